"""The exit codes of the command line."""

from __future__ import annotations

from enum import IntEnum


class ExitCode(IntEnum):
    """What the exit code of obscli says."""

    DONE = 0
    FAILED = 1
    USAGE = 2
    INTERNAL = 3
    UNDECIDED = 4
    INTERRUPTED = 130
