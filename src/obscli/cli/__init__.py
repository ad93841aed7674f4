"""The command line. ``run`` is what the installed ``obscli`` calls; everything else is imported inside it."""

from __future__ import annotations

import sys
from typing import NoReturn


def run() -> NoReturn:
    """Run the command line of this process and leave with its exit code."""
    try:
        from obscli.cli.boundary import main  # noqa: PLC0415 - an interrupt while importing is caught too

        status = main(sys.argv[1:])
    except KeyboardInterrupt:
        sys.stderr.write("obscli: interrupted\n")
        status = 130
    sys.exit(status)
