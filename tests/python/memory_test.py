"""Renders, traces and sweeps in loops: the memory of the process does not grow.

KAGERO_RENDERS is the number of pictures (default 30).
"""
import os
import unittest

from support import HOLE
import numpy as np
import kagero

RENDERS = int(os.environ.get("KAGERO_RENDERS", "30"))
WARM_UP = 30  # the first pictures fill the caches of Embree, the C library and Python


def resident_megabytes():
    with open("/proc/self/status", encoding="ascii") as status:
        return next(int(line.split()[1]) for line in status if line.startswith("VmRSS")) / 1024


class MemoryTest(unittest.TestCase):
    def assert_bounded(self, function, repetitions, name):
        for i in range(WARM_UP):
            function(i)
        before = resident_megabytes()
        for i in range(repetitions):
            function(i)
        growth = resident_megabytes() - before
        # A picture has 128x96 pixels of 3 floats, 147 kB. 30 of them that are kept would take 4.4 MB.
        self.assertLess(growth, max(2, 2e-3 * repetitions), f"{name}: {growth:.1f} MB in {repetitions} repetitions")

    def test_memory_does_not_grow(self):
        scene = kagero.scene({**HOLE, "film": {"size": [128, 96]}})
        directions = np.random.default_rng(1).normal(size=(200, 3))
        self.assert_bounded(lambda i: scene.render(), RENDERS, "render")
        self.assert_bounded(lambda i: scene.trace([0, 0, 5], directions), RENDERS, "trace")
        self.assert_bounded(lambda i: scene.path([0, 0, 5], directions[:2]), RENDERS, "path")
        self.assert_bounded(lambda i: scene.override({"space.rg": 0.1 + 1e-4 * i}).trace([0, 0, 5], [0, 0, 1]),
                            RENDERS, "override")
        self.assert_bounded(lambda i: self.assertRaises(kagero.InputError, scene.trace, [0, 0, 5], [0, 0, np.nan]),
                            RENDERS, "wrong input")
        self.assert_bounded(lambda i: kagero.sweep(scene, {"space.rg": [0.1, 0.2]}, [0, 0, 5], directions[:5]),
                            RENDERS, "sweep")


if __name__ == "__main__":
    unittest.main()
