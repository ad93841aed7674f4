"""Every command on a discrete-time model: it works, or refuses with the place of `F`."""

import json

import numpy as np
import pytest

from obscli.model.library import bundled_models
from obscli.model.reader import load


MODEL = """\
name: sampled
parameters: {T: 0.5, a: 0.9}
states: [p, v, b, c]
F: [[1, T, 0, 0], [0, 1, 0, T], [0, 0, a, 0], [0, 0, 0, 1]]
G: [[0], [T], [0], [0]]
H: [[1, 0, 0, 0]]
step: T
noise: {R: 0.01, Q: 0.1, P0_std: 1}
interval: {stop: 30}
claims:
  - rank: 3
    observable: [v]
    unobservable: [b]
    directions: [{b: 1}]
"""
VARYING = "states: [x, y]\nF: [[cos(0.7*k), 1], [0, 1]]\nH: [[1, 0]]\nnoise: {R: 1, P0_std: 1}\n"
REFUSED = "F: {} does not take discrete-time models yet"


@pytest.fixture
def model(tmp_path):
    file = tmp_path / "sampled.yaml"
    file.write_text(MODEL, encoding="utf-8")
    return file


@pytest.fixture
def varying(tmp_path):
    file = tmp_path / "varying.yaml"
    file.write_text(VARYING, encoding="utf-8")
    return file


WORKS = [
    ("analyze",),
    ("analyze", "--details"),
    ("analyze", "--dual"),
    ("analyze", "--cross-check"),
    ("analyze", "--only", "numeric"),
    ("analyze", "--basis", "sparse"),
    ("analyze", "--fix", "a=0"),
    ("analyze", "--times", "0,4"),
    ("verify",),
    ("why", "v"),
    ("why", "b"),
    ("measures",),
    ("measures", "--at", "12"),
    ("simulate",),
    ("simulate", "--runs", "20"),
    ("transform", "--to", "observable"),
    ("transform", "--to", "kalman"),
    ("transform", "--drop"),
    ("model", "check"),
]
REFUSES = [
    (("calibrate",), "obscli calibrate"),
    (("plan",), "obscli plan"),
    (("transform", "--to", "stationary"), "--to stationary"),
    (("analyze", "--certify"), "--certify"),
    (("analyze", "--frozen-at", "3"), "--frozen-at"),
]


def called(arguments, model):
    """The arguments with the model where it stands: after the command and its subcommand."""
    head = 2 if arguments[0] == "model" else 1
    return [*arguments[:head], str(model), *arguments[head:]]


@pytest.mark.parametrize("arguments", WORKS, ids=" ".join)
def test_commands_work(obscli, model, arguments):
    outcome = obscli(*called(arguments, model))
    assert outcome.status == 0, outcome.err
    assert "derivative" not in outcome.out


@pytest.mark.parametrize(
    ("arguments", "what"), REFUSES, ids=lambda one: " ".join(one) if isinstance(one, tuple) else ""
)
def test_commands_refuse(obscli, model, arguments, what):
    outcome = obscli(*called(arguments, model))
    assert outcome.status == 2
    assert f"sampled.yaml:4:{len('F: [[') + 1}: {REFUSED.format(what)}" in outcome.err


def test_a_filter_in_continuous_time_is_refused(obscli, model, tmp_path):
    other = tmp_path / "other.yaml"
    text = MODEL.replace("F: [[1,", "A: [[0,").replace("step: T\n", "").split("claims:")[0]
    other.write_text(text, encoding="utf-8")
    outcome = obscli("simulate", "--truth", model, "--filter", other)
    assert "the filter is in continuous time, the true model in discrete time" in " ".join(
        outcome.out.split()
    )


def test_sizes_of_stationary_systems_stay_undecided(obscli, model):
    model.write_text(MODEL + "expect: [{stationary: {smallest: 3}}]\n", encoding="utf-8")
    outcome = obscli("verify", model)
    assert outcome.status == 0
    assert "stationary systems are those of systems in continuous time" in " ".join(outcome.out.split())


def test_every_window_begins_at_its_step(obscli, model):
    [found] = json.loads(obscli("analyze", model, "--format", "json").out)["results"]
    points = found["numeric"]["points"]
    assert all(one["t"] == one["start"] for one in points)
    assert {one["stop"] for one in points} == {30.0}


@pytest.mark.parametrize("method", ["lyapunov", "quadrature", "lift"])
def test_methods_of_continuous_time_are_refused(obscli, model, method):
    outcome = obscli("analyze", model, "--gramian", method)
    assert outcome.status == 2
    assert method in outcome.err


def test_instants_between_steps_are_refused(obscli, model):
    for arguments in (("analyze", model, "--times", "0.5"), ("measures", model, "--at", "0.5")):
        outcome = obscli(*arguments)
        assert outcome.status == 2
        assert "step" in outcome.err


def test_both_sides_take_what_varies(obscli, varying):
    outcome = obscli("analyze", varying, "--format", "json")
    [found] = json.loads(outcome.out)["results"]
    assert outcome.status == 0
    assert found["discrete"] is True
    assert found["analytic"]["rank"] == found["numeric"]["rank"] == 2
    assert found["verification"]["verdict"] == "verified"
    for command in (("verify",), ("simulate",), ("measures",)):
        assert obscli(*called(command, varying)).status == 0


def test_what_is_for_constant_coefficients_names_the_entry(obscli, varying):
    for command in (("why", "x"), ("transform", "--to", "observable")):
        outcome = obscli(*called(command, varying))
        assert "F[x, x] depends on k" in " ".join(outcome.out.split())
        assert obscli(*called((*command, "--strict"), varying)).status == 4


@pytest.mark.parametrize("option", ["--to observable", "--to kalman", "--drop"])
def test_models_made_are_discrete_and_analysed_again(obscli, model, tmp_path, option):
    target = tmp_path / "made.yaml"
    outcome = obscli("transform", model, *option.split(), "-o", target, "--format", "json")
    made = json.loads(outcome.out)["results"][0]["transform"]
    assert all(check["verdict"] == "holds" for check in made["checks"])
    assert made["discrete"] is True
    [written] = load(target).systems
    assert written.discrete
    assert written.step is not None
    assert obscli("verify", target).status == 0


def test_a_certificate_is_checked_from_its_file(obscli, model, tmp_path):
    report = tmp_path / "report.json"
    obscli("analyze", model, "--format", "json", "--output", report)
    outcome = obscli("verify", model, "--certificate", report)
    assert outcome.status == 0, outcome.out + outcome.err


def test_a_false_claim_is_refuted_by_two_trajectories(obscli, model):
    outcome = obscli("verify", model, "--claim", "b")
    assert outcome.status == 1
    assert "give the same outputs" in outcome.out


def test_measures_are_those_of_the_samples(obscli, model):
    outcome = obscli("measures", model, "--format", "json")
    found = json.loads(outcome.out)["results"][0]
    F = np.array([[1, 0.5, 0, 0], [0, 1, 0, 0.5], [0, 0, 0.9, 0], [0, 0, 0, 1]])
    rows = [np.array([1.0, 0, 0, 0])]
    for _ in range(30):
        rows.append(rows[-1] @ F)
    singular = np.linalg.svd(np.array(rows[:4]), compute_uv=False)
    W = np.array(rows).T @ np.array(rows)
    text = json.dumps(found)
    values = values_of(found, "singular-values"), values_of(found, "gramian-singular-values")
    assert values[0][:3] == pytest.approx(singular[:3], rel=1e-6), text[:400]
    assert values[1][:3] == pytest.approx(np.linalg.eigvalsh(W)[::-1][:3], rel=1e-6)


def values_of(data, key):
    """The values of a measure of the system as a whole, wherever it stands in the report."""
    found = []

    def walk(node):
        if isinstance(node, dict):
            if key in node:
                found.append(node[key])
            for one in node.values():
                walk(one)
        elif isinstance(node, list):
            for one in node:
                walk(one)

    walk(data)
    return numbers(found[0])


def numbers(node):
    if isinstance(node, list):
        return [value for one in node for value in numbers(one)]
    if isinstance(node, dict):
        return numbers(node["value"]) if "value" in node else []
    return [float(node)] if isinstance(node, int | float) else []


@pytest.mark.parametrize("name", [name for name in bundled_models() if name.startswith("discrete/")])
def test_bundled_models_hold(obscli, name):
    outcome = obscli("verify", bundled_models()[name])
    assert outcome.status == 0, outcome.out
