#!/usr/bin/python3
"""The shadow of a rotating black hole, compared with the closed form of its edge (Bardeen 1973).

Usage: shadow.py [FIGURE.png]
"""
import pathlib
import sys

import matplotlib
matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import kagero

DISTANCE = 1000.0  # of the observer, who is in the equatorial plane, in units of M
SPINS = [0.0, 0.5, 0.9, 0.998]


def edge_in_closed_form(spin, count=400):
    """Returns the points (alpha, beta) of the upper half of the shadow's edge for a distant observer at the equator."""
    if spin == 0:
        angle = np.linspace(0, np.pi, count)
        return np.sqrt(27) * np.cos(angle), np.sqrt(27) * np.sin(angle)
    prograde, retrograde = (2 * (1 + np.cos(2 / 3 * np.arccos(sign * spin))) for sign in (-1, 1))
    r = prograde + (retrograde - prograde) * (1 - np.cos(np.linspace(0, np.pi, count))) / 2
    xi = (r**2 * (3 - r) - spin**2 * (r + 1)) / (spin * (r - 1))
    eta = r**3 * (4 * spin**2 - r * (r - 3)**2) / (spin**2 * (r - 1)**2)
    return -xi, np.sqrt(np.maximum(eta, 0))


def constants_of_motion(ends, spin):
    """Returns alpha = -L_z/E and beta = sqrt(Q)/E of rays from their ends in Kerr-Schild coordinates."""
    x, y, z = (ends[name] for name in "xyz")
    px, py, pz = (ends[name] / ends["pt"] for name in ("px", "py", "pz"))
    square = x**2 + y**2 + z**2 - spin**2
    r = np.sqrt(square / 2 + np.sqrt(square**2 / 4 + (spin * z)**2))
    cosine = z / r
    sine = np.sqrt(1 - cosine**2)
    momentum = x * py - y * px
    p_theta = cosine / sine * (x * px + y * py) - r * sine * pz
    carter = p_theta**2 + cosine**2 * ((momentum / sine)**2 - spin**2)
    return momentum, np.sqrt(np.maximum(carter, 0))


def traced_edge(spin, count=25):
    """Returns points (alpha, beta) of the edge: a bisection between rays that are captured and rays that escape."""
    scene = kagero.scene({"space": {"hamiltonian": "kerr", "spin": spin},
                          "integrator": {"tolerance": 1e-12, "escape_radius": 2 * DISTANCE}})
    angle = np.linspace(0.02, np.pi - 0.02, count)
    inside, outside = np.zeros(count), np.full(count, 9 / DISTANCE)
    # The bisection begins near the middle of the shadow, so that it is inside for every spin.
    middle = 2 * spin / DISTANCE
    edge = None
    for _ in range(34):
        radius = (inside + outside) / 2
        direction = np.column_stack([np.ones(count), -middle - radius * np.cos(angle), radius * np.sin(angle)])
        ends = scene.trace([-DISTANCE, 0, 0], direction, observer="static",
                           columns=["status", "x", "y", "z", "px", "py", "pz", "pt"])
        captured = ends["status"] == kagero.Status.captured
        inside, outside = np.where(captured, radius, inside), np.where(captured, outside, radius)
        alpha, beta = constants_of_motion(ends, spin)
        edge = (alpha, beta) if edge is None else tuple(np.where(captured, old, new)
                                                        for old, new in zip(edge, (alpha, beta)))
    return edge


figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4.6), layout="constrained")
sizes, greatest = [], 0.0
for i, spin in enumerate(SPINS):
    alpha, beta = traced_edge(spin)
    curve = edge_in_closed_form(spin)
    fine = edge_in_closed_form(spin, 200001)
    # The distance of a traced point from the curve, which is at its closest point up to the square of its spacing.
    distance = np.array([np.hypot(fine[0] - a, fine[1] - b).min() for a, b in zip(alpha, beta)])
    greatest = max(greatest, distance.max())
    for sign in (1, -1):
        left.plot(curve[0], sign * curve[1], color=f"C{i}", lw=1.2, label=f"spin {spin}" if sign == 1 else None)
        left.plot(alpha, sign * beta, ".", color=f"C{i}", ms=5)
    sizes.append((alpha.max() - alpha.min(), 2 * beta.max()))
print(f"greatest distance of a traced edge from the closed form: {greatest:.1e} M")
assert greatest < 1e-4
left.set(aspect="equal", xlabel=r"$\alpha$ / M", ylabel=r"$\beta$ / M",
         title="Edge of the shadow: closed form (lines), traced (points)")
left.legend(loc="center")
spins = np.linspace(0, 0.999, 60)
forms = [edge_in_closed_form(spin) for spin in spins]
right.plot(spins, [alpha.max() - alpha.min() for alpha, beta in forms], color="C0", label="width")
right.plot(spins, [2 * beta.max() for alpha, beta in forms], color="C1", label="height")
for k in range(2):
    right.plot(SPINS, [size[k] for size in sizes], "o", color=f"C{k}", ms=5)
right.set(xlabel="spin a/M", ylabel="size / M", title="Size of the shadow for an observer at the equator")
right.legend()
figure.savefig(sys.argv[1] if sys.argv[1:] else pathlib.Path(__file__).parent / "figures/shadow.png", dpi=110)
