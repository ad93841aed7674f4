"""``transform --to stationary`` and what ``expect`` says of it: sizes, files, checks, what stands in the way."""

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import expm

from obscli.core.document import Table
from obscli.core.place import ModelError
from obscli.exact.lift_finding import Stationary
from obscli.model.covector import parse_covector
from obscli.model.reader import load, read_text
from obscli.model.specialise import at_nominal
from obscli.numeric.numeric_system import NumericSystem
from obscli.pipelines.request import TransformRequest
from obscli.pipelines.transform import transform
from obscli.pipelines.transform_result import NoStationaryForm, StationaryForm
from obscli.pipelines.verify import verify
from obscli.render.format import Surface
from obscli.render.json_text import render as as_json
from obscli.render.terminal import render as as_text


MODELS = Path(__file__).parents[2] / "models"


def made(model, stage=None):
    stages = () if stage is None else (stage,)
    return transform(model, TransformRequest(to="stationary", stages=stages))


@pytest.fixture(scope="module")
def ins():
    return load(MODELS / "ins_calibration/horizontal.yaml")


@pytest.mark.parametrize(("stage", "smallest"), [("stage_1", 19), ("stage_2", 21), ("stage_3", 21)])
def test_the_stages_of_the_paper_become_smaller_than_by_hand(ins, stage, smallest):
    """24 states → 19, 21, 21 equations, where the paper has 25 by hand; the full lift has 3 + 5·21."""
    [result] = made(ins, stage).results
    found = result.finding.found
    assert (found.full.n, found.full.rank) == (108, 16)
    assert (found.smallest.n, found.observable.n, found.rank) == (smallest, 16, 16)
    assert found.agrees
    assert [check.verdict for check in result.finding.checks] == ["holds"] * 4


def translates(rows):
    """Return the rank of translates l(t + s) of rows of functions, and their values: (k, s, rows, columns)."""
    t, s = np.linspace(0, 70, 41), np.linspace(0, 97, 43)
    values = rows((t[:, None] + s).ravel())
    columns = values.shape[-1]
    hankel = values.reshape(len(t), len(s), -1, columns).transpose(2, 1, 0, 3).reshape(-1, len(t) * columns)
    scale = np.abs(hankel).max(axis=1, keepdims=True)
    sizes = np.linalg.svd(hankel / np.where(scale > 0, scale, 1), compute_uv=False)
    return int((sizes > 1e-10 * sizes[0]).sum())


@pytest.mark.parametrize("name", ["horizontal", "vertical", "pole", "equator", "stage_1_sparse"])
def test_the_smallest_lift_has_as_many_variables_as_the_translates_of_the_rows(name):
    """Closed under d/dt is closed under translation: rows of A12, H2 at t + s, as functions of t, by their rank."""
    model = load(MODELS / f"ins_calibration/{name}.yaml")
    for system, result in zip(model.systems, made(model).results, strict=True):
        numeric = NumericSystem(system, 0, 200)

        def still(t, numeric=numeric):
            return np.concatenate(numeric.matrices(t), axis=1)[..., numeric.constant_states]

        assert len(numeric.moving) + translates(still) == result.finding.found.smallest.n


def test_the_file_written_gives_the_same_outputs(ins):
    """y of the lift from z(0) = V(0) x(0), by one matrix exponential, against the Gramian's own transition."""
    report = made(ins, "stage_1")
    lifted = read_text(report.text, "lifted.yaml").systems[0]
    system = next(one for one in ins.systems if one.stage == "stage_1")
    found = report.results[0].finding.found
    numeric, constant = NumericSystem(system, 0, 100), NumericSystem(lifted, 0, 100)
    A_z = np.zeros((lifted.n, lifted.n))
    A_z[constant.moving], H_z = (one[0] for one in constant.matrices(np.array([0.0])))
    forms = list(found.smallest.variables)
    V = numeric.covectors(forms, np.array([0.0, 40.0]))[0]
    x = np.random.default_rng(1).normal(size=24)
    stop, steps = 40.0, 4000
    A = np.zeros((2 * steps + 1, 24, 24))
    A[:, numeric.moving] = numeric.matrices(np.linspace(0, stop, 2 * steps + 1))[0]
    state, h = x.copy(), stop / steps
    for k in range(steps):  # classical Runge–Kutta on the time-varying system
        first = A[2 * k] @ state
        second = A[2 * k + 1] @ (state + h / 2 * first)
        third = A[2 * k + 1] @ (state + h / 2 * second)
        fourth = A[2 * k + 2] @ (state + h * third)
        state = state + h / 6 * (first + 2 * second + 2 * third + fourth)
    z = expm(A_z * stop) @ (V[0] @ x)
    assert z == pytest.approx(V[1] @ state, rel=1e-7, abs=1e-9)
    assert H_z @ z == pytest.approx(numeric.matrices(np.array([stop]))[1][0] @ state, rel=1e-7, abs=1e-9)


def random_reducible(seed):
    """Return x1' = A11 x1 + A12(t) x2, x2' = 0, y = H1 x1 + H2(t) x2 with random functions of a few kinds."""
    source = np.random.default_rng(seed)
    functions = [
        "1",
        "t",
        "cos(w*t)",
        "sin(w*t)",
        "exp(-a*t)",
        "t*exp(-a*t)",
        "cos(2*w*t)",
        "exp(-a*t)*sin(w*t)",
    ]
    chosen = source.choice(functions, size=3, replace=False)

    def entry():
        k = source.integers(-2, 3, size=len(chosen)) * source.integers(0, 2, size=len(chosen))
        terms = [f"{c}*{f}" for c, f in zip(k, chosen, strict=True) if c]
        return f'"{" + ".join(terms)}"' if terms else "0"

    moving, still, m = 2, int(source.integers(2, 5)), int(source.integers(1, 3))
    rows = [
        [*source.integers(-1, 2, size=moving).tolist(), *(entry() for _ in range(still))]
        for _ in range(moving)
    ] + [[0] * (moving + still)] * still
    H = [[*source.integers(-1, 2, size=moving).tolist(), *(entry() for _ in range(still))] for _ in range(m)]
    names = ", ".join(f"x{k}" for k in range(moving + still))
    flat = lambda M: "[" + ", ".join("[" + ", ".join(map(str, row)) + "]" for row in M) + "]"  # noqa: E731
    return f"parameters: {{w: 0.7, a: 0.3}}\nstates: [{names}]\nA: {flat(rows)}\nH: {flat(H)}\n"


@pytest.mark.parametrize("seed", range(12))
def test_of_random_reducible_systems_lift_rank_and_combinations_agree_with_the_analysis(seed):
    model = read_text(random_reducible(seed), "random.yaml")
    [result] = made(model).results
    assert isinstance(result.finding, StationaryForm)
    assert result.finding.found.agrees
    assert [check.verdict for check in result.finding.checks] == ["holds"] * 4
    [stage] = verify([model]).results
    assert {check.verdict for check in stage.checks} <= {"holds", "undecided"}


def test_the_combinations_are_those_printed_by_analyze(ins):
    found = made(ins, "stage_1").results[0].finding.found
    system = found.system
    named = [
        parse_covector(system, text, "test").coefficients for text in ("g*psi2 - b_a1", "b_g2 + omega*M_g21")
    ]
    assert all(any(one.keys() == form.keys() for one in found.combinations) for form in named)


def test_equations_in_turning_axes_are_constant_in_the_same_number_of_states():
    for name, eigenvalues in (("markus_yamabe", [-1, -1, 0.5]), ("wu", [-10, -1, -1])):
        found = made(load(MODELS / f"textbook/{name}.yaml")).results[0].finding.found
        assert found.same_order.n == 3
        constant = at_nominal(found.system)
        A = np.zeros((3, 3))
        for i, row in enumerate(found.same_order.A):
            for j, entry in row.items():
                A[i, j] = float(constant.expression(entry).value)
        assert sorted(np.linalg.eigvals(A).real) == pytest.approx(eigenvalues, abs=1e-6)


def test_what_stands_in_the_way_is_named_with_its_place():
    report = made(read_text("states: [x, b]\nA: [[0, cos(t^2)], [0, 0]]\nH: [[1, 1/t]]\n", "odd.yaml"))
    [result] = report.results
    assert isinstance(result.finding, NoStationaryForm)
    told = {one.entry: (one.reason, one.place) for one in result.finding.found.obstacles}
    assert told["A[x, b]"][1].startswith("odd.yaml:2:")
    assert "1/t" in told["H[y1, b]"][0]
    text = as_text(report, Surface(width=80))
    assert "not reducible in this way" in text
    data = json.loads(as_json(report, Surface()))["results"][0]["transform"]
    assert (data["reducible"], data["smallest"], len(data["obstacle"])) == (False, None, 2)


def test_a_periodic_system_that_is_not_reducible_has_its_floquet_form_in_numbers():
    text = (
        "parameters: {a: 1.2, q: 0.3}\nstates: [x, v]\nA: [[0, 1], [-(a - 2*q*cos(2*t)), 0]]\nH: [[1, 0]]\n"
    )
    report = made(read_text(text, "mathieu.yaml"))
    floquet = report.results[0].finding.floquet
    assert np.prod([mode.multiplier for mode in floquet.modes]) == pytest.approx(1)  # no damping: det M = 1
    assert "Floquet and Lyapunov" in as_text(report, Surface(width=80))


def test_a_constant_system_is_its_own_stationary_form():
    report = made(read_text("states: [x, v]\nA: [[0, 1], [0, 0]]\nH: [[1, 0]]\n", "constant.yaml"))
    assert report.results[0].finding.found.smallest.n == 2
    assert "time-invariant as it stands: 2 states" in as_text(report, Surface(width=80))


EXPECTED = """\
parameters: {{w: 1}}
states: [x, b]
A: [[0, cos(w*t)], [0, 0]]
H: [[1, 0]]
expect: {{stationary: {expected}}}
"""


@pytest.mark.parametrize(
    ("expected", "verdicts"),
    [
        ("{smallest: 3, full: 3, outputs: 3}", ["holds", "holds", "holds"]),
        ("{smallest: 2}", ["fails"]),
        ("false", ["fails"]),
    ],
)
def test_sizes_that_are_expected_hold_or_fail(expected, verdicts):
    [stage] = verify([read_text(EXPECTED.format(expected=expected), "test.yaml")]).results
    assert [one.verdict for one in stage.checks if one.place is not None] == verdicts
    assert any(
        "has the same observable combinations" in one.claim and one.verdict == "holds" for one in stage.checks
    )


def test_that_a_system_is_not_reducible_may_be_expected():
    text = "functions: [f]\nstates: [x, b]\nA: [[0, f], [0, 0]]\nH: [[1, 0]]\nexpect: {stationary: false}\n"
    [stage] = verify([read_text(text, "test.yaml")]).results
    [found] = [one for one in stage.checks if one.place is not None]
    assert found.verdict == "holds"
    assert "function left open" in found.reason


@pytest.mark.parametrize("path", sorted(MODELS.rglob("*.yaml")), ids=lambda path: path.stem)
def test_every_bundled_model_is_reduced_and_checked_or_says_what_stands_in_the_way(path):
    model = load(path)
    if model.systems[0].discrete:
        with pytest.raises(ModelError, match="does not take discrete-time models"):
            made(model)
        return
    for result in made(model).results:
        if isinstance(result.finding, StationaryForm):
            assert isinstance(result.finding.found, Stationary)
            assert {check.verdict for check in result.finding.checks} == {"holds"}
        else:
            assert isinstance(result.finding, NoStationaryForm)
            assert result.finding.found.obstacles


def test_the_report_has_a_table_of_sizes(ins):
    tables = [block for block in made(ins, "stage_1").document().blocks if isinstance(block, Table)]
    assert [cell[0][0].text for cell in (row[1] for row in tables[0].rows)] == ["108", "19", "16", "24"]
