"""Display of the progress of runs."""
import sys

from ._errors import InputError
from ._toml import _shown


class _Bar:
    """A progress bar of tqdm; without tqdm, lines on stderr for each tenth."""

    def __init__(self):
        self._bar = None
        self._done = 0.0
        self._tenths = 0
        try:
            from tqdm.auto import tqdm
            self._tqdm = tqdm
        except ImportError:
            self._tqdm = None

    def __call__(self, done, seconds):
        if done < self._done:  # the trial rays are finished, and the picture begins
            self.close()
        if self._tqdm is None:
            if int(10 * done) > self._tenths:
                self._tenths = int(10 * done)
                print(f"kagero: {self._tenths * 10} % after {seconds:.1f} s", file=sys.stderr)
        else:
            if self._bar is None:
                self._bar = self._tqdm(total=1.0, bar_format="{l_bar}{bar}| {elapsed}<{remaining}")
            self._bar.update(done - self._done)
        self._done = done

    def close(self):
        if self._bar is not None:
            self._bar.close()
        self._bar, self._done, self._tenths = None, 0.0, 0


class Progress:
    """A context that supplies the callback for the argument `progress`: None, False, True or a callable."""

    def __init__(self, progress):
        self._bar = None
        if progress is None or progress is False:
            self.callback = None
        elif progress is True:
            self.callback = self._bar = _Bar()
        elif callable(progress):
            self.callback = progress
        else:
            raise InputError(f"progress is {_shown(progress)}; expected True, False or a function of done and seconds")

    def __enter__(self):
        return self.callback

    def __exit__(self, *exception):
        if self._bar is not None:
            self._bar.close()
