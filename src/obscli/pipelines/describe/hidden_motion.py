"""What becomes of hidden errors over a period or window, and the Riccati equation from two priors."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import inf, log
from typing import Final

from obscli.checks.detectability import Detectability
from obscli.core.document import Block, Column, Note, Paragraph, Table, Text, line, plain
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
#: So many states are shown in the cross-check, those whose deviations end most apart.
MOST_SHOWN: Final = 3
CROSS_CHECK_LEGEND: Final = (
    "Standard deviations of the Kalman filter from P0 / from 4 P0 along the interval; apart: how far the two "
    "covariances are apart, 1 at the start. Where what is hidden dies out, it goes to 0."
)


def motion_blocks(found: Detectability, system: System) -> Iterator[Block]:
    """Yield by how much hidden errors change over a period or window."""
    motion = found.motion
    if motion is None:
        return
    rows = tuple(
        (
            line(Text(short(gain, 6))),
            line(Text(short(_exponent(gain, motion), 3))),
            line(Text(_numbers(one, system))),
        )
        for gain, one in zip(motion.gains, motion.directions, strict=True)
    )
    yield Table(MOTION_COLUMNS, rows, (Text(MOTION_LEGEND, "faint"),))
    if found.of.period is not None:
        multipliers = ", ".join(_complex(one) for one in motion.multipliers)
        yield Paragraph(plain(f"Floquet multipliers over the period: {multipliers}."))


def _exponent(gain: float, motion: HiddenMotion) -> float:
    return log(gain) / (motion.stop - motion.start) if gain else -inf


def _numbers(direction: Mapping[str, float], system: System) -> str:
    return ", ".join(
        f"{name}: {short(direction[name], 4)}" for name in system.state_names if name in direction
    )


def _complex(value: complex) -> str:
    real = short(value.real, 6)
    return real if not value.imag else f"{real} {'+-'[value.imag < 0]} {short(abs(value.imag), 6)}i"


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
    if found.assumed:
        yield Note(
            "note", plain(f"no prior in the file for {', '.join(found.assumed)}: taken as its scale, or 1")
        )
