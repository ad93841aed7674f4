"""What the Riccati equation solved from two priors says of a verdict on detectability.

In units in which P0 = I the covariances from P0 and 4 P0 stay γ apart or more, γ the largest factor by which
hidden errors have changed, and γ ≥ ρ, the spectral radius. Hidden dynamics of a time-invariant system that
are not stable have ρ ≥ 1 at all times; so if the two come closer than they were, they are stable. Where all
that is hidden dies out the two meet, sooner or later; that they have not, on an interval, says nothing.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal

from obscli.checks.detectability import ALL_TIMES, SHRUNK, Detectability
from obscli.core.number import short
from obscli.model.expression import symbols
from obscli.model.system import System
from obscli.numeric.finding import CrossCheck


#: The difference of two covariances is known to half the digits.
_ROUNDING: Final = 1e-6


@dataclass(frozen=True, slots=True)
class RiccatiWord:
    """Whether the Riccati equation agrees with a verdict, in a word and in words."""

    word: Literal["agrees", "denies", "silent"]
    words: str


def riccati_word(found: Detectability, checked: CrossCheck, system: System) -> RiccatiWord:
    """Return what the distance of the two covariances says of a verdict.

    Parameters
    ----------
    found : the verdict, at the file's values
    checked : the two covariances
    system : whose verdict it is
    """
    last, least = checked.apart[-1], min(checked.apart)
    met = f"from P0 and 4 P0 the covariances end {short(last, 3)} apart"
    if found.verdict == "not detectable":
        if last >= 1 - _ROUNDING:
            return RiccatiWord("agrees", f"the Riccati equation agrees: {met}, no closer than they were")
        if least < 1 - _ROUNDING and found.scope == ALL_TIMES and _is_constant(system):
            closest = f"the covariances come as close as {short(least, 3)}"
            return RiccatiWord("denies", f"the Riccati equation denies it: {closest}")
    elif found.verdict != "undecided" and last <= SHRUNK:
        return RiccatiWord("agrees", f"the Riccati equation agrees: {met}")
    return RiccatiWord("silent", f"the Riccati equation does not tell on this interval: {met}")


def _is_constant(system: System) -> bool:
    moving = {system.time} | {one.name for one in system.functions}
    return not symbols(*system.A.entries.values(), *system.H.entries.values()) & moving
