"""The largest entry of a row of the pseudo-inverse: by how much an error of an output may enter a state.

    μ_i = max_j |(M⁺)_ij|   where e_i lies in the row space of M,   else ∞

Row i of M⁺ gives x_i from the outputs and their derivatives only where x_i is observable. Elsewhere the row
is small and means nothing: the naive number is the smaller the less is seen.

References
----------
I. A. Bagmut (2009), (17).
"""

from __future__ import annotations

from typing import Final

import numpy as np

from obscli.exact.ball import precision
from obscli.measures.in_range import as_double, beyond
from obscli.measures.local import as_matrix
from obscli.measures.measure import Found, Measure
from obscli.measures.subject import Subject
from obscli.model.expression import Expression


def pseudo_inverse(subject: Subject) -> Found:
    """Return max |c M⁺| of every target."""
    local = subject.local
    with precision(local.bits, 1):
        C, U = local.orthogonal.C, local.orthogonal.U
        covectors = as_matrix(subject.covectors(subject.at), subject.n)
        rows = (
            (covectors * U.transpose()) * (C.transpose() * C).inv() * C.transpose() if subject.rank else None
        )
        entries = rows.tolist() if rows is not None else []
        values = [
            as_double(max((abs(one) for one in entries[k]), key=lambda one: one.mid()))
            if observable
            else np.inf
            for k, observable in enumerate(subject.observable)
        ]
    return Found(tuple(values), forms=_forms(subject), remarks=beyond(values.count(None)))


def _forms(subject: Subject) -> dict[str, Expression]:
    if subject.closed is None:
        return {}
    rows = zip(subject.targets, subject.closed.pseudo_inverse, strict=True)
    return {target.name: max(map(subject.positive, row), key=subject.value) for target, row in rows}


PSEUDO_INVERSE: Final = Measure(
    key="pseudo-inverse",
    symbol="(17)",
    title="row of the pseudo-inverse",
    reference="Bagmut 2009, (17)",
    reading="by how much an error of an output or of a derivative may enter; inf: not observable",
    compute=pseudo_inverse,
    basis="matrix",
    better="smaller",
)
