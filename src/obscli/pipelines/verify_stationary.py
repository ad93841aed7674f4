"""The stationary system as a witness: the same observable combinations, and the sizes that are expected.

It knows nothing of the differentiation and elimination over functions of time that the analysis rests on: its
observability matrix is that of a time-invariant system, over the constants.
"""

from __future__ import annotations

from collections.abc import Iterator

from obscli.core.check import CheckResult
from obscli.core.number import counted
from obscli.core.place import Place
from obscli.exact.errors import JetOverflowError, UndecidedError, UndefinedError
from obscli.exact.finding import Analysis, Undecided
from obscli.exact.lift_finding import NotReducible, Stationary
from obscli.exact.prove import prove
from obscli.exact.stationary import stationary_of
from obscli.model.system import ExpectedStationary, Lifted, System


def check_stationary(system: System, finding: Analysis | Undecided) -> Iterator[CheckResult]:
    """Yield whether the stationary system of one that varies agrees with its analysis, and what is expected.

    Nothing where the system does not vary or is not reducible, and nothing is expected.
    """
    expected = [claim.stationary for claim in system.claims if claim.stationary is not None]
    if not expected and (isinstance(finding, Undecided) or not finding.varying):
        return
    try:
        found = stationary_of(prove(system, range(system.n)))
    except (JetOverflowError, UndecidedError, UndefinedError) as error:
        for one in expected:
            yield CheckResult("stationary systems", "undecided", str(error), one.place)
        return
    if isinstance(found, Stationary):
        yield _agreement(found)
    for one in expected:
        yield from _sizes(found, one)


def _agreement(found: Stationary) -> CheckResult:
    equations = counted(found.smallest.n, "time-invariant equation")
    claim = f"a stationary system of {equations} has the same observable combinations"
    reason = f"{counted(len(found.combinations), 'combination')}, mapped back by z = V(t) x"
    return CheckResult(claim, "holds" if found.agrees else "fails", reason)


def _sizes(found: Stationary | NotReducible, expected: ExpectedStationary) -> Iterator[CheckResult]:
    if isinstance(found, NotReducible) or not expected.reducible:
        claim = "reducible" if expected.reducible else "not reducible"
        holds = isinstance(found, Stationary) == expected.reducible
        reason = (
            f"{found.obstacles[0].entry}: {found.obstacles[0].reason}"
            if isinstance(found, NotReducible) and found.obstacles
            else "a stationary system was found"
            if isinstance(found, Stationary)
            else ""
        )
        yield CheckResult(claim, "holds" if holds else "fails", reason, expected.place)
        return
    for which, (size, place) in expected.sizes.items():
        yield _size(found, which, size, place)


def _size(found: Stationary, which: Lifted, expected: int, place: Place) -> CheckResult:
    """Compare the size of one stationary system."""
    sizes: dict[Lifted, int | None] = {
        "full": None if found.full is None else found.full.n,
        "smallest": found.smallest.n,
        "outputs": found.observable.n,
        "same_order": None if found.same_order is None else found.same_order.n,
    }
    actual = sizes[which]
    claim = f"stationary: {which} has {counted(expected, 'state')}"
    reason = "there is none" if actual is None else f"it has {actual}"
    return CheckResult(claim, "holds" if actual == expected else "fails", reason, place)
