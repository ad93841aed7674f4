"""Whether what no output shows dies out: decided by algebra where it can, else looked at on a window.

Algebra decides for all times. Over one period the Floquet multipliers decide, up to their error. A window
never proves anything beyond itself, and the verdict says so.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from math import inf, log
from typing import Final, Literal, TypeAlias

from obscli.core.number import counted, plain, short
from obscli.exact.structure_finding import Mode, Structure
from obscli.numeric.finding import HiddenMotion


DetectabilityVerdict: TypeAlias = Literal["observable", "detectable", "not detectable", "undecided"]

#: A window on which hidden errors shrink to this or less says that they die out there.
SHRUNK: Final = 0.5

#: The scope of what algebra decides.
ALL_TIMES: Final = "all times"


_PERSISTING: Final = (
    ("growing", "grows by itself", "grow by themselves"),
    ("neutral", "stays as it is", "stay as they are"),
)


@dataclass(frozen=True, slots=True, eq=False)
class Detectability:
    """A verdict, how far it reaches, and its grounds in words.

    ``scope``: ``all times``, ``every period of 6.28``, ``this window, 0 to 600``; ``of``: the structure that
    it is about; ``motion``: the hidden motion that was looked at. Where a generic verdict depends on
    parameters it is the one at the file's values.
    """

    verdict: DetectabilityVerdict
    scope: str
    words: str
    of: Structure
    motion: HiddenMotion | None = None

    @property
    def where(self) -> str:
        """The scope in a sentence: ``over every period of 6.28``, ``on this window, 0 to 600``."""
        return f"{'on' if self.scope.startswith('this') else 'over'} {self.scope}"


def exact_detectability(structure: Structure) -> Detectability:
    """Return what algebra says: for generic values, where these decide it, else at the file's values."""
    there = structure.at_values if structure.verdict == "depends" and structure.at_values else structure
    match there.verdict:
        case "observable" | "detectable" | "not detectable":
            return Detectability(there.verdict, ALL_TIMES, structure_words(there), there)
    return Detectability("undecided", ALL_TIMES, structure_words(there), there)


def is_followable(structure: Structure) -> bool:
    """Whether algebra leaves open what becomes of hidden directions that are known."""
    return structure.verdict == "undecided" and bool(structure.directions)


def seen_detectability(structure: Structure, motion: HiddenMotion) -> Detectability:
    """Return what the motion of hidden errors over a period, or on a window, says at the file's values."""
    if structure.period is not None:
        scope = f"every period of {short(motion.stop - motion.start, 4)}"
        verdict, words = _by_multipliers(motion)
    else:
        scope = f"this window, {plain(motion.start)} to {plain(motion.stop)}"
        verdict, words = _by_gains(motion)
    return Detectability(verdict, scope, words, structure, motion)


def _by_multipliers(motion: HiddenMotion) -> tuple[DetectabilityVerdict, str]:
    """Judge Floquet multipliers: all inside the unit circle, one outside, or not to be told."""
    largest, error = abs(motion.multipliers[0]), motion.multiplier_error
    modulus = f"the largest Floquet multiplier has modulus {short(largest, 4)} (error {short(error)})"
    if largest + error < 1:
        return "detectable", f"every hidden error dies out; {modulus}"
    if largest - error > 1:
        return "not detectable", f"a hidden error grows, and no output shows it; {modulus}"
    return "undecided", f"{modulus}, which cannot be told from 1"


def _by_gains(motion: HiddenMotion) -> tuple[DetectabilityVerdict, str]:
    """Judge the factors by which hidden errors change on a window (they may change again after it)."""
    largest = motion.gains[0]
    factor = f"the largest factor is {factor_text(motion, 0, 4)}"
    if largest <= SHRUNK:
        return "detectable", f"every hidden error shrinks; {factor}"
    if largest * (1 + motion.error) < 1:
        return "undecided", f"hidden errors shrink, but the window is too short to say more; {factor}"
    if largest * (1 - motion.error) > 1:
        return "not detectable", f"a hidden error grows, and no output shows it; {factor}"
    return "not detectable", f"a hidden error keeps its size, and no output shows it; {factor}"


def kind_of(logarithm: float, error: float) -> Literal["decaying", "neutral", "growing"]:
    """Return whether a factor γ is below 1, not to be told from 1, or above, given ln γ and its error."""
    if abs(logarithm) <= error:
        return "neutral"
    return "decaying" if logarithm < 0 else "growing"


def factor_text(motion: HiddenMotion, k: int, digits: int) -> str:
    """Return one of the factors as text, also where no number is so large or so small."""
    gain = motion.gains[k]
    if gain and gain < inf:
        return short(gain, digits)
    return f"10^{motion.exponents[k] * (motion.stop - motion.start) / log(10):.0f}"


def structure_words(structure: Structure) -> str:
    """Return the verdict of algebra with its grounds, in a sentence."""
    match structure.verdict:
        case "observable":
            return "nothing is hidden from the outputs"
        case "detectable":
            return f"every hidden error dies out by itself{_slowest(structure.modes)}"
        case "not detectable":
            return _persisting(structure)
        case "depends":
            return f"detectable iff {structure.condition}"
    return structure.reason


def _slowest(modes: tuple[Mode, ...]) -> str:
    times = [time for mode in modes if (time := time_constant(mode)) is not None]
    if not times:
        return ""
    if not any(mode.discrete for mode in modes):
        return f", the slowest with time constant {short(max(times), 3)}"
    if not max(times):
        return f", entirely within {counted(len(modes), 'step')}"
    return f", the slowest with a time constant of {short(max(times), 3)} steps"


def _persisting(structure: Structure) -> str:
    """Say which hidden error does not die out, the worst first."""
    for kind, *verbs in _PERSISTING:
        modes = [mode for mode in structure.modes if mode.kind == kind]
        if modes:
            hidden = f"{counted(len(modes), 'hidden direction')} {verbs[len(modes) > 1]}"
            return f"{hidden} (eigenvalue {_eigenvalues(modes)}), and no output shows it"
    return structure.reason or f"what is hidden never dies out (eigenvalue {_eigenvalues(structure.modes)})"


def _eigenvalues(modes: Iterable[Mode]) -> str:
    return ", ".join(dict.fromkeys(mode.eigenvalue for mode in modes))


def time_constant(mode: Mode) -> float | None:
    """Return in which time a mode falls to 1/e, or grows e-fold, at the file's values; None: neither.

    1/|Re s|; for a discrete-time system 1/|ln |s||, in steps, and 0 for s = 0.
    """
    if mode.discrete:
        moduli = [abs(value) for value in mode.values]
        if not moduli or mode.kind_there not in {"decaying", "growing"} or 1.0 in moduli:
            return None
        return max(1 / abs(log(one)) if one else 0.0 for one in moduli)
    reals = [abs(value.real) for value in mode.values]
    if not reals or mode.kind_there not in {"decaying", "growing"} or not min(reals):
        return None
    return 1 / min(reals)
