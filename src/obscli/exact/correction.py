"""The smallest change that makes a claimed combination observable: where a term was lost, or a sign.

c is observable iff c N = 0. Wanted is a row e with as few entries as possible and

    e N = −c N,    c + e ≠ 0;

among those with as few, the ones that bring in the fewest new states. States that no direction touches (zero
rows of N) cannot help, so only few supports have to be tried, each a small linear system over the field.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from math import comb
from typing import TYPE_CHECKING, Final

from obscli.exact.echelon import polynomial_row, reduced_echelon
from obscli.exact.field import Element
from obscli.exact.restore import Restorer
from obscli.exact.rows import dot
from obscli.model.system import Covector


if TYPE_CHECKING:
    from obscli.exact.exact_system import ExactSystem, Row


#: Changes of more coefficients say little, and more supports than this are not tried.
_MOST_CHANGED: Final = 3
_MOST_SUPPORTS: Final = 4000


@dataclass(frozen=True, slots=True, eq=False)
class Correction:
    """A change e and the observable combination c + e."""

    change: Covector
    corrected: Covector


def corrections(exact: ExactSystem, kernel: Sequence[Row], claimed: Row) -> list[Correction]:
    """Return the smallest changes of a combination that make it observable, all that are equally small.

    Parameters
    ----------
    exact : the system with its field
    kernel : a basis of the unobservable directions (columns of N)
    claimed : a combination that is not observable

    Returns
    -------
    list
        empty where more than a few coefficients would have to change
    """
    wanted = [-dot(exact.field, claimed, column) for column in kernel]
    touched = sorted({j for column in kernel for j in column})
    for count in range(1, _MOST_CHANGED + 1):
        if comb(len(touched), count) > _MOST_SUPPORTS:
            break
        changes = [
            change
            for support in combinations(touched, count)
            if (change := _change(exact, kernel, wanted, support)) is not None
            and not _cancels(claimed, change)
        ]
        if changes:
            fewest = min(len(change.keys() - claimed.keys()) for change in changes)
            nearest = [one for one in changes if len(one.keys() - claimed.keys()) == fewest]
            return [_correction(exact, claimed, change) for change in nearest]
    return []


def _change(
    exact: ExactSystem, kernel: Sequence[Row], wanted: Sequence[Element], support: Sequence[int]
) -> dict[int, Element] | None:
    """Return e on the support with e N = wanted, None where there is none or an entry is not needed."""
    size = len(support)
    if any(
        value and not any(j in column for j in support) for column, value in zip(kernel, wanted, strict=True)
    ):
        return None
    rows = []
    for column, value in zip(kernel, wanted, strict=True):
        row = {k: column[j] for k, j in enumerate(support) if j in column}
        row |= {size: value} if value else {}
        if row:
            rows.append(polynomial_row(exact.field, row))
    echelon = reduced_echelon(exact.field, rows, range(size + 1))
    if len(echelon) != size or size in echelon:
        return None
    if any(size not in row for row in echelon.values()):
        return None
    return {j: exact.field.fraction(echelon[k][size], echelon[k][k]) for k, j in enumerate(support)}


def _cancels(claimed: Row, change: Row) -> bool:
    """Whether nothing is left of the claim."""
    return claimed.keys() == change.keys() and not any(claimed[j] + change[j] for j in change)


def _correction(exact: ExactSystem, claimed: Row, change: Row) -> Correction:
    restorer, zero = Restorer(exact.interpreter), exact.field.zero
    names = exact.system.state_names
    places = sorted({*claimed, *change})
    total = {j: claimed.get(j, zero) + change.get(j, zero) for j in places}
    return Correction(
        change={names[j]: restorer.element(change[j]) for j in sorted(change)},
        corrected={names[j]: restorer.element(e) for j, e in total.items() if e},
    )
