"""What the pipeline of a simulation puts together: verdicts, combinations, sampling, judgements, figures."""

from pathlib import Path

import numpy as np
import pytest
from scipy.stats import chi2

from obscli.api import simulate
from obscli.core.document import VerdictLine
from obscli.model.reader import load, read_text
from obscli.numeric.simulation_finding import Consistency, MonteCarlo
from obscli.pipelines.describe.simulate_runs import judged, runs_blocks
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


def consistency(averages, degrees):
    """Return averages over runs as a Monte Carlo run gives them; the bands of single instants do not matter."""
    k = len(averages)
    return Consistency(np.arange(float(k)), averages, np.zeros(k), np.zeros(k), degrees, 0.95)


def series(degrees, count, seed, *, independent):
    """Return averages of right filters (count, k): new at every instant, or one and the same at all."""
    source = np.random.default_rng(seed)
    if independent:
        return source.chisquare(degrees, (count, len(degrees))) / degrees
    return np.repeat(source.chisquare(degrees[0], (count, 1)) / degrees[0], len(degrees), axis=1)


@pytest.mark.parametrize("independent", [True, False])
@pytest.mark.parametrize("runs", [1, 50])
def test_right_filters_are_refuted_once_in_a_thousand_and_outside_once_in_twenty(runs, independent):
    """Of few runs χ² is lopsided; one output is sampled at every instant, another at every third."""
    outputs = 1 + (np.arange(40) % 3 == 0) if independent else np.full(40, 2)
    found = [
        judged("NIS", consistency(one, runs * outputs), 0.95, independent=independent)
        for one in series(runs * outputs, 8000, 5, independent=independent)
    ]
    for rate, expected in (
        (np.mean([one.refuted for one in found]), 0.001),
        (np.mean([one.side == "above" for one in found]), 0.025),
        (np.mean([one.side == "below" for one in found]), 0.025),
    ):
        assert rate == pytest.approx(expected, abs=5 * np.sqrt(expected / 8000))


@pytest.mark.parametrize("scale", [1.3, 0.7])
def test_filters_that_claim_another_size_are_refuted(scale):
    degrees = np.full(400, 500)
    [averages] = scale * series(degrees, 1, 5, independent=True)
    for independent in (True, False):
        one = judged("NIS", consistency(averages, degrees), 0.95, independent=independent)
        assert one.refuted
        assert one.side == ("above" if scale > 1 else "below")


def test_a_band_is_that_of_all_degrees_of_freedom():
    degrees = np.array([30, 60, 30])
    one = judged("NIS", consistency(np.array([1.0, 1.1, 0.9]), degrees), 0.95, independent=True)
    assert one.average == pytest.approx((30 + 66 + 27) / 120)
    assert (one.lower, one.upper) == pytest.approx(tuple(chi2.ppf([0.025, 0.975], 120) / 120))
    alone = judged("NEES", consistency(np.array([1.0, 1.1, 0.9]), degrees), 0.95, independent=False)
    assert (alone.lower, alone.upper) == pytest.approx(tuple(chi2.ppf([0.025, 0.975], 30) / 30))


def verdict(blocks):
    """Return the kind and the words of the first verdict."""
    first = next(block for block in blocks if isinstance(block, VerdictLine))
    return first.kind, "".join(part.text for part in first.content)


@pytest.mark.parametrize(
    ("nees", "nis", "kind", "words"),
    [
        (0.5, 0.5, "good", "consistent"),
        (0.97, 0.03, "good", "consistent"),
        (0.98, 0.5, "open", "not decided: NEES above the band, as up to 1 in 10 right filters is"),
        (0.001, 0.999, "open", "not decided: NEES below, NIS above the band"),
        (0.9999, 0.98, "bad", "optimistic: errors are larger than the filter claims (NEES above the band)"),
        (0.98, 0.0001, "open", "pessimistic: errors are smaller than the filter claims (NIS below the band)"),
        (0.9999, 0.0001, "bad", "inconsistent: NEES above the band, NIS below"),
    ],
)
def test_what_chance_may_do_is_not_held_against_a_filter(nees, nis, kind, words):
    """Averages at quantiles of their distributions: outside of 0.025 … 0.975, of 0.0005 … 0.9995."""
    degrees, t = np.full(5, 60), np.arange(5.0)
    parts = [
        consistency(np.full(5, chi2.ppf(share, own) / own), degrees)
        for share, own in ((nees, 60), (nis, 300))
    ]
    nothing = np.zeros((5, 0))
    found = MonteCarlo((), (), 20, 0, t, nothing, nothing, nothing, *parts, 0.95)
    told = verdict(runs_blocks(found, {}, mismatched=False))
    assert told[0] == kind
    assert told[1].startswith(words)


DRIVEN = """\
parameters: {beta: 0.1}
states: [p, v, b, c]
disturbances: [w1, w2]
A: [[0, 1, 0, 0], [0, 0, 1, 0], [0, 0, -beta, 0], [0, 0, 0, 0]]
G: [[0, 0], [1, 0], [0, 1], [0, 0]]
outputs: {y: {every: 1}, z: {every: 3, during: [[0, 10], [15, 30]]}}
H: [[1, 0, 0, 0], [0, 1, 0, 1]]
noise:
  R: [[0.25, 0], [0, 0.5]]
  Q: [[0.04, 0], [0, 0.0025]]
  P0: [[4, 1, 0, 0], [1, 1, 0.1, 0], [0, 0.1, 0.5, 0.2], [0, 0, 0.2, 1]]
interval: {stop: 30}
"""


@pytest.mark.parametrize("seed", range(6))
def test_a_right_filter_is_not_called_wrong(seed):
    report = simulate(read_text(DRIVEN, "driven.yaml"), request=SimulateRequest(runs=400, seed=seed))
    kind, words = verdict(report.document().blocks)
    assert (kind, words.partition(":")[0]) in {("good", "consistent"), ("open", "not decided")}


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


@pytest.mark.parametrize(("part", "kept"), [("filter", 0), ("mismatch", 1), ("response", 2), ("runs", 3)])
def test_an_interrupt_keeps_all_parts_before_it(part, kept, monkeypatch):
    """Whichever part Ctrl-C ends before its first instant, what came before it is reported."""
    names = {
        "filter": "simulate.covariance_history",
        "mismatch": "simulate.mismatch_history",
        "response": "simulate_errors.mean_response",
        "runs": "simulate_errors.monte_carlo",
    }

    def interrupted(*_, **__):
        raise KeyboardInterrupt

    model = read_text(VECTORS, "vectors.yaml")
    monkeypatch.setattr(f"obscli.pipelines.{names[part]}", interrupted)
    if not kept:
        with pytest.raises(KeyboardInterrupt):
            simulate(model)
        return
    report = simulate(model, request=SimulateRequest(runs=3, initial=(("a", "1"),)), design=model)
    [result] = report.results

    assert report.interrupted
    assert result.interrupted
    assert result.found.history.complete
    assert (result.found.mismatch is not None) is (kept >= 2)
    assert (result.found.initial is not None) is (kept == 3)
    assert result.found.monte_carlo is None
    assert any("interrupted" in str(block) for block in report.document().blocks)
