"""Whether the processor is as quick as it can be: where others share the host it is not, for minutes at a time, and code that fills a core
loses more by it than code that waits for its own results. Ratios shift then as well."""
import time

SLOWER = 1.05        # than ever before in this run: others are at work
CALIBRATION = 30     # seconds
PAUSE = 5            # seconds between two looks
TRIES = 3            # of a measurement that was disturbed


class Quiet:
    """Waits for quiet, up to so many minutes in all; 0: never."""

    def __init__(self, program, minutes):
        self.program = program
        self.minutes = minutes
        self.left = 60 * minutes
        self.least = float("inf")
        self.quiet = self.all = 0
        self.steps = []  # seconds, of the step below, after each measurement
        end = time.monotonic() + (CALIBRATION if minutes else 0)
        while time.monotonic() < end:
            self.now()

    def now(self):
        """A step of `verlet` on packets of doubles fills a core."""
        row, = self.program.benchmark(f"bench_kernels_{self.program.isa}", "--benchmark_filter=^step/schwarzschild_rescaled/verlet/packet_double$",
                                      "--benchmark_min_time=0.1")
        self.last = row["s/step"]
        self.least = min(self.least, self.last)
        return self.last <= SLOWER * self.least

    def wait(self):
        begin = time.monotonic()
        while time.monotonic() - begin < self.left:
            if self.now():
                break
            time.sleep(PAUSE)
        self.left = max(0, self.left - (time.monotonic() - begin))

    def measured(self, measure):
        """What `measure` returns, if possible of a time that was quiet when it began and when it ended."""
        for _ in range(TRIES if self.minutes else 1):
            self.wait()
            found = measure()
            quiet = self.now()
            if quiet or self.left == 0:
                break
        self.quiet += quiet
        self.all += 1
        self.steps.append(self.last)
        return found

    def story(self):
        if not self.steps:
            return []
        waited = "; where it was not they waited, and took up to three tries" if self.minutes else ""
        return [f"- others on the host: after the measurements a step of `verlet` on a packet of doubles took {1e9 * min(self.steps):.1f} to {1e9 * max(self.steps):.1f} ns a ray, "
                f"and {self.quiet} of {self.all} times no more than {100 * SLOWER - 100:.0f} % above the least of the run{waited}"]
