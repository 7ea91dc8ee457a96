"""The machine and the source code that a measurement belongs to."""
import pathlib
import platform
import subprocess

from .program import SOURCE


def processor():
    lines = pathlib.Path("/proc/cpuinfo").read_text().splitlines()
    def field(name):
        return next((line.split(":", 1)[1].strip() for line in lines if line.split("\t", 1)[0] == name), "unknown")
    return f"{field('model name')} (family {field('cpu family')}, model {field('model')})"


def machine():
    threads = pathlib.Path("/proc/cpuinfo").read_text().count("processor\t")
    return f"{processor()}, {threads} threads, {platform.system()} {platform.release()}"


def commit():
    done = subprocess.run(["git", "-C", SOURCE, "describe", "--always", "--dirty"], capture_output=True, text=True)
    return done.stdout.strip() or "unknown"
