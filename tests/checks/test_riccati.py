"""The Riccati equation as a witness for verdicts: right ones, wrong ones, and too short an interval."""

from dataclasses import replace

import pytest

from obscli.checks.detectability import exact_detectability
from obscli.checks.riccati import riccati_word
from obscli.exact.analysis import Options, analyze
from obscli.model.reader import read_text
from obscli.numeric.riccati import cross_check


def said(rate, stop, *, verdict=None, coupling="0", start=0):
    """What is said of a hidden state h' = rate h + coupling, and of a wrong verdict on it."""
    text = (
        f"states: [x, h]\ndynamics: {{x: -x, h: ({rate})*h + {coupling}}}\nmeasurements: {{y: x}}\n"
        "noise: {R: 1, P0_std: 1}\n"
    )
    system = read_text(text, "test.yaml").systems[0]
    found = exact_detectability(analyze(system, Options(critical=False)).structure)
    found = found if verdict is None else replace(found, verdict=verdict)
    return riccati_word(found, cross_check(system, start, stop), system)


@pytest.mark.parametrize("coupling", ["0", "x"])
@pytest.mark.parametrize("rate", ["-1", "0", "1/10"])
def test_it_agrees_with_a_right_verdict(rate, coupling):
    assert said(rate, 20, coupling=coupling).word == "agrees"


@pytest.mark.parametrize("stop", [0.5, 5, 50])
def test_it_denies_that_what_dies_out_does_not(stop):
    assert said("-1", stop, verdict="not detectable").word == "denies"


@pytest.mark.parametrize("rate", ["0", "1/10"])
def test_it_never_agrees_that_what_stays_or_grows_dies_out(rate):
    assert said(rate, 30, verdict="detectable").word == "silent"


def test_it_does_not_tell_on_too_short_an_interval_or_of_an_open_verdict():
    assert said("-1", 0.1).word == "silent"
    assert said("-1", 20, verdict="undecided").word == "silent"


def test_an_error_that_shrinks_and_grows_again_is_not_denied():
    """h' = -sin(t) h comes back every 2 pi: closer meanwhile, which says nothing."""
    found = said("-sin(t)", 3, verdict="not detectable")
    assert found.word == "silent"
    assert "does not tell" in found.words
