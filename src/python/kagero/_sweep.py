"""Traces of the same rays for several values of parameters."""
import numbers

import numpy

from ._errors import InputError
from ._results import Result, finish
from ._toml import _shown, overrides_to_texts


def _values(key, values):
    if isinstance(values, numpy.ndarray):
        values = values.tolist()
    if isinstance(values, range):
        values = list(values)
    if not isinstance(values, (list, tuple)) or not values:
        raise InputError(f"values of {_shown(key)}: {_shown(values)};"
                         " expected a list or an array with at least one value")
    return list(values)


def _is_space_number(key, values):
    # The sets of a formula have plans of their own in any case; those with its constants have reasons of their own.
    return (isinstance(key, str) and key.startswith("space.") and key.count(".") == 1
            and all(isinstance(value, numbers.Real) and not isinstance(value, bool) for value in values))


def sweep(scene, values, position, direction, **options):
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
    from ._scene import Scene
    if not isinstance(scene, Scene):
        raise InputError(f"scene is {_shown(scene)}; expected a kagero.Scene")
    if not isinstance(values, dict) or not values:
        raise InputError(f"values is {_shown(values)}; expected a dict such as {{\"space.rg\": [0.1, 0.2]}}")
    lists = {key: _values(key, each) for key, each in values.items()}
    counts = {key: len(each) for key, each in lists.items()}
    if len(set(counts.values())) > 1:
        raise InputError(f"values: the keys have different numbers of values, {counts}; expected equal numbers")
    if not options.get("bounces") and all(_is_space_number(key, each) for key, each in lists.items()):
        options.pop("bounces", None)
        floats = {key: [float(value) for value in each] for key, each in lists.items()}
        columns, facts = scene._sweep_numbers(floats, position, direction, **options)
        count = next(iter(counts.values()))
        arrays = {name: column.reshape((count, -1) + column.shape[1:]) for name, column in columns.items()}
        return finish(Result(arrays, facts), "the rays that were not traced have the status failed")
    sets = [overrides_to_texts({key: each[i] for key, each in lists.items()})
            for i in range(next(iter(counts.values())))]
    runs = scene._sweep(sets, position, direction, **options)
    arrays = {name: numpy.stack([columns[name] for columns, _ in runs]) for name in runs[0][0]}
    facts = [each for _, each in runs]
    warnings = list(dict.fromkeys(text for each in facts for text in each["warnings"]))
    result = Result(arrays, {"interrupted": any(each["interrupted"] for each in facts),
                             "seconds": sum(each["seconds"] for each in facts), "warnings": warnings})
    return finish(result, "the arrays contain only the sets that were begun")
