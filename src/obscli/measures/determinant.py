"""The generalised determinant of the observability matrix.

    μ = det(MᵀM),   0 below full rank; then the pseudo-determinant, Π σ_i² over the σ_i > 0, stands beside it

One number of the whole system, and no threshold for it: with H = I/2, A = 0 and many states it is as small as
one likes though every state is measured directly.

References
----------
I. A. Bagmut (2009), (15).
"""

from __future__ import annotations

from typing import Final

from flint import arb

from obscli.exact.ball import precision
from obscli.measures.in_range import as_double, or_nan
from obscli.measures.measure import Found, Measure, SystemValue
from obscli.measures.subject import Subject


_REMARKS: Final = ("it is beyond the range of double precision: see its logarithm, determinant-log10",)


def determinant(subject: Subject) -> Found:
    """Return det(MᵀM), and log10 of it or of the pseudo-determinant."""
    local = subject.local
    with precision(local.bits, 1):
        C = local.orthogonal.C
        product = (C.transpose() * C).det() if subject.rank else arb(1)
        logarithm = float(product.log() / arb(10).log())
        if subject.rank < subject.n:
            return Found(system={"determinant": 0.0, "pseudo-determinant-log10": logarithm})
        value = as_double(product)
    found: dict[str, SystemValue] = {"determinant": or_nan(value), "determinant-log10": logarithm}
    forms = {} if subject.closed is None else {"determinant": subject.closed.determinant}
    return Found(system=found, forms=forms, remarks=_REMARKS if value is None else ())


DETERMINANT: Final = Measure(
    key="determinant",
    symbol="(15)",
    title="generalised determinant",
    reference="Bagmut 2009, (15)",
    reading="det(MᵀM) of the system as a whole; 0: not every state is observable",
    compute=determinant,
    basis="matrix",
)
