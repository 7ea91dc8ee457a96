"""The examples of docs/examples run, and write their figures. Each checks its results itself."""
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

from support import BUILD, SOURCE

EXAMPLES = SOURCE / "docs" / "examples"


class ExampleTest(unittest.TestCase):
    def test_examples(self):
        names = sorted(path.stem for path in EXAMPLES.glob("*.py"))
        self.assertGreaterEqual(len(names), 6)
        for name in names:
            with self.subTest(name), tempfile.TemporaryDirectory() as folder:
                figure = pathlib.Path(folder, "figure.png")
                environment = os.environ | {"PYTHONPATH": str(BUILD / "python"), "MPLCONFIGDIR": folder}
                done = subprocess.run([sys.executable, "-B", EXAMPLES / f"{name}.py", figure], capture_output=True,
                                      text=True, env=environment, timeout=200)
                self.assertEqual(done.returncode, 0, done.stderr)
                print(name, done.stdout, end="")
                self.assertTrue(figure.read_bytes().startswith(b"\x89PNG"))

    def test_figures_are_in_the_repository(self):
        for path in EXAMPLES.glob("*.py"):
            self.assertTrue((EXAMPLES / "figures" / f"{path.stem}.png").exists(), path)


if __name__ == "__main__":
    for package in ("matplotlib", "scipy"):
        try:
            __import__(package)
        except ImportError:
            print(f"SKIPPED: the examples need {package}; install the package python3-{package}", file=sys.stderr)
            sys.exit(77)
    unittest.main()
