"""Every command on recorded signals: what it says of them, or why it does not take them."""

import json

import numpy as np
import pytest


#: No force along the track and a constant heading: heading error and lever arm leave no trace, 2 of 4.
LEVEL = """\
title: level flight along a line, position fixes, lever arm
states: [phi, dv, dp, l]
signals:
  file: flight.csv
  time: {column: t_ms, factor: 1e-3, zero: first}
  columns: {f: fx, yaw: {column: hdg, factor: pi/180, unwrap: 360}}
dynamics: {phi: 0, dv: f*phi, dp: dv}
measurements: {y: dp + cos(yaw)*l}
"""
NOISE = "noise: {signals: {f: 0.05, yaw: 0.002}, R: 1, step: 1, P0_std: {phi: 0.1, dv: 1, dp: 10, l: 1}}\n"


@pytest.fixture
def flight(tmp_path):
    """Write the model, with more text, and a minute of level flight with noise; return its path."""

    def write(more="", text=LEVEL):
        t, rng = np.arange(0, 60.01, 0.4), np.random.default_rng(3)
        record = np.column_stack(
            [0.05 * rng.standard_normal(len(t)), 359.99 + 0.1 * rng.standard_normal(len(t))]
        )
        record[:, 1] %= 360
        header = "t_ms,fx,hdg"
        rows = np.column_stack([5000 + 1000 * t, record])
        np.savetxt(tmp_path / "flight.csv", rows, delimiter=",", header=header, comments="", fmt="%.12g")
        (tmp_path / "m.yaml").write_text(text + more)
        return tmp_path / "m.yaml"

    return write


def analyzed(obscli, *arguments):
    found = obscli("analyze", *arguments, "--format", "json")
    return json.loads(found.out)["results"][0]


def test_what_comes_from_noise_is_not_excited(obscli, flight):
    found = analyzed(obscli, flight(NOISE), "--samples", 5)
    signals = found["numeric"]["signals"]
    assert found["analytic"]["rank"] == found["numeric"]["rank"] == 4
    assert (signals["shown"], signals["excited"], signals["exact"]) == (4, 2, False)
    assert found["numeric"]["interval"] == {"start": 0.0, "default": True}
    states = found["numeric"]["states"]
    assert {name for name, own in states.items() if own == "not excited"} == set(signals["not_excited"])
    assert set(signals["not_excited"]) == {"phi", "dp", "l"}


def test_the_verdict_says_what_the_record_excites(obscli, flight):
    text = " ".join(obscli("analyze", flight(NOISE), "--samples", 5).out.split())
    assert "at generic values of the signals" in text
    assert "this record excites 2 of 4 directions: the Gramian shows 4" in text
    assert "all that the files of signals cover" in text


def test_without_noise_signals_are_taken_as_exact(obscli, flight):
    text = " ".join(obscli("analyze", flight(), "--samples", 5).out.split())
    assert "signals taken as exact" in text
    assert "noise of the signals alone would" not in text


def test_a_clean_record_below_the_generic_rank_is_no_contradiction(obscli, flight, tmp_path):
    path = flight(NOISE)
    (tmp_path / "flight.csv").write_text("t_ms,fx,hdg\n" + "".join(f"{k},0,0.5\n" for k in range(9)))
    found = analyzed(obscli, path, "--samples", 5)
    assert (found["analytic"]["rank"], found["numeric"]["rank"]) == (4, 2)
    assert found["verification"]["verdict"] == "not excited"
    assert found["numeric"]["signals"]["excited"] == 2


def test_an_interval_beyond_the_samples_is_refused_with_what_there_is(obscli, flight):
    found = obscli("analyze", flight(), "--to", 100)
    assert found.status == 2
    assert "flight.csv from 0 to 60: choose one within 0 to 60" in found.err


@pytest.mark.parametrize("command", ["measures", "simulate"])
def test_commands_with_noise_say_that_signals_are_taken_as_exact(obscli, flight, command):
    found = obscli(command, flight(NOISE))
    assert found.status == 0, found.err
    assert "signals taken as exact: f, yaw" in " ".join(found.out.split())


def test_measures_at_one_instant_say_why_they_are_not_taken(obscli, flight):
    text = " ".join(obscli("measures", flight(NOISE)).out.split())
    assert "samples of a signal do not tell them" in text


def test_simulate_covers_the_record(obscli, flight):
    found = json.loads(obscli("simulate", flight(NOISE), "--format", "json").out)["results"][0]["simulate"]
    assert found["interval"]["start"] == 0
    assert found["interval"]["stop"] == pytest.approx(60)
    assert found["signals"] == ["f", "yaw"]


def test_claims_are_checked_at_generic_signals(obscli, flight):
    found = obscli("verify", flight(NOISE + "claims: [{rank: 4, observable: [phi]}]\n"))
    assert found.status == 0, found.out
    assert obscli("verify", flight("claims: [{rank: 3}]\n")).status == 1


def test_a_transformed_model_keeps_its_signals(obscli, flight, tmp_path):
    (tmp_path / "made").mkdir()
    made = tmp_path / "made" / "t.yaml"
    assert obscli("transform", flight(NOISE), "--to", "observable", "-o", made).status == 0
    found = analyzed(obscli, made, "--samples", 5)
    assert found["numeric"]["signals"]["excited"] == 2


def test_runs_of_an_experiment_have_records_of_their_own(obscli, flight, tmp_path):
    more = NOISE + "experiment: {runs: [one, two]}\nstages: {one: {}, two: {signals: {file: other.csv}}}\n"
    path = flight(more)
    (tmp_path / "other.csv").write_text((tmp_path / "flight.csv").read_text())
    found = obscli("calibrate", path, "--no-critical")
    assert found.status == 0, found.err
    assert "2 runs determine" in " ".join(found.out.split())


def test_a_signal_can_be_fixed(obscli, flight):
    found = analyzed(obscli, flight(NOISE), "--samples", 5, "--fix", "f=0", "--only", "numeric")
    assert found["numeric"]["signals"]["noise"] == {"yaw": 0.002}


def test_the_dual_and_the_frozen_system(obscli, flight):
    driven = LEVEL.replace("dp: dv", "dp: dv + u")
    assert obscli("analyze", flight("inputs: [u]\n", driven), "--dual", "--samples", 3).status == 0
    assert obscli("analyze", flight(NOISE), "--frozen-at", 3, "--samples", 3).status == 0


def test_why(obscli, flight):
    assert obscli("why", flight(NOISE), "phi").status == 0


def test_the_combinations_of_the_gramian_say_that_noise_is_among_them(obscli, flight):
    words = "what noise of the signals alone would show is among them"
    for noise, told in ((NOISE, True), ("", False)):
        outcome = obscli("analyze", flight(noise), "--samples", 5, "--only", "numeric")
        assert (words in " ".join(outcome.out.split())) is told


def test_segments_and_windows_say_that_signals_are_taken_as_exact(obscli, flight):
    more = (
        NOISE + "stages: {a: {}}\nsegments: [{stage: a, duration: 20}, {stage: a, name: b, duration: 20}]\n"
    )
    file = flight(more)
    out = " ".join(obscli("analyze", file, "--segments").out.split())
    assert "signals taken as exact: f, yaw" in out
    assert "is given by samples, and a proof at the file's values needs an expression" in out
    assert "signals taken as exact: f, yaw" in obscli("measures", file, "--window", 5, "--step", 5).out
    planned = obscli("plan", file, "--segments")
    assert planned.status == 2
    assert "is given by samples" in " ".join(planned.err.split())
