"""Runs kagero and its benchmarks and reads their reports."""
import importlib.machinery
import importlib.util
import json
import pathlib
import statistics
import subprocess
import tempfile

SOURCE = pathlib.Path(__file__).resolve().parent.parent.parent
SCENES = SOURCE / "scenes"


def benchmarks(build, name, quick, wanted):
    """The medians, by name, of the benchmarks of a program that `wanted` matches, run by bench/run; none where it was not built."""
    binary = build / "bin" / name
    if not binary.exists():
        return {}
    loader = importlib.machinery.SourceFileLoader("bench_run", str(SOURCE / "bench" / "run"))
    bench = importlib.util.module_from_spec(importlib.util.spec_from_loader("bench_run", loader))
    loader.exec_module(bench)
    output = build / "bench" / f"{binary.name}-performance.json"
    bench.run(binary, output, quick, wanted)
    return bench.medians(output)


class Program:
    """The program of a build, one instruction set of it, and how patient to be."""

    def __init__(self, build, isa, quick):
        self.build = pathlib.Path(build)
        self.isa = isa
        self.quick = quick
        self.rounds = 3 if quick else 7
        self.directory = pathlib.Path(tempfile.mkdtemp(prefix="kagero-performance-"))
        self.commands = []

    def text(self, *arguments):
        """Standard output of one run. The command is kept for the page."""
        words = [str(a) for a in arguments]
        shown = "kagero " + " ".join(words).replace(str(SOURCE) + "/", "").replace(str(self.directory) + "/", "")
        if shown not in self.commands:
            self.commands.append(shown)
        done = subprocess.run([self.build / "bin" / "kagero", *words, "--isa", self.isa], capture_output=True, text=True)
        if done.returncode != 0:
            raise RuntimeError(f"{shown}: status {done.returncode}: {done.stderr.strip()}")
        return done.stdout

    def json(self, *arguments):
        return json.loads(self.text(*arguments, "--quiet", "--json"))

    def benchmark(self, name, *arguments):
        """What a program of Google Benchmark's measures, once each."""
        words = [str(a) for a in arguments]
        shown = " ".join([name, *words]).replace(str(self.directory) + "/", "")
        if shown not in self.commands:
            self.commands.append(shown)
        binary = self.build / "bin" / name
        if not binary.exists():
            raise RuntimeError(f"there is no {name} in {binary.parent}: build with -DKAGERO_BENCH=ON")
        done = subprocess.run([binary, *words, "--benchmark_format=json"], capture_output=True, text=True)
        if done.returncode != 0:
            raise RuntimeError(f"{shown}: status {done.returncode}: {done.stderr.strip()}")
        return json.loads(done.stdout)["benchmarks"]

    def compare(self, scene, *arguments):
        return self.json("compare", SCENES / scene, "--rounds", self.rounds, *arguments)

    def render(self, scene, *arguments):
        """The report of a render, and the bytes of its picture."""
        picture = self.directory / "picture.pfm"
        report = self.json("render", SCENES / scene, "-o", picture, *arguments)
        return report, picture.read_bytes()

    def ratio(self, *ways):
        """Calls each way, which return a time, in turn, round by round; medians, least and greatest of the first time over the second."""
        for way in ways:
            way()
        ratios = []
        for _ in range(self.rounds):
            first, second = (way() for way in ways)
            ratios.append(first / second)
        return Spread(ratios)


class Spread:
    def __init__(self, values):
        self.median, self.least, self.greatest = statistics.median(values), min(values), max(values)


def row_of(report, strategy, precision):
    """The quickest row of a comparison that has both, of code that the compiler has not vectorized by itself."""
    rows = [r for r in report["rows"] if r["strategy"] == strategy and r["precision"] == precision and r["form"] != "auto-vectorized"]
    return max(rows, key=lambda r: r["speedup"], default=None)
