"""The Gramian of a reducible system through a stationary one, without any step error.

    z = V(t) x,   z' = A_z z,   y = H_z z:     H(τ) Φ(τ, t) = H_z e^(A_z (τ − t)) V(t)

    W(t, t0) = V(t)ᵀ W_z(t − t0) V(t),     W_z = R_zᵀ R_z,     R = qr(R_z V(t))

R_z is carried from panel to panel as in ``square_root``, but panels of one length share their matrices, and
these are matrix exponentials: Taylor series, so that an entry is wrong by rounding relative to what it is
summed from, |ΔX| ≲ ε |A|h e^(|A|h), whatever the units of the variables. (Scaling and squaring is accurate
relative to the largest entry only.) The error of V(t), and of the product with it, is added at every instant.

References
----------
V. M. Morozov, F. Yu. Baklanov (2018), section 5, (13)–(22). C. Moler, C. Van Loan (2003), Nineteen dubious
ways to compute the exponential of a matrix, method 1.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Final

import numpy as np

from obscli.numeric.collocation import gauss_legendre
from obscli.numeric.constant_form import ConstantForm, stationary_system
from obscli.numeric.gramian import LOST, Gramian, squared_rounding
from obscli.numeric.numeric_system import NumericSystem
from obscli.numeric.panels import Panels
from obscli.numeric.program import EPS, Array
from obscli.numeric.rates import Rates, rates_of
from obscli.numeric.settings import Effort
from obscli.numeric.square_root import carried
from obscli.numeric.transition import NODES, edges_of, longest_step, times


#: Panels are of one length if their lengths agree to so many digits: W_z then is that of a window as much
#: longer or shorter, and its kernel is the same.
_ALIKE: Final = 10

#: Panels before the first instant: one for so many variables at the least, so that there are twice as many
#: samples of each output as variables.
_VARIABLES: Final = NODES // 2

#: Terms of the series beyond the number of variables (the longest chain of integrators): λh is 2 at the most.
_TERMS: Final = 40

#: Panels put together at a time.
_PIECE: Final = 256


def lifted_gramian(
    form: ConstantForm, system: NumericSystem, start: float, instants: Array, _: Rates, effort: Effort
) -> Gramian:
    """Return R(t_i) for W(t_i, t0) at all instants; R = 0 with error ``LOST`` where columns grow too far.

    Parameters
    ----------
    form : a stationary system with the outputs of ``system``
    start, instants : t0, and t_i in order, shape (N,)
    effort : how many steps; there is no step error

    Raises
    ------
    TooManyStepsError
        where the interval is too long for the motion of the stationary system
    """
    stationary = NumericSystem(stationary_system(system.system, form), start, float(instants[-1]))
    rates = rates_of(stationary, instants[:1])
    first = np.linspace(start, instants[0], len(form.variables) // _VARIABLES + 2)[1:-1]
    edges = edges_of(start, np.concatenate([first, instants]), longest_step(rates), effort.most_steps)
    root = carried(_panels(stationary, edges), stationary, start, instants)
    return _in_states(root, *system.covectors(form.variables, instants))


def _panels(stationary: NumericSystem, edges: Array) -> Iterator[Panels]:
    """Yield the panels between edges in order, those of one length made once."""
    h = np.diff(edges)
    _, first, which = np.unique(np.round(h / h.max(), _ALIKE), return_index=True, return_inverse=True)
    made = [_panel(stationary, float(h[k])) for k in first]
    for k in range(0, len(h), _PIECE):
        part = [made[i] for i in which[k : k + _PIECE]]
        matrices = (np.concatenate(one) for one in zip(*part, strict=True))
        yield Panels(edges[1:][k : k + _PIECE], *matrices)


def _panel(stationary: NumericSystem, h: float) -> tuple[Array, Array, Array, Array]:
    """Return, for one panel of length h, what ``Panels`` has beside its end, shape (1, …) each."""
    rule, moving, n, m = gauss_legendre(NODES), stationary.moving, stationary.n, stationary.m
    at = stationary.coefficients(np.zeros(1))
    A, A_error, H, H_error = at.A[0], at.A_error[0], at.H[0], at.H_error[0]
    nodes = np.append(h * (rule.nodes - 1), -h)
    X = np.array([_exponential(A, moving, s) for s in nodes])
    size = _exponential(np.abs(A), moving, h)
    rounding = EPS * h * times(np.abs(A), size, moving)
    coefficients = h * (size[:, moving] @ times(A_error, size, moving))
    drift: Array = rounding**2 + coefficients**2
    shares = np.sqrt(h * rule.weights)[:, None, None]
    rows = (shares * times(np.broadcast_to(H, (NODES, m, n)), X[:-1], moving)).reshape(1, NODES * m, n)
    in_rows = times(H_error**2, size**2, moving) + (H**2)[:, moving] @ drift
    return X[-1:], rows, drift[None], h * in_rows.sum(axis=0)[None]


def _exponential(A: Array, moving: Array, s: float) -> Array:
    """Return the moving rows of e^(A s), given those of A, shape (p, n), by its Taylor series."""
    whole: Array = np.eye(A.shape[1])[moving]
    term = s * A
    for k in range(2, A.shape[1] + _TERMS):
        whole = whole + term
        if (np.abs(term) <= EPS / 8 * np.abs(whole)).all():
            break
        term = s / k * (A[:, moving] @ term)
    return whole


def _in_states(root: Gramian, V: Array, V_error: Array) -> Gramian:
    """Return R = R_z V(t_i) with its error, in the file's units of the states.

    Parameters
    ----------
    root : R_z D, D its units
    V, V_error : V(t_i) and its rounding error, shape (N, n_z, n) each
    """
    V, V_error = V / root.units[:, :, None], V_error / root.units[:, :, None]
    count, lifted, n = V.shape
    squares = np.einsum("kij,kij->kj", root.matrices, root.matrices)
    rounding = squared_rounding(max(n, lifted))
    local = np.einsum("ki,kij->kj", squares, V_error**2 + 2 * rounding * V**2)
    error = V.transpose(0, 2, 1) @ root.error @ V + local[:, None, :] * np.eye(n)
    lost = root.error[:, 0, 0] >= LOST
    error[lost] = LOST * np.eye(n)
    product = root.matrices @ V
    matrices = np.zeros((count, n, n))
    rows = min(lifted, n)
    matrices[:, :rows] = np.linalg.qr(product, mode="r") if lifted > n else product
    return replace(root, method="lift", matrices=matrices, units=np.ones((count, n)), error=error)
