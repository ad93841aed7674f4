"""``obscli verify``: claims, certificates, many models."""

import json

import pytest


def test_claims_that_hold(obscli, integrator):
    outcome = obscli("verify", integrator)

    assert (outcome.status, outcome.err) == (0, "")
    assert "✓" in outcome.out
    assert "✗" not in outcome.out


def test_json_keeps_its_contract(obscli, integrator):
    integrator.write_text(integrator.read_text().replace("rank: 2", "rank: 1"))

    outcome = obscli("verify", integrator, "--format", "json")

    data = json.loads(outcome.out)
    assert outcome.status == 1
    assert {"schema", "obscli", "results", "checks", "failed", "undecided"} <= data.keys()
    assert all({"model", "stage", "claim", "verdict", "reason"} <= check.keys() for check in data["checks"])
    assert (data["failed"], data["undecided"]) == (1, 0)


@pytest.mark.parametrize(("claim", "status"), [("g*tilt - bias", 0), ("tilt", 1), ("2*bias - 2*g*tilt", 0)])
def test_a_claim_on_the_command_line(obscli, stages, claim, status):
    assert obscli("verify", stages, "--stage", "still", "--claim", claim).status == status


def test_a_claim_on_the_command_line_has_no_line(obscli, integrator):
    assert "(line" not in obscli("verify", integrator, "--claim", "velocity").out


def test_a_claim_that_cannot_be_read(obscli, stages):
    outcome = obscli("verify", stages, "--claim", "tilt +")

    assert outcome.status == 2
    assert "--claim" in outcome.err


def test_claims_of_a_colleague(obscli, stages, tmp_path):
    file = tmp_path / "claims.yaml"
    file.write_text("claims:\n  - {stage: still, rank: 1}\n  - {stage: turning, rank: 3}\n")

    outcome = obscli("verify", stages, "--claims", file)

    assert outcome.status == 1
    assert outcome.out.count("✗") == 2


def test_every_model_under_models(obscli, integrator, tmp_path, monkeypatch):
    (tmp_path / "models").mkdir()
    integrator.rename(tmp_path / "models" / "one.yaml")
    (tmp_path / "compose.yaml").write_text("services: {}\n")
    monkeypatch.chdir(tmp_path)

    assert obscli("verify").status == 0


@pytest.mark.usefixtures("integrator")
def test_models_of_the_current_directory(obscli, tmp_path, monkeypatch):
    (tmp_path / "compose.yaml").write_text("services: {}\n")
    monkeypatch.chdir(tmp_path)

    assert obscli("verify").status == 0


def test_no_models_at_all(obscli, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    outcome = obscli("verify")

    assert outcome.status == 2
    assert "no models" in outcome.err


def test_problems_of_all_models_at_once(obscli, tmp_path):
    for name in ("one", "two"):
        (tmp_path / f"{name}.yaml").write_text("states: [a]\nA: [[b]]\nH: [[1]]\n")

    outcome = obscli("verify", tmp_path / "one.yaml", tmp_path / "two.yaml")

    assert outcome.status == 2
    assert "one.yaml:2:" in outcome.err
    assert "two.yaml:2:" in outcome.err


@pytest.fixture
def certified(obscli, stages, tmp_path):
    """A report of both stages, as data to be altered, and the function that verifies it."""
    file = tmp_path / "report.json"
    assert obscli("analyze", stages, "--format", "json", "--output", file).status == 0

    def verify(data):
        file.write_text(data if isinstance(data, str) else json.dumps(data))
        return obscli("verify", stages, "--certificate", file)

    return json.loads(file.read_text()), verify


def test_a_certificate_verifies(certified):
    data, verify = certified

    outcome = verify(data)

    assert (outcome.status, outcome.err) == (0, "")


def test_a_fixed_system_s_certificate_verifies_too(obscli, stages, tmp_path):
    file = tmp_path / "report.json"
    obscli("analyze", stages, "--fix", "g=2", "--without", "drift", "--format", "json", "--output", file)

    assert obscli("verify", stages, "--certificate", file).status == 0


def test_a_rank_raised_in_the_report_fails(certified):
    data, verify = certified
    data["results"][0]["analytic"]["rank"] += 1

    assert verify(data).status == 1


def test_the_certificate_at_the_values_is_checked_too(obscli, stages, tmp_path):
    file = tmp_path / "report.json"
    obscli("analyze", stages, "--stage", "turning", "--set", "w=0", "--format", "json", "--output", file)
    data = json.loads(file.read_text())

    assert "at the file's values" in obscli("verify", stages, "--certificate", file).out
    data["results"][0]["analytic"]["at_values"]["rank"] = 2
    file.write_text(json.dumps(data))
    assert obscli("verify", stages, "--certificate", file).status == 1


def test_a_wrong_combination_fails(certified):
    data, verify = certified
    data["results"][0]["analytic"]["combinations"][0]["coefficients"] = {"tilt": "1"}

    assert verify(data).status == 1


@pytest.mark.parametrize(
    ("path", "value"),
    [
        (("rank",), "3"),
        (("rank",), -1),
        (("rank",), True),
        (("order",), None),
        (("lower",), []),
        (("lower", "point"), {"t": 1}),
        (("lower", "rows"), [["y"]]),
        (("lower", "rows"), [["y", 0.5]]),
        (("lower", "columns"), "tilt"),
        (("lower", "midpoint"), 3.0),
        (("upper", "kernel"), [{"nobody": "1"}]),
        (("upper", "kernel"), [{"tilt": "__import__('os')"}]),
        (("upper", "multiplier"), [["0"]]),
        (("upper", "delay"), "w"),
        (("assumes",), {}),
    ],
)
def test_malformed_certificates_are_named(certified, path, value):
    data, verify = certified
    place = data["results"][0]["analytic"]["certificate"]
    for key in path[:-1]:
        place = place[key]
    place[path[-1]] = value

    outcome = verify(data)

    assert (outcome.status, outcome.out) == (2, "")
    assert "results[0].analytic.certificate" in outcome.err
    assert len(outcome.err.splitlines()) == 1


@pytest.mark.parametrize("key", ["model", "rank", "order", "lower", "upper", "assumes"])
def test_a_missing_key_is_named(certified, key):
    data, verify = certified
    del data["results"][0]["analytic"]["certificate"][key]

    outcome = verify(data)

    assert outcome.status == 2
    assert f"key '{key}' is missing" in outcome.err


@pytest.mark.parametrize(
    "text", ["", "{", "[" * 100_000, "NaN", "[]", '{"results": 3}', '{"results": []}', "\x00"]
)
def test_no_report_at_all(certified, text):
    _, verify = certified

    outcome = verify(text)

    assert (outcome.status, outcome.out) == (2, "")
    assert len(outcome.err.splitlines()) == 1
