"""Results of runs: dicts with further attributes."""
import enum
import json
import warnings as _warnings

from . import _kagero
from ._errors import RunWarning

Status = enum.IntEnum("Status", {name: code for code, name in enumerate(_kagero.status_names())}, module="kagero")
Status.__doc__ = """Status of a ray: why it has ended.

hit: it hit a surface. escaped: it left the escape sphere. captured: it fell into a black hole. step_limit: it
reached integrator.max_steps, the greatest number of bounces, or the stated parameter. failed: the column `reason`
states why.
"""


class Result(dict):
    """The arrays of a run by name, with facts about the run.

    Attributes:
        interrupted: True if Ctrl-C has stopped the run, so that some pixels or rays are not finished.
        seconds: time of tracing and shading, without loading the scene.
        warnings: the warnings that the command line would print, as a list of str.
        report: for a picture, the dict that `kagero render --json` writes; otherwise None.
    """

    def __init__(self, arrays, facts):
        super().__init__(arrays)
        self.interrupted = facts["interrupted"]
        self.seconds = facts["seconds"]
        self.warnings = facts["warnings"]
        self.report = json.loads(facts["json"]) if "json" in facts else None

    def __reduce__(self):
        return _restore, (dict(self), dict(self.__dict__))

    def __repr__(self):
        arrays = ", ".join(f"{name}: {array.dtype}{list(array.shape)}" for name, array in self.items())
        return f"<kagero.Result {{{arrays}}}{' interrupted' if self.interrupted else ''}>"


def _restore(arrays, attributes):
    result = Result.__new__(Result)
    result.update(arrays)
    result.__dict__.update(attributes)
    return result


class Explanation(dict):
    """The dict of `kagero explain --json`. `str` and `print` give the text of `kagero explain`."""

    def __init__(self, json_text, text):
        super().__init__(json.loads(json_text))
        self.text = text

    def __str__(self):
        return self.text

    def __reduce__(self):
        return Explanation, (json.dumps(dict(self)), self.text)


def warn(texts, stacklevel=3):
    """Issues warnings for the caller of the function that calls this one."""
    for text in texts:
        _warnings.warn(text, RunWarning, stacklevel=stacklevel)


def finish(result, finished, stacklevel=4):
    """Issues the warnings of a result. `finished` states what an interrupted run has left."""
    warn(result.warnings, stacklevel)
    if result.interrupted:
        warn([f"interrupted; {finished}"], stacklevel)
    return result
