#!/usr/bin/python3
"""Deflection of light by a black hole, compared with the elliptic integral of Darwin (1959).

Usage: deflection.py [FIGURE.png]
"""
import pathlib
import sys

import matplotlib
matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from scipy.special import ellipk, ellipkinc

import kagero

RG = 1.0                          # Schwarzschild radius, the unit of length; M = RG/2
FAR = 1e6                         # distance at which the rays start and end
CRITICAL = 1.5 * np.sqrt(3) * RG  # rays with a smaller impact parameter fall into the hole


def deflection_and_impact(closest):
    """Returns the deflection angle and the impact parameter of the ray with this closest approach, in closed form."""
    m = RG / 2
    q = np.sqrt((closest - 2 * m) * (closest + 6 * m))
    modulus = (q - closest + 6 * m) / (2 * q)
    amplitude = np.arcsin(np.sqrt((q - closest + 2 * m) / (q - closest + 6 * m)))
    angle = 4 * np.sqrt(closest / q) * (ellipk(modulus) - ellipkinc(amplitude, modulus)) - np.pi
    return angle, closest * np.sqrt(closest / (closest - 2 * m))


scene = kagero.scene({"space": {"hamiltonian": "schwarzschild", "rg": RG},
                      "integrator": {"tolerance": 1e-13, "escape_radius": FAR}})
closest = RG * (1.5 + np.geomspace(1e-3, 40, 60))
expected, impact = deflection_and_impact(closest)
position = np.column_stack([np.full_like(impact, -FAR), impact, np.zeros_like(impact)])
ends = scene.trace(position, [1, 0, 0])
angle = -np.arctan2(ends["dy"], ends["dx"])
found = angle + 2 * np.pi * np.round((expected - angle) / (2 * np.pi))  # rays can go round the hole several times
error = np.abs(found - expected)
print(f"{len(impact)} rays; greatest difference to the elliptic integral: {error.max():.1e} rad")
assert error.max() < 1e-6 and error[impact > 2.7].max() < 1e-10

figure = plt.figure(figsize=(10, 4.6), layout="constrained")
grid = figure.add_gridspec(2, 2, width_ratios=[1.15, 1], height_ratios=[2, 1])
rays = figure.add_subplot(grid[:, 0])
heights = CRITICAL * np.concatenate([[0.3, 0.7, 0.95], 1 + np.geomspace(4e-3, 1.6, 9)])
starts = np.column_stack([np.full_like(heights, -14), heights, np.zeros_like(heights)])
paths = scene.override({"integrator.escape_radius": 30}).path(starts, [1, 0, 0], every=0.02)
for i, height in enumerate(heights):
    ray = paths["ray"] == i
    rays.plot(paths["x"][ray], paths["y"][ray], lw=1.2, color="C3" if height < CRITICAL else "C0")
rays.add_patch(plt.Circle((0, 0), RG, color="black", zorder=3))
rays.add_patch(plt.Circle((0, 0), 1.5 * RG, fill=False, ls="--", lw=0.8, zorder=3))
rays.set(xlim=(-9, 9), ylim=(-8, 8), aspect="equal", xlabel="x / $r_g$", ylabel="y / $r_g$",
         title="Rays; the dashed circle is the photon sphere")
above = figure.add_subplot(grid[0, 1])
above.loglog(impact / CRITICAL - 1, expected, color="0.6", lw=3, label="elliptic integral")
above.loglog(impact / CRITICAL - 1, found, "k.", ms=4, label="kagero")
above.axhline(2 * np.pi, color="C1", lw=0.8)
above.text(0.9, 7, "one turn", color="C1", fontsize=9)
above.set(ylabel="deflection / rad", title="Deflection")
above.tick_params(labelbottom=False)
above.legend()
below = figure.add_subplot(grid[1, 1], sharex=above)
below.loglog(impact / CRITICAL - 1, np.maximum(error, 1e-16), "k.", ms=4)
below.set(xlabel="$b/b_c - 1$", ylabel="difference / rad")
figure.savefig(sys.argv[1] if sys.argv[1:] else pathlib.Path(__file__).parent / "figures/deflection.png", dpi=110)
