"""What ``--without`` and ``--outputs`` leave of noise, priors and requirements; what a specialisation carries."""

import pytest

from obscli.core.place import ModelError
from obscli.model.expression import Symbol, number
from obscli.model.notation import to_text
from obscli.model.reader import read_text
from obscli.model.specialise import Specialisation, at_nominal


MODEL = """\
states: {psi: 2, b: 1, d: 1}
parameters: {w: 2, s: 3}
inputs: [u]
dynamics: {psi1: w*b + u, psi2: s*d}
measurements: {y: psi, z: b + w*d}
noise:
  Q: {psi1: s, b: 5, d: 7}
  R: {y: [[w, 1], [1, s]], z: 9}
  P0: {psi: [[4, 1], [1, s]], b: w}
  step: w/10
quantities: {q: psi1 - b, r: d}
require: {psi: 1, b: w, q: 3, d: 5}
experiment: {runs: [{name: there}, {name: back, fix: {w: -w}}], fresh: [psi]}
"""
DISTURBED = """\
states: [x, v, c]
parameters: {w: 2}
inputs: {u: 2}
disturbances: {n: 2}
dynamics: {x: v + n1, v: w*n2 + u1 - w*u2}
measurements: {y: x + c}
noise: {Q: {n: [[w, 1], [1, 3]]}, R: w, P0_std: {c: w}}
interval: {stop: 2*w}
"""


def entries(matrix):
    return {place: to_text(entry) for place, entry in matrix.entries.items()}


def base(text=MODEL, **options):
    return read_text(text, "test.yaml", **options).systems[0]


def requirements(**options):
    return {one.name: set(one.coefficients) for one in read_text(MODEL, "test.yaml", **options).require}


# -- fewer outputs


def test_of_the_outputs_left_out_the_noise_is_left_out():
    system = base(outputs=["z"])

    assert [one.name for one in system.outputs] == ["z"]
    assert (system.noise.R.rows, system.noise.R.columns) == (1, 1)
    assert entries(system.noise.R) == {(0, 0): "9"}


def test_correlations_of_outputs_kept_stay():
    assert entries(base(outputs=["y"]).noise.R) == {
        (0, 0): "w", (0, 1): "1", (1, 0): "1", (1, 1): "s",
    }  # fmt: skip
    assert entries(base(outputs=["y2", "z"]).noise.R) == {(0, 0): "s", (1, 1): "9"}
    # in the order of the file, whatever was asked for
    assert entries(base(outputs=["z", "y2"]).noise.R) == {(0, 0): "s", (1, 1): "9"}


def test_fewer_outputs_leave_states_as_they_are():
    plain, system = base(), base(outputs=["z"])

    assert entries(system.noise.P0) == entries(plain.noise.P0)
    assert entries(system.noise.Q) == entries(plain.noise.Q)
    assert to_text(system.noise.step) == "w/10"
    assert system.prior.keys() == plain.prior.keys()
    assert requirements(outputs=["z"]) == requirements()


# -- fewer states


def test_of_the_states_left_out_prior_and_driving_noise_are_left_out():
    system = base(without=["psi2", "b"])

    assert system.state_names == ("psi1", "d")
    assert entries(system.noise.Q) == {(0, 0): "s", (1, 1): "7"}
    assert entries(system.noise.P0) == {(0, 0): "4"}
    assert (system.noise.P0.rows, system.noise.P0.columns) == (2, 2)
    assert set(system.prior) == {"psi1"}
    assert entries(system.noise.R) == entries(base().noise.R)


def test_correlations_of_states_kept_stay():
    system = base(without=["b", "d"])

    assert entries(system.noise.P0) == {(0, 0): "4", (0, 1): "1", (1, 0): "1", (1, 1): "s"}
    assert set(system.prior) == {"psi1", "psi2"}


def test_inputs_and_disturbances_keep_their_columns():
    system = base(DISTURBED, without=["x"])

    assert system.state_names == ("v", "c")
    assert (system.G.rows, system.G.columns, entries(system.G)) == (2, 2, {(0, 1): "w"})
    assert (system.B.rows, system.B.columns, entries(system.B)) == (2, 2, {(0, 0): "1", (0, 1): "-w"})
    # Q is over the disturbances, which stay
    assert entries(system.noise.Q) == {(0, 0): "w", (0, 1): "1", (1, 0): "1", (1, 1): "3"}
    assert entries(system.noise.P0) == {(1, 1): entries(base(DISTURBED).noise.P0)[2, 2]}


def test_requirements_on_states_left_out_go():
    assert requirements() == {
        "psi1": {"psi1"}, "psi2": {"psi2"}, "b": {"b"}, "q": {"psi1", "b"}, "d": {"d"},
    }  # fmt: skip
    assert requirements(without=["psi"]) == {"b": {"b"}, "q": {"b"}, "d": {"d"}}
    assert "d" not in requirements(without=["d"])


def test_runs_are_cut_as_the_stages_are():
    found = read_text(MODEL, "test.yaml", without=["b"], outputs=["y1", "z"])

    for system in (found.systems[0], *(run.system for run in found.experiment.runs)):
        assert system.state_names == ("psi1", "psi2", "d")
        assert [one.name for one in system.outputs] == ["y1", "z"]
        assert entries(system.noise.R) == {(0, 0): "-w" if system.stage == "back" else "w", (1, 1): "9"}
        assert entries(system.noise.Q).keys() == {(0, 0), (2, 2)}
        assert set(system.prior) == {"psi1", "psi2"}
    assert found.experiment.shared == ("d",)


@pytest.mark.parametrize(
    "options", [{"without": ["psi3"]}, {"outputs": ["x"]}, {"without": ["psi", "b", "d"]}]
)
def test_what_is_not_there_cannot_be_cut(options):
    with pytest.raises(ModelError):
        base(**options)


# -- specialisation


def test_a_specialisation_carries_noise_and_priors():
    system = base()
    there = Specialisation(system, {"w": number(7), "s": Symbol("w")}).system()

    assert entries(there.noise.R) == {(0, 0): "7", (0, 1): "1", (1, 0): "1", (1, 1): "w", (2, 2): "9"}
    assert entries(there.noise.Q)[0, 0] == "w"
    assert entries(there.noise.P0)[2, 2] == "7"
    assert to_text(there.noise.step) == "7/10"
    assert to_text(there.prior["b"]) == "sqrt(7)"
    assert [one.name for one in there.parameters] == []


def test_a_specialisation_carries_inputs_and_disturbances():
    there = Specialisation(base(DISTURBED), {"w": number(5)}).system()

    assert entries(there.B) == {(1, 0): "1", (1, 1): "-5"}
    assert entries(there.G) == {(0, 0): "1", (1, 1): "5"}
    assert entries(there.noise.Q)[0, 0] == "5"
    assert to_text(there.interval.stop) == "10"


def test_at_the_files_values_nothing_is_left_of_parameters():
    there = at_nominal(base(DISTURBED)).system()

    assert there.parameters == ()
    assert entries(there.G) == {(0, 0): "1", (1, 1): "2"}
    assert entries(there.noise.R) == {(0, 0): "2"}
    assert to_text(there.prior["c"]) == "sqrt(4)"


def test_a_prior_that_becomes_zero_is_an_entry_still():
    """So that it can be refused by name, and is not taken for no prior."""
    there = Specialisation(base(DISTURBED), {"w": number(0)}).system()

    assert entries(there.noise.P0) == {(2, 2): "0"}
    assert entries(there.noise.R) == {(0, 0): "0"}
    assert entries(there.G) == {(0, 0): "1"}


def test_a_run_carries_what_it_fixes_into_its_noise():
    _, back = read_text(MODEL, "test.yaml").experiment.runs

    assert entries(back.system.A)[0, 2] == "-w"
    assert entries(back.system.noise.R)[0, 0] == "-w"
    assert to_text(back.system.noise.step) == "-w/10"
