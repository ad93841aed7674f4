import pytest

from obscli.core.place import ModelError
from obscli.model.covector import parse_covector, parse_covectors_file, parse_scalar
from obscli.model.notation import covector_text, to_text
from obscli.model.reader import load_claims, read_text
from obscli.model.system import Parameter, System


LINES = """
states: {psi: 2, b: 1}
parameters: {g: 9.8, phi: 1}
functions: [f]
let: {c: g*cos(phi)}
dynamics: {psi1: b}
measurements: {y: psi}
stages: {one: {}, two: {fix: {phi: 0}}}
"""
CLAIMS = """
claims:
- rank: 2
  basis: [psi1, c*psi2 - b]
  observable: [psi]
  unobservable: ["b/g"]
  directions: [{psi1: 1/g, b: 1, psi2: 0}]
  states: {psi: observable, b: coupled}
  at: {phi: pi/2}
- {stage: two, rank: 0, at: nominal, basis: [], determined: [b], detectable: false}
- {experiment: e, rank: 3, basis: [b]}
expect: {stage: one, measures: {cond: 1e3}, require: {b: met}}
"""


@pytest.fixture
def model():
    return read_text(LINES + CLAIMS, "model.yaml")


@pytest.fixture
def system():
    return read_text(LINES, "model.yaml").systems[0]


def texts(quantities):
    return [covector_text(one.coefficients, ("psi1", "psi2", "b")) for one in quantities]


def test_a_claim(model):
    claim = model.systems[0].claims[0]
    assert (claim.origin, claim.stage, claim.rank) == ("claims", None, 2)
    assert texts(claim.basis) == ["psi1", "g*cos(phi)*psi2 - b"]
    assert texts(claim.observable) == ["psi1", "psi2"]
    assert texts(claim.unobservable) == ["1/g*b"]
    assert texts(claim.directions) == ["1/g*psi1 + b"]
    assert {name: verdict for name, (verdict, _) in claim.states.items()} == {
        "psi1": "observable",
        "psi2": "observable",
        "b": "coupled",
    }
    assert to_text(claim.at["phi"]) == "pi/2"
    assert claim.place.line == 11
    assert claim.rank_place.line == 11
    assert (claim.basis[1].place.line, claim.basis[1].text) == (12, "c*psi2 - b")


def test_claims_belong_to_stages(model):
    one, two = model.systems
    assert [(claim.origin, claim.stage) for claim in one.claims] == [("claims", None), ("expect", "one")]
    assert [(claim.origin, claim.stage) for claim in two.claims] == [("claims", None), ("claims", "two")]
    assert (two.claims[1].at, two.claims[1].basis, two.claims[1].rank) == ("nominal", (), 0)
    assert two.claims[1].detectable[0] is False
    assert (two.claims[1].measures, two.claims[1].requirements) == ((), {})
    assert {name: verdict for name, (verdict, _) in two.claims[1].states.items()} == {"b": "observable"}
    assert [(one.key, to_text(one.value)) for one in one.claims[1].measures] == [("cond", "1000")]
    assert {name: word for name, (word, _) in one.claims[1].requirements.items()} == {"b": "met"}
    assert one.claims[1].basis is None


def test_names_of_the_stage_count(model):
    assert texts(model.systems[1].claims[0].basis) == ["psi1", "g*psi2 - b"]


def test_claims_about_an_experiment(model):
    (claim,) = model.claims
    assert (claim.experiment, texts(claim.basis)) == ("e", ["b"])


EXPERIMENT = "experiment: {name: table, runs: [one, {stage: two, name: back}]}\nplan: {candidates: [two]}\n"


def test_claims_about_some_runs():
    claims = "claims: [{experiment: table, runs: [one, back, two], determined: [psi], states: {b: coupled}}]"
    (claim,) = read_text(LINES + EXPERIMENT + claims, "model.yaml").claims

    assert [(name, place.column) for name, place in claim.runs] == [("one", 37), ("back", 42), ("two", 48)]
    assert {name: verdict for name, (verdict, _) in claim.states.items()} == {
        "psi1": "observable",
        "psi2": "observable",
        "b": "coupled",
    }
    assert claim.everything is None


def test_everything_determined():
    lines = "claims: [{experiment: table, determined: all}, {stage: one, determined: all}]"
    model = read_text(LINES + EXPERIMENT + lines, "model.yaml")

    assert (model.claims[0].runs, model.claims[0].states) == ((), {})
    assert (model.claims[0].everything.line, model.claims[0].everything.column) == (11, 42)
    assert model.systems[0].claims[0].states.keys() == {"psi1", "psi2", "b"}


@pytest.mark.parametrize(
    ("claim", "message"),
    [
        ("{experiment: tabel}", "there is no experiment 'tabel'; did you mean 'table'"),
        ("{experiment: table, runs: [bakc]}", "there is no run 'bakc'; did you mean 'back'"),
        ("{experiment: table, runs: one}", "a list is expected here"),
        ("{stage: one, runs: [one]}", "`runs` belongs to a claim about an experiment"),
        ("{experiment: table, determined: [psy]}", "'psy' is no state; did you mean 'psi'"),
        ("{experiment: table, determined: some}", "a list is expected here"),
    ],
)
def test_wrong_claims_about_an_experiment(claim, message):
    with pytest.raises(ModelError, match=message) as caught:
        read_text(f"{LINES}{EXPERIMENT}claims: [{claim}]", "model.yaml")
    (problem,) = caught.value.problems
    assert problem.place.line == 11


def test_claims_of_another_file(model, tmp_path):
    path = tmp_path / "claims.yaml"
    path.write_text("- {rank: 7}\n- {stage: two, basis: [b]}\n")
    found = load_claims(model, path)
    assert {stage: [claim.rank for claim in claims] for stage, claims in found.items()} == {
        "one": [7],
        "two": [7, None],
    }
    path.write_text(CLAIMS)
    assert [claim.origin for claim in load_claims(model, path)["one"]] == ["claims", "expect"]
    path.write_text("- {rank: 7, basis: [nope]}\n- {stage: tow}\n")
    with pytest.raises(ModelError) as caught:
        load_claims(model, path)
    assert [problem.message for problem in caught.value.problems] == [
        "unknown name 'nope'",
        "there is no stage 'tow'; did you mean 'two'?",
    ]


def test_expressions_of_the_command_line(system):
    assert to_text(parse_scalar(system, "2*c + deriv(f)", "--at")) == "2*g*cos(phi) + deriv(f)"
    one = parse_covector(system, " c*psi[2] - b ", "--why")
    assert one.text == "c*psi[2] - b"
    assert texts([one]) == ["g*cos(phi)*psi2 - b"]


@pytest.mark.parametrize(
    ("text", "column", "message"),
    [
        ("psi1 + nope", 8, "unknown name 'nope'"),
        ("psi", 1, "not a vector of 2"),
        ("psi1 + g", 1, "a term without a state"),
        ("psi1*b", 5, "not linear"),
        ("psi1 +", 7, "the expression ends"),
        ("0", 1, "is zero"),
        ("", 1, "missing"),
        ("\x1b[31m", 1, "U\\+001B"),
    ],
)
def test_wrong_combinations(system, text, column, message):
    with pytest.raises(ModelError, match=message) as caught:
        parse_covector(system, text, "--basis")
    (problem,) = caught.value.problems
    assert (problem.place.file, problem.place.line, problem.place.column) == ("--basis", 1, column)


@pytest.mark.parametrize(
    ("text", "message"), [("psi1", "states have no place"), ("[1, 2]", "a scalar is expected")]
)
def test_wrong_scalars(system, text, message):
    with pytest.raises(ModelError, match=message):
        parse_scalar(system, text, "--at")


def test_a_file_of_combinations(system, tmp_path):
    path = tmp_path / "basis.yaml"
    path.write_text("- psi1\n- 'c*psi2 - b'\n")
    assert texts(parse_covectors_file(system, path)) == ["psi1", "g*cos(phi)*psi2 - b"]
    path.write_text("- psi1\n- nope\n- 1 +\n")
    with pytest.raises(ModelError) as caught:
        parse_covectors_file(system, path)
    assert [problem.place.line for problem in caught.value.problems] == [2, 3]
    path.write_text("a: 1\n")
    with pytest.raises(ModelError, match="a list is expected"):
        parse_covectors_file(system, path)


def test_a_system_not_made_from_a_file(system):
    bare = System(
        None, "t", (Parameter("g", system.states[0].place),), (), (), system.states, (), system.A, system.H
    )
    assert texts([parse_covector(bare, "g*psi1 - t*b", "--why")]) == ["g*psi1 - t*b"]
