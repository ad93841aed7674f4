"""The one place where an error becomes a message and an exit code."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from obscli.cli.errors import CommandError
from obscli.cli.exit_codes import ExitCode
from obscli.core.place import ModelError
from obscli.core.visible import visible


def main(arguments: Sequence[str]) -> int:
    """Run one command line; return its exit code, whatever happens."""
    try:
        status = _dispatch(arguments)
    except ModelError as error:
        complain("\n".join(str(problem) for problem in error.problems) or "the model cannot be read")
        return ExitCode.USAGE
    except CommandError as error:
        complain(f"obscli: {error}")
        return ExitCode.USAGE
    except KeyboardInterrupt:
        status = ExitCode.INTERRUPTED
    except Exception as error:  # noqa: BLE001 - the boundary: nothing gets past it
        return _unforeseen(error)
    if status == ExitCode.INTERRUPTED:
        complain("obscli: interrupted")
    return status


def _dispatch(arguments: Sequence[str]) -> int:
    from obscli.cli.app import app  # noqa: PLC0415 - so that errors while importing are reported as well

    try:
        status = app(list(arguments), prog_name="obscli", standalone_mode=False)
    except SystemExit as leaving:
        status = leaving.code
    return status if isinstance(status, int) else ExitCode.DONE


def _unforeseen(error: Exception) -> int:
    """Report wrong usage, which the command line's library raises, or an error of obscli itself."""
    show = getattr(error, "show", None)
    if callable(show) and hasattr(error, "format_message"):
        show()
        return ExitCode.USAGE
    if type(error).__name__ == "Abort":
        return ExitCode.INTERRUPTED
    import traceback  # noqa: PLC0415

    complain("".join(traceback.format_exception(error)).rstrip())
    complain(
        "obscli: internal error: this is a bug in obscli, not in your model. "
        "Please report it with the lines above and the model file."
    )
    return ExitCode.INTERNAL


def complain(message: str) -> None:
    """Write a message to stderr, nothing in it able to control the terminal."""
    shown = visible(message, keep="\n") + "\n"
    encoding = sys.stderr.encoding or "utf-8"
    try:
        sys.stderr.write(shown.encode(encoding, "backslashreplace").decode(encoding))
        sys.stderr.flush()
    except BrokenPipeError:
        pass
