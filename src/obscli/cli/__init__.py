"""The command line. ``run`` is what the installed ``obscli`` calls; everything else is imported inside it."""

from __future__ import annotations

import os
import sys
from typing import Final, NoReturn


#: Matrices of some hundred states gain nothing from threads, which spin while they wait.
ONE_THREAD: Final = ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


def run() -> NoReturn:
    """Run the command line of this process and leave with its exit code."""
    for name in ONE_THREAD:
        os.environ.setdefault(name, "1")
    try:
        from obscli.cli.boundary import main  # noqa: PLC0415 - an interrupt while importing is caught too

        status = main(sys.argv[1:])
    except KeyboardInterrupt:
        sys.stderr.write("obscli: interrupted\n")
        status = 130
    sys.exit(status)
