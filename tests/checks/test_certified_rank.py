"""The rank of the Gramian proved in ball arithmetic: never above the truth, and the truth wherever it is known."""

import random
from fractions import Fraction
from pathlib import Path

import pytest
from flint import arb

from obscli.checks.certified_rank import ATTEMPTS, certified_rank, sampled_rows
from obscli.exact.ball import precision
from obscli.exact.lift_finding import Lift
from obscli.exact.stationary_form import itself, lift_of
from obscli.model.covector import parse_scalar
from obscli.model.expression import ONE, Number
from obscli.model.reader import load, read_text


MODELS = Path(__file__).parents[2] / "models"
INS = ["horizontal.yaml", "vertical.yaml"]
STAGES = [f"stage_{k}" for k in (1, 2, 3)]


def read(text):
    return read_text(text, "test.yaml").systems[0]


def constant(A, H):
    """Return the system with these matrices of rationals."""
    n = len(A)
    return read(f"states: [{', '.join(f'x{i}' for i in range(n))}]\nA: {_rows(A)}\nH: {_rows(H)}\n")


def _rows(matrix):
    return "[" + ", ".join("[" + ", ".join(f"'{entry}'" for entry in row) + "]" for row in matrix) + "]"


def numbers(*rows):
    """Return sparse rows of constant expressions."""
    return tuple({j: Number(Fraction(e)) for j, e in enumerate(row) if e} for row in rows)


def excludes_zero(minor):
    return abs(Fraction(minor.midpoint)) > Fraction(minor.radius)


def proved(system, rank, *instants, start=0.0):
    return [one.rank for one in certified_rank(system, itself(system), rank, start, instants).instants]


@pytest.mark.parametrize("stage", STAGES)
@pytest.mark.parametrize("file", INS)
def test_the_rank_of_every_stage_is_certified_and_no_more(bundled, file, stage):
    system, finding, _ = bundled(f"ins_calibration/{file}", stage)
    lift = lift_of(system)
    found = certified_rank(system, lift, finding.at_values.rank, 0.0, [60.0, 600.0])
    assert [one.rank for one in found.instants] == [16 if file == "horizontal.yaml" else 12] * 2
    assert all(excludes_zero(one.minor) for one in found.instants)
    above = certified_rank(system, lift, finding.at_values.rank + 1, 0.0, [60.0])
    assert above.instants[0].rank is None
    assert above.is_undecided


@pytest.mark.parametrize("stage", STAGES)
def test_sampled_rows_vanish_on_the_exact_kernel(bundled, stage):
    """H(τ) Φ(τ, t) N(t) = 0: the balls of all products contain zero and are as small as their precision."""
    from obscli.exact.ball import BallPoint
    from obscli.model.specialise import at_nominal

    system, finding, _ = bundled("ins_calibration/horizontal.yaml", stage)
    nominal, t = at_nominal(system), Fraction(600)
    place = {name: j for j, name in enumerate(system.state_names)}
    lift = lift_of(system)
    there = Lift(
        lift.names,
        tuple(nominal.covector(one) for one in lift.variables),
        *(
            tuple({j: nominal.expression(e) for j, e in row.items()} for row in rows)
            for rows in (lift.A, lift.H)
        ),
    )
    with precision(256, 1):
        rows = sampled_rows(system, there, Fraction(0), t, 20)
        point = BallPoint(system, {system.time: t}, 1)
        for direction in finding.unobservable:
            N = {place[name]: point.value(nominal.expression(e))[0] for name, e in direction.items()}
            for row in rows:
                product = sum((row[j] * e for j, e in N.items()), arb(0))
                assert product.contains(0)
                assert product.rad() < arb("1e-40")


@pytest.mark.parametrize("seed", range(6))
def test_random_systems_of_known_rank(seed):
    """x = (seen, unseen) in random coordinates: an observable companion pair, and what it does not contain."""
    source = random.Random(seed)
    seen, unseen = source.randrange(1, 5), source.randrange(4)
    n = seen + unseen
    A = [[Fraction(0)] * n for _ in range(n)]
    for i in range(n):
        for j in range(seen if i < seen else n):
            A[i][j] = Fraction(source.randrange(-4, 5), 4)
    for i in range(seen - 1):  # y = x0, and x(i+1) is new in every derivative
        A[i] = [*A[i][: i + 1], Fraction(1), *[Fraction(0)] * (n - i - 2)]
    H = [[Fraction(int(j == 0)) for j in range(n)]]
    for _ in range(3 * n):  # x → T x with elementary T
        i, j = source.sample(range(n), 2) if n > 1 else (0, 0)
        if i == j:
            continue
        for row in (*A, *H):
            row[j] += row[i]
        A[i] = [a - b for a, b in zip(A[i], A[j], strict=True)]
    system = constant(A, H)
    assert proved(system, seen, 0.5, 3.0) == [seen, seen]
    assert proved(system, seen + 1, 0.5) == [None]


def test_a_window_a_thousand_time_constants_long():
    """e^(A (τ − t)) grows backwards by e^12000: over the whole interval no precision tried tells it."""
    system = read("states: [a, b, c]\nA: [[-1, 1, 0], [0, -2, 1], [0, 0, -1/2]]\nH: [[1, 0, 1]]\n")
    found = certified_rank(system, itself(system), 3, 0.0, [6000.0]).instants[0]
    assert found.rank == 3
    assert excludes_zero(found.minor)
    assert 0.0 < found.minor.since < 6000.0


def test_samples_that_all_meet_one_period():
    """y = a + b cos 2πt + c sin 2πt sampled at whole t is one row; other samples tell."""
    system = read(
        "states: [a, b, c]\nA: [[0, 0, 0], [0, 0, 0], [0, 0, 0]]\nH: [[1, cos(2*pi*t), sin(2*pi*t)]]\n"
    )
    found = certified_rank(system, lift_of(system), 3, 0.0, [6.0]).instants[0]
    assert found.rank == 3
    assert found.minor.precision > ATTEMPTS[0][0]


def test_rows_of_a_known_transition():
    """y = x1 + t² x2, x2' = 0, x1' = x2: H Φ(τ, t) = (1, τ − t + τ²), through z = (x1, x2, t x2, t² x2)."""
    system = read("states: [x1, x2]\nA: [[0, 1], [0, 0]]\nH: [[1, t^2]]\n")
    names = ("x1", "x2", "z1", "z2")
    forms = [{"x1": ONE}, {"x2": ONE}, *({"x2": parse_scalar(system, text, "test")} for text in ("t", "t^2"))]
    A = numbers((0, 1, 0, 0), (0, 0, 0, 0), (0, 1, 0, 0), (0, 0, 2, 0))
    lift = Lift(names, tuple(forms), A, numbers((1, 0, 0, 1)))
    t, since = Fraction(7, 2), Fraction(1, 2)
    with precision(128, 1):
        for k, row in enumerate(sampled_rows(system, lift, since, t, 5)):
            tau = t - k * (t - since) / 4
            assert row[0].contains(1)
            expected = tau - t + tau**2
            assert row[1].contains(arb(expected.numerator) / expected.denominator)


def test_the_rank_found_agrees_with_hand_made_and_found_lifts():
    system = read("states: [x1, x2]\nA: [[0, 1], [0, 0]]\nH: [[1, t^2]]\n")
    assert certified_rank(system, lift_of(system), 2, 0.0, [1.0]).instants[0].rank == 2


def test_a_rank_of_zero_needs_no_minor():
    system = read("states: [a]\nA: [[1]]\nH: [[0]]\n")
    found = certified_rank(system, itself(system), 0, 0.0, [1.0])
    assert found.instants[0].rank == 0
    assert found.instants[0].minor is None
    assert not found.is_undecided


def test_a_parameter_without_a_value_is_named():
    system = read("parameters: {k: {}}\nstates: [a, b]\nA: [[0, k], [0, 0]]\nH: [[1, 0]]\n")
    found = certified_rank(system, itself(system), 2, 0.0, [1.0]).instants[0]
    assert found.rank is None
    assert found.reason == "k has no value (--set)"


def test_values_at_which_the_rank_is_lower():
    """With k = 0 there is no second row: two is never certified, one is."""
    system = read("parameters: {k: 0}\nstates: [a, b]\nA: [[0, k], [0, 0]]\nH: [[1, 0]]\n")
    assert proved(system, 2, 1.0) == [None]
    assert proved(system, 1, 1.0) == [1]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("A: [[0, cos(t^2)], [0, 0]]", "A[a, b]"),
        ("A: [[0, 1/(1 + t)], [0, 0]]", "A[a, b]"),
        ("functions: [f]\nA: [[0, f], [0, 0]]", "f is a function left open"),
    ],
)
def test_what_is_not_reducible_says_so(text, words):
    found = lift_of(read(f"states: [a, b]\n{text}\nH: [[1, 0]]\n"))
    assert isinstance(found, str)
    assert found.startswith("not reducible: ")
    assert words in found


def test_no_lift_depends_on_functions_without_values():
    for system in load(MODELS / "textbook/attitude_quaternion.yaml").systems:
        assert isinstance(lift_of(system), str)
