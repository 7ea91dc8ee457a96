#!/usr/bin/python3
"""Runs every command of a page of the documentation, and checks that the links of the page lead to files.

    run_page.py PAGE BUILD WORK

Runs the page's `sh` blocks from top to bottom in the folder WORK, which stands for the root of the repository: it
contains copies of scenes and docs/spacetimes, the empty folder docs/pictures, and build/release, a link to BUILD.
A block fails if one of its commands fails. A block of another language whose first line is a comment `# file: NAME` is
written to the file NAME in WORK. A block after a line that begins with "Not run by the tests:" is not run, unless a
heading lies between them. To save time, commands are run with at most MAX_SPP rays per pixel, and pictures wider than
MAX_WIDTH are made that wide.
"""
import os
import pathlib
import re
import shutil
import subprocess
import sys

SOURCE = pathlib.Path(__file__).resolve().parent.parent.parent
EXEMPT = "Not run by the tests:"
MAX_SPP = 2
MAX_WIDTH = 240


def blocks_of(text):
    """Yields (line number, language, content, exempt) of each fenced block."""
    lines = text.split("\n")
    exempt, begin = False, None
    for number, line in enumerate(lines, 1):
        if begin is not None:
            if line.strip() == "```":
                yield begin, language, "\n".join(lines[begin:number - 1]) + "\n", exempt
                exempt, begin = False, None
        elif line.startswith("```"):
            begin, language = number, line[3:].strip()
        elif line.startswith(EXEMPT):
            exempt = True
        elif line.startswith("#"):
            exempt = False
    if begin is not None:
        sys.exit(f"the block that begins in line {begin} has no end")


def broken_links(page, text):
    """Returns the link targets of a page that are neither an address nor an existing file with that heading."""
    broken = []
    text = re.sub(r"^```.*?^```", "", text, flags=re.MULTILINE | re.DOTALL)
    for target in re.findall(r"\]\(([^)\s]+)\)", text) + re.findall(r'(?:src|href)="([^"]+)"', text):
        if re.match(r"[a-z]+:", target):
            continue
        name, _, anchor = target.partition("#")
        file = (page.parent / name).resolve() if name else page
        if not file.exists() or anchor and anchor not in anchors_of(file.read_text()):
            broken.append(target)
    return broken


def anchors_of(text):
    """Returns the anchors of headings, as GitHub forms them."""
    headings = re.findall(r"^#+ (.*)$", text, re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


def shortened(commands):
    """Returns commands that make smaller pictures with fewer rays per pixel."""
    def smaller(found):
        width, height = int(found[1]), int(found[2])
        return f"--size {width}x{height}" if width <= MAX_WIDTH else f"--size {MAX_WIDTH}x{MAX_WIDTH * height // width}"
    commands = re.sub(r"--spp (\d+)", lambda found: f"--spp {min(int(found[1]), MAX_SPP)}", commands)
    return re.sub(r"--size (\d+)x(\d+)", smaller, commands)


def prepare(work, build):
    """Creates the folder WORK."""
    shutil.rmtree(work, ignore_errors=True)
    (work / "docs" / "pictures" / "spacetimes").mkdir(parents=True)
    (work / "build").mkdir()
    (work / "build" / "release").symlink_to(build)
    shutil.copytree(SOURCE / "scenes", work / "scenes", ignore=shutil.ignore_patterns("data", "*.cpp", "*.h"))
    shutil.copytree(SOURCE / "docs" / "spacetimes", work / "docs" / "spacetimes")


def file_of(content):
    """Returns the name in the first line `# file: NAME` of a block, or None."""
    found = re.match(r"(?:#|//|<!--) file: (\S+)", content)
    return found and found[1]


def main():
    page, build, work = (pathlib.Path(argument).resolve() for argument in sys.argv[1:4])
    text = page.read_text()
    broken = broken_links(page, text)
    if broken:
        sys.exit(f"{page}: no file or heading for these links: {' '.join(broken)}")
    prepare(work, build)
    environment = os.environ | {"PATH": f"{build / 'bin'}:{os.environ['PATH']}"}
    ran = 0
    for number, language, content, exempt in blocks_of(text):
        if language != "sh":
            if name := file_of(content):
                (work / name).write_text(content)
            continue
        if exempt:
            continue
        print(f"{page.name}:{number}", flush=True)
        done = subprocess.run(["bash", "-euo", "pipefail", "-c", shortened(content)], cwd=work, env=environment,
                              stdin=subprocess.DEVNULL)
        if done.returncode != 0:
            sys.exit(f"{page}:{number}: exit status {done.returncode} of\n{content}")
        ran += 1
    shutil.rmtree(work)
    print(f"ran {ran} blocks")


main()
