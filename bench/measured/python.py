"""The claim about Python: lists of rays take hardly longer than tracing alone."""
import os
import statistics
import subprocess

from . import rays
from .claim import Claim
from .program import SCENES

SIDE = 1000  # square root of the number of rays

# For each line of the input, traces the rays of the CSV file twice, and prints the seconds of the second call. `trace
# --json` traces them twice, too, and computes neither the error of H nor λ; these columns are left out here.
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
    print(time.perf_counter() - begin, flush=True)
    assert len(ends["status"]) == len(position)
'''


def list_of_rays(program, _):
    """Time of scene.trace in Python for 10⁶ rays divided by the time of tracing that `kagero trace --json` states for
    the same rays, with the default method, around a hole without and with spin."""
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
                return float(script.stdout.readline())
            # A call takes so long that the machine changes in the meantime: medians of times are compared.
            return [statistics.median(times) for times in zip(*((in_script(), alone()) for _ in range(program.rounds)))]
    times = [times_in(SCENES / f"{name}.toml") for name in ("hole", "kerr")]
    return [Claim("python-rays", "scene.trace in Python ÷ tracing alone (`trace --json`), 10⁶ rays, 2 "
                  "threads, without error of H and λ: hole / kerr", [1.05] * 2, [1.02] * 2,
                  [script / alone for script, alone in times],
                  "; ".join(f"{script:.2f} s and {alone:.2f} s" for script, alone in times), False)]


ALL = (list_of_rays,)
