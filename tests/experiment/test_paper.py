"""Morozov & Baklanov (2018), the calibration example: their numbers, and those recomputed for this project.

Each by the exact and by the numeric side. The experiments are put in place of those of the files.
"""

import numpy as np
import pytest


LEVEL = """\
experiment:
  name: level
  runs:
    - {stage: [stage_1, stage_2, stage_3], grid: {omega: [omega, -omega]}}
"""
VERTICAL = """\
experiment:
  name: vertical
  runs:
    - {stage: [stage_1, stage_2, stage_3], grid: {omega: [omega, -omega]}}
    - {stage: stage_1, name: down_1, let: {R_nb: rotz(omega*t) @ rotx(pi) @ start}}
    - {stage: stage_2, name: down_2, let: {R_nb: rotz(omega*t) @ rotx(pi) @ start}}
    - {stage: stage_3, name: down_3, let: {R_nb: rotz(omega*t) @ rotx(pi) @ start}}
"""
VALUES = {"g": 9.81, "omega": 0.1, "phi": 0.47, "omega_ie": 2 * np.pi / 86400}
KERNEL = (
    "{b_a1: -g, M_a11: 1, M_a21: 1, M_a31: 1, M_g12: 1, M_g21: -1, M_g13: 1, M_g31: -1}",
    "{b_a2: -g, M_a21: 1, M_a22: 1, M_a32: 1, M_g23: 1, M_g32: -1}",
    "{b_a3: -g, M_a31: 1, M_a32: 1, M_a33: 1}",
)


def back(k):
    return f"stage_{k} (omega = -omega)"


@pytest.fixture(scope="module")
def level(model, bare):
    """The axis level, each stage turning both ways: the paper's six runs."""
    return model(bare("ins_calibration/horizontal.yaml") + LEVEL)


@pytest.fixture(scope="module")
def vertical(model, bare):
    """The axis vertical, each body axis up, turning both ways, and down."""
    return model(bare("ins_calibration/vertical.yaml") + VERTICAL)


def assert_both_sides(found, rank):
    assert found.exact.rank == found.exact.at_file.rank == found.together.rank == rank
    assert {one.verdict for one in found.verifications} == {"verified"}


def test_six_level_runs_give_78_rows_of_rank_21(level, calibrated):
    found = calibrated(level)

    assert_both_sides(found, 21)
    assert (found.exact.stack.system.m, found.exact.stack.system.n) == (78, 21)
    assert [len(run.rows.rows) for run in found.runs] == [13] * 6
    assert [run.rows.finding.rank for run in found.runs] == [16] * 6
    assert set(found.exact.stack.finding.states.values()) == {"observable"}
    assert found.exact.fresh == ("psi1", "psi2", "psi3")


@pytest.mark.parametrize(
    ("runs", "rank"),
    [
        (("stage_1", "stage_2", "stage_3"), 21),
        *((("stage_" + str(i), back(i), f"stage_{j}", back(j)), 21) for i, j in ((1, 2), (1, 3), (2, 3))),
        *(((f"stage_{i}", f"stage_{j}"), 20) for i, j in ((1, 2), (1, 3), (2, 3))),
        *(((f"stage_{k}", back(k)), 15) for k in (1, 2, 3)),
        *(((f"stage_{k}",), 13) for k in (1, 2, 3)),
    ],
)
def test_fewer_level_runs(level, calibrated, runs, rank):
    found = calibrated(level, *runs)

    assert tuple(run.run.name for run in found.runs) == runs
    assert_both_sides(found, rank)


def test_stage_1_says_what_the_paper_says(level, calibrated):
    """y4 to y16 of the paper, the combinations without psi."""
    [run] = calibrated(level, "stage_1", only="analytic").runs

    rows = [set(row) for row in run.rows.rows]
    alone = ["b_a2", "b_a3", "M_g12", "M_g13", "M_g22", "M_g23", "M_g32", "M_g33", "M_a22", "M_a32", "M_a33"]
    assert [row for row in rows if len(row) > 1] == [{"b_g2", "M_g21"}, {"b_g3", "M_g31"}]
    assert sorted(name for row in rows if len(row) == 1 for name in row) == sorted(alone)


def _span(covectors, names, numbers):
    """The orthogonal projector onto the span of covectors at the file's values."""
    rows = numbers(covectors, names, VALUES)
    basis = np.linalg.svd(rows, full_matrices=False)[2]
    return basis.T @ basis


@pytest.mark.parametrize("both_ways", [False, True])
def test_a_vertical_axis_leaves_three_directions(vertical, calibrated, model, bare, numbers, both_ways):
    runs = [name for k in (1, 2, 3) for name in (f"stage_{k}", *([back(k)] if both_ways else []))]
    found = calibrated(vertical, *runs)
    claims = f"claims: [{{experiment: vertical, directions: [{', '.join(KERNEL)}]}}]\n"
    [claim] = model(bare("ins_calibration/vertical.yaml") + VERTICAL + claims).claims

    assert_both_sides(found, 18)
    assert [len(run.rows.rows) for run in found.runs] == [9] * len(runs)
    names = list(found.exact.shared)
    mine = found.exact.stack.finding.unobservable
    assert len(mine) == 3
    wanted = _span([one.coefficients for one in claim.directions], names, numbers)
    np.testing.assert_allclose(_span(mine, names, numbers), wanted, atol=1e-12)


def test_the_joint_gramian_has_the_same_three_directions(vertical, calibrated, numbers, model, bare):
    """No observable combination of the joint Gramian changes along them."""
    from obscli.experiment.witnessed import witnessed
    from obscli.numeric.settings import Settings
    from obscli.pipelines.numerical import Looks
    from obscli.pipelines.request import NumericRequest

    found = calibrated(vertical, "stage_1", "stage_2", "stage_3", only="analytic")
    look = Looks(vertical, NumericRequest())
    seen = witnessed(found.exact.runs, found.exact.stack.system, look.numeric, Settings()).together
    claims = f"claims: [{{experiment: vertical, directions: [{', '.join(KERNEL)}]}}]\n"
    [claim] = model(bare("ins_calibration/vertical.yaml") + VERTICAL + claims).claims
    directions = numbers([one.coefficients for one in claim.directions], list(found.exact.shared), VALUES)

    kernel = seen.spaces.kernel(-1)
    assert kernel.shape[-1] == 3
    in_units = seen.spaces.gramian.units[-1][:, None] * kernel
    own = np.linalg.svd(in_units.T, full_matrices=False)[2]
    leak = directions.T - own.T @ (own @ directions.T)
    assert np.abs(leak).max() < 1e-8 * np.abs(directions).max()


def test_each_axis_up_and_down_determines_everything(vertical, calibrated):
    found = calibrated(vertical, *(f"{name}_{k}" for name in ("stage", "down") for k in (1, 2, 3)))

    assert_both_sides(found, 21)
    assert found.exact.stack.finding.unobservable == ()
