"""Claims about formulas of scenes: compiled Hamiltonians against the same H as a formula."""
import math
import re
import statistics

from .claim import DOUBLE, GENERAL, ROOM, Claim
from .program import SCENES

# The space of the room as a formula: H of Satoh (2003), equation (16), factored as in
# kernels/hamiltonians/schwarzschild.h.
FORMULA_ROOM = '''[space]
hamiltonian = "formula"
H = "0.5*(px^2 + py^2 + pz^2 - pt^2) - 0.5*(rg/r)*u^2"
capture = "r - rg"
[space.constants]
rg = 0.08
pt = 1
[space.let]
r = "sqrt(x^2 + y^2 + z^2)"
u = "pt + (x*px + y*py + z*pz)/r"
'''


# The space `kerr` with mass 0.25 and spin 0.6, and the same as a formula, for one method and step.
FORMULA_KERR = '''[space]
hamiltonian = "formula"
H = "0.5*(px^2 + py^2 + pz^2 - pt^2) - 0.5*f*(pt + lx*px + ly*py + z/r*pz)^2"
capture = "r - 1.02*(M + sqrt(M^2 - a^2))"
[space.constants]
pt = 1
M = 0.25
a = 0.15
[space.let]
s = "x^2 + y^2 + z^2 - a^2"
r = "sqrt(0.5*(s + sqrt(s^2 + 4*a^2*z^2)))"
f = "2*M*r^3/(r^4 + a^2*z^2)"
lx = "(r*x - a*y)/(r^2 + a^2)"
ly = "(r*y + a*x)/(r^2 + a^2)"
'''
BUILT_IN_KERR = '''[space]
hamiltonian = "kerr"
mass = 0.25
spin = 0.6
'''
KERR_VIEW = '''[integrator]
method = "gauss8"
step = 0.2
rescale = "none"
escape_radius = 20
[camera]
position = [8, 0.5, 2]
look_at = [0, 0, 0]
up = [0, 0, 1]
fov = 40
[film]
size = [256, 256]
'''


def formula_pairs(program):
    """Returns scenes with a compiled Hamiltonian and the same as a formula, each with options for method and step."""
    text = (SCENES / ROOM).read_text()
    room, kerr, formula_kerr = (program.directory / f"{name}.toml" for name in ("formula-room", "kerr", "formula-kerr"))
    room.write_text(FORMULA_ROOM + text[text.index("[integrator]"):])
    kerr.write_text(BUILT_IN_KERR + KERR_VIEW)
    formula_kerr.write_text(FORMULA_KERR + KERR_VIEW)
    printed = program.text("print", SCENES / ROOM, *GENERAL)  # in which defaults are comments
    method, step = (re.search(rf"^(?:# )?{key} = (\S+)", printed, re.MULTILINE)[1] for key in ("method", "step"))
    in_room, in_mirage = (["--integrator", name, "--step", length]
                          for name, length in ((method.strip('"'), step), ("srkn6", "0.1")))
    return ((SCENES / ROOM, [*GENERAL, *in_room], room, [*in_room, "-D", "integrator.rescale=r"]),
            (SCENES / "mirage.toml", [*GENERAL, *in_mirage], SCENES / "formula-mirage.toml", in_mirage),
            (kerr, GENERAL, formula_kerr, []))


def formulas(program, _):
    """Render time with a compiled Hamiltonian divided by that with the same H as a formula of the scene, for the same
    method and step; and the time in which a long formula is compiled."""
    claim = Claim("formula", "compiled Hamiltonian ÷ the same as a formula, room / mirage / Kerr, same method and step",
                  [0.8] * 3, [0.97] * 3, [])
    spreads = []
    for compiled, compiled_options, formula, formula_options in formula_pairs(program):
        def run(path, options):
            return program.render(path, "--threads", 1, *DOUBLE, *options)[0]["seconds"]
        ratio = program.ratio(lambda: run(compiled, compiled_options), lambda: run(formula, formula_options))
        claim.measured.append(ratio.median)
        claim.share.append(program.share_of_peak(formula, *DOUBLE, *formula_options))
        spreads.append(str(ratio))
    claim.detail = "; ".join(spreads)
    return [claim, formula_compilation(program)]


def formula_compilation(program):
    """Time in which a formula of about 300 nodes is compiled."""
    terms = (f"{i}*sqrt((x - 0.{i})^2 + (y + 0.{i})^2 + z^2*{i} + 1)" for i in range(1, 21))
    scene = program.directory / "long-formula.toml"
    scene.write_text('[space]\nhamiltonian = "formula"\nH = "0.5*(px^2 + py^2 + pz^2) + ' + " + ".join(terms) + '"\n' +
                     "H0 = 1e5\n" + KERR_VIEW)
    times = [program.json("explain", scene)["formula_code"].get("compile_s", math.inf) for _ in range(program.rounds)]
    return Claim("formula-compilation", "time to compile a formula of 300 nodes, s", [0.3], [0.05],
                 [statistics.median(times)], f"{min(times):.3f} to {max(times):.3f}", False, "{:.3f}")


ALL = (formulas,)
