"""Segments one after the other: ranks, the condition of the stripped matrix, when what becomes observable."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest

from obscli.numeric.local_stack import frozen_stack
from obscli.numeric.numeric_system import Coefficients
from obscli.numeric.piecewise_constant import Segments, piecewise_constant


_spec = importlib.util.spec_from_file_location("flights", Path(__file__).with_name("flights.py"))
flown = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(flown)


def segments(A, H, durations, h=1.0, form="continuous"):
    """Segments of whole matrices A (r, n, n), H (r, m, n)."""
    A, H = np.asarray(A, dtype=float), np.asarray(H, dtype=float)
    n, starts = A.shape[1], np.concatenate([[0.0], np.cumsum(durations)[:-1]])
    found = Coefficients(A, H, np.zeros_like(A), np.zeros_like(H))
    stack = frozen_stack(found, np.arange(n), form, n, h)
    return Segments(starts, np.asarray(durations, dtype=float), found.A, found.A_error, stack)


def analysed(A, H, durations, **options):
    n = np.shape(A)[1]
    return piecewise_constant([segments(A, H, durations, **options)], np.arange(n), np.ones(n), np.eye(n))


def along(case, *, earth, form="continuous", h=1.0, portions=1):
    flight = flown.Flight(case).at(np.arange(5.5, 35.5))
    found = flight.coefficients(earth=earth)
    parts = []
    for some in np.array_split(np.arange(len(flight.t)), portions):
        part = Coefficients(found.A[some], found.H[some], found.A_error[some], found.H_error[some])
        stack = frozen_stack(part, flown.MOVING, form, 15, h).weighed(np.diag(1 / flown.NOISE))
        parts.append(Segments(flight.t[some], np.ones(len(some)), part.A, part.A_error, stack))
    return piecewise_constant(parts, flown.MOVING, flown.PRIOR, np.eye(15))


# --- small systems ---------------------------------------------------------------------------------------------


def test_one_segment_is_its_own_observability_matrix():
    found = analysed([[[0, 1, 0], [0, 0, 0], [0, 0, 0]]], [[[1, 0, 0]]], [2.0])
    assert found.local_rank.tolist() == found.total_rank.tolist() == found.stripped_rank.tolist() == [2]
    assert found.holds
    assert found.since[:2].tolist() == [2.0, 2.0]
    assert np.isnan(found.since[2])


def test_outputs_that_change_add_their_states():
    A = np.zeros((3, 3, 3))
    H = np.eye(3)[:, None, :]
    found = analysed(A, H, [1.0, 2.0, 3.0])
    assert found.local_rank.tolist() == [1, 1, 1]
    assert found.total_rank.tolist() == found.stripped_rank.tolist() == [1, 2, 3]
    assert found.since.tolist() == [1.0, 3.0, 6.0]


def test_the_stripped_matrix_may_miss_what_the_total_one_shows():
    # the hidden state turns into the plane of the others between segments, never inside one
    A = np.zeros((2, 3, 3))
    A[:, 1, 2] = 1.0
    H = np.array([[[1.0, 0, 0]], [[0, 0, 0]]])
    H[1, 0, 0] = 1.0
    A[:, 0, :] = 0.0
    hidden = analysed(A, H, [1.0, 1.0])
    assert hidden.local_rank.tolist() == [1, 1]
    assert not hidden.holds
    A[1, 0, 1] = 1.0  # now the second segment sees b, and through it c
    A[1, 1, 2] = 0.0
    found = analysed(A, H, [1.0, 1.0])
    assert found.stripped_rank[-1] == 2
    assert found.total_rank[-1] == 2
    assert found.violated.tolist() == [True, False]
    # b(1) = b(0) + c: the total matrix shows the sum, the stripped one b alone
    assert np.isnan(found.since[1:]).all()


def test_rank_and_null_space_agree_where_the_condition_holds():
    rng = np.random.default_rng(4)
    for _ in range(5):
        basis = np.linalg.qr(rng.normal(size=(5, 5)))[0]
        A = np.zeros((3, 5, 5))
        A[:, :3, :3] = rng.normal(size=(3, 3, 3))
        A, H = basis @ A @ basis.T, np.tile(np.eye(5)[:1] @ basis.T, (3, 1, 1))
        found = analysed(A, H, [0.5, 0.5, 0.5])
        assert found.holds
        assert (found.total_rank == found.stripped_rank).all()
        assert (found.total_rank == 3).all()


def test_the_rank_does_not_depend_on_the_form_of_the_local_matrices():
    rng = np.random.default_rng(6)
    A, H = rng.normal(size=(4, 4, 4)), rng.normal(size=(4, 1, 4))
    A[:, :, 3] = 0
    H[:, :, 3] = 0
    ranks = [
        analysed(A, H, [0.3] * 4, form=form, h=h).total_rank.tolist()
        for form, h in (("continuous", 1.0), ("continuous", 0.1), ("discrete", 0.2))
    ]
    assert ranks == [[3, 3, 3, 3]] * 3


def test_a_sampled_system_has_the_ranks_of_the_one_it_samples():
    from scipy.linalg import expm

    rng = np.random.default_rng(9)
    A, H = np.zeros((3, 4, 4)), rng.normal(size=(3, 1, 4))
    A[:, :2] = rng.normal(size=(3, 2, 4))
    F = expm(0.2 * A)
    given = segments(A, H, [1.0] * 3)
    sampled = segments(F, H, [1.0] * 3)
    powers = np.linalg.matrix_power(F, 5)
    stepped = Segments(sampled.starts, sampled.durations, F - np.eye(4), 0 * F, sampled.stack, powers)
    found = [piecewise_constant([one], np.arange(4), np.ones(4), np.eye(4)) for one in (given, stepped)]
    for name in ("local_rank", "total_rank", "stripped_rank", "violated", "since"):
        np.testing.assert_array_equal(getattr(found[0], name), getattr(found[1], name))


# --- the rocket ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("case", flown.CASES)
@pytest.mark.parametrize(("form", "h"), [("continuous", 1.0), ("discrete", 0.1)])
def test_with_the_rate_of_the_earth_the_condition_holds(case, form, h):
    found = along(case, earth=True, form=form, h=h)
    assert found.decided
    assert (found.local_rank == 12).all()
    assert found.holds
    assert found.residual.max() < 1e-9
    until = found.stops <= 9.5
    assert found.total_rank[until][-1] == found.stripped_rank[until][-1] == 15
    assert (found.since <= 9.5).all()


@pytest.mark.parametrize(("form", "h"), [("continuous", 1.0), ("discrete", 0.1)])
def test_without_it_the_condition_fails_and_the_stripped_matrix_misses_the_roll_gyro(form, h):
    found = along("uncontrolled", earth=False, form=form, h=h)
    assert found.decided
    assert (found.local_rank == 11).all()
    assert found.violated.all()
    assert (found.stripped_rank[-1], found.total_rank[-1]) == (14, 15)
    # the gyro bias along the specific force, unseen, turns the attitude: its prior by the prior of attitude
    np.testing.assert_allclose(found.residual, 100 / 3600 / 5, rtol=1e-9)


def test_equal_ranks_are_not_equal_degrees():
    found = along("uncontrolled", earth=True, form="discrete", h=0.1)
    assert found.total_rank[-1] == found.stripped_rank[-1] == 15
    assert found.total_values[-1] > 1e3 * found.stripped_values[-1]


def test_portions_do_not_change_the_values():
    whole, parts = (along("yaw", earth=True, portions=k) for k in (1, 7))
    np.testing.assert_array_equal(whole.total_rank, parts.total_rank)
    np.testing.assert_allclose(whole.total_values, parts.total_values, rtol=1e-8)
    np.testing.assert_array_equal(whole.since, parts.since)
