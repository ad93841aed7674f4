"""Why a combination is observable or not: laws on systems of known structure, and on bundled models."""

import random
from fractions import Fraction
from pathlib import Path

import pytest

from obscli.exact.analysis import analyze
from obscli.exact.exact_system import read_system
from obscli.exact.finding import Undecided
from obscli.exact.saturation import rank_modulo_a_prime, saturate
from obscli.exact.trials import try_change, verdict_in
from obscli.exact.why import LIGHT, explain
from obscli.model.covector import parse_covector
from obscli.model.expression import ONE, ZERO
from obscli.model.measured import with_output
from obscli.model.notation import covector_text, to_text
from obscli.model.reader import load, read_text


MODELS = Path(__file__).parents[2] / "models"
HORIZONTAL = MODELS / "ins_calibration/horizontal.yaml"


def explained(system, text):
    return explain(analyze(system, LIGHT), parse_covector(system, text, "test"))


def parse(system, covector):
    return parse_covector(system, covector_text(covector, system.state_names), "test")


def random_system(seed):
    """Constant rows of small integers: some states observable, some coupled, some not seen at all."""
    source = random.Random(seed)
    n = source.randint(3, 6)
    states = ", ".join(f"x{k}" for k in range(1, n + 1))

    def entry():
        return source.choice([0, 0, 0, 1, -1, 2])

    A = [[entry() for _ in range(n)] for _ in range(n)]
    H = [[entry() for _ in range(n)] for _ in range(source.randint(1, 2))]
    H[0][0] = 1
    return read_text(f"states: [{states}]\nA: {A}\nH: {H}\n", "random.yaml").systems[0]


@pytest.mark.parametrize("seed", range(25))
def test_what_is_said_of_every_state_agrees_with_the_analysis_and_every_remedy_helps(seed):
    system = random_system(seed)
    whole = analyze(system, LIGHT)
    for state, verdict in whole.states.items():
        found = explained(system, state)
        assert (found.verdict, found.rank) == (verdict, whole.rank)
        assert bool(found.directions) == (verdict != "observable")
        assert (found.seen_by is not None) == (verdict == "observable")
        assert all(state in direction for direction in found.directions)
        assert all(state in one.coefficients for one in found.combinations)
        helps = {one.change: one.rank for one in found.remedies}
        for other in system.state_names:
            becomes, rank = verdict_in(with_output(system, {other: ONE}), found.target)
            assert (other in helps) == (verdict != "observable" and becomes == "observable")
            assert helps.get(other, rank) == rank
        assert (state in helps) == (verdict != "observable")
        if verdict == "coupled":
            assert all(verdict_in(system, parse(system, one))[0] == "observable" for one in found.corrections)


@pytest.mark.parametrize("seed", range(10))
def test_a_measured_free_state_removes_its_direction(seed):
    system = random_system(100 + seed)
    whole = analyze(system, LIGHT)
    for free in whole.free:
        assert analyze(with_output(system, {free: ONE}), LIGHT).rank == whole.rank + 1


@pytest.mark.parametrize("seed", range(10))
def test_an_observable_state_is_shown_by_its_row_of_L_and_by_none_before(seed):
    """The flag of the rows up to seen_by holds the state; without that row it does not."""
    system = random_system(200 + seed)
    rows = saturate(read_system(system)).rows
    for state, verdict in analyze(system, LIGHT).states.items():
        if verdict != "observable":
            continue
        output, order = explained(system, state).seen_by
        place = rows.index((order, [one.name for one in system.outputs].index(output)))
        unit = [Fraction(int(name == state)) for name in system.state_names]
        until = flag(system, rows[: place + 1])
        assert rank([*until, unit]) == rank(until)
        assert rank([*until[:-1], unit]) == rank(until[:-1]) + 1


def flag(system, rows):
    """Rows H_k A^order in fractions, from the numbers of the file."""
    A, H = (
        [
            [Fraction(to_text(matrix.entries.get((i, j), ZERO))) for j in range(system.n)]
            for i in range(matrix.rows)
        ]
        for matrix in (system.A, system.H)
    )
    found = []
    for order, output in rows:
        row = H[output]
        for _ in range(order):
            row = [sum(row[i] * A[i][j] for i in range(system.n)) for j in range(system.n)]
        found.append(row)
    return found


def rank(rows):
    rows, found = [list(row) for row in rows], 0
    for column in range(len(rows[0]) if rows else 0):
        pivot = next((row for row in rows if row[column]), None)
        if pivot is not None:
            rows.remove(pivot)
            rows = [
                [x - row[column] / pivot[column] * y for x, y in zip(row, pivot, strict=True)] for row in rows
            ]
            found += 1
    return found


@pytest.mark.parametrize("seed", range(10))
def test_a_trial_modulo_a_prime_says_what_the_proof_says(seed):
    system, other = random_system(300 + seed), random_system(300 + seed)
    for state in system.state_names:
        target = parse_covector(system, state, "test")
        light, proved = (try_change("", "stage", other, target, prove_it=prove) for prove in (False, True))
        verdict, rank_there = verdict_in(other, target)
        assert (light.becomes == "observable") == (verdict == "observable")
        assert light.rank == proved.rank == rank_there == rank_modulo_a_prime(read_system(other))
        assert (light.proved, proved.proved) == (False, verdict == "observable")


def test_a_chain_is_shown_derivative_by_derivative():
    """x1' = x2, x2' = x3 seen through x1: x_k is the (k-1)-th derivative of y."""
    text = "states: [x1, x2, x3]\nA: [[0, 1, 0], [0, 0, 1], [0, 0, 0]]\nH: [[1, 0, 0]]\n"
    system = read_text(text, "chain.yaml").systems[0]
    assert [explained(system, f"x{k}").seen_by for k in (1, 2, 3)] == [("y1", 0), ("y1", 1), ("y1", 2)]


def test_the_hidden_mode_and_the_file_s_values_are_told():
    [system] = load(MODELS / "kortunov/single_channel.yaml").systems
    found = explained(system, "dW")
    there = found.at_values
    assert (found.verdict, found.rank, found.because) == ("observable", 5, ())
    assert (there.verdict, there.rank, there.because) == ("coupled", 4, ("alpha_w = alpha_omega",))
    assert {one.change for one in there.remedies} == {"alpha", "dOm", "dW"}
    [special] = load(MODELS / "kortunov/single_channel.yaml", fix={"alpha_w": "alpha_omega"}).systems
    assert [mode.eigenvalue for mode in explained(special, "dW").modes] == ["alpha_omega"]
    assert explained(special, "V").modes == ()
    assert explained(special, "dW").at_values is None


def test_directions_that_move_with_time_are_said_to():
    [system] = load(MODELS / "textbook/markus_yamabe.yaml").systems
    assert explained(system, "h2").moving
    assert not explained(system, "x").moving


def test_no_single_state_separates_a_combination_hidden_by_three_directions():
    system = load(HORIZONTAL).systems[0]
    found = explained(system, "psi3 - b_g1/omega")
    assert (len(found.directions), found.trials) == (3, ())
    texts = [covector_text(one, system.state_names) for one in found.corrections]
    assert len(texts) == len(set(texts)) > 0
    assert {one.change: (one.rank, one.proved) for one in explained(system, "b_g3").remedies} == {
        "b_g3": (17, True), "M_g31": (17, True),
    }  # fmt: skip


def test_what_cannot_be_read_stays_undecided():
    text = "parameters: {a: 1}\nstates: [x]\nA: [[sqrt(a - a)/(a - a)]]\nH: [[1]]\n"
    [system] = read_text(text, "undefined.yaml").systems
    assert isinstance(explained(system, "x"), Undecided)
    target = parse_covector(system, "x", "test")
    tried = try_change("", "stage", system, target)
    assert (tried.becomes, tried.rank, tried.proved) == ("undecided", None, False)


@pytest.mark.parametrize("file", sorted(MODELS.rglob("*.yaml")), ids=lambda file: file.stem)
def test_one_state_of_every_verdict_is_explained_in_every_bundled_model(file):
    system = load(file).systems[0]
    whole = analyze(system, LIGHT)
    for verdict in dict.fromkeys(whole.states.values()):
        state = next(name for name, own in whole.states.items() if own == verdict)
        assert explain(whole, parse_covector(system, state, "test")).verdict == verdict
