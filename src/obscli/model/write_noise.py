"""``noise`` as text: a diagonal by names, a full matrix as rows.

What the file has no way to say is left out with a comment: correlations among some of the states where others
have no prior at all.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from math import isqrt
from typing import TYPE_CHECKING, Final

from obscli.model.expression import Expression, Number, Power
from obscli.model.write_text import Entry, entry_lines, formula


if TYPE_CHECKING:
    from obscli.model.system import Matrix, Noise, System

_PARTLY: Final = "given for some only, and correlated: a file cannot say that"


def noise_lines(system: System) -> Iterator[str]:
    """Yield the section ``noise``."""
    noise = system.noise
    if noise is None:
        return
    driven = system.disturbances if noise.driven == "disturbances" else system.state_names
    outputs = tuple(output.name for output in system.outputs)
    body = [*_square("Q", noise.Q, driven, filled=True), *_square("R", noise.R, outputs)]
    body += _prior(noise, system)
    if noise.step is not None:
        body += entry_lines("step", formula(noise.step), "  ")
    sampled: list[Entry] = [
        (name, formula(noise.signals[name])) for name in system.sampled if name in noise.signals
    ]
    if sampled:
        body += entry_lines("signals", sampled, "  ")
    if body:
        yield "noise:"
        yield from body


def _square(key: str, matrix: Matrix | None, names: Sequence[str], *, filled: bool = False) -> Iterator[str]:
    """Yield a symmetric matrix; ``filled``: where it has no entry it is zero."""
    if matrix is None:
        return
    diagonal = {i for i, j in matrix.entries if i == j}
    if all(i == j for i, j in matrix.entries):
        entries: list[Entry] = [(names[i], formula(e)) for (i, _), e in sorted(matrix.entries.items())]
        yield from entry_lines(key, entries, "  ")
    elif filled or len(diagonal) == len(names):
        yield f"  {key}:"
        for i in range(len(names)):
            row = (matrix.entries.get((i, j)) for j in range(len(names)))
            yield f"    - [{', '.join('0' if entry is None else formula(entry) for entry in row)}]"
    else:
        yield f"  # {key} is {_PARTLY}"


def _prior(noise: Noise, system: System) -> Iterator[str]:
    """Yield standard deviations where all variances are squares, else the covariance."""
    if noise.P0 is None:
        return
    deviations = {place: _root(entry) for place, entry in noise.P0.entries.items()}
    if all(i == j and root is not None for (i, j), root in deviations.items()):
        found: list[Entry] = [
            (system.state_names[i], formula(root)) for (i, _), root in sorted(deviations.items()) if root
        ]
        yield from entry_lines("P0_std", found, "  ")
    else:
        yield from _square("P0", noise.P0, system.state_names)


def _root(variance: Expression) -> Expression | None:
    """Return what a variance is the square of, None where it is not written as one."""
    if isinstance(variance, Power) and variance.exponent == 2:
        return variance.base
    if not isinstance(variance, Number) or variance.value < 0:
        return None
    root = Fraction(isqrt(variance.value.numerator), isqrt(variance.value.denominator))
    return Number(root) if root**2 == variance.value else None
