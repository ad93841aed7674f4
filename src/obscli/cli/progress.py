"""What is being done, on stderr, once a command takes longer than a second."""

from __future__ import annotations

import shutil
import sys
import threading
import time
from types import TracebackType
from typing import Final, Self

from obscli.core.visible import visible


#: Seconds before anything is shown, and between two looks at the clock.
PATIENCE: Final = 1.0
BEAT: Final = 0.5


class ProgressLine:
    """One line that is rewritten on a terminal; elsewhere a line for each new step.

    Used as a context manager; calling it names the step being done. Nothing is left on a terminal at the end.
    """

    def __init__(self) -> None:
        self._start = time.monotonic()
        self._step = ""
        self._shown = ""
        self._done = threading.Event()
        self._terminal = sys.stderr.isatty()
        self._thread = threading.Thread(target=self._watch, daemon=True)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __call__(self, step: str) -> None:
        """Name what is being done now."""
        self._step = visible(step)

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._done.set()
        self._thread.join(timeout=BEAT)
        if self._terminal and self._shown:
            self._write("\r\x1b[K")

    def _watch(self) -> None:
        wait = PATIENCE
        while not self._done.wait(wait):
            wait = BEAT
            self._show()

    def _show(self) -> None:
        if self._terminal:
            width = shutil.get_terminal_size().columns - 1
            self._shown = f"{self._step} … {time.monotonic() - self._start:.0f} s"[:width]
            self._write(f"\r\x1b[K{self._shown}")
        elif self._step != self._shown:
            self._shown = self._step
            self._write(f"obscli: {self._step}\n")

    @staticmethod
    def _write(text: str) -> None:
        try:
            sys.stderr.write(text)
            sys.stderr.flush()
        except (OSError, ValueError, UnicodeError):
            return
