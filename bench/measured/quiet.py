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
        end = time.monotonic() + (CALIBRATION if minutes else 0)
        while time.monotonic() < end:
            self.now()

    def now(self):
        """A step of `verlet` on packets of doubles fills a core."""
        row, = self.program.benchmark(f"bench_kernels_{self.program.isa}", "--benchmark_filter=^step/schwarzschild_rescaled/verlet/packet_double$",
                                      "--benchmark_min_time=0.1")
        self.least = min(self.least, row["s/step"])
        return row["s/step"] <= SLOWER * self.least

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
            if self.minutes and self.now():
                self.quiet += 1
                break
            if self.left == 0:
                break
        self.all += 1
        return found

    def story(self):
        if not self.minutes:
            return []
        return [f"- others on the host: {self.quiet} of {self.all} measurements ended with the processor within {100 * SLOWER - 100:.0f} % of the quickest that it was in this run "
                "(a step of `verlet`; where it had not, they waited, and took up to three tries)"]
