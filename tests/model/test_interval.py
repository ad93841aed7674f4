"""``interval`` and the initial deviations in ``noise``: their values, and what is wrong, word for word."""

import math

import pytest

from obscli.core.place import ModelError
from obscli.model.notation import to_text
from obscli.model.reader import read_text
from obscli.model.specialise import at_nominal


MODEL = """\
states: {psi: 2, b: 1}
parameters: {w: 1/2, s: 3}
let: {period: 2*pi/w}
dynamics: {psi1: b}
measurements: {y: psi}
"""


def systems(*lines):
    return read_text(MODEL + "\n".join(lines), "model.yaml").systems


def interval(text):
    return systems(f"interval: {text}")[0].interval


def problems(*lines):
    with pytest.raises(ModelError) as caught:
        systems(*lines)
    return [str(problem).splitlines()[0] for problem in caught.value.problems]


@pytest.mark.parametrize(
    ("text", "start", "stop", "samples"),
    [
        ("{start: 0, stop: 600, samples: 200}", "0", "600", 200),
        ("{stop: 10}", None, "10", None),
        ("{start: -1/2}", "-1/2", None, None),
        ("{samples: 7}", None, None, 7),
        ("{start: w, stop: 3*period}", "w", "6*pi/w", None),
        ("{stop: 1e3}", None, "1000", None),
        ("{}", None, None, None),
    ],
)
def test_an_interval(text, start, stop, samples):
    found = interval(text)

    assert [None if end is None else to_text(end) for end in (found.start, found.stop)] == [start, stop]
    assert found.samples == samples
    assert (found.place.file, found.place.line) == ("model.yaml", 6)


def test_no_interval():
    assert systems()[0].interval is None
    empty = interval("")
    assert (empty.start, empty.stop, empty.samples) == (None, None, None)


def test_each_stage_replaces_what_it_names(number):
    one, two, three = systems(
        "interval: {start: w, stop: 10, samples: 5}",
        "stages: {one: {}, two: {interval: {stop: 20}}, three: {parameters: {w: 4}}}",
    )

    assert [(s.interval.samples, to_text(s.interval.stop)) for s in (one, two, three)] == [
        (5, "10"),
        (5, "20"),
        (5, "10"),
    ]
    starts = [number(at_nominal(system).system().interval.start, {}) for system in (one, two, three)]
    assert starts == [0.5, 0.5, 4.0]


def test_values_put_in_are_put_into_the_interval(number):
    there = at_nominal(systems("interval: {start: w, stop: period}")[0]).system().interval

    assert number(there.start, {}) == 0.5
    assert number(there.stop, {}) == pytest.approx(4 * math.pi)


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("5", "model.yaml:6:11: interval: a mapping of names to values is expected here, not a text"),
        ("{stpo: 5}", "model.yaml:6:12: interval: unknown key 'stpo'; did you mean 'stop'?"),
        ("{stop: }", "model.yaml:6:18: interval.stop: an expression is missing here"),
        ("{stop: 2*}", "model.yaml:6:20: interval.stop: the expression ends where a value is expected"),
        ("{stop: wx}", "model.yaml:6:18: interval.stop: unknown name 'wx'; did you mean 'w'?"),
        (
            "{samples: 0}",
            "model.yaml:6:21: interval.samples: a whole number from 1 to 10000000 is expected here, not '0'",
        ),
        (
            "{samples: 2.5}",
            (
                "model.yaml:6:21: interval.samples: a whole number from 1 to 10000000 is expected "
                "here, not '2.5'"
            ),
        ),
        ("{stop: '[1, 2]'}", "model.yaml:6:19: interval.stop: a scalar is expected here, not a vector of 2"),
        ("{stop: b}", "model.yaml:6:18: interval.stop: 'b' is a state and has no place here"),
    ],
)
def test_what_is_wrong_with_an_interval(text, problem):
    assert problems(f"interval: {text}") == [problem]


@pytest.mark.parametrize(
    ("noise", "deviations"),
    [
        ("{P0_std: 2}", {"psi1": 2, "psi2": 2, "b": 2}),
        ("{P0: 4}", {"psi1": 2, "psi2": 2, "b": 2}),
        ("{P0_std: [1, 2, 3]}", {"psi1": 1, "psi2": 2, "b": 3}),
        ("{P0: [1, 4, s]}", {"psi1": 1, "psi2": 2, "b": math.sqrt(3)}),
        ("{P0: '[[1, 9, 9], [9, 4, 9], [9, 9, 16]]'}", {"psi1": 1, "psi2": 2, "b": 4}),
        ("{P0_std: {psi: 5*w, b: 1}}", {"psi1": 2.5, "psi2": 2.5, "b": 1}),
        ("{P0_std: {psi: [1, 2]}}", {"psi1": 1, "psi2": 2}),
        ("{P0_std: {psi2: 1/4}}", {"psi2": 0.25}),
        ("{P0: {b: 1/16}}", {"b": 0.25}),
        ("{R: 1}", {}),
        ("{}", {}),
    ],
)
def test_initial_deviations(number, noise, deviations):
    prior = systems(f"noise: {noise}")[0].prior

    assert {name: number(value, {"w": 0.5, "s": 3.0}) for name, value in prior.items()} == deviations


@pytest.mark.parametrize(
    ("noise", "deviation"),
    [
        ("{P0_std: 5*pi/180}", "pi/36"),
        ("{P0_std: 0.01}", "1/100"),
        ("{P0: 9/4}", "3/2"),
        ("{P0: 2}", "sqrt(2)"),
        ("{P0: w^2}", "sqrt(w**2)"),
    ],
)
def test_roots_are_taken_where_they_are_exact(noise, deviation):
    assert to_text(systems(f"noise: {noise}")[0].prior["b"]) == deviation


def test_no_noise_no_deviations():
    assert systems()[0].prior == {}


def test_variances_are_the_squares_of_deviations(number):
    values = {"w": 0.5, "s": 3.0}
    by_std, by_variance = (
        systems(f"noise: {{{key}: [{entries}]}}")[0].prior
        for key, entries in (("P0_std", "w, 2*s, 5"), ("P0", "w^2, 4*s^2, 25"))
    )

    assert {s: number(e, values) for s, e in by_std.items()} == {
        s: pytest.approx(number(e, values)) for s, e in by_variance.items()
    }


def test_a_stage_has_its_own_deviations(number):
    found = systems(
        "noise: {P0_std: 1}", "stages: {one: {}, two: {noise: {P0_std: s}}, three: {parameters: {s: 4}}}"
    )

    assert [number(at_nominal(s).system().prior["b"], {}) for s in found] == [1, 3, 1]


@pytest.mark.parametrize(
    ("noise", "problem"),
    [
        ("{P0: 1, P0_std: 1}", "model.yaml:6:16: noise: `P0` and `P0_std` are both given; one of the two"),
        (
            "{P0_std: [1, 2]}",
            (
                "model.yaml:6:17: noise.P0_std: a scalar, a list of 3 (the diagonal) or a 3×3 matrix is "
                "expected here, not a vector of 2"
            ),
        ),
        (
            "{P0_std: {psy: 1}}",
            "model.yaml:6:18: noise.P0_std: 'psy' is none of the names expected here; did you mean 'psi'?",
        ),
        ("{P0_std: {psi: }}", "model.yaml:6:23: noise.P0_std.psi: an expression is missing here"),
    ],
)
def test_what_is_wrong_with_deviations(noise, problem):
    assert problems(f"noise: {noise}") == [problem]
