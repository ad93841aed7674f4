"""The least-squares measure: how an error of the normal equations enters a state.

    B(t_N) = Σ_j Φ(t_j, t_N)ᵀ Hᵀ W² H Φ(t_j, t_N),   t_j = t_0 + j Δt,  j = 0 … N − 1

    μ_j = max_λ ‖P_λ e_j‖ / λ,   P_λ the orthoprojector on the eigenspace of λ > 0;   ∞ if not observable

(= max_i |u_ij|/λ_i where eigenvalues are simple; where they repeat |u_ij| depends on the choice of a basis.)
Of a discrete-time system Φ(t_j, t_0) stands there, and t_j are whole steps. B is never formed in double
precision: its condition is the square of that of the rows.

References
----------
I. A. Bagmut (2009), (5)–(9), after D. V. Lebedev and A. I. Tkachenko. Δt, N and W are not stated there; with
1 s, 11 and 1 five of the six printed values come out, 0.58 for the sixth (printed 0.56).
"""

from __future__ import annotations

from typing import Final

import numpy as np
from flint import arb, arb_mat

from obscli.exact.ball import precision
from obscli.measures.gram_spectrum import GramSpectrum, gram_spectrum
from obscli.measures.in_range import as_double, beyond
from obscli.measures.local import PRECISIONS, as_matrix, local
from obscli.measures.measure import Found, Measure, NotMeasuredError, Option
from obscli.measures.subject import Subject
from obscli.numeric.hidden_motion import transitions
from obscli.numeric.program import Array
from obscli.numeric.rates import rates_of
from obscli.numeric.settings import Effort
from obscli.numeric.transition import edges_of, longest_step


_KEY: Final = "least-squares"
_STEP_ERROR: Final = 1e-14
_MOST: Final = 20_000

#: Samples have m n numbers each; so many in all are worked on.
_MOST_ENTRIES: Final = 1_000_000

#: In double precision rows do not tell directions apart whose singular values, columns alike, are so far.
_RESOLVED: Final = 1e-12


def least_squares(subject: Subject) -> Found:
    """Return μ of every target from N samples without noise."""
    count, step = round(subject.number(_KEY, "N")), subject.number(_KEY, "dt")
    _require_affordable(subject, count)
    end = subject.start + (count - 1) * step
    rows = _rows(subject, step, count) * subject.number(_KEY, "W") * subject.units
    if subject.system.discrete:
        end = subject.start  # nothing is moved backwards: the estimate is that of the first state
    there = local(subject.numeric, subject.there, subject.rank, end, subject.units)
    bits = max(there.bits, PRECISIONS[1])
    with precision(bits, 1):
        U = there.orthogonal.U
        C = as_matrix(rows, subject.n) * U.transpose()
        _require_resolved(C, count)
        spectrum = gram_spectrum(C, U)
        z = as_matrix(subject.covectors(end), subject.n) * U.transpose()
        values = [
            as_double(_largest(spectrum, z, k)) if observable else np.inf
            for k, observable in enumerate(subject.observable)
        ]
    return Found(tuple(values), remarks=beyond(values.count(None)))


def _require_affordable(subject: Subject, count: int) -> None:
    n, m = subject.n, subject.there.m
    most = _MOST_ENTRIES // max(m * n, 1)
    if count > most:
        raise NotMeasuredError(
            f"{count} samples of {n} states and {m} outputs are too many: take at most {most}, farther apart "
            f"(--option least-squares.N={most}, least-squares.dt=…)"
        )


def _rows(subject: Subject, step: float, count: int) -> Array:
    """Return H(t_j) Φ(t_j, t_N) of all samples below each other, shape (N m, n)."""
    numeric = subject.numeric
    if subject.system.discrete:
        return _stepped_rows(subject, step, count)
    instants = subject.start + step * np.arange(float(count))
    outputs: Array = numeric.matrices(instants)[1]
    if count == 1:
        return np.asarray(outputs[0], dtype=float)
    rates = rates_of(numeric, np.linspace(instants[0], instants[-1], 18)[1:-1])
    edges = edges_of(instants[0], instants[1:], longest_step(rates), _MOST)
    rows: Array = np.asarray(outputs[0])
    taken = 1
    for phi, end in transitions(numeric, edges, Effort(_STEP_ERROR, _MOST)):
        rows = rows @ phi
        if end == instants[taken]:
            rows = np.concatenate([rows, outputs[taken]])
            taken += 1
    return rows


def _stepped_rows(subject: Subject, step: float, count: int) -> Array:
    """Return H(k_j) Φ(k_j, k_0) of all samples of a discrete-time system below each other, shape (N m, n)."""
    if step != round(step):
        raise NotMeasuredError("a discrete-time model counts steps: least-squares.dt is a whole number")
    every = subject.start + np.arange((count - 1) * step + 1)
    F, H = subject.numeric.matrices(every)
    moved, rows = np.eye(subject.n), []
    for k in range(len(every)):
        if k % step == 0:
            rows.append(H[k] @ moved)
        moved = F[k] @ moved
    return np.concatenate(rows)


def _require_resolved(C: arb_mat, count: int) -> None:
    """Refuse where the samples do not tell all observable directions apart."""
    matrix = np.array([[float(entry) for entry in row] for row in C.tolist()]).reshape(C.nrows(), C.ncols())
    size = np.linalg.norm(matrix, axis=0)
    values = np.linalg.svd(matrix / np.where(size > 0, size, 1.0), compute_uv=False)
    if len(values) < C.ncols() or (len(values) and values[-1] <= _RESOLVED * values[0]):
        raise NotMeasuredError(
            f"{count} samples do not tell the {C.ncols()} observable combinations apart in double precision: "
            "take more, or farther apart (--option least-squares.N=…, least-squares.dt=…)"
        )


def _largest(spectrum: GramSpectrum, z: arb_mat, k: int) -> arb:
    """Return max_λ ‖P_λ z_k‖/λ."""
    r = len(spectrum.squares)
    largest = arb(0)
    for cluster in spectrum.clusters:
        chosen = tuple(arb(1) if i in cluster else arb(0) for i in range(r))
        row = arb_mat(1, r, [z[k, j] for j in range(r)]) * spectrum.function(chosen)
        size = sum((entry * entry for entry in row.entries()), arb(0)).nonnegative_part().sqrt()
        largest = largest.max(size / spectrum.squares[cluster[0]])
    return largest


LEAST_SQUARES: Final = Measure(
    key=_KEY,
    symbol="(9)",
    title="least squares",
    reference="Bagmut 2009, (9); Lebedev & Tkachenko",
    reading="by how much an error of the normal equations may enter; inf: not observable",
    compute=least_squares,
    basis="samples",
    better="smaller",
    options=(
        Option("dt", 1.0, "seconds between samples"),
        Option("N", 11, "how many samples", whole=True),
        Option("W", 1.0, "weight of every output"),
    ),
)
