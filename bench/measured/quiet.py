"""Detects whether other programs slow the processor down. On a shared host, a slowdown can last for minutes. Code
that uses all execution units of a core is slowed down more than code that is limited by latency, so ratios of times
change."""
import time

TOLERANCE = 1.05     # the processor is busy if a calibration step takes longer than this times the shortest one
CALIBRATION = 30     # seconds of calibration steps before the first measurement
PAUSE = 5            # seconds between two calibration steps while the processor is busy
ATTEMPTS = 3         # greatest number of attempts at a measurement that is disturbed


class Quiet:
    """Repeats disturbed measurements, and delays them until the processor is quiet. All delays together take at most
    `minutes`; 0: measurements are neither delayed nor repeated."""

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
        """Times a calibration step, and returns True if it takes about as long as the shortest one so far. The
        calibration step is a step of `verlet` on packets of doubles, which uses all execution units of a core."""
        row, = self.program.benchmark(f"bench_kernels_{self.program.isa}",
                                      "--benchmark_filter=^step/schwarzschild_rescaled/verlet/packet_double$",
                                      "--benchmark_min_time=0.1")
        self.last = row["s/step"]
        self.least = min(self.least, self.last)
        return self.last <= TOLERANCE * self.least

    def wait(self):
        """Returns when the processor is quiet or the time for delays is used up."""
        begin = time.monotonic()
        while time.monotonic() - begin < self.seconds_left:
            if self.is_quiet():
                break
            time.sleep(PAUSE)
        self.seconds_left = max(0, self.seconds_left - (time.monotonic() - begin))

    def measured(self, measure):
        """Returns the result of `measure`. Repeats the measurement if the processor is busy at its end."""
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
        """Returns the number of undisturbed measurements and the times of the calibration steps, for the data file."""
        if not self.steps:
            return {}
        return {"undisturbed": self.undisturbed, "measurements": self.total,
                "calibration_step_ns": {"min": 1e9 * min(self.steps), "max": 1e9 * max(self.steps)}}
