"""r counts the singular values above ten times their noise; the rank is decided where σ_r is ten times above that."""

import numpy as np
import pytest

from obscli.numeric.gramian import Gramian
from obscli.numeric.leak import leak_of
from obscli.numeric.subspace import subspaces


UNITS = np.array([1.0, 1e3, 0.5, 20.0])


def spaces(values, error=1e-12, units=UNITS, seed=0):
    """The subspaces of M = U diag(values) Vᵀ at one instant, with |ΔM v| ≲ error |v|."""
    n = len(values)
    U, _, V = np.linalg.svd(np.random.default_rng(seed).normal(size=(n, n)))
    M = U @ np.diag(values) @ V
    one = np.ones(1)
    return subspaces(
        Gramian("square-root", one, 0 * one, M[None], units[None], error**2 * np.eye(n)[None], 0 * one)
    )


@pytest.mark.parametrize(
    ("values", "rank", "decided"),
    [
        ((1, 0.5, 1e-3, 1e-6), 4, True),
        ((1, 0.5, 1e-3, 0), 3, True),
        ((1, 0.5, 1e-3, 5e-12), 3, True),
        ((1, 0.5, 1e-3, 5e-11), 4, False),
        ((1, 0.5, 3e-11, 0), 3, False),
        ((1, 1e-10, 0, 0), 2, False),
        ((1, 0, 0, 0), 1, True),
        ((1e-11, 0, 0, 0), 0, False),
        ((0, 0, 0, 0), 0, False),
    ],
)
def test_rank_and_grey_zone(values, rank, decided):
    found = spaces(values)
    assert (found.rank[0], found.decided[0]) == (rank, decided)
    assert found.kernel(0).shape == (4, 4 - rank)
    # the noise of direction k is that of all from k on: 1e-12 √(n − k + 1), SVD roundings are far below
    np.testing.assert_allclose(found.noise[0], 1e-12 * np.sqrt([4, 3, 2, 1]), rtol=1e-6)
    assert found.tolerance[0] == pytest.approx(10 * found.noise[0, min(rank, 3)])
    if rank:
        first = max(values[rank] if rank < 4 else 0, found.noise[0, min(rank, 3)])
        assert found.gap[0] == pytest.approx(values[rank - 1] / first, rel=1e-3)
    else:
        assert np.isnan(found.gap[0])


def test_no_error_and_no_matrix_is_rank_0_for_certain():
    found = spaces((0, 0, 0, 0), error=0.0)
    assert (found.rank[0], found.decided[0]) == (0, True)


@pytest.mark.parametrize("units", [np.ones(4), UNITS, np.array([1e-3, 1e6, 1, 1e-6])])
def test_the_kernel_is_orthonormal_in_the_files_units(units):
    found = spaces((1, 0.3, 0, 0), units=units)
    kernel = found.kernel(0)
    inner = (units[:, None] * kernel).T @ (units[:, None] * kernel)
    np.testing.assert_allclose(inner, np.eye(2), atol=1e-9)
    M = found.gramian.matrices[0]
    assert np.abs(M @ kernel).max() <= 1e-14 * np.linalg.norm(kernel)


def test_the_pull_of_a_combination_is_the_length_of_its_preimage():
    """s = uᵀ M D⁻¹ with u = (s D M⁺)ᵀ."""
    found = spaces((2, 0.5, 1e-4, 0))
    M = found.gramian.matrices[0]
    u = np.array([0.3, -1.0, 2.0, 0.0])
    u = M @ np.linalg.pinv(M, rcond=1e-9) @ u  # within the range
    s = (u @ M) / UNITS
    assert found.pull(s, 0) == pytest.approx(np.linalg.norm(u), rel=1e-9)


def test_noise_along_directions():
    found = spaces((1, 1, 1, 0))
    v = np.array([[3.0, 0], [0, 1], [4, 0], [0, 0]])
    np.testing.assert_allclose(found.noise_along(v, 0), [5e-12, 1e-12])


def test_one_instant_of_many():
    both = spaces((1, 0.5, 1e-3, 0))
    one = both.only(0)
    assert (one.rank == both.rank).all()
    np.testing.assert_array_equal(one.kernel(0), both.kernel(0))


def test_the_leak_is_the_largest_cosine_with_the_kernel():
    found = spaces((1, 0.3, 0, 0))
    kernel = UNITS[:, None] * found.kernel(0)
    rows = np.random.default_rng(3).normal(size=(1, 5, 4))
    leak = leak_of(found, rows, np.zeros_like(rows))
    expected = np.abs(rows[0] @ kernel).max(axis=1) / np.linalg.norm(rows[0], axis=1)
    np.testing.assert_allclose(leak.chi[0], expected, rtol=1e-9)
    assert (leak.chi[0] > 1e3 * leak.bound[0]).all()


def test_rows_of_the_matrix_do_not_leak_above_the_bound():
    """Whatever the error of M: perturb it by that, and right rows stay below their bound."""
    source = np.random.default_rng(4)
    exact = spaces((1, 0.3, 1e-3, 0))
    M = exact.gramian.matrices[0]
    for _ in range(20):
        off = M + 1e-9 * source.normal(size=(4, 4))
        g = Gramian(
            "square-root", np.ones(1), np.zeros(1), off[None], UNITS[None],
            (2 * 1e-9) ** 2 * np.eye(4)[None], np.zeros(1),
        )  # fmt: skip
        found = subspaces(g)
        assert found.rank[0] == 3
        rows = (source.normal(size=(6, 4)) @ M / UNITS)[None]
        leak = leak_of(found, rows, np.zeros_like(rows))
        # the length of a normal 4-vector is 2 on average, and seldom above 4
        assert (leak.chi <= 2 * leak.bound).all()
