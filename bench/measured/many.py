"""The claims about many machines: the costs of the journal, of parts and of ranks. `bench/performance --only WORD`
measures one of them."""
import os
import pathlib
import resource
import shutil
import statistics
import subprocess
import time

from .claim import Claim
from .program import SCENES, Spread

SIZE = ("--size", "2048x2048")
PARTS = 16
# Open MPI: permits more ranks than processors, and the user root in a container.
MPI = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1", "OMPI_MCA_rmaps_base_oversubscribe": "1",
       "OMPI_MCA_hwloc_base_binding_policy": "none"}


def processor_seconds(measured):
    """Calls a function that runs processes. Returns their processor time in user and system mode, and its result."""
    def used():
        usage = resource.getrusage(resource.RUSAGE_CHILDREN)
        return usage.ru_utime + usage.ru_stime
    before = used()
    result = measured()
    return used() - before, result


def journal(program, _):
    """Processor time of a render with --resume divided by that without, for a picture with large areas of one colour
    (room), and for pictures in which hardly two neighbouring pixels are equal. As for ranks, the noise of the machine
    is greater than the difference: there are three times as many rounds. The first claim has the default settings, by
    which only tiles of the time before the last second are written; for the second one, all tiles are written."""
    scenes = ("room", "kerr", "mirage")

    def claim(key, what, minimum, target, interval):
        ratios, spreads = [], []
        for scene in scenes:
            def run(*options, path=SCENES / f"{scene}.toml"):
                return processor_seconds(lambda: program.render(path, *SIZE, "--spp", 1, "--threads", 2, *options))[0]
            os.environ["KAGERO_JOURNAL_INTERVAL"] = interval
            ratio = program.ratio(lambda: run("--resume"), run, rounds=3 * program.rounds)
            del os.environ["KAGERO_JOURNAL_INTERVAL"]
            ratios.append(ratio.median)
            spreads.append(str(ratio))
        what = f"processor time with --resume ÷ without, 2048x2048{what}: {' / '.join(scenes)}"
        return Claim(key, what, minimum, target, ratios, "; ".join(spreads), False, "{:.3f}")

    return [claim("journal", "", [1.05] * len(scenes), [1.01] * len(scenes), "1"),
            claim("journal-always", ", KAGERO_JOURNAL_INTERVAL=0", [], [], "0")]


def parts(program, _):
    """Time of all parts of a picture divided by that of the whole picture, which is not a part: for rendering, and for
    whole processes."""
    def rendering(file, *options):
        """Returns the seconds of rendering on one thread, and the processor time of the whole process."""
        used, report = processor_seconds(lambda: program.json(
            "render", SCENES / "room.toml", *SIZE, "--threads", 1, "-o", program.directory / file, *options))
        return report["seconds"], used
    of_rendering, of_processes, greatest, starts = [], [], [], []
    for _ in range(program.rounds):
        whole = rendering("a.pfm")
        each = [rendering("a.part", "--part", f"{number}/{PARTS}") for number in range(1, PARTS + 1)]
        seconds = [part[0] for part in each]
        of_rendering.append(sum(seconds) / whole[0])
        of_processes.append(sum(part[1] for part in each) / whole[1])
        greatest.append(max(seconds) * PARTS / sum(seconds))
        starts.append(1e3 * statistics.median(used - rendered for rendered, used in each))
    spread = Spread(of_rendering)
    return [Claim("parts", f"rendering of {PARTS} parts, sum of times ÷ the whole picture, room 2048x2048, 1 thread",
                  [1.1], [1.03], [spread.median], str(spread), False, "{:.3f}"),
            Claim("parts-start", "processor time of one part beside rendering (loading, trial, writing), ms", [], [],
                  [statistics.median(starts)],
                  f"all processes of the {PARTS} parts take {statistics.median(of_processes):.2f} times as long as that"
                  " of the whole picture", False, "{:.0f}"),
            Claim("parts-balance", f"longest of the {PARTS} parts ÷ their mean", [], [], [statistics.median(greatest)],
                  str(Spread(greatest)), False)]


def run_ranks(program, ranks, *arguments):
    """Returns the JSON report of a render on several ranks."""
    output = program.directory / "ranks.json"
    words = ["mpirun", "-n", str(ranks), str(program.build / "bin" / "kagero"), "render",
             *(str(a) for a in arguments), "--mpi", "--isa", program.isa, "--quiet", "-o",
             str(program.directory / "ranks.pfm"), "--json", str(output)]
    program.record(words)
    subprocess.run(words, check=True, capture_output=True, env=os.environ | MPI)
    return program.read_json(output)


def ranks(program, _):
    """Speed of two ranks of one thread divided by that of two threads of one process. The differences are of the order
    of the noise of the machine: there are three times as many rounds."""
    if not shutil.which("mpirun") or not (program.build / "lib" / "kagero" / "kagero-mpi.so").exists():
        return []
    cases = {"room 2048x2048": (SCENES / "room.toml", *SIZE),
             "hole 1024x1024, gauss8, step 0.01": (
                 SCENES / "hole.toml", "--size", "1024x1024", "--integrator", "gauss8", "--step", 0.01)}
    measured, spreads = [], []
    for arguments in cases.values():
        ratio = program.ratio(
            lambda arguments=arguments: program.render(*arguments, "--threads", 2)[0]["seconds"],
            lambda arguments=arguments: run_ranks(program, 2, *arguments, "--threads", 1)["seconds"],
            rounds=3 * program.rounds)
        measured.append(ratio.median)
        spreads.append(str(ratio))
    what = f"time, 2 threads ÷ 2 ranks of 1 thread: {' / '.join(cases)}"
    return [Claim("ranks", what, [0.9] * 2, [0.97] * 2, measured,
                  "; ".join(spreads))]


def mpi_module(program, _):
    """Time of a start and time per ray with the module for MPI beside the program, divided by those without it."""
    installed = program.build / "lib" / "kagero"
    if not (installed / "kagero-mpi.so").exists():
        return []
    def copy(name, left_out):
        """Copies the program and its modules into a folder. Returns the path of the program."""
        folder = program.directory / name
        (folder / "bin").mkdir(parents=True)
        shutil.copytree(installed, folder / "lib" / "kagero", ignore=shutil.ignore_patterns(*left_out))
        return pathlib.Path(shutil.copy2(program.build / "bin" / "kagero", folder / "bin"))
    programs = copy("with-mpi", ()), copy("without-mpi", ("kagero-mpi.so",))
    def start(path):
        begin = time.monotonic()
        for _ in range(20):
            subprocess.run([path, "check", SCENES / "room.toml", "--isa", program.isa, "--quiet"], check=True)
        return time.monotonic() - begin
    def rendering(path):
        report = program.directory / "module.json"
        subprocess.run([path, "render", SCENES / "room.toml", "--size", "1024x1024", "--threads", "1", "--isa",
                        program.isa, "--quiet", "-o", program.directory / "module.pfm", "--json", report], check=True)
        return program.read_json(report)["seconds"]
    ratios = [program.ratio(lambda m=measure: m(programs[0]), lambda m=measure: m(programs[1]))
              for measure in (start, rendering)]
    what = "with kagero-mpi.so beside the program ÷ without: time of a start / time per ray"
    return [Claim("mpi-module", what, [1.05] * 2,
                  [1.01] * 2, [ratio.median for ratio in ratios], "; ".join(map(str, ratios)), False, "{:.3f}")]


ALL = (journal, parts, ranks, mpi_module)
