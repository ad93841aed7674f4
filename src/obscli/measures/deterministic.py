"""The deterministic measure: how strongly each derivative of an output brings in a new direction.

    r_k = |a_k − a_k*|   (Gram–Schmidt on the rows of M),   μ_k = |f_{k−1,k}| = r_k / r_{k−1},   μ_0 = r_0

y = U x, ẏ = F y;  of a linear form c x that is observable   μ = 1 / √Σ_l ((c u_l)/μ_l)²,   else 0.

Several outputs: rows by order, then by output; an output's chain goes on from its last direction.

References
----------
I. A. Bagmut (2009), (3), after N. A. Parusnikov.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from flint import arb

from obscli.exact.ball import precision
from obscli.measures.local import as_matrix
from obscli.measures.measure import Direction, Found, Measure
from obscli.measures.subject import Subject
from obscli.model.expression import Expression


def deterministic(subject: Subject) -> Found:
    """Return μ of every target, and the chain."""
    local = subject.local
    with precision(local.bits, 1):
        found = local.orthogonal
        chain = chain_of(subject)
        covectors = as_matrix(subject.covectors(subject.at), subject.n)
        components = (covectors * found.U.transpose()).tolist()
        values = []
        for observable, row in zip(subject.observable, components, strict=True):
            parts = [c / mu for c, mu in zip(row, chain, strict=True)]
            total = sum((part * part for part in parts), start=arb(0))
            values.append(float(1 / total.sqrt()) if observable and total > 0 else 0.0)
        links = tuple(
            Direction(float(mu), subject.named(np.array([float(found.U[k, j]) for j in range(subject.n)])))
            for k, mu in enumerate(chain)
        )
    return Found(tuple(values), {"deterministic": links}, _forms(subject))


def _forms(subject: Subject) -> dict[str, Expression]:
    if subject.closed is None:
        return {}
    pairs = zip(subject.targets, subject.closed.deterministic, strict=True)
    return {target.name: subject.positive(form) for target, form in pairs if form is not None}


def chain_of(subject: Subject) -> list[arb]:
    """Return μ_k of the chain, balls, in the order of the rows of U."""
    local = subject.local
    last: dict[int, arb] = {}
    chain = []
    for residual, row in zip(local.orthogonal.residuals, local.orthogonal.origins, strict=True):
        _, output = local.origins[row]
        chain.append(residual / last[output] if output in last else residual)
        last[output] = residual
    return chain


DETERMINISTIC: Final = Measure(
    key="deterministic",
    symbol="(3)",
    title="deterministic",
    reference="Bagmut 2009, (3); Parusnikov",
    reading="the link by which a derivative of an output brings the state in; 0: none does",
    compute=deterministic,
    basis="matrix",
    better="larger",
)
