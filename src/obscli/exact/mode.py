"""The functions that exponential polynomials are made of, and their products.

    t^j e^{σt} cos νt,   t^j e^{σt} sin νt

Products by the addition theorems. With τ = tan(θ/2), w = e^{iθ} and the coefficients of
(w − 1)^i (w + 1)^{2d−i} = Σ_m c_m w^{m+d}:

    τ^i/(1 + τ²)^d = (−1)^{i/2} (c_0 + 2 Σ_{m>0} c_m cos mθ)/4^d          for even i
                   = (−1)^{(i−1)/2} 2 Σ_{m>0} c_m sin mθ/4^d              for odd i
"""

from __future__ import annotations

from fractions import Fraction
from functools import lru_cache
from math import comb
from typing import Final, NamedTuple


_HALF: Final = Fraction(1, 2)


class Mode(NamedTuple):
    """The function t^power e^{σt} cos νt, or with sin νt.

    ``turns``: ν in halves of the rates of the base angles, the first that is not zero > 0; ``exponents``: σ
    in the rates of the base exponents.
    """

    turns: tuple[int, ...]
    exponents: tuple[int, ...]
    power: int
    sine: bool

    @property
    def place(self) -> tuple[object, ...]:
        """Where it stands among others: 1 first, slow before fast, cosine before sine."""
        size = sum(map(abs, self.turns)), sum(map(abs, self.exponents))
        return (*size, self.turns, self.exponents, self.power, self.sine)


@lru_cache(maxsize=65536)
def mode_product(a: Mode, b: Mode) -> tuple[tuple[Mode, Fraction], ...]:
    """Return the product of two modes as a sum of modes."""
    exponents = _plus(a.exponents, b.exponents, 1)
    sine = a.sine != b.sine
    found: dict[Mode, Fraction] = {}
    for sign in (1, -1):
        turns = _plus(a.turns, b.turns, sign)
        lead = next((turn for turn in turns if turn), 0)
        if sine and not lead:
            continue
        value = -_HALF if b.sine and (sign == 1) != sine else _HALF
        if lead < 0:
            turns = tuple(-turn for turn in turns)
            value = -value if sine else value
        mode = Mode(turns, exponents, a.power + b.power, sine)
        found[mode] = found.get(mode, Fraction(0)) + value
    return tuple((mode, value) for mode, value in found.items() if value)


def _plus(a: tuple[int, ...], b: tuple[int, ...], sign: int) -> tuple[int, ...]:
    return tuple(x + sign * y for x, y in zip(a, b, strict=True))


@lru_cache(maxsize=4096)
def harmonics(i: int, d: int) -> dict[int, Fraction]:
    """Return τ^i/(1 + τ²)^d, i ≤ 2d, by multiples of θ: of cosines for even i, of sines for odd i."""
    scale = Fraction(-1 if i // 2 % 2 else 1, 4**d)
    found = {}
    for m in range(d + 1):
        coefficient = sum(
            (-1) ** (i - k) * comb(i, k) * comb(2 * d - i, m + d - k)
            for k in range(max(0, m + i - d), min(i, m + d) + 1)
        )
        if coefficient:
            found[m] = scale * coefficient * (2 if m else 1)
    return found
