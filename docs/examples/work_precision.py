#!/usr/bin/python3
"""Error against run time for several integration methods: work-precision.

Usage: work_precision.py [FIGURE.png]
"""
import pathlib
import sys

import matplotlib
matplotlib.use("Agg")
import matplotlib.pyplot as plt

import kagero

scene = kagero.scene({"space": {"hamiltonian": "schwarzschild", "rg": 2}, "integrator": {"escape_radius": 40},
                      "camera": {"position": [-20, 0, 2], "look_at": [0, 0, 0], "up": [0, 0, 1]},
                      "film": {"size": [256, 256]}})
study = scene.error(sample=(8, 8), quick=True)
figure, axes = plt.subplots(figsize=(9, 5), layout="constrained")
for curve in study["curves"]:
    name = f"{curve['method']}, {curve['precision']}" + (", rescaled time" if curve["rescaled"] else "")
    points = [(point["ns_per_ray"]["median"] / 1000, point["pixels"]["p99"]) for point in curve["points"]]
    points = [(time, error) for time, error in points if error is not None and 0 < error < 100]
    if curve["strategy"] == "packet" and not curve["loose"] and len(points) > 1:
        style = "-" if curve["precision"] == "double" else ":"
        axes.loglog(*zip(*sorted(points)), style, marker="o", ms=3, label=name)
axes.axhline(0.05, color="0.7", lw=1)
axes.set(xlabel="time per ray / µs", ylabel="error, 99th percentile / pixel", title="Camera rays near a black hole")
axes.legend(fontsize=8, bbox_to_anchor=(1.01, 1), loc="upper left")
print(f"{len(study['curves'])} curves; the cheapest: {study['cheapest'][0]}")
figure.savefig(sys.argv[1] if sys.argv[1:] else pathlib.Path(__file__).parent / "figures/work_precision.png", dpi=110)
