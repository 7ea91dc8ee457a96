"""Signals, progress, threads, processes and the memory of large results."""
import multiprocessing
import signal
import threading
import time
import unittest
import warnings

from support import HOLE, LONG, run_python
import numpy as np
import kagero


def color_sum(scene):
    return float(scene.render()["color"].sum())


def resident_bytes():
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * 4096


class Interrupt:
    """A progress callback that sends Ctrl-C to the process, once, when a share of the run is done."""

    def __init__(self, share):
        self.share = share
        self.sent = False

    def __call__(self, done, seconds):
        if done >= self.share and not self.sent:
            self.sent = True
            signal.raise_signal(signal.SIGINT)


class SignalTest(unittest.TestCase):
    def interrupted(self, call):
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            return call(Interrupt(0.02)), [str(warning.message) for warning in caught]

    def test_render_returns_the_finished_pixels(self):
        scene = kagero.scene(LONG, {"integrator.step": 0.02})
        result, texts = self.interrupted(
            lambda progress: scene.render(["color", "steps"], precision="double", progress=progress))
        self.assertTrue(result.interrupted)
        finished = np.isfinite(result["steps"])
        self.assertTrue(0 < finished.sum() < finished.size, finished.sum())
        self.assertIn("interrupted", "".join(texts))

    def test_trace_returns_the_finished_rays(self):
        scene = kagero.scene(LONG, {"integrator.step": 0.02})
        directions = np.random.default_rng(1).normal(size=(200000, 3))
        result, texts = self.interrupted(
            lambda progress: scene.trace([-20, 0, 0], directions, columns=["status", "reason"], progress=progress))
        self.assertTrue(result.interrupted)
        untraced = result["reason"] == "the run was interrupted before this ray was traced"
        self.assertTrue(0 < untraced.sum() < untraced.size, untraced.sum())
        self.assertTrue((result["status"][untraced] == kagero.Status.failed).all())

    def test_trial_without_results_raises_keyboard_interrupt(self):
        tables = dict(LONG)
        del tables["integrator"]
        scene = kagero.scene(tables, {"space.spin": 1, "camera.position": [-1.02, 0, 0.3]})
        done = run_python(
            "from support import LONG\nimport kagero, signal, threading\n"
            "tables = dict(LONG, integrator={'max_pixel_error': 1e-9, 'escape_radius': 1e6, 'symmetry': 'none'})\n"
            "scene = kagero.scene(tables)\n"
            "threading.Timer(0.15, lambda: signal.raise_signal(signal.SIGINT)).start()\n"
            "try:\n    scene.explain()\n    print('finished')\nexcept KeyboardInterrupt:\n    print('interrupted')\n")
        self.assertEqual(done.stdout.strip(), "interrupted", done.stderr)

    def test_exceptions_of_handlers_and_callbacks_stop_the_run(self):
        scene = kagero.scene(LONG, {"integrator.step": 1e-4, "integrator.max_steps": 4000000000})

        def handler(*_):
            raise TimeoutError("alarm")
        previous = signal.signal(signal.SIGALRM, handler)
        try:
            signal.setitimer(signal.ITIMER_REAL, 0.3)
            with self.assertRaisesRegex(TimeoutError, "alarm"):
                scene.trace([-20, 0, 0], np.random.default_rng(1).normal(size=(20000, 3)))
        finally:
            signal.signal(signal.SIGALRM, previous)

        def fail(done, seconds):
            raise ArithmeticError("callback")
        with self.assertRaisesRegex(ArithmeticError, "callback"):
            kagero.scene(LONG, {"integrator.step": 0.05}).render(precision="double", progress=fail)


class ProgressTest(unittest.TestCase):
    def test_callback_receives_rising_fractions(self):
        calls = []
        kagero.scene(HOLE, {"film.size": [400, 400], "integrator.method": "gauss16", "integrator.step": 0.01}).render(
            precision="double", progress=lambda done, seconds: calls.append((done, seconds)))
        self.assertTrue(calls)
        self.assertEqual(calls, sorted(calls))
        self.assertTrue(all(0 <= done <= 1 for done, _ in calls))

    def test_bar(self):
        done = run_python("from support import HOLE\nimport kagero\n"
                          "kagero.scene(HOLE, {'film.size': [400, 400], 'integrator.method': 'gauss16', "
                          "'integrator.step': 0.01}).render(precision='double', progress=True)")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("%", done.stderr)

    def test_interpreter_runs_meanwhile(self):
        scene = kagero.scene(HOLE, {"film.size": [600, 600], "integrator.method": "gauss16", "integrator.step": 0.01})
        thread = threading.Thread(target=lambda: scene.render(precision="double"))
        thread.start()
        count = 0
        while thread.is_alive():
            time.sleep(0.001)
            count += 1
        self.assertGreater(count, 5)


class ThreadTest(unittest.TestCase):
    def test_threads_share_a_scene(self):
        scene = kagero.scene(HOLE)
        expected = color_sum(scene)
        results = []
        threads = [threading.Thread(target=lambda: results.append(color_sum(scene))) for _ in range(8)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(results, [expected] * 8)


class ProcessTest(unittest.TestCase):
    def test_fork_and_spawn(self):
        scenes = [kagero.scene(HOLE, {"space.rg": radius}) for radius in (0.5, 1.0, 1.5)]
        expected = [color_sum(scene) for scene in scenes]
        for method in ("fork", "spawn", "forkserver"):
            with self.subTest(method):
                with multiprocessing.get_context(method).Pool(2) as pool:
                    self.assertEqual(pool.map_async(color_sum, scenes).get(60), expected)
        self.assertEqual(color_sum(scenes[0]), expected[0])  # this process has not changed

    def test_fork_during_a_run_is_refused(self):
        done = run_python(
            "from support import LONG, HOLE\nimport kagero, os, threading, time\nimport numpy as np\n"
            "scene = kagero.scene(LONG)\n"
            "run = lambda: scene.trace([-20, 0, 0], np.random.default_rng(1).normal(size=(300000, 3)))\n"
            "threading.Thread(target=run, daemon=True).start()\ntime.sleep(0.5)\n"
            "child = os.fork()\n"
            "if child == 0:\n"
            "    try:\n        kagero.scene(HOLE).render()\n        os._exit(3)\n"
            "    except kagero.RunError as error:\n        os._exit(5 if 'spawn' in str(error) else 4)\n"
            "status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])\nprint(status, flush=True)\nos._exit(0)\n")
        self.assertEqual(done.stdout.strip(), "5", done.stderr)


class MemoryTest(unittest.TestCase):
    def test_large_results_are_freed(self):
        scene = kagero.scene(HOLE, {"film.size": [1000, 1000]})
        scene.render()
        before = resident_bytes()
        for _ in range(20):
            scene.render()  # 12 MB each
        self.assertLess(resident_bytes() - before, 30 << 20)


if __name__ == "__main__":
    unittest.main()
