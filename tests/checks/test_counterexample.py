"""What refutes a false combination: an unobservable direction, and two trajectories with the same outputs.

The direction is held against all observable combinations exactly; the trajectories are integrated anew, by
another method, from coefficients evaluated here.
"""

import math
import random
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from obscli.checks.claims import check_claims
from obscli.core.place import Place
from obscli.exact.analysis import Options, analyze, contained
from obscli.exact.interpreter import Interpreter
from obscli.model.covector import parse_scalar
from obscli.model.expression import TimeDerivative, add, multiply, negate, number
from obscli.model.notation import to_text
from obscli.model.reader import read_text
from obscli.model.specialise import at_nominal
from obscli.model.system import Claim, Quantity
from obscli.numeric.analysis import analyze as look


HERE = Place("here", 1, 1)
FAST = Options(critical=False, certificate=False)
NAMES = {name: getattr(math, name) for name in ("pi", "sin", "cos", "tan", "exp", "log", "sqrt")}
BUNDLED = [
    ("ins_calibration/horizontal.yaml", "stage_2"),
    ("ins_calibration/horizontal.yaml", "stage_3"),
    ("textbook/ins_velocity_aiding.yaml", "constant_velocity"),
    ("textbook/levelling.yaml", None),
]


def _values(system, t):
    values = {**NAMES, system.time: t}
    for one in system.parameters:
        values[one.name] = eval(to_text(one.nominal), values)
    return values


def _matrix(matrix, system):
    """Return t -> matrix of floats, each entry evaluated by Python."""
    codes = {place: compile(to_text(entry), "entry", "eval") for place, entry in matrix.entries.items()}
    fixed = _values(system, 0.0)

    def at(t):
        values = {**fixed, system.time: t}
        found = np.zeros((matrix.rows, matrix.columns))
        for place, code in codes.items():
            found[place] = eval(code, values)
        return found

    return at


def _row(covector, system, t):
    values = _values(system, t)
    return np.array(
        [eval(to_text(covector[s]), values) if s in covector else 0.0 for s in system.state_names]
    )


def _refuted(system, analysis, numeric, covector):
    """Return the result of the claim that a combination is observable."""
    claim = Claim("claims", HERE, observable=(Quantity("wrong", covector, HERE),))
    [result] = check_claims(replace(system, claims=(claim,)), analysis, lambda _: numeric)
    return result


def _zero(system, *expressions):
    interpreter = Interpreter(system, expressions)
    return [not interpreter.read(one) for one in expressions]


def _product(covector, direction):
    return add(number(0), *(multiply(covector[s], e) for s, e in direction.items() if s in covector))


def _random_claim(source, system):
    choices = ["1", "-2", "t", "cos(w*t)", "w"]
    states = source.sample(system.state_names, source.randint(1, min(3, system.n)))
    return {s: parse_scalar(system, source.choice(choices), "claim") for s in states}


def _known_system(known, seed):
    """Return a random system with hidden directions, with values for its parameters."""
    text = known.build(seed, breakable=False).text
    for name, value in (("w", "7/5"), ("v", "1/3")):
        text = text.replace(f"{name}: null", f"{name}: {value}")
    return read_text(text, "known.yaml").systems[0]


def _rejected(source, system, analysis):
    while True:
        claimed = _random_claim(source, system)
        if not contained(analysis, [claimed])[0]:
            return claimed


SEEDS = [2, 3, 5, 7, 11, 12, 14, 15, 17, 20]


@pytest.fixture(scope="module", params=SEEDS)
def refuted(request, known, instants):
    """A random system, its analysis and Gramian, a false claim, and what comes of it."""
    system = _known_system(known, request.param)
    analysis = analyze(system, FAST)
    assert analysis.rank < system.n, "choose a seed with hidden directions"
    numeric = look(system, instants(system, "1/2", "1", "3/2"))
    claimed = _rejected(random.Random(request.param), system, analysis)
    result = _refuted(system, analysis, numeric, claimed)
    return SimpleNamespace(system=system, analysis=analysis, numeric=numeric, claimed=claimed, result=result)


def test_the_direction_is_annihilated_by_all_but_the_claim(refuted):
    one, system = refuted.result.counterexample, refuted.system
    direction = {s: parse_scalar(system, text, "direction") for s, text in one.direction.items()}
    products = [_product(c.coefficients, direction) for c in refuted.analysis.combinations]
    assert all(_zero(system, *products))
    change = _product(refuted.claimed, direction)
    told = parse_scalar(system, one.claim, "claim")
    assert _zero(system, change, add(change, negate(told))) == [False, True]
    assert refuted.result.verdict == "fails"
    assert all(f"{s}: {text}" in refuted.result.reason for s, text in one.direction.items())


def test_it_is_called_a_trajectory_exactly_where_it_is_one(refuted):
    one, system = refuted.result.counterexample, refuted.system
    direction = {s: parse_scalar(system, text, "direction") for s, text in one.direction.items()}
    derive = TimeDerivative(system.time, {}, frozenset())
    drift = []
    for i, name in enumerate(system.state_names):
        moved = [multiply(system.A.entries[i, j], direction[s]) for j, s in enumerate(system.state_names)
                 if s in direction and (i, j) in system.A.entries]  # fmt: skip
        rate = derive(direction[name]) if name in direction else number(0)
        drift.append(add(rate, *(negate(one) for one in moved)))
    assert one.is_trajectory == all(_zero(system, *drift))


def _told_apart(system, trajectories, claimed, tolerance):
    """Integrate from a state and from the one displaced; compare states, outputs and the claim."""
    A, H = _matrix(system.A, system), _matrix(system.H, system)
    instants = np.array(trajectories.instants)
    names = system.state_names
    told = np.array([trajectories.difference.get(s, (0.0,) * len(instants)) for s in names]).T
    base = np.linspace(-1, 1, system.n) * np.abs(told[0]).max()
    pair = [
        solve_ivp(lambda t, x: A(t) @ x, (instants[0], instants[-1]), start, "DOP853", instants,
                  rtol=1e-11, atol=1e-13 * np.abs(told).max()).y.T
        for start in (base, base + told[0])
    ]  # fmt: skip
    difference = pair[1] - pair[0]
    size = np.abs(np.array(pair)).max()
    assert np.abs(difference - told).max() < tolerance * size
    for t, first, second, claim in zip(instants, *pair, trajectories.claim, strict=True):
        output, row = H(t), _row(claimed, system, t)
        shown = np.abs(output) @ (np.abs(first) + np.abs(second))
        assert np.all(np.abs(output @ second - output @ first) <= tolerance * (shown + size))
        assert abs(row @ (second - first) - claim) <= tolerance * np.abs(row).sum() * size
    assert max(map(abs, trajectories.claim)) > 1e3 * tolerance * np.abs(told).max() > 0


def test_no_output_tells_the_trajectories_apart_but_the_claim_does(refuted):
    trajectories = refuted.result.counterexample.trajectories
    assert len(trajectories.instants) == 5
    assert (trajectories.instants[0], trajectories.instants[-1]) == (0.0, 1.5)
    _told_apart(refuted.system, trajectories, refuted.claimed, 1e-8)


@pytest.mark.parametrize(("file", "stage"), BUNDLED)
def test_trajectories_of_bundled_models(bundled, file, stage):
    system, analysis, numeric = bundled(file, stage)
    for state, verdict in analysis.states.items():
        if verdict == "observable":
            continue
        claimed = {state: number(1)}
        one = _refuted(system, analysis, numeric, claimed).counterexample
        _told_apart(system, one.trajectories, claimed, 1e-6)
        break
    else:
        pytest.fail("every state is observable")


@pytest.mark.parametrize("rate", [1, 2])
def test_outputs_that_are_all_rounding_are_alike(checked, rate):
    """y reads a and b only; the pair of trajectories differs in c, which drives nothing."""
    text = (
        f"states: [a, b, c]\nA: [[0, 1, 0], [0, 0, 0], [1, 0, -{rate}]]\nH: [[1, 0, 0]]\n"
        "claims:\n  - observable: [c]\n"
    )
    [result] = checked(text, "20")
    assert np.abs(result.counterexample.trajectories.difference.get("a", 0.0)).max() < 1e-12
    assert result.counterexample.trajectories.output < 1e-10


def test_an_observable_combination_has_no_counterexample(refuted):
    for one in refuted.analysis.combinations:
        result = _refuted(refuted.system, refuted.analysis, refuted.numeric, one.coefficients)
        assert result.verdict == "holds"
        assert (result.counterexample, result.corrections) == (None, ())


def test_without_a_gramian_the_direction_stands_alone(refuted):
    claim = Claim("claims", HERE, observable=(Quantity("wrong", refuted.claimed, HERE),))
    [result] = check_claims(replace(refuted.system, claims=(claim,)), refuted.analysis)
    assert result.counterexample.direction == refuted.result.counterexample.direction
    assert result.counterexample.trajectories is None
    assert result.gramian is None


def test_a_claim_at_values_is_refuted_at_these_values(checked):
    """At w = 0 the coefficient of x2 is gone, so that the claim about it fails there only."""
    text = (
        "states: [x1, x2]\nparameters: {w: 1/2}\nA: [[0, w], [0, 0]]\nH: [[1, 0]]\n"
        "claims:\n  - observable: [x2]\n  - {at: {w: 0}, observable: [x2 + w*x1]}\n"
    )
    generic, there = checked(text, "1", "2")
    assert (generic.verdict, there.verdict) == ("holds", "fails")
    assert there.counterexample.direction == {"x2": "1"}
    assert there.counterexample.trajectories.difference == {"x2": (1.0,) * 5}
    assert there.counterexample.trajectories.claim == (1.0,) * 5


@pytest.mark.parametrize("seed", SEEDS[:4])
def test_the_same_at_the_values_put_in_beforehand(known, instants, seed):
    """A claim ``at: nominal`` is refuted as the claim about the system with its numbers in it is."""
    system = _known_system(known, seed)
    there = at_nominal(system)
    special = there.system()
    analysis = analyze(special, FAST)
    claimed = _rejected(random.Random(seed), system, analyze(system, FAST))
    settings = instants(system, "1/2", "1", "3/2")
    numbers = _refuted(special, analysis, look(special, settings), there.covector(claimed))
    claim = Claim("claims", HERE, at="nominal", observable=(Quantity("wrong", claimed, HERE),))
    [nominal] = check_claims(
        replace(system, claims=(claim,)), analyze(system, FAST), lambda one: look(one, settings)
    )
    assert (nominal.verdict, nominal.reason) == (numbers.verdict, numbers.reason)
    assert nominal.counterexample.direction == numbers.counterexample.direction
    assert nominal.counterexample.trajectories.claim == numbers.counterexample.trajectories.claim
