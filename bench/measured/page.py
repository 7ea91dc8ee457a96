"""Writes docs/performance.md from a data file."""
import textwrap


def verdict(row):
    """Compares the measured values of a claim with its target and minimum. Returns "target" or "minimum" if that is the
    highest bound that they reach, otherwise "**missed**", or "below target" for a claim without a minimum."""
    if not row["minimum"] and not row["target"]:
        return ""
    def meets(bounds):
        higher = row["higher_is_better"]
        return bool(row["measured"]) and all(m >= b if higher else m <= b for m, b in zip(row["measured"], bounds))
    if row["target"] and meets(row["target"]):
        return "target"
    if row["minimum"] and meets(row["minimum"]):
        return "minimum"
    return "**missed**" if row["minimum"] else "below target"


def numbers(values, form="{:g}"):
    """Returns the values as text, separated by slashes."""
    return " / ".join(form.format(v) for v in values) if values else "–"


def table(rows):
    """Returns the lines of the table of claims."""
    lines = ["| what is measured | minimum | target | measured | reaches | share of peak, % | "
             "least to greatest, method |", "|---|---|---|---|---|---|---|"]
    for row in rows:
        lines.append(f"| {row['what']} | {numbers(row['minimum'])} | {numbers(row['target'])} | "
                     f"{numbers(row['measured'], row['form'])} | {verdict(row)} | {numbers(row['share'], '{:.0f}')} | "
                     f"{row['detail']} |")
    return lines


def wrapped(text, indent=""):
    """Returns the lines of a paragraph. `indent` precedes all lines but the first."""
    return textwrap.wrap(text, 120, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False)


def missed(rows, causes):
    """Returns the lines of the section on missed targets. `causes` maps keys of claims to sentences."""
    lines = []
    for row in rows:
        if verdict(row) in ("**missed**", "below target"):
            lines += wrapped(f"- {row['what']}: {causes.get(row['key'], 'the cause has not been measured.')}", "  ")
    return ["", "## Causes of missed targets", "", *(lines or ["Every target is reached."])]


def disturbance(data):
    """Returns a line with the number of measurements that ended on a quiet processor; no line without such data."""
    quiet = data["quiet"]
    if not quiet:
        return []
    step = quiet["calibration_step_ns"]
    return [f"- disturbance: {quiet['undisturbed']} of {quiet['measurements']} measurements ended on a quiet processor "
            f"(calibration step: {step['min']:.1f} to {step['max']:.1f} ns per ray)"]


def write(path, data, name, causes, others):
    """Writes the page. `name` is the data file, `causes` maps keys of claims to one sentence each, and `others` are
    the data files of other machines."""
    link = f"[{name}](performance/{name})"
    lines = [
        "# Performance", "",
        *wrapped(f"`bench/performance` measured everything on this page, and wrote it and {link}. Do not edit the page."
                 " Each number is a median over interleaved rounds of one run, on one thread unless the row states "
                 "another number. The share of peak divides the counted floating-point operations of tracing per"
                 " second by the rate of independent multiply-adds, which the same run measures on the same"
                 " thread."), "",
        f"- machine: {data['machine']}; instruction set {data['isa']}",
        f"- compiler: {data['compiler']}; commit {data['commit']}; {data['date']}; {data['rounds']} rounds",
        *disturbance(data), "",
        *wrapped("The minimum must hold and the target is the aim; both were set for processors with eight doubles"
                 " per register (avx512). They are those of the measured commit; claims that were added later have no"
                 " row."), "",
        "## Results", "", *table(data["claims"]), *missed(data["claims"], causes), "",
        "## Further data", "",
        *wrapped(f"{link} contains the rows of every comparison of strategies, the times of gradients from the tape"
                 " and of hand-written gradients, Table 1 of Satoh (2003), and the list of all commands. "
                 "`bench/performance --only WORD` repeats the measurements whose name contains WORD. The names are"
                 " those of the functions in `bench/measured`. Measurements of other machines, or of earlier"
                 " commits:"), ""]
    for other in others:
        lines += wrapped(f"- [{other['file']}](performance/{other['file']}): {other['machine']}; {other['isa']}; "
                         f"commit {other['commit']}", "  ")
    path.write_text("\n".join(lines) + "\n")
