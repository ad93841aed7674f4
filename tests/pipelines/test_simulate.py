"""What the pipeline of a simulation puts together: verdicts, combinations, sampling, judgements, figures."""

from pathlib import Path

import numpy as np
import pytest

from obscli.api import simulate
from obscli.model.reader import load, read_text
from obscli.numeric.simulation_finding import Consistency
from obscli.pipelines.describe.simulate_runs import judged
from obscli.pipelines.request import Changes, RequestError, SimulateRequest
from obscli.pipelines.simulate_followed import followed_forms


MODELS = Path(__file__).parents[2] / "models"

#: theory: measure (4), 1 - σ⁺/σ⁻, of the paper's two systems in the bundled setting.
R1 = {
    ("gyro", "velocity", 10): (0.99304295, 0.7921662, 0.45016617),
    ("gyro", "velocity", 50): (0.99755737, 0.99252013, 0.98525833),
    ("accelerometer", "attitude", 10): (0.0047759426, 0.96985153, 3.6465778e-7),
    ("accelerometer", "attitude", 50): (0.095077835, 0.98540726, 8.8483422e-4),
}
VECTORS = """\
states: {b: {shape: 5, unit: rad}, a: {unit: m}, c: {unit: m}, d: {}}
A: {}
H: {y: {b1: 1, a: 1}}
quantities: {q: a - c}
noise: {R: 1, step: 1, P0_std: {b: 1, a: 1, c: 2, d: 1}}
interval: {stop: 10}
"""


@pytest.mark.parametrize(("model", "stage", "t"), R1)
def test_the_stochastic_measure_of_the_paper(model, stage, t):
    [result] = simulate(MODELS / f"bagmut/{model}.yaml", request=SimulateRequest(stages=(stage,))).results
    history = result.found.history
    k = int(np.flatnonzero(history.t == t)[0])

    assert 1 - history.deviations[k] / history.open_loop[k] == pytest.approx(R1[model, stage, t], rel=2e-7)


def test_verdicts_are_those_at_the_files_values():
    """Two error models that decay equally fast cannot be told apart, though generic ones can."""
    forms, unsaid = followed_forms(load(MODELS / "kortunov/single_channel.yaml").systems[0])
    verdicts = {one.name: one.verdict for one in forms if one.kind == "state"}

    assert unsaid == ""
    assert verdicts == {
        "alpha": "coupled", "V": "observable", "R": "observable", "dOm": "coupled", "dW": "coupled"
    }  # fmt: skip
    assert [len(one.coefficients) for one in forms if one.kind == "combination"] == [2, 2]


def test_changes_are_made_to_the_truth_alone():
    file = MODELS / "kortunov/single_channel.yaml"
    [result] = simulate(file, changes=Changes({"alpha_w": "0.01"}), design=file).results
    mismatch = result.found.mismatch

    assert mismatch.history.ignored == ()
    assert max(one.worst for one in mismatch.ratios) > 1.5


def test_a_filter_is_taken_from_the_stage_of_the_same_name():
    text = (
        "states: [x]\nA: [[0]]\nH: [[1]]\nnoise: {R: 1, step: 1, P0_std: [1]}\ninterval: {stop: 10}\n"
        "stages: {a: {}, b: {noise: {R: 4}}}\n"
    )
    truth = read_text(text, "truth.yaml")
    report = simulate(truth, design=truth)
    assert [result.found.mismatch.system.stage for result in report.results] == ["a", "b"]
    assert all(one.end == pytest.approx(1) for r in report.results for one in r.found.mismatch.ratios)
    with pytest.raises(RequestError, match="no stage for the filter 'b'"):
        simulate(truth, design=read_text(text.replace("b:", "c:"), "other.yaml"))


@pytest.mark.parametrize("scale", [1.0, 1.3, 0.7])
def test_the_average_of_consistent_runs_is_in_its_band(scale):
    """χ² averages of 50 runs and 4 degrees of freedom, errors as claimed, larger, smaller."""
    runs, n, k = 50, 4, 400
    averages = np.random.default_rng(5).chisquare(runs * n, k) / (runs * n)
    half = 1.96 * np.sqrt(2 / (runs * n))
    band = (np.full(k, 1 - half), np.full(k, 1 + half))
    found = Consistency(np.arange(k, dtype=float), scale * averages, *band, 0.95)

    one = judged("NIS", found, independent=True)
    assert (one.lower <= one.average <= one.upper) is (scale == 1.0)
    assert one.upper - one.lower == pytest.approx(2 * half / np.sqrt(k))
    assert (one.average > one.upper) is (scale > 1)


def test_every_form_has_its_curve_and_panels_stay_readable():
    report = simulate(read_text(VECTORS, "vectors.yaml"))
    panels = [panel for figure in report.figures() for panel in figure.panels]
    titles = [panel.title for panel in panels]

    assert titles == ["b1, b2, b3", "b4, b5", "a, c", "d", "q", "b1 + a"]
    for panel in panels:
        main = [curve for curve in panel.curves if curve.emphasis in {"main", "one of many"}]
        assert len(main) == 1 + panel.title.count(",")
        assert any(curve.label == "nothing measured" for curve in panel.curves)


def test_the_assumed_step_and_the_default_interval_are_told():
    text = "states: [x]\nA: [[-1]]\nH: [[1]]\nnoise: {R: 1, P0_std: [1]}\n"
    [result] = simulate(read_text(text, "dense.yaml")).results

    assert result.found.default
    assert result.found.assumed_step == pytest.approx((result.found.stop - result.found.start) / 400)
    [given] = simulate(read_text(text, "dense.yaml"), request=SimulateRequest(step=0.5)).results
    assert given.found.assumed_step is None


@pytest.mark.parametrize(("part", "kept"), [("filter", 0), ("mismatch", 1), ("runs", 2)])
def test_an_interrupt_keeps_all_parts_before_it(part, kept, monkeypatch):
    """Whichever part Ctrl-C ends before its first instant, what came before it is reported."""
    names = {"filter": "covariance_history", "mismatch": "mismatch_history", "runs": "monte_carlo"}

    def interrupted(*_, **__):
        raise KeyboardInterrupt

    model = read_text(VECTORS, "vectors.yaml")
    monkeypatch.setattr(f"obscli.pipelines.simulate.{names[part]}", interrupted)
    if not kept:
        with pytest.raises(KeyboardInterrupt):
            simulate(model)
        return
    report = simulate(model, request=SimulateRequest(runs=3), design=model)
    [result] = report.results

    assert report.interrupted
    assert result.interrupted
    assert result.found.history.complete
    assert (result.found.mismatch is not None) is (kept == 2)
    assert result.found.monte_carlo is None
    assert any("interrupted" in str(block) for block in report.document().blocks)
