"""Ray lists, and the cheapest way to a bound on their directions."""
import csv
import io
import itertools
import math
import random

from .program import SCENES

OUTWARD, ACROSS = (2 / 3, -1 / 3, 2 / 3), (2 / 3, 2 / 3, -1 / 3)
START = 20


def inward(b):
    """A ray at r = 20 r_g of impact parameter b: dr/dlambda = -sqrt(1 - (1 - 1/r) b^2/r^2), r dphi/dlambda = b/r."""
    along, aside = -math.sqrt(1 - (1 - 1 / START) * b * b / START**2), b / START
    return [START * o for o in OUTWARD] + [along * o + aside * a for o, a in zip(OUTWARD, ACROSS)]


def write_rays(path, rays):
    lines = ["x,y,z,dx,dy,dz"] + [",".join(repr(v) for v in ray) for ray in rays]
    path.write_text("\n".join(lines) + "\n")
    return path


def peers(path, least=3.0, width=7.0, count=2048):
    return write_rays(path, [inward(least + width * (k + 0.5) / count) for k in range(count)])


def room_rays(path, shuffled, side=192):
    """Directions through a square window, from the room's camera; in rows of a picture or in no order."""
    eye, right, up = (0.22, -0.92, 0.16), (0.97, 0.23, 0.0), (0.0, 0.0, 1.0)
    forward = [-c for c in eye]
    rays = []
    for y in range(side):
        for x in range(side):
            u, v = 2 * (x + 0.5) / side - 1, 1 - 2 * (y + 0.5) / side
            rays.append(list(eye) + [forward[k] + u * right[k] + v * up[k] for k in range(3)])
    if shuffled:
        random.Random(7).shuffle(rays)
    return write_rays(path, rays)


def directions(program, scene, rays, *arguments):
    rows = csv.DictReader(io.StringIO(program.text("trace", scene, "--rays", rays, "--threads", 1, *arguments)))
    return [(row["status"], [float(row[k]) for k in ("dx", "dy", "dz")]) for row in rows]


def worst_angle(ends, should):
    if any(a[0] != b[0] for a, b in zip(ends, should)):
        return math.inf
    return max(2 * math.asin(min(1.0, 0.5 * math.dist(a[1], b[1]))) for a, b in zip(ends, should))


# The longest steps first.
TOLERANCES = tuple(m * 10.0**-k for k in range(5, 14) for m in (1, 0.5, 0.2))
METHODS = {"dp5": (0.3, 0.29, 0.28, 0.27, 0.25, 0.2, 0.15, 0.1, 0.07, 0.05), "dp8": (1, 0.8, 0.6, 0.5, 0.45, 0.4, 0.35, 0.3, 0.25, 0.2, 0.15, 0.12, 0.1),
           "verner9": (1, 0.8, 0.6, 0.5, 0.45, 0.4, 0.35, 0.3, 0.25, 0.22, 0.2, 0.19, 0.18, 0.17, 0.15, 0.12), "dp85": TOLERANCES, "rkf78": TOLERANCES,
           "gauss4": (0.4, 0.2, 0.1), "gauss6": (0.9, 0.6, 0.4, 0.25), "gauss8": (1.2, 0.9, 0.7, 0.55, 0.45, 0.38, 0.3),
           "gauss12": (1.2, 0.9, 0.6, 0.45, 0.35, 0.3, 0.25, 0.2, 0.15), "gauss16": (1.2, 0.9, 0.7, 0.5, 0.4, 0.3, 0.2)}

ADAPTIVE = ("rkf78", "dp85")  # whose numbers are tolerances

ORBITS = {"orbit-srkn6": (0.8, 0.6, 0.4, 0.3, 0.2), "orbit-srkn11": (1.2, 1, 0.8, 0.6, 0.5, 0.4, 0.3, 0.25, 0.2, 0.15),
          "orbit-srkn14": (1, 0.8, 0.6, 0.4, 0.3, 0.25, 0.2)}


def cheapest(program, rays, bounds, solved, methods=METHODS, precisions=("double",)):
    """For each bound on the greatest error of direction: (ns per ray, error, precision, method and step, arguments for them), the quickest; and
    how well the reference, gauss16 at two short steps, agrees with itself. Implicit equations are solved to `solved` of the bound: what a ray multiplies its
    errors by. The least time decides, as the one that nothing disturbed; those that come near the least are timed again, in turn."""
    scene = SCENES / "hole.toml"
    should = directions(program, scene, rays, "--integrator", "gauss16", "--step", 0.1)
    doubt = worst_angle(directions(program, scene, rays, "--integrator", "gauss16", "--step", 0.15), should)
    if not doubt <= 0.1 * min(bounds):
        raise RuntimeError(f"the reference agrees with itself to {doubt:.0e} alone: too little to judge errors of {min(bounds):.0e}")
    def time_of(how):
        return program.json("trace", scene, "--rays", rays, "--threads", 1, "--repeat", 9 if program.quick else 25, *how)["ns_per_ray"]
    def least(way):
        return way[0]["min"]
    found = []
    for bound in bounds:
        ways = []
        for precision, (method, steps) in itertools.product(precisions, methods.items()):
            for step in steps:
                length = ["-D", f"integrator.tolerance={step:g}"] if method in ADAPTIVE else ["--step", step]
                how = ["--precision", precision, "--integrator", method, *length, "-D", f"integrator.solver_tolerance={solved * bound:g}"]
                error = worst_angle(directions(program, scene, rays, *how), should)
                if error > bound:
                    continue
                ways.append((time_of(how), error, f"{precision}, {method}, {'tolerance' if method in ADAPTIVE else 'step'} {step:g}", how))
                break  # shorter steps of the same method only cost more
        for _ in range(1 if program.quick else 4):
            ways = [min(way, (time_of(way[3]), *way[1:]), key=least) for way in ways if least(way) <= 1.3 * min(map(least, ways))]
        found.append(min(ways, key=least, default=None))
    return found, doubt


def cheapest_of_odeint(program, rays, bounds):
    """The same of Boost.Odeint's steppers: the benchmark of each bound, None where none comes so near."""
    def run(*options):
        return program.benchmark("bench_peers", f"--rays={rays}", *options)
    rows = run("--benchmark_min_time=0.01")
    found = []
    for bound in bounds:
        near = [row for row in rows if row["error"] <= bound]
        if near and not program.quick:
            least = min(row["s/ray"] for row in near)
            contenders = "|".join(row["name"] for row in near if row["s/ray"] <= 1.3 * least)
            again = run(f"--benchmark_filter=^({contenders})$", "--benchmark_min_time=0.02", "--benchmark_repetitions=5")
            near = [row for row in again if row["run_type"] == "iteration"]
        found.append(min(near, key=lambda row: row["s/ray"], default=None))
    return found
