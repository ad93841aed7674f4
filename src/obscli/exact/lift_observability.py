"""What the outputs show, through the stationary system: chains of derivatives, and combinations mapped back.

    ζ_1 = y_i,   ζ_{k+1} = ζ_k' minus what was seen before, constant factors removed

The forms in all chains span the closure of the rows of H over the constants. Over the field they span the
rows of the observability matrix L, which are the derivatives of the rows of H too: their rank over the
field is that of L, and L N = 0 for them as well.

References
----------
Morozov & Baklanov 2018, section 5, after (22).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from obscli.exact.echelon import Echelon, polynomial_row, reduced_echelon
from obscli.exact.lift_finding import Chain
from obscli.exact.rows import dot, field_row


if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from obscli.exact.closure import Span
    from obscli.exact.closure_screen import Screen
    from obscli.exact.constant_span import Forms
    from obscli.exact.echelon import PolyRow
    from obscli.exact.exact_system import Row
    from obscli.exact.lift_writing import Writer
    from obscli.exact.prove import Proof
    from obscli.model.system import Covector


def chains_of(forms: Forms, screen: Screen, writer: Writer) -> tuple[Chain, ...]:
    """Return what each output brings, those first that show least by themselves.

    Raises
    ------
    UndecidedError : the coefficients grow too large
    """
    echelon = Echelon(forms.field, forms.order(range(len(forms.columns))))
    outputs = forms.modes.exact.system.outputs
    order = sorted(range(len(outputs)), key=lambda i: len(screen.finite([forms.H[i]])))
    return tuple(
        Chain(outputs[i].name, tuple(writer.form(row)[0] for row in _chain(forms, echelon, forms.H[i])))
        for i in order
    )


def _chain(forms: Forms, echelon: Echelon, start: Row) -> Iterator[PolyRow]:
    """Yield ζ_1, ζ_2, … of one output, and take them into the echelon form."""
    form = polynomial_row(forms.field, start)
    first = True
    while rest := echelon.reduce(form):
        rest = echelon.strip(rest)
        echelon.insert(rest)
        yield form if first else rest
        first = False
        form = polynomial_row(forms.field, forms.rate(field_row(forms.field, rest)))


def combinations(proof: Proof, span: Span) -> tuple[tuple[Covector, ...], bool]:
    """Return a basis over the field of a space of forms, and whether it spans the rows of L."""
    field = proof.exact.field
    rows = [span.forms.over_the_field(row) for row in span.basis.values()]
    polynomial = [polynomial_row(field, row) for row in rows]
    echelon = reduced_echelon(field, polynomial, range(proof.exact.n))
    agrees = len(echelon) == proof.rank and not _sees(proof, rows)
    return tuple(proof.covector(row) for _, row in sorted(echelon.items())), agrees


def _sees(proof: Proof, rows: Iterable[Row]) -> bool:
    """Whether some form changes along an unobservable direction."""
    field = proof.exact.field
    kernel = [field_row(field, column) for column in proof.kernel.columns.values()]
    return any(dot(field, row, column) for row in rows for column in kernel)
