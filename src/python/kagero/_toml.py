"""Conversion of Python values to TOML text."""
import json
import math
import re

import numpy

from ._errors import InputError

_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+\Z")
_MAX_DEPTH = 16


def _key(name, path):
    if not isinstance(name, str):
        raise InputError(f"{path or 'the scene'}: a key is {_shown(name)}; expected a string", key=path or None)
    return name if _BARE_KEY.match(name) else _string(name, path)


def _join(path, name):
    name = name if isinstance(name, str) else _shown(name)
    return f"{path}.{name}" if path else name


def _shown(value):
    """Returns a value with its type, shortened, for messages. Never raises an exception of the value itself."""
    try:
        text = repr(value)
    except Exception:  # a __repr__ that fails must not hide the message
        text = "an object"
    if len(text) > 80:
        text = text[:77] + "..."
    return f"{text} (of type {type(value).__name__})"


def _string(text, path):
    try:
        text.encode("utf-8")
    except UnicodeEncodeError:
        raise InputError(f"{path}: {_shown(text)} contains a surrogate, which UTF-8 cannot encode",
                         key=path or None) from None
    # JSON escapes every control character but DEL, and TOML has the same escapes.
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def value_to_toml(value, path, depth=0):
    """Returns a number, string, bool, list, dict or array as TOML on one line. `path` names the key in messages."""
    if depth > _MAX_DEPTH:
        raise InputError(f"{path}: the value is nested more than {_MAX_DEPTH} times", key=path)
    if isinstance(value, (bool, numpy.bool_)):
        return "true" if value else "false"
    if isinstance(value, (int, numpy.integer)):
        number = int(value)
        if not -2**63 <= number < 2**63:
            raise InputError(f"{path}: {_shown(number)} does not fit into 64 bits", key=path)
        return str(number)
    if isinstance(value, (float, numpy.floating)):
        number = float(value)
        if math.isnan(number):
            return "nan"
        return repr(number) if math.isfinite(number) else ("inf" if number > 0 else "-inf")
    if isinstance(value, str):
        return _string(value, path)
    if hasattr(value, "__fspath__"):
        return _string(str(value), path)
    if isinstance(value, numpy.ndarray):
        value = value.tolist()
        if not isinstance(value, list):
            return value_to_toml(value, path, depth + 1)
    if isinstance(value, (list, tuple)):
        items = (value_to_toml(item, f"{path}[{i}]", depth + 1) for i, item in enumerate(value))
        return "[" + ", ".join(items) + "]"
    if isinstance(value, dict):
        items = (f"{_key(name, path)} = {value_to_toml(item, _join(path, name), depth + 1)}"
                 for name, item in value.items())
        return "{" + ", ".join(items) + "}"
    raise InputError(f"{path}: the value is {_shown(value)}; expected a number, a string, a bool, a list, a dict or a "
                     "NumPy array of numbers", key=path)


def dict_to_toml(scene):
    """Returns the text of a scene from nested dicts, and a list with the path of the key of each line.

    `scene["object"]` and `scene["medium"]` are lists of dicts, one for each [[object]] and [[medium]].
    """
    if not isinstance(scene, dict):
        raise InputError(f"the scene is {_shown(scene)}; expected a dict")
    lines, keys = [], []

    def add(line, path):
        lines.append(line)
        keys.append(path)

    def add_table(table, header, path, depth):
        if depth > _MAX_DEPTH:
            raise InputError(f"{path}: tables are nested more than {_MAX_DEPTH} times", key=path)
        tables = []
        for name, value in table.items():
            inner = _join(path, name)
            if isinstance(value, dict) or _is_list_of_tables(value):
                tables.append((name, value, inner))
            else:
                add(f"{_key(name, path)} = {value_to_toml(value, inner)}", inner)
        for name, value, inner in tables:
            inner_header = _join(header, _key(name, path))
            if isinstance(value, dict):
                add(f"[{inner_header}]", inner)
                add_table(value, inner_header, inner, depth + 1)
                continue
            for i, item in enumerate(value):
                add(f"[[{inner_header}]]", f"{inner}[{i}]")
                add_table(item, inner_header, f"{inner}[{i}]", depth + 1)

    add_table(scene, "", "", 0)
    return "\n".join(lines) + "\n", keys


def _is_list_of_tables(value):
    return isinstance(value, (list, tuple)) and len(value) > 0 and all(isinstance(item, dict) for item in value)


def overrides_to_texts(overrides):
    """Returns a dict of overrides as a list of "key.path=value" texts."""
    if overrides is None:
        return []
    if not isinstance(overrides, dict):
        raise InputError(f"overrides: {_shown(overrides)} is not a dict; expected for example {{\"space.rg\": 0.2}}")
    texts = []
    for key, value in overrides.items():
        if not isinstance(key, str):
            raise InputError(f"overrides: a key is {_shown(key)}; expected a string such as \"space.rg\"")
        _string(key, "overrides")
        texts.append(f"{key}={value_to_toml(value, key)}")
    return texts
