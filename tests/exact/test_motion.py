"""Which motion states need: what is lost where functions are zero or constant, proved."""

from pathlib import Path

import pytest

from obscli.exact.motion import motion_needs
from obscli.model.reader import load, read_text


AIDED = """
functions: {f: 2, u: {}}
states: [tilt, bias, drift]
A: [[0, 0, 0], [0, 0, 0], [0, 0, 0]]
H: [[f1, f2, 1], [0, 0, u]]
"""


def needs(text):
    return motion_needs(read_text(text, "test.yaml").systems[0])


def by_target(found):
    return {(one.target, one.kind, one.functions) for one in found.needs}


def test_what_a_state_needs_is_found():
    found = by_target(needs(AIDED))
    assert ("tilt", "zero", ("f1",)) in found
    assert ("bias", "zero", ("f2",)) in found
    # f constant: only the sum f1 tilt + f2 bias shows
    assert ("tilt", "constant", ("f1", "f2")) in found
    assert ("bias", "constant", ("f1", "f2")) in found


def test_no_superset_of_what_is_needed_is_named():
    for one in needs(AIDED).needs:
        smaller = [
            other
            for other in needs(AIDED).needs
            if other.target == one.target
            and other.kind == one.kind
            and set(other.functions) < set(one.functions)
        ]
        assert not smaller


def test_vectors_are_tried_early():
    """Of many functions only some sets are tried; three components of one vector are among them."""
    many = ", ".join(f"u{k}: {{}}" for k in range(30))
    text = (
        f"functions: {{f: 3, {many}}}\nstates: [a, b]\n"
        "A: [[0, 0], [0, 0]]\nH: [[0, 1], [f1, 0], [f2, 0], [f3, 0], [0, "
        + " + ".join(f"u{k}" for k in range(30))
        + "]]\n"
    )
    found = needs(text)
    assert found.cut
    assert by_target(found) == {("a", "zero", ("f1", "f2", "f3"))}


def test_without_functions_there_is_nothing_to_find():
    assert needs("states: [a]\nA: [[0]]\nH: [[1]]\n").reason == "no function of time is left open"


@pytest.fixture(scope="module")
def straight():
    model = load(Path(__file__).parents[2] / "models/rocket/ins_gnss_enu.yaml")
    return next(one for one in model.systems if one.stage == "straight")


def test_roll_needs_normal_and_pitch_axial_specific_force(straight):
    found = by_target(motion_needs(straight))
    assert {(kind, some) for target, kind, some in found if target == "phi_x" and kind == "zero"} == {
        ("zero", ("f_y", "f_z"))
    }
    assert ("phi_z", "zero", ("f_x", "f_y")) in found
    assert not any(target == "phi_x" and "f_x" in some for target, _, some in found)
