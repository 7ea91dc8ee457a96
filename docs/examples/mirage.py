#!/usr/bin/python3
"""A tower over hot ground: its mirage, and the rays that cause it.

Usage: mirage.py [FIGURE.png]
"""
import pathlib
import sys

import matplotlib
matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import kagero

EYE, TOWER, HEIGHT, GROUND = 1.6, 900.0, 14.0, 0.0  # metres: eye level, distance, height of the tower, ground
BANDS = [([0.75, 0.1, 0.08], 0, 3.5), ([0.93, 0.9, 0.82], 3.5, 7), ([0.75, 0.1, 0.08], 7, 10.5),
         ([0.93, 0.9, 0.82], 10.5, 14)]

# The air is hottest at the ground, where its index is lower by 50 parts in a million; this decays within a metre.
index = "1.0003 - 5e-5*exp(-max(z, -1)/0.6)"
tables = {
    "space": {"hamiltonian": "formula", "H": "0.5*(px^2 + py^2 + pz^2 - n^2)", "H0": 0, "let": {"n": index}},
    "integrator": {"method": "dp85", "tolerance": 1e-11, "escape_radius": 4000},
    "camera": {"position": [0, 0, EYE], "look_at": [1000, 0, EYE + 1], "up": [0, 0, 1], "fov": 1.9},
    "film": {"size": [360, 360]}, "sky": {"color": [0.62, 0.76, 0.9]},
    "object": [{"name": "ground", "shape": "rectangle", "origin": [-10, -400, GROUND], "edge_u": [1500, 0, 0],
                "edge_v": [0, 800, 0], "color": [0.62, 0.5, 0.33]}]}
for i, (color, bottom, top) in enumerate(BANDS):
    half = 1.9 - 0.25 * i
    tables["object"].append({"name": f"tower-{i}", "shape": "box", "min": [TOWER, -half, bottom],
                             "max": [TOWER + 2 * half, half, top], "color": color})
scene = kagero.scene(tables)

figure, (left, middle, right) = plt.subplots(1, 3, figsize=(12, 4.4), layout="constrained", width_ratios=[1, 1, 1.25])
straight = scene.override({"space.let.n": "1.0003"})
for axes, each, title in ((left, straight, "without hot air"), (middle, scene, "with hot air at the ground")):
    color = each.render()["color"]
    axes.imshow(np.clip(color, 0, 1)**(1 / 2.2), interpolation="nearest")
    axes.set(title=title, xticks=[], yticks=[])
slopes = np.linspace(-8.2e-3, 1.3e-2, 27)
paths = scene.path([0, 0, EYE], np.column_stack([np.ones_like(slopes), np.zeros_like(slopes), slopes]), every=10.0)
ends = scene.trace([0, 0, EYE], np.column_stack([np.ones_like(slopes), np.zeros_like(slopes), slopes]))
inverted = 0
for i, slope in enumerate(slopes):
    ray = paths["ray"] == i
    hits_tower = ends["object"][i].startswith("tower")
    mirrored = hits_tower and slope < 0
    inverted += mirrored
    right.plot(paths["x"][ray], paths["z"][ray], lw=1, color="C3" if mirrored else "C0" if hits_tower else "0.7")
for color, bottom, top in BANDS:
    right.add_patch(plt.Rectangle((TOWER, bottom), 12, top - bottom, facecolor=color, edgecolor="black", lw=0.5))
right.set(xlim=(0, TOWER + 20), ylim=(-0.5, 15), xlabel="distance / m", ylabel="height / m",
          title="rays from the eye; red: those that start downward")
print(f"{inverted} of {len(slopes)} rays start downward and reach the tower")
assert inverted > 0
figure.savefig(sys.argv[1] if sys.argv[1:] else pathlib.Path(__file__).parent / "figures/mirage.png", dpi=110)
