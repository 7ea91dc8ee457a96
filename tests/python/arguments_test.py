"""Wrong arguments raise exceptions that name the received and the expected input."""
import pickle
import unittest

from support import HOLE
import numpy as np
import kagero


class InputErrorTest(unittest.TestCase):
    def setUp(self):
        self.scene = kagero.scene(HOLE)
        self.good = np.array([[-8.0, 0, 0], [-8, 1, 0]])

    def refuse(self, function, *parts):
        with self.assertRaises(kagero.InputError) as caught:
            function()
        for part in parts:
            self.assertIn(part, str(caught.exception))
        return caught.exception

    def test_arrays(self):
        expected = "expected an array of float64 in C order with the shape (N, 3)"
        wrong = [
            (np.zeros((2, 4)), "shape (2, 4)"),
            (np.zeros(4), "shape (4,)"),
            (np.zeros((2, 2, 3)), "shape (2, 2, 3)"),
            (np.float64(1), "1.0"),
            (np.array(1.0), "shape ()"),
            (np.zeros((2, 3), np.float32), "float32"),
            (np.zeros((2, 3), np.int64), "int64"),
            (np.zeros((2, 3), complex), "complex128"),
            (np.zeros((2, 3), object), "object"),
            (np.zeros((2, 3), ">f8"), ">f8"),
            (np.zeros((3, 2)).T, "strides (8, 16)"),
            (np.zeros((2, 3))[::-1], "strides (-24, 8)"),
            (np.zeros((4, 3))[::2], "strides (48, 8)"),
            (np.zeros((2, 6))[:, ::2], "strides (48, 16)"),
            (np.zeros((0, 3)), "empty"),
            (np.frombuffer(bytearray(49), np.uint8)[1:].view(np.float64).reshape(2, 3), "aligned"),
            ("text", "'text'"),
            (None, "None"),
            ([[1, 2, 3], [4, 5]], "rectangular"),
            (["a", "b", "c"], "expected numbers"),
            ([], "empty"),
        ]
        for value, part in wrong:
            with self.subTest(part):
                self.refuse(lambda: self.scene.trace(value, self.good), "position", part)
                self.refuse(lambda: self.scene.trace(self.good, value), "direction", part)
                self.refuse(lambda: self.scene.path(self.good, value), "direction", part)
        self.refuse(lambda: self.scene.trace(np.zeros((2, 4)), self.good), expected)

    def test_numbers_that_are_not_finite(self):
        for bad in (np.nan, np.inf, -np.inf):
            position = np.zeros((9000, 3))
            position[8765, 1] = bad
            self.refuse(lambda: self.scene.trace(position, np.ones(3)), "position[8765, 1]", "expected a finite number")
        self.refuse(lambda: self.scene.trace([0, 0, 5], [0, np.nan, 1]), "direction[1]", "nan")

    def test_different_counts(self):
        self.refuse(lambda: self.scene.trace(np.zeros((4, 3)), self.good), "4 vectors", "2")

    def test_arrays_in_c_order_are_read_in_place(self):
        read_only = self.good.copy()
        read_only.flags.writeable = False
        before = read_only.copy()
        self.scene.trace(read_only, read_only)
        np.testing.assert_array_equal(read_only, before)

    def test_options(self):
        trace = lambda **options: lambda: self.scene.trace([0, 0, 5], [0, 0, 1], **options)
        self.refuse(trace(columns=["stat"]), "stat", 'did you mean "status"')
        self.refuse(trace(columns=["x", "x"]), "twice")
        self.refuse(trace(columns="x"), "list of strings")
        self.refuse(trace(columns=[]), "at least one")
        self.refuse(trace(observer="ststic"), "static")
        self.refuse(trace(observer=3), "3", "string")
        self.refuse(trace(bounces=-1), "-1", "from 0 to 1000")
        self.refuse(trace(bounces=2.5), "2.5", "from 0 to 1000")
        self.refuse(trace(bounces=2**70), "from 0 to 1000")
        self.refuse(trace(parameter=-1), "-1", "greater than 0")
        self.refuse(trace(parameter=True), "True", "number")
        self.refuse(trace(parameter=10**400), "too large")
        self.refuse(trace(parameter=1, bounces=1), "exclude each other")
        self.refuse(trace(threads=0), "0", "from 1 to 4096")
        self.refuse(trace(threads=True), "True", "from 1 to 4096")
        self.refuse(trace(precision="half"), "half", "double, float")
        self.refuse(trace(isa="mmx"), "mmx")
        self.refuse(trace(strategy="gpu"), "gpu", "packet")
        self.refuse(trace(progress=3), "3", "function")
        self.refuse(lambda: self.scene.path([0, 0, 5], [0, 0, 1], every=0), "every", "greater than 0")
        self.refuse(lambda: self.scene.path([0, 0, 5], [0, 0, 1], every=float("nan")), "nan")
        self.refuse(lambda: self.scene.render(["colour"]), "colour", 'did you mean "color"')
        self.refuse(lambda: self.scene.render("color"), "list of strings")
        self.refuse(lambda: self.scene.render(["color", "color"]), "only once")
        self.refuse(lambda: self.scene.render(["\ud800"]), "Unicode")
        self.refuse(lambda: self.scene.error(sample=(0, 5)), "sample[0]", "from 1 to 4096")
        self.refuse(lambda: self.scene.error(quick=True, full=True), "exclude")
        self.refuse(lambda: self.scene.error(strategy="per-ray"), "per-ray")
        with self.assertRaises(TypeError):
            self.scene.trace([0, 0, 5], [0, 0, 1], column=["x"])
        with self.assertRaises(TypeError):
            kagero.Scene()

    def test_overrides(self):
        override = lambda **keys: lambda: self.scene.override({key.replace("__", "."): v for key, v in keys.items()})
        error = self.refuse(override(space__rgg=1), "space.rgg", 'did you mean "rg"')
        self.assertEqual(error.file, "-D space.rgg=1")
        self.refuse(override(space__rg=-1), "-1", "legal range")
        self.refuse(override(space__rg="wide"), "wide", "number")
        self.refuse(override(space__rg=[1, [2]]), "[1, [2]]")
        self.refuse(override(space__rg=float("nan")), "nan", "finite")
        self.refuse(override(space__rg=2**64), "64 bits")
        self.refuse(override(space__rg=object()), "space.rg", "of type object", "expected a number")
        self.refuse(override(space__rg=None), "None")
        self.refuse(override(object__balls__color=[1, 1, 1]), 'did you mean "ball"')
        self.refuse(lambda: self.scene.override({3: 4}), "3", "string")
        self.refuse(lambda: self.scene.override([("space.rg", 1)]), "dict")
        self.refuse(lambda: self.scene.override({"": 1}), "key.path=value")
        self.refuse(lambda: self.scene.override({"space.rg=3\nspace.rg": 1}))
        nested = []
        nested.append(nested)
        self.refuse(override(space__rg=nested), "nested")

    def test_files(self):
        error = self.refuse(lambda: kagero.load("/no/such/file.toml"), "/no/such/file.toml", "cannot be opened")
        self.assertEqual(error.file, "/no/such/file.toml")
        self.refuse(lambda: kagero.load("/tmp"), "directory")
        self.refuse(lambda: kagero.load(7), "7", "path")
        self.refuse(lambda: kagero.load(""), "path")
        self.refuse(lambda: kagero.load("a\0b"), "path")

    def test_location_in_a_file(self):
        import os
        import tempfile
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "wrong.toml")
            with open(path, "w") as file:
                file.write('[space]\nhamiltonian = "kerr"\n  spin = 3\n')
            error = self.refuse(lambda: kagero.load(path), "wrong.toml:3:10", "space.spin = 3", "legal range")
        self.assertEqual((error.file, error.line, error.column), (path, 3, 10))

    def test_keys_of_dicts(self):
        def wrong(*path, value):
            tables = {name: dict(table) if isinstance(table, dict) else [dict(each) for each in table]
                      for name, table in HOLE.items()}
            inner = tables
            for name in path[:-1]:
                inner = inner[name]
            inner[path[-1]] = value
            return lambda: kagero.scene(tables).render()
        self.assertEqual(self.refuse(wrong("space", "rgg", value=1), "space.rgg", "did you mean").key, "space.rgg")
        self.assertEqual(self.refuse(wrong("film", "size", value=[8, 0]), "film.size[1] = 0").key, "film.size")
        error = self.refuse(wrong("object", 0, "radius", value=-2), "radius = -2", "legal range")
        self.assertEqual(error.key, "object[0].radius")
        self.refuse(wrong("camera", "up", value=[1, 0, 0]), "camera.up", "parallel")
        self.refuse(wrong("film", "layers", value=[]), "film.layers")
        self.refuse(wrong("film", "layers", value={"a": 1}), "film.layers")
        self.refuse(wrong("film", 3, value=1), "expected a string")
        self.refuse(wrong("film", "size", value={1, 2}), "film.size", "of type set")
        self.refuse(wrong("camera", value=5), "camera")
        self.refuse(wrong("space", "ham\nil", value=5), "ham\nil")
        self.refuse(lambda: kagero.scene([1]), "dict")
        self.refuse(lambda: kagero.scene({}), "space.hamiltonian")
        self.refuse(lambda: kagero.scene(HOLE, directory=3), "directory")

    def test_sweep(self):
        sweep = lambda values: lambda: kagero.sweep(self.scene, values, [0, 0, 5], [0, 0, 1])
        self.refuse(sweep({}), "dict")
        self.refuse(sweep({"space.rg": []}), "at least one value")
        self.refuse(sweep({"space.rg": [1, 2], "film.seed": [1]}), "different numbers")
        self.refuse(sweep({"space.rgg": [1, 2]}), "space.rgg")
        self.refuse(lambda: kagero.sweep("scene", {"space.rg": [1]}, [0, 0, 5], [0, 0, 1]), "kagero.Scene")

    def test_errors_can_be_pickled(self):
        error = self.refuse(lambda: self.scene.override({"space.rg": -1}))
        copy = pickle.loads(pickle.dumps(error))
        self.assertEqual((str(copy), copy.file), (str(error), error.file))

    def test_rays_that_cannot_start_fail_with_a_reason(self):
        import warnings
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", kagero.RunWarning)
            ends = self.scene.trace([[0.0, 0, 0], [-8, 0, 0]], [[1.0, 0, 0], [0, 0, 0]])
        self.assertEqual(list(ends["status"]), [kagero.Status.failed] * 2)
        self.assertIn("direction", ends["reason"][1])


if __name__ == "__main__":
    unittest.main()
