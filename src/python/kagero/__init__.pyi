"""Type stubs of kagero. tests/python/stub_test.py compares them with the package."""
from collections.abc import Callable, Mapping, Sequence
from enum import IntEnum
from os import PathLike
from typing import Any

import numpy
from numpy.typing import NDArray

Progress = bool | Callable[[float, float], object] | None
Vectors = NDArray[numpy.float64] | Sequence[float] | Sequence[Sequence[float]]

version: str

class InputError(ValueError):
    """Raised if an input is invalid: a scene, an override, an option or an array.

    The message states what was read, where, what was expected, and what to do.

    Attributes:
        file: path of the scene file, or the override that contains the input; None if it is unknown.
        line: line in the file, counted from 1; None if it is unknown.
        column: column in the line, counted from 1; None if it is unknown.
        key: for a scene from a dict, the path of the key, such as "camera.fov"; otherwise None.
    """
    file: str | None
    line: int | None
    column: int | None
    key: str | None
    def __init__(self, message: str, file: str | None = None, line: int | None = None, column: int | None = None,
                 key: str | None = None) -> None: ...

class RunError(RuntimeError):
    """Raised if a run fails, for example because there is not enough memory."""

class RunWarning(UserWarning):
    """Category of the warnings that the command line prints, and of interrupted runs."""

class Status(IntEnum):
    """Status of a ray: why it has ended.

    hit: it hit a surface. escaped: it left the escape sphere. captured: it fell into a black hole. step_limit: it
    reached integrator.max_steps, the greatest number of bounces, or the stated parameter. failed: the column `reason`
    states why.
    """
    hit = 0
    escaped = 1
    captured = 2
    step_limit = 3
    failed = 4

class Result(dict[str, NDArray[Any]]):
    """The arrays of a run by name, with facts about the run.

    Attributes:
        interrupted: True if Ctrl-C has stopped the run, so that some pixels or rays are not finished.
        seconds: time of tracing and shading, without loading the scene.
        warnings: the warnings that the command line would print, as a list of str.
        report: for a picture, the dict that `kagero render --json` writes; otherwise None.
    """
    interrupted: bool
    seconds: float
    warnings: list[str]
    report: dict[str, Any] | None
    def __init__(self, arrays: Mapping[str, NDArray[Any]], facts: Mapping[str, Any]) -> None: ...

class Explanation(dict[str, Any]):
    """The dict of `kagero explain --json`. `str` and `print` give the text of `kagero explain`."""
    text: str
    def __init__(self, json_text: str, text: str) -> None: ...

class Scene:
    """A scene. It does not change; `override` returns another one.

    `kagero.load` and `kagero.scene` create scenes. Meshes and images are read when a function first needs them, and
    kept. All functions may be called from several threads, and scenes can be pickled.
    """
    @property
    def file(self) -> str:
        """The absolute path of the scene file. It ends with "<dict>" for a scene from a dict."""
    @property
    def text(self) -> str:
        """The text of the scene file, without overrides."""
    @property
    def overrides(self) -> tuple[str, ...]:
        """The overrides as a tuple of "key.path=value" texts."""
    def toml(self) -> str:
        """Returns the whole scene as TOML text, with overrides and defaults, as `kagero print` does."""
    def override(self, overrides: Mapping[str, Any] | None) -> Scene:
        """Returns the scene with changed keys.

        Args:
            overrides: values by key, for example {"space.rg": 0.2, "object.floor.color": [1, 0, 0]}. A value is a
                number, string, bool, list, dict or NumPy array. Lengths are in scene units, angles in degrees.

        Raises:
            InputError: a key is unknown, or a value is not legal. The message names the legal range.
        """
    def render(self, layers: Sequence[str] | None = None, *, threads: int | None = None, precision: str | None = None,
               isa: str | None = None, strategy: str | None = None, progress: Progress = None) -> Result:
        """Renders the scene and returns its layers, as `kagero render` does.

        Args:
            layers: names of layers (`kagero.layers()`), instead of film.layers of the scene.
            threads: number of threads, 1 to 4096; default: KAGERO_THREADS, or one per processor. The picture does not
                depend on it.
            precision: "auto", "double" or "float".
            isa: instruction set, such as "avx2"; default: KAGERO_ISA, or "auto".
            strategy: "auto", "scalar", "per-ray" or "packet".
            progress: True for a progress bar, or a function that is called with the finished share (0 to 1) and the
                elapsed seconds. The share rises once for trial rays, if there are any, and once for the picture.

        Returns:
            For each layer a float32 array with the shape (height, width), or (height, width, 3) for colours, which are
            linear RGB. Row 0 is at the top. `docs/reference/layers.md` states the units.

            After Ctrl-C, the result contains the finished pixels, and `interrupted` is True. Unfinished pixels are 0 in
            layers of colours and NaN in other layers.

        Raises:
            InputError: the scene or an option is invalid.
            RunError: the run failed.
            KeyboardInterrupt: Ctrl-C stopped the trial rays, before there was any result.
        """
    def trace(self, position: Vectors, direction: Vectors, *, observer: str | None = None, bounces: int | None = None,
              columns: Sequence[str] | None = None, parameter: float | None = None, threads: int | None = None,
              precision: str | None = None, isa: str | None = None, strategy: str | None = None,
              progress: Progress = None) -> Result:
        """Traces rays to their ends, as `kagero trace` does.

        Args:
            position: starts of the rays in scene units, an array of float64 in C order with the shape (N, 3), which is
                read in place, or (3,) for the same start of all rays. A list of numbers is converted.
            direction: directions of the rays with the same shapes; their lengths have no effect. Without an observer,
                they are directions of dq/dλ in scene coordinates.
            observer: "static", "zamo", "falling" or "coordinate": directions are those in its rest frame.
            bounces: number of surfaces through which rays continue, 0 to 1000. It adds the columns `bounces`, `medium`
                and `weight`.
            columns: names of the columns of the result; default: those of the CSV. "action" and "time" are integrals
                that are computed only where they are listed. Fewer columns take less time.
            parameter: value of λ at which every ray ends with the status step_limit. Excludes `bounces`.
            threads, precision, isa, strategy, progress: as for `render`.

        Returns:
            For each column an array of length N. The columns are those of the CSV (`docs/reference/outputs.md`):
            `x y z` is the end in scene units, `dx dy dz` the unit direction dq/dλ there, `px py pz pt` the momentum,
            `energy_error` the greatest relative error of H. Numbers are float64, counts int64. `status` contains the
            codes of kagero.Status as uint8; `object`, `reason` and `medium` are arrays of str.

            A ray that cannot be traced has the status failed and a reason. After Ctrl-C, this includes the rays that
            are not finished, and `interrupted` is True.

        Raises:
            InputError: the scene, an option or an array is invalid: a wrong type, shape or memory order, no vector, or
                a number that is not finite.
            RunError: the run failed.
        """
    def path(self, position: Vectors, direction: Vectors, *, observer: str | None = None, bounces: int | None = None,
             columns: Sequence[str] | None = None, parameter: float | None = None, every: float | None = None,
             threads: int | None = None, precision: str | None = None, isa: str | None = None,
             strategy: str | None = None, progress: Progress = None) -> Result:
        """Traces the paths of rays, as `kagero trace --path` does.

        Args:
            position, direction, observer, bounces, parameter: as for `trace`.
            columns: names of the columns of the result; default: those of the CSV.
            every: interval of λ between the points; default: one point after every step.
            threads, precision, isa, strategy, progress: as for `render`.

        Returns:
            For each column an array with one element per point, sorted by ray and step. `ray` is the index of the ray,
            `step` 0 is its start, `parameter` is λ, and `energy` the value of H. Positions are in scene units. Rays
            that cannot be traced have no points.

        Raises:
            InputError: as for `trace`.
        """
    def explain(self, *, threads: int | None = None, precision: str | None = None, isa: str | None = None,
                strategy: str | None = None) -> Explanation:
        """Returns the choices for a picture of the scene with their reasons, as `kagero explain` does."""
    def error(self, *, sample: tuple[int, int] = (64, 64), quick: bool = False, full: bool = False,
              threads: int | None = None, precision: str | None = None, isa: str | None = None,
              strategy: str | None = None, progress: Progress = None) -> dict[str, Any]:
        """Measures error against run time for the camera rays of the scene, as `kagero error` does.

        Args:
            sample: columns and rows of the grid of pixels whose rays are traced, each 1 to 4096.
            quick: True measures a few representative methods only, which takes less than a minute.
            full: True measures every method with the strategy scalar too.
            threads: number of threads of the timed runs; default: 1.
            precision, isa, strategy, progress: as for `render`; they select what is measured.

        Returns:
            The dict that `kagero error --json` writes. `curves` has one entry per method, with the errors in pixels and
            the nanoseconds per ray for each step.
        """
    def _repr_png_(self) -> bytes:
        """Returns a small picture as a PNG file, which notebooks show."""

def load(file: str | PathLike[str], overrides: Mapping[str, Any] | None = None) -> Scene:
    """Loads a scene file and applies overrides.

    Args:
        file: path of a TOML file. Relative paths in the scene start at its folder.
        overrides: values by key, for example {"space.rg": 0.2}, as for Scene.override.

    Raises:
        InputError: the file or an override is invalid; `file`, `line` and `column` are the position. The camera is
            checked by `render`, because `trace` needs none.
    """

def scene(tables: Mapping[str, Any], overrides: Mapping[str, Any] | None = None, *,
          directory: str | PathLike[str] = ".") -> Scene:
    """Makes a scene from nested dicts with the tables and keys of a scene file.

    Args:
        tables: for example {"space": {"hamiltonian": "kerr", "spin": 0.9}}. "object" and "medium" are lists of dicts.
        overrides: values by key, as for Scene.override.
        directory: folder at which relative paths of textures and meshes start.

    Raises:
        InputError: a key or value is invalid; `key` is its path, such as "object[0].radius".
    """

def sweep(scene: Scene, values: Mapping[str, Any], position: Vectors, direction: Vectors, **options: Any) -> Result:
    """Traces the same rays for several sets of parameters.

    Args:
        scene: the scene.
        values: for each key the list of its values, for example {"space.rg": [0.1, 0.2], "film.seed": [1, 2]}. Set i
            consists of the values i of all keys.
        position, direction: the rays, as for Scene.trace.
        options: the options of Scene.trace.

    Returns:
        The columns of Scene.trace. The arrays have the shape (sets, rays). After Ctrl-C, `interrupted` is True; the
        arrays then lack the sets that were not begun, or their rays have the status failed.

    If all keys are numbers of the table [space], the rays of different sets are traced together: each lane of a packet
    has its own parameters, and a ray costs hardly more than without a sweep. Otherwise, every set has a run of its own.

    Raises:
        InputError: the keys have different numbers of values, or as for Scene.override and Scene.trace.
    """

def hamiltonians() -> dict[str, dict[str, Any]]:
    """Returns the spaces as a dict of dicts by name, with formulas, sources and parameters."""

def integrators() -> dict[str, dict[str, Any]]:
    """Returns the integration methods as a dict of dicts by name, with orders and properties."""

def layers() -> dict[str, dict[str, Any]]:
    """Returns the layers of pictures as a dict of dicts by name, with a description of each."""
