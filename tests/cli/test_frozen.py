"""``obscli analyze --frozen-at``: the frozen rank, and beside it the true one."""

import json
import random
from pathlib import Path

import numpy as np
import pytest

import obscli
from obscli.core.place import ModelError
from obscli.pipelines.request import AnalyzeRequest, Changes, RequestError
from obscli.pipelines.verify_certificate import verify_certificates


MODELS = Path(__file__).parents[2] / "models"
TEXTBOOK = MODELS / "textbook"


def analyzed(file, instant, **options):
    request = AnalyzeRequest(frozen_at=instant, **{"only": "analytic", **options})
    return obscli.analyze(file, request=request)


def words(report):
    return "\n".join(
        "".join(part.text for part in block.content)
        for block in report.document().blocks
        if type(block).__name__ == "Note"
    )


@pytest.mark.parametrize(
    ("name", "frozen", "true"), [("frozen_observable", 2, 1), ("frozen_unobservable", 1, 2)]
)
@pytest.mark.parametrize("instant", ["0", "3", "pi/(4*omega)"])
def test_both_ranks_are_told(name, frozen, true, instant):
    report = analyzed(TEXTBOOK / f"{name}.yaml", instant)
    assert report.data()["results"][0]["frozen"] == {"at": instant, "rank": frozen, "true_rank": true}
    assert f"the frozen system has rank {frozen}, the true one {true}" in words(report)
    assert f"t = {instant}" in words(report)


def test_no_instant_is_none():
    report = obscli.analyze(TEXTBOOK / "frozen_observable.yaml", request=AnalyzeRequest(only="analytic"))
    assert report.data()["results"][0]["frozen"] is None


@pytest.mark.parametrize("file", ["bagmut/gyro.yaml", "kortunov/single_channel.yaml"])
def test_a_time_invariant_system_keeps_its_rank(file):
    report, plain = (
        analyzed(MODELS / file, "5"),
        obscli.analyze(MODELS / file, request=AnalyzeRequest(only="analytic")),
    )
    for frozen, result in zip(report.results, plain.results, strict=True):
        assert frozen.frozen.rank == frozen.frozen.true_rank == result.finding.rank
        assert not frozen.frozen.differs
    assert "the true system has the same rank" in words(report)


@pytest.mark.parametrize("seed", range(8))
def test_the_frozen_rank_is_that_of_the_matrices_at_the_instant(seed, tmp_path):
    """rank [H; HA; …; HA^(n-1)] in floating point, entries small integers at the instant."""
    source = random.Random(seed)
    n, instant = 4, source.randint(-2, 2)

    def coefficient():
        return source.choice([0, 0, 0, 1, -1, "t", "t^2 - 1", "2*t + 1", "cos(pi*t)"])

    A, H = [[coefficient() for _ in range(n)] for _ in range(n)], [[coefficient() for _ in range(n)]]
    file = tmp_path / "random.yaml"
    file.write_text(f"states: [a, b, c, d]\nA: {A}\nH: {H}\n".replace("'", ""))
    values = {
        "t": instant,
        "t^2 - 1": instant**2 - 1,
        "2*t + 1": 2 * instant + 1,
        "cos(pi*t)": (-1) ** instant,
    }
    a, h = (np.array([[values.get(e, e) for e in row] for row in M], dtype=float) for M in (A, H))
    rows = np.vstack([h @ np.linalg.matrix_power(a, k) for k in range(n)])
    assert analyzed(file, str(instant)).results[0].frozen.rank == np.linalg.matrix_rank(rows)


def test_relations_hold_for_the_constants():
    """Without norm(q) = 1 the rank without rotation would be 9."""
    report = analyzed(TEXTBOOK / "attitude_quaternion.yaml", "2", stages=("any_motion",))
    assert report.results[0].frozen.rank == 6
    assert report.results[0].frozen.true_rank == 9


def test_the_gramian_is_that_of_the_frozen_system():
    report = analyzed(TEXTBOOK / "frozen_unobservable.yaml", "3", only=None)
    [result] = report.results
    assert result.numeric.rank == 1
    assert result.verification.verdict == "verified"


def test_without_algebra_nothing_is_compared():
    report = analyzed(TEXTBOOK / "frozen_unobservable.yaml", "3", only="numeric")
    assert report.data()["results"][0]["frozen"] == {"at": "3", "rank": None, "true_rank": None}


def test_certificates_are_about_the_frozen_system():
    file = TEXTBOOK / "frozen_unobservable.yaml"
    data = json.loads(json.dumps(analyzed(file, "3").data()))
    model = obscli.load(file)
    assert [c.verdict for r in verify_certificates(model, data).results for c in r.checks] == ["holds"]
    data["results"][0]["frozen"]["at"] = "4"
    assert [c.verdict for r in verify_certificates(model, data).results for c in r.checks] == ["fails"]


def test_a_fix_is_compared_frozen():
    file = TEXTBOOK / "frozen_unobservable.yaml"
    request = AnalyzeRequest(only="analytic", frozen_at="3")
    report = obscli.analyze(file, request=request, changes=Changes(fix={"omega": "0"}))
    [neglect] = report.results[0].finding.neglect
    assert (neglect.rank_before, neglect.rank_after) == (1, 1)


@pytest.mark.parametrize(("instant", "error"), [("t", RequestError), ("h1", ModelError), ("3 +", ModelError)])
def test_instants_that_are_none(instant, error):
    with pytest.raises(error, match="--frozen-at"):
        analyzed(TEXTBOOK / "frozen_unobservable.yaml", instant)
