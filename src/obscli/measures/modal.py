"""The modal factor of a time-invariant system: how much of each mode the outputs show.

    A v_i = λ_i v_i,  |v_i| = 1:   |H v_i|,   the smallest σ of H V where several vectors V belong to λ_i

Zero exactly where the mode is unobservable (Popov–Belevitch–Hautus). Modes and vectors are found with
hundreds of bits, so that multiple eigenvalues, which double precision scatters, stay together. What is zero
to half of these is zero; in an observable system nothing is, and more bits are taken.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from flint import acb, acb_mat, arb

from obscli.exact.ball import BallPoint, precision
from obscli.measures.measure import Direction, Found, Measure, NotMeasuredError
from obscli.measures.mode_values import is_rational, largest, mode_values
from obscli.measures.mode_vectors import UnresolvedModeError, half_precision, mode_vectors
from obscli.measures.subject import Subject


#: Bits in the order tried; a state, where the matrix is not rational.
_PRECISIONS: Final = (400, 1500, 6000)
_PER_STATE: Final = 60

_MOST_STATES: Final = 40


def modal(subject: Subject) -> Found:
    """Return every eigenvalue with the factor of its mode, the least observable first."""
    n = subject.n
    if not subject.numeric.is_constant:
        raise NotMeasuredError("modes are those of a time-invariant system; this one depends on time")
    if n > _MOST_STATES:
        raise NotMeasuredError(f"modes are found for up to {_MOST_STATES} states")
    fewest = 0 if is_rational(subject.there.A.entries) else _PER_STATE * n
    for bits in _PRECISIONS:
        with precision(max(bits, fewest), 1):
            try:
                found = _modes(subject)
            except UnresolvedModeError:
                continue
            return Found(system={"modal": tuple(sorted(found, key=lambda one: one.value))})
    raise NotMeasuredError(f"the modes are not told apart with {_PRECISIONS[-1]} bits")


def _modes(subject: Subject) -> list[Direction]:
    A, H = _matrices(subject)
    modes = [one for one in mode_values(subject.there.A.entries, A) if one.value.imag >= 0]
    found = [_mode(subject, H, one.value, mode_vectors(A, one)) for one in modes]
    if subject.rank == subject.n and any(one.value == 0 for one in found):
        raise UnresolvedModeError
    return found


def _matrices(subject: Subject) -> tuple[acb_mat, acb_mat]:
    """Return D⁻¹ A D and H D, x = D x_s."""
    there = subject.there
    point = BallPoint(there, {}, 1)
    A, H = acb_mat(there.n, there.n), acb_mat(there.m, there.n)
    D = [arb(float(one)) for one in subject.units]
    for (i, j), entry in there.A.entries.items():
        A[i, j] = acb((point.value(entry)[0] * D[j] / D[i]).mid())
    for (i, j), entry in there.H.entries.items():
        H[i, j] = acb((point.value(entry)[0] * D[j]).mid())
    return A, H


def _mode(subject: Subject, H: acb_mat, value: acb, vectors: acb_mat) -> Direction:
    """Return the smallest singular value of H on the space of the vectors, and the vector it belongs to."""
    Q = _orthonormal(vectors)
    shown = H * Q
    squares, right = (shown.conjugate().transpose() * shown).mid().eig(right=True, algorithm="approx")
    k = min(range(len(squares)), key=lambda i: squares[i].real.mid())
    square, size = squares[k].real.mid(), largest(H)
    is_zero = square <= size * size * half_precision()
    vector = _unit([sum((Q[i, j] * right[j, k] for j in range(Q.ncols())), acb(0)) for i in range(Q.nrows())])
    components = np.array([float(entry.real) for entry in vector])
    return Direction(0.0 if is_zero else float(square.sqrt()), subject.named(components), complex(value))


def _orthonormal(vectors: acb_mat) -> acb_mat:
    """Return an orthonormal basis of the space of independent columns, by Gram–Schmidt."""
    basis: list[acb_mat] = []
    for column in vectors.transpose().tolist():
        rest = acb_mat([column])
        for one in basis + basis:  # twice is enough
            rest = (rest - rest * one.conjugate().transpose() * one).mid()
        size = sum((abs(entry) ** 2 for entry in rest.entries()), arb(0)).sqrt()
        basis.append((rest * (1 / size)).mid())
    return acb_mat([list(one.entries()) for one in basis]).transpose()


def _unit(vector: list[acb]) -> list[acb]:
    """Return a vector whose largest component is 1."""
    pivot = max(vector, key=lambda entry: abs(entry).mid())
    return [entry / pivot for entry in vector]


MODAL: Final = Measure(
    key="modal",
    symbol="|Hv|",
    title="modal factor",
    reference="Popov–Belevitch–Hautus; Porter & Crossley 1972",
    reading="how much of each mode the outputs show; 0: the mode is not observable; time-invariant systems",
    compute=modal,
    basis="matrix",
)
