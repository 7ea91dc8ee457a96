#!/usr/bin/python3
"""A metric of your own, Kerr-Newman in Boyer-Lindquist coordinates, checked for its constants of the motion.

Usage: constants_of_motion.py [FIGURE.png]
"""
import pathlib
import sys

import matplotlib
matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import kagero

SPIN, CHARGE = 0.8, 0.4  # in units of the mass M = 1

scene = kagero.scene({"space": {
    "hamiltonian": "formula",
    # H = (g^rr p_r^2 + g^tt.. )/2, the inverse metric of Kerr-Newman as printed in textbooks
    "H": "(D*pr^2 + ptheta^2 + (a*sin(theta)*pt + pphi/sin(theta))^2 - ((r^2 + a^2)*pt + a*pphi)^2/D) / (2*S)",
    "H0": 0, "capture": "r - 1.01*(1 + sqrt(1 - a^2 - e^2))", "length_scale": "0.3*(r - 0.9)",
    "constants": {"a": SPIN, "e": CHARGE, "pt": 1},
    "let": {"D": "r^2 - 2*r + a^2 + e^2", "S": "r^2 + a^2*cos(theta)^2"}},
    "integrator": {"escape_radius": 60}})

height = np.linspace(-7, 7, 12)
position = np.column_stack([np.full_like(height, -25), height, 0.4 * height + 1.5])
direction = [1, 0, 0.02]


def drift(paths):
    """Returns the greatest relative changes of H, L_z and Carter's constant along the rays that escape."""
    x, y, z, px, py, pz, pt = (paths[name] for name in ("x", "y", "z", "px", "py", "pz", "pt"))
    r, rho = np.sqrt(x**2 + y**2 + z**2), np.hypot(x, y)
    momentum = x * py - y * px
    p_theta = z / rho * (x * px + y * py) - rho * pz
    carter = p_theta**2 + (z / r)**2 * ((momentum * r / rho)**2 - (SPIN * pt)**2)
    kinetic = px**2 + py**2 + pz**2
    changes = {"H": np.abs(paths["energy"]) / kinetic}
    first = np.searchsorted(paths["ray"], paths["ray"])  # index of the start of each point's ray
    for name, constant in (("$L_z$", momentum), ("Carter's constant", carter)):
        changes[name] = np.abs(constant - constant[first]) / (np.abs(constant[first]) + 1)
    return changes


figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4.5), layout="constrained")
tolerances = [1e-4, 1e-6, 1e-8, 1e-10, 1e-12]
worst = {}
for tolerance in tolerances:
    paths = scene.override({"integrator.method": "dp85", "integrator.tolerance": tolerance}).path(position, direction)
    for name, change in drift(paths).items():
        worst.setdefault(name, []).append(change.max())
for i in range(len(height)):
    ray = paths["ray"] == i
    left.plot(paths["x"][ray], paths["y"][ray], lw=1)
left.add_patch(plt.Circle((0, 0), 1 + np.sqrt(1 - SPIN**2 - CHARGE**2), color="black", zorder=3))
left.set(xlim=(-16, 16), ylim=(-12, 12), aspect="equal", xlabel="x / M", ylabel="y / M",
         title="Rays near a Kerr-Newman black hole, seen from above")
for (name, changes), marker in zip(worst.items(), "osd"):
    right.loglog(tolerances, changes, marker=marker, label=name)
right.invert_xaxis()
right.set(xlabel="integrator.tolerance", ylabel="greatest relative change",
          title="Constants of the motion")
right.legend()
print("greatest change at the smallest tolerance:", ", ".join(f"{name} {c[-1]:.1e}" for name, c in worst.items()))
assert all(changes[-1] < 1e-8 for changes in worst.values())
figure.savefig(sys.argv[1] if sys.argv[1:] else pathlib.Path(__file__).parent / "figures/constants_of_motion.png",
               dpi=110)
