"""The options of the numerical side, put together."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, cast

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
    """Return the request; the choices were checked by their options."""
    from obscli.pipelines.request import NumericRequest  # noqa: PLC0415 - heavy imports inside command bodies

    return NumericRequest(
        start=start,
        stop=stop,
        samples=samples,
        times=names(times),
        method=cast("Method", method),
        rtol=rtol,
        scaling=cast("Scaling | None", scaling),
    )
