"""How much of what a Gramian shows comes from noise of the signals: noise in a log looks like motion.

Of a record s = s̄ + e only e's size is known. Noise of that size is added once more, s̃ = s + ẽ, and the rows
of both systems are compared at the same instants, by the Gramian of the pair [x; x̃]:

    |R v|²  = ∫ |H Φ v|²              what the record shows of a direction v
    |E v|²  = ∫ |H Φ v − H̃ Φ̃ v|²      what noise alone shows of it, the mean of some draws

Where s̄ shows nothing of v, R v is the work of e, as E v is that of ẽ, and both are alike in size. A direction
counts as excited where |R v| > κ |E v|. On the row space of R = U S Vᵀ, v = V S⁻¹ w, the directions are the
singular vectors of N = E V S⁻¹, and those are excited whose singular value is below 1/κ. The others are
faint, and the kernel is hidden. A state is not excited where a hidden direction contains it, beyond what
noise may do, or where it is known κ times worse without the faint ones.
What of E v looks like a change along excited directions is left out, since v was chosen free of that in R:
E v is projected, and the rest tried again until no direction is added.

Noise that is not white may look like motion where white noise of its size does not. So a direction has to be
shown as well by the calmest record that noise of this size explains (``signal_noise``), with the root R_c:
|R v| < κ |R_c v|.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from obscli.model.system import System
from obscli.numeric.analysis import Numeric, affordable_steps
from obscli.numeric.errors import NotComputableError
from obscli.numeric.gramian import Gramian
from obscli.numeric.numeric_system import NumericSystem, constants_of
from obscli.numeric.program import Array, Flags, constant_value
from obscli.numeric.scaling import scaled, sizes_of
from obscli.numeric.settings import STEP_ERROR, Effort
from obscli.numeric.signal_noise import calmed, noisier
from obscli.numeric.signals import Changed
from obscli.numeric.square_root import square_root_gramian
from obscli.numeric.subspace import Subspaces, subspaces


#: κ: e and ẽ are draws of the same size, and may be so far apart where few samples count.
CLEAR: Final = 5.0
_DRAWS: Final = 6

#: Each of them is a panel of two systems, in every draw.
_MOST_SAMPLES: Final = 50_000

#: A component of a unit vector that may be rounding.
_ROUNDED: Final = 1e-9


@dataclass(frozen=True, slots=True, eq=False)
class Excitation:
    """What is left of the rank without the work of noise, over the window up to one instant.

    Parameters
    ----------
    t : the instant
    ratios : |R v| / |E v| of the directions that the Gramian shows, the largest first
    clear : how many of them stand clear of white noise
    excited : how many of these the calmest record shows as well
    calm : the rank of the calmest record that the noise explains; None: it is not clear
    not_excited : the states that directions contain which the record does not show, or as noise would
    """

    t: float
    ratios: tuple[float, ...]
    clear: int
    excited: int
    calm: int | None
    not_excited: tuple[str, ...]


class Pair(NumericSystem):
    """Two systems side by side, [x; x̃], with y + ỹ for the output; both of the same size."""

    def __init__(self, one: NumericSystem, other: NumericSystem) -> None:
        self.system, self.constants, self.motion = one.system, one.constants, one.motion
        self._one, self._other = one, other
        self.moving = np.concatenate([one.moving, one.n + other.moving])

    @property
    def n(self) -> int:
        """The number of states."""
        return 2 * self._one.n

    @property
    def is_constant(self) -> bool:
        """Whether no coefficient varies with time."""
        return False

    @property
    def parts(self) -> tuple[NumericSystem, ...]:
        """The two systems."""
        return self._one, self._other


def deviations_of(system: System) -> dict[str, float]:
    """Return the standard deviations of samples of signals that the file gives, by function."""
    given = system.noise.signals if system.noise else {}
    constants = constants_of(system)
    sampled = set(system.sampled)
    found = {name: constant_value(one, constants) for name, one in given.items() if name in sampled}
    return {name: deviation for name, deviation in found.items() if deviation > 0}


def excitation(numeric: Numeric) -> Excitation | None:
    """Return what noise of the signals may have made of the rank; None where the file gives no noise.

    Raises
    ------
    NotComputableError
        where the system with more noise cannot be integrated
    """
    deviations = deviations_of(numeric.system.system)
    conclusive = np.flatnonzero(numeric.conclusive)
    if not deviations or not conclusive.size or not numeric.rank:
        return None
    i = int(conclusive[-1])
    draws = _draws(numeric, i, deviations)
    length = np.linalg.norm(np.concatenate([part for draw in draws for part in draw]), axis=0)
    D = 1 / np.where(length > 0, length, 1.0)  # a state that only noise shows counts like the others
    _, S, V = np.linalg.svd(draws[-1][0] * D)
    inverse = V[: numeric.rank].T / S[: numeric.rank]
    clear, others, ratios = _told_apart(
        [(shown * D @ inverse, noise * D @ inverse) for shown, noise in draws]
    )
    calm = _calm(numeric, i, deviations)
    root = calm.gramian.matrices[0] / calm.gramian.units[0] * D
    kept, lost = _shown_by(root @ inverse @ clear)
    seen = inverse @ clear @ kept
    hidden, _ = np.linalg.qr(np.hstack([V[numeric.rank :].T, inverse @ clear @ lost]))
    faint = inverse @ others
    if calm.decided[0] and calm.rank[0] <= numeric.rank - lost.shape[1]:
        rows = np.linalg.svd(root)[2]
        hidden = rows[calm.rank[0] :].T  # the same, less turned by noise
        if calm.rank[0] == seen.shape[1]:  # and the others with it
            seen, faint = _orthonormal(draws[-1][0] * D, rows[: calm.rank[0]].T), faint[:, :0]
    touched = _touched(numeric, draws, D, hidden, seen) | _blurred(faint, seen)
    names = numeric.system.system.state_names
    return Excitation(
        t=float(numeric.horizon.instants[i]),
        ratios=tuple(sorted(ratios, reverse=True)),
        clear=clear.shape[1],
        excited=seen.shape[1],
        calm=int(calm.rank[0]) if calm.decided[0] else None,
        not_excited=tuple(name for name, own in zip(names, touched, strict=True) if own),
    )


def _shown_by(calm: Array) -> tuple[Array, Array]:
    """Return of orthonormal directions those that the calmest record shows, too, and the others.

    Parameters
    ----------
    calm : what it shows of them where the record shows a unit of each, shape (n, k)
    """
    _, size, W = np.linalg.svd(calm)
    shown = CLEAR * size > 1
    return W[: len(size)][shown].T, np.vstack([W[: len(size)][~shown], W[len(size) :]]).T


def _orthonormal(R: Array, X: Array) -> Array:
    """Return a basis of the directions X that R takes to orthonormal ones."""
    return np.asarray(np.linalg.solve(np.linalg.qr(R @ X)[1].T, X.T).T, dtype=float)


def _blurred(faint: Array, seen: Array) -> Flags:
    """Return which states are known far worse without the faint directions, shape (n,).

    Both are orthonormal as the record shows them, R X = 1: by the directions seen alone a state k has the
    deviation |X_k| in units of noise. As much may be shifted from one to the other by noise.
    """
    found: Flags = np.linalg.norm(faint, axis=1) > CLEAR * np.linalg.norm(seen, axis=1)
    return found


def _told_apart(draws: list[tuple[Array, Array]]) -> tuple[Array, Array, list[float]]:
    """Return orthonormal w that stand clear of noise, the others, and |R v| / |E v| of all.

    Parameters
    ----------
    draws : R V S⁻¹, with orthonormal columns, and E V S⁻¹, shape (k, r) both
    """
    rank = draws[0][0].shape[1]
    seen, others, ratios = np.zeros((rank, 0)), np.eye(rank), list[float]()
    while True:
        rest = []
        for shown, noise in draws:
            known = shown @ seen
            work = noise @ others
            rest.append(work - known @ (known.T @ work))
        _, size, W = np.linalg.svd(np.concatenate(rest) / np.sqrt(len(draws)))
        fresh = CLEAR * size < 1
        with np.errstate(divide="ignore"):
            found = (1 / size).tolist()
        if not fresh.any():
            return seen, others, [*ratios, *found]
        ratios += [one for one, clear in zip(found, fresh, strict=True) if clear]
        seen, others = np.hstack([seen, others @ W[fresh].T]), others @ W[~fresh].T
        if not others.shape[1]:
            return seen, others, ratios


def _draws(numeric: Numeric, i: int, deviations: Mapping[str, float]) -> list[tuple[Array, Array]]:
    """Return R and E, shape (2n, n) both, of some draws of the noise, over the window of an instant."""
    one, n = numeric.system, numeric.system.n
    count = len(one.knots(float(numeric.spaces.gramian.starts[i]), float(numeric.horizon.instants[i])))
    if count > _MOST_SAMPLES:
        raise NotComputableError(
            f"{count} instants with samples, {_MOST_SAMPLES} at the most for this test: choose a shorter "
            "interval (--from, --to)"
        )
    found = []
    for draw in range(_DRAWS):
        pair = _gramian(numeric, i, Pair(one, _changed(numeric, noisier(deviations, draw))))
        root = pair.matrices[0] / pair.units[0]
        found.append((root[:, :n], root[:, :n] - root[:, n:]))
    return found


def _calm(numeric: Numeric, i: int, deviations: Mapping[str, float]) -> Subspaces:
    """Return what the calmest record shows over the window of an instant."""
    gramian = _gramian(numeric, i, _changed(numeric, calmed(deviations)))
    return subspaces(scaled(gramian, numeric.system.system, numeric.scaling))


def _gramian(numeric: Numeric, i: int, system: NumericSystem) -> Gramian:
    """Return the Gramian of a system with other samples over the window of an instant."""
    start, t = float(numeric.spaces.gramian.starts[i]), numeric.horizon.instants[i : i + 1]
    effort = Effort(STEP_ERROR["square-root"], affordable_steps(numeric.system))
    return square_root_gramian(system, start, t, numeric.rates, effort)


def _changed(numeric: Numeric, how: Changed) -> NumericSystem:
    return NumericSystem(numeric.system.system, numeric.horizon.start, numeric.horizon.stop, how)


def _touched(
    numeric: Numeric, draws: list[tuple[Array, Array]], D: Array, hidden: Array, seen: Array
) -> Flags:
    """Return which states hidden directions contain, beyond what noise turns such a direction by, shape (n,).

    To first order noise turns a hidden direction d by −X (R X)ᵀ E d, X the directions seen. Directions are
    taken as one for each of some states, 1 there and 0 at the others of these: see ``_pivots``.
    """

    def turned(directions: Array) -> Array:
        """Return by what each draw turns directions, shape (draws, n, q)."""
        return np.array([seen @ ((shown * D @ seen).T @ (noise * D @ directions)) for shown, noise in draws])

    system = numeric.system.system
    by = np.sqrt((turned(hidden) ** 2).mean(axis=0).sum(axis=1))
    sizes = np.ones(len(D)) if numeric.scaling == "automatic" else sizes_of(system, numeric.scaling)
    pivots = _pivots(hidden, by, D / sizes)
    each = hidden @ np.linalg.inv(hidden[pivots])
    moved = turned(each)
    size = np.sqrt(((moved - each @ moved[:, pivots]) ** 2).mean(axis=0))
    contained: Flags = (np.abs(each) > CLEAR * size + _ROUNDED).any(axis=1)
    return contained


def _pivots(hidden: Array, by: Array, units: Array) -> list[int]:
    """Return as many states as there are hidden directions, one after the other those that stand clearest.

    Parameters
    ----------
    by : what noise turns the components by; where none is clear of that, the largest is taken
    units : of the components, in which they are compared then
    """
    rest, found = hidden.copy(), list[int]()
    for _ in range(hidden.shape[1]):
        length = np.linalg.norm(rest, axis=1)
        length[found] = 0.0
        clear = length / (by + _ROUNDED)
        k = int(clear.argmax() if clear.max() > CLEAR else (length * units).argmax())
        found.append(k)
        along = rest[k] / length[k]
        rest -= np.outer(rest @ along, along)
    return found
