"""``outputs``: when outputs are sampled, and how that follows a system through everything made of it."""

import pytest

from obscli.core.place import ModelError
from obscli.model.dual import dual
from obscli.model.expression import Symbol, number
from obscli.model.frozen import frozen_at
from obscli.model.measured import with_output
from obscli.model.notation import to_text
from obscli.model.reader import read_text
from obscli.model.specialise import Specialisation, at_nominal
from obscli.model.used import without_unused


MODEL = """\
parameters: {f_s: 10, T: 60, g: 9.8}
let: {gap: T/2}
states: {x: 2, v: 2}
dynamics: {x: v}
inputs: [u]
B: {v1: {u: 1}}
measurements: {gnss: x, speed: v1, tilt: g*v2}
outputs:
  gnss: {unit: m, every: 1/f_s, during: [[0, T], [T + gap, 400]]}
  gnss2: {every: 2}
  speed: {during: [[-1, 0], [0, pi]]}
"""


def base(text=MODEL, **options):
    return read_text(text, "test.yaml", **options).systems[0]


def sampling(system):
    """Return, by output, the time between samples and the intervals, as text."""
    return {
        one.name: (
            None if one.every is None else to_text(one.every),
            None if one.during is None else [tuple(map(to_text, span)) for span in one.during],
        )
        for one in system.outputs
    }


ALONG = [("0", "T"), ("T + T/2", "400")]
EXPECTED = {
    "gnss1": ("1/f_s", ALONG),
    "gnss2": ("2", ALONG),
    "speed": (None, [("-1", "0"), ("0", "pi")]),
    "tilt": (None, None),
}


def test_what_is_said_of_a_component_goes_before_what_is_said_of_its_vector():
    system = base()
    assert sampling(system) == EXPECTED
    assert [one.unit for one in system.outputs] == ["m", "m", "", ""]


@pytest.mark.parametrize(
    "lines",
    [
        "H: [[1, 0], [0, 1]]\noutputs: {y: {every: 2, during: [[0, 1]]}, y1: {every: 3}}",
        "H: {y1: {x1: 1}, y2: {x2: 1}}\noutputs: {y1: {every: 3, during: [[0, 1]]}, y2: {every: 2, during: [[0, 1]]}}",
        "measurements: {y: x}\noutputs: {y: {every: 2, during: [[0, 1]]}, y1: {every: 3}}",
        "H: eye(2)\noutputs: {y1: {every: 3, during: [[0, 1]]}, y2: {every: 2, during: [[0, 1]]}}",
    ],
)
def test_outputs_may_be_named_in_any_way(lines):
    system = base(f"states: {{x: 2}}\ndynamics: {{}}\n{lines}\n")
    assert sampling(system) == {"y1": ("3", [("0", "1")]), "y2": ("2", [("0", "1")])}


def test_a_stage_replaces_what_it_says_and_keeps_the_rest():
    stages = (
        "stages:\n"
        "  lost: {outputs: {gnss: {during: [[0, 1]]}}}\n"
        "  fast: {outputs: {gnss: {every: 1/2}, tilt: {every: 3}}}\n"
        "  other: {let: {gap: 1}, fix: {f_s: 4*g}}\n"
    )
    lost, fast, other = (sampling(one) for one in read_text(MODEL + stages, "test.yaml").systems[1:])
    assert lost == {**EXPECTED, "gnss1": ("1/f_s", [("0", "1")]), "gnss2": ("2", [("0", "1")])}
    assert fast == {**EXPECTED, "gnss1": ("1/2", ALONG), "tilt": ("3", None)}
    assert other["gnss1"] == ("1/(4*g)", [("0", "T"), ("1 + T", "400")])


def test_what_is_fixed_is_replaced():
    fixed = sampling(base(fix={"f_s": "g", "T": "20"}))
    assert fixed == {
        **EXPECTED, "gnss1": ("1/g", [("0", "20"), ("30", "400")]), "gnss2": ("2", [("0", "20"), ("30", "400")])
    }  # fmt: skip
    there = Specialisation(base(), {"f_s": Symbol("g"), "T": number(20)}).system()
    assert sampling(there) == fixed
    assert sampling(at_nominal(base()).system())["gnss1"] == ("1/10", [("0", "60"), ("90", "400")])


def test_values_given_from_outside_are_judged_too():
    with pytest.raises(ModelError, match=r"gnss\.every: a positive time is expected here"):
        base(settings={"f_s": "-1"})
    with pytest.raises(ModelError, match=r"gnss\.during\[2\]: the interval does not stop after its start"):
        base(settings={"T": "300"})
    assert sampling(base(settings={"f_s": "20"})) == EXPECTED  # nominal: the expression stays


def test_only_what_can_be_compared_is_judged():
    system = base(MODEL.replace("T: 60", "T: ").replace("every: 2", "every: exp(-3) - 1"))
    assert sampling(system)["gnss1"] == ("1/f_s", ALONG)


def test_systems_made_of_a_system_keep_its_sampling():
    system = base()
    assert sampling(frozen_at(system, number(3))) == EXPECTED
    assert sampling(with_output(system, {"x1": number(1)}, "more")) == {**EXPECTED, "more": (None, None)}
    assert sampling(without_unused(system)) == EXPECTED
    assert {one.name for one in without_unused(system).parameters} == {"f_s", "T", "g"}
    assert sampling(dual(system)) == {"u": (None, None)}  # its outputs are others


def test_of_the_outputs_kept_the_sampling_is_kept():
    assert sampling(base(outputs=["gnss2", "tilt"])) == {name: EXPECTED[name] for name in ("gnss2", "tilt")}
    assert sampling(base(without=["x1"])) == EXPECTED


def test_a_run_has_the_sampling_of_its_stage():
    text = MODEL + (
        "stages: {lost: {outputs: {gnss: {every: f_s}}}}\n"
        "experiment: {runs: [lost, {stage: lost, fix: {f_s: 3*g}}]}\n"
    )
    runs = read_text(text, "test.yaml").experiment.runs
    assert [sampling(run.system)["gnss1"][0] for run in runs] == ["f_s", "3*g"]


def test_outputs_with_outages_are_named_a_vector_as_a_whole():
    assert base().interrupted == ("gnss", "speed")
    assert base(MODEL.replace("gnss: {unit: m, every: 1/f_s, during", "gnss1: {during")).interrupted == (
        "gnss1", "speed",
    )  # fmt: skip
    alone = "states: [x]\nA: [[0]]\nH: {gnss: {x: 1}}\noutputs: {gnss: {every: 1, during: [[0, 1]]}}\n"
    assert base(alone).interrupted == ("gnss",)
    assert base(alone.replace(", during: [[0, 1]]", "")).interrupted == ()
