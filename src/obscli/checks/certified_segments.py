"""A lower bound of what segments show together, proved in ball arithmetic at the file's values.

    rows_j = (Taylor coefficients of H Φ_j at t_{j−1}) · J_{j−1} Φ_{j−1} … J_1 Φ_1(t_1, t_0)

are forms in x(t_0), and all of them lie in the row space of what the segments show. Row by row they are
eliminated in balls: a pivot that excludes zero is one more independent row. What is found is never more
than the rank; a row whose remainder cannot be told from zero is left out, and said to be.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from flint import arb, arb_mat

from obscli.exact.ball import OutsideDomainError, precision, without_value
from obscli.exact.ball_transition import BallSegment, TooManyBallStepsError, ball_matrix, ball_number
from obscli.model.specialise import at_nominal
from obscli.model.system import Matrix


if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

    from obscli.model.system import Segments


#: Bits of the ball arithmetic in the order tried, and terms of Taylor series for so many bits.
BITS: Final = (128, 256, 512)
_TERMS: Final = 3

#: A pivot is taken as told from zero where so many of its bits are known.
_TOLD: Final = 16


@dataclass(frozen=True, slots=True)
class CertifiedSegments:
    """How many independent rows were proved after each segment, with how many bits; ``reason``: why not all.

    ``after`` has a number for every segment looked at; none where nothing could be evaluated.
    """

    after: tuple[int, ...]
    bits: int
    reason: str = ""

    @property
    def rank(self) -> int:
        """The rank is not below this."""
        return self.after[-1] if self.after else 0


def certified_segments(
    segments: Segments,
    most: int,
    told: Callable[[str], None] = lambda _: None,
    attempts: Sequence[int] = BITS,
) -> CertifiedSegments:
    """Prove as much of the rank of all segments together as balls show.

    Parameters
    ----------
    segments : parameters take their values in the file
    most : the rank is proved not to exceed this: no more is looked for
    told : told what is being done
    attempts : bits, in the order tried
    """
    best = CertifiedSegments((), 0)
    try:
        for bits in attempts:
            told(f"rank of the segments in balls of {bits} bits")
            with precision(bits, bits // _TERMS + 2):
                after = _after_each(segments, most, bits)
            if not best.after or after[-1] > best.rank:
                best = CertifiedSegments(after, bits)
            if best.rank == most:
                return best
    except OutsideDomainError:
        return _because(best, "a coefficient is not seen to exist at the file's values")
    except KeyError as missing:
        return _because(best, without_value(missing.args[0], (one.system for one in segments.parts)))
    except TooManyBallStepsError:
        return _because(best, "a segment is too long to be followed in ball arithmetic")
    return _because(best, f"no further row is seen to be independent with up to {attempts[-1]} bits")


def _because(found: CertifiedSegments, reason: str) -> CertifiedSegments:
    return CertifiedSegments(found.after, found.bits, reason)


def _after_each(segments: Segments, most: int, bits: int) -> tuple[int, ...]:
    """Return the number of independent rows after each segment; once all are there nothing is followed."""
    first = segments.parts[0].system
    values = at_nominal(first)
    echelon = Echelon()
    found: list[int] = []
    tolerance = arb(2) ** (-(3 * bits) // 4)
    carried = _identity(first.n)
    begin = ball_number(first, values.expression(segments.start))
    for one in segments.parts:
        if echelon.rank < most:
            motion = BallSegment(at_nominal(one.system).system(), bits // _TERMS)
            for rows in motion.rows(begin, first.n):
                echelon.add((rows * carried).tolist())
        found.append(echelon.rank)
        if echelon.rank < most and one is not segments.parts[-1]:
            end = ball_number(first, values.expression(one.stop))
            duration = ball_number(first, values.expression(one.duration))
            carried = motion.transition(begin, duration, tolerance) * carried
            if one.jump is not None:
                jump = {at: values.expression(entry) for at, entry in one.jump.entries.items()}
                carried = ball_matrix(first, Matrix(first.n, first.n, jump)) * carried
            begin = end
    return tuple(found)


def _identity(n: int) -> arb_mat:
    return arb_mat(n, n, [int(i == j) for i in range(n) for j in range(n)])


class Echelon:
    """Rows eliminated as they come: each one kept has a pivot that excludes zero."""

    def __init__(self, rows: Iterable[tuple[int, list[arb]]] = ()) -> None:
        self._rows: list[tuple[int, list[arb]]] = list(rows)

    def copy(self) -> Echelon:
        """Return one that goes its own way from here."""
        return Echelon(self._rows)

    @property
    def rows(self) -> list[list[arb]]:
        """The rows kept."""
        return [row for _, row in self._rows]

    @property
    def rank(self) -> int:
        """How many rows were kept."""
        return len(self._rows)

    def add(self, rows: Iterable[list[arb]]) -> None:
        """Keep the rows that are seen to be independent of those before them."""
        for row in rows:
            rest = list(row)
            for pivot, kept in self._rows:
                factor = rest[pivot] / kept[pivot]
                if not factor.is_zero():
                    rest = [a - factor * b for a, b in zip(rest, kept, strict=True)]
                rest[pivot] = arb(0)
            pivot = max(range(len(rest)), key=lambda j: rest[j].abs_lower())
            if rest[pivot].rel_accuracy_bits() >= _TOLD and not rest[pivot].contains(0):
                self._rows.append((pivot, rest))
