#!/usr/bin/python3
"""Builds the Debian packages, and checks that only kagero-mpi depends on an MPI library.

    check_dependencies.py BUILD FOLDER

Exits with 77 if this machine cannot build Debian packages. FOLDER receives the packages.
"""
import pathlib
import re
import shutil
import subprocess
import sys

build, folder = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
if not (shutil.which("dpkg-deb") and shutil.which("dpkg-shlibdeps") and shutil.which("cpack")):
    print("dpkg-dev or cpack is not installed")
    sys.exit(77)
shutil.rmtree(folder, ignore_errors=True)
subprocess.run(["cpack", "--config", build / "CPackConfig.cmake", "-B", folder], check=True, stdout=subprocess.DEVNULL)


def output_of(*command):
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


packages = {output_of("dpkg-deb", "-f", file, "Package").strip(): file for file in folder.glob("*.deb")}
has_mpi = bool(list((build / "lib" / "kagero").glob("kagero-mpi.so")))
expected = {"kagero", "kagero-mpi"} if has_mpi else {"kagero"}
if set(packages) != expected:
    sys.exit(f"the packages are {sorted(packages)}, but should be {sorted(expected)}")
depends = {name: output_of("dpkg-deb", "-f", file, "Depends") for name, file in packages.items()}
modules = {name: set(re.findall(r"kagero-[a-z0-9-]+\.so", output_of("dpkg-deb", "-c", file)))
           for name, file in packages.items()}
if "libembree" not in depends["kagero"] or "mpi" in depends["kagero"]:
    sys.exit(f"kagero depends on {depends['kagero']}")
if not any(module.startswith("kagero-kernels") for module in modules["kagero"]):
    sys.exit(f"kagero contains the modules {modules['kagero']}")
if has_mpi and (modules["kagero-mpi"] != {"kagero-mpi.so"} or "kagero-mpi.so" in modules["kagero"]):
    sys.exit(f"the modules of the packages are {modules}")
if has_mpi and not re.search(r"lib(open)?mpi", depends["kagero-mpi"]):
    sys.exit(f"kagero-mpi depends on {depends['kagero-mpi']}")
print(depends)
