"""The claims: what must hold, what is aimed at, and what is measured. One function measures one claim, or several that share runs."""
import dataclasses
import hashlib
import math
import statistics
import tomllib

from . import rays
from .program import SCENES, row_of

ROOM = "room.toml"
GENERAL = ("-D", "integrator.symmetry=none")  # what every row measures but those of the orbit plane
DOUBLE = ("--precision", "double")  # a picture would be in float where that cannot be seen
OWN = "Room 512², rg = 0.08, the default method of the general path"  # a table that two measurements share


@dataclasses.dataclass
class Claim:
    key: str            # of the note that says why it misses
    what: str
    must: list          # numbers, one per measured value; empty: nothing is asked
    aim: list
    measured: list
    spread: str = ""
    more: bool = True   # more is better
    form: str = "{:.2f}"


def seconds(row):
    s = row["seconds"]
    return f"{1e3 * s['median']:.1f} ms ({1e3 * s['min']:.1f} to {1e3 * s['max']:.1f})"


def usual(report, precision):
    """Packets of the width that is taken unasked: those that also come as scanlines."""
    runs = {r["lanes"] for r in report["rows"] if r["precision"] == precision and r["strategy"] == "packet" and
            r["shape"] == f"{r['lanes']}x1"}
    rows = [r for r in report["rows"] if r["precision"] == precision and r["strategy"] == "packet" and r["lanes"] in runs]
    return next(r for r in rows if r["shape"] != f"{r['lanes']}x1")


def packet_over_scalar(program, tables):
    verlet = program.compare(ROOM, "--integrator", "verlet", "--step", 0.1)
    own = program.compare(ROOM)
    tables["Room 512², rg = 0.08, `verlet`, step 0.1"] = verlet
    tables[OWN] = own
    claims = []
    for key, what, report, must, aim in (("packet-verlet", "packet ÷ scalar, room 512², `verlet`, double / float", verlet, [12, 22], [20, 40]),
                                         ("packet-default", "packet ÷ scalar, room 512², default method, double / float", own, [7, 14], [12, 24])):
        rows = [usual(report, p) for p in ("double", "float")]
        # Float against scalar float: the same work, the same precision.
        scalar = row_of(report, "scalar", "float")["speedup"]
        measured = [rows[0]["speedup"], rows[1]["speedup"]]
        claims.append(Claim(key, what + " (over scalar double)", must, aim, measured,
                            f"{seconds(rows[0])}; {seconds(rows[1])}; over scalar float {rows[1]['speedup'] / scalar:.2f}"))
    return claims


def packet_over_per_ray(program, tables):
    claims = []
    for pixels in (0.25, 1e-4):
        report = program.compare(ROOM, "--equal-error", pixels, "--precision", "double")
        tables[f"Room 512², rg = 0.08, each by its cheapest method for {pixels:g} pixel"] = report
        packet, single = row_of(report, "packet", "double"), row_of(report, "per-ray", "double")
        claims.append(Claim(f"per-ray-{pixels:g}", f"packet ÷ better per-ray form, equal error ({pixels:g} pixel), double", [], [4],
                            [packet["speedup"] / single["speedup"]],
                            f"{packet['method']} {packet['lanes']} lanes, {seconds(packet)}; {single['form']} {single['method']}, {seconds(single)}"))
    own = tables.get(OWN) or program.compare(ROOM)
    packet, single = row_of(own, "packet", "double"), row_of(own, "per-ray", "double")
    one = next(r for r in own["rows"] if r["strategy"] == "packet" and r["precision"] == "double" and r["registers"] == 1)
    claims.append(Claim("per-ray-same", f"the same by the same method (`{packet['method']}`): best packet; one register alone (SIMD)", [], [],
                        [packet["speedup"] / single["speedup"], one["speedup"] / single["speedup"]],
                        f"{packet['registers']} registers; per-ray {single['form']} is {single['speedup']:.2f} times scalar"))
    return claims


def culling(program, _):
    claim = Claim("culling", "culling on ÷ off, identical image, double / float", [1.6, 2.2], [2, 3], [], "")
    same = True
    for precision in ("double", "float"):
        def run(cull):
            report, picture = program.render(ROOM, "--threads", 1, "--precision", precision, "-D", f"integrator.cull={cull}", *GENERAL)
            hashes.add(hashlib.sha256(picture).hexdigest())
            return report["seconds"]
        hashes = set()
        ratio = program.ratio(lambda: run("none"), lambda: run("auto"))
        claim.measured.append(ratio.median)
        claim.spread += f"{ratio.least:.2f} to {ratio.greatest:.2f}; "
        same = same and len(hashes) == 1
    claim.spread += "images identical, chords within a fiftieth of a pixel of the curve and 1e-5 of the room" if same else "IMAGES DIFFER"
    if not same:
        claim.measured = []
    return [claim]


def threads(program, _):
    ratio = program.ratio(*(lambda n=n: program.render(ROOM, "--threads", n, *GENERAL)[0]["seconds"] for n in (1, 2)))
    return [Claim("threads", "1 → 2 threads, room 512²", [1.9], [1.98], [ratio.median], f"{ratio.least:.2f} to {ratio.greatest:.2f}")]


CRITICAL = ("critical.csv", 2.599, 0.021)


def cheapest_claim(program, key, what, must, aim, bundle, bound, doubt_allowed, unit="µs", **choice):
    """What rays cost by the cheapest method and step of a list (and precision: rays.cheapest) that ends them within the bound."""
    name, *impact = bundle
    found, doubt = rays.cheapest(program, rays.peers(program.directory / name, *impact), (bound,), doubt_allowed, **choice)
    if not found[0]:
        return Claim(key, what, must, aim, [], f"no method and step of the list comes so near (reference agrees to {doubt:.0e})", False)
    time, error, how, _ = found[0]
    scale, digits = (1, 0) if unit == "ns" else (1e-3, 2)
    spread = f"{how}: error {error:.1e}, {scale * time['min']:.{digits}f} to {scale * time['max']:.{digits}f} {unit}; reference agrees to {doubt:.0e}"
    return Claim(key, what, must, aim, [scale * time["median"]], spread, False, *(["{:.0f}"] if unit == "ns" else []))


def peers(program, _):
    """The same rays by Boost.Odeint and by kagero, each by its cheapest method for the bound, in turn."""
    list_of_rays, bounds = rays.peers(program.directory / "peers.csv"), (1.6e-5, 1e-8, 8e-12)
    found, doubt = rays.cheapest(program, list_of_rays, bounds, 1e-2)
    claim = Claim("peers", "peers' 2048 rays, Boost.Odeint's best (one ray at a time, derivatives by hand) ÷ ours (packets, from H) at ≤ 1.6e-5 / 1e-8 / 8e-12", [6, 7, 8], [13, 15, 18], [], "")
    for odeint, best in zip(rays.cheapest_of_odeint(program, list_of_rays, bounds), found):
        if best is None or odeint is None:
            claim.spread += f"no method and step of {'ours' if best is None else 'Odeint'} comes so near; "
            claim.measured.append(0 if best is None else math.inf)
            continue
        _, error, how, arguments = best
        times = {"theirs": [], "ours": []}
        def theirs():
            row, = program.benchmark("bench_peers", f"--rays={list_of_rays}", f"--benchmark_filter=^{odeint['name']}$", "--benchmark_min_time=0.1")
            times["theirs"].append(1e9 * row["s/ray"])
            return times["theirs"][-1]
        def ours():
            report = program.json("trace", SCENES / "hole.toml", "--rays", list_of_rays, "--threads", 1, "--repeat", 25, *arguments)
            times["ours"].append(report["ns_per_ray"]["median"])
            return times["ours"][-1]
        ratio = program.ratio(theirs, ours)
        claim.measured.append(ratio.median)
        theirs_median, ours_median = (statistics.median(times[who]) for who in ("theirs", "ours"))
        claim.spread += (f"{ratio.least:.1f} to {ratio.greatest:.1f}: {odeint['name'].removeprefix('odeint/')} {theirs_median:.0f} ns, error {odeint['error']:.1e}; "
                         f"{how} {ours_median:.0f} ns, error {error:.1e}; ")
    claim.spread += f"reference agrees to {doubt:.0e}"
    claims = [claim]
    claims.append(cheapest_claim(program, "critical", "near-critical rays (b = 2.599 … 2.62 rg), ≤ 2e-9, µs per ray", [8.9], [3], CRITICAL, 2e-9, 1e-6))
    return claims


def orbits(program, _):
    """The same rays, and the room, through the plane of the orbit; in the precision that costs less."""
    choice = {"methods": rays.ORBITS, "precisions": ("double", "float")}
    claims = [cheapest_claim(program, "orbit", "peers' rays through the orbit plane, ≤ 1e-6, ns per ray", [60], [15], ("peers.csv",), 1e-6, 1e-2, "ns", **choice),
              cheapest_claim(program, "orbit-critical", "near-critical rays through the orbit plane, ≤ 2e-9, µs per ray", [], [], CRITICAL, 2e-9, 1e-6, **choice)]
    for scene in (ROOM, "galaxy.toml", "wormhole.toml"):
        ratio = program.ratio(*(lambda more=more: program.render(scene, "--threads", 1, *DOUBLE, *more)[0]["seconds"] for more in (GENERAL, ())))
        claims.append(Claim("orbit-picture", f"general path ÷ orbit plane, {scene}, each by the space's defaults", [], [], [ratio.median],
                            f"{ratio.least:.2f} to {ratio.greatest:.2f}"))
    def frame():
        return program.render(ROOM, "--size", "1280x720", "--precision", "float", "--threads", 2)[0]["seconds"]
    times = sorted(frame() for _ in range(2 * program.rounds))
    claims.append(Claim("orbit-frames", "1280x720 room, float, 2 threads, orbit plane: frames/s", [], [], [1 / times[len(times) // 2]],
                        f"{1 / times[-1]:.1f} to {1 / times[0]:.1f}", form="{:.1f}"))
    return claims


def whole_steps(program, _):
    """One step after another without a scene (bench/kernels/steps.h): by the tape and by hand, against the peak, and in a picture."""
    results = program.medians(f"bench_kernels_{program.isa}", "^step/schwarzschild_(rescaled|by_hand|as_printed)/(verlet|gauss8)/(packet|one_register)_double$")
    def of(form, method, values="packet"):
        return results[f"step/schwarzschild_{form}/{method}/{values}_double"]
    methods = ("verlet", "gauss8")
    by_tape = [of("rescaled", m)["s/step"] / of("by_hand", m)["s/step"] for m in methods]
    printed = [max(of("as_printed", m, v)["s/step"] / of("by_hand", m, v)["s/step"] for m in methods) for v in ("one_register", "packet")]
    share = max(100 * of("rescaled", m)["of_peak"] for m in methods)
    bare = Claim("bare", "render per gradient ÷ bare integrator, `verlet` / `gauss8`", [1.3, 1.3], [1.08, 1.08], [], "", False)
    for method, step in zip(methods, (0.1, 0.5)):
        def render():
            report = program.render(ROOM, "--threads", 1, *DOUBLE, "--integrator", method, "--step", step)[0]
            return report["seconds"] / report["gradients"]
        def alone():
            row, = program.benchmark(f"bench_kernels_{program.isa}", f"--benchmark_filter=^step/schwarzschild_rescaled/{method}/packet_double$", "--benchmark_min_time=0.2")
            return row["s/step"] / row["gradients/step"]
        ratio = program.ratio(render, alone)
        bare.measured.append(ratio.median)
        bare.spread += f"{ratio.least:.2f} to {ratio.greatest:.2f}; "
    return [Claim("hand", "AD ÷ hand code for K, (16) factored, in `verlet` / `gauss8`, double packets", [1.15, 1.15], [1, 1], by_tape, "medians of 5", False),
            Claim("printed", "the same, (16) as printed, term by term, one register / a packet's two; the worse of both methods", [1.5, 2.6], [1.15, 1.3],
                  printed, "medians of 5", False),
            Claim("peak", "best double AD step ÷ multiply-adds alone, %", [45], [65], [share], "operations counted in the programs: a lower bound", form="{:.0f}"),
            bare]


def shuffled(program, _):
    lists = [rays.room_rays(program.directory / f"{name}.csv", name == "shuffled") for name in ("shuffled", "coherent")]
    def run(path):
        return program.json("trace", SCENES / ROOM, "--observer", "static", "--rays", path, "--threads", 1, "--repeat", 3, *GENERAL)["ns_per_ray"]["median"]
    ratio = program.ratio(*(lambda path=path: run(path) for path in lists))
    return [Claim("shuffled", "shuffled ÷ coherent rays (`trace`, room)", [1.15], [1.03], [ratio.median],
                  f"{ratio.least:.2f} to {ratio.greatest:.2f}", False)]


def frames(program, tables):
    report = program.compare(ROOM, "--size", "1280x720", "--precision", "float", "--strategy", "packet", "--equal-error", 0.25, "--threads", 2)
    tables["Room 1280x720, 2 threads, each by its cheapest method for 0.25 pixel"] = report
    row = row_of(report, "packet", "float")
    if not row:
        return [Claim("frames", "1280x720 room, float, 2 threads, ≤ ¼ pixel for 99 %: frames/s", [9], [30], [], "no float method comes so near")]
    s = row["seconds"]
    return [Claim("frames", "1280x720 room, float, 2 threads, ≤ ¼ pixel for 99 %: frames/s", [9], [30], [1 / s["median"]],
                  f"{row['method']}, step {row['step']:g}, {row['lanes']} lanes; {1 / s['max']:.1f} to {1 / s['min']:.1f}", form="{:.1f}")]


def straight(program, tables):
    report = program.compare(ROOM, "-D", "space.rg=0")
    tables["Room 512², rg = 0"] = report
    rate = usual(report, "double")["mrays_per_s"]
    results = program.medians("bench_render", f"^straight_room/{program.isa}/")
    times = [results[f"straight_room/{program.isa}/{way}"] for way in ("kagero", "bare_embree")]
    ratio = times[0]["real_time"] / times[1]["real_time"]
    return [Claim("straight", "rg = 0 ÷ a bare Embree loop over the same rays and shading", [1.1], [1.02], [ratio],
                  f"medians of 5: {times[0]['real_time']:.1f} and {times[1]['real_time']:.1f} ms; {rate:.2f} Mray/s with the start of threads", False)]


# The room's space as a formula: (16) of the paper, in the coordinates of kernels/hamiltonians/schwarzschild.h.
FORMULA_ROOM = '''[space]
hamiltonian = "formula"
H = "0.5*(px^2 + py^2 + pz^2 - pt^2) - 0.5*(rg/r)*u^2"
capture = "r - rg"
[space.constants]
rg = 0.08
pt = 1
[space.let]
r = "sqrt(x^2 + y^2 + z^2)"
u = "pt + (x*px + y*py + z*pz)/r"
'''


def formulas(program, _):
    """The same space, built in and as a formula of the scene, by the method and step that are the built-in's defaults."""
    text = (SCENES / ROOM).read_text()
    scene = program.directory / "formula-room.toml"
    scene.write_text(FORMULA_ROOM + text[text.index("[integrator]"):])
    default = tomllib.loads(program.text("print", SCENES / ROOM, *GENERAL))["integrator"]
    pairs = ((ROOM, scene, ["--integrator", default["method"], "--step", default["step"], "-D", "integrator.rescale=r"]), ("mirage.toml", SCENES / "formula-mirage.toml", []))
    claim = Claim("formula", "formula ÷ built-in, room and mirage, by the built-in's default method", [0.4, 0.4], [0.6, 0.6], [], "")
    for built_in, formula, options in pairs:
        def run(path, more=()):
            return program.render(path, "--threads", 1, *DOUBLE, *more)[0]["seconds"]
        ratio = program.ratio(lambda: run(built_in, GENERAL), lambda: run(formula, options))
        claim.measured.append(ratio.median)
        claim.spread += f"{ratio.least:.2f} to {ratio.greatest:.2f}; "
    return [claim]


ALL = (packet_over_scalar, packet_over_per_ray, culling, threads, peers, orbits, whole_steps, shuffled, frames, straight, formulas)
