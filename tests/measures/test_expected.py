"""What a file expects of measures and requirements, checked by ``obscli verify``."""

import pytest

from obscli.model.reader import read_text
from obscli.pipelines.verify import verify


MODEL = """\
parameters: {{g: 9.8, R: 6378137}}
states: [dv, alpha, domega]
A: [[0, -g, 0], [1/R, 0, 1], [0, 0, 0]]
H: [[1, 0, 0]]
quantities: {{drift: alpha/1000 - domega}}
interval: {{stop: 50}}
{noise}
require: {{domega: {required}}}
expect:
  - {expected}
"""
NOISE = "noise: {R: 1e-4, step: 1, P0_std: [1, 1e-3, 1e-4]}"


def checks(expected, noise=NOISE, required="1e-5"):
    text = MODEL.format(expected=expected, noise=noise, required=required)
    found = verify([read_text(text, "test.yaml")]).results[0].checks
    return [one for one in found if one.place is not None]


@pytest.mark.parametrize(
    ("expected", "verdict", "told"),
    [
        ("measures: {determinant: g^4}", "holds", "measured: 9223.6816"),
        ("measures: {determinant: 1e4}", "fails", "measured: 9223.6816, expected within 1e-6"),
        ("measures: {determinant: {value: 1e4, tolerance: 0.1}}", "holds", ""),
        ("measures: {determinant-log10: {value: 3.96, tolerance: 1e-2}}", "holds", ""),
        ("measures: {pseudo-inverse: {domega: 1/g}}", "holds", ""),
        (
            "measures: {least-squares: {domega: {value: 0.04, tolerance: 0.1}}}",
            "fails",
            "measured: 0.0035748107",
        ),
        ("measures: {stochastic: {alpha: {value: 0.99252013, tolerance: 1e-6}}}", "holds", ""),
        ("measures: {pseudo-inverse: {alpha: inf}}", "fails", "measured: 0.10204082"),
        ("measures: {cond: 2}", "fails", "there is no single value cond of the system"),
        ("measures: {column-norm: {drift: 2}}", "undecided", "column-norm has no value for drift"),
        ("require: met", "holds", "standard deviation"),
        ("require: {domega: missed}", "fails", "at most 1e-5 asked for"),
    ],
)
def test_a_value_holds_or_fails(expected, verdict, told):
    [found] = checks(expected)
    assert found.verdict == verdict
    assert told in found.reason


def test_a_requirement_may_be_expected_to_be_missed():
    [found] = checks("require: missed", required="1e-9")
    assert (found.verdict, found.claim) == ("holds", "the accuracy of domega is missed")


def test_without_noise_what_rests_on_it_is_undecided():
    texts = ("measures: {stochastic: {alpha: 1}}", "require: met")
    found = [one for text in texts for one in checks(text, noise="title: quiet")]
    assert [one.verdict for one in found] == ["undecided", "undecided"]
    assert "no `noise`" in found[0].reason


def test_at_other_values_measures_are_those_there():
    [found] = checks("{at: {g: 2}, measures: {determinant: 16}}")
    assert found.verdict == "holds"
