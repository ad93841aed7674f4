"""Singular values of a square root R of the Gramian in any units, and by how much they may be wrong.

    |ΔR v|² ≲ vᵀ E v,   e_i = v_iᵀ E v_i,   ρ_k² = Σ_{i ≤ k} e_i/σ_i²,   δ_k² = Σ_{i > k} e_i

    |Δσ_i| ≤ min over k of  ρ_k (σ_i + σ_{k+1}) + δ_k      (ρ_k < 1)

For R + ΔR is (I + F) R and a rest: F = ΔR V_k (R V_k)⁺, |F| ≤ ρ_k, moves every σ_i by no more than ρ_k σ_i
(Ostrowski), the rest, ΔR − F R along the other vectors, by no more than its norm (Weyl). So columns of very
different sizes cost nothing where R is sure of them. The decomposition is found in hundreds of bits: double
precision would lose all that is below σ_1 ε.

References
----------
J. Demmel, K. Veselić, Jacobi's method is more accurate than QR (1992). R. A. Horn, C. R. Johnson, Matrix
Analysis, 4.5.9.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from flint import arb, arb_mat, ctx

from obscli.exact.ball import precision
from obscli.measures.gram_spectrum import GramSpectrum, gram_spectrum
from obscli.numeric.program import Array


#: Bits in the order tried; squares below this power of two above their rounding are not used.
_PRECISIONS: Final = (400, 1500, 4000)
_SPARE: Final = 128


@dataclass(frozen=True, slots=True, eq=False)
class RootSpectrum:
    """Singular values, the largest first, as many as differ from zero.

    Parameters
    ----------
    squares : σ_i²
    wrong : bounds of |Δσ_i|/σ_i, 1 where nothing is known
    vectors : v_i of unit length
    """

    squares: tuple[arb, ...]
    wrong: tuple[float, ...]
    vectors: tuple[tuple[arb, ...], ...]


def root_spectrum(R: Array, E: Array, units: Array, rank: int) -> RootSpectrum:
    """Return the singular values of R D.

    Parameters
    ----------
    R, E : the root and its error, shape (n, n)
    units : D, shape (n,)
    rank : how many singular values of R D differ from zero
    """
    for bits in _PRECISIONS:
        with precision(bits, 1):
            root, error = _scaled(R, E, units)
            spectrum = gram_spectrum(root, _identity(len(R)))
            found = _of(spectrum, error, rank)
            if not R.any() or all(_is_told_apart(spectrum, i) for i in range(rank)):
                break
    return found


def _scaled(R: Array, E: Array, units: Array) -> tuple[arb_mat, arb_mat]:
    """Return R D and D E D."""
    n = len(R)
    D = arb_mat(n, n, [arb(float(units[i])) if i == j else 0 for i in range(n) for j in range(n)])
    root, error = (arb_mat(n, n, [arb(float(entry)) for entry in one.ravel()]) for one in (R, E))
    return (root * D).mid(), (D * error * D).mid()


def _identity(n: int) -> arb_mat:
    return arb_mat(n, n, [int(i == j) for i in range(n) for j in range(n)])


def _is_told_apart(spectrum: GramSpectrum, i: int) -> bool:
    return bool(spectrum.squares[i] > spectrum.squares[0] * arb(2) ** (_SPARE - ctx.prec))


def _of(spectrum: GramSpectrum, error: arb_mat, rank: int) -> RootSpectrum:
    vectors = [spectrum.right_vector(i) for i in range(error.nrows())]
    noise = [_noise(error, one) for one in vectors]
    wrong = _bounds([_size(one) for one in spectrum.squares], noise)
    known = [one if _is_told_apart(spectrum, i) else 1.0 for i, one in enumerate(wrong)]
    return RootSpectrum(spectrum.squares[:rank], tuple(known[:rank]), tuple(vectors[:rank]))


def _size(square: arb) -> arb:
    return square.sqrt().mid() if square > 0 else arb(0)


def _noise(error: arb_mat, vector: tuple[arb, ...]) -> arb:
    """Return e = vᵀ E v."""
    v = arb_mat([list(vector)])
    return (v * error * v.transpose())[0, 0].mid().max(0)


def _bounds(sizes: list[arb], noise: list[arb]) -> list[float]:
    """Return bounds of |Δσ_i|/σ_i, 1 at the most."""
    best = [arb(1)] * len(sizes)
    rho = arb(0)  # squared, as delta is
    for k in range(len(sizes) + 1):
        delta, following = sum(noise[k:], arb(0)), (*sizes, arb(0))[k]
        rest = rho.sqrt() * following + delta.sqrt()
        best = [
            bound.min(rho.sqrt() + rest / size) if size > 0 else bound
            for bound, size in zip(best, sizes, strict=True)
        ]
        if k == len(sizes) or not sizes[k] > 0:
            break
        rho = (rho + noise[k] / sizes[k] ** 2).mid()
        if not rho < 1:
            break
    return [float(one) for one in best]
