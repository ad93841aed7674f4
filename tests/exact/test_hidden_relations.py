"""Relations that the field does not know of: never a false claim, of completeness, of a basis, of a rank."""

import pytest

from obscli.checks.claims import check_claims
from obscli.exact.analysis import Options, analyze
from obscli.exact.finding import Analysis, Undecided
from obscli.model.covector import parse_covector


def _conditions(analysis):
    return {v.condition: v.rank for v in analysis.critical.values if v.kind == "confirmed"}


@pytest.mark.parametrize(
    ("entries", "condition"),
    [
        (("sin(p)", "p"), "p = 0"),
        (("exp(p) - 1", "p"), "p = 0"),
        (("log(p)", "p - 1"), "p = 1"),
        (("sin(p*q)", "sin(q)"), "q = 0"),
        (("sin(p*q)",), "p = 0"),
        (("cos(p)", "2*p - pi"), "p = pi/2"),
    ],
)
def test_constants_without_a_parameter_of_their_own_leave_the_search_open(row, entries, condition):
    found = analyze(row({"p": "", "q": ""}, *entries))
    assert _conditions(found)[condition] == 0
    assert not found.critical.complete
    assert any("related in another way" in text for text in found.critical.not_searched)


@pytest.mark.parametrize("entries", [("sin(p)", "q"), ("cos(p*pi/180)", "exp(q)")])
def test_constants_with_a_parameter_of_their_own_do_not(row, entries):
    assert analyze(row({"p": "", "q": ""}, *entries)).critical.complete


@pytest.mark.parametrize(
    ("entries", "condition"),
    [
        (("log(t^3 + p)", "log(t)"), "p = 0"),
        (("log(t + p)", "log(t + q)"), "q = p"),
        (("atan(p*t)", "atan(q*t)"), "q = p"),
    ],
)
def test_logarithms_depend_on_each_other_where_their_arguments_share_a_factor(row, entries, condition):
    found = analyze(row({"p": "", "q": ""}, *entries))
    assert _conditions(found)[condition] == 1
    assert found.critical.complete


def test_harmonics_kept_apart_leave_the_search_open(row):
    """At p = 2 the first entry vanishes; the field has no relation between 66 t and 33 t beside t."""
    entry = "(sin(66*t) - p*sin(33*t)*cos(33*t))*sin(t)"
    assert not analyze(row({"p": ""}, entry, "cos(t)")).critical.complete


def test_a_basis_whose_rows_depend_in_secret_is_not_said_to_hold(system):
    text = "states: [x, y]\nA: zeros(2, 2)\nH: [[1, 0], [0, 1]]\n"
    one = system(text + "claims: [{basis: ['pi/4*x + y', '(atan(1/2) + atan(1/3))*x + y']}]\n")
    verdicts = [result.verdict for result in check_claims(one, analyze(one))]
    assert verdicts == ["undecided"]
    rows = tuple(parse_covector(one, f"{c}*x + y", "row") for c in ("pi/4", "(atan(1/2) + atan(1/3))"))
    assert isinstance(analyze(one, Options(basis=rows)), Undecided)


def test_an_invariant_that_is_a_product_leaves_open_which_factor_vanishes(system):
    text = "functions: {f: {invariant: f*g}, g: {}}\nstates: [x, y]\nA: zeros(2, 2)\nH: [[f, g]]\n"
    found = analyze(system(text))
    assert isinstance(found, Undecided)
    assert "is a product" in found.reason


def test_high_derivatives_in_the_model_are_read(system):
    high = "deriv(" * 7 + "f" + ")" * 7
    found = analyze(system(f"functions: [f]\nstates: [x, y]\nA: zeros(2, 2)\nH: [[f, '{high}']]\n"))
    assert isinstance(found, Analysis)
    assert found.rank == 2


def test_a_combination_that_becomes_zero_is_lost(row):
    (value,) = [v for v in analyze(row({"p": ""}, "sin(p)", "p")).critical.values if v.condition == "p = 0"]
    assert len(value.lost) == 1
