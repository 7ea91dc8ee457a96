"""Claims about integration: rays at equal error against Boost.Odeint, near-critical rays, orbits, spinning holes, and
steps without a scene."""
import math
import re
import statistics

from . import rays
from .claim import DOUBLE, GENERAL, ROOM, Claim
from .program import SCENES

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
                  "(packets, from H), 2048 rays, errors ≤ 1.6e-5 / 1e-8 / 8e-12", [10, 14, 14], [13, 18, 20], [])
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
    bare = Claim("bare", "render ÷ integrator alone, time per gradient, `verlet` / `gauss8`", [1.25, 1.15],
                 [1.10, 1.08], [], "", False)
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
            Claim("peak", "best step from the tape, double, % of the peak of multiply-adds", [62], [72], [max(shares)],
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


ALL = (peers, orbits, spin, whole_steps, shuffled)
