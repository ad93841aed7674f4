"""The Gramian by its differential equation (3), as the papers integrate it.

    dW/dt = −Aᵀ W − W A + Hᵀ H,    W(t0, t0) = 0

with an explicit Runge–Kutta method of order 8 (DOP853). The integration is made a second time with ten times
the tolerance; the difference of the two is the error that the rank decision is told of. W is the square of
what ``square_root`` finds: so are its singular values, and half of the digits are gone.

References
----------
V. M. Morozov, F. Yu. Baklanov (2018), (3). E. Hairer, S. P. Nørsett, G. Wanner, Solving Ordinary Differential
Equations I, II.10.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from obscli.numeric.errors import NotComputableError
from obscli.numeric.gramian import Gramian, diagonal_root, unit_diagonal
from obscli.numeric.numeric_system import NumericSystem
from obscli.numeric.program import EPS, Array
from obscli.numeric.rates import Rates
from obscli.numeric.settings import Effort
from obscli.numeric.square_root import square_root_gramian


#: The integration whose difference is the error estimate is this much coarser.
_COARSER: Final = 10.0

#: Entries are held to rtol down to this fraction of their final size.
_FLOOR: Final = 1e-3


def lyapunov_gramian(
    system: NumericSystem, start: float, instants: Array, rates: Rates, effort: Effort
) -> Gramian:
    """Return W(t_i, t0) at all instants.

    Parameters
    ----------
    start, instants : t0, and t_i in order, shape (N,)
    rates : for the sizes of the states only: the integrator finds its own steps
    effort : tolerance of the integrator, relative to each entry of W, is its step error

    Raises
    ------
    NotComputableError
        where the integrator gives up, or a coefficient does not exist
    """
    sizes = np.linalg.norm(
        square_root_gramian(system, start, instants[-1:], rates, effort).matrices[0], axis=0
    )
    units = 1 / np.where(sizes > 0, sizes, 1.0)
    fine = _integrate(system, start, instants, units, effort.rtol)
    coarse = _integrate(system, start, instants, units, _COARSER * effort.rtol)
    size = diagonal_root(fine)
    with np.errstate(invalid="ignore", over="ignore"):
        change = (fine - coarse) / size[:, :, None] / size[:, None, :]
        spread = np.linalg.norm(change, axis=(1, 2)) + system.n * EPS
        found = unit_diagonal("lyapunov", instants, start, fine, spread)
    return replace(found, units=found.units * units)


def _integrate(system: NumericSystem, start: float, instants: Array, units: Array, rtol: float) -> Array:
    """Return W in units of the states, shape (N, n, n)."""
    from scipy.integrate import solve_ivp  # noqa: PLC0415 - half a second to import, for this method only

    n, moving = system.n, system.moving
    ratio = units / units[moving][:, None]

    def right_side(t: float, w: Array) -> Array:
        A, H = system.matrices(np.array([t]))
        h = H[0] * units
        product = w.reshape(n, n)[:, moving] @ (A[0] * ratio)
        change: Array = h.T @ h - product - product.T
        return change.ravel()

    with np.errstate(over="ignore", invalid="ignore"):
        found = solve_ivp(
            right_side,
            (start, float(instants[-1])),
            np.zeros(n * n),
            method="DOP853",
            t_eval=instants,
            rtol=rtol,
            atol=_FLOOR * rtol,
        )
    if not found.success:
        raise NotComputableError(f"equation (3) could not be integrated: {found.message}")
    W: Array = found.y.T.reshape(len(instants), n, n)
    return W
