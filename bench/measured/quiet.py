"""Detects whether other programs slow the processor down. On a shared host that happens for minutes at a time. It
costs code that fills a core more than code that waits for its own results, so that ratios shift as well."""
import time

TOLERANCE = 1.05     # a calibration step that takes more than this times the least one means that the host is busy
CALIBRATION = 30     # seconds
PAUSE = 5            # seconds between two checks
ATTEMPTS = 3         # at a measurement that was disturbed


class Quiet:
    """Repeats disturbed measurements, and waits for a quiet processor for at most `minutes` in all (0: never)."""

    def __init__(self, program, minutes):
        self.program = program
        self.minutes = minutes
        self.seconds_left = 60 * minutes
        self.least = float("inf")
        self.undisturbed = self.total = 0
        self.steps = []  # seconds per calibration step, after each measurement
        end = time.monotonic() + (CALIBRATION if minutes else 0)
        while time.monotonic() < end:
            self.is_quiet()

    def is_quiet(self):
        """Times a step of `verlet` on packets of doubles, which fills a core, and compares it with the least time."""
        row, = self.program.benchmark(f"bench_kernels_{self.program.isa}",
                                      "--benchmark_filter=^step/schwarzschild_rescaled/verlet/packet_double$",
                                      "--benchmark_min_time=0.1")
        self.last = row["s/step"]
        self.least = min(self.least, self.last)
        return self.last <= TOLERANCE * self.least

    def wait(self):
        begin = time.monotonic()
        while time.monotonic() - begin < self.seconds_left:
            if self.is_quiet():
                break
            time.sleep(PAUSE)
        self.seconds_left = max(0, self.seconds_left - (time.monotonic() - begin))

    def measured(self, measure):
        """Returns the result of `measure`, if possible from a time that was quiet at its beginning and at its end."""
        for _ in range(ATTEMPTS if self.minutes else 1):
            self.wait()
            found = measure()
            quiet = self.is_quiet()
            if quiet or self.seconds_left == 0:
                break
        self.undisturbed += quiet
        self.total += 1
        self.steps.append(self.last)
        return found

    def summary(self):
        """Returns the data by which a reader judges how far other programs disturbed the run."""
        if not self.steps:
            return {}
        return {"undisturbed": self.undisturbed, "measurements": self.total,
                "calibration_step_ns": {"min": 1e9 * min(self.steps), "max": 1e9 * max(self.steps)}}
