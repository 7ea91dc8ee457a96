"""A claim about speed, and what several measurements use."""
import dataclasses

from .program import SCENES

ROOM = "room.toml"
GENERAL = ("-D", "integrator.symmetry=none")  # the general path: all six variables are integrated
DOUBLE = ("--precision", "double")            # by default, pictures without a visible difference are in float


@dataclasses.dataclass
class Claim:
    key: str            # key of the cause in bench/performance-causes.toml
    what: str           # description of the measured quantity
    minimum: list       # one number per measured value; empty: no minimum
    target: list        # one number per measured value; empty: no target
    measured: list      # medians; empty: no method and step met the error bound
    detail: str = ""    # spread, method and step
    higher_is_better: bool = True
    form: str = "{:.2f}"  # format of the measured values
    share: list = dataclasses.field(default_factory=list)  # tracing rate in percent of the machine's peak


def general_share(program, precision, *arguments):
    """Returns the share of peak, in percent, of the room on the general path."""
    return program.share_of_peak(SCENES / ROOM, "--precision", precision, *GENERAL, *arguments)
