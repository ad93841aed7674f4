"""Short ways to build systems and to read expressions in them."""

import pytest

from obscli.exact.interpreter import Interpreter
from obscli.model.covector import parse_scalar
from obscli.model.reader import read_text


def _system(text):
    """Return the first system of a model text."""
    return read_text(text, "test.yaml").systems[0]


def _row(parameters, *entries, functions=()):
    """Return x' = 0, y = H x: one row of measurements, its entries the coefficients of x1, x2, ..."""
    states = [f"x{k}" for k in range(1, len(entries) + 1)]
    given = "\n".join(f"  {name}: {value or 'null'}" for name, value in parameters.items()) or "  unused: 1"
    row = "\n".join(f"    {s}: {e}" for s, e in zip(states, entries, strict=True))
    return _system(
        f"parameters:\n{given}\nfunctions: [{', '.join(functions)}]\nstates: [{', '.join(states)}]\n"
        f"A: zeros({len(states)}, {len(states)})\nH:\n  y:\n{row}\n"
    )


def _read(system, text):
    """Return the field element that a text stands for."""
    expression = parse_scalar(system, text, "test")
    return Interpreter(system, [expression]).read(expression)


@pytest.fixture(scope="session")
def system():
    return _system


@pytest.fixture(scope="session")
def row():
    return _row


@pytest.fixture(scope="session")
def read():
    return _read
