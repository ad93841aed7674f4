"""R and P_k from the factors of a period, each group of multipliers on its own subspace.

    M_b = S_K ⋯ S_1,    R_b = log(M_b^m)/(m T),    m = 2 where M_b has multipliers near the negative real axis
    R = Σ_b B_0 R_b L_b,    P_k = Σ_b B_k S_k ⋯ S_1 e^{−R_b (t_k − t0)} L_b,    L_b the rows of [B_0 …]⁻¹

S_k ⋯ S_1 is kept as F_k e^{s_k} and R_b T as ρ I + log(M_b^m e^{−m ρ})/m, with a determinant of modulus 1
under the logarithm: no number is too large or too small.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.linalg import expm

from obscli.numeric.errors import NotComputableError
from obscli.numeric.matrix_logarithm import real_logarithm
from obscli.numeric.periodic_subspaces import PeriodicSubspace, periodic_subspaces
from obscli.numeric.program import Array


#: Angles nearer to π than this, or than so many of their errors, are too near to the negative real axis.
_NEAR_AXIS: Final = 1e-2
_ERRORS: Final = 10.0


@dataclass(frozen=True, slots=True, eq=False)
class _Followed:
    """B_k (K + 1, n, d) over a period, and S_k ⋯ S_1 = F_k e^{s_k}: ``F`` (K + 1, d, d), ``s`` (K + 1,).

    ``balanced`` is M_b e^{−ρ}, its determinant of modulus 1, and ``mean`` ρ.
    """

    bases: Array
    F: Array
    s: Array
    balanced: Array
    mean: float


@dataclass(frozen=True, slots=True, eq=False)
class _Part:
    """One group: R_b T = ρ I + ``log``, L_b ``left`` (d, n), a real logarithm after ``turns`` periods."""

    followed: _Followed
    log: Array
    left: Array
    turns: int

    @property
    def growth(self) -> Array:
        """R_b T, shape (d, d)."""
        return self.log + self.followed.mean * np.eye(len(self.log))

    @property
    def closing(self) -> float:
        """How far e^{−R_b m T} M_b^m is from I."""
        again = np.linalg.matrix_power(expm(-self.log) @ self.followed.balanced, self.turns)
        return float(np.linalg.norm(again - np.eye(len(again)), 2))


@dataclass(frozen=True, slots=True, eq=False)
class Reduction:
    """The stationary equivalent of a period with K steps that end at ``times`` since t0, shape (K,)."""

    parts: tuple[_Part, ...]
    times: Array

    @property
    def periods(self) -> int:
        """After how many periods P repeats itself."""
        return max(one.turns for one in self.parts)

    @property
    def closing(self) -> float:
        """How far P is from returning, relative."""
        return max(one.closing for one in self.parts)

    @property
    def R(self) -> Array:
        """R, real, shape (n, n)."""
        whole = sum(one.followed.bases[0] @ one.growth @ one.left for one in self.parts)
        return np.asarray(whole / self.times[-1], dtype=float)

    def factor(self, steps: Sequence[int]) -> Array:
        """Return P after so many steps since t0, ``periods`` times K at the most, shape (k, n, n).

        Raises
        ------
        NotComputableError
            where P leaves the range of numbers
        """
        found = np.array([sum(self._moved(one, step) for one in self.parts) for step in steps])
        if not np.isfinite(found).all():
            raise NotComputableError("the periodic factor P leaves the range of numbers")
        return found

    def _moved(self, part: _Part, step: int) -> Array:
        followed, K = part.followed, len(self.times)
        turn, k = divmod(step, K)
        share = self.times[k - 1] / self.times[-1] if k else 0.0
        before = np.linalg.matrix_power(expm(-part.log) @ followed.balanced, turn)
        with np.errstate(over="ignore", invalid="ignore"):
            size = np.exp(followed.s[k] - followed.mean * share)
            moved = size * followed.bases[k] @ followed.F[k] @ expm(-part.log * share) @ before @ part.left
        return np.asarray(moved, dtype=float)


def periods_of(factors: Sequence[Array], groups: Sequence[slice], errors: Array) -> tuple[int, ...]:
    """Return after how many periods, 1 or 2, the multipliers of each group have a real logarithm.

    Parameters
    ----------
    factors : C_1 … C_K, shape (n, n) each
    groups : of multipliers of like modulus
    errors : of the multipliers, the largest first, relative

    Raises
    ------
    NotComputableError
        where neither will do
    """
    found = []
    for one, group in zip(periodic_subspaces(factors, groups), groups, strict=True):
        angles = np.asarray(np.angle(np.linalg.eigvals(_followed(one).balanced)), dtype=float)
        margin = max(_NEAR_AXIS, _ERRORS * float(errors[group].max()))
        fit = [m for m in (1, 2) if _from_axis(m * angles) > m * margin]
        if not fit:
            raise NotComputableError(
                "neither the multipliers nor their squares keep clear of the negative real axis, where there "
                "is no real logarithm"
            )
        found.append(fit[0])
    return tuple(found)


def reduction(
    factors: Sequence[Array], times: Array, groups: Sequence[slice], turns: Sequence[int]
) -> Reduction:
    """Return the stationary equivalent of the system with transitions C_1 … C_K over a period.

    Parameters
    ----------
    factors : C_1 … C_K, shape (n, n) each
    times : of their ends since t0, the last one the period, shape (K,)
    groups, turns : of multipliers of like modulus, and after how many periods they have a real logarithm

    Raises
    ------
    NotComputableError
        where there is no real logarithm
    """
    subspaces = periodic_subspaces(factors, groups)
    left = np.linalg.inv(np.concatenate([one.bases[0] for one in subspaces], axis=1))
    parts = []
    for one, group, m in zip(subspaces, groups, turns, strict=True):
        followed = _followed(one)
        log = real_logarithm(np.linalg.matrix_power(followed.balanced, m)) / m
        parts.append(_Part(followed, log, left[group], m))
    return Reduction(tuple(parts), times)


def _from_axis(angles: Array) -> float:
    """Return the smallest angle from the negative real axis."""
    return float(np.abs(np.remainder(angles, 2 * np.pi) - np.pi).min())


def _followed(subspace: PeriodicSubspace) -> _Followed:
    F, s = [np.eye(subspace.steps.shape[1])], [0.0]
    for step in subspace.steps:
        after = step @ F[-1]
        size = float(np.linalg.norm(after, 2))
        F.append(after / size)
        s.append(s[-1] + float(np.log(size)))
    mean = float(np.linalg.slogdet(F[-1])[1]) / len(F[-1])
    bases = np.concatenate([subspace.bases, subspace.bases[:1]])
    return _Followed(bases, np.array(F), np.array(s), F[-1] * np.exp(-mean), mean + s[-1])
