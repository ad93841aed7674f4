"""A system frozen at an instant: its coefficients are those of that instant, and nothing moves any more."""

import random
from pathlib import Path

import pytest

from obscli.core.place import ModelError
from obscli.model.covector import parse_scalar
from obscli.model.expression import Symbol, number, symbols
from obscli.model.frozen import frozen_at
from obscli.model.notation import to_text
from obscli.model.reader import load, read_text


MODELS = sorted((Path(__file__).parents[2] / "models").glob("**/*.yaml"))


def system(*lines):
    return read_text("\n".join(lines), "model.yaml").systems[0]


def texts(matrix):
    return {place: to_text(entry) for place, entry in matrix.entries.items()}


def moves(one):
    entries = [entry for matrix in (one.A, one.H) for entry in matrix.entries.values()]
    return bool(symbols(*entries) & {one.time, *(f.name for f in one.functions)})


@pytest.mark.parametrize("file", MODELS, ids=[f.stem for f in MODELS])
def test_a_time_invariant_system_is_itself(file):
    for one in load(file).systems:
        frozen = frozen_at(one, number(7))
        assert one.time not in symbols(*frozen.A.entries.values(), *frozen.H.entries.values())
        if not moves(one):
            assert texts(frozen.A) == texts(one.A)
            assert texts(frozen.H) == texts(one.H)


@pytest.mark.parametrize("seed", range(10))
def test_coefficients_are_those_of_the_instant(seed, dense):
    source = random.Random(seed)
    entries = ["sin(a*t)", "exp(-t/3)*t", "1/(2 + t^2)", "sqrt(1 + t)*a", "t^3 - a", "log(4 + cos(t))"]
    A = [[source.choice(entries) for _ in range(3)] for _ in range(3)]
    one = system("states: [x, y, z]", "parameters: {a: 2}", f"A: {A}", f"H: [{A[0]}]")
    instant = source.choice([0, 1, 3])
    frozen = frozen_at(one, number(instant))
    moving = {"a": 0.7, "t": float(instant)}
    for found, expected in ((frozen.A, one.A), (frozen.H, one.H)):
        for row, other in zip(dense(found, {"a": 0.7}), dense(expected, moving), strict=True):
            assert row == pytest.approx(other)


def test_values_are_exact_where_they_are_known():
    one = system("states: [x, y]", "A: [[cos(t), sin(pi*t)], [t, exp(t)]]", "H: [[1 + t, sqrt(t + 4)]]")
    frozen = frozen_at(one, number(0))
    assert texts(frozen.A) == {(0, 0): "1", (1, 1): "1"}
    assert texts(frozen.H) == {(0, 0): "1", (0, 1): "2"}


def test_functions_and_their_derivatives_are_constants():
    one = system(
        "functions: {f: {}, q: {shape: 2, derivative: '[q2, -q1]', invariant: norm(q)^2 - 1}, g: {invariant: g - 2*f}}",
        "parameters: {deriv_f: 3}",
        "states: [x, y]",
        "A: [[deriv(f), deriv(deriv(g))], [q1, deriv(q1)]]",
        "H: [[f, deriv_f]]",
    )
    frozen = frozen_at(one, Symbol("deriv_f"))
    assert texts(frozen.A) == {(0, 0): "deriv_f_", (0, 1): "deriv2_g", (1, 0): "q1", (1, 1): "q2"}
    assert [(f.name, to_text(f.derivative)) for f in frozen.functions] == [
        (name, "0") for name in ("f", "q1", "q2", "g", "deriv_f_", "deriv2_g", "deriv_g", "deriv2_f")
    ]
    relations = [to_text(i.expression) for i in frozen.invariants]
    assert relations == ["q1**2 + q2**2 - 1", "g - 2*f", "deriv_g - 2*deriv_f_", "deriv2_g - 2*deriv2_f"]
    assert to_text(parse_scalar(frozen, "deriv2_g + t*q1", "text")) == "deriv2_g + deriv_f*q1"
    assert to_text(parse_scalar(frozen, "deriv(f)", "text")) == "0"


def test_what_does_not_exist_at_the_instant_is_named():
    one = system("states: [x]", "let: {k: log(t - 2), j: 3}", "A: [[1/(t - 1)]]", "H: [[t/(t - 1)]]")
    with pytest.raises(
        ModelError, match="a coefficient of A does not exist at t = 1: division by zero"
    ) as caught:
        frozen_at(one, number(1))
    assert [problem.place.line for problem in caught.value.problems] == [3, 4]
    frozen = frozen_at(one, number(2))
    assert texts(frozen.A) == {(0, 0): "1"}
    with pytest.raises(ModelError, match="'k' does not exist at t = 2"):
        parse_scalar(frozen, "k", "text")


@pytest.mark.parametrize("instant", ["t", "f", "2*f + 1"])
def test_an_instant_does_not_move(instant):
    one = system("functions: [f]", "states: [x]", "A: [[f]]", "H: [[1]]")
    with pytest.raises(ValueError, match="an instant is constant"):
        frozen_at(one, parse_scalar(one, instant, "text"))
