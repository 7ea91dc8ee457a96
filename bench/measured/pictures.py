"""Claims about strategies and pictures: packets against other strategies, culling, threads, pictures per second,
straight rays, adaptive pictures and shading."""
import hashlib

from .claim import DOUBLE, GENERAL, ROOM, Claim, general_share
from .program import SCENES, fastest_row

DEFAULT_TABLE = "Room 512x512, rg = 0.08, the default method of the general path"


def milliseconds(row):
    """Returns median, minimum and maximum of the time of a row of `kagero compare`."""
    s = row["seconds"]
    return f"{1e3 * s['median']:.1f} ms ({1e3 * s['min']:.1f} to {1e3 * s['max']:.1f})"


def default_width(report, precision):
    """Returns the packet row of the default width, which is the only one that is also measured as scanlines."""
    packets = [r for r in report["rows"] if r["precision"] == precision and r["strategy"] == "packet"]
    scanlines = {r["lanes"] for r in packets if r["shape"] == f"{r['lanes']}x1"}
    return next(r for r in packets if r["lanes"] in scanlines and r["shape"] != f"{r['lanes']}x1")


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
    claims.append(Claim("tracing-peak", "tracing of the room with `verlet`, double, % of the peak of multiply-adds",
                        [45], [60], claims[0].share[:1], "operations are counted in the programs", form="{:.0f}"))
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
                  "traced pixels: " + ", ".join(f"{share:.1f} %" for share in shares))]


def shading(program, _):
    """Time from the ends of rays to colours, per pixel that shows the sky."""
    results = program.medians("bench_shading", "^sky/")
    times = {name: 1e9 * results[f"sky/{name}"]["per_pixel"] for name in ("galaxy", "hole", "kerr", "wormhole")}
    return [Claim("shading", "shading of a sky pixel without tracing, galaxy / hole / kerr, 1 thread, ns", [], [60] * 3,
                  [times["galaxy"], times["hole"], times["kerr"]],
                  f"medians of 5; wormhole, whose pixels near the throat cover long stripes of sky: "
                  f"{times['wormhole']:.0f} ns", False, "{:.0f}")]


ALL = (packet_over_scalar, packet_over_per_ray, culling, threads, frames, straight, adaptive, shading)
