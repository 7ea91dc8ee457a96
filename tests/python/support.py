"""Scenes and helpers for the tests of the Python module. The environment variable KAGERO_BUILD is the build folder."""
import os
import pathlib
import subprocess
import sys

BUILD = pathlib.Path(os.environ["KAGERO_BUILD"])
SOURCE = pathlib.Path(__file__).resolve().parent.parent.parent
SCENES = SOURCE / "scenes"
PROGRAM = BUILD / "bin" / "kagero"
sys.path.insert(0, str(BUILD / "python"))

HOLE = {"space": {"hamiltonian": "schwarzschild", "rg": 1},
        "camera": {"position": [-8, 0, 0], "look_at": [0, 0, 0], "up": [0, 0, 1]},
        "film": {"size": [32, 24]},
        "object": [{"name": "ball", "shape": "sphere", "center": [3, 0, 5], "radius": 1}]}

# A picture and a ray that take minutes, so that signals arrive while they are in progress.
LONG = {"space": {"hamiltonian": "kerr", "spin": 0.9},
        "integrator": {"method": "gauss16", "step": 0.001, "max_steps": 100000000},
        "camera": {"position": [-20, 0, 0], "look_at": [0, 0, 0], "up": [0, 0, 1]},
        "film": {"size": [512, 512]}}


def run_program(*arguments):
    """Returns what the program writes to stdout."""
    done = subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True, check=True)
    return done.stdout


def run_python(code, **options):
    """Runs Python code in a new process that can import this module."""
    environment = os.environ | {"PYTHONPATH": str(pathlib.Path(__file__).parent)}
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=environment, timeout=120,
                          **options)
