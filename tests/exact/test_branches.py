"""What is left open by an invariant, or contradicted by a fix, is not guessed."""

import pytest

from obscli.core.place import ModelError
from obscli.exact.analysis import analyze
from obscli.exact.finding import Analysis, Undecided
from obscli.model.reader import read_text


MODEL = "states: [x1, x2]\nA: [[0, 0], [0, 0]]\n"


def _analysis(text):
    return analyze(read_text(MODEL + text, "test.yaml").systems[0])


def test_a_root_that_an_invariant_leaves_open_is_undecided_where_it_stands_in_the_model():
    found = _analysis('functions: {f: {invariant: f^2 - 2}}\nH: [["f - sqrt(2)", 1]]\n')

    assert isinstance(found, Undecided)
    assert "sign of sqrt(2)" in found.reason


def test_it_is_decided_where_only_the_function_stands_in_the_model():
    found = _analysis("functions: {f: {invariant: f^2 - 2}}\nH: [[f, t]]\n")

    assert isinstance(found, Analysis)
    assert found.rank == 2


@pytest.mark.parametrize(("value", "rank"), [("exp(-t)", 2), ("0", 1), ("3*exp(-t)", 2)])
def test_a_function_is_fixed_to_a_value_that_satisfies_its_rule(value, rank):
    text = f"functions: {{f: {{derivative: -f}}}}\nH: [[f, t]]\nstages: {{a: {{fix: {{f: {value}}}}}}}\n"
    system = next(s for s in read_text(MODEL + text, "test.yaml").systems if s.stage == "a")

    assert analyze(system).rank == rank


def test_a_value_that_does_not_is_refused_or_undecided():
    text = "functions: {f: {derivative: -f}}\nH: [[f, t]]\nstages: {a: {fix: {f: VALUE}}}\n"
    with pytest.raises(ModelError, match="does not satisfy the derivative"):
        read_text(MODEL + text.replace("VALUE", "1"), "test.yaml")
    moving = read_text(MODEL + text.replace("VALUE", "t"), "test.yaml")

    assert isinstance(analyze(next(s for s in moving.systems if s.stage == "a")), Undecided)
