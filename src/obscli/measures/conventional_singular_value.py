"""The conventional rule: a singular value is given to the state that has the largest component of its vector.

    σ_i → state k*(i) = argmax_k |v_ki|

A state that gets several keeps the largest, one that gets none has no value. The rule is no function of M
where singular values repeat.

References
----------
Wan, Fang, Liu, as cited by Dong & Mo.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from obscli.exact.ball import precision
from obscli.measures.in_range import beyond
from obscli.measures.local_spectrum import local_spectrum
from obscli.measures.measure import Found, Measure
from obscli.measures.subject import Subject


#: Components whose sizes differ by less do not say which of them is the largest.
_TIED: Final = 1e-9


def conventional_singular_value(subject: Subject) -> Found:
    """Return the largest σ_i given to each state."""
    with precision(subject.local.bits, 1):
        spectrum = local_spectrum(subject)
        vectors = [np.abs([float(one) for one in spectrum.right_vector(i)]) for i in range(subject.rank)]
        values, repeated = spectrum.values, any(len(one) > 1 for one in spectrum.clusters)
    given: dict[int, float | None] = {}
    tied = False
    for vector, value in zip(vectors, values, strict=True):
        first, *rest = np.argsort(-vector, kind="stable")
        tied |= bool(rest) and bool(vector[rest[0]] > vector[first] * (1 - _TIED))
        given.setdefault(int(first), value)
    states = iter(range(subject.n))
    targets = tuple(given.get(next(states)) if is_state else None for is_state in subject.is_state)
    return Found(
        targets,
        remarks=(
            *_remarks(repeated=repeated, tied=tied, given=len(given), n=subject.n),
            *beyond(values.count(None), "singular value"),
        ),
    )


def _remarks(*, repeated: bool, tied: bool, given: int, n: int) -> list[str]:
    found = ["gives each singular value to one state, whatever else its vector holds; compare σ̃"]
    if repeated:
        found.append("singular values repeat: which states get them is arbitrary")
    if tied:
        found.append("two components of a vector are equally large: which state gets its value is arbitrary")
    if given < n:
        found.append(f"{n - given} of {n} states get no singular value; that does not mean 0")
    return found


CONVENTIONAL_SINGULAR_VALUE: Final = Measure(
    key="conventional-singular-value",
    symbol="σ_max",
    title="conventional singular value",
    reference="Wan, Fang, Liu; as cited by Dong & Mo",
    reading="the singular value whose vector has its largest component there; a habit, not a measure",
    compute=conventional_singular_value,
    basis="matrix",
    better="larger",
    always=False,
)
