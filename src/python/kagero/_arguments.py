"""Checks of the arguments of functions."""
import os

import numpy

from . import _kagero
from ._errors import InputError
from ._toml import _shown

_MAX_THREADS = 4096


def vectors(name, value):
    """Returns positions or directions as an array of float64 in C order with the shape (3,) or (N, 3).

    An array that has this form is returned itself, so that its numbers are read in place. Lists and tuples of numbers
    are converted. Any other array raises InputError, because a conversion would copy it unnoticed.
    """
    expected = "expected an array of float64 in C order with the shape (N, 3), or (3,) for one vector"
    if isinstance(value, (list, tuple)):
        try:
            converted = numpy.array(value)
        except Exception as error:  # an element of the list can raise any exception
            raise InputError(f"{name}: the list is no rectangular array of numbers ({error}); {expected}") from None
        if converted.size and converted.dtype.kind not in "iuf":
            raise InputError(f"{name} is {_shown(value)}; expected numbers")
        value = converted.astype(numpy.float64)
    if not isinstance(value, numpy.ndarray):
        raise InputError(f"{name} is {_shown(value)}; {expected}")
    if value.dtype != numpy.float64 or not value.dtype.isnative:
        raise InputError(f"{name} has the type {value.dtype}; {expected}. `{name}.astype(numpy.float64)` converts it")
    if value.size == 0:
        raise InputError(f"{name} has the shape {value.shape} and is empty; {expected}, with at least one vector")
    if value.ndim not in (1, 2) or value.shape[-1] != 3:
        raise InputError(f"{name} has the shape {value.shape}; {expected}")
    if not value.flags.c_contiguous:
        raise InputError(f"{name} has the strides {value.strides}, which are not those of C order; {expected}. "
                         f"`numpy.ascontiguousarray({name})` makes a copy in C order")
    if not value.flags.aligned:
        raise InputError(f"{name} is not aligned in memory; {expected}. `{name}.copy()` makes an aligned copy")
    return value.view(numpy.ndarray)


def number(name, value, expected="a number"):
    """Returns a number as float."""
    if isinstance(value, (bool, numpy.bool_)) or not isinstance(value, (int, float, numpy.integer, numpy.floating)):
        raise InputError(f"{name} is {_shown(value)}; expected {expected}")
    try:
        return float(value)
    except OverflowError:
        raise InputError(f"{name} is {_shown(value)}, which is too large; expected {expected}") from None


def whole_number(name, value, least, greatest):
    """Returns a whole number in a range as int."""
    if isinstance(value, (bool, numpy.bool_)) or not isinstance(value, (int, numpy.integer)) \
            or not least <= value <= greatest:
        raise InputError(f"{name} is {_shown(value)}; expected a whole number from {least} to {greatest}")
    return int(value)


def word(name, value, default):
    """Returns a string; `default` for None."""
    if value is None:
        return default
    if not isinstance(value, str):
        raise InputError(f"{name} is {_shown(value)}; expected a string")
    try:
        value.encode("utf-8")
    except UnicodeEncodeError:
        raise InputError(f"{name} is {_shown(value)}, which is not valid Unicode; expected a string") from None
    return value


def words(name, value):
    """Returns a list of strings from a sequence of strings; [] for None."""
    if value is None:
        return []
    if isinstance(value, str) or not isinstance(value, (list, tuple)):
        raise InputError(f"{name} is {_shown(value)}; expected a list of strings")
    texts = [word(f"{name}[{i}]", item, None) for i, item in enumerate(value)]
    if None in texts or not texts:
        raise InputError(f"{name} is {_shown(value)}; expected a list with at least one string")
    return texts


def flag(name, value):
    """Returns a bool."""
    if not isinstance(value, (bool, numpy.bool_)):
        raise InputError(f"{name} is {_shown(value)}; expected True or False")
    return bool(value)


def run_options(threads, precision, isa, strategy):
    """Returns the options of a run. As for the command line, KAGERO_THREADS and KAGERO_ISA are defaults."""
    name = "threads"
    if threads is None and os.environ.get("KAGERO_THREADS"):
        name, text = "KAGERO_THREADS", os.environ["KAGERO_THREADS"]
        threads = int(text) if text.isascii() and text.isdigit() and len(text) < 10 else text
    count = 0 if threads is None else whole_number(name, threads, 1, _MAX_THREADS)
    isa = word("isa", isa, os.environ.get("KAGERO_ISA") or "auto")
    return _kagero.RunOptions(isa=isa, strategy=word("strategy", strategy, "auto"),
                              precision=word("precision", precision, "auto"), threads=count)
