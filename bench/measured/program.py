"""Runs kagero and its benchmark programs, and reads their reports."""
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
    """The executables of one build directory, run with one instruction set. `quick` reduces the number of rounds."""

    def __init__(self, build, isa, quick):
        self.build = pathlib.Path(build)
        self.isa = isa
        self.quick = quick
        self.rounds = 3 if quick else 7
        self.directory = pathlib.Path(tempfile.mkdtemp(prefix="kagero-performance-"))
        self.commands = []

    def record(self, words):
        """Adds a command to the list that is written to the data file; paths are relative to the source folder."""
        shown = shlex.join(words).replace(str(SOURCE) + "/", "").replace(str(self.directory) + "/", "")
        if shown not in self.commands:
            self.commands.append(shown)
        return shown

    def text(self, *arguments):
        """Returns the standard output of one run of kagero."""
        words = [*(str(a) for a in arguments), "--isa", self.isa]
        shown = self.record(["kagero", *words])
        done = subprocess.run([self.build / "bin" / "kagero", *words], capture_output=True, text=True)
        if done.returncode != 0:
            raise RuntimeError(f"{shown}: status {done.returncode}: {done.stderr.strip()}")
        return done.stdout

    def json(self, *arguments):
        """Returns the JSON report of one run of kagero."""
        return json.loads(self.text(*arguments, "--quiet", "--json"))

    @staticmethod
    def read_json(path):
        """Returns the content of a JSON file."""
        return json.loads(pathlib.Path(path).read_text())

    def benchmark(self, name, *arguments):
        """Runs a Google Benchmark program once and returns its list of results."""
        words = [str(a) for a in arguments]
        shown = self.record([name, *words])
        command = [self.build / "bin" / name, *words, "--benchmark_format=json"]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode != 0:
            raise RuntimeError(f"{shown}: status {done.returncode}: {done.stderr.strip()}")
        return json.loads(done.stdout)["benchmarks"]

    def medians(self, name, pattern):
        """Runs the benchmarks whose names match `pattern` as bench/run does; returns their medians by name."""
        self.record(["bench/run", *(["--quick"] if self.quick else []), pattern])
        loader = importlib.machinery.SourceFileLoader("bench_run", str(SOURCE / "bench" / "run"))
        bench = importlib.util.module_from_spec(importlib.util.spec_from_loader("bench_run", loader))
        loader.exec_module(bench)
        output = self.build / "bench" / f"{name}-performance.json"
        bench.run(self.build / "bin" / name, output, self.quick, pattern)
        return bench.medians(output)

    def compare(self, scene, *arguments):
        """Returns the report of `kagero compare` for a scene in scenes/."""
        size = [] if "--size" in arguments or "--equal-error" in arguments else ["--seconds", 0]
        return self.json("compare", SCENES / scene, "--rounds", self.rounds, *size, *arguments)

    def render(self, scene, *arguments):
        """Returns the report of a render, and the bytes of its picture."""
        picture = self.directory / "picture.pfm"
        report = self.json("render", SCENES / scene, "-o", picture, *arguments)
        return report, picture.read_bytes()

    def roofline(self, scene, *arguments):
        """Returns counted operations and the measured peak, from `kagero profile` with one thread."""
        directory = self.directory / "profile"
        return self.json("profile", SCENES / scene, "-o", directory, "--threads", 1, *arguments)["roofline"]

    def share_of_peak(self, scene, *arguments):
        """Returns the operations of tracing per second, in percent of the peak of multiply-adds on one thread."""
        return 100 * self.roofline(scene, *arguments)["share_of_peak"]

    def ratio(self, *measurements, rounds=0):
        """Calls two functions alternately, each of which returns a time. Returns the spread of the ratio first ÷ second
        over the rounds, by default `self.rounds`."""
        for measure in measurements:
            measure()
        ratios = []
        for _ in range(rounds or self.rounds):
            first, second = (measure() for measure in measurements)
            ratios.append(first / second)
        return Spread(ratios)


class Spread:
    """Median, minimum and maximum of a list of numbers."""

    def __init__(self, values):
        self.median, self.least, self.greatest = statistics.median(values), min(values), max(values)

    def __str__(self):
        return f"{self.least:.2f} to {self.greatest:.2f}"


def fastest_row(report, strategy, precision):
    """Returns the fastest row of a comparison with this strategy and precision, without auto-vectorized code."""
    rows = [r for r in report["rows"]
            if r["strategy"] == strategy and r["precision"] == precision and r["form"] != "auto-vectorized"]
    return max(rows, key=lambda r: r["speedup"], default=None)
