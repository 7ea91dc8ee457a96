"""Runs kagero and its benchmarks and reads their reports."""
import importlib.machinery
import importlib.util
import json
import pathlib
import shlex
import statistics
import subprocess
import tempfile

SOURCE = pathlib.Path(__file__).resolve().parent.parent.parent
SCENES = SOURCE / "scenes"


class Program:
    """The program of a build, one instruction set of it, and how patient to be."""

    def __init__(self, build, isa, quick):
        self.build = pathlib.Path(build)
        self.isa = isa
        self.quick = quick
        self.rounds = 3 if quick else 7
        self.directory = pathlib.Path(tempfile.mkdtemp(prefix="kagero-performance-"))
        self.commands = []

    def keep(self, words):
        """For the page: what was run, from the root of the source and with the lists of rays there."""
        shown = shlex.join(words).replace(str(SOURCE) + "/", "").replace(str(self.directory) + "/", "")
        if shown not in self.commands:
            self.commands.append(shown)
        return shown

    def text(self, *arguments):
        """Standard output of one run."""
        words = [*(str(a) for a in arguments), "--isa", self.isa]
        shown = self.keep(["kagero", *words])
        done = subprocess.run([self.build / "bin" / "kagero", *words], capture_output=True, text=True)
        if done.returncode != 0:
            raise RuntimeError(f"{shown}: status {done.returncode}: {done.stderr.strip()}")
        return done.stdout

    def json(self, *arguments):
        return json.loads(self.text(*arguments, "--quiet", "--json"))

    def benchmark(self, name, *arguments):
        """What a program of Google Benchmark's measures, once each."""
        words = [str(a) for a in arguments]
        shown = self.keep([name, *words])
        done = subprocess.run([self.build / "bin" / name, *words, "--benchmark_format=json"], capture_output=True, text=True)
        if done.returncode != 0:
            raise RuntimeError(f"{shown}: status {done.returncode}: {done.stderr.strip()}")
        return json.loads(done.stdout)["benchmarks"]

    def medians(self, name, wanted):
        """The medians, by name, of the benchmarks of a program that `wanted` matches, as bench/run measures them."""
        self.keep(["bench/run", *(["--quick"] if self.quick else []), wanted])
        loader = importlib.machinery.SourceFileLoader("bench_run", str(SOURCE / "bench" / "run"))
        bench = importlib.util.module_from_spec(importlib.util.spec_from_loader("bench_run", loader))
        loader.exec_module(bench)
        output = self.build / "bench" / f"{name}-performance.json"
        bench.run(self.build / "bin" / name, output, self.quick, wanted)
        return bench.medians(output)

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
