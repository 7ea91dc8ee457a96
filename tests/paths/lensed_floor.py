#!/usr/bin/python3
"""Light of a Lambertian floor that a small sphere lights around a black hole, by Monte Carlo integration with NumPy.

    tests/paths/lensed_floor.py [--paths N] [--seed S] [--add FILE]     computes N paths, and adds them to FILE
    tests/paths/lensed_floor.py --check FILE [--paths N] [--seed S]     compares N paths with the result in FILE

The script shares no code and no equations with kagero. kagero integrates Hamilton's equations in Kerr-Schild
coordinates; this script integrates the orbit equation u'' = -u + 3/2 r_g u^2 of null rays in the plane of each ray,
with u = 1/r (Chandrasekhar 1983, section 20). Space coordinates (r and the angles) are the same in both.

A path starts at a point of the floor, in a direction that is distributed as cos(theta)/pi in the rest frame of
the static observer there. It adds the albedo times the light of the lamp if it meets the lamp before the floor
and the hole.
"""
import argparse
import json
import pathlib
import sys

try:
    import numpy as np
except ImportError:
    print("NumPy is not installed")
    sys.exit(77)  # CTest counts the test as skipped

RADIUS_OF_HOLE = 0.12                      # r_g; the hole is at the origin
FLOOR_HEIGHT = -1.0                        # the floor is the plane z = -1
ALBEDO = 0.6
LAMP_CENTER, LAMP_RADIUS = np.array([0.15, 0.1, 0.9]), 0.2
LAMP_LIGHT = 10.0
POINTS = [0.1, 0.6, 1.2]                   # points (x, 0, -1) of the floor
COMMAND = "for seed in 1 2 6 7; do tests/paths/lensed_floor.py --paths 10000000 --seed $seed " \
          "--add tests/paths/lensed_floor.json; done"


def cosine_directions(rng, count, normal):
    """Returns unit vectors around a normal with the density cos(theta)/pi."""
    square, angle = rng.random(count), 2 * np.pi * rng.random(count)
    first = np.cross(normal, [0.0, 1.0, 0.0])
    first /= np.linalg.norm(first)
    second = np.cross(normal, first)
    sine = np.sqrt(square)
    return (np.sqrt(1 - square)[:, None] * normal + (sine * np.cos(angle))[:, None] * first
            + (sine * np.sin(angle))[:, None] * second)


def start_orbits(rng, count, point):
    """Returns the state of rays whose planes meet the lamp: u, du/dphi, the lamp in the plane, its squared radius
    there, and the components of z along the axes of the plane."""
    r = np.linalg.norm(point)
    radial = point / r
    root = np.sqrt(1 - RADIUS_OF_HOLE / r)
    # The components of the gradient of z in the rest frame: the radial one is smaller by sqrt(1 - r_g/r).
    normal = np.array([0, 0, 1.0])
    normal = normal + (root - 1) * normal.dot(radial) * radial
    directions = cosine_directions(rng, count, normal / np.linalg.norm(normal))
    cosine = directions @ radial
    tangential = directions - cosine[:, None] * radial
    sine = np.linalg.norm(tangential, axis=1)
    tangential /= sine[:, None]
    u = np.full(count, 1 / r)
    slope = -u * root * cosine / sine
    lamp_x, lamp_y = np.full(count, LAMP_CENTER.dot(radial)), tangential @ LAMP_CENTER
    square = LAMP_RADIUS ** 2 - (LAMP_CENTER.dot(LAMP_CENTER) - lamp_x ** 2 - lamp_y ** 2)
    meets = square > 0
    return [a[meets] for a in (u, slope, lamp_x, lamp_y, square, np.full(count, radial[2]), tangential[:, 2])]


def acceleration(u):
    return u * (1.5 * RADIUS_OF_HOLE * u - 1)


def step(u, w, h):
    """One step of the classical Runge-Kutta method for u'' = acceleration(u)."""
    k1, l1 = w, acceleration(u)
    k2, l2 = w + 0.5 * h * l1, acceleration(u + 0.5 * h * k1)
    k3, l3 = w + 0.5 * h * l2, acceleration(u + 0.5 * h * k2)
    k4, l4 = w + h * l3, acceleration(u + h * k3)
    return u + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4), w + h / 6 * (l1 + 2 * l2 + 2 * l3 + l4)


def count_hits(rng, count, point):
    """Returns the number of rays, of `count`, that meet the lamp."""
    u, w, lamp_x, lamp_y, square, z_x, z_y = start_orbits(rng, count, point)
    phi = np.zeros_like(u)
    x, y = 1 / u, np.zeros_like(u)
    far = np.linalg.norm(LAMP_CENTER) + 1.01 * LAMP_RADIUS
    hits = 0
    while u.size:
        h = np.minimum(0.02, 0.03 * u / np.abs(w))
        u, w = step(u, w, h)
        phi += h
        new_x, new_y = np.cos(phi) / u, np.sin(phi) / u
        edge_x, edge_y = new_x - x, new_y - y
        share = np.clip(((lamp_x - x) * edge_x + (lamp_y - y) * edge_y) / (edge_x ** 2 + edge_y ** 2), 0, 1)
        hit = (x + share * edge_x - lamp_x) ** 2 + (y + share * edge_y - lamp_y) ** 2 < square
        x, y = new_x, new_y
        hits += int(np.count_nonzero(hit))
        on_floor = x * z_x + y * z_y < FLOOR_HEIGHT - 1e-12
        captured = (w > 0) & (u > 1 / (1.5 * RADIUS_OF_HOLE))
        escaped = (w < 0) & (u < 1 / far)
        keep = ~(hit | on_floor | captured | escaped)
        u, w, phi, x, y, lamp_x, lamp_y, square, z_x, z_y = (
            a[keep] for a in (u, w, phi, x, y, lamp_x, lamp_y, square, z_x, z_y))
    return hits


def run(paths, seed):
    """Returns the number of hits for each point."""
    chunk = 1 << 18
    all_hits = []
    for index, x in enumerate(POINTS):
        rng = np.random.default_rng([seed, index])
        point, hits, done = np.array([x, 0, FLOOR_HEIGHT]), 0, 0
        while done < paths:
            count = min(chunk, paths - done)
            hits += count_hits(rng, count, point)
            done += count
        all_hits.append(hits)
    return all_hits


def light_of(hits, paths):
    """Returns the light and its standard error."""
    share = hits / paths
    return ALBEDO * LAMP_LIGHT * share, ALBEDO * LAMP_LIGHT * (share * (1 - share) / paths) ** 0.5


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--paths", type=int, default=1_000_000, help="number of paths for each point")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--add", type=pathlib.Path, help="file of results to which the paths are added")
    parser.add_argument("--check", type=pathlib.Path, help="file of results with which the paths are compared")
    arguments = parser.parse_args()
    stored = {}
    file = arguments.check or arguments.add
    if file and file.exists():
        stored = json.loads(file.read_text())
    hits = run(arguments.paths, arguments.seed)
    failures = 0
    for index, x in enumerate(POINTS):
        light, error = light_of(hits[index], arguments.paths)
        print(f"x = {x}: light {light:.6f} +- {error:.6f}")
        if arguments.check:
            known = stored["points"][index]
            if abs(light - known["light"]) > 4 * (error ** 2 + known["error"] ** 2) ** 0.5:
                print(f"  the stored light is {known['light']:.6f} +- {known['error']:.6f}")
                failures += 1
    if arguments.add:
        if arguments.seed in stored.get("seeds", []):
            sys.exit(f"the paths of seed {arguments.seed} are already in {file}; choose another seed")
        paths = stored.get("paths", 0) + arguments.paths
        earlier = [p["hits"] for p in stored["points"]] if stored else [0] * len(POINTS)
        points = []
        for x, old, new in zip(POINTS, earlier, hits):
            light, error = light_of(old + new, paths)
            points.append({"x": x, "hits": old + new, "light": light, "error": error})
        file.write_text(json.dumps({"command": COMMAND, "paths": paths,
                                    "seeds": stored.get("seeds", []) + [arguments.seed], "points": points},
                                   indent=1) + "\n")
    sys.exit(1 if failures else 0)


if __name__ == "__main__":
    main()
