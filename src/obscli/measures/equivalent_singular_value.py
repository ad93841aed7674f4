"""The equivalent singular value: the singular values of M, each weighed by how much of it a state is.

    σ̃_k = Σ_i v_ki² σ_i = [(MᵀM)^½]_kk

The weights v_ki² make it a function of M alone, also where singular values repeat. It is an average gain and
no test: M = [1 1] gives 0.71 for both states though neither is observable.

References
----------
Dong Jinlong, Mo Bo, (12), with μ_ki = v_ki².
"""

from __future__ import annotations

from typing import Final

from obscli.measures.in_range import beyond, of_states
from obscli.measures.local_spectrum import root_of_gram
from obscli.measures.measure import Found, Measure
from obscli.measures.subject import Subject


def equivalent_singular_value(subject: Subject) -> Found:
    """Return σ̃ of every state."""
    values = root_of_gram(subject)
    return Found(of_states(subject, values), remarks=beyond(values.count(None)))


EQUIVALENT_SINGULAR_VALUE: Final = Measure(
    key="equivalent-singular-value",
    symbol="σ̃",
    title="equivalent singular value",
    reference="Dong & Mo, (12)",
    reading="average gain from the state to outputs and derivatives; positive also where others hide it",
    compute=equivalent_singular_value,
    basis="matrix",
    better="larger",
)
