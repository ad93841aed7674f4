"""The functions a file may call: the reserved names, what they take, what they give."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from typing import Final, TypeAlias

from obscli.model.expression import ELEMENTARY, Number
from obscli.model.form import ZERO_FORM, Form, Impossible, applied, exponential, value_of
from obscli.model.rotations import cross, omega4, quat_matrix, rotation, skew
from obscli.model.tensor import Tensor, identity, inner, matrix, named, scalar, transpose, vector


Arguments: TypeAlias = tuple[Tensor, ...]
_HALF: Final = Form(Number(Fraction(1, 2)))


def _count(arguments: Arguments, wanted: int, usage: str) -> None:
    if len(arguments) != wanted:
        found = f"{len(arguments)} argument" + ("s" if len(arguments) != 1 else "")
        raise Impossible(f"{found} given; it is written {usage}")


def _scalar(arguments: Arguments, usage: str) -> Form:
    _count(arguments, 1, usage)
    if not arguments[0].is_scalar:
        raise Impossible(f"{usage} takes a scalar, not {named(arguments[0].shape)}")
    return arguments[0].entries[0]


def _vector(value: Tensor, size: int, usage: str) -> tuple[Form, ...]:
    if value.shape not in {(size,), (1, size), (size, 1)}:
        raise Impossible(f"{usage} takes a vector of {size}, not {named(value.shape)}")
    return value.entries


def _whole(value: Tensor, usage: str) -> int:
    constant = value.entries[0].constant
    plain = value.is_scalar and not value.entries[0].linear and isinstance(constant, Number)
    if not plain or constant.value.denominator != 1 or not 1 <= constant.value <= 1000:  # type: ignore[union-attr]
        raise Impossible(f"{usage} takes whole numbers from 1 to 1000")
    return int(constant.value)  # type: ignore[union-attr]


def _elementary(name: str) -> Callable[[Arguments], Tensor]:
    return lambda arguments: scalar(applied(name, _scalar(arguments, f"{name}(x)")))


def _rotation(axis: int) -> Callable[[Arguments], Tensor]:
    return lambda arguments: rotation(axis, _scalar(arguments, f"rot{'xyz'[axis]}(a)"))


def _sqrt(arguments: Arguments) -> Tensor:
    return scalar(exponential(_scalar(arguments, "sqrt(x)"), _HALF))


def _cross(arguments: Arguments) -> Tensor:
    _count(arguments, 2, "cross(a, b)")
    a, b = (_vector(value, 3, "cross(a, b)") for value in arguments)
    return vector(cross(a, b))


def _skew(arguments: Arguments) -> Tensor:
    _count(arguments, 1, "skew(v)")
    return skew(_vector(arguments[0], 3, "skew(v)"))


def _dot(arguments: Arguments) -> Tensor:
    _count(arguments, 2, "dot(a, b)")
    a, b = arguments
    if len(a.entries) != len(b.entries):
        raise Impossible(f"dot(a, b) takes vectors of one size, not {named(a.shape)} and {named(b.shape)}")
    return scalar(inner(a.entries, b.entries))


def _norm(arguments: Arguments) -> Tensor:
    _count(arguments, 1, "norm(v)")
    for entry in arguments[0].entries:
        value_of(entry, "inside norm")
    return scalar(exponential(inner(arguments[0].entries, arguments[0].entries), _HALF))


def _transpose(arguments: Arguments) -> Tensor:
    _count(arguments, 1, "transpose(M)")
    return transpose(arguments[0])


def _eye(arguments: Arguments) -> Tensor:
    _count(arguments, 1, "eye(n)")
    return identity(_whole(arguments[0], "eye(n)"))


def _zeros(arguments: Arguments) -> Tensor:
    if len(arguments) == 1:
        return vector((ZERO_FORM,) * _whole(arguments[0], "zeros(n)"))
    _count(arguments, 2, "zeros(m, n)")
    m, n = (_whole(value, "zeros(m, n)") for value in arguments)
    return matrix(m, n, lambda _i, _j: ZERO_FORM)


def _diag(arguments: Arguments) -> Tensor:
    if any(len(value.shape) > 1 for value in arguments) or not arguments:
        raise Impossible("diag takes scalars or a vector")
    entries = [entry for value in arguments for entry in value.entries]
    n = len(entries)
    return matrix(n, n, lambda i, j: entries[i] if i == j else ZERO_FORM)


def _quat_matrix(arguments: Arguments) -> Tensor:
    _count(arguments, 1, "quat_matrix(q)")
    return quat_matrix(_vector(arguments[0], 4, "quat_matrix(q)"))


def _omega4(arguments: Arguments) -> Tensor:
    _count(arguments, 1, "omega4(w)")
    return omega4(_vector(arguments[0], 3, "omega4(w)"))


#: Every function but ``deriv`` and ``block``, which need more than the values of their arguments.
CATALOGUE: Final[dict[str, Callable[[Arguments], Tensor]]] = {
    **{name: _elementary(name) for name in ELEMENTARY},
    "sqrt": _sqrt,
    "cross": _cross,
    "skew": _skew,
    "dot": _dot,
    "norm": _norm,
    "transpose": _transpose,
    "eye": _eye,
    "zeros": _zeros,
    "diag": _diag,
    "rotx": _rotation(0),
    "roty": _rotation(1),
    "rotz": _rotation(2),
    "quat_matrix": _quat_matrix,
    "omega4": _omega4,
}

RESERVED: Final = frozenset({*CATALOGUE, "block", "deriv", "pi"})

#: Functions that are not analytic, and what to do instead.
NOT_ANALYTIC: Final = {
    "abs": "write sqrt(x^2) only if x never changes sign; else drop the sign into the states",
    "sign": "make the two signs two stages",
    "sgn": "make the two signs two stages",
    **dict.fromkeys(
        ("piecewise", "heaviside", "step", "if", "where", "ifelse"), "make the pieces stages of their own"
    ),
    **dict.fromkeys(
        ("floor", "ceil", "round", "mod", "frac", "trunc"), "use a smooth function of time, or stages"
    ),
    **dict.fromkeys(
        ("max", "min", "clip", "sat"), "make the cases stages, or use a smooth saturation as tanh"
    ),
    "atan2": "write atan(y/x) where x keeps its sign",
}
