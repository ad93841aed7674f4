"""Discrete-time models as files: what `F` and `step` mean, what cannot stand beside them, and the way back."""

import pytest

from obscli.core.place import ModelError
from obscli.model.discrete import require_continuous, varying_entry
from obscli.model.notation import to_text
from obscli.model.reader import read_text
from obscli.model.write import write_model


FREE = """\
parameters: {T: 0.5}
states: [x, v]
F: [[1, T], [0, 1]]
H: [[1, 0]]
step: T
"""


def read(*lines):
    return read_text("\n".join(lines), "file").systems[0]


def problems(*lines):
    with pytest.raises(ModelError) as caught:
        read(*lines)
    return [str(one) for one in caught.value.problems]


def test_what_a_file_means():
    system = read_text(FREE, "file").systems[0]
    assert system.discrete
    assert system.dynamics_name == "F"
    assert system.time == "k"
    assert to_text(system.step) == "T"
    assert {place: to_text(e) for place, e in system.A.entries.items()} == {
        (0, 0): "1",
        (0, 1): "T",
        (1, 1): "1",
    }
    assert system.A.places[0, 1].line == 3


def test_a_continuous_time_model_is_none():
    system = read("states: [x]", "A: [[1]]", "H: [[1]]")
    assert not system.discrete
    assert system.step is None
    assert system.time == "t"
    require_continuous(system, "anything")


@pytest.mark.parametrize(("given", "name"), [((), "k"), (("time: i",), "i")])
def test_the_time_symbol_is_the_step(given, name):
    system = read(*given, "states: [x]", f"F: [[cos({name})]]", "H: [[1]]")
    assert system.time == name
    assert varying_entry(system) == f"file:{2 + len(given)}:6: F[x, x]"


def test_the_step_may_be_left_out():
    assert read("states: [x]", "F: {x: {x: 2}}", "H: [[1]]").step is None


def test_time_itself_is_unknown():
    assert "unknown name 't'" in problems("states: [x]", "F: [[t]]", "H: [[1]]")[0]


def test_a_stage_replaces_rows():
    systems = read_text(f"{FREE}stages: {{base: {{}}, still: {{F: [[1, 0], [0, 1]]}}}}", "file").systems
    assert [len(one.A.entries) for one in systems] == [3, 2]
    assert all(one.discrete for one in systems)


def test_stages_may_give_the_matrix():
    systems = read_text("states: [x]\nH: [[1]]\nstages: {one: {F: [[k]]}, two: {F: [[2]]}}", "file").systems
    assert [one.stage for one in systems] == ["one", "two"]
    assert {one.time for one in systems} == {"k"}


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("A: [[1]]", "`A` goes with continuous time"),
        ("dynamics: {x: -x}", "`dynamics` goes with continuous time"),
        ("functions: [f]", "`functions` is not supported yet; this is a discrete-time model"),
        ("experiment: {runs: []}", "`experiment` of a discrete-time model (`F`) is not supported yet"),
        ("plan: {candidates: []}", "`plan` of a discrete-time model (`F`) is not supported yet"),
        ("noise: {R: 1, step: 0.1}", "a discrete-time model (`F`) has its own `step`"),
        ("step: -1", "a positive time is expected here"),
        ("step: k", "the step depends on k: it is one number"),
        ("stages: {other: {A: [[2]]}}", "`A` goes with continuous time"),
    ],
)
def test_what_cannot_stand_beside(line, words):
    found = problems("states: [x]", "F: [[1]]", "H: [[1]]", line)
    assert any(words in one and one.startswith("file:4") for one in found), found


def test_a_step_goes_with_the_matrix():
    [found] = problems("states: [x]", "A: [[1]]", "H: [[1]]", "step: 0.1")
    assert "`step` goes with `F`" in found
    assert "noise" in found


def test_shapes_are_those_of_states():
    assert "2×2" in problems("states: [x, y]", "F: [[1]]", "H: [[1, 0]]")[0].replace(" by ", "×").replace(
        "x", "×"
    )


def test_the_refusal_names_the_place():
    system = read_text(FREE, "file").systems[0]
    with pytest.raises(
        ModelError, match=r"file:3:\d+: F: obscli calibrate does not take discrete-time models"
    ):
        require_continuous(system, "obscli calibrate")


def test_written_and_read_back():
    text = write_model(
        read_text(f"{FREE}noise: {{R: 1, Q: 2, P0_std: 3}}\ninterval: {{stop: 9}}", "file").systems[0]
    )
    again = read_text(text, "again").systems[0]
    assert "F:" in text.splitlines()
    assert "step: T" in text.splitlines()
    assert again.discrete
    assert write_model(again) == text
