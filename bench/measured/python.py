"""The claim about Python: lists of rays take hardly longer than tracing alone."""
import os
import statistics
import subprocess

from . import rays
from .claim import Claim
from .program import SCENES

SIDE = 1000  # square root of the number of rays

# Prints the seconds of each call. The rays are those of the CSV file.
SCRIPT = '''
import sys, time
import numpy, kagero
table = numpy.loadtxt(sys.argv[2], delimiter=",", skiprows=1)
position, direction = (numpy.ascontiguousarray(half) for half in (table[:, :3], table[:, 3:]))
scene = kagero.load(sys.argv[1])
for _ in range(int(sys.argv[3])):
    begin = time.perf_counter()
    ends = scene.trace(position, direction, threads=2)
    print(time.perf_counter() - begin, flush=True)
    assert len(ends["status"]) == len(position)
'''


def list_of_rays(program, _):
    """Time of scene.trace in Python for 10⁶ rays divided by the time of tracing that `kagero trace --json` states for
    the same rays, with the default method."""
    path = rays.camera_rays(program.directory / "million.csv", SIDE)
    scene = SCENES / "hole.toml"
    environment = os.environ | {"PYTHONPATH": str(program.build / "python"), "KAGERO_ISA": program.isa}
    program.record(["python3", "-c", "...", scene.name, path.name])
    def in_python(calls):
        done = subprocess.run(["/usr/bin/python3", "-c", SCRIPT, scene, path, str(calls)], env=environment, check=True,
                              capture_output=True, text=True)
        return [float(line) for line in done.stdout.split()]
    ratios = []
    for _ in range(program.rounds):
        report = program.json("trace", scene, "--rays", path, "--threads", 2, "--repeat", 5)
        seconds = 1e-9 * report["ns_per_ray"]["median"] * SIDE * SIDE
        ratios.append(statistics.median(in_python(6)[1:]) / seconds)  # the first call also makes the plan
    return [Claim("python-rays", "scene.trace in Python ÷ tracing alone (`trace --json`), 10⁶ rays, 2 threads", [1.05],
                  [1.02], [statistics.median(ratios)], f"{min(ratios):.2f} to {max(ratios):.2f}", False)]


ALL = (list_of_rays,)
