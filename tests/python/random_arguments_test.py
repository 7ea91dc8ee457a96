"""Calls functions with thousands of random arguments. None may crash the process or raise another exception than those
of wrong arguments.

KAGERO_RANDOM_CALLS is the number of calls (default 4000), KAGERO_RANDOM_SEED the seed. With the address sanitizer:

    LD_PRELOAD="$(gcc -print-file-name=libasan.so) $(gcc -print-file-name=libstdc++.so)" \
        ASAN_OPTIONS=detect_leaks=0 KAGERO_BUILD=build/asan /usr/bin/python3 tests/python/random_arguments_test.py

Python itself does not load libstdc++, whose functions the sanitizer replaces; it must therefore be loaded first.
"""
import os
import random
import unittest
import warnings

from support import HOLE
import numpy as np
import kagero

CALLS = int(os.environ.get("KAGERO_RANDOM_CALLS", "1500"))
SEED = int(os.environ.get("KAGERO_RANDOM_SEED", "1"))
EXPECTED = (kagero.InputError, kagero.RunError, TypeError)
SMALL = {**HOLE, "film": {"size": [4, 3]}, "integrator": {"max_steps": 500}}


class Strange:
    """An object whose special functions fail."""

    def __repr__(self):
        raise RuntimeError("no text")

    def __array__(self, *_):
        raise RuntimeError("no array")

    def __len__(self):
        return -1


class Generator:
    def __init__(self, seed):
        self.random = random.Random(seed)
        self.numbers = np.random.default_rng(seed)

    def one_of(self, *values):
        return self.random.choice(values)

    def number(self):
        return self.one_of(0, 1, -1, 2, 0.5, -0.0, 1e-320, 1e308, -1e308, 2**31, 2**32, -2**63, 2**64, float("nan"),
                           float("inf"), True, np.float32(3), np.int8(-5), np.uint64(2**64 - 1), np.bool_(False),
                           3 + 1j)

    def text(self):
        return self.one_of("", "a", "color", "steps", "x", "status", "static", "zamo", "falling", "float", "double",
                           "avx2", "sse2", "packet", "scalar", "\0", "\ud800", "é" * 50, "x" * 10000, "[", "]", '"',
                           "'''", "=", "\n", "a.b.c", "." * 100, "-1", "nan", "space.rg", "object.ball.color")

    def junk(self, depth=0):
        values = [None, self.number(), self.text(), b"bytes", Strange(), object, lambda: 1, {1, 2}, iter([1])]
        if depth < 3:
            values += [[self.junk(depth + 1) for _ in range(self.random.randint(0, 3))],
                       {self.text(): self.junk(depth + 1) for _ in range(self.random.randint(0, 3))},
                       tuple(self.junk(depth + 1) for _ in range(self.random.randint(0, 3)))]
        return self.random.choice(values)

    def array(self):
        shape = self.one_of((3,), (1, 3), (4, 3), (4, 3), (5, 3), (0, 3), (3, 4), (), (2, 2, 3), (0,), (7, 0))
        dtype = self.one_of("f8", "f8", "f8", "f8", "f4", "i8", ">f8", "c16", "O", "U3", "M8[s]", "f2", "?")
        array = (self.numbers.normal(size=shape) * self.one_of(1, 1, 1, 10, 1e-300, 1e200, 0))
        array = np.asarray(array)
        if array.size and self.random.random() < 0.2:
            array.flat[self.random.randrange(array.size)] = self.one_of(np.nan, np.inf, -np.inf, 0, 1e308, 5e-324)
        if dtype != "f8":
            with np.errstate(all="ignore"):
                array = array.astype(dtype) if dtype != "M8[s]" else np.zeros(shape, dtype)
        if array.ndim and self.random.random() < 0.15:
            array = self.one_of(array[::-1], array.T, array[..., ::2], array[None], np.asfortranarray(array))
        return array

    def vectors(self):
        return self.one_of(self.array, self.array, self.array, lambda: [0, 0, 5], lambda: (1.0, 0.5, 0.2),
                           self.junk)()

    def maybe(self, good, chance=0.7):
        return good() if self.random.random() < chance else self.junk()

    def options(self):
        options = {}
        add = lambda name, good: options.__setitem__(name, self.maybe(good))
        for name, good in (("threads", lambda: self.one_of(None, 1, 2, 3)),
                           ("precision", lambda: self.one_of("auto", "double", "float")),
                           ("isa", lambda: self.one_of("auto", None)),
                           ("strategy", lambda: self.one_of("auto", "scalar", "packet", "per-ray")),
                           ("progress", lambda: self.one_of(None, False, lambda done, seconds: None))):
            if self.random.random() < 0.15:
                add(name, good)
        return options

    def ray_options(self):
        options = self.options()
        for name, good in (("observer", lambda: self.one_of(None, "static", "zamo", "falling", "coordinate")),
                           ("bounces", lambda: self.random.randint(0, 3)),
                           ("parameter", lambda: self.one_of(0.5, 3.0)),
                           ("columns", lambda: self.random.sample(["x", "status", "reason", "steps", "action", "time",
                                                                   "energy_error", "medium", "weight", "object"], 3))):
            if self.random.random() < 0.15:
                options[name] = self.maybe(good)
        return options

    def override(self):
        key = self.one_of("space.rg", "space.center", "film.size", "film.layers", "camera.position", "camera.fov",
                          "integrator.method", "integrator.step", "object.ball.radius", "object.ball.color",
                          "object.ball.material", "sky.checker", self.text())
        value = self.maybe(lambda: self.one_of(0.5, 1, [1, 2, 3], [4, 4], ["color"], "rk4", "mirror", True), 0.6)
        if key == "film.size" and not (isinstance(value, list) and value == [4, 4]):
            value = [5, 2]  # large pictures take too long
        return {key: value}


class RandomArgumentsTest(unittest.TestCase):
    def test_random_arguments(self):
        scene = kagero.scene(SMALL)
        done = refused = 0
        for i in range(CALLS):
            make = Generator(SEED * 1000003 + i)
            call = make.one_of("trace", "trace", "trace", "path", "path", "override", "render", "scene", "load",
                               "sweep", "pickle")
            try:
                with warnings.catch_warnings():
                    warnings.simplefilter("ignore", kagero.RunWarning)
                    self.call(call, scene, make)
                done += 1
            except EXPECTED:
                refused += 1
            except BaseException as error:
                raise AssertionError(f"call {i} ({call}) with seed {SEED}: {type(error)}") from error
        self.assertGreater(done, CALLS // 20)
        self.assertGreater(refused, CALLS // 20)

    def call(self, name, scene, make):
        if name in ("trace", "path"):
            options = make.ray_options()
            if name == "path" and make.random.random() < 0.3:
                options["every"] = make.maybe(lambda: 0.5)
            result = getattr(scene, name)(make.vectors(), make.vectors(), **options)
            self.assertEqual(len({len(column) for column in result.values()}), 1)
            repr(result)
        elif name == "override":
            changed = scene.override(make.maybe(make.override, 0.9))
            repr(changed)
            changed.trace([0, 0, 5], [0, 0, 1])
            changed.render()
        elif name == "render":
            scene.render(make.maybe(lambda: make.one_of(["color"], ["status", "steps"], None)), **make.options())
        elif name == "scene":
            tables = {table: dict(keys) if isinstance(keys, dict) else [dict(each) for each in keys]
                      for table, keys in SMALL.items()}
            table = make.one_of("space", "camera", "film", "sky", "integrator", make.text())
            if make.random.random() < 0.8 and isinstance(tables.setdefault(table, {}), dict):
                tables[table][make.one_of("rg", "size", "position", "color", "spp", make.text())] = \
                    make.one_of([4, 3], make.junk())
            else:
                tables[table] = make.junk()
            if tables["film"] == SMALL["film"]:
                kagero.scene(tables).render()
            else:
                kagero.scene(tables)
        elif name == "load":
            kagero.load(make.junk(), make.junk())
        elif name == "sweep":
            kagero.sweep(scene, make.maybe(lambda: {"space.rg": [0.5, 1.0], "film.seed": [1, 2]}), make.vectors(),
                         make.vectors(), **make.ray_options())
        else:
            import pickle
            pickle.loads(pickle.dumps(scene.trace([0, 0, 5], [0, 0, 1])))


if __name__ == "__main__":
    unittest.main()
