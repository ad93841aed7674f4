"""The norm of a column of the observability matrix: how much a state shows in the outputs, if it were alone.

    ‖M e_k‖ = √Σ_i v_ki² σ_i²

It says nothing of whether another state shows alike.
"""

from __future__ import annotations

from typing import Final

from flint import arb

from obscli.exact.ball import precision
from obscli.measures.in_range import as_double, beyond, of_states
from obscli.measures.measure import Found, Measure
from obscli.measures.subject import Subject


def column_norm(subject: Subject) -> Found:
    """Return ‖M e_k‖ of every state."""
    local = subject.local
    with precision(local.bits, 1):
        squares = [
            sum((row[j] * row[j] for row in local.rows.tolist()), start=arb(0)) for j in range(subject.n)
        ]
        values = [as_double(one.nonnegative_part().sqrt()) for one in squares]
    return Found(of_states(subject, values), remarks=beyond(values.count(None)))


COLUMN_NORM: Final = Measure(
    key="column-norm",
    symbol="‖Me‖",
    title="column norm",
    reference="theory of the equivalent singular value; for comparison",
    reading="how much the state alone would show in outputs and derivatives, whatever hides it",
    compute=column_norm,
    basis="matrix",
    better="larger",
)
