"""docs/performance.md."""
import datetime
import pathlib
import platform
import subprocess

from .program import SOURCE

# Satoh (c. 2003), Table 1, PC B: Intel Xeon 2.8 GHz; seconds by r_g, picture, processors.
PAPER = {(0.00, 50, 1): 38, (0.00, 50, 2): 33, (0.01, 50, 1): 128, (0.01, 50, 2): 88,
         (0.00, 100, 1): 162, (0.00, 100, 2): 137, (0.01, 100, 1): 528, (0.01, 100, 2): 349}


def doubles_in_a_register(tables):
    rows = (r for t in tables.values() for r in t["rows"] if (r["strategy"], r["precision"]) == ("packet", "double") and not r["form"])
    return next((r["lanes"] // r["registers"] for r in rows), None)


def paper_table(program):
    lines = ["| r_g | pixels | threads | paper, s | kagero, ms (median, least to greatest) | times faster |", "|---|---|---|---|---|---|"]
    for (rg, side, threads), paper in PAPER.items():
        times = sorted(program.render("room.toml", "-D", f"space.rg={rg}", "--size", f"{side}x{side}", "--threads", threads)[0]["seconds"]
                       for _ in range(program.rounds + 2))
        median = times[len(times) // 2]
        lines.append(f"| {rg:.2f} | {side}x{side} | {threads} | {paper} | {1e3 * median:.2f} ({1e3 * times[0]:.2f} to {1e3 * times[-1]:.2f}) | "
                     f"{paper / median:,.0f} |")
    return lines


def verdict(claim):
    if not claim.measured or not (claim.must or claim.aim):
        return ""
    def holds(bounds):
        return all(m >= b if claim.more else m <= b for m, b in zip(claim.measured, bounds))
    if claim.aim and holds(claim.aim):
        return "aim"
    if claim.must:
        return "must" if holds(claim.must) else "**misses**"
    return "below the aim"


def numbers(values, form):
    return " / ".join(form.format(v) for v in values) if values else "—"


def claim_table(claims, notes):
    lines = ["| claim | must | aim | measured | reaches | spread, and how |", "|---|---|---|---|---|---|"]
    for claim in claims:
        lines.append(f"| {claim.what} | {numbers(claim.must, '{:g}')} | {numbers(claim.aim, '{:g}')} | {numbers(claim.measured, claim.form)} | "
                     f"{verdict(claim)} | {claim.spread} |")
    missed = [c for c in claims if verdict(c) in ("**misses**", "below the aim") or (c.must and not c.measured)]
    if missed:
        lines += ["", "What misses, and why as far as that was measured:", ""]
        lines += [f"- {c.what}: {notes.get(c.key, 'cause not measured yet')}" for c in missed]
    return lines


def comparison_table(report):
    lines = ["| isa | strategy | method | step | precision | lanes | registers | shape | ms | least to greatest | speedup | occupancy | difference | flips |",
             "|---|---|---|---|---|---|---|---|---|---|---|---|---|---|"]
    for r in report["rows"]:
        s, name = r["seconds"], r["strategy"] + (f" {r['form']}" if r["form"] else "")
        lines.append(f"| {r['isa']} | {name} | {r['method']} | {r['step']:g} | {r['precision']} | {r['lanes']} | {r['registers']} | {r['shape']} | "
                     f"{1e3 * s['median']:.2f} | {1e3 * s['min']:.2f} to {1e3 * s['max']:.2f} | {r['speedup']:.2f} | {r['lane_occupancy']:.3f} | "
                     f"{r['max_difference']:.2g} | {r['flips']} |")
    return lines


def processor():
    lines = pathlib.Path("/proc/cpuinfo").read_text().splitlines()
    def field(name):
        return next((line.split(":", 1)[1].strip() for line in lines if line.split("\t", 1)[0] == name), "?")
    return f"{field('model name')} (family {field('cpu family')}, model {field('model')})"


def machine():
    threads = pathlib.Path("/proc/cpuinfo").read_text().count("processor\t")
    return f"{processor()}, {threads} threads, {platform.system()} {platform.release()}"


def commit():
    done = subprocess.run(["git", "-C", SOURCE, "describe", "--always", "--dirty"], capture_output=True, text=True)
    return done.stdout.strip() or "?"


def write(path, program, claims, tables, paper, gradients, notes, story):
    doubles = doubles_in_a_register(tables)
    compilers = {t["compiler"] for t in tables.values()} or {"not asked: no table was made"}
    lines = ["# Performance", "", "Written by `bench/performance`; do not edit. Ratios are medians over interleaved rounds inside one run, one thread unless said;",
             "absolute times move with the machine.", "",
             f"- machine: {machine()}", f"- compiler: {', '.join(sorted(compilers))}; instruction set {program.isa}",
             f"- commit {commit()}, {datetime.date.today().isoformat()}, {program.rounds} rounds", *story, "",
             "What must hold, and what is aimed at, was set for processors with eight doubles in a register (avx512)"
             f"{'' if doubles in (None, 8) else f'; here there are {doubles}'}.", "", "## Claims", ""]
    lines += claim_table(claims, notes)
    if paper:
        lines += ["", "## The paper's Table 1", "", "The paper's machine is its PC B, an Intel Xeon 2.8 GHz. Ours by the scene's defaults, tracing and shading, one process: in the plane of each",
                  "ray's orbit, and at r_g = 0 one straight line per ray. How many times faster is machine, method and program together; the paper's own",
                  "recipe, `satoh4-nine`, is in the last table.", ""]
        lines += paper
    if gradients:
        lines += ["", "## The derivative program against the shortest hand-written code", "", "Time of the reverse tape over that of the hand-written gradient; 1.00 is hand-written speed.", ""]
        lines += gradients
    lines += ["", "## Strategies side by side", "", "Speedup over scalar double of the same instruction set; `registers` 1 is SIMD alone, 2 and 4 add instruction-level",
              "parallelism. Scalar is built without the compiler's vectorizers, `auto-vectorized` with them."]
    for title, report in tables.items():
        lines += ["", f"### {title}", ""] + comparison_table(report)
        lines += [""] + [f"- left out: {o['what']}: {o['why']}" for o in report["left_out"]] if report["left_out"] else []
    lines += ["", "## Commands", "", "bench/measured/rays.py writes the lists of rays, claims.py `formula-room.toml`; `bench/performance --only WORD` repeats what is named in", "bench/measured/claims.py: `--only peers`.", "", "```sh"] + program.commands + ["```", ""]
    path.write_text("\n".join(lines))
