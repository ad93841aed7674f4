"""Rotations and quaternions: active, right-handed; quaternions scalar first, body to navigation axes.

rotz(a) = [[cos a, -sin a, 0], [sin a, cos a, 0], [0, 0, 1]]
q' = ½ omega4(w) q, with w the angular rate in body axes
"""

from __future__ import annotations

from fractions import Fraction
from typing import Final

from obscli.model.expression import Number
from obscli.model.form import ONE_FORM, ZERO_FORM, Form, applied, opposite, product, total
from obscli.model.tensor import Tensor


_TWO: Final = Form(Number(Fraction(2)))


def rotation(axis: int, angle: Form) -> Tensor:
    """Return the rotation by the angle about axis 0, 1 or 2."""
    c, s = applied("cos", angle), applied("sin", angle)
    entries = [ZERO_FORM] * 9
    i, j = (axis + 1) % 3, (axis + 2) % 3
    entries[4 * axis] = ONE_FORM
    entries[4 * i] = entries[4 * j] = c
    entries[3 * i + j], entries[3 * j + i] = opposite(s), s
    return Tensor((3, 3), tuple(entries))


def skew(v: tuple[Form, ...]) -> Tensor:
    """Return the matrix of the cross product: skew(v) @ x = cross(v, x)."""
    x, y, z = v
    o = ZERO_FORM
    return Tensor((3, 3), (o, opposite(z), y, z, o, opposite(x), opposite(y), x, o))


def cross(a: tuple[Form, ...], b: tuple[Form, ...]) -> tuple[Form, ...]:
    """Return a × b."""
    return tuple(
        total((product(a[i], b[j]), opposite(product(a[j], b[i])))) for i, j in ((1, 2), (2, 0), (0, 1))
    )


def quat_matrix(q: tuple[Form, ...]) -> Tensor:
    """Return the rotation matrix of the unit quaternion q = (q0, q1, q2, q3), body to navigation."""
    square = [product(part, part) for part in q]

    def diagonal(plus: int) -> Form:
        rest = [opposite(square[k]) for k in (1, 2, 3) if k != plus]
        return total((square[0], square[plus], *rest))

    def twice(i: int, j: int, k: int, sign: int) -> Form:
        last = product(q[0], q[k])
        return product(_TWO, total((product(q[i], q[j]), last if sign > 0 else opposite(last))))

    entries = (
        diagonal(1), twice(1, 2, 3, -1), twice(1, 3, 2, 1),
        twice(1, 2, 3, 1), diagonal(2), twice(2, 3, 1, -1),
        twice(1, 3, 2, -1), twice(2, 3, 1, 1), diagonal(3),
    )  # fmt: skip
    return Tensor((3, 3), entries)


def omega4(w: tuple[Form, ...]) -> Tensor:
    """Return Ω(w) of the quaternion kinematics q' = ½ Ω(w) q."""
    x, y, z = w
    a, b, c, o = opposite(x), opposite(y), opposite(z), ZERO_FORM
    return Tensor((4, 4), (o, a, b, c, x, o, z, b, y, c, o, x, z, y, a, o))
