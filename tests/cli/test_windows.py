"""``obscli measures --window``: tables, warnings, JSON, figures, what is refused."""

import json

import numpy as np
import pytest


TURNING = """\
functions: {f: {}}
states: {a: {unit: m}, b: {unit: m/s}, c: {}}
A: [[0, 1, 0], [0, 0, 0], [0, 0, 0]]
H: [[1, 0, 0], [0, 0, 1 + 0*t]]
quantities: {both: a + 0.1*b}
noise: {R: [0.01, 0.04], step: 0.1, P0_std: [1, 0.5, 2]}
interval: {stop: 4}
"""
HIDDEN = """\
states: [tilt, bias]
A: [[0, 0], [0, 0]]
H: [[9.81, -1]]
interval: {stop: 2}
"""
#: The same output in three segments' worth of time; what turns is seen only as it turns.
VIOLATED = """\
states: [a, b]
A: [[0, 0], [1, 0]]
H: [[0, 0]]
noise: {R: [1], step: 0.1, P0_std: [1, 1]}
interval: {stop: 2}
"""
KEYS = {
    "conventional-singular-value",
    "equivalent-singular-value",
    "column-norm",
    "residual-index",
    "posterior-ratio",
}


@pytest.fixture
def windows(obscli, tmp_path):
    def run(text, *words):
        (tmp_path / "model.yaml").write_text(text)
        found = obscli("measures", tmp_path / "model.yaml", *words)
        return found.status, found.out, found.err

    return run


@pytest.fixture
def data(windows):
    def run(text, *words):
        status, out, err = windows(text, *words, "--format", "json")
        assert (status, err) == (0, "")
        return json.loads(out)["results"][0]["measures"]

    return run


def test_the_report_says_which_windows_in_which_units(windows):
    status, out, err = windows(TURNING, "--window", "1", "--step", "0.5")
    text = " ".join(out.split())
    assert (status, err) == (0, "")
    assert "7 windows of 1, 0.5 apart, from t = 0 to 4; 10 samples each, 0.1 apart" in text
    assert "A and H kept as at the start of each" in text
    assert "States in units of the prior's standard deviations, outputs in units of their noise" in text
    assert "3 of 3 in every window" in text
    assert "best at 0" in text
    assert "null(Q_j) ⊂ null(A_j) in every segment" in text


@pytest.mark.parametrize("width", ["60", "80", "120"])
def test_no_line_is_wider_than_the_terminal(windows, monkeypatch, width):
    from obscli.render.line import cell_width

    monkeypatch.setenv("COLUMNS", width)
    _, out, _ = windows(TURNING, "--window", "1", "--advice")
    assert max(map(cell_width, out.splitlines())) <= int(width)


def test_every_window_has_the_keys_agreed_upon(data):
    found = data(TURNING, "--window", "1", "--step", "0.5")
    assert [one["t"] for one in found["windows"]] == [0, 0.5, 1, 1.5, 2, 2.5, 3]
    for one in found["windows"]:
        assert one["rank"] == 3
        assert len(one["singular_values"]) == 3
        assert set(one["states"]) == {"a", "b", "c"}
        assert all(set(values) == KEYS for values in one["states"].values())
        assert one["quantities"]["both"]["conventional-singular-value"] is None
        index = [one["states"][name]["equivalent-singular-value"] for name in "abc"]
        assert sum(index) == pytest.approx(sum(one["singular_values"]), rel=1e-12)
    c = found["windows"][0]["states"]["c"]
    assert c["column-norm"] == pytest.approx(np.sqrt(10) * 2 / 0.2, rel=1e-12)
    assert c["posterior-ratio"] == pytest.approx(1 / np.sqrt(1 + 1000), rel=1e-12)
    assert found["piecewise_constant"]["condition_holds"] is True
    assert found["piecewise_constant"]["observable_since"]["b"] == 1


def test_frozen_and_true_are_the_same_where_nothing_moves(data):
    frozen, true = (data(TURNING, "--window", "1", word) for word in ("--frozen", "--true"))
    assert (frozen["window"]["frozen"], true["window"]["frozen"]) == (True, False)
    for one, other in zip(frozen["windows"], true["windows"], strict=True):
        np.testing.assert_allclose(one["singular_values"], other["singular_values"], rtol=1e-9)


def test_units_asked_for_and_weights(data):
    raw = data(TURNING, "--window", "1", "--scaling", "none")
    assert raw["scaling"]["states"] == "none"
    assert raw["windows"][0]["states"]["c"]["column-norm"] == pytest.approx(np.sqrt(10), rel=1e-12)
    assert "as asked" in raw["warnings"][0]
    scaled = data(TURNING, "--window", "1")
    for name in "abc":
        values = [one["windows"][0]["states"][name]["posterior-ratio"] for one in (raw, scaled)]
        assert values[0] == pytest.approx(values[1], rel=1e-10)


def test_indices_of_what_is_hidden_and_missing_scales_are_warned_of(data):
    found = data(HIDDEN, "--window", "1", "--step", "0.1")
    text = " ".join(found["warnings"])
    assert "no scaling given: `noise` has no P0 of tilt, bias" in text
    assert "no R of y" in text
    assert "by itself no window identifies tilt, bias (residual index 0)" in text
    values = found["windows"][0]["states"]["tilt"]
    assert values["residual-index"] == 0
    assert values["equivalent-singular-value"] > 1
    assert values["posterior-ratio"] is None
    assert found["piecewise_constant"]["observable_since"] == {"tilt": None, "bias": None}


def test_ties_are_warned_of(data):
    text = "states: [a, b]\nA: [[0, 0], [0, 0]]\nH: [[1, 0], [0, 1]]\ninterval: {stop: 2}\n"
    squared, sizes = (
        " ".join(data(text, "--window", "1", "--step", "0.1", "--mu", mu)["warnings"])
        for mu in ("squared", "abs")
    )
    assert "singular values repeat" in squared
    assert "no function of the matrix" not in squared
    assert "σ̃ by |v| is no function of the matrix" in sizes


def test_a_violated_condition_is_warned_of(data):
    found = data(VIOLATED, "--window", "1")
    assert found["piecewise_constant"]["condition_holds"] is False
    assert "null(Q_j) ⊂ null(A_j) is violated in 2 of 2 segments" in " ".join(found["warnings"])


def test_functions_without_data_are_warned_of(data):
    text = TURNING.replace("1 + 0*t", "f")
    assert "f follows a sample motion" in " ".join(data(text, "--window", "1")["warnings"])


def test_derivatives_instead_of_samples(data):
    found = data(HIDDEN, "--window", "1", "--step", "0.1", "--stack", "continuous")
    assert found["windows"][0]["states"]["tilt"]["column-norm"] == pytest.approx(9.81)


def test_advice_names_the_motion(windows):
    text = TURNING.replace("1 + 0*t", "f")
    _, out, _ = windows(text, "--window", "1", "--advice")
    assert "c needs f different from zero" in " ".join(out.split())


def test_figures(windows, tmp_path):
    status, _, _ = windows(TURNING, "--window", "1", "--plot", str(tmp_path / "figures"))
    assert status == 0
    names = {one.name for one in (tmp_path / "figures").iterdir()}
    assert {"model-window-equivalent-singular-value.svg", "model-window-posterior-ratio.svg"} <= names


def test_only_what_is_asked_for_is_shown(windows, data, tmp_path):
    _, out, _ = windows(TURNING, "--window", "1", "--show", "both,c", "--plot", str(tmp_path / "figures"))
    first = {line.split()[0] for line in out.splitlines() if line.startswith("  ")}
    assert {"both", "c"} <= first
    assert not {"a", "b"} & first
    assert set(data(TURNING, "--window", "1", "--show", "c")["windows"][0]["states"]) == {"a", "b", "c"}


def test_figures_of_several_stages_together(windows, tmp_path):
    text = TURNING + "stages: {slow: {}, quick: {noise: {R: [1, 2], step: 0.1, P0_std: [1, 1, 1]}}}\n"
    status, _, err = windows(text, "--window", "1", "--show", "both,c", "--plot", str(tmp_path / "figures"))
    assert status == 0, err
    drawn = {one.stem: one for one in (tmp_path / "figures").glob("*.svg")}
    together = {f"model-window-{key}-{group}" for key in ("equivalent-singular-value", "posterior-ratio")
                for group in ("quantities", "states")}  # fmt: skip
    assert together <= set(drawn)
    alone = {f"model_{stage}-window-posterior-ratio" for stage in ("slow", "quick")}
    assert alone <= set(drawn)


def test_one_stage_is_not_compared(windows, tmp_path):
    windows(TURNING, "--window", "1", "--plot", str(tmp_path / "figures"))
    assert len(list((tmp_path / "figures").glob("*.svg"))) == 2


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--window", "9"], "a window of 9 does not fit"),
        (["--window", "-1"], "--window -1: a positive number"),
        (["--window", "1", "--at", "2"], "--at does not go with --window"),
        (["--window", "1", "--segments"], "--segments does not go with --window"),
        (["--window", "1", "--step", "0"], "0 is no time between samples"),
        (["--step", "-1"], "-1 is no time between samples"),
        (["--step", "inf"], "inf is no time between samples"),
        (["--window", "1", "--step", "1e-300"], "windows; 20000000 at the most"),
        (["--window", "1", "--select", "column-norm"], "--select does not go with --window"),
        (["--window", "1", "--stack", "continuous", "--true"], "leave out --true"),
        (["--window", "1", "--stack", "other"], "is not one of discrete, continuous"),
        (["--true"], "--true is about windows"),
        (["--mu", "abs"], "--mu is about windows"),
        (["--advice"], "--advice is about windows"),
        (["--show", "a"], "--show is about windows"),
        (["--window", "1", "--show", "a,z"], "--show: no state, vector or quantity 'z'; there are:"),
        (["--window", "1", "--scaling", "scale"], "missing for a, b, c"),
    ],
)
def test_what_does_not_fit_is_refused(windows, words, message):
    status, _, err = windows(TURNING, *words)
    assert status == 2
    assert message in " ".join(err.split())


def test_nothing_says_how_often(windows):
    status, _, err = windows(HIDDEN, "--window", "1")
    assert status == 2
    assert "give --step" in " ".join(err.split())
