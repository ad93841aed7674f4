"""The rank of the Gramian at an instant, proved in ball arithmetic.

    H(τ) Φ(τ, t) = H_z e^(A_z (τ − t)) V(t),     z = V(t) x,  z' = A_z z,  y = H_z z

The row space of W(t, t0) is the span of these rows over t0 ≤ τ ≤ t, so that sampled at some instants τ_j they
have no higher rank. A minor of r sampled rows whose ball excludes zero proves rank W ≥ r; that it is not
above r is proved exactly, by the kernel. Nothing is rounded away: parameters are balls around their exact
values, the matrix exponential is a ball matrix, and where balls are too wide they are made anew with more
bits and more samples, in turn over the whole interval and over the last part of it: what decays fast has to
be seen late, since e^(A_z (τ − t)) of it grows backwards.

References
----------
F. Johansson (2017), Arb: efficient arbitrary-precision midpoint-radius interval arithmetic.
V. M. Morozov, F. Yu. Baklanov (2018), section 5.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Final

from flint import arb, arb_mat, fmpq

from obscli.exact.ball import BallPoint, OutsideDomainError, precision, without_value
from obscli.exact.lift_finding import Lift, Rows
from obscli.model.expression import Expression
from obscli.model.specialise import at_nominal
from obscli.model.system import System


#: Bits of the ball arithmetic, and the part of the interval sampled with them, in the order tried.
ATTEMPTS: Final = tuple(zip((128, 256, 512, 1024, 2048, 4000), (1, 2**-4, 1, 2**-8, 1, 2**-16), strict=True))

#: Sampled rows for each one that the minor needs, at first.
_SPARE: Final = 2

#: A minor is taken as told from zero where so many of its bits are known; digits of it that are printed.
_TOLD: Final = 16
_DIGITS: Final = 10


@dataclass(frozen=True, slots=True)
class Minor:
    """The ball of a minor of sampled output rows, as text; it does not contain zero.

    ``precision``: bits; ``samples``: at how many instants the outputs were sampled, ``since``: from when on.
    """

    midpoint: str
    radius: str
    precision: int
    samples: int
    since: float


@dataclass(frozen=True, slots=True)
class CertifiedInstant:
    """The rank of W(t, t0), proved; None: undecided, ``reason`` says why.

    ``minor`` proves that it is not lower; a rank of zero needs none, and has none.
    """

    t: float
    rank: int | None
    minor: Minor | None
    reason: str = ""


@dataclass(frozen=True, slots=True)
class CertifiedRank:
    """What was certified of one system, from t0 = ``start``; ``reason``: why nothing was."""

    start: float
    instants: tuple[CertifiedInstant, ...]
    reason: str = ""

    @property
    def is_undecided(self) -> bool:
        """Whether the rank is not proved at some instant."""
        return bool(self.reason) or any(one.rank is None for one in self.instants)


def certified_rank(
    system: System, lift: Lift, rank: int, start: float, instants: Sequence[float]
) -> CertifiedRank:
    """Prove the rank of W(t, t0) at instants, at the file's values.

    Parameters
    ----------
    system : the system that ``lift`` is of, proved: V' + V A = A_z V, H = H_z V
    rank : at the file's values, proved not to be exceeded
    start, instants : t0 and t_i > t0, taken as the exact numbers that they are in binary
    """
    there = _at_values(system, lift)
    found = tuple(_at_instant(system, there, rank, Fraction(start), Fraction(t)) for t in instants)
    return CertifiedRank(start, found)


def _at_values(system: System, lift: Lift) -> Lift:
    """Return the lift with the parameters that have a value replaced by it, exactly."""
    nominal = at_nominal(system)

    def rows(matrix: Rows) -> Rows:
        return tuple({j: nominal.expression(entry) for j, entry in row.items()} for row in matrix)

    variables = tuple(nominal.covector(one) for one in lift.variables)
    return Lift(lift.names, variables, rows(lift.A), rows(lift.H))


def _at_instant(system: System, lift: Lift, rank: int, start: Fraction, t: Fraction) -> CertifiedInstant:
    try:
        minor = _first_minor(system, lift, rank, start, t) if rank else None
    except OutsideDomainError:
        return CertifiedInstant(float(t), None, None, "a coefficient is not seen to exist at these values")
    except KeyError as missing:
        return CertifiedInstant(float(t), None, None, without_value(missing.args[0], [system]))
    if rank and minor is None:
        most = ATTEMPTS[-1][0]
        reason = f"no minor of {rank} sampled rows is seen to differ from zero with up to {most} bits"
        return CertifiedInstant(float(t), None, None, reason)
    return CertifiedInstant(float(t), rank, minor)


def _first_minor(system: System, lift: Lift, rank: int, start: Fraction, t: Fraction) -> Minor | None:
    """Return the first minor that excludes zero; each attempt has more samples, at other distances."""
    samples = 1 + math.ceil(_SPARE * rank / len(lift.H))
    for bits, part in ATTEMPTS:
        since = t - Fraction(part) * (t - start)
        with precision(bits, 1):
            ball = _minor(sampled_rows(system, lift, since, t, samples), rank)
            if ball is not None:
                return Minor(*_told(ball), bits, samples, float(since))
        samples += 1 + min(samples, lift.n)
    return None


def sampled_rows(system: System, lift: Lift, since: Fraction, t: Fraction, samples: int) -> list[list[arb]]:
    """Return the balls of H(τ_j) Φ(τ_j, t) at so many instants (two or more), evenly from t back.

    Use inside ``precision``.

    Parameters
    ----------
    system : for the names of its time and states
    lift : of it, at the file's values

    Raises
    ------
    OutsideDomainError
        where a coefficient is not seen to exist
    KeyError
        naming a parameter without a value, or a function left open
    """
    point = BallPoint(system, {system.time: t}, 1)
    place = {name: j for j, name in enumerate(system.state_names)}
    V = _matrix(point, [{place[name]: e for name, e in row.items()} for row in lift.variables], system.n)
    step = (since - t) / (samples - 1)
    transition = (_matrix(point, lift.A, lift.n) * arb(fmpq(step.numerator, step.denominator))).exp()
    seen = _matrix(point, lift.H, lift.n)
    rows = (seen * V).tolist()
    for _ in range(samples - 1):
        seen = seen * transition
        rows += (seen * V).tolist()
    return rows


def _matrix(point: BallPoint, rows: Sequence[Mapping[int, Expression]], columns: int) -> arb_mat:
    """Return the balls of a matrix given by sparse rows."""
    found = arb_mat(len(rows), columns)
    for i, row in enumerate(rows):
        for j, entry in row.items():
            found[i, j] = point.value(entry)[0]
    return found


def _minor(rows: Sequence[Sequence[arb]], rank: int) -> arb | None:
    """Return a minor that excludes zero, chosen by elimination with complete pivoting; None: not found."""
    active = {i: dict(enumerate(row)) for i, row in enumerate(rows)}
    chosen: list[tuple[int, int]] = []
    for _ in range(min(rank, len(rows), len(rows[0]))):
        sizes = ((entry.abs_lower(), i, j) for i, row in active.items() for j, entry in row.items())
        _, i, j = max(sizes, key=lambda one: one[0])
        pivot_row = active.pop(i)
        pivot = pivot_row.pop(j)
        if pivot.contains(0):
            return None
        chosen.append((i, j))
        for row in active.values():
            factor = row.pop(j) / pivot
            for column, entry in pivot_row.items():
                row[column] -= factor * entry
    columns = sorted(j for _, j in chosen)
    found: arb = arb_mat([[rows[i][j] for j in columns] for i, _ in sorted(chosen)]).det()
    return found if len(chosen) == rank and found.rel_accuracy_bits() >= _TOLD else None


def _told(ball: arb) -> tuple[str, str]:
    """Return a midpoint in few digits and a radius around it, so that they contain the ball."""
    midpoint = ball.mid().str(_DIGITS, radius=False)
    radius = (ball - arb(midpoint)).abs_upper() * arb("1.01")
    return midpoint, radius.str(3, radius=False)
