"""Lists of rays, and the search for the cheapest method whose end directions meet an error bound."""
import csv
import io
import itertools
import math
import random

from .program import SCENES

OUTWARD, ACROSS = (2 / 3, -1 / 3, 2 / 3), (2 / 3, 2 / 3, -1 / 3)  # unit vectors that span the orbit plane
START_RADIUS = 20  # radius of the ray starts, in r_g


def inward(b):
    """Returns position and direction of a ray at r = 20 r_g with impact parameter b (in r_g):
    dr/dlambda = -sqrt(1 - (1 - 1/r) b^2/r^2), r dphi/dlambda = b/r."""
    radial, tangential = -math.sqrt(1 - (1 - 1 / START_RADIUS) * b * b / START_RADIUS**2), b / START_RADIUS
    return [START_RADIUS * o for o in OUTWARD] + [radial * o + tangential * a for o, a in zip(OUTWARD, ACROSS)]


def write_rays(path, rays):
    """Writes the rays as CSV for `kagero trace`, and returns the path."""
    lines = ["x,y,z,dx,dy,dz"] + [",".join(repr(v) for v in ray) for ray in rays]
    path.write_text("\n".join(lines) + "\n")
    return path


def inward_rays(path, least=3.0, width=7.0, count=2048):
    """Writes inward rays with impact parameters from `least` to `least` + `width`, in r_g. Returns the path."""
    return write_rays(path, [inward(least + width * (k + 0.5) / count) for k in range(count)])


def room_rays(path, shuffled, side=192):
    """Writes side² rays from the room's camera through a square window, row by row or shuffled (seed 7)."""
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


def camera_rays(path, side=192):
    """Writes side² rays from 30 lengths in front of the origin through a square window of 38 degrees, row by row."""
    slope = math.tan(math.radians(19))
    points = [(2 * k + 1) / side - 1 for k in range(side)]
    return write_rays(path, [[0, -30, 4.5, slope * x, 1, -0.163 - slope * y] for y in points for x in points])


def directions(program, scene, rays, *arguments):
    """Returns (status, unit direction at the end) of each ray."""
    rows = csv.DictReader(io.StringIO(program.text("trace", scene, "--rays", rays, "--threads", 1, *arguments)))
    return [(row["status"], [float(row[k]) for k in ("dx", "dy", "dz")]) for row in rows]


def worst_angle(ends, reference):
    """Returns the greatest angle between directions, in radians; infinity if a status differs."""
    if any(a[0] != b[0] for a, b in zip(ends, reference)):
        return math.inf
    return max(2 * math.asin(min(1.0, 0.5 * math.dist(a[1], b[1]))) for a, b in zip(ends, reference))


# The steps or tolerances of each method, the coarsest first.
TOLERANCES = tuple(m * 10.0**-k for k in range(5, 14) for m in (1, 0.5, 0.2))
METHODS = {
    "dp5": (0.3, 0.29, 0.28, 0.27, 0.25, 0.2, 0.15, 0.1, 0.07, 0.05),
    "dp8": (1, 0.8, 0.6, 0.5, 0.45, 0.4, 0.35, 0.3, 0.25, 0.2, 0.15, 0.12, 0.1),
    "verner9": (1, 0.8, 0.6, 0.5, 0.45, 0.4, 0.35, 0.3, 0.25, 0.22, 0.2, 0.19, 0.18, 0.17, 0.15, 0.12),
    "dp85": TOLERANCES,
    "rkf78": TOLERANCES,
    "gauss4": (0.4, 0.2, 0.1),
    "gauss6": (0.9, 0.6, 0.4, 0.25),
    "gauss8": (1.2, 0.9, 0.7, 0.55, 0.45, 0.38, 0.3),
    "gauss12": (1.2, 0.9, 0.6, 0.45, 0.35, 0.3, 0.25, 0.2, 0.15),
    "gauss16": (1.2, 0.9, 0.7, 0.5, 0.4, 0.3, 0.2),
}
ADAPTIVE = ("rkf78", "dp85")
ORBITS = {  # methods in the orbit plane
    "orbit-srkn6": (0.8, 0.6, 0.4, 0.3, 0.2),
    "orbit-srkn11": (1.2, 1, 0.8, 0.6, 0.5, 0.4, 0.3, 0.25, 0.2, 0.15),
    "orbit-srkn14": (1, 0.8, 0.6, 0.4, 0.3, 0.25, 0.2),
}


def cheapest(program, rays, bounds, solver_share, methods=METHODS, precisions=("double",)):
    """Finds, for each bound on the greatest error of direction, the fastest method, step and precision.

    Returns a list and the uncertainty of the reference, which is the difference between two step sizes of gauss16. The
    list contains a tuple (report of trace, error, text, arguments) for each bound, or None if no candidate meets it.
    Implicit equations are solved to `solver_share` of the bound. Candidates are compared by their minimum times, which
    are least affected by other programs. Candidates near the shortest time are timed again, alternately."""
    scene = SCENES / "hole.toml"
    reference = directions(program, scene, rays, "--integrator", "gauss16", "--step", 0.1)
    uncertainty = worst_angle(directions(program, scene, rays, "--integrator", "gauss16", "--step", 0.15), reference)
    if not uncertainty <= 0.1 * min(bounds):
        raise RuntimeError(f"the uncertainty of the reference is {uncertainty:.0e}, more than a tenth of the "
                           f"error bound {min(bounds):.0e}")
    def report_of(arguments):
        return program.json("trace", scene, "--rays", rays, "--threads", 1, "--repeat", 9 if program.quick else 25,
                            *arguments)
    def least_time(candidate):
        return candidate[0]["ns_per_ray"]["min"]
    found = []
    for bound in bounds:
        candidates = []
        for precision, (method, steps) in itertools.product(precisions, methods.items()):
            for step in steps:
                step_arguments = ["-D", f"integrator.tolerance={step:g}"] if method in ADAPTIVE else ["--step", step]
                arguments = ["--precision", precision, "--integrator", method, *step_arguments, "-D",
                             f"integrator.solver_tolerance={solver_share * bound:g}"]
                error = worst_angle(directions(program, scene, rays, *arguments), reference)
                if error > bound:
                    continue
                text = f"{precision}, {method}, {'tolerance' if method in ADAPTIVE else 'step'} {step:g}"
                candidates.append((report_of(arguments), error, text, arguments))
                break  # Shorter steps of the same method take more time.
        for _ in range(1 if program.quick else 4):
            time_limit = 1.3 * min(map(least_time, candidates), default=0)
            candidates = [min(c, (report_of(c[3]), *c[1:]), key=least_time) for c in candidates
                          if least_time(c) <= time_limit]
        found.append(min(candidates, key=least_time, default=None))
    return found, uncertainty


def cheapest_of_odeint(program, rays, bounds):
    """Returns, for each bound, the fastest benchmark of Boost.Odeint whose error meets it, or None."""
    def run(*options):
        return program.benchmark("bench_peers", f"--rays={rays}", *options)
    rows = run("--benchmark_min_time=0.01")
    found = []
    for bound in bounds:
        within = [row for row in rows if row["error"] <= bound]
        if within and not program.quick:
            least = min(row["s/ray"] for row in within)
            contenders = "|".join(row["name"] for row in within if row["s/ray"] <= 1.3 * least)
            again = run(f"--benchmark_filter=^({contenders})$", "--benchmark_min_time=0.02",
                        "--benchmark_repetitions=5")
            within = [row for row in again if row["run_type"] == "iteration"]
        found.append(min(within, key=lambda row: row["s/ray"], default=None))
    return found
