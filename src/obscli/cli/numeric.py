"""The options of the numerical side, put together."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, cast

from obscli.cli.errors import CommandError
from obscli.cli.texts import names


if TYPE_CHECKING:
    from obscli.pipelines.request import Method, NumericRequest, Scaling


def numeric_request(
    *,
    start: str | None,
    stop: str | None,
    samples: int | None,
    times: Sequence[str] | None,
    method: str,
    rtol: float | None,
    scaling: str | None,
) -> NumericRequest:
    """Return the request; the choices were checked by their options.

    Raises
    ------
    CommandError
        where the instants are given and counted too
    """
    from obscli.pipelines.request import NumericRequest  # noqa: PLC0415 - heavy imports inside command bodies

    if times and (stop is not None or samples is not None):
        raise CommandError("--times gives the instants themselves; leave out --to and --samples")

    return NumericRequest(
        start=start,
        stop=stop,
        samples=samples,
        times=names(times),
        method=cast("Method", method),
        rtol=rtol,
        scaling=cast("Scaling | None", scaling),
    )


def forbid_numeric(numeric: NumericRequest, plot: Path | None, where: str) -> None:
    """Refuse options about the Gramian where none is found.

    Raises
    ------
    CommandError
        where there is such an option
    """
    from obscli.pipelines.request import NumericRequest  # noqa: PLC0415

    if plot is not None or numeric != NumericRequest():
        raise CommandError(f"{where} finds no Gramian; leave out --plot and what is about the Gramian")
