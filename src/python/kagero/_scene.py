"""Scenes."""
import json
import os

from . import _arguments as arguments
from . import _kagero
from ._errors import InputError
from ._progress import Progress
from ._results import Explanation, Result, finish, warn
from ._toml import _shown, dict_to_toml, overrides_to_texts

_DICT_NAME = "<dict>"  # the file name of a scene that is not a file


class Scene:
    """A scene. It does not change; `override` returns another one.

    `kagero.load` and `kagero.scene` create scenes. Meshes and images are read when a function first needs them, and
    kept. All functions may be called from several threads, and scenes can be pickled.
    """

    __slots__ = ("_core", "_keys", "__weakref__")

    def __init__(self):
        raise TypeError("use kagero.load(file) or kagero.scene(dict) to create a scene")

    @classmethod
    def _make(cls, path, text, overrides, keys=None):
        scene = object.__new__(cls)
        scene._keys = keys
        try:
            scene._core = _kagero.Scene(path, text, overrides)
        except InputError as error:
            raise scene._with_key(error) from None
        return scene

    def _with_key(self, error):
        """Adds the key to an error in a scene from a dict, whose lines the user has not seen."""
        if self._keys is None or not error.line or os.path.basename(error.file or "") != _DICT_NAME:
            return error
        # The column selects an element of a list, which the key does not name.
        is_whole_scene = (error.line, error.column) == (1, 1) and "the required key " in str(error)
        key = self._keys[error.line - 1] if error.line <= len(self._keys) and not is_whole_scene else ""
        message = error.args[0].split(": ", 1)[-1]
        return InputError(f"{key or 'the scene'}: {message}", error.file, error.line, error.column, key or None)

    def _call(self, function, *values):
        try:
            return function(*values)
        except InputError as error:
            raise self._with_key(error) from None

    @property
    def file(self):
        """The absolute path of the scene file. It ends with "<dict>" for a scene from a dict."""
        return self._core.path

    @property
    def text(self):
        """The text of the scene file, without overrides."""
        return self._core.text

    @property
    def overrides(self):
        """The overrides as a tuple of "key.path=value" texts."""
        return tuple(self._core.overrides)

    def toml(self):
        """Returns the whole scene as TOML text, with overrides and defaults, as `kagero print` does."""
        return self._core.toml()

    def override(self, overrides):
        """Returns the scene with changed keys.

        Args:
            overrides: values by key, for example {"space.rg": 0.2, "object.floor.color": [1, 0, 0]}. A value is a
                number, string, bool, list, dict or NumPy array. Lengths are in scene units, angles in degrees.

        Raises:
            InputError: a key is unknown, or a value is not legal. The message names the legal range.
        """
        return Scene._make(self.file, self.text, list(self.overrides) + overrides_to_texts(overrides), self._keys)

    def render(self, layers=None, *, threads=None, precision=None, isa=None, strategy=None, progress=None):
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
        names = arguments.words("layers", layers)
        options = arguments.run_options(threads, precision, isa, strategy)
        with Progress(progress) as callback:
            arrays, facts = self._call(self._core.render, names, options, callback)
        return finish(Result(arrays, facts), "unfinished pixels are 0 in layers of colours and NaN in other layers")

    def trace(self, position, direction, *, observer=None, bounces=None, columns=None, parameter=None, threads=None,
              precision=None, isa=None, strategy=None, progress=None):
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
        return self._trace(self._core.trace, position, direction, observer, bounces, columns, parameter, 0.0,
                           (threads, precision, isa, strategy), progress,
                           "rays that are not finished have the status failed")

    def path(self, position, direction, *, observer=None, bounces=None, columns=None, parameter=None, every=None,
             threads=None, precision=None, isa=None, strategy=None, progress=None):
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
        interval = 0.0
        if every is not None:
            interval = arguments.number("every", every, "a number greater than 0")
            if not interval > 0:
                raise InputError(f"every is {_shown(every)}; expected a number greater than 0")
        return self._trace(self._core.path_table, position, direction, observer, bounces, columns, parameter, interval,
                           (threads, precision, isa, strategy), progress,
                           "the paths of rays that are not finished are left out")

    def _trace(self, function, position, direction, observer, bounces, columns, parameter, every, options, progress,
               finished):
        rays = _rays(position, direction, observer, bounces, columns, parameter, every, options)
        with Progress(progress) as callback:
            arrays, facts = self._call(function, *rays, callback)
        return finish(Result(arrays, facts), finished, 5)

    def _sweep(self, sets, position, direction, *, observer=None, bounces=None, columns=None, parameter=None,
               threads=None, precision=None, isa=None, strategy=None, progress=None):
        """Traces rays once for each list of overrides. Returns the arrays and facts of each."""
        rays = _rays(position, direction, observer, bounces, columns, parameter, 0.0,
                     (threads, precision, isa, strategy))
        with Progress(progress) as callback:
            return self._call(self._core.sweep, sets, *rays, callback)

    def _sweep_numbers(self, values, position, direction, *, observer=None, columns=None, parameter=None, threads=None,
                       precision=None, isa=None, strategy=None, progress=None):
        """Traces rays for all values of parameters of the space. Returns flat arrays and the facts."""
        rays = _rays(position, direction, observer, None, columns, parameter, 0.0,
                     (threads, precision, isa, strategy))
        with Progress(progress) as callback:
            return self._call(self._core.sweep_numbers, list(values), list(values.values()), *rays, callback)

    def explain(self, *, threads=None, precision=None, isa=None, strategy=None):
        """Returns the choices for a picture of the scene with their reasons, as `kagero explain` does."""
        options = arguments.run_options(threads, precision, isa, strategy)
        text, json_text, remarks = self._call(self._core.explain, options, None)
        warn(remarks)
        return Explanation(json_text, text)

    def error(self, *, sample=(64, 64), quick=False, full=False, threads=None, precision=None, isa=None, strategy=None,
              progress=None):
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
        if not isinstance(sample, (list, tuple)) or len(sample) != 2:
            raise InputError(f"sample is {_shown(sample)}; expected the columns and rows of the grid, such as (64, 64)")
        size = tuple(arguments.whole_number(f"sample[{i}]", edge, 1, 4096) for i, edge in enumerate(sample))
        if arguments.flag("quick", quick) and arguments.flag("full", full):
            raise InputError("quick and full exclude each other; leave one of them out")
        options = arguments.run_options(threads, precision, isa, strategy)
        with Progress(progress) as callback:
            json_text, interrupted = self._call(self._core.error, size, bool(quick), arguments.flag("full", full),
                                                options, callback)
        if interrupted:
            warn(["interrupted; the results so far are returned"])
        return json.loads(json_text)

    def __repr__(self):
        facts = self._core.summary()
        width, height = facts["size"]
        parts = [repr(os.path.basename(self.file)), f"space {facts['hamiltonian']}"]
        for count, one, several in ((facts["objects"], "object", "objects"), (facts["media"], "medium", "media")):
            if count:
                parts.append(f"{count} {one if count == 1 else several}")
        parts += [f"{width} x {height} pixels", "layers " + ", ".join(facts["layers"])]
        shown = [text if len(text) <= 60 else text[:57] + "..." for text in self.overrides]
        if len(shown) > 4:
            shown = shown[:4] + [f"{len(self.overrides) - 4} more"]
        if shown:
            parts.append("overrides " + ", ".join(shown))
        return f"<kagero.Scene {'; '.join(parts)}>"

    def _repr_png_(self):
        """Returns a small picture as a PNG file, which notebooks show."""
        return self._call(self._core.png, 320)

    def __reduce__(self):
        return Scene._make, (self.file, self.text, list(self.overrides), self._keys)


def _rays(position, direction, observer, bounces, columns, parameter, every, options):
    """Returns the checked arguments of a list of rays, in the order of the functions of the extension module."""
    position = arguments.vectors("position", position)
    direction = arguments.vectors("direction", direction)
    if bounces is not None:
        bounces = arguments.whole_number("bounces", bounces, 0, 1000)
    if parameter is not None:
        parameter = arguments.number("parameter", parameter)
    request = _kagero.RayRequest(observer=arguments.word("observer", observer, ""), bounces=bounces,
                                 parameter=parameter, every=every)
    return position, direction, request, arguments.words("columns", columns), arguments.run_options(*options)


def load(file, overrides=None):
    """Loads a scene file and applies overrides.

    Args:
        file: path of a TOML file. Relative paths in the scene start at its folder.
        overrides: values by key, for example {"space.rg": 0.2}, as for Scene.override.

    Raises:
        InputError: the file or an override is invalid; `file`, `line` and `column` are the position. The camera is
            checked by `render`, because `trace` needs none.
    """
    if not isinstance(file, (str, os.PathLike)):
        raise InputError(f"file is {_shown(file)}; expected the path of a scene file as str or pathlib.Path")
    path = os.fspath(file)
    if not isinstance(path, str):
        path = os.fsdecode(path)
    arguments.word("file", path, None)
    if not path or "\0" in path:
        raise InputError(f"file is {_shown(file)}; expected the path of a scene file")
    return Scene._make(os.path.abspath(path), None, overrides_to_texts(overrides))


def scene(tables, overrides=None, *, directory="."):
    """Makes a scene from nested dicts with the tables and keys of a scene file.

    Args:
        tables: for example {"space": {"hamiltonian": "kerr", "spin": 0.9}}. "object" and "medium" are lists of dicts.
        overrides: values by key, as for Scene.override.
        directory: folder at which relative paths of textures and meshes start.

    Raises:
        InputError: a key or value is invalid; `key` is its path, such as "object[0].radius".
    """
    if not isinstance(directory, (str, os.PathLike)):
        raise InputError(f"directory is {_shown(directory)}; expected the path of a folder as str or pathlib.Path")
    folder = os.fsdecode(directory)
    arguments.word("directory", folder, None)
    text, keys = dict_to_toml(tables)
    path = os.path.join(os.path.abspath(folder), _DICT_NAME)
    return Scene._make(path, text, overrides_to_texts(overrides), keys)
