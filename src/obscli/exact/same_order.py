"""A stationary system of the same order: x = T(t) z, where one is found.

    z = V x,   V' + V A = A_z V,   H = H_z V,   V (n, n) invertible,   T = V^{-1}

The rows of V span a closed space of forms that has the rows of H, of dimension n over the constants and of
rank n over the field. It is built from closed spaces that add as much to the rank as to the dimension: that
of the rows of H, those of single states, then those of the modes of D on the largest closed space that is
made of the functions in A and H, of half their frequencies too: axes that turn by θ show in A as 2θ.

    P_0 = functions ⊗ states,   P_{k+1} = {v ∈ P_k : D v ∈ P_k}

What this finds is a change of variables; that there is none is not shown where nothing is found, unless the
closure of the rows of H is itself larger than its rank.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from obscli.exact.closure import closure
from obscli.exact.echelon import Echelon, polynomial_row, reduced_echelon
from obscli.exact.kronecker import functions_in
from obscli.exact.rows import combined, field_row, transpose
from obscli.exact.spectrum import characteristic_polynomial, factors, modes_of


if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from obscli.exact.closure import Screen, Span
    from obscli.exact.constant_span import Forms
    from obscli.exact.exact_system import Row
    from obscli.exact.exponential_polynomial import Mode

#: The largest space of functions ⊗ states that is searched.
_LARGEST: Final = 150


def same_order(forms: Forms, screen: Screen) -> Span | None:
    """Return a closed space of forms that is a change of variables; None: none was found."""
    n = len(forms.A)
    chosen = _Chosen(forms, screen)
    if not chosen.add(list(forms.H)):
        return None
    for candidate in _candidates(forms, chosen):
        if chosen.size == n:
            break
        chosen.add([candidate])
    return closure(forms, chosen.generators) if chosen.size == n else None


class _Chosen:
    """Generators of a closed space whose dimension over the constants is its rank over the field.

    A rank at a random instant modulo a prime is not above the rank, which is not above the dimension.
    """

    def __init__(self, forms: Forms, screen: Screen) -> None:
        self._screen, self._most = screen, len(forms.A)
        self.generators: list[Row] = []
        self.size = 0

    def add(self, forms: Sequence[Row]) -> bool:
        """Take in what forms generate, if it adds as much to the rank as to the dimension."""
        more = [*self.generators, *forms]
        found = self._screen.closure(more, self._most)
        if found is None or self._screen.rank_over_the_field(found.values()) < len(found):
            return False
        if len(found) > self.size:
            self.generators, self.size = more, len(found)
        return True


def _candidates(forms: Forms, chosen: _Chosen) -> Iterator[Row]:
    """Yield forms that may generate what is still missing."""
    for i in range(len(forms.A)):
        yield forms.state(i)
    if chosen.size < len(forms.A):
        functions = _with_halves(forms)
        if len(functions) * len(forms.A) <= _LARGEST:
            yield from _modes(forms, _largest_closed(forms, functions))


def _with_halves(forms: Forms) -> list[Mode]:
    """Return 1 and the functions in A and H, with those of half their frequencies."""
    found = {forms.modes.one, *functions_in(forms)}
    for mode in tuple(found):
        if any(mode.turns) and not any(turn % 2 for turn in mode.turns):
            halved = mode._replace(turns=tuple(turn // 2 for turn in mode.turns))
            found |= {halved._replace(sine=sine) for sine in (False, True)}
    return sorted(found, key=lambda mode: mode.rank)


def _largest_closed(forms: Forms, functions: Sequence[Mode]) -> list[Row]:
    """Return a basis of the largest closed space within functions ⊗ states."""
    field = forms.field
    basis: list[Row] = [{forms.column(i, mode): field.one} for mode in functions for i in range(len(forms.A))]
    while True:
        relations = _relations(forms, basis)
        if len(relations) == len(basis):
            return basis
        basis = [combined(field, [(c, basis[k]) for k, c in row.items()]) for row in relations]


def _relations(forms: Forms, basis: Sequence[Row]) -> list[Row]:
    """Return the c with D Σ c_k b_k in the span of the b_k."""
    field = forms.field
    rates = [forms.rate(row) for row in basis]
    size = len(forms.columns)
    echelon = Echelon(field, range(size + len(basis)))
    for row in basis:
        echelon.insert(echelon.strip(echelon.reduce(polynomial_row(field, row))))
    known = set(echelon.rows)
    outside = [
        echelon.reduce(polynomial_row(field, {**rate, size + k: field.one})) for k, rate in enumerate(rates)
    ]
    columns = [k for k in range(size + len(basis)) if k not in known]
    found = reduced_echelon(field, outside, columns)
    return [
        {k - size: entry for k, entry in field_row(field, row).items()}
        for pivot, row in found.items()
        if pivot >= size
    ]


def _modes(forms: Forms, basis: Sequence[Row]) -> Iterator[Row]:
    """Yield a basis of a closed space by the modes of D on it, real ones of low order first."""
    if not basis:
        return
    field = forms.field
    matrix = transpose(_matrix(forms, basis), len(basis))
    for factor in factors(field, characteristic_polynomial(field, matrix)):
        for group in modes_of(field, matrix, factor):
            for mode in group:
                yield combined(field, [(c, basis[k]) for k, c in mode.items()])


def _matrix(forms: Forms, basis: Sequence[Row]) -> list[Row]:
    """Return M with D b_i = Σ_j M_ij b_j."""
    field, size, d = forms.field, len(forms.columns), len(basis)
    rows = [polynomial_row(field, {**row, size + k: field.one}) for k, row in enumerate(basis)]
    echelon = reduced_echelon(field, rows, range(size + d))
    inverse = {p: field_row(field, row) for p, row in echelon.items()}
    result = []
    for row in basis:
        rate = forms.rate(row)
        terms = [(rate[p] / inverse[p][p], inverse[p]) for p in rate if p in inverse]
        total = combined(field, terms)
        result.append({k - size: entry for k, entry in total.items() if k >= size})
    return result
