"""The claim about Python: lists of rays take hardly longer than tracing alone."""
import os
import statistics
import subprocess

from . import rays
from .claim import Claim
from .program import SCENES, Spread

SIDE = 1000  # square root of the number of rays

# For each line of the input, traces the rays of the CSV file twice. Prints the seconds of the second call, and those of
# tracing alone that its result states. `trace --json` traces the rays twice, too, and computes neither the error of H
# nor λ; these columns are left out here.
SCRIPT = '''
import sys, time
import numpy, kagero
table = numpy.loadtxt(sys.argv[2], delimiter=",", skiprows=1)
position, direction = (numpy.ascontiguousarray(half) for half in (table[:, :3], table[:, 3:]))
scene = kagero.load(sys.argv[1])
columns = "status object x y z dx dy dz px py pz pt steps gradients reason".split()
for _ in sys.stdin:
    for _ in range(2):
        begin = time.perf_counter()
        ends = scene.trace(position, direction, columns=columns, threads=2)
    print(time.perf_counter() - begin, ends.seconds, flush=True)
    assert len(ends["status"]) == len(position)
'''


def list_of_rays(program, _):
    """Time of scene.trace in Python for 10⁶ rays divided by the time of tracing alone, with the default method, around
    a hole without and with spin. The time of tracing is that which the result of the same call states, because the
    speed of a machine changes from call to call. `kagero trace --json` states the same time for its own run; a second
    row compares the two."""
    path = rays.camera_rays(program.directory / "million.csv", SIDE)
    environment = os.environ | {"PYTHONPATH": str(program.build / "python"), "KAGERO_ISA": program.isa}
    def times_in(scene):
        program.record(["python3", "-c", "...", scene.name, path.name])
        def alone():
            report = program.json("trace", scene, "--rays", path, "--threads", 2, "--repeat", 1)
            return 1e-9 * report["ns_per_ray"]["median"] * SIDE * SIDE
        with subprocess.Popen(["/usr/bin/python3", "-c", SCRIPT, scene, path], env=environment, text=True,
                              stdin=subprocess.PIPE, stdout=subprocess.PIPE) as script:
            def in_script():
                print(file=script.stdin, flush=True)
                return [float(seconds) for seconds in script.stdout.readline().split()]
            return [(*in_script(), alone()) for _ in range(program.rounds)]
    times = [times_in(SCENES / f"{name}.toml") for name in ("hole", "kerr")]
    whole = [Spread([call / tracing for call, tracing, _ in rounds]) for rounds in times]
    medians = [[statistics.median(column) for column in zip(*rounds)] for rounds in times]
    by_program = [tracing / alone for _, tracing, alone in medians]
    return [Claim("python-rays",
                  "scene.trace in Python ÷ tracing alone, 10⁶ rays, 2 threads, without error of H and λ: hole / kerr",
                  [1.05] * 2, [1.02] * 2, [ratio.median for ratio in whole], "; ".join(map(str, whole)), False,
                  "{:.3f}"),
            Claim("python-tracing", "tracing alone in Python ÷ in `kagero trace --json`, medians, the same rays: "
                  "hole / kerr", [], [], by_program, "", False)]


ALL = (list_of_rays,)
