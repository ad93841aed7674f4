"""The information filter in square-root form: what measurements with noise tell of the state, in time.

S with Sᵀ S = P⁻¹ is carried from panel to panel as the square root of the Gramian is, the outputs in units
of their noise; driving noise enters at the edges of the panels, half of each panel's at either end. There
x⁺ = x⁻ + L w, w ~ N(0, I), L Lᵀ = h G Q Gᵀ, and w is eliminated:

    ( I      0 )        ( *  * )
    ( −S L   S )  = Q'  ( 0  S⁺)

No prior is needed (S may start as zero), and constant states without a prior stay without information until
something is measured. Panels are halved until the result stands.

References
----------
G. J. Bierman, Factorization Methods for Discrete Sequential Estimation (1977), ch. V, VI.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from obscli.numeric.errors import NotComputableError, TooManyStepsError
from obscli.numeric.noise import NoiseModel
from obscli.numeric.numeric_system import NumericSystem
from obscli.numeric.panels import Panels
from obscli.numeric.program import Array, Counts
from obscli.numeric.rates import rates_of
from obscli.numeric.settings import Effort
from obscli.numeric.transition import edges_of, longest_step, not_resolved, panels


#: Step error of the transition; relative change of the information that halving the panels may make.
STEP_ERROR: Final = 1e-11
STANDS: Final = 2e-3

#: A row of the transition that is known worse than this has a pole behind it.
_RESOLVED: Final = 1e-3

#: With driving noise: panels to begin with, how often they are halved, and how many are made at the most.
_FEWEST: Final = 60
_HALVINGS: Final = 6
_MOST: Final = 20_000

#: The first panels are so long in units of the time constant of a filter of driven and measured states.
_PER_BANDWIDTH: Final = 0.5

#: Rows are triangularised when they are more than so many per state.
_GATHERED: Final = 3

#: Columns of states that decay are rescaled, by powers of two, when they become larger than this.
_LARGE: Final = 1e60
_FARTHEST: Final = 1000

#: The squares of what is larger overflow.
_TOO_LARGE: Final = 1e150

_PROBES: Final = 18
_ZERO: Final = 1e-13
_CLEAR: Final = 1e-9
_SMALLEST: Final = 1e-8


def information(noise: NoiseModel, start: float, instants: Array, kept: Counts, priors: Array) -> Array:
    """Return roots of the information on some states at instants, the others unknown, shape (N, c, c).

    Parameters
    ----------
    noise : of the system; the states' prior is not taken from it
    start, instants : t0, and t_i in order, shape (N,)
    kept : indices of the states kept, shape (c,)
    priors : rows of information at t0, shape (k, n)

    Raises
    ------
    NotComputableError
        where the system cannot be integrated, or the information overflows
    """
    rates = rates_of(noise.system, np.linspace(start, instants[-1], _PROBES)[1:-1])
    longest = longest_step(rates)
    if noise.drive is None:
        return _marginal(
            _carried(noise, edges_of(start, instants, longest, _MOST), instants, priors, kept), kept
        )
    span = float(instants[-1] - start)
    longest = min(longest, span / _FEWEST, _PER_BANDWIDTH / max(_bandwidth(noise, start, span), 1 / span))
    found: list[Array] = []
    for halving in range(_HALVINGS):
        try:
            edges = edges_of(start, instants, longest / 2**halving, _MOST)
        except TooManyStepsError:
            break
        found.append(_marginal(_carried(noise, edges, instants, priors, kept), kept))
        if halving and _stands(found[-2][-1], found[-1][-1]):
            return found[-1]
    raise NotComputableError(
        f"the driving noise is not resolved in {_MOST} steps: Q is large against R for so long an interval"
    )


def _bandwidth(noise: NoiseModel, start: float, span: float) -> float:
    """Return how fast a filter of directly driven and measured states would be, |R^(-1/2) H G Q^(1/2)|."""
    t = start + span * np.arange(1, _PROBES) / _PROBES
    _, H = noise.system.matrices(t)
    return float(np.linalg.norm(noise.whitening @ H @ noise.driving(t), axis=(1, 2)).max())


def _carried(noise: NoiseModel, edges: Array, instants: Array, priors: Array, kept: Counts) -> Array:
    """Return S at the instants, the columns not kept in any units, shape (N, n, n)."""
    system = noise.system
    chain = _Chain(system.moving, priors, kept)
    found: list[Array] = []
    last, pending = float(edges[0]), 0.0
    for piece in panels(system, edges, Effort(STEP_ERROR, _MOST)):
        _require_resolved(system, piece)
        rows = _whitened(piece, noise.whitening)
        at = np.append(last, piece.ends)
        driving = None if noise.drive is None else noise.driving(at)
        for k, half in enumerate(np.diff(at) / 2):
            if driving is not None:
                chain.drive(driving[k] * np.sqrt(pending + half))
            chain.advance(piece.transition[k], rows[k])
            pending = half
            if at[k + 1] == instants[len(found)]:
                found.append(chain.snapshot(None if driving is None else driving[k + 1] * np.sqrt(half)))
        last = float(at[-1])
    return np.array(found)


def _require_resolved(system: NumericSystem, piece: Panels) -> None:
    """Raise where the step error of the transition says that it is not known."""
    error = piece.transition_error.sum(axis=2)
    size = (piece.transition**2).sum(axis=2)
    lost = (error > _RESOLVED**2 * size).any(axis=1)
    if lost.any():
        raise NotComputableError(not_resolved(system, float(piece.ends[lost][0])))


def _whitened(piece: Panels, whitening: Array) -> Array:
    """Return the rows of the outputs in units of their noise."""
    k, rows, n = piece.rows.shape
    whitened: Array = (whitening @ piece.rows.reshape(k, -1, len(whitening), n)).reshape(k, rows, n)
    return whitened


class _Chain:
    """S at the end of the last panel, as rows that are triangularised from time to time.

    The column of a state that decays without noise grows without bound; such columns are in units of their
    own, x = 2^e z, which nobody sees who eliminates them. ``kept``: the states that are not eliminated.
    """

    def __init__(self, moving: Array, priors: Array, kept: Counts) -> None:
        self._rows = priors
        self._moving = moving
        self._free = np.setdiff1d(moving, kept)
        self._whole = np.eye(priors.shape[1])
        self._exponents = np.zeros(priors.shape[1])
        self._units = np.ones(priors.shape[1])
        self._ratio = np.ones((len(moving), priors.shape[1]))

    def advance(self, transition: Array, rows: Array) -> None:
        """Carry the rows to the end of a panel and take in those measured on it."""
        self._whole[self._moving] = np.where(transition == 0, 0.0, transition * self._ratio)
        with np.errstate(over="ignore", invalid="ignore"):  # seen at the end
            self._rows = np.concatenate([self._rows @ self._whole, rows * self._units])
        if np.abs(self._rows[:, self._free]).max(initial=0.0) > _LARGE:
            self._rescale()
        if len(self._rows) > _GATHERED * self._rows.shape[1]:
            self._rows = triangle(self._rows)

    def drive(self, L: Array) -> None:
        """Let driving noise with covariance L Lᵀ act."""
        self._rows = driven(self._rows, L / self._units[:, None])

    def _rescale(self) -> None:
        size = np.abs(self._rows[:, self._free]).max(axis=0)
        exponent = np.zeros(len(self._exponents))
        exponent[self._free] = -np.round(np.log2(np.where(size > _LARGE, size, 1.0)))
        self._rows = self._rows * 2.0**exponent
        self._exponents += exponent
        self._units = _two_to(self._exponents)
        self._ratio = _two_to(self._exponents - self._exponents[self._moving][:, None])

    def snapshot(self, L: Array | None) -> Array:
        """Return S, shape (n, n), with the driving noise still to come at this instant."""
        n = self._rows.shape[1]
        if not (np.abs(self._rows) < _TOO_LARGE).all():
            raise NotComputableError(
                "the information overflows: a state decays too far; give a shorter interval"
            )
        self._rows = triangle(self._rows)
        rows = self._rows if L is None else driven(self._rows, L / self._units[:, None])
        root = np.zeros((n, n))
        root[: len(rows)] = rows
        return root


def _two_to(exponents: Array) -> Array:
    """Return 2^e, infinite or zero where that is too large or too small."""
    with np.errstate(over="ignore", under="ignore"):
        return np.exp2(np.clip(exponents, -_FARTHEST - 100, _FARTHEST + 100))


def driven(rows: Array, L: Array) -> Array:
    """Return S⁺ after noise x⁺ = x⁻ + L w, w ~ N(0, I), for S of shape (r, n) and L (n, d)."""
    n, d = L.shape
    joint = np.zeros((d + len(rows), d + n))
    joint[:d, :d] = np.eye(d)
    joint[d:, :d], joint[d:, d:] = -(rows @ L), rows
    return triangle(joint)[d:, d:]


def triangle(rows: Array) -> Array:
    """Return R with Rᵀ R = Sᵀ S, of no more rows than columns; S itself where it is empty or not finite."""
    if not len(rows) or not np.isfinite(rows).all():
        return rows
    R: Array = np.linalg.qr(rows, mode="r")  # type: ignore[assignment]  # no QRResult in this mode
    return R


def _marginal(roots: Array, kept: Counts) -> Array:
    """Return the information on the states kept, the others eliminated, shape (N, c, c).

    What is left of a column after the elimination is nothing where it is below rounding of the column.

    Raises
    ------
    NotComputableError
        where a direction of the others is neither seen nor unseen
    """
    n = roots.shape[-1]
    unknown = np.setdiff1d(np.arange(n), kept)
    found = np.zeros((len(roots), len(kept), len(kept)))
    for k, root in enumerate(roots):
        left, values, _ = np.linalg.svd(root[:, unknown] / _units(root[:, unknown]))
        r = int((values > _ZERO).sum())
        if r and values[r - 1] < _CLEAR:
            raise NotComputableError(
                "what starts anew is seen too dimly to be told from what is shared: give it a prior"
            )
        units = _units(root[:, kept])
        _, size, right = np.linalg.svd(left[:, r:].T @ root[:, kept] / units, full_matrices=False)
        c = int((size > _ZERO).sum())
        told = np.where(np.abs(right[:c]) > _ZERO, right[:c], 0.0)
        found[k, :c] = size[:c, None] * told * units
    return found


def _units(columns: Array) -> Array:
    """Return the lengths of columns, 1 where they are zero."""
    size = np.linalg.norm(columns, axis=0)
    units: Array = np.where(size > 0, size, 1.0)
    return units


def _stands(before: Array, after: Array) -> bool:
    """Whether two roots of information agree in all directions that matter."""
    units = _units(after)
    coarse = np.linalg.svd(before / units, compute_uv=False)
    fine = np.linalg.svd(after / units, compute_uv=False)
    matters = fine > _SMALLEST * fine.max(initial=0.0)
    return bool((np.abs(coarse - fine)[matters] <= STANDS * fine[matters]).all())
