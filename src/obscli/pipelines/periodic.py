"""The Floquet–Lyapunov form of a system that algebra finds no stationary form of, where it is periodic."""

from __future__ import annotations

from typing import TYPE_CHECKING

from obscli.exact.errors import UndecidedError, UndefinedError
from obscli.exact.period import period
from obscli.exact.prove import prove
from obscli.model.specialise import at_nominal
from obscli.model.system import System


if TYPE_CHECKING:
    from obscli.numeric.finding import NotComputed
    from obscli.numeric.floquet_finding import Floquet


def periodic_form(system: System) -> Floquet | NotComputed | None:
    """Return the form in numbers, why there is none, or None where the system is not periodic."""
    try:
        found = period(prove(system, range(system.n)))
    except (UndecidedError, UndefinedError):
        return None
    if found is None:
        return None
    from obscli.numeric.errors import NotComputableError  # noqa: PLC0415 - floating point only where it is needed
    from obscli.numeric.finding import NotComputed  # noqa: PLC0415
    from obscli.numeric.floquet import floquet  # noqa: PLC0415
    from obscli.numeric.horizon import Wanted, horizon_of  # noqa: PLC0415

    try:
        return floquet(at_nominal(system).system(), horizon_of(system, Wanted()).start, found)
    except NotComputableError as error:
        return NotComputed(str(error))
