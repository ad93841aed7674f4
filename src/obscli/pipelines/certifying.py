"""The certified rank of a stage: at which instants, through which stationary system, or why not."""

from __future__ import annotations

from typing import Final

from obscli.checks.certified_rank import CertifiedInstant, CertifiedRank, certified_rank
from obscli.exact.finding import Analysis, Undecided
from obscli.exact.stationary_form import lift_of
from obscli.model.system import System
from obscli.numeric.errors import NotComputableError
from obscli.numeric.horizon import Horizon, horizon_of
from obscli.pipelines.numerical import settings_of
from obscli.pipelines.request import NumericRequest, Progress


#: Instants where the user gives none: so many of those of the Gramian, the first and the last among them.
INSTANTS: Final = 5


def certified(
    system: System, finding: Analysis | Undecided | None, request: NumericRequest, progress: Progress
) -> CertifiedRank:
    """Return the rank of the Gramian at instants, proved in ball arithmetic, or why it is not.

    Raises
    ------
    ModelError
        where an instant is no expression in the names of the system
    """
    try:
        horizon = horizon_of(system, settings_of(system, request).wanted)
    except NotComputableError as error:
        return CertifiedRank(0.0, (), str(error))
    instants = _instants(horizon, chosen=bool(request.times))
    progress("a stationary system with the same outputs")
    rank, lift = _rank(finding), lift_of(system)
    if isinstance(rank, str) or isinstance(lift, str):
        reason = rank if isinstance(rank, str) else str(lift)
        none = tuple(CertifiedInstant(t, None, None, reason) for t in instants)
        return CertifiedRank(horizon.start, none, reason)
    progress("the rank in ball arithmetic")
    return certified_rank(system, lift, rank, horizon.start, instants)


def _instants(horizon: Horizon, *, chosen: bool) -> list[float]:
    instants = [float(t) for t in horizon.instants]
    last = len(instants) - 1
    if chosen or last < INSTANTS:
        return instants
    return [instants[last * k // (INSTANTS - 1)] for k in range(INSTANTS)]


def _rank(finding: Analysis | Undecided | None) -> int | str:
    """Return the proved rank at the file's values, or why there is none."""
    if not isinstance(finding, Analysis):
        reason = finding.reason if isinstance(finding, Undecided) else "it was not asked for"
        return f"the exact rank is undecided: {reason}"
    at = finding.at_values
    return f"the exact rank at the file's values is undecided: {at.reason}" if at.rank is None else at.rank
