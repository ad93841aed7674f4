"""The Floquet–Lyapunov reduction: multipliers over a period, the constant equivalent, how well it holds."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from obscli.core.document import Block, Cell, Column, Note, Table, Text, VerdictLine, line, plain
from obscli.core.number import short
from obscli.numeric.finding import FloquetMode, NotComputed
from obscli.numeric.floquet_finding import Equivalent, Floquet
from obscli.pipelines.describe.hidden_motion import FLOQUET_COLUMNS


MULTIPLIER_LEGEND: Final = (
    "Over a period each of these directions is multiplied by its Floquet multiplier, an eigenvalue of the "
    "transition matrix over the period (a pair of complex ones: turned and multiplied by their modulus); "
    "exponent: ln(multiplier)/period."
)
EQUIVALENT_LEGEND: Final = "R of z' = R z in numbers, the states in the file's units; 0 where it is rounding."

#: R is shown of so many states at the most.
MOST_STATES: Final = 8

_DIGITS: Final = 6


def floquet_blocks(found: Floquet) -> Iterator[Block]:
    """Yield the multipliers, R where it is small, and one line that says what holds."""
    yield Table(FLOQUET_COLUMNS, tuple(map(_mode, found.modes)), (Text(MULTIPLIER_LEGEND, "faint"),))
    match found.equivalent:
        case NotComputed(reason):
            yield VerdictLine("open", plain(f"no constant equivalent in numbers: {reason}"))
        case Equivalent() as equivalent:
            yield VerdictLine("good", plain(equivalent_words(found, equivalent)))
            yield _equivalent(found, equivalent)


def equivalent_words(found: Floquet, equivalent: Equivalent) -> str:
    """Return what the change of variables does, in one sentence with its figures."""
    period = short((2 if equivalent.doubled else 1) * found.period, _DIGITS)
    why = (
        " (two periods of A: a multiplier is on the negative real axis, or near)"
        if equivalent.doubled
        else ""
    )
    return (
        f"x = P(t) z, P(t) of period {period}{why}, makes the system stationary: z' = R z; residual over the "
        f"next period {short(equivalent.residual)}, condition of P {short(equivalent.condition)}"
    )


def _mode(one: FloquetMode) -> tuple[Cell, ...]:
    direction = ", ".join(f"{name}: {short(value, 4)}" for name, value in one.direction.items())
    return (
        line(Text(_complex(one.multiplier, _DIGITS))),
        line(Text(_complex(one.exponent, 3))),
        line(Text(one.kind)),
        line(Text(direction)),
    )


def _equivalent(found: Floquet, equivalent: Equivalent) -> Block:
    n = len(found.states)
    if n > MOST_STATES:
        return Note("note", plain(f"R is {n} by {n}: JSON has it, with P(t) at instants"))
    columns = (Column(), *(Column(f"z_{name}", "right") for name in found.states))
    rows = tuple(
        (
            line(Text(f"z_{name}'", "name")),
            *(
                line(Text(short(value if abs(value) > error else 0.0, _DIGITS)))
                for value, error in zip(row, errors, strict=True)
            ),
        )
        for name, row, errors in zip(
            found.states, equivalent.R.tolist(), equivalent.R_error.tolist(), strict=True
        )
    )
    return Table(columns, rows, (Text(EQUIVALENT_LEGEND, "faint"),))


def _complex(value: complex, digits: int) -> str:
    real = short(value.real, digits)
    if not value.imag:
        return real
    return f"{real} {'+-'[value.imag < 0]} {short(abs(value.imag), digits)}i"
