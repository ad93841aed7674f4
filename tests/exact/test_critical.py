"""Parameter values and identities among functions at which the rank drops: each answer derived by hand.

Mostly x' = 0, y = H(t) x: the rank is the number of linearly independent functions of time in the row, and
it drops exactly where they become dependent.
"""

from itertools import combinations

import pytest

from obscli.exact.analysis import analyze
from obscli.exact.finding import Analysis
from obscli.exact.interpreter import Interpreter
from obscli.model.covector import parse_scalar
from obscli.model.specialise import Specialisation


REAL = {"a": "", "b": "", "c": "", "k": "", "phi": "", "omega": "", "w": ""}


def _search(row, entries, assume=None, functions=()):
    names = {n: "" for n in REAL if any(n in _words(e) for e in entries)}
    names |= {n: f"{{assume: {how}}}" for n, how in (assume or {}).items()}
    system = row(names, *entries, functions=functions)
    found = analyze(system)
    assert isinstance(found, Analysis), getattr(found, "reason", "")
    return system, found


def _words(text):
    return {w for w in "".join(c if c.isalnum() else " " for c in text).split() if not w.isdigit()}


def _same_zeros(system, zero, text):
    """Whether two expressions have the same numerator up to a constant factor."""
    other = parse_scalar(system, text, "expected")
    interpreter = Interpreter(system, [zero, other])
    a, b = interpreter.read(zero).num, interpreter.read(other).num
    return a * b.leading_coefficient() == b * a.leading_coefficient()


def _check(system, found, expected, kind="confirmed"):
    values = [v for v in found.critical.values if v.kind == kind]
    told = [(v.condition, v.rank) for v in values]
    assert len(values) == len(expected), told
    for text, rank in expected.items():
        same = [v for v in values if v.zero is not None and _same_zeros(system, v.zero, text)]
        assert [v.rank for v in same] == [rank], (text, told)


# row, conditions with the rank there
ALL = [
    # sin at, sin bt are dependent iff one is zero (a = 0, b = 0) or they are equal up to sign (a = +-b)
    (("sin(a*t)", "sin(b*t)"), {"a": 1, "b": 1, "a - b": 1, "a + b": 1}),
    # cos is even and never zero: only a = +-b
    (("cos(a*t)", "cos(b*t)"), {"a - b": 1, "a + b": 1}),
    # at w = 0 cos = 1, rank 1 stays
    (("cos(w*t)",), {}),
    # at w = 0 sin = 0
    (("cos(w*t)", "sin(w*t)"), {"w": 1}),
    # at w = 0: 1, 1
    (("cos(w*t)", "1"), {"w": 1}),
    # cos wt and cos 2wt are dependent only where both are 1
    (("cos(w*t)", "cos(2*w*t)"), {"w": 1}),
    # sin^2 = (1 - cos 2wt)/2 with 1 and cos 2wt spans only two functions for every w; one at w = 0
    (("sin(w*t)^2", "1", "cos(2*w*t)"), {"w": 1}),
    # cos(at + b) against cos(at): the determinant is sin b up to the factor a
    (("cos(a*t + b)", "cos(a*t)"), {"a": 1, "sin(b)": 1}),
    # exponentials: dependent iff equal
    (("exp(a*t)", "exp(b*t)"), {"a - b": 1}),
    (("exp(a*t)", "1"), {"a": 1}),
    (("exp(a*t)", "t", "1"), {"a": 2}),
    (("exp(a*t)", "exp(-a*t)"), {"a": 1}),
    (("sinh(a*t)", "cosh(b*t)"), {"a": 1}),
    (("sinh(a*t)", "sinh(b*t)"), {"a": 1, "b": 1, "a - b": 1, "a + b": 1}),
    (("tanh(a*t)", "1"), {"a": 1}),
    # exp(at) cos bt, exp(at) sin bt: only b = 0 (sin = 0); a does not matter
    (("exp(a*t)*cos(b*t)", "exp(a*t)*sin(b*t)"), {"b": 1}),
    # sqrt(1 + a t^2) is constant only at a = 0; log(1 + at) is zero only there
    (("sqrt(1 + a*t^2)", "1"), {"a": 1}),
    (("sqrt(a + t)", "sqrt(b + t)"), {"a - b": 1}),
    (("log(1 + a*t)", "1"), {"a": 1}),
    (("log(1 + a*t)", "log(1 + b*t)"), {"a": 1, "b": 1, "a - b": 1}),
    (("atan(a*t)", "atan(t)"), {"a": 1, "a - 1": 1, "a + 1": 1}),
    # rational functions of time
    (("1/(t + a)", "1/(t + b)"), {"a - b": 1}),
    (("t^2 + a*t", "t"), {}),
    (("t^2 + a", "t^2 + b"), {"a - b": 1}),
    (("a*t + b", "c*t + k"), {"a*k - b*c": 1}),
    # constants
    (("1 + cos(phi)",), {"phi - pi": 0}),
    (("1 - cos(phi)",), {"phi": 0}),
    (("cos(phi)", "t"), {"cos(phi)": 1}),
    (("sin(phi)", "t"), {"sin(phi)": 1}),
    (("omega*cos(phi) + k", "t"), {"omega*cos(phi) + k": 1}),
    (("exp(a) - 2", "t"), {"a - log(2)": 1}),
    (("sqrt(a) - 2", "t"), {"a - 4": 1}),
    (("a*b", "t"), {"a": 1, "b": 1}),
    (("(a - 1)^2*(b + 2)", "t"), {"a - 1": 1, "b + 2": 1}),
    # no real zeros: nothing is reported
    (("a^2 + 1", "t"), {}),
    (("a^2 + b^2 + 1", "t"), {}),
    (("exp(a)", "t"), {}),
    (("cosh(a)", "t"), {}),
    (("2 + cos(phi)", "t"), {}),
    (("a^2 - a + 1", "t"), {}),
    (("a^2 + a*b + b^2 + 1", "t"), {}),
]


@pytest.mark.parametrize(("entries", "expected"), ALL, ids=[" | ".join(e) for e, _ in ALL])
def test_the_critical_values_are_all_those_derived_by_hand(row, entries, expected):
    system, found = _search(row, entries)
    _check(system, found, expected)
    assert found.critical.complete
    assert not [v.condition for v in found.critical.values if v.kind != "confirmed"]


# The same, where the answer is harder to reach: a search that misses one must not call itself complete.
HARD = [
    # half-angle at infinity for an angle that is a product: 1 + cos(ab) = 0 on ab = pi
    (("1 + cos(a*b)", "t"), 1),
    # (1 + t)^a = 1 + t at a = 1
    (("(1 + t)^a - (1 + t)",), 1),
    (("exp(a*log(1 + t)) - (1 + t)^2",), 1),
    # t^a and 1/t span one dimension at a = -1 (found as content) but t^a + 1/t - 2/t vanishes there too
    (("t^a - 1/t",), 1),
    # (1 + at)^(1/3) = 1 at a = 0
    (("(1 + a*t)^(1/3) - 1",), 1),
    (("(1 + a*t)^(2/3) - 1", "t"), 1),
    # sqrt(t^2 + a) = t for t > 0 at a = 0
    (("sqrt(t^2 + a) - t",), 1),
    # sin(atan t) sqrt(1 + t^2) = t
    (("sin(a*atan(t))*sqrt(1 + t^2) - t",), 1),
    # exp(asinh(t)) = t + sqrt(1 + t^2)
    (("exp(a*asinh(t)) - t - sqrt(1 + t^2)",), 1),
    # a = log 2 makes exp(a) - 2 vanish; cos a = 1/2; log a = 0; a^3 = 2; sqrt a = 0: undecided is allowed
    (("2*sin(a) - 1", "t"), 1),
    (("log(a)", "t"), 1),
    (("a^3 - 2", "t"), 1),
    (("a - cos(a)", "t"), 1),
    (("sqrt(a)", "t"), 1),
    (("cos(a + b)", "t"), 1),
    (("cos(a) - cos(b)", "t"), 1),
    (("a^2 - 2*b^2", "t"), 1),
    (("cos(25*a*t) - cos(b*t)",), 1),
    (("cos(a*t)^2 - cos(b*t)^2",), 1),
    (("exp(a*t) - exp(b*t)",), 1),
    (("sin(a*t)*cos(b*t) - sin(c*t)/2 - sin(k*t)/2",), 0),
    (("1/(1 + exp(a)) - 1/2", "t"), 1),
]


@pytest.mark.parametrize(("entries", "least"), HARD, ids=[" | ".join(e) for e, _ in HARD])
def test_a_search_that_misses_something_does_not_call_itself_complete(row, entries, least):
    _, found = _search(row, entries)
    confirmed = [v for v in found.critical.values if v.kind == "confirmed"]
    assert len(confirmed) >= least or not found.critical.complete


@pytest.mark.parametrize(
    ("entries", "expected"),
    [
        # three tones: dependent iff some is zero or two coincide up to sign
        (("sin(a*t)", "sin(b*t)", "sin(c*t)"),
         {**dict.fromkeys("abc", 2), **{f"{x} {s} {y}": 2 for x, y in combinations("abc", 2) for s in "+-"}}),
        # cos at cos bt = (cos (a+b)t + cos (a-b)t)/2, with sin at sin bt and cos ct: dependent where c = +-(a+b)
        # or +-(a-b) only if the other tone is among them too, so nowhere; sin at sin bt = 0 at a = 0 or b = 0
        (("cos(a*t)*cos(b*t)", "sin(a*t)*sin(b*t)"), {"a": 1, "b": 1}),
        # cos (a+b)t and cos (a-b)t from the two products, and cos ct one of them
        (("cos(a*t)*cos(b*t)", "sin(a*t)*sin(b*t)", "cos(c*t)"),
         {"a": 2, "b": 2, "c - a - b": 2, "c + a + b": 2, "c - a + b": 2, "c + a - b": 2}),
    ],
)  # fmt: skip
def test_every_coincidence_of_tones_is_found(row, entries, expected):
    system, found = _search(row, entries)
    _check(system, found, expected)
    assert found.critical.complete


def test_a_quadratic_condition_is_solved_on_both_branches(row):
    # a^2 = 2 b^2: b = a/sqrt 2 and b = -a/sqrt 2, one branch each, for every real a
    _, found = _search(row, ("a^2 - 2*b^2", "t"))
    assert [(v.kind, v.rank) for v in found.critical.values] == [("confirmed", 1)] * 2
    assert found.critical.complete


def test_a_quadratic_condition_of_positive_parameters_has_one_branch(row):
    # a, b > 0: only b = a/sqrt 2 is allowed, b = -a/sqrt 2 is outside what the file assumes
    _, found = _search(row, ("a^2 - 2*b^2", "t"), {"a": "positive", "b": "positive"})
    kinds = [v.kind for v in found.critical.values]
    assert kinds.count("confirmed") == 1
    assert set(kinds) <= {"confirmed", "excluded"}


@pytest.mark.parametrize(
    ("entries", "assume", "confirmed", "excluded"),
    [
        (("a*t", "1"), {"a": "positive"}, {}, {"a": 1}),
        (("a*t", "1"), {"a": "nonzero"}, {}, {"a": 1}),
        (("(a + b)*t", "1"), {"a": "positive", "b": "positive"}, {}, {"a + b": 1}),
        (("(a - b)*t", "1"), {"a": "positive", "b": "positive"}, {"a - b": 1}, {}),
        (("a*b*t", "1"), {"a": "nonzero", "b": "real"}, {"b": 1}, {"a": 1}),
        (("(a + 1)*t", "1"), {"a": "positive"}, {}, {"a + 1": 1}),
        (
            ("sin(a*t)", "sin(b*t)"),
            {"a": "positive", "b": "positive"},
            {"a - b": 1},
            {"a": 1, "b": 1, "a + b": 1},
        ),
        (
            ("sin(a*t)", "sin(b*t)"),
            {"a": "nonzero", "b": "nonzero"},
            {"a - b": 1, "a + b": 1},
            {"a": 1, "b": 1},
        ),
        (("a^2*b*t", "1"), {"a": "nonzero", "b": "nonzero"}, {}, {"a": 1, "b": 1}),
    ],
)
def test_values_outside_assume_are_reported_apart(row, entries, assume, confirmed, excluded):
    system, found = _search(row, entries, assume)
    _check(system, found, confirmed)
    _check(system, found, excluded, "excluded")
    assert found.critical.complete


@pytest.mark.parametrize(
    ("entries", "undefined", "confirmed"),
    [
        (("1/a", "t"), {"a": None}, {}),
        (("1/(a - b)", "t"), {"a - b": None}, {}),
        (("t/cos(phi)", "1"), {"cos(phi)": None}, {}),
        (("tan(phi)", "t"), {"cos(phi)": None}, {"sin(phi)": 1}),
        (("a/b", "t"), {"b": None}, {"a": 1}),
        (("t/(a*t + b)", "1"), {}, {"b": 1}),
    ],
)
def test_values_where_a_coefficient_does_not_exist_are_called_undefined(row, entries, undefined, confirmed):
    # t/(at + b): constant 1/a at b = 0; a = b = 0 is of codimension two
    system, found = _search(row, entries)
    _check(system, found, undefined, "undefined")
    _check(system, found, confirmed)


@pytest.mark.parametrize(
    ("entries", "count"),
    [
        # A = 0: the rank of L(t) = (H; H') at an instant
        (("1", "t^2"), 1),  # L = [1 t^2; 0 2t]
        (("1", "t"), 0),
        (("1", "exp(t)"), 0),  # exp is never zero
        (("exp(w*t)", "1"), 0),
        (("1", "1 + t^2"), 1),
        (("1 + t^2", "1 + 2*t^2"), 1),  # determinant 2t
        (("t",), 1),
        (("1 + t^2",), 0),
        (("1/(1 + t)",), 0),
    ],
)
def test_instants_are_noted_and_are_no_loss(row, entries, count):
    _, found = _search(row, entries)
    assert len(found.critical.instants) == count
    assert not [v for v in found.critical.values if v.condition.startswith("t ")]
    assert found.rank == len(entries)


def test_an_instant_is_where_the_row_vanishes_and_nowhere_else(row):
    # y = cos(wt) x is blind where cos(wt) = 0; sin(wt) = +-1 there, but cos(wt) = -1 is no such instant
    _, found = _search(row, ("cos(w*t)",))
    assert found.critical.instants == ("cos(w*t) = 0",)


@pytest.mark.parametrize(
    ("entry", "angles"),
    [
        ("1 + cos(2*phi)", {"pi/2", "-pi/2"}),
        ("sin(2*phi)", {"0", "pi", "pi/2", "-pi/2"}),
        ("tan(phi)", {"0", "pi"}),
        ("cos(phi/2)", {"pi"}),
        ("cos(3*phi) - cos(phi)", {"0", "pi", "pi/2", "-pi/2"}),
    ],
)
def test_every_angle_of_a_turn_is_found(row, entry, angles):
    """Every zero in one turn is told (as a value or as sin = 0, cos = 0), not only one in a period of the base."""
    system, found = _search(row, (entry, "t"))
    left = set()
    for angle in angles:
        at = Specialisation(system, {"phi": parse_scalar(system, angle, "angle")})
        zeros = [at.expression(v.zero) for v in found.critical.values if v.kind == "confirmed"]
        interpreter = Interpreter(at.system(), zeros)
        if all(interpreter.read(z) for z in zeros):
            left.add(angle)
    assert not left


@pytest.mark.parametrize(
    "entries", [("cos(phi)/cos(phi)", "t"), ("sin(w*t)^2 + cos(w*t)^2", "t"), ("a/a", "t")]
)
def test_what_cancels_is_not_critical(row, entries):
    _, found = _search(row, entries)
    assert not [v for v in found.critical.values if v.kind == "confirmed"]


# -- dynamics


CHANNEL = """\
parameters: {{g: {g}, alpha_omega: null, alpha_w: null}}
states: [alpha, V, R, dOm, dW]
dynamics: {{alpha: dOm, V: g*alpha + dW, R: V, dOm: alpha_omega*dOm, dW: alpha_w*dW}}
measurements: {{velocity: V, position: R}}
"""


@pytest.mark.parametrize(("assume", "kind"), [("null", "confirmed"), ("{assume: positive}", "excluded")])
def test_kortunovs_channel(system, assume, kind):
    # gcd of the 5x5 minors of L is g^2 alpha_w (alpha_omega - alpha_w). At g = 0: V' = dW, so V, R, dW remain: 3
    given = system(CHANNEL.format(g=assume))
    found = analyze(given)
    wanted = {"alpha_w": 4, "alpha_w - alpha_omega": 4}
    if kind == "confirmed":
        _check(given, found, {**wanted, "g": 3})
    else:
        _check(given, found, wanted)
        _check(given, found, {"g": 3}, "excluded")
    assert found.critical.complete


def test_a_rate_in_the_dynamics_that_vanishes(system):
    # rotating pair: det L = -omega
    given = system("parameters: {omega: null}\nstates: [x1, x2]\nA: [[0, -omega], [omega, 0]]\nH: [[1, 0]]\n")
    _check(given, analyze(given), {"omega": 1})


def test_poles_that_coincide(system):
    # x_i' = -p_i x_i, y = x1 + x2 + x3: Vandermonde, rank 2 where two poles coincide
    given = system(
        "parameters: {p1: null, p2: null, p3: null}\nstates: [x1, x2, x3]\n"
        "dynamics: {x1: -p1*x1, x2: -p2*x2, x3: -p3*x3}\nmeasurements: {y: x1 + x2 + x3}\n"
    )
    found = analyze(given)
    _check(given, found, {"p1 - p2": 2, "p1 - p3": 2, "p2 - p3": 2})
    assert found.critical.complete


def test_resonance_of_an_oscillator_and_a_tone(system):
    # x'' = -k^2 x + sin(wt) d, y = x: L = (1 0 0; 0 1 0; -k^2 0 sin wt): rank 3 but at w = 0
    given = system(
        "parameters: {k: null, w: null}\nstates: [x, v, d]\ndynamics: {x: v, v: -k^2*x + sin(w*t)*d}\nmeasurements: {y: x}\n"
    )
    _check(given, analyze(given), {"w": 2})


def test_a_term_that_cancels_the_drift_of_the_row(system):
    # x' = -a x + b, y = exp(ct) x1: L = e^ct (1, 0; c - a, 1): rank 2 always. y = exp(ct)(x1 + x2), A = diag(-a, -b):
    # e^ct (1 1; c-a c-b): a = b only
    given = system(
        "parameters: {a: null, b: null, c: null}\nstates: [x1, x2]\ndynamics: {x1: -a*x1, x2: -b*x2}\n"
        "measurements: {y: exp(c*t)*(x1 + x2)}\n"
    )
    _check(given, analyze(given), {"a - b": 1})
    # y = exp(ct) x1 + x2: rows (e^ct, 1), (e^ct (c - a), -b): c = a - b only
    given = system(
        "parameters: {a: null, b: null, c: null}\nstates: [x1, x2]\ndynamics: {x1: -a*x1, x2: -b*x2}\n"
        "measurements: {y: exp(c*t)*x1 + x2}\n"
    )
    found = analyze(given)
    _check(given, found, {"a - b - c": 1})
    assert found.critical.complete


# -- functions


def _conditions(found):
    return {
        frozenset(v.condition.removesuffix(" = 0").split(" = ")): v.rank
        for v in found.critical.values
        if v.functions
    }


def test_identities_of_one_function(row):
    # y = f x1 + x2: dependent iff f is constant (f = 0 is one of those, reported for itself)
    _, found = _search(row, ("f", "1"), functions=("f",))
    assert _conditions(found) == {frozenset({"f"}): 1, frozenset({"deriv(f)"}): 1}


def test_identities_of_two_functions(row):
    # y = f x1 + g x2: dependent iff f = 0, g = 0 or f g' = g f' (g a constant multiple of f)
    _, found = _search(row, ("f", "g"), functions=("f", "g"))
    conditions = _conditions(found)
    assert conditions[frozenset({"f"})] == 1
    assert conditions[frozenset({"g"})] == 1
    assert any("deriv(f)" in text and "deriv(g)" in text for c in conditions for text in c)


def test_velocity_aiding_loses_heading_only_without_horizontal_force(system):
    # v' = f x phi: with f_E = f_N = 0 heading enters through the Earth rate only, tied to b_E: rank 7 of 8;
    # f_U = 0 alone leaves phi_U from f_E, f_N; the levels phi_E, phi_N are then seen through phi_U'' only
    given = system(
        "parameters: {omega_ie: {assume: positive}, L: null}\nfunctions: [f_E, f_N, f_U]\n"
        "states:\n  v: {components: [E, N]}\n  phi: {components: [E, N, U]}\n  b: {components: [E, N, U]}\n"
        "let:\n  w_ie: [0, omega_ie*cos(L), omega_ie*sin(L)]\n"
        "dynamics:\n  v: [f_N*phi_U - f_U*phi_N, f_U*phi_E - f_E*phi_U]\n  phi: -cross(w_ie, phi) + b\n"
        "measurements:\n  velocity: v\n"
    )
    found = analyze(given)
    assert found.rank == 8
    conditions = _conditions(found)
    assert conditions[frozenset({"f_E", "f_N"})] == 7
    assert frozenset({"f_E"}) not in conditions
    assert frozenset({"f_N"}) not in conditions
    assert all(v.reason or v.kind == "confirmed" for v in found.critical.values)


def test_constant_functions_are_a_critical_identity(system):
    # y = f.x with a constant direction f: one number for ever; rank 3 where f turns in space
    given = system("functions: {f: {shape: 3}}\nstates: {x: 3}\nA: zeros(3, 3)\nH: [[f1, f2, f3]]\n")
    found = analyze(given)
    conditions = _conditions(found)
    assert conditions[frozenset({"f1"})] == 2
    assert conditions[frozenset({"deriv(f1)", "deriv(f2)"})] == 2


# -- the rank at the file's values


@pytest.mark.parametrize(
    ("values", "rank", "because"),
    [
        ({"a": "2", "b": "3"}, 2, ()),
        ({"a": "2", "b": "2"}, 1, ("b = a",)),
        ({"a": "sqrt(2)", "b": "-2/sqrt(2)"}, 1, ("b = -a",)),
        ({"a": "0", "b": "1"}, 1, ("a = 0",)),
        ({"a": "pi/6", "b": "asin(1)/3"}, 1, ("b = a",)),
        ({"a": "log(2)", "b": "log(8)/3"}, 1, ("b = a",)),
        ({"a": "2^(1/3)", "b": "4^(2/3)/2"}, 1, ("b = a",)),
        ({"a": "sqrt(3 + 2*sqrt(2))", "b": "1 + sqrt(2)"}, 1, ("b = a",)),
    ],
)
def test_exact_values_are_compared_exactly(row, values, rank, because):
    found = analyze(row(values, "sin(a*t)", "sin(b*t)"))
    assert found.rank == 2
    if found.at_values.rank is None:
        assert found.at_values.reason
        return
    assert found.at_values.rank == rank
    assert found.at_values.because == because


def test_a_missing_value_leaves_the_rank_at_values_open(row):
    found = analyze(row({"a": "1", "b": ""}, "sin(a*t)", "sin(b*t)"))
    assert found.at_values.rank is None
    assert "b" in found.at_values.reason


def test_factors_with_long_numbers_are_found(row):
    """Over Z the binding cannot order factors with coefficients beyond a C int; nobody must notice."""
    found = analyze(row({"a": "1"}, "(1000000000001*a + 7)*(a + 3)*(a - 123456789012)"))
    assert {one.condition: one.rank for one in found.critical.values} == {
        "a = -3": 0,
        "a = 123456789012": 0,
        "a = -7/1000000000001": 0,
    }


@pytest.mark.parametrize("number", ["1 + sin(1/10)", "sin(1/10) + sqrt(7)", "exp(2) - 7", "pi - 3", "log(2)"])
def test_a_number_other_than_zero_is_no_condition(system, number):
    given = system(f"parameters: {{a: }}\nstates: [x, y]\nA: [[0, a*({number})], [0, 0]]\nH: [[1, 0]]\n")
    found = analyze(given)
    assert [value.condition for value in found.critical.values] == ["a = 0"]
    assert found.critical.complete
