"""Compares the pixels of the installed Python module with those of the installed program.

Usage: installed_module.py KAGERO SCENE. The folder of the module is printed, because another copy would be found
first if PYTHONPATH contained it.
"""
import pathlib
import subprocess
import sys
import tempfile

import numpy as np
import kagero

program, scene = sys.argv[1:]
print("module:", pathlib.Path(kagero.__file__).parent)
options = {"film.size": [64, 48], "film.layers": ["steps"]}
with tempfile.TemporaryDirectory() as folder:
    output = pathlib.Path(folder, "steps.npy")
    subprocess.run([program, "render", scene, "--size", "64x48", "--layers", "steps", "-o", output, "--quiet"],
                   check=True)
    expected = np.load(output)
found = kagero.load(scene, options).render()["steps"]
assert found.dtype == expected.dtype and np.array_equal(found, expected)
linked = subprocess.run(["ldd", program], capture_output=True, text=True, check=True).stdout
assert "python" not in linked.lower(), linked
