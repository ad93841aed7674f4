"""The relations of a time-invariant system found state by state: many parameters, few in each column.

The c-th column of H e^{At} is the output of a start at x0 = e_c alone, so of the states that c drives. Their
part of A is block triangular in groups of states that drive each other, and has the characteristic polynomial

    χ_c = Π_groups det(s I − A_group) = Π_i q_i^{m_i}

The functions of the column are those of its least divisor μ_c with  Σ_j μ_j y_{k+j} = 0  for all k ≤ K,
y_k = H A^k e_c, K the order at which the observability matrix saturates. It has the few parameters that act
on the way from state c to the outputs, while the common multiple of all μ_c has all of them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from obscli.exact.errors import UndecidedError
from obscli.exact.fundamental import fundamental_system, inverse_at_zero
from obscli.exact.hidden_dynamics import occurring
from obscli.exact.polynomial import require_small
from obscli.exact.spectrum import Factor, characteristic_polynomial, factors
from obscli.exact.tower import Blocks


if TYPE_CHECKING:
    from collections.abc import Sequence

    from obscli.exact.exact_system import ExactSystem
    from obscli.exact.field import Element, Field
    from obscli.exact.fundamental import Fundamental, FundamentalSystem
    from obscli.exact.prove import Proof


def relations_by_columns(proof: Proof) -> tuple[FundamentalSystem, list[tuple[dict[int, Element], ...]]]:
    """Return the functions of all columns together, and for each the rows d of the outputs.

    Raises
    ------
    UndecidedError : the coefficients grow too large, or functions of two columns are not told apart
    """
    exact, blocks = proof.exact, Blocks(proof.exact)
    groups = _Groups(exact)
    columns = [_least(proof, blocks, c, groups.factors(c)) for c in range(exact.n)]
    union = _union(exact.field, columns)
    basis = fundamental_system(proof, list(union.values()))
    rows: list[tuple[dict[int, Element], ...]] = [tuple({} for _ in exact.H) for _ in basis.functions]
    for c, own in enumerate(columns):
        if own:
            _fill(exact.field, rows, c, _chosen(basis, union, own), blocks)
    return basis, rows


#: The square of the number of states in a group times (1 + how many parameters it has); more takes long.
_LARGEST_GROUP: Final = 600


class _Groups:
    """The groups of states that drive each other, and the factors of their characteristic polynomials."""

    def __init__(self, exact: ExactSystem) -> None:
        self._exact = exact
        drives: list[set[int]] = [set() for _ in range(exact.n)]
        for i, row in enumerate(exact.A):
            for j in row:
                drives[j].add(i)
        self._driven = [_reached(drives, c) for c in range(exact.n)]
        self._known: dict[int, list[Factor]] = {}

    def factors(self, c: int) -> dict[str, Factor]:
        """Return the factors of χ_c by their text."""
        total: dict[str, Factor] = {}
        for first in sorted({self._group(j)[0] for j in self._driven[c]}):
            for factor in self._of_group(first):
                known = total.get(_key(factor))
                more = known.multiplicity if known else 0
                total[_key(factor)] = Factor(factor.coefficients, factor.multiplicity + more)
        return total

    def _group(self, j: int) -> list[int]:
        return sorted(i for i in self._driven[j] if j in self._driven[i])

    def _of_group(self, first: int) -> list[Factor]:
        if first not in self._known:
            members = self._group(first)
            place = {j: k for k, j in enumerate(members)}
            block = tuple({place[j]: e for j, e in self._exact.A[i].items() if j in place} for i in members)
            field = self._exact.field
            letters = {k for row in block for entry in row.values() for k in occurring(entry)}
            require_small(len(members) ** 2 * (1 + len(letters)), _LARGEST_GROUP)
            self._known[first] = factors(field, characteristic_polynomial(field, block), formally=True)
        return self._known[first]


def _reached(drives: Sequence[set[int]], c: int) -> set[int]:
    """Return the states that a state drives, through others too, and itself."""
    found, fresh = {c}, [c]
    while fresh:
        more = drives[fresh.pop()] - found
        found |= more
        fresh += more
    return found


def _least(proof: Proof, blocks: Blocks, c: int, given: dict[str, Factor]) -> dict[str, Factor]:
    """Return the factors of μ_c: of χ_c, each taken as often as it takes to annihilate the outputs."""
    needed = {key: factor.multiplicity for key, factor in given.items()}
    for key in given:
        while needed[key]:
            needed[key] -= 1
            if not _annihilates(proof, blocks, c, [(given[k].coefficients, m) for k, m in needed.items()]):
                needed[key] += 1
                break
    return {key: Factor(given[key].coefficients, m) for key, m in needed.items() if m}


def _annihilates(
    proof: Proof, blocks: Blocks, c: int, powers: Sequence[tuple[Sequence[Element], int]]
) -> bool:
    """Whether Σ_j p_j y_{k+j} = 0 for all k ≤ K, p the product of the powers."""
    field = proof.exact.field
    product = [field.one]
    for coefficients, multiplicity in powers:
        for _ in range(multiplicity):
            product = _times(field, product, coefficients)
    for k in range(proof.order + 1):
        for i in range(len(proof.exact.H)):
            total = field.zero
            for j, coefficient in enumerate(product):
                if c in blocks[k + j][i]:
                    total = total + coefficient * blocks[k + j][i][c]
            if total:
                return False
    return True


def _times(field: Field, left: Sequence[Element], right: Sequence[Element]) -> list[Element]:
    """Return the product of two polynomials by rising degree."""
    result = [field.zero] * (len(left) + len(right) - 1)
    for i, a in enumerate(left):
        for j, b in enumerate(right):
            result[i + j] = result[i + j] + a * b
    return result


def _key(factor: Factor) -> str:
    return " ".join(f"({c.num})/({c.den})" for c in factor.coefficients)


def _union(field: Field, columns: Sequence[dict[str, Factor]]) -> dict[str, Factor]:
    """Return each factor with its largest multiplicity, those of low degree first.

    Distinct irreducible polynomials have no root in common. Of factors found formally, with algebraic
    generators taken for independent, that is not known.
    """
    union: dict[str, Factor] = {}
    for column in columns:
        for key, factor in column.items():
            if key not in union or union[key].multiplicity < factor.multiplicity:
                union[key] = factor
    algebraic = {index for index, _ in field.relations}
    if any(occurring(c) & algebraic for factor in union.values() for c in factor.coefficients):
        raise UndecidedError(
            "roots of numbers or parameters keep the functions of time from being told apart"
        )
    return dict(sorted(union.items(), key=lambda pair: pair[1].degree))


def _chosen(
    basis: FundamentalSystem, union: dict[str, Factor], own: dict[str, Factor]
) -> list[tuple[int, Fundamental]]:
    """Return the functions of a column with their places among all."""
    chosen, place = [], 0
    for key, factor in union.items():
        if key in own:
            count = factor.degree * own[key].multiplicity
            chosen += [(place + k, basis.functions[place + k]) for k in range(count)]
        place += factor.degree * factor.multiplicity
    return chosen


def _fill(
    field: Field,
    rows: Sequence[Sequence[dict[int, Element]]],
    c: int,
    chosen: Sequence[tuple[int, Fundamental]],
    blocks: Blocks,
) -> None:
    """Solve y_k = Σ_j f_j^(k)(0) d_j for the c-th entries of all d."""
    inverse = inverse_at_zero(field, [function for _, function in chosen])
    for (place, _), weights in zip(chosen, inverse, strict=True):
        for i, row in enumerate(rows[place]):
            total = field.zero
            for k, weight in weights.items():
                if c in blocks[k][i]:
                    total = total + weight * blocks[k][i][c]
            if total:
                row[c] = total
