"""Why a combination is observable or not: laws on systems of known structure, and on bundled models."""

import random
from pathlib import Path

import pytest

from obscli.exact.analysis import Options, analyze
from obscli.exact.why import explain, verdict_in
from obscli.model.covector import parse_covector
from obscli.model.expression import ONE
from obscli.model.measured import with_output
from obscli.model.notation import covector_text
from obscli.model.reader import load, read_text


MODELS = Path(__file__).parents[2] / "models"
LIGHT = Options(critical=False, certificate=False)


def explained(system, text):
    return explain(system, parse_covector(system, text, "test"))


def random_system(seed):
    """Constant rows with rational entries: some states observable, some coupled, some not seen at all."""
    source = random.Random(seed)
    n = source.randint(3, 6)
    states = ", ".join(f"x{k}" for k in range(1, n + 1))

    def entry():
        return source.choice([0, 0, 0, 1, -1, 2])

    A = [[entry() for _ in range(n)] for _ in range(n)]
    H = [[entry() for _ in range(n)] for _ in range(source.randint(1, 2))]
    H[0][0] = 1
    return read_text(f"states: [{states}]\nA: {A}\nH: {H}\n", "random.yaml").systems[0]


@pytest.mark.parametrize("seed", range(40))
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
        helps = {one.change for one in found.remedies}
        for other in system.state_names:
            measured = with_output(system, {other: ONE})
            becomes = verdict_in(measured, found.target)[0]
            assert (other in helps) == (verdict != "observable" and becomes == "observable")
        if verdict == "coupled":
            assert all(verdict_in(system, parse(system, one))[0] == "observable" for one in found.corrections)


def parse(system, covector):
    return parse_covector(system, covector_text(covector, system.state_names), "test")


@pytest.mark.parametrize("seed", range(10))
def test_a_measured_free_state_removes_its_direction(seed):
    system = random_system(100 + seed)
    whole = analyze(system, LIGHT)
    for free in whole.free:
        assert analyze(with_output(system, {free: ONE}), LIGHT).rank == whole.rank + 1


def test_an_observable_state_is_first_shown_by_the_row_that_adds_it():
    """A chain x1' = x2, x2' = x3 seen through x1: x_k is the (k-1)-th derivative of y."""
    system = read_text(
        "states: [x1, x2, x3]\nA: [[0, 1, 0], [0, 0, 1], [0, 0, 0]]\nH: [[1, 0, 0]]\n", "c.yaml"
    ).systems[0]
    assert [explained(system, f"x{k}").seen_by for k in (1, 2, 3)] == [("y1", 0), ("y1", 1), ("y1", 2)]


def test_the_hidden_mode_and_the_file_s_values_are_told():
    [system] = load(MODELS / "kortunov/single_channel.yaml").systems
    found = explained(system, "dW")
    assert (found.verdict, found.rank) == ("observable", 5)
    assert (found.at_values.becomes, found.at_values.rank) == ("coupled", 4)
    assert found.at_values.change == "alpha_w = alpha_omega"
    [special] = load(MODELS / "kortunov/single_channel.yaml", fix={"alpha_w": "alpha_omega"}).systems
    assert [mode.eigenvalue for mode in explained(special, "dW").modes] == ["alpha_omega"]
    assert explained(special, "V").modes == ()


def test_no_single_state_separates_a_combination_hidden_by_three_directions():
    system = load(MODELS / "ins_calibration/horizontal.yaml").systems[0]
    found = explained(system, "psi3 - b_g1/omega")
    assert (len(found.directions), found.remedies) == (3, ())
    assert {one.change: (one.rank, one.proved) for one in explained(system, "b_g3").remedies} == {
        "b_g3": (17, True), "M_g31": (17, True),
    }  # fmt: skip


@pytest.mark.parametrize("file", sorted(MODELS.rglob("*.yaml")), ids=lambda file: file.stem)
def test_one_state_of_every_verdict_is_explained_in_every_bundled_model(file):
    system = load(file).systems[0]
    whole = analyze(system, LIGHT)
    for verdict in dict.fromkeys(whole.states.values()):
        state = next(name for name, own in whole.states.items() if own == verdict)
        assert explained(system, state).verdict == verdict
