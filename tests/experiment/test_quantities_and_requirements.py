"""Quantities of an experiment are those of the file; requirements, priors and setting up need values."""

import pytest

from obscli.core.place import ModelError
from obscli.pipelines.request import CalibrateRequest, NumericRequest, RequestError


TURNED = """\
parameters: {w: 2}
states: [b, m]
dynamics: {}
measurements: {y: b + w*m}
noise: {R: 1, P0_std: {b: 10, m: 10}}
quantities: {q: b + w*m, r: b - w*m}
interval: {stop: 100}
require: {q: 1, r: 1}
experiment:
  name: e
  runs: [{name: back, fix: {w: -w}}]
"""


def test_quantities_are_those_of_the_file_not_of_a_run_that_fixes_their_parameters(calibrated):
    """The only run turns the other way: it sees b - w*m, which is r of the file."""
    found = calibrated(TURNED)

    assert {one.name: one.verdict for one in found.exact.stack.finding.quantities} == {
        "q": "coupled",
        "r": "observable",
    }
    required = {one.name: one for one in found.accuracy.required}
    assert required["r"].after == pytest.approx(0.1, rel=1e-3)
    assert required["q"].after > 10
    assert (required["q"].is_met, required["r"].is_met) == (False, True)
    assert found.failed == 1


def test_a_quantity_by_a_parameter_that_every_run_fixes_keeps_its_value(calibrated):
    """What a quantity means does not depend on which values the runs put in."""
    runs = "runs: [{name: one, fix: {w: 1}}, {name: three, fix: {w: 3}}]"
    found = calibrated(TURNED.replace("runs: [{name: back, fix: {w: -w}}]", runs))
    required = {one.name: one for one in found.accuracy.required}
    # b + m and b + 3m at 0.01 each: q = b + 2m is half their sum, r = b - 2m is 5/2 of the one less 3/2
    assert required["q"].after == pytest.approx((2 * 0.01 / 4) ** 0.5, rel=1e-3)
    assert required["r"].after == pytest.approx((0.01 * (2.5**2 + 1.5**2)) ** 0.5, rel=1e-3)


NO_VALUE = """\
parameters: {s: null}
states: [a]
dynamics: {}
measurements: {y: a}
noise: {R: 1, P0_std: {a: 1}}
interval: {stop: 100}
"""
RUN = "experiment: {runs: [{name: one}]}\n"


def test_a_requirement_without_a_value_stays_open(calibrated, planned):
    text = NO_VALUE + "require: {a: s}\n" + RUN
    for found in (calibrated(text), planned(text)):
        assert found.accuracy is None
        assert found.undecided
        assert not found.failed
    assert "s" in calibrated(text).no_accuracy
    assert calibrated(text, settings={"s": "0.2"}).accuracy.required[0].is_met
    assert not calibrated(text, settings={"s": "0.05"}).accuracy.required[0].is_met


def test_a_time_to_set_up_without_a_value_is_refused(planned):
    text = NO_VALUE + "plan: {setup_time: s}\n" + RUN
    with pytest.raises(RequestError, match="value: s"):
        planned(text)
    assert planned(text, settings={"s": "7"}).plan.setup_time == 7


@pytest.mark.parametrize("given", ["-1", "0 - 2"])
def test_a_time_to_set_up_is_not_negative(planned, given):
    text = NO_VALUE.replace("s: null", "s: 1") + "plan: {setup_time: s}\n" + RUN
    with pytest.raises(ModelError, match=r"plan\.setup_time: a time is expected here"):
        planned(text, settings={"s": given})


def test_noise_without_a_value_stays_open(calibrated):
    text = NO_VALUE.replace("R: 1", "R: s") + "require: {a: 1}\n" + RUN
    found = calibrated(text)
    assert found.accuracy is None
    assert "s" in found.no_accuracy
    assert found.undecided
    assert calibrated(text, settings={"s": "4"}).accuracy.states[0].after == pytest.approx(
        (1 / (1 + 25)) ** 0.5
    )


MOVING = """\
states: [x, a]
dynamics: {x: a}
measurements: {y: x}
interval: {stop: 100}
"""


def test_what_is_asked_for_and_cannot_be_told_is_open(calibrated, planned):
    """`require` without noise."""
    text = MOVING + "require: {a: 1}\n" + RUN
    for found in (calibrated(text), planned(text)):
        assert found.accuracy is None
        assert found.undecided
    assert "noise" in calibrated(text).no_accuracy


def test_nothing_asked_for_nothing_open(calibrated):
    found = calibrated(MOVING + RUN)
    assert (found.accuracy, found.undecided, found.failed) == (None, 0, 0)


def test_the_priors_are_units_where_all_are_given(model):
    from obscli.api import calibrate

    text = MOVING + "noise: {R: 1, P0_std: {x: 1, a: 3}}\n" + RUN
    request = CalibrateRequest(critical=False, numeric=NumericRequest(scaling="prior"))
    [found] = calibrate(model(text), request=request).results

    assert found.together.scaling == found.runs[0].numeric.scaling == "prior"
    assert found.together.rank == found.exact.rank == 1
    assert {one.verdict for one in found.verifications} == {"verified"}


def test_the_priors_are_no_units_where_one_is_missing(model):
    from obscli.api import calibrate

    text = MOVING + "noise: {R: 1, P0_std: {x: 1}}\n" + RUN
    request = CalibrateRequest(critical=False, numeric=NumericRequest(scaling="prior"))
    with pytest.raises(RequestError, match="missing for a"):
        calibrate(model(text), request=request)


def test_a_requirement_on_what_starts_anew_is_not_judged_and_said_so(calibrated):
    found = calibrated(MOVING + "noise: {R: 1}\nrequire: {x: 1, a: 1}\n" + RUN)
    assert [one.name for one in found.accuracy.required] == ["a"]
    assert any("x" in note and "anew" in note for note in found.accuracy.notes)


def test_what_the_runs_share_is_constant_whatever_drives_it(calibrated):
    """`Q` on a shared state is left out, and said so."""
    still, driven = (
        calibrated(MOVING + f"noise: {{R: 1, P0_std: {{a: 1}}{q}}}\n" + RUN) for q in ("", ", Q: {a: 5}")
    )
    assert driven.accuracy.states[0].after == still.accuracy.states[0].after
    assert still.accuracy.notes == ()
    assert any("Q" in note for note in driven.accuracy.notes)


def test_different_priors_of_the_runs_count_as_that_of_the_first_and_it_is_said_so(calibrated):
    text = """\
states: [a]
dynamics: {}
measurements: {y: a}
noise: {R: 1e6, P0_std: {a: 1}}
interval: {stop: 1}
experiment: {runs: [{name: one}, {name: two, noise: {P0_std: {a: 100}}}]}
"""
    found = calibrated(text)
    assert found.accuracy.states[0].before == 1
    assert any("prior" in note for note in found.accuracy.notes)


def test_a_prior_correlated_with_what_starts_anew_is_left_out_and_it_is_said_so(calibrated):
    P0 = "P0: [[1, 0.5], [0.5, 1]]"
    found = calibrated(MOVING + f"noise: {{R: 1, {P0}}}\n" + RUN)
    plain = calibrated(MOVING + "noise: {R: 1, P0: [[1, 0], [0, 1]]}\n" + RUN)
    assert found.accuracy.states[0].after == pytest.approx(plain.accuracy.states[0].after, rel=1e-12)
    assert any("correlates" in note for note in found.accuracy.notes)
    assert plain.accuracy.notes == ()


@pytest.mark.parametrize(
    ("noise", "message"),
    [
        ("{P0_std: {a: 1}}", "no R"),
        ("{R: 0}", "no R, or zero"),
        ("{R: 1, P0: {a: 0}}", "is zero"),
        ("{R: t}", "only constants"),
        ("{R: 1, P0: [[1, 2], [2, 1]]}", "positive definite"),
    ],
)
def test_noise_that_is_none_is_said_so(calibrated, noise, message):
    found = calibrated(MOVING + f"noise: {noise}\n" + RUN)
    assert found.accuracy is None
    assert message in found.no_accuracy
    assert found.exact.rank == 1


# -- what is infinite, and what is not


def test_a_finite_prior_stays_finite_however_well_a_sum_is_measured(calibrated):
    """y = a + b to 1e-8, priors of 1e6: each part is left at its prior over the root of two."""
    found = calibrated(
        "states: [a, b]\ndynamics: {}\nmeasurements: {y: a + b}\n"
        "noise: {R: 1e-14, P0_std: {a: 1e6, b: 1e6}}\ninterval: {stop: 100}\nrequire: {a: 1e7, b: 7e5}\n"
        + RUN
    )
    for one in found.accuracy.states:
        assert one.after == pytest.approx(1e6 / 2**0.5, rel=1e-6)
    assert [one.is_met for one in found.accuracy.required] == [True, False]


def test_what_is_known_of_a_part_says_nothing_of_a_sum(calibrated):
    """a to 1000, b + c to 1e-7, nothing of b: a + b is not known, whatever the sizes."""
    found = calibrated(
        "states: [a, b, c]\ndynamics: {}\nmeasurements: {y: a, z: b + c}\nnoise: {R: {y: 1e8, z: 1e-12}}\n"
        "interval: {stop: 100}\nquantities: {q: a + b, r: b + c}\nrequire: {q: 2000, r: 1e-6}\n" + RUN
    )
    required = {one.name: one for one in found.accuracy.required}
    assert required["q"].after == float("inf")
    assert not required["q"].is_met
    assert required["r"].after == pytest.approx(1e-7, rel=1e-6)
    assert found.accuracy.states[0].after == pytest.approx(1000, rel=1e-6)
    assert found.failed == 1


def test_what_nothing_sees_is_not_known_beside_what_is_seen_badly(calibrated):
    found = calibrated(
        "states: [a, b, c]\ndynamics: {}\nmeasurements: {y: a - c}\nnoise: {R: 1e14}\ninterval: {stop: 1}\n"
        "quantities: {q: b + c - a, r: a - c}\nrequire: {q: 1e8, r: 1e8}\n" + RUN
    )
    assert [(one.name, one.is_met) for one in found.accuracy.required] == [("q", False), ("r", True)]


def test_a_requirement_that_is_zero_at_the_files_values_is_not_divided_by(planned):
    text = MOVING + "parameters: {w: 0}\nnoise: {R: 1, P0_std: {x: 1, a: 1}}\nrequire: {a: w}\n" + RUN
    assert planned(text).failed
