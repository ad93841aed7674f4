"""Expressions in floating point, by rules of their own: a witness independent of both engines."""

import math
from pathlib import Path

import pytest

from obscli.model.expression import Apply, Derivative, Number, Pi, Power, Product, Sum, Symbol
from obscli.model.reader import read_text


ERRORS = Path(__file__).parents[1] / "errors"


def evaluate(node, values):
    match node:
        case Number(value):
            return float(value)
        case Pi():
            return math.pi
        case Symbol(name):
            return values[name]
        case Derivative(name, order):
            return values[name, order]
        case Sum(terms):
            return math.fsum(evaluate(term, values) for term in terms)
        case Product(factors):
            return math.prod(evaluate(factor, values) for factor in factors)
        case Power(base, exponent):
            return evaluate(base, values) ** (int(exponent) if exponent.denominator == 1 else float(exponent))
        case Apply(function, argument):
            return getattr(math, function)(evaluate(argument, values))
    raise TypeError(node)


@pytest.fixture(scope="session")
def number():
    """Return the evaluator: (expression, values by name) → float."""
    return evaluate


@pytest.fixture(scope="session")
def scalar():
    """Return a reader of one expression of t, a, b, c, f, g."""

    def read(text):
        lines = (
            "parameters: {a: , b: , c: }",
            "functions: [f, g]",
            "states: [x]",
            f"A: [[{quoted(text)}]]",
            "H: [[1]]",
        )
        system = read_text("\n".join(lines), "text").systems[0]
        return system.A.entries.get((0, 0), Number(0))

    return read


def quoted(text):
    return "'" + text.replace("'", "''") + "'"


@pytest.fixture(scope="session")
def dense(number):
    """Return a matrix in floating point: (Matrix, values) → list of rows."""

    def rows(matrix, values):
        return [
            [
                number(matrix.entries[i, j], values) if (i, j) in matrix.entries else 0.0
                for j in range(matrix.columns)
            ]
            for i in range(matrix.rows)
        ]

    return rows
