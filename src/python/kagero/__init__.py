"""kagero renders scenes in which light bends, and traces single rays through them.

    import kagero
    scene = kagero.load("scenes/room.toml", {"space.rg": 0.2})
    color = scene.render()["color"]                        # float32, (height, width, 3), linear
    ends = scene.trace([0, -0.85, 0.12], [1, 0, 0])        # columns of `kagero trace`

Every function makes the choices of the command line, and gives the same numbers and messages.
"""
import os as _os

try:
    import numpy as _numpy
except ImportError as error:
    raise ImportError("kagero needs NumPy; install the package python3-numpy, or run `pip install numpy`") from error

from . import _kagero
from ._errors import InputError, RunError, RunWarning
from ._results import Explanation, Result, Status
from ._scene import Scene, load, scene
from ._sweep import sweep

version = __version__ = _kagero.version

# The threads of TBB do not exist in a forked process. They are ended before, so that the new process starts its own.
_os.register_at_fork(before=_kagero.before_fork, after_in_child=_kagero.after_fork_in_child)


def _listing(topic):
    import json
    isa = _os.environ.get("KAGERO_ISA") or "auto"
    return {item["name"]: item for item in json.loads(_kagero.listing(topic, isa))[topic]}


def hamiltonians():
    """Returns the spaces as a dict of dicts by name, with formulas, sources and parameters."""
    return _listing("hamiltonians")


def integrators():
    """Returns the integration methods as a dict of dicts by name, with orders and properties."""
    return _listing("integrators")


def layers():
    """Returns the layers of pictures as a dict of dicts by name, with a description of each."""
    return _listing("layers")


__all__ = ["Explanation", "InputError", "Result", "RunError", "RunWarning", "Scene", "Status", "hamiltonians",
           "integrators", "layers", "load", "scene", "sweep", "version"]
