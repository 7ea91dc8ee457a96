"""The machine and the source code that a measurement belongs to."""
import pathlib
import platform
import subprocess

from .program import SOURCE


def processor():
    """Returns name, family and model of the processor."""
    lines = pathlib.Path("/proc/cpuinfo").read_text().splitlines()
    def field(name):
        return next((line.split(":", 1)[1].strip() for line in lines if line.split("\t", 1)[0] == name), "unknown")
    return f"{field('model name')} (family {field('cpu family')}, model {field('model')})"


def machine():
    """Returns a description of the processor and the operating system."""
    threads = pathlib.Path("/proc/cpuinfo").read_text().count("processor\t")
    return f"{processor()}, {threads} threads, {platform.system()} {platform.release()}"


def commit():
    """Returns the commit of the source code; "-dirty" is appended if files have changed since."""
    done = subprocess.run(["git", "-C", SOURCE, "describe", "--always", "--dirty"], capture_output=True, text=True)
    return done.stdout.strip() or "unknown"
