"""The paper's table of what χ and r + q mean, applied in words.

    χ_i large at some times, or r + q_i ≠ n at some i      suspect an algebra error
    all χ_i small, r + q_i < n for all i                   a combination was probably forgotten
    r + q_i > n for all i                                  certainly an error

References
----------
V. M. Morozov, F. Yu. Baklanov (2018), verification of an analytic result, after step 5.
"""

from __future__ import annotations

from dataclasses import dataclass

from obscli.core.number import counted


@dataclass(frozen=True, slots=True)
class Seen:
    """What was seen: of ``count`` instants ``conclusive`` ones, at ``leaking`` of which χ exceeds its bound.

    ``surely``: by far; ``kernel``: q at the conclusive instants; ``above``: a rank above the exact one;
    ``expected``: the exact rank, where it is known; ``excited``: a rank below it that recorded signals show.
    """

    count: int
    conclusive: int
    leaking: int
    surely: bool
    rows: int
    kernel: int | None
    n: int
    above: int | None
    expected: int | None
    excited: int | None = None


def diagnose(seen: Seen) -> str:
    """Return the diagnosis in words."""
    if seen.above is not None:
        above = counted(seen.above, "direction")
        return (
            f"The Gramian shows {above} far above its tolerance, algebra {seen.expected}: "
            "one of the two sides is wrong. Please report it."
        )
    if seen.kernel is None and seen.excited is not None:
        return (
            f"The recorded signals show {counted(seen.excited, 'direction')} of the {seen.expected} that "
            "generic ones would: the rest is not excited."
        )
    if seen.kernel is None:
        return "At no instant is the Gramian clear enough: nothing can be said."
    total = seen.rows + seen.kernel
    early = _early(seen)
    if total > seen.n:
        return (
            f"r + q > n ({total} > {seen.n}) at all times: certainly an error, "
            f"{counted(total - seen.n, 'row')} too many or rows that are not observable.{early}"
        )
    if seen.leaking:
        fewer = f" And r + q < n ({total} < {seen.n}): rows are missing." if total < seen.n else ""
        return (
            f"χ is above its bound at {seen.leaking} of {seen.conclusive} instants: suspect an algebra error "
            f"in the combinations that leak.{fewer}{early}"
        )
    if total < seen.n:
        less = seen.n - total
        forgotten = "a combination was" if less == 1 else f"{less} combinations were"
        return f"All χ are small, r + q < n ({total} < {seen.n}) at all times: {forgotten} forgotten.{early}"
    if not seen.kernel:
        return f"q = 0: the Gramian has no kernel, every combination is observable.{early}"
    return f"All χ are below their bounds and r + q = n: nothing speaks against it.{early}"


def _early(seen: Seen) -> str:
    rest = seen.count - seen.conclusive
    if not rest:
        return ""
    return f" ({rest} of {seen.count} instants are not clear enough and are left out.)"
