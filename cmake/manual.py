#!/usr/bin/env python3
"""Writes kagero's man page and bash completion from what the program's own --help prints.

usage: manual.py KAGERO DIRECTORY      writes DIRECTORY/kagero.1.gz and DIRECTORY/kagero.bash
"""
import gzip
import os
import re
import subprocess
import sys


def help_of(program, *verb):
    return subprocess.run([program, *verb, "--help"], check=True, capture_output=True, text=True).stdout


def sections(text):
    """The titled blocks of a help text: {"Options": [(names, meaning), ...]}, and the lines before the first."""
    blocks, preface, rows = {}, [], None
    for line in text.splitlines():
        title = re.fullmatch(r"([A-Z]\w+):", line)
        row = re.fullmatch(r"  (\S.*?)(?:\s{2,}(.*))?", line)
        if title:
            rows = blocks[title.group(1)] = []
        elif rows is not None and row:
            rows.append((row.group(1), row.group(2) or ""))
        elif rows is not None and line.startswith(" " * 20) and rows:  # the meaning of a long option is on a line of its own
            rows[-1] = (rows[-1][0], (rows[-1][1] + " " + line.strip()).strip())
        elif line and rows is None:
            preface.append(line)
        elif not line:
            rows = rows if rows is None else rows
    return blocks, preface


def roff(text):
    text = text.replace("\\", "\\e").replace("-", "\\-").replace("…", "...")
    return "\\&" + text if text.startswith((".", "'")) else text


def man_page(program, version, top, verbs):
    blocks, preface = sections(top)
    out = [f'.TH KAGERO 1 "" "kagero {version}" "User Commands"', ".SH NAME", "kagero \\- " + roff(preface[0].rstrip(".")),
           ".SH SYNOPSIS", ".B kagero", "VERB [OPTIONS] [SCENE]", ".SH VERBS"]
    for name, meaning in blocks["Verbs"]:
        out += [".TP", f".B {roff(name)}", roff(meaning)]
    for name, text in verbs.items():
        out += [f".SH {name.upper()}", roff(sections(text)[1][0]), ".PP"]
        for title, rows in sections(text)[0].items():
            for names, meaning in rows:
                out += [".TP", f".B {roff(names)}", roff(meaning)]
    status = [line for line in top.splitlines() if line.startswith("Exit status:")]
    out += [".SH EXIT STATUS", roff(status[0].removeprefix("Exit status: ")), ".SH ENVIRONMENT", ".TP", ".B KAGERO_ISA",
            "The instruction set, where \\-\\-isa is not given.", ".TP", ".B KAGERO_THREADS", "The number of threads, where \\-\\-threads is not given."]
    return "\n".join(out) + "\n"


def long_options(text):
    return sorted(set(re.findall(r"--[a-z][a-z-]*", "\n".join(names for names, _ in sections(text)[0].get("Options", [])))))


COMPLETION = """# bash completion for kagero, written by cmake/manual.py from the program's help
_kagero_names() { "$1" list "$2" 2>/dev/null | sed -n 's/^  \\([a-z0-9_-]\\+\\)  .*/\\1/p'; }
_kagero() {
    local cur=${COMP_WORDS[COMP_CWORD]} prev=${COMP_WORDS[COMP_CWORD-1]} verb=${COMP_WORDS[1]} words=
    COMPREPLY=()
    if [ "$COMP_CWORD" = 1 ]; then
        COMPREPLY=($(compgen -W "@verbs@ --help --version" -- "$cur"))
        return
    fi
    case $prev in
        --integrator) words=$(_kagero_names "$1" integrators) ;;
        --layers) words=$(_kagero_names "$1" layers) ;;
        --isa) words="auto $(_kagero_names "$1" isas)" ;;
        --precision) words="auto double float" ;;
        --strategy) words="auto scalar per-ray packet" ;;
        --schedule) words="auto scanline tiles predicted" ;;
        --observer) words="static zamo falling coordinate" ;;
        --color) words="auto always never" ;;
        -o|--output|--json|--rays) COMPREPLY=($(compgen -f -- "$cur")); return ;;
    esac
    if [ -n "$words" ]; then
        COMPREPLY=($(compgen -W "$words" -- "$cur"))
        return
    fi
    case $verb in
@cases@
    esac
    if [[ $cur == -* ]]; then
        COMPREPLY=($(compgen -W "$words" -- "$cur"))
    elif [ "$verb" = list ]; then
        COMPREPLY=($(compgen -W "hamiltonians integrators strategies isas scenes layers" -- "$cur"))
    else
        COMPREPLY=($(compgen -f -X '!*.toml' -- "$cur") $(compgen -d -- "$cur"))
    fi
}
complete -o filenames -F _kagero kagero
"""


def completion(verbs):
    cases = "\n".join(f'        {name}) words="{" ".join(long_options(text))}" ;;' for name, text in verbs.items())
    return COMPLETION.replace("@verbs@", " ".join(verbs)).replace("@cases@", cases)


def main():
    program, directory = sys.argv[1:]
    os.makedirs(directory, exist_ok=True)
    top = help_of(program)
    version = subprocess.run([program, "--version"], check=True, capture_output=True, text=True).stdout.split()[-1]
    verbs = {name: help_of(program, name) for name, _ in sections(top)[0]["Verbs"]}
    with open(os.path.join(directory, "kagero.1.gz"), "wb") as file:  # the same bytes whenever it is written
        with gzip.GzipFile(filename="", mode="wb", compresslevel=9, fileobj=file, mtime=0) as packed:
            packed.write(man_page(program, version, top, verbs).encode())
    with open(os.path.join(directory, "kagero.bash"), "w", encoding="utf8") as file:
        file.write(completion(verbs))


if __name__ == "__main__":
    main()
