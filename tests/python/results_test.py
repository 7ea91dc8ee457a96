"""The Python module gives the numbers of the command line."""
import csv
import io
import json
import pathlib
import pickle
import subprocess
import tempfile
import unittest
import warnings

from exr import read_exr
from support import HOLE, PROGRAM, SCENES, run_program
import numpy as np
import kagero

ROOM = {"film.size": [96, 64], "space.rg": 0.12}
FLAGS = ["-D", "film.size=[96, 64]", "-D", "space.rg=0.12"]


class PictureTest(unittest.TestCase):
    def test_layers_are_those_of_the_program(self):
        with tempfile.TemporaryDirectory() as folder:
            run_program("render", SCENES / "room.toml", *FLAGS, "-o", f"{folder}/a.pfm", "--quiet")
            data = pathlib.Path(folder, "a.pfm").read_bytes()
            run_program("render", SCENES / "room.toml", *FLAGS, "--layers", "steps", "-o", f"{folder}/b.npy", "--quiet")
            steps = np.load(f"{folder}/b.npy")
        expected = np.frombuffer(data.split(b"\n", 3)[3], "<f4").reshape(64, 96, 3)[::-1]
        layers = kagero.load(SCENES / "room.toml", ROOM).render(["color", "steps"])
        self.assertEqual(layers["color"].dtype, np.float32)
        np.testing.assert_array_equal(layers["color"], expected)
        np.testing.assert_array_equal(layers["steps"], steps)

    def test_layers_are_those_of_the_exr_file(self):
        """The layers are equal after they are rounded to the types of the file: HALF for colours."""
        names = ["color", "status", "steps", "energy_error", "position_error", "gradients"]
        with tempfile.TemporaryDirectory() as folder:
            run_program("render", SCENES / "room.toml", *FLAGS, "--layers", ",".join(names), "-o", f"{folder}/a.exr",
                        "--quiet")
            stored = read_exr(f"{folder}/a.exr")
        layers = kagero.load(SCENES / "room.toml", ROOM).render(names)
        self.assertEqual(list(layers), names)
        for i, channel in enumerate("RGB"):
            expected = stored[f"color.{channel}"]
            self.assertEqual(expected.dtype, np.float16)
            np.testing.assert_array_equal(layers["color"][..., i].astype(np.float16), expected)
        for name in names[1:]:
            self.assertEqual(stored[f"{name}.V"].dtype, np.float32)
            np.testing.assert_array_equal(layers[name], stored[f"{name}.V"])

    def test_files_of_one_layer(self):
        with tempfile.TemporaryDirectory() as folder:
            for layer, magic in (("steps", b"Pf"), ("color", b"PF")):
                for extension in ("npy", "pfm"):
                    run_program("render", SCENES / "room.toml", *FLAGS, "--layers", layer, "-o",
                                f"{folder}/{layer}.{extension}", "--quiet")
                expected = np.load(f"{folder}/{layer}.npy")
                self.assertEqual(expected.dtype, np.float32)
                kind, size, scale, data = pathlib.Path(folder, f"{layer}.pfm").read_bytes().split(b"\n", 3)
                self.assertEqual((kind, size, scale), (magic, b"96 64", b"-1.0"))
                np.testing.assert_array_equal(np.frombuffer(data, "<f4").reshape(expected.shape)[::-1], expected)
                np.testing.assert_array_equal(kagero.load(SCENES / "room.toml", ROOM).render([layer])[layer], expected)
            for layers, extension in (("color,steps", "npy"), ("steps,status", "pfm")):
                done = subprocess.run([PROGRAM, "render", SCENES / "room.toml", "--layers", layers, "-o",
                                       f"{folder}/two.{extension}"], capture_output=True, text=True)
                self.assertEqual(done.returncode, 2)
                self.assertIn("select one with --layers", done.stderr)
                self.assertFalse(pathlib.Path(folder, f"two.{extension}").exists())

    def test_program_does_not_link_python(self):
        linked = subprocess.run(["ldd", PROGRAM], capture_output=True, text=True, check=True).stdout
        self.assertIn("libtbb", linked)
        self.assertNotIn("python", linked.lower())

    def test_report_is_that_of_the_program(self):
        with tempfile.TemporaryDirectory() as folder:
            expected = json.loads(run_program("render", SCENES / "room.toml", *FLAGS, "-o", f"{folder}/a.exr",
                                              "--json", "--quiet"))
        report = kagero.load(SCENES / "room.toml", ROOM).render().report
        for key in ("status", "steps", "gradients", "integrator", "precision", "step", "energy_error", "warnings"):
            self.assertEqual(report[key], expected[key], key)

    def test_threads_and_precision_are_used(self):
        scene = kagero.scene(HOLE)
        self.assertEqual(scene.render(threads=1, precision="double").report["threads"], 1)
        self.assertEqual(scene.render(precision="double").report["precision"], "double")
        np.testing.assert_array_equal(scene.render(threads=1)["color"], scene.render(threads=2)["color"])

    def test_arrays_outlive_their_result(self):
        color = kagero.scene(HOLE).render()["color"]
        copy = color.copy()
        kagero.scene(HOLE, {"film.size": [64, 64]}).render()
        np.testing.assert_array_equal(color, copy)
        color[:] = 1  # the array belongs to the caller

    def test_errors_are_measured(self):
        errors = kagero.scene(HOLE).render(["position_error"])["position_error"]
        self.assertLess(np.nanpercentile(errors, 99), 0.1)


class TraceTest(unittest.TestCase):
    def setUp(self):
        random = np.random.default_rng(5)
        self.position = random.uniform(-0.4, 0.4, (50, 3)) + [0, -0.5, 0.1]
        self.direction = random.normal(size=(50, 3))
        self.direction[7] = 0

    def table(self, *flags):
        rows = "x,y,z,dx,dy,dz\n" + "\n".join(
            ",".join(repr(float(x)) for x in row) for row in np.hstack([self.position, self.direction]))
        with tempfile.NamedTemporaryFile("w", suffix=".csv") as file:
            file.write(rows)
            file.flush()
            text = run_program("trace", SCENES / "room.toml", "--rays", file.name, "--quiet", *flags)
        return list(csv.DictReader(io.StringIO(text)))

    def compare(self, result, rows):
        self.assertEqual(list(result), list(rows[0]))
        for name, column in result.items():
            with self.subTest(name):
                written = [row[name] for row in rows]
                if name == "status":
                    self.assertEqual([kagero.Status(code).name for code in column], written)
                elif column.dtype == object:
                    self.assertEqual(list(column), written)
                else:
                    np.testing.assert_array_equal(column, np.array([float(text) for text in written]))

    def trace(self, **options):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", kagero.RunWarning)
            return kagero.load(SCENES / "room.toml").trace(self.position, self.direction, **options)

    def test_columns_are_those_of_the_program(self):
        self.compare(self.trace(), self.table())

    def test_observer(self):
        self.compare(self.trace(observer="static"), self.table("--observer", "static"))

    def test_bounces(self):
        self.compare(self.trace(bounces=3), self.table("--bounces", "3"))

    def test_parameter(self):
        result = self.trace(parameter=0.3)
        rows = self.table("--parameter", "0.3")
        self.compare(result, rows)
        self.assertIn(kagero.Status.step_limit, result["status"])

    def test_chosen_columns(self):
        result = self.trace(columns=["action", "x", "status"])
        self.assertEqual(list(result), ["action", "x", "status"])
        rows = self.table("--columns", "action")
        np.testing.assert_array_equal(result["action"], [float(row["action"]) for row in rows])

    def test_paths(self):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", kagero.RunWarning)
            path = kagero.load(SCENES / "room.toml").path(self.position, self.direction)
            even = kagero.load(SCENES / "room.toml").path(self.position, self.direction, every=0.05)
        self.compare(path, self.table("--path"))
        self.compare(even, self.table("--path", "--every", "0.05"))

    def test_one_position_for_all_directions(self):
        scene = kagero.load(SCENES / "room.toml")
        directions = np.delete(self.direction, 7, axis=0)
        one = scene.trace(self.position[0], directions)
        several = scene.trace(np.tile(self.position[0], (len(directions), 1)), directions)
        for name in one:
            np.testing.assert_array_equal(one[name], several[name])

    def test_batches_are_independent(self):
        """Longer lists are traced in batches of 2^18 rays."""
        scene = kagero.scene(HOLE, {"integrator.method": "rk4", "integrator.step": 0.2})
        directions = np.random.default_rng(3).normal(size=((1 << 18) + 1000, 3)) + [3, 0, 0]
        columns = ["ray", "status", "object", "x", "y", "z", "px", "pt", "steps", "reason"]
        progress = []
        whole = scene.trace([-8, 0, 0], directions, columns=columns,
                            progress=lambda done, seconds: progress.append(done))
        first = 1 << 17
        for begin, end in ((0, first), (first, len(directions))):
            part = scene.trace([-8, 0, 0], directions[begin:end], columns=columns)
            np.testing.assert_array_equal(part["ray"] + begin, whole["ray"][begin:end])
            for column in columns[1:]:
                np.testing.assert_array_equal(part[column], whole[column][begin:end])
        self.assertEqual(progress, sorted(progress))
        self.assertTrue(all(0 <= done <= 1 for done in progress))

    def test_mirrors(self):
        ends = kagero.load(SCENES / "mirror-room.toml").trace(
            [0, -0.6, 0], np.random.default_rng(1).normal(size=(200, 3)), bounces=5)
        self.assertGreater(ends["bounces"].max(), 0)
        self.assertLess(ends["weight"].min(), 1)


class ListTest(unittest.TestCase):
    def test_lists_are_those_of_the_program(self):
        for topic, function in (("hamiltonians", kagero.hamiltonians), ("integrators", kagero.integrators),
                                ("layers", kagero.layers)):
            expected = json.loads(run_program("list", topic, "--json"))[topic]
            self.assertEqual(list(function().values()), expected)

    def test_explanation_is_that_of_the_program(self):
        explanation = kagero.load(SCENES / "room.toml").explain()
        self.assertEqual(str(explanation).strip(), run_program("explain", SCENES / "room.toml", "--quiet").strip())
        self.assertEqual(explanation["strategy"], "packet")

    def test_printed_scene_is_that_of_the_program(self):
        printed = run_program("print", SCENES / "kerr.toml")
        self.assertEqual(kagero.load(SCENES / "kerr.toml").toml().strip().split("\n")[5:],
                         printed.strip().split("\n")[5:])

    def test_study(self):
        study = kagero.scene(HOLE).error(sample=(4, 4), quick=True)
        self.assertGreater(len(study["curves"]), 2)
        self.assertEqual(study["sample"]["rays"], 16)


class SceneTest(unittest.TestCase):
    def test_dict_is_the_same_scene_as_its_text(self):
        scene = kagero.scene(HOLE)
        with tempfile.NamedTemporaryFile("w", suffix=".toml") as file:
            file.write(scene.text)
            file.flush()
            np.testing.assert_array_equal(kagero.load(file.name).render()["color"], scene.render()["color"])

    def test_overrides_of_all_types(self):
        scene = kagero.scene(HOLE, {"sky.checker": True})
        changed = scene.override({"space.rg": np.float64(0.5), "film.size": np.array([8, 4]), "camera.type":
                                  "equirectangular", "object.ball.color": (1, 0.5, 0), "sky.checker": False,
                                  "film.seed": np.int32(3)})
        self.assertEqual(changed.render()["color"].shape, (4, 8, 3))
        self.assertEqual(scene.render()["color"].shape, (24, 32, 3))
        self.assertIn("rg = 0.5", changed.toml())

    def test_quotes_and_line_breaks_in_texts(self):
        tables = dict(HOLE, object=[dict(HOLE["object"][0], name='a "b"\n\t\\ \x7f é')])
        ends = kagero.scene(tables).trace([3, 0, 9], [0, 0, -1])
        self.assertEqual(ends["object"][0], 'a "b"\n\t\\ \x7f é')

    def test_pickle(self):
        scene = kagero.scene(HOLE, {"space.rg": 0.25})
        copy = pickle.loads(pickle.dumps(scene))
        self.assertEqual((copy.file, copy.text, copy.overrides), (scene.file, scene.text, scene.overrides))
        np.testing.assert_array_equal(copy.render()["color"], scene.render()["color"])
        result = pickle.loads(pickle.dumps(scene.render()))
        self.assertEqual(result.report["rays"], 32 * 24)

    def test_text_representations(self):
        scene = kagero.scene(HOLE, {"space.rg": 0.25})
        for part in ("schwarzschild", "1 object", "32 x 24", "space.rg=0.25"):
            self.assertIn(part, repr(scene))
        self.assertTrue(scene._repr_png_().startswith(b"\x89PNG"))
        self.assertIn("color: float32[24, 32, 3]", repr(scene.render()))

    def test_warnings_are_those_of_the_program(self):
        scene = kagero.scene(HOLE, {"integrator.max_steps": 2})
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            result = scene.render()
        texts = [str(warning.message) for warning in caught]
        self.assertEqual(texts, result.warnings)
        self.assertIn("max_steps", "".join(texts))
        self.assertEqual({warning.category for warning in caught}, {kagero.RunWarning})
        self.assertEqual({pathlib.Path(warning.filename).name for warning in caught}, {"results_test.py"})

    def test_sweep_equals_single_scenes(self):
        scene = kagero.scene(HOLE)
        radii = [0.5, 1.0, 1.5]
        direction = np.array([[1, 0.3, 0], [1, 0, 0.4]])
        ends = kagero.sweep(scene, {"space.rg": radii}, [-8, 0, 0], direction, columns=["status", "dy"])
        self.assertEqual(ends["dy"].shape, (3, 2))
        for i, radius in enumerate(radii):
            single = scene.override({"space.rg": radius}).trace([-8, 0, 0], direction)
            np.testing.assert_array_equal(ends["dy"][i], single["dy"])

    def test_sweep_of_several_keys_with_warnings(self):
        calls = []
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            ends = kagero.sweep(kagero.scene(HOLE), {"space.rg": (0.5, 1.0), "integrator.max_steps": [3, 1000]},
                                [-8, 0, 0], [1, 0.5, 0], progress=lambda done, seconds: calls.append(done))
        self.assertEqual(list(ends["status"][:, 0]), [kagero.Status.step_limit, kagero.Status.escaped])
        self.assertEqual({pathlib.Path(warning.filename).name for warning in caught}, {"results_test.py"})
        self.assertEqual(calls, sorted(calls))


if __name__ == "__main__":
    unittest.main()
