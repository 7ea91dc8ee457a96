#!/usr/bin/python3
"""Spot diagram of a rod whose index falls with the square of the radius (GRIN), compared with the closed form.

Usage: grin_rod.py [FIGURE.png]
"""
import pathlib
import sys

import matplotlib
matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import kagero

N0, ALPHA = 1.6, 0.25         # N^2 = N0^2 (1 - ALPHA^2 (x^2 + y^2)); lengths in mm
SOURCE = np.array([0.4, 0.0])  # position of a point source on the entrance face z = 0
HALF_PITCH = np.pi / ALPHA

# The source emits a cone of rays, on a grid in polar coordinates.
radius, angle = (grid.ravel() for grid in np.meshgrid(np.linspace(0, 0.3, 13)[1:], np.linspace(0, 2 * np.pi, 37)[:-1]))
direction = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), np.sqrt(1 - radius**2)])
position = np.tile([*SOURCE, 0.0], (len(radius), 1))

# In the parameter of H, rays are harmonic oscillators with frequency N0 ALPHA, and move evenly along z.
index = N0 * np.sqrt(1 - ALPHA**2 * (SOURCE @ SOURCE))
momentum = index * direction


def closed_form(z):
    phase = N0 * ALPHA * z / momentum[:, 2]
    return SOURCE * np.cos(phase)[:, None] + momentum[:, :2] / (N0 * ALPHA) * np.sin(phase)[:, None]


def spots(z):
    """Returns the points at which the rays hit a screen at this distance from the entrance face."""
    scene = kagero.scene({
        "space": {"hamiltonian": "fiber", "n0": N0, "alpha": ALPHA},
        "integrator": {"tolerance": 1e-12, "escape_radius": 100},
        "object": [{"name": "screen", "shape": "rectangle", "origin": [-3, -3, z], "edge_u": [6, 0, 0],
                    "edge_v": [0, 6, 0]}]})
    ends = scene.trace(position, direction)
    assert (ends["status"] == kagero.Status.hit).all()
    return np.column_stack([ends["x"], ends["y"]])


figure, axes = plt.subplots(1, 4, figsize=(12.5, 3.6), layout="constrained", width_ratios=[1.7, 1, 1, 1])
in_plane = np.flatnonzero(np.isclose(np.abs(np.cos(angle)), 1))  # these rays stay in the plane y = 0
rod = kagero.scene({"space": {"hamiltonian": "fiber", "n0": N0, "alpha": ALPHA}, "integrator": {"escape_radius": 14}})
paths = rod.path(position[in_plane], direction[in_plane], every=0.05)
for i in range(len(in_plane)):
    ray = paths["ray"] == i
    axes[0].plot(paths["z"][ray], paths["x"][ray], lw=0.8, color="0.5")
axes[0].set(xlabel="z / mm", ylabel="x / mm", title="Rays in the plane y = 0")
greatest = 0.0
for i, share in enumerate((0.96, 0.98, 1.0)):
    found, expected = spots(share * HALF_PITCH), closed_form(share * HALF_PITCH)
    greatest = max(greatest, np.abs(found - expected).max())
    axes[0].axvline(share * HALF_PITCH, color=f"C{i + 1}", lw=1.2)
    axes[i + 1].scatter(1000 * (found[:, 0] + SOURCE[0]), 1000 * found[:, 1], c=radius, s=7, cmap="viridis")
    axes[i + 1].set(aspect="equal", xlabel="(x + 0.4 mm) / µm", title=f"z = {share:.2f} half pitches")
    axes[i + 1].title.set_color(f"C{i + 1}")
axes[1].set_ylabel("y / µm")
print(f"greatest distance of a spot from the closed form: {greatest:.1e} mm")
assert greatest < 1e-9
figure.savefig(sys.argv[1] if sys.argv[1:] else pathlib.Path(__file__).parent / "figures/grin_rod.png", dpi=110)
