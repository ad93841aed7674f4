"""The exact interpreter: expressions to elements of a differential field that grows as needed.

Reading an expression may call for a generator that the field lacks (a new angle, a new root). The field
is then built again with it and reading starts over; fields are small, so this is cheap, and every field
in use is complete and fixed. Functions with an ``invariant`` become algebraic generators first.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import replace
from fractions import Fraction
from typing import TYPE_CHECKING

from obscli.exact.angles import exponential, hyperbolic, trigonometric
from obscli.exact.errors import JetOverflowError, UndecidedError
from obscli.exact.field import Element, Field, Generator
from obscli.exact.invariants import largest_root, require_one_branch, without_square_root
from obscli.exact.missing import MissingError, RefineError
from obscli.exact.polynomial import factored, polynomial_coefficients
from obscli.exact.primitives import primitive
from obscli.exact.roots import rational_power
from obscli.model.expression import (
    Apply,
    Derivative,
    Expression,
    Number,
    Pi,
    Power,
    Product,
    Sum,
    Symbol,
    add,
    divide,
    multiply,
    negate,
    number,
    postorder,
    power,
    symbols,
)
from obscli.model.notation import to_text


if TYPE_CHECKING:
    from obscli.exact.polynomial import Polynomial
    from obscli.model.system import System

#: More roots, or roots, angles, exponentials and primitives together, are not tried.
MOST_ROOTS = 12
MOST_ADJOINED = 100

_TRIGONOMETRIC = frozenset({"sin", "cos", "tan"})
_HYPERBOLIC = frozenset({"sinh", "cosh", "tanh"})


class Interpreter:
    """Reads the expressions of one system as elements of one differential field.

    Parameters
    ----------
    system : the system whose names (time, parameters, functions) the expressions use
    roots : all expressions that will be read; the field is built to hold them
    jets : how many derivatives of each unspecified function the field holds

    Raises
    ------
    UndecidedError : zero cannot be decided (a root's sign, an unsupported invariant)
    UndefinedError : a denominator is identically zero
    """

    def __init__(self, system: System, roots: Iterable[Expression], jets: int = 4) -> None:
        self.system = system
        self.jets = jets
        self.rules = {f.name: f.derivative for f in system.functions if f.derivative is not None}
        self.fineness: dict[str, Fraction] = {}
        #: atoms with multiples too far apart for one base angle or exponential: related, but not in the field
        self.kept_apart: set[str] = set()
        self.definitions: dict[str, Expression] = {}
        self._meanings: dict[str, Expression] = {}
        self._adjoined: list[Generator] = []
        self._roots = [*roots, *self.rules.values()]
        #: the names that occur in what the interpreter reads, rules and relations included
        self.names = self._reachable_names()
        self._rebuild()
        for invariant in system.invariants:
            if symbols(invariant.expression) & self.names:
                self._impose(invariant.expression)
        self._read_all(self._roots)
        require_one_branch(self, self._roots, [name for name in self._meanings if name in self.field.index])

    # -- building

    def _reachable_names(self) -> frozenset[str]:
        used = symbols(*self._roots)
        for invariant in self.system.invariants:
            if symbols(invariant.expression) & used:
                used |= symbols(invariant.expression)
        return used

    def _rebuild(self) -> None:
        self._memo: dict[int, tuple[Expression, Element]] = {}
        self._applied: dict[tuple[str, str, str], Element] = {}
        self.field = Field([*self._base_generators(), *self._adjoined], self._derivation)
        self.logarithms: list[tuple[str, Element]] = []
        for generator in self._adjoined:
            if generator.kind == "root":
                self.field.set_relation(generator.name, self._relation(generator))
            elif generator.function == "log" and generator.argument is not None:
                self.logarithms.append((generator.name, self.read(generator.argument)))

    def _base_generators(self) -> list[Generator]:
        time = self.system.time
        generators = [Generator(time, "time", Symbol(time))] if time in self.names else []
        generators += [
            Generator(p.name, "parameter", Symbol(p.name), positive=p.assume == "positive")
            for p in self.system.parameters
            if p.name in self.names
        ]
        for f in self.system.functions:
            if f.name not in self.names or f.name in self.definitions:
                continue
            if f.derivative is not None:
                generators.append(Generator(f.name, "function", Symbol(f.name)))
                continue
            for order in range(self.jets + 1):
                meaning = Derivative(f.name, order) if order else Symbol(f.name)
                generators.append(
                    Generator(_jet(f.name, order), "jet", meaning, function=f.name, order=order)
                )
        return generators

    def _relation(self, generator: Generator) -> Polynomial:
        g = self.field.ctx.gen(self.field.index[generator.name])
        relation = g**generator.order
        for k, coefficient in enumerate(generator.relation):
            element = self.read(coefficient)
            if not element.den.is_one():
                raise UndecidedError(f"the root {generator.name} has a denominator in its relation")
            relation = relation - element.num * g**k
        return relation

    def _read_all(self, roots: Sequence[Expression]) -> None:
        functions = [node for node in postorder(*roots) if isinstance(node, Apply | Power)]
        for batch in (functions, roots):
            self._read_batch(batch)

    def _read_batch(self, batch: Sequence[Expression]) -> None:
        while True:
            try:
                for node in batch:
                    self.read(node)
                self._derive_generators()
            except MissingError as missing:
                generator = missing.generator
                meaning = self._meanings.get(generator.name, generator.meaning)
                self._adjoined.append(replace(generator, meaning=meaning))
                self._require_few_generators()
            except RefineError as refine:
                self.fineness[refine.atom] = refine.step
                self._adjoined.clear()
            else:
                return
            self._rebuild()

    def _require_few_generators(self) -> None:
        roots = sum(generator.kind == "root" for generator in self._adjoined)
        if roots > MOST_ROOTS or len(self._adjoined) > MOST_ADJOINED:
            raise UndecidedError(
                f"more than {MOST_ROOTS} independent roots, or {MOST_ADJOINED} independent angles, "
                "exponentials and logarithms, are too many for exact algebra"
            )

    def _derive_generators(self) -> None:
        """Derive every generator once, so that whatever its derivative needs is adjoined as well."""
        for k, generator in enumerate(self.field.generators):
            if generator.kind != "jet":
                with suppress(JetOverflowError):
                    self.field.derivative(k)

    def _impose(self, relation: Expression) -> None:
        """Make one function algebraic over the others, by a relation ``relation`` = 0."""
        relation = without_square_root(relation)
        self._read_batch([node for node in postorder(relation) if isinstance(node, Apply | Power)])
        numerator = self._one_factor(relation)
        if numerator is None:
            return
        name = self._function_to_solve(numerator)
        parts = [self.expression(c) for c in polynomial_coefficients(numerator, self.field.index[name])]
        self.definitions[name] = largest_root(parts)
        self._rebuild()
        self._read_batch(list(postorder(self.definitions[name])))
        self._name_root(name)
        self._check_invariant_rule(name)

    def _name_root(self, name: str) -> None:
        """Print the root ρ in f = (u + v ρ)/w as (w f - u)/v, so that results speak of f."""
        element = self.read(self.definitions[name])
        roots = [
            k
            for k, d in enumerate(element.num.degrees())
            if d > 0 and self.field.generators[k].kind == "root"
        ]
        if not roots:
            return
        u, v = (self.expression(c) for c in polynomial_coefficients(element.num, roots[0])[:2])
        f = multiply(self.expression(element.den), Symbol(name))
        self._meanings[self.field.generators[roots[0]].name] = divide(add(f, negate(u)), v)
        self._adjoined.clear()
        self._rebuild()

    def _one_factor(self, relation: Expression) -> Polynomial | None:
        """Return the factor of a relation that contains functions; f g = 0 leaves open which one vanishes."""
        numerator = self.read(relation).num
        if numerator.is_zero():
            return None
        indices = [k for k, g in enumerate(self.field.generators) if g.kind in {"jet", "function"}]
        factors = [p for p, _ in factored(numerator)[1] if any(p.degrees()[k] > 0 for k in indices)]
        if len(factors) > 1:
            raise UndecidedError(
                f"the invariant {to_text(relation)} is a product; state the factor that vanishes"
            )
        return factors[0] if factors else numerator

    def _function_to_solve(self, numerator: Polynomial) -> str:
        """Return the function to solve for: linear before quadratic, without a rule before with one, last."""
        degrees = numerator.degrees()
        candidates = [
            (degrees[index], f.derivative is not None, f.name)
            for f in reversed(self.system.functions)
            if (index := self.field.index.get(f.name)) is not None and degrees[index] in (1, 2)
        ]
        if not candidates:
            raise UndecidedError(
                "a relation (an invariant, or the rule of a function that is fixed) can be used "
                "only if it is linear or quadratic in some function"
            )
        return min(candidates, key=lambda candidate: candidate[:2])[2]

    def _check_invariant_rule(self, name: str) -> None:
        rule = self.rules.get(name)
        if rule is None:
            return
        self._read_batch([rule, Symbol(name)])
        if self.field.derive(self.read(Symbol(name))) != self.read(rule):
            raise UndecidedError(f"the invariant of {name} is not preserved by the derivative given for it")

    # -- derivation

    def _derivation(self, generator: Generator) -> Element:
        field = self.field
        match generator.kind:
            case "time":
                return field.one
            case "parameter" | "pi":
                return field.zero
            case "jet":
                if generator.order >= self.jets:
                    raise JetOverflowError(generator.function)
                return field.generator(_jet(generator.function, generator.order + 1))
            case "function":
                return self.read(self.rules[generator.name])
            case "root":
                return self._derive_root(generator)
        assert generator.argument is not None
        inner = field.derive(self.read(generator.argument))
        if generator.kind == "angle":
            tangent = field.generator(generator.name)
            return inner * (field.one + tangent * tangent) * field.rational(Fraction(1, 2))
        if generator.kind == "exponential":
            return inner * field.generator(generator.name)
        return inner * self.read(generator.relation[0])

    def _derive_root(self, generator: Generator) -> Element:
        """g' = Σ r_k' g^k / (d g^(d-1) - Σ k r_k g^(k-1))  from  g^d = Σ r_k g^k."""
        field = self.field
        g = field.generator(generator.name)
        above, below = field.zero, field.rational(generator.order) * g ** (generator.order - 1)
        for k, coefficient in enumerate(generator.relation):
            element = self.read(coefficient)
            above = above + field.derive(element) * g**k
            if k:
                below = below - field.rational(k) * element * g ** (k - 1)
        return above / below if above else field.zero

    # -- reading

    def read(self, node: Expression) -> Element:
        """Return the element that an expression stands for."""
        known = self._memo.get(id(node))
        if known is None:
            known = self._memo[id(node)] = (node, self._read(node))
        return known[1]

    def _read(self, node: Expression) -> Element:
        match node:
            case Number(value):
                return self.field.rational(value)
            case Pi():
                return self.constant_pi()
            case Symbol(name):
                return self._symbol(name)
            case Derivative(name, order):
                return self._derivative(name, order)
            case Sum(terms):
                return sum((self.read(term) for term in terms[1:]), self.read(terms[0]))
            case Product(factors):
                result = self.read(factors[0])
                for factor in factors[1:]:
                    result = result * self.read(factor)
                return result
            case Power(base, exponent):
                if exponent.denominator == 1:
                    return self.read(base) ** exponent.numerator
                return self.power(self.read(base), exponent)
        argument = self.read(node.argument)
        key = (node.function, str(argument.num), str(argument.den))
        if key not in self._applied:
            self._applied[key] = self._apply(node.function, argument)
        return self._applied[key]

    def _symbol(self, name: str) -> Element:
        if name in self.definitions:
            return self.read(self.definitions[name])
        if name not in self.field.index:
            raise UndecidedError(f"unknown name {name!r}")
        return self.field.generator(name)

    def _derivative(self, name: str, order: int) -> Element:
        if _jet(name, 1) in self.field.index or (self.jets == 0 and name in self.field.index):
            if order > self.jets:
                raise JetOverflowError(name)
            return self.field.generator(_jet(name, order))
        element = self._symbol(name)
        for _ in range(order):
            element = self.field.derive(element)
        return element

    def _apply(self, function: str, argument: Element) -> Element:
        if function in _TRIGONOMETRIC:
            return trigonometric(self, function, argument)
        if function == "exp":
            return exponential(self, argument)
        if function in _HYPERBOLIC:
            return hyperbolic(self, function, argument)
        return primitive(self, function, argument)

    def power(self, base: Element, exponent: Fraction) -> Element:
        """Return a rational power of an element."""
        if exponent.denominator == 1:
            return base**exponent.numerator
        return rational_power(self, base, exponent)

    def exponential(self, argument: Element) -> Element:
        """Return exp of an element."""
        return exponential(self, argument)

    def constant_pi(self) -> Element:
        """Return π, a transcendental constant."""
        if "pi" not in self.field.index:
            raise MissingError(Generator("pi", "pi", Pi(), positive=True, numeric=True))
        return self.field.generator("pi")

    # -- back to expressions, without trigonometric restoration

    def expression(self, polynomial: Polynomial) -> Expression:
        """Return a polynomial as an expression in the meanings of the generators."""
        generators = self.field.generators
        written = sorted(range(len(generators)), key=lambda k: (generators[k].writing_order, k))
        return add(
            *(
                multiply(
                    number(int(coefficient)),
                    *(power(generators[k].meaning, int(exponents[k])) for k in written if exponents[k]),
                )
                for exponents, coefficient in polynomial.terms()
            )
        )

    def element_expression(self, element: Element) -> Expression:
        """Return an element as an expression in the meanings of the generators."""
        return divide(self.expression(element.num), self.expression(element.den))

    def is_numeric(self, element: Element) -> bool:
        """Whether an element is a number: free of time, parameters and functions."""
        degrees = [max(a, b) for a, b in zip(element.num.degrees(), element.den.degrees(), strict=True)]
        return all(self.field.generators[k].numeric for k, degree in enumerate(degrees) if degree > 0)


def _jet(name: str, order: int) -> str:
    return name + "'" * order
