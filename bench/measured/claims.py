"""The claims about speed. Each claim has a minimum, a target, and a function that measures it. A function returns a
list of `Claim`, with several claims if they share runs. It may add tables with all rows of a comparison to the data
file."""
import dataclasses
import hashlib
import math
import re
import statistics

from . import rays
from .program import SCENES, fastest_row

ROOM = "room.toml"
GENERAL = ("-D", "integrator.symmetry=none")  # the general path: all six variables are integrated
DOUBLE = ("--precision", "double")            # by default, pictures without a visible difference are in float
DEFAULT_TABLE = "Room 512x512, rg = 0.08, the default method of the general path"


@dataclasses.dataclass
class Claim:
    key: str            # key of the cause in bench/performance-causes.toml
    what: str           # description of the measured quantity
    minimum: list       # one number per measured value; empty: no minimum
    target: list        # one number per measured value; empty: no target
    measured: list      # medians; empty: no method and step met the error bound
    detail: str = ""    # spread, method and step
    higher_is_better: bool = True
    form: str = "{:.2f}"  # format of the measured values
    share: list = dataclasses.field(default_factory=list)  # tracing rate in percent of the machine's peak


def milliseconds(row):
    """Returns median, minimum and maximum of the time of a row of `kagero compare`."""
    s = row["seconds"]
    return f"{1e3 * s['median']:.1f} ms ({1e3 * s['min']:.1f} to {1e3 * s['max']:.1f})"


def default_width(report, precision):
    """Returns the packet row of the default width, which is the only one that is also measured as scanlines."""
    packets = [r for r in report["rows"] if r["precision"] == precision and r["strategy"] == "packet"]
    scanlines = {r["lanes"] for r in packets if r["shape"] == f"{r['lanes']}x1"}
    return next(r for r in packets if r["lanes"] in scanlines and r["shape"] != f"{r['lanes']}x1")


def general_share(program, precision, *arguments):
    """Returns the share of peak, in percent, of the room on the general path."""
    return program.share_of_peak(SCENES / ROOM, "--precision", precision, *GENERAL, *arguments)


def packet_over_scalar(program, tables):
    """Speedup of packets over scalar code, with `verlet` and with the default method."""
    verlet_arguments = ("--integrator", "verlet", "--step", 0.1)
    verlet = program.compare(ROOM, *verlet_arguments)
    default = program.compare(ROOM)
    tables["Room 512x512, rg = 0.08, verlet, step 0.1"] = verlet
    tables[DEFAULT_TABLE] = default
    claims = []
    for key, what, report, minimum, target, arguments in (
            ("packet-verlet", "packet ÷ scalar, room 512x512, `verlet`, double / float", verlet, [12, 22], [20, 40],
             verlet_arguments),
            ("packet-default", "packet ÷ scalar, room 512x512, default method, double / float", default, [7, 14],
             [12, 24], ())):
        rows = [default_width(report, p) for p in ("double", "float")]
        scalar_float = fastest_row(report, "scalar", "float")["speedup"]
        claims.append(Claim(key, what + " (both over scalar double)", minimum, target, [r["speedup"] for r in rows],
                            f"{milliseconds(rows[0])}; {milliseconds(rows[1])}; float packet ÷ scalar float "
                            f"{rows[1]['speedup'] / scalar_float:.2f}",
                            share=[general_share(program, p, *arguments) for p in ("double", "float")]))
    return claims


def packet_over_per_ray(program, tables):
    """Speedup of packets over the faster of the two per-ray forms, at equal error and with the same method."""
    claims = []
    for pixels in (0.25, 1e-4):
        report = program.compare(ROOM, "--equal-error", pixels, *DOUBLE)
        tables[f"Room 512x512, rg = 0.08, each strategy by its cheapest method for {pixels:g} pixel"] = report
        packet, per_ray = fastest_row(report, "packet", "double"), fastest_row(report, "per-ray", "double")
        claims.append(Claim(
            f"per-ray-{pixels:g}", f"packet ÷ better per-ray form at equal error ({pixels:g} pixel), double", [], [4],
            [packet["speedup"] / per_ray["speedup"]],
            f"packet {packet['method']}, {packet['lanes']} lanes, {milliseconds(packet)}; per-ray {per_ray['form']} "
            f"{per_ray['method']}, {milliseconds(per_ray)}",
            share=[general_share(program, "double", "--integrator", packet["method"], "--step", packet["step"])]))
    default = tables.get(DEFAULT_TABLE) or program.compare(ROOM)
    packet, per_ray = fastest_row(default, "packet", "double"), fastest_row(default, "per-ray", "double")
    one = next(r for r in default["rows"]
               if r["strategy"] == "packet" and r["precision"] == "double" and r["registers"] == 1)
    claims.append(Claim(
        "per-ray-same", f"packet ÷ better per-ray form, both by `{packet['method']}`: best packet / one register", [],
        [], [packet["speedup"] / per_ray["speedup"], one["speedup"] / per_ray["speedup"]],
        f"{packet['registers']} registers per variable; per-ray {per_ray['form']} is {per_ray['speedup']:.2f} times "
        "scalar"))
    return claims


def culling(program, _):
    """Render time without culling divided by that with culling. The pictures must be identical."""
    claim = Claim("culling", "queries for all steps ÷ with culling, same picture, double / float", [1.6, 2.2], [2, 3],
                  [])
    spreads, same = [], True
    for precision in ("double", "float"):
        def run(cull):
            report, picture = program.render(ROOM, "--threads", 1, "--precision", precision, "-D",
                                             f"integrator.cull={cull}", *GENERAL)
            hashes.add(hashlib.sha256(picture).hexdigest())
            return report["seconds"]
        hashes = set()
        ratio = program.ratio(lambda: run("none"), lambda: run("auto"))
        claim.measured.append(ratio.median)
        spreads.append(str(ratio))
        same = same and len(hashes) == 1
    claim.detail = "; ".join(spreads) + ("; pictures are identical" if same else "; THE PICTURES DIFFER")
    if not same:
        claim.measured = []
    return [claim]


def threads(program, _):
    """Speedup of two threads over one."""
    def run(count):
        return program.render(ROOM, "--threads", count, *GENERAL)[0]["seconds"]
    ratio = program.ratio(lambda: run(1), lambda: run(2))
    return [Claim("threads", "1 thread ÷ 2 threads, room 512x512", [1.9], [1.98], [ratio.median], str(ratio))]


# File name, and least value and width of the range of impact parameters, in r_g, of the near-critical rays.
CRITICAL = ("critical.csv", 2.599, 0.021)


def traced_share(program, found):
    """Returns the share of peak of traced rays, in percent, from the operations that `profile` counts for the method.

    `found` is an entry (report of trace, error, text, arguments) of rays.cheapest. A profile of hole.toml with the same
    method, step and precision gives the operations per gradient and per step. The report of `trace` gives the numbers
    of gradients and steps per ray."""
    roofline = program.roofline(SCENES / "hole.toml", *found[3], "--size", "64x64")
    report = found[0]
    operations = (report["gradients_per_ray"] * roofline["operations_per_gradient"] +
                  report["steps_per_ray"] * roofline["operations_per_step"])
    return 100 * operations / report["ns_per_ray"]["median"] / roofline["peak_gflops_one_thread"]


def cheapest_claim(program, key, what, minimum, target, ray_choice, bound, solver_share, unit="µs", **choice):
    """Measures the time per ray of the cheapest method, step and precision of rays.py that meet an error bound.

    `ray_choice` is a tuple: a file name, and optionally the arguments of rays.inward_rays after the path. Implicit
    equations are solved to `solver_share` of the bound. `choice` contains methods and precisions for rays.cheapest."""
    name, *impact_range = ray_choice
    ray_list = rays.inward_rays(program.directory / name, *impact_range)
    found, uncertainty = rays.cheapest(program, ray_list, (bound,), solver_share, **choice)
    if not found[0]:
        return Claim(key, what, minimum, target, [], "no method and step in rays.py meets the error bound (uncertainty"
                     f" of the reference: {uncertainty:.0e})", False)
    report, error, text, _ = found[0]
    time = report["ns_per_ray"]
    scale, digits = (1, 0) if unit == "ns" else (1e-3, 2)
    detail = (f"{text}: error {error:.1e}; {scale * time['min']:.{digits}f} to {scale * time['max']:.{digits}f} {unit};"
              f" uncertainty of the reference {uncertainty:.0e}")
    return Claim(key, what, minimum, target, [scale * time["median"]], detail, False, f"{{:.{digits}f}}",
                 [traced_share(program, found[0])])


def peers(program, _):
    """Time of Boost.Odeint divided by that of kagero, for the same rays. Both use their cheapest method within each
    error bound, and run alternately."""
    ray_list, bounds = rays.inward_rays(program.directory / "peers.csv"), (1.6e-5, 1e-8, 8e-12)
    found, uncertainty = rays.cheapest(program, ray_list, bounds, 1e-2)
    claim = Claim("peers", "Boost.Odeint's cheapest method (one ray at a time, derivatives by hand) ÷ kagero's "
                  "(packets, from H), 2048 rays, errors ≤ 1.6e-5 / 1e-8 / 8e-12", [6, 7, 8], [13, 15, 18], [])
    details = []
    for odeint, best in zip(rays.cheapest_of_odeint(program, ray_list, bounds), found):
        if best is None or odeint is None:
            details.append(f"no method and step of {'kagero' if best is None else 'Odeint'} meets the bound")
            claim.measured.append(0 if best is None else math.inf)
            continue
        _, error, text, arguments = best
        times = {"odeint": [], "kagero": []}
        def time_of_odeint():
            row, = program.benchmark("bench_peers", f"--rays={ray_list}",
                                     f"--benchmark_filter=^{odeint['name']}$", "--benchmark_min_time=0.1")
            times["odeint"].append(1e9 * row["s/ray"])
            return times["odeint"][-1]
        def time_of_kagero():
            report = program.json("trace", SCENES / "hole.toml", "--rays", ray_list, "--threads", 1, "--repeat", 25,
                                  *arguments)
            times["kagero"].append(report["ns_per_ray"]["median"])
            return times["kagero"][-1]
        ratio = program.ratio(time_of_odeint, time_of_kagero)
        claim.measured.append(ratio.median)
        claim.share.append(traced_share(program, best))
        odeint_median, kagero_median = (statistics.median(times[name]) for name in ("odeint", "kagero"))
        details.append(f"{ratio}: {odeint['name'].removeprefix('odeint/')} {odeint_median:.0f} ns, error "
                       f"{odeint['error']:.1e}; {text} {kagero_median:.0f} ns, error {error:.1e}")
    claim.detail = "; ".join([*details, f"uncertainty of the reference {uncertainty:.0e}"])
    return [claim, cheapest_claim(program, "critical", "near-critical rays (b = 2.599 to 2.62 r_g), error ≤ 2e-9, µs "
                                  "per ray", [8.9], [3], CRITICAL, 2e-9, 1e-6)]


def orbits(program, _):
    """The rays of `peers`, and pictures, integrated in the orbit plane of each ray. Rays use the faster precision."""
    choice = {"methods": rays.ORBITS, "precisions": ("double", "float")}
    claims = [cheapest_claim(program, "orbit", "the peers' rays in the orbit plane, error ≤ 1e-6, ns per ray", [60],
                             [15], ("peers.csv",), 1e-6, 1e-2, "ns", **choice),
              cheapest_claim(program, "orbit-critical", "near-critical rays in the orbit plane, error ≤ 2e-9, µs per "
                             "ray", [], [], CRITICAL, 2e-9, 1e-6, **choice)]
    for scene in (ROOM, "galaxy.toml", "wormhole.toml"):
        def run(*arguments):
            return program.render(scene, "--threads", 1, *DOUBLE, *arguments)[0]["seconds"]
        ratio = program.ratio(lambda: run(*GENERAL), lambda: run())
        claims.append(Claim("orbit-picture", f"general path ÷ orbit plane, {scene}, default methods", [], [],
                            [ratio.median], str(ratio), share=[program.share_of_peak(SCENES / scene, *DOUBLE)]))
    picture = ("--size", "1280x720", "--precision", "float")
    times = sorted(program.render(ROOM, *picture, "--threads", 2)[0]["seconds"] for _ in range(2 * program.rounds))
    claims.append(Claim("orbit-frames", "room 1280x720, float, 2 threads, orbit plane, frames/s", [], [],
                        [1 / times[len(times) // 2]], f"{1 / times[-1]:.1f} to {1 / times[0]:.1f}", form="{:.1f}",
                        share=[program.share_of_peak(SCENES / ROOM, *picture)]))
    return claims


# A hole in front of the sky, without objects.
HOLE_AND_SKY = '''space = {{ {} }}
[integrator]
escape_radius = 100
[camera]
position = [0, -30, 4.5]
look_at = [0, 0, -0.4]
up = [0, 0, 1]
fov = 38
[film]
size = [960, 640]
[sky]
checker = true
'''


def spin(program, _):
    """Time with a hole of spin 0.95 divided by the time with a hole of the same mass without spin. Nothing but the sky
    is seen, and both use the method, step and precision that the trial chooses for an error of 0.05 pixel."""
    scenes = {}
    for name, space in (("spinning", 'hamiltonian = "kerr", spin = 0.95'), ("resting", 'hamiltonian = "schwarzschild", '
                                                                            "rg = 2")):
        scenes[name] = program.directory / f"sky-{name}.toml"
        scenes[name].write_text(HOLE_AND_SKY.format(space))
    def picture(name):
        return program.render(scenes[name], "--threads", 1)[0]["seconds"]
    pictures = program.ratio(lambda: picture("spinning"), lambda: picture("resting"))
    path = program.directory / "camera-rays.csv"
    rays.camera_rays(path)
    def choice(name):
        plan = program.json("explain", scenes[name])
        method, step = re.search(r"integration by (\S+), step (\S+)", "\n".join(plan["used"])).groups()
        return "--integrator", method, "--step", step, "--precision", plan["precision"]
    choices = {name: choice(name) for name in scenes}
    def trace(name):
        report = program.json("trace", scenes[name], "--rays", path, "--threads", 1, "--repeat", 21, "-o",
                              program.directory / "ends.csv", *choices[name])
        return report["ns_per_ray"]["median"]
    traced = program.ratio(lambda: trace("spinning"), lambda: trace("resting"))
    return [Claim("spin-picture", "picture of the sky around a hole of spin 0.95 ÷ the same without spin, 1 thread", [],
                  [4], [pictures.median], str(pictures), False),
            Claim("spin-rays", "the rays of such a picture, tracing alone, spin 0.95 ÷ without spin, 1 thread", [], [4],
                  [traced.median], f"{traced}; {choices['spinning'][1]}, step {choices['spinning'][3]}", False)]


def whole_steps(program, _):
    """Time of steps without a scene (bench/kernels/steps.h): with derivatives from the tape divided by hand-written
    ones, and in a picture divided by the step alone."""
    results = program.medians(f"bench_kernels_{program.isa}", "^step/schwarzschild_(rescaled|by_hand|as_printed)/"
                              "(verlet|gauss8)/(packet|one_register)_double$")
    def step(derivatives, method, values="packet"):
        return results[f"step/schwarzschild_{derivatives}/{method}/{values}_double"]
    methods = ("verlet", "gauss8")
    tape = [step("rescaled", m)["s/step"] / step("by_hand", m)["s/step"] for m in methods]
    printed = [max(step("as_printed", m, v)["s/step"] / step("by_hand", m, v)["s/step"] for m in methods)
               for v in ("one_register", "packet")]
    shares = [100 * step("rescaled", m)["of_peak"] for m in methods]
    bare = Claim("bare", "render ÷ integrator alone, time per gradient, `verlet` / `gauss8`", [1.3, 1.3], [1.08, 1.08],
                 [], "", False)
    spreads = []
    for method, length in zip(methods, (0.1, 0.5)):
        arguments = (*DOUBLE, "--integrator", method, "--step", length)
        def render():
            report = program.render(ROOM, "--threads", 1, *arguments)[0]
            return report["seconds"] / report["gradients"]
        def alone():
            row, = program.benchmark(f"bench_kernels_{program.isa}", "--benchmark_filter=^step/schwarzschild_rescaled/"
                                     f"{method}/packet_double$", "--benchmark_min_time=0.2")
            return row["s/step"] / row["gradients/step"]
        ratio = program.ratio(render, alone)
        bare.measured.append(ratio.median)
        bare.share.append(program.share_of_peak(SCENES / ROOM, *arguments))
        spreads.append(str(ratio))
    bare.detail = "; ".join(spreads)
    return [Claim("hand", "gradient from the tape ÷ by hand, (16) factored, in `verlet` / `gauss8`, double packets",
                  [1.15, 1.15], [1, 1], tape, "medians of 5", False, share=shares),
            Claim("printed", "the same for (16) term by term as printed, one register / packet of two", [1.5, 2.6],
                  [1.15, 1.3], printed, "medians of 5, the worse of both methods", False),
            Claim("peak", "best step from the tape, double, % of the peak of multiply-adds", [45], [65], [max(shares)],
                  "operations are counted in the programs, which gives a lower bound", form="{:.0f}",
                  share=[max(shares)]),
            bare]


def shuffled(program, _):
    """Time of `trace` for shuffled rays divided by that for the same rays in order."""
    lists = [rays.room_rays(program.directory / f"{name}.csv", name == "shuffled") for name in ("shuffled", "coherent")]
    def run(path):
        return program.json("trace", SCENES / ROOM, "--observer", "static", "--rays", path, "--threads", 1, "--repeat",
                            3, *GENERAL)["ns_per_ray"]["median"]
    ratio = program.ratio(*(lambda path=path: run(path) for path in lists))
    return [Claim("shuffled", "`trace` of shuffled ÷ coherent rays, room", [1.15], [1.03], [ratio.median], str(ratio),
                  False)]


def frames(program, tables):
    """Pictures per second of the cheapest float method with a pixel error of at most 0.25."""
    picture = ("--size", "1280x720", "--precision", "float")
    report = program.compare(ROOM, *picture, "--strategy", "packet", "--equal-error", 0.25, "--threads", 2)
    tables["Room 1280x720, 2 threads, each strategy by its cheapest method for 0.25 pixel"] = report
    row = fastest_row(report, "packet", "float")
    claim = Claim("frames", "room 1280x720, float, 2 threads, general path, ≤ 0.25 pixel for 99 %, frames/s", [9], [30],
                  [], "no float method meets the bound", form="{:.1f}")
    if row:
        s = row["seconds"]
        claim.measured = [1 / s["median"]]
        claim.detail = (f"{row['method']}, step {row['step']:g}, {row['lanes']} lanes; "
                        f"{1 / s['max']:.1f} to {1 / s['min']:.1f}")
        claim.share = [general_share(program, "float", "--size", "1280x720", "--integrator", row["method"], "--step",
                                     row["step"])]
    return [claim]


def straight(program, tables):
    """Render time of the room with straight rays divided by that of a loop that only queries Embree."""
    report = program.compare(ROOM, "-D", "space.rg=0")
    tables["Room 512x512, rg = 0"] = report
    rate = default_width(report, "double")["mrays_per_s"]
    results = program.medians("bench_render", f"^straight_room/{program.isa}/")
    kagero, shaded, unshaded = (results[f"straight_room/{program.isa}/{name}"]["real_time"] for name in
                                ("kagero", "bare_embree", "bare_embree_without_shading"))
    return [Claim("straight", "rg = 0 ÷ a plain Embree loop over the same rays and shading", [1.1], [1.02],
                  [kagero / shaded], f"medians of 5: {kagero:.1f} and {shaded:.1f} ms; {rate:.2f} Mray/s with the "
                  "start of threads", False),
            Claim("straight-unshaded", "rg = 0, a picture ÷ a plain Embree loop over the same rays without shading",
                  [2.5], [1.5], [kagero / unshaded], f"medians of 5: {kagero:.1f} and {unshaded:.1f} ms", False)]


# The space of the room as a formula: H of Satoh (2003), equation (16), factored as in
# kernels/hamiltonians/schwarzschild.h.
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


# The space `kerr` with mass 0.25 and spin 0.6, and the same as a formula, for one method and step.
FORMULA_KERR = '''[space]
hamiltonian = "formula"
H = "0.5*(px^2 + py^2 + pz^2 - pt^2) - 0.5*f*(pt + lx*px + ly*py + z/r*pz)^2"
capture = "r - 1.02*(M + sqrt(M^2 - a^2))"
[space.constants]
pt = 1
M = 0.25
a = 0.15
[space.let]
s = "x^2 + y^2 + z^2 - a^2"
r = "sqrt(0.5*(s + sqrt(s^2 + 4*a^2*z^2)))"
f = "2*M*r^3/(r^4 + a^2*z^2)"
lx = "(r*x - a*y)/(r^2 + a^2)"
ly = "(r*y + a*x)/(r^2 + a^2)"
'''
BUILT_IN_KERR = '''[space]
hamiltonian = "kerr"
mass = 0.25
spin = 0.6
'''
KERR_VIEW = '''[integrator]
method = "gauss8"
step = 0.2
rescale = "none"
escape_radius = 20
[camera]
position = [8, 0.5, 2]
look_at = [0, 0, 0]
up = [0, 0, 1]
fov = 40
[film]
size = [256, 256]
'''


def formula_pairs(program):
    """Returns scenes with a compiled Hamiltonian and the same as a formula, each with options for method and step."""
    text = (SCENES / ROOM).read_text()
    room, kerr, formula_kerr = (program.directory / f"{name}.toml" for name in ("formula-room", "kerr", "formula-kerr"))
    room.write_text(FORMULA_ROOM + text[text.index("[integrator]"):])
    kerr.write_text(BUILT_IN_KERR + KERR_VIEW)
    formula_kerr.write_text(FORMULA_KERR + KERR_VIEW)
    printed = program.text("print", SCENES / ROOM, *GENERAL)  # in which defaults are comments
    method, step = (re.search(rf"^(?:# )?{key} = (\S+)", printed, re.MULTILINE)[1] for key in ("method", "step"))
    in_room, in_mirage = (["--integrator", name, "--step", length]
                          for name, length in ((method.strip('"'), step), ("srkn6", "0.1")))
    return ((SCENES / ROOM, [*GENERAL, *in_room], room, [*in_room, "-D", "integrator.rescale=r"]),
            (SCENES / "mirage.toml", [*GENERAL, *in_mirage], SCENES / "formula-mirage.toml", in_mirage),
            (kerr, GENERAL, formula_kerr, []))


def formulas(program, _):
    """Render time with a compiled Hamiltonian divided by that with the same H as a formula of the scene, for the same
    method and step; and the time in which a long formula is compiled."""
    claim = Claim("formula", "compiled Hamiltonian ÷ the same as a formula, room / mirage / Kerr, same method and step",
                  [0.8] * 3, [0.97] * 3, [])
    spreads = []
    for compiled, compiled_options, formula, formula_options in formula_pairs(program):
        def run(path, options):
            return program.render(path, "--threads", 1, *DOUBLE, *options)[0]["seconds"]
        ratio = program.ratio(lambda: run(compiled, compiled_options), lambda: run(formula, formula_options))
        claim.measured.append(ratio.median)
        claim.share.append(program.share_of_peak(formula, *DOUBLE, *formula_options))
        spreads.append(str(ratio))
    claim.detail = "; ".join(spreads)
    return [claim, formula_compilation(program)]


def formula_compilation(program):
    """Time in which a formula of about 300 nodes is compiled."""
    terms = (f"{i}*sqrt((x - 0.{i})^2 + (y + 0.{i})^2 + z^2*{i} + 1)" for i in range(1, 21))
    scene = program.directory / "long-formula.toml"
    scene.write_text('[space]\nhamiltonian = "formula"\nH = "0.5*(px^2 + py^2 + pz^2) + ' + " + ".join(terms) + '"\n' +
                     "H0 = 1e5\n" + KERR_VIEW)
    times = [program.json("explain", scene)["formula_code"].get("compile_s", math.inf) for _ in range(program.rounds)]
    return Claim("formula-compilation", "time to compile a formula of 300 nodes, s", [0.3], [0.05],
                 [statistics.median(times)], f"{min(times):.3f} to {max(times):.3f}", False, "{:.3f}")


# The room with mirrors as walls and a lamp.
MIRROR_ROOM = '''[space]
hamiltonian = "schwarzschild"
rg = 0.08
[integrator]
escape_radius = 4
[camera]
position = [0.22, -0.92, 0.16]
look_at = [0, 0, 0]
up = [0, 0, 1]
fov = 96
[film]
size = [512, 512]
max_bounces = 4
[[object]]
shape = "room"
min = [-1, -1, -1]
max = [1, 1, 1]
material = "mirror"
[[object]]
shape = "sphere"
center = [0.5, 0.4, -0.6]
radius = 0.2
'''


# A square outside the walls of the room.
UNSEEN_SQUARE = '''
[[object]]
name = "unseen"
shape = "rectangle"
origin = [1.5, -1, -1]
edge_u = [0, 2, 0]
edge_v = [0, 0, 2]
'''


def bounces(program, _):
    """Cost of the generations of rays in a room of mirrors, of those in the same room with diffuse walls, and cost of
    following paths where no ray meets a mirror. A scene without mirrors and boundaries does not follow paths;
    `tests/corpus OLD NEW` compares such scenes. The times of generations are processor times, from `generations` in the
    JSON of `kagero render mirror-room.toml --threads 1 --json` with the scene MIRROR_ROOM above."""
    scene = program.directory / "mirror-room.toml"
    scene.write_text(MIRROR_ROOM)
    costs, occupancies = [], []
    for _ in range(program.rounds):
        generations = program.render(scene, "--threads", 1)[0]["generations"]
        costs.append(max(g["ns_per_ray"] for g in generations[1:]) / generations[0]["ns_per_ray"])
        occupancies.append(min(100 * g["lane_occupancy"] for g in generations if g["rays"] > 1e4))
    diffuse = program.directory / "diffuse-room.toml"
    diffuse.write_text(MIRROR_ROOM.replace('"mirror"', '"diffuse"'))
    def segment_time(path):
        generations = program.render(path, "--threads", 1)[0]["generations"][1:]
        return sum(g["ns_per_ray"] * g["rays"] for g in generations) / sum(g["rays"] for g in generations)
    scattered = [segment_time(diffuse) / segment_time(scene) for _ in range(program.rounds)]
    def room_with(material):
        unseen = program.directory / f"unseen-{material}.toml"
        unseen.write_text((SCENES / ROOM).read_text() + UNSEEN_SQUARE + f'material = "{material}"\n')
        return program.render(unseen, "--threads", 1)[0]["seconds"]
    unseen = program.ratio(lambda: room_with("mirror"), lambda: room_with("surface"))
    return [Claim("bounces", "time per ray segment, room of mirrors: costliest of generations 1 to 4 ÷ generation 0",
                  [1.3], [1], [statistics.median(costs)], f"{min(costs):.2f} to {max(costs):.2f}", False),
            Claim("scattered", "time per path segment, diffuse walls ÷ mirrors, generations 1 to 4", [1.5], [1],
                  [statistics.median(scattered)], f"{min(scattered):.2f} to {max(scattered):.2f}", False),
            Claim("bounce-occupancy", "lane occupancy of the emptiest generation there, in percent", [90], [95],
                  [statistics.median(occupancies)], form="{:.0f}"),
            Claim("unseen-mirror", "room with a mirror that no ray meets ÷ with a plain square instead", [], [1.02],
                  [unseen.median], str(unseen), False)]


def adaptive(program, _):
    """Time of a picture in which all rays are traced, divided by that of the adaptively sampled picture."""
    def picture(scene, sampling):
        return program.render(SCENES / f"{scene}.toml", "--threads", 2, "--size", "1280x720", "--spp", 1, "--sampling",
                              sampling)[0]
    scenes, shares = ("galaxy", "hole", "wormhole", "room", "kerr", "mirage"), []
    ratios = []
    for scene in scenes:
        ratios.append(program.ratio(lambda scene=scene: picture(scene, "full")["seconds"],
                                    lambda scene=scene: picture(scene, "adaptive")["seconds"]).median)
        shares.append(100 * picture(scene, "adaptive")["traced_share"])
    return [Claim("adaptive", f"full picture ÷ adaptive one, 1280x720, 2 threads: {' / '.join(scenes)}", [], [], ratios,
                  "traced pixels: " + ", ".join(f"{share:.1f} %" for share in shares), False)]


def shading(program, _):
    """Time from the ends of rays to colours, per pixel that shows the sky."""
    results = program.medians("bench_shading", "^sky/")
    times = {name: 1e9 * results[f"sky/{name}"]["per_pixel"] for name in ("galaxy", "hole", "kerr", "wormhole")}
    return [Claim("shading", "shading of a sky pixel without tracing, galaxy / hole / kerr, 1 thread, ns", [], [60] * 3,
                  [times["galaxy"], times["hole"], times["kerr"]],
                  f"medians of 5; wormhole, whose pixels near the throat cover long stripes of sky: "
                  f"{times['wormhole']:.0f} ns", False, "{:.0f}")]


ALL = (packet_over_scalar, packet_over_per_ray, culling, threads, peers, orbits, spin, whole_steps, shuffled, frames,
       straight, formulas, bounces, adaptive, shading)
