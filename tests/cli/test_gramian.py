"""The Gramian in ``obscli analyze`` and ``obscli verify``: its options, its keys in JSON, its figures."""

import json
import re
from pathlib import Path

import pytest


MISTYPED = """\
title: A turntable with one coefficient mistyped in the claims
parameters: {g: 9.81, omega: 0.1}
states: [tilt, bias, drift, scale]
dynamics: {tilt: drift + omega*scale}
measurements: {y: g*tilt - bias}
claims:
  - basis: [g*tilt - bias, drift + 2*omega*scale]
"""


@pytest.fixture(autouse=True)
def wide(monkeypatch):
    """Lines that are not broken."""
    monkeypatch.setenv("COLUMNS", "240")


def told(obscli, *arguments, status=0):
    outcome = obscli(*arguments)
    assert (outcome.status, outcome.err) == (status, "")
    return outcome.out


def results(obscli, *arguments):
    return json.loads(told(obscli, "analyze", *arguments, "--format", "json"))["results"]


def instants(result):
    return [point["t"] for point in result["numeric"]["points"]]


def test_analyze_keeps_its_contract(obscli, stages):
    for result in results(obscli, stages):
        numeric, verification = result["numeric"], result["verification"]
        assert numeric.keys() >= {"method", "scaling", "tolerance", "points"}
        assert (numeric["method"], numeric["scaling"]) == ("square-root", "automatic")
        assert len(numeric["points"]) == 150
        for point in numeric["points"]:
            assert point.keys() >= {"t", "rank", "gap", "singular_values"}
            assert len(point["singular_values"]) == result["n"]
        assert verification.keys() >= {"verdict", "points", "combinations", "diagnosis"}
        assert verification["verdict"] == "verified"
        for point in verification["points"]:
            assert point.keys() >= {"t", "r", "q", "chi"}
            assert point["r"] + point["q"] == result["n"]
        for one in verification["combinations"]:
            assert one.keys() >= {"expression", "chi", "holds", "correction"}
            assert one["holds"] is True


def test_verify_keeps_its_contract(obscli, stages):
    data = json.loads(told(obscli, "verify", stages, "--claim", "tilt", "--format", "json", status=1))

    assert {"checks", "failed", "undecided"} <= data.keys()
    assert all({"model", "stage", "claim", "verdict", "reason"} <= one.keys() for one in data["checks"])
    failed = [one for one in data["checks"] if one["verdict"] == "fails"]
    assert len(failed) == data["failed"] > 0
    assert {one["claim"] for one in failed} == {"tilt is observable"}


def test_the_verdict_in_one_sentence(obscli, stages):
    out = told(obscli, "analyze", stages, "--stage", "turning")

    assert (
        "proved exactly (generic): rank 2; at your values 2; the Gramian agrees at 150 of 150 instants" in out
    )


def test_a_mistyped_coefficient_is_named_with_what_it_should_be(obscli, tmp_path):
    file = tmp_path / "mistyped.yaml"
    file.write_text(MISTYPED)

    out = " ".join(told(obscli, "verify", file, status=1).split())

    assert "drift + 2*omega*scale is not observable" in out
    assert "the Gramian denies it" in out
    assert "has 1 where drift needs 2, or has 2*omega where scale needs omega" in out
    assert "nearest observable combinations: 2*drift + 2*omega*scale, or drift + omega*scale" in out
    assert "outputs alike to" in out
    assert f"({file}:7:" in out


def test_another_form_of_the_same_basis_is_equivalent(obscli, tmp_path):
    file = tmp_path / "equivalent.yaml"
    rows = "[g*tilt - bias + cos(omega*t)*(drift + omega*scale), 3*drift + 3*omega*scale]"
    file.write_text(MISTYPED.replace("[g*tilt - bias, drift + 2*omega*scale]", rows))

    assert "equivalent" in told(obscli, "verify", file)
    details = told(obscli, "verify", file, "--details")
    assert "s1 + cos(omega*t)*s2\n" in details
    assert "3*s2\n" in details


def test_a_forgotten_row_is_named(obscli, tmp_path):
    file = tmp_path / "forgotten.yaml"
    file.write_text(MISTYPED.replace(", drift + 2*omega*scale", ""))

    out = " ".join(told(obscli, "verify", file, status=1).split())

    assert "1 forgotten, for example drift + omega*scale" in out
    assert "a combination was forgotten" in out


def test_a_superfluous_row_is_named(obscli, tmp_path):
    file = tmp_path / "superfluous.yaml"
    file.write_text(MISTYPED.replace("2*omega*scale", "omega*scale, scale"))

    out = " ".join(told(obscli, "verify", file, status=1).split())

    assert "scale is not observable" in out
    assert "r + q > n (5 > 4) at all times: certainly an error" in out


def test_values_on_a_critical_condition_are_explained(obscli, stages):
    [result] = results(obscli, stages, "--stage", "turning", "--set", "w=0")

    assert (result["analytic"]["rank"], result["analytic"]["at_values"]["rank"]) == (2, 1)
    assert result["numeric"]["points"][0]["rank"] == 1
    assert result["verification"]["verdict"] == "verified"


def test_interval_and_samples(obscli, stages):
    [result] = results(
        obscli, stages, "--stage", "turning", "--from", "1", "--to", "1 + 2*pi/w", "--samples", 4
    )

    assert instants(result) == pytest.approx([1 + 5 * 3.141592653589793 * k for k in (1, 2, 3, 4)])


def test_times(obscli, stages):
    [result] = results(obscli, stages, "--stage", "turning", "--times", "3, 1/w", "--times", "2")

    assert instants(result) == [2, 3, 10]


def test_the_interval_of_the_file(obscli, stages):
    stages.write_text(stages.read_text() + "interval: {start: 1, stop: 3, samples: 2}\n")

    assert instants(results(obscli, stages, "--stage", "turning")[0]) == [2, 3]
    assert instants(results(obscli, stages, "--stage", "turning", "--to", "9")[0]) == [5, 9]


@pytest.mark.parametrize("method", ["square-root", "lyapunov", "quadrature"])
def test_methods(obscli, stages, method):
    [result] = results(obscli, stages, "--stage", "turning", "--gramian", method, "--rtol", "1e-9")

    assert result["numeric"]["method"] == method
    assert result["numeric"]["rtol"] == 1e-9
    assert result["verification"]["verdict"] == "verified"


def test_scalings(obscli, stages):
    stages.write_text(
        stages.read_text()
        .replace("states: [tilt, bias, drift]", "states: {tilt: 1, bias: 1, drift: {scale: 3}}")
        .replace("quantities:", "noise: {P0_std: {tilt: 1, bias: 0.5, drift: 2}}\nquantities:")
    )

    def ratio(scaling):
        [result] = results(obscli, stages, "--stage", "turning", "--scaling", scaling)
        assert result["numeric"]["scaling"] == scaling
        assert {point["rank"] for point in result["numeric"]["points"]} == {2}
        values = result["numeric"]["points"][-1]["singular_values"]
        return values[1] / values[0]

    assert len({ratio(scaling) for scaling in ("automatic", "prior", "none")}) == 3


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--from", "5", "--to", "2"], "the interval stops at 2, not after its start 5"),
        (["--to", "w - w"], "the interval stops at 0, not after its start 0"),
        (["--times", "1,-3"], "the instant -3 is not after the start 0"),
        (["--times", "1,two"], "--times:1:1: unknown name 'two'"),
        (["--to", "tilt"], "--to:1:1:"),
        (["--times", "1", "--samples", "5"], "leave out --to and --samples"),
        (["--times", "1", "--to", "5"], "leave out --to and --samples"),
        (["--samples", "0"], "greater than or equal to 1"),
        (["--rtol", "2"], "2 is no step error"),
        (["--gramian", "square"], "square-root, lyapunov, quadrature"),
        (["--scaling", "unit"], "automatic, scale, prior, none"),
        (["--scaling", "prior"], "`P0_std` under `noise`; missing for tilt, bias, drift"),
        (["--scaling", "scale"], "`scale` of the states; missing for tilt, bias, drift"),
    ],
)
@pytest.mark.parametrize("command", ["analyze", "verify"])
def test_what_cannot_be_done_is_refused(obscli, stages, command, options, message):
    outcome = obscli(command, stages, "--stage", "turning", *options)

    assert (outcome.status, outcome.out) == (2, "")
    assert message in outcome.err


@pytest.mark.parametrize("option", [["--from", "1"], ["--plot", "figures"], ["--gramian", "lyapunov"]])
def test_no_gramian_no_options_about_it(obscli, stages, option):
    outcome = obscli("analyze", stages, "--only", "analytic", *option)

    assert (outcome.status, outcome.out) == (2, "")
    assert "leave out --plot and what is about the Gramian" in outcome.err


@pytest.mark.parametrize("command", ["analyze", "verify"])
def test_parameters_without_value_are_asked_for(obscli, stages, command):
    stages.write_text(stages.read_text().replace("g: 9.81", "g: {}"))

    out = " ".join(told(obscli, command, stages, "--stage", "turning").split())

    assert "parameter without a value: g; give it in the file or with --set g=…" in out
    assert obscli(command, stages, "--stage", "turning", "--strict").status == 4
    assert obscli(command, stages, "--stage", "turning", "--strict", "--set", "g=10").status == 0


def test_values_given_to_verify_are_those_of_the_gramian(obscli, stages):
    def denial(g):
        given = ("verify", stages, "--stage", "turning", "--claim", "tilt", "--set", f"g={g}")
        return re.search(r"denies it: χ = (\S+),", told(obscli, *given, status=1))[1]

    assert denial("0.1") != denial("10")


def test_numeric_alone_guesses_forms(obscli, stages):
    out = told(obscli, "analyze", stages, "--stage", "turning", "--only", "numeric")

    assert "guess" in out
    assert "proved exactly" not in out


def test_numeric_alone_takes_systems_too_opaque_for_algebra(obscli, stages):
    """Nothing exact is done, so that nothing can be undecided there."""
    text = stages.read_text().replace("w*k*drift", "w*k*drift*exp(sin(tanh(t)))")
    stages.write_text(text)

    [result] = results(obscli, stages, "--stage", "turning", "--only", "numeric")

    assert result["analytic"] is None
    assert {point["rank"] for point in result["numeric"]["points"]} == {2}


def test_figures_of_analyze(obscli, stages, tmp_path):
    outcome = obscli("analyze", stages, "--stage", "turning", "--plot", tmp_path / "deep" / "figures")
    assert outcome.status == 0

    files = {path.name for path in (tmp_path / "deep" / "figures").iterdir()}
    kinds = {Path(name).stem.removeprefix("stages_turning-") for name in files}
    assert files == {f"stages_turning-{kind}.{ending}" for kind in kinds for ending in ("svg", "png")}
    assert kinds >= {"chi", "singular-values"}


def test_figures_of_verify_show_the_claim(obscli, stages, tmp_path):
    stages.write_text(stages.read_text() + "claims:\n  - {stage: turning, basis: [g*tilt + bias, drift]}\n")

    assert obscli("verify", stages, "--stage", "turning", "--plot", tmp_path / "f").status == 1

    files = {path.name for path in (tmp_path / "f").iterdir()}
    assert files == {f"stages_turning{of}-chi.{form}" for of in ("", "-claim-1") for form in ("svg", "png")}


def test_a_directory_that_cannot_be_made(obscli, stages):
    outcome = obscli("analyze", stages, "--plot", stages)

    assert outcome.status == 2
    assert "--plot" in outcome.err
