"""What becomes of hidden errors over a period or window, and the Riccati equation from two priors."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Final

from obscli.checks.detectability import Detectability, factor_text
from obscli.checks.riccati import RiccatiWord, riccati_word
from obscli.core.document import Block, Column, Kind, Note, Table, Text, VerdictLine, line, plain
from obscli.core.number import short
from obscli.model.system import System
from obscli.numeric.finding import CrossCheck, HiddenMotion, NotComputed
from obscli.pipelines.stage_result import StageResult


MOTION_COLUMNS: Final = (
    Column("factor", "right"),
    Column("exponent", "right"),
    Column("direction at the start", breaks=True),
)
MOTION_LEGEND: Final = (
    "Hidden errors change by these factors from the start to the end (singular values of the transition "
    "matrix on the unobservable subspace, states in units of their scale); exponent: ln(factor)/length."
)
FLOQUET_COLUMNS: Final = (
    Column("multiplier", "right"),
    Column("exponent", "right"),
    Column("kind"),
    Column("direction at the start", breaks=True),
)
FLOQUET_LEGEND: Final = (
    "Over a period each of these hidden errors is multiplied by its Floquet multiplier (a pair of complex "
    "ones: turned and multiplied by their modulus); exponent: ln(multiplier)/period."
)
#: So many states are shown in the cross-check, those whose deviations end most apart.
MOST_SHOWN: Final = 3
WORDS: Final[dict[str, Kind]] = {"agrees": "good", "denies": "bad", "silent": "open"}
CROSS_CHECK_LEGEND: Final = (
    "Standard deviations of the Kalman filter from P0 / from 4 P0 along the interval; apart: how far the two "
    "covariances are apart in units of P0, 1 before the first output. Where what is hidden dies out, it goes "
    "to 0; it never falls below the largest factor by which hidden errors change."
)


def motion_blocks(found: Detectability, system: System) -> Iterator[Block]:
    """Yield by how much hidden errors change over a period or window."""
    motion = found.motion
    if motion is None:
        return
    if motion.floquet:
        yield _floquet(motion, system)
        return
    rows = tuple(
        (
            line(Text(factor_text(motion, k, 6))),
            line(Text(short(motion.exponents[k], 3))),
            line(Text(_numbers(one, system))),
        )
        for k, one in enumerate(motion.directions)
    )
    yield Table(MOTION_COLUMNS, rows, (Text(MOTION_LEGEND, "faint"),))


def _floquet(motion: HiddenMotion, system: System) -> Table:
    rows = tuple(
        (
            line(Text(_complex(one.multiplier, 6))),
            line(Text(_complex(one.exponent, 3))),
            line(Text(one.kind)),
            line(Text(_numbers(one.direction, system))),
        )
        for one in motion.floquet
    )
    return Table(FLOQUET_COLUMNS, rows, (Text(FLOQUET_LEGEND, "faint"),))


def _numbers(direction: Mapping[str, float], system: System) -> str:
    return ", ".join(
        f"{name}: {short(direction[name], 4)}" for name in system.state_names if name in direction
    )


def _complex(value: complex, digits: int) -> str:
    real = short(value.real, digits)
    if not value.imag:
        return real
    return f"{real} {'+-'[value.imag < 0]} {short(abs(value.imag), digits)}i"


def said_by_riccati(result: StageResult) -> RiccatiWord | None:
    """Return what the cross-check says of the verdict at the file's values, None where there is none."""
    verdict = result.detectability_there or result.detectability
    if verdict is None or not isinstance(result.cross_check, CrossCheck):
        return None
    return riccati_word(verdict, result.cross_check, result.system)


def cross_check_blocks(result: StageResult) -> Iterator[Block]:
    """Yield the Riccati equation from two priors: the states that end most apart."""
    found = result.cross_check
    if isinstance(found, NotComputed):
        yield Note("note", plain(f"no cross-check by the Riccati equation: {found.reason}"))
    if not isinstance(found, CrossCheck):
        return
    names = sorted(found.deviations, key=lambda name: found.wider[name][-1] / found.deviations[name][-1])
    shown = [name for name in found.deviations if name in names[-MOST_SHOWN:]]
    columns = (Column("t", "right"), *(Column(name, "right") for name in shown), Column("apart", "right"))
    rows = tuple(
        (
            line(Text(short(t, 6))),
            *(
                line(Text(f"{short(found.deviations[name][k], 4)} / {short(found.wider[name][k], 4)}"))
                for name in shown
            ),
            line(Text(short(found.apart[k], 3))),
        )
        for k, t in enumerate(found.instants)
    )
    yield Table(columns, rows, (Text(CROSS_CHECK_LEGEND, "faint"),))
    word = said_by_riccati(result)
    if word is not None:
        yield VerdictLine(WORDS[word.word], plain(word.words))
    if found.assumed:
        yield Note(
            "note", plain(f"no prior in the file for {', '.join(found.assumed)}: taken as its scale, or 1")
        )
