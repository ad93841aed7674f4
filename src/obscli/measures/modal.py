"""The modal factor of a time-invariant system: how much of each mode the outputs show.

    A v_i = λ_i v_i,  |v_i| = 1:   |H v_i|,   the smallest σ of H V where several vectors V belong to λ_i

Zero exactly where the mode is unobservable (Popov–Belevitch–Hautus). Modes and vectors are found with
hundreds of bits, so that multiple eigenvalues, which double precision scatters, stay together.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from flint import acb, acb_mat, arb, ctx

from obscli.exact.ball import BallPoint, precision
from obscli.measures.measure import Direction, Found, Measure, NotMeasuredError
from obscli.measures.subject import Subject


_BITS: Final = 1500
_MOST_STATES: Final = 40

#: Eigenvalues of a Jordan block of size k scatter by 2^(−bits/k): this close they are one.
_ALIKE: Final = 1e-9


def modal(subject: Subject) -> Found:
    """Return every eigenvalue with the factor of its mode, the least observable first."""
    there = subject.there
    if not subject.numeric.is_constant:
        raise NotMeasuredError("modes are those of a time-invariant system; this one depends on time")
    if there.n > _MOST_STATES:
        raise NotMeasuredError(f"modes are found for up to {_MOST_STATES} states")
    with precision(_BITS, 1):
        point = BallPoint(there, {}, 1)
        A, H = acb_mat(there.n, there.n), acb_mat(there.m, there.n)
        units = [arb(float(one)) for one in subject.units]
        for (i, j), entry in there.A.entries.items():
            A[i, j] = acb((point.value(entry)[0] * units[j] / units[i]).mid())
        for (i, j), entry in there.H.entries.items():
            H[i, j] = acb((point.value(entry)[0] * units[j]).mid())
        found = [_mode(subject, A, H, value) for value in _distinct(A) if value.imag >= 0]
    return Found(system={"modal": tuple(sorted(found, key=lambda one: one.value))})


def _distinct(A: acb_mat) -> list[acb]:
    """Return the eigenvalues, those that scatter about one value as their mean."""
    values = list(A.eig(algorithm="approx"))
    largest = max((float(abs(one).upper()) for one in values), default=0.0)
    groups: list[list[acb]] = []
    for value in values:
        near = [g for g in groups if any(float(abs(value - one).upper()) <= _ALIKE * largest for one in g)]
        joined = [value, *(one for g in near for one in g)]
        groups = [g for g in groups if g not in near] + [joined]
    return [_clean(sum(g, acb(0)) / len(g), largest) for g in groups]


def _clean(value: acb, largest: float) -> acb:
    """Return a mean without what is rounding: a real eigenvalue is real, zero is zero."""
    tiny = arb(largest) * arb(2) ** (-ctx.prec // 4)
    real, imag = (part.mid() for part in (value.real, value.imag))
    return acb(real if abs(real) > tiny else 0, imag if abs(imag) > tiny else 0)


def _mode(subject: Subject, A: acb_mat, H: acb_mat, value: acb) -> Direction:
    vectors = _null_space(A, value)
    seen = np.array([[complex(entry) for entry in row] for row in (H * vectors).tolist()])
    V = np.array([[complex(entry) for entry in row] for row in vectors.tolist()])
    Q, R = np.linalg.qr(V)
    shown = np.linalg.solve(R.T, seen.T).T  # H Q
    _, sizes, right = np.linalg.svd(shown)
    factor = float(sizes[-1]) if len(sizes) == Q.shape[1] else 0.0
    vector = Q @ right[-1].conj()
    vector = vector / vector[np.abs(vector).argmax()]
    return Direction(factor, subject.named(vector.real), complex(value))


def _null_space(A: acb_mat, value: acb) -> acb_mat:
    """Return a basis of the vectors v with A v = λ v, columns, by elimination with full pivoting."""
    n = A.nrows()
    rows = [[A[i, j] - (value if i == j else 0) for j in range(n)] for i in range(n)]
    order, rank = list(range(n)), 0
    scale = max((float(abs(entry).upper()) for row in rows for entry in row), default=0.0)
    small = arb(scale) * arb(2) ** (-ctx.prec // (4 * max(n, 1)) - 40)
    while rank < n:
        size, i, j = max(
            ((abs(rows[i][order[j]]).mid(), i, j) for i in range(rank, n) for j in range(rank, n)),
            key=lambda one: one[0],
        )
        if not size > small:
            break
        rows[rank], rows[i] = rows[i], rows[rank]
        order[rank], order[j] = order[j], order[rank]
        pivot = rows[rank][order[rank]]
        rows[rank] = [(entry / pivot).mid() for entry in rows[rank]]
        for k in range(n):
            if k != rank:
                factor = rows[k][order[rank]]
                rows[k] = [(a - factor * b).mid() for a, b in zip(rows[k], rows[rank], strict=True)]
        rank += 1
    free = order[rank:]
    basis = acb_mat(n, len(free))
    for c, j in enumerate(free):
        basis[j, c] = acb(1)
        for k in range(rank):
            basis[order[k], c] = -rows[k][j]
    return basis


MODAL: Final = Measure(
    key="modal",
    symbol="|Hv|",
    title="modal factor",
    reference="Popov–Belevitch–Hautus; Porter & Crossley 1972",
    reading="how much of each mode the outputs show; 0: the mode is not observable; time-invariant systems",
    compute=modal,
    basis="matrix",
)
