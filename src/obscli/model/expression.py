"""Expressions: the one form in which a coefficient travels between file, engines and report.

A node is frozen and compared by identity, so that shared subexpressions (a ``let`` used twice) stay
shared: every walk over an expression memoises by ``id`` and is linear in the number of distinct nodes.
The two interpreters (exact, numeric) live elsewhere and do not know each other.
"""

from __future__ import annotations

from collections.abc import Container, Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Final, TypeAlias


#: Functions of one argument that survive into an expression (``sqrt`` is a power, ``2^a`` is exp(a log 2)).
ELEMENTARY: Final = (
    "sin", "cos", "tan", "asin", "acos", "atan", "exp", "log",
    "sinh", "cosh", "tanh", "asinh", "acosh", "atanh",
)  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class Number:
    """An exact rational number."""

    value: Fraction


@dataclass(frozen=True, slots=True, eq=False)
class Pi:
    """The number π."""


@dataclass(frozen=True, slots=True, eq=False)
class Symbol:
    """A parameter, a function of time, the time itself; the ``System`` says which."""

    name: str


@dataclass(frozen=True, slots=True, eq=False)
class Derivative:
    """The time derivative of given order (≥ 1) of a function named in ``functions``."""

    name: str
    order: int


@dataclass(frozen=True, slots=True, eq=False)
class Sum:
    """Two or more terms added."""

    terms: tuple[Expression, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Product:
    """Two or more factors multiplied."""

    factors: tuple[Expression, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Power:
    """A base raised to a rational number (real branch, base ≥ 0 where the exponent is no integer)."""

    base: Expression
    exponent: Fraction


@dataclass(frozen=True, slots=True, eq=False)
class Apply:
    """An elementary function of one argument, named as in ``ELEMENTARY``."""

    function: str
    argument: Expression


Expression: TypeAlias = Number | Pi | Symbol | Derivative | Sum | Product | Power | Apply

#: Longer nested sums and products are kept nested, so that an expression stays linear in its sharing.
LONGEST_FLATTENED: Final = 32


class ExpressionTooLarge(Exception):  # noqa: N818
    """A derivative that grows beyond what any model needs."""


ZERO: Final = Number(Fraction(0))
ONE: Final = Number(Fraction(1))


def number(value: int | Fraction) -> Number:
    """Return the exact number as an expression."""
    return Number(Fraction(value))


def is_zero(node: Expression) -> bool:
    """Whether the node is the number 0 as written (no algebra is done)."""
    return isinstance(node, Number) and node.value == 0


def is_one(node: Expression) -> bool:
    """Whether the node is the number 1 as written (no algebra is done)."""
    return isinstance(node, Number) and node.value == 1


def _is_short(parts: tuple[Expression, ...]) -> bool:
    return len(parts) <= LONGEST_FLATTENED


def add(*terms: Expression) -> Expression:
    """Sum with short nested sums flattened and numbers gathered in front; no other algebra."""
    constant, rest = Fraction(0), list[Expression]()
    for term in terms:
        for part in term.terms if isinstance(term, Sum) and _is_short(term.terms) else (term,):
            if isinstance(part, Number):
                constant += part.value
            else:
                rest.append(part)
    if constant or not rest:
        rest.insert(0, Number(constant))
    return rest[0] if len(rest) == 1 else Sum(tuple(rest))


def multiply(*factors: Expression) -> Expression:
    """Product with short nested products flattened, numbers gathered in front, zero absorbing."""
    constant, rest = Fraction(1), list[Expression]()
    for factor in factors:
        for part in (
            factor.factors if isinstance(factor, Product) and _is_short(factor.factors) else (factor,)
        ):
            if isinstance(part, Number):
                constant *= part.value
            else:
                rest.append(part)
    if constant == 0:
        return ZERO
    if constant != 1 or not rest:
        rest.insert(0, Number(constant))
    return rest[0] if len(rest) == 1 else Product(tuple(rest))


def negate(node: Expression) -> Expression:
    """Return −node."""
    return multiply(Number(Fraction(-1)), node)


def power(base: Expression, exponent: Fraction | int) -> Expression:
    """Power with the trivial exponents removed; (√u)² is u, numbers to small integers are computed."""
    exponent = Fraction(exponent)
    if exponent == 0:
        return ONE
    if exponent == 1:
        return base
    if isinstance(base, Number) and exponent.denominator == 1 and (base.value or exponent > 0):
        if abs(exponent) <= 64:
            return Number(base.value**exponent.numerator)
    elif isinstance(base, Power) and exponent.denominator == 1:
        return power(base.base, base.exponent * exponent)
    return Power(base, exponent)


def divide(left: Expression, right: Expression) -> Expression:
    """Return left / right; a literal zero denominator stays as 0^(-1), to be reported by the reader."""
    return multiply(left, power(right, -1))


def children(node: Expression) -> tuple[Expression, ...]:
    """Return the direct subexpressions."""
    match node:
        case Sum(terms):
            return terms
        case Product(factors):
            return factors
        case Power(base):
            return (base,)
        case Apply(_, argument):
            return (argument,)
    return ()


def postorder(*roots: Expression, known: Container[int] = frozenset()) -> Iterator[Expression]:
    """Yield every distinct node once, those inside it first; skip what is known by its ``id``."""
    done: set[int] = set()
    stack = [(root, False) for root in reversed(roots)]
    while stack:
        node, ready = stack.pop()
        if id(node) in done or id(node) in known:
            continue
        if ready:
            done.add(id(node))
            yield node
        else:
            stack.append((node, True))
            stack.extend((part, False) for part in children(node))


def rebuild(node: Expression, parts: tuple[Expression, ...]) -> Expression:
    """Return the node with its direct subexpressions replaced."""
    match node:
        case Sum():
            return add(*parts)
        case Product():
            return multiply(*parts)
        case Power(_, exponent):
            return power(parts[0], exponent)
        case Apply(function):
            return Apply(function, parts[0])
    return node


def symbols(*roots: Expression) -> frozenset[str]:
    """Return the names of all symbols (and differentiated functions) in the expressions."""
    seen: set[int] = set()
    names: set[str] = set()
    stack = list(roots)
    while stack:
        node = stack.pop()
        if id(node) in seen:
            continue
        seen.add(id(node))
        if isinstance(node, Symbol | Derivative):
            names.add(node.name)
        stack.extend(children(node))
    return frozenset(names)


def derivative_of(function: str, u: Expression) -> Expression:  # noqa: C901, PLR0911, PLR0912
    """Return f'(u) of an elementary function."""
    square = power(u, 2)
    match function:
        case "sin":
            return Apply("cos", u)
        case "cos":
            return negate(Apply("sin", u))
        case "tan":
            return add(ONE, power(Apply("tan", u), 2))
        case "exp":
            return Apply("exp", u)
        case "log":
            return power(u, -1)
        case "asin":
            return power(add(ONE, negate(square)), Fraction(-1, 2))
        case "acos":
            return negate(power(add(ONE, negate(square)), Fraction(-1, 2)))
        case "atan":
            return power(add(ONE, square), -1)
        case "sinh":
            return Apply("cosh", u)
        case "cosh":
            return Apply("sinh", u)
        case "tanh":
            return add(ONE, negate(power(Apply("tanh", u), 2)))
        case "asinh":
            return power(add(square, ONE), Fraction(-1, 2))
        case "acosh":
            return power(add(square, number(-1)), Fraction(-1, 2))
        case "atanh":
            return power(add(ONE, negate(square)), -1)
    raise ValueError(function)


class TimeDerivative:
    """d/dt of expressions by the chain rule, memoised over shared nodes.

    Parameters
    ----------
    time : name of the time symbol
    rules : derivative of each function of time that has a rule (``derivative`` in the file)
    functions : names of the functions of time without a rule; they get a ``Derivative`` node
    most : how many distinct nodes may be derived, None: any number
    """

    def __init__(
        self,
        time: str,
        rules: Mapping[str, Expression],
        functions: frozenset[str],
        most: int | None = None,
    ) -> None:
        self._most = most
        self._time = time
        self._rules = rules
        self._functions = functions
        self._memo: dict[int, tuple[Expression, Expression]] = {}

    def __call__(self, node: Expression) -> Expression:
        """Return the time derivative of the expression."""
        for part in postorder(node, known=self._memo):
            if self._most is not None and len(self._memo) > self._most:
                raise ExpressionTooLarge("the time derivative grows beyond any model; derive fewer times")
            self._memo[id(part)] = (part, self._derive(part))
        return self._memo[id(node)][1]

    def _derive(self, node: Expression) -> Expression:
        match node:
            case Symbol(name):
                return self._symbol(name)
            case Derivative(name, order):
                return Derivative(name, order + 1)
            case Sum(terms):
                return add(*(self(term) for term in terms))
            case Product(factors):
                return add(
                    *(
                        multiply(self(factor), *factors[:k], *factors[k + 1 :])
                        for k, factor in enumerate(factors)
                    )
                )
            case Power(base, exponent):
                inner = self(base)
                return (
                    ZERO if is_zero(inner) else multiply(Number(exponent), power(base, exponent - 1), inner)
                )
            case Apply(function, argument):
                inner = self(argument)
                return ZERO if is_zero(inner) else multiply(inner, derivative_of(function, argument))
        return ZERO

    def _symbol(self, name: str) -> Expression:
        if name == self._time:
            return ONE
        if name in self._rules:
            return self._rules[name]
        return Derivative(name, 1) if name in self._functions else ZERO


def substitute(root: Expression, values: Mapping[str, Expression], derive: TimeDerivative) -> Expression:
    """Replace symbols by expressions; a derivative of a replaced function is derived by ``derive``."""
    memo: dict[int, Expression] = {}

    def replace(node: Expression) -> Expression:
        if isinstance(node, Symbol):
            return values.get(node.name, node)
        if isinstance(node, Derivative) and node.name in values:
            value = values[node.name]
            for _ in range(node.order):
                value = derive(value)
            return value
        parts = children(node)
        return rebuild(node, tuple(memo[id(part)] for part in parts)) if parts else node

    for node in postorder(root):
        memo[id(node)] = replace(node)
    return memo[id(root)]
