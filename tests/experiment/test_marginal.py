"""What is left of a Gramian on some states, the others eliminated: the Schur complement, and its error."""

import numpy as np
import pytest

from obscli.numeric.gramian import Gramian
from obscli.numeric.marginal import joined, marginal
from obscli.numeric.program import EPS
from obscli.numeric.subspace import subspaces


def spaces_of(matrix, error=None, units=None):
    """The decomposition of one square root R (n, n), its error |ΔR v|² ≤ vᵀ E v, in units D: R D."""
    n = matrix.shape[1]
    units = np.ones(n) if units is None else units
    error = EPS**2 * np.diag((matrix**2).sum(axis=0)) if error is None else error
    instants = np.array([1.0])
    scaled = error * units * units[:, None]
    return subspaces(
        Gramian(
            "square-root",
            instants,
            0 * instants,
            (matrix * units)[None],
            units[None],
            scaled[None],
            0 * instants,
        )
    )


def schur(W, kept):
    """Wkk − Wku Wuu⁺ Wuk."""
    unknown = np.setdiff1d(np.arange(len(W)), kept)
    Wku = W[np.ix_(kept, unknown)]
    return W[np.ix_(kept, kept)] - Wku @ np.linalg.pinv(W[np.ix_(unknown, unknown)]) @ Wku.T


def example(seed):
    """A well-conditioned square root, and which states are kept."""
    source = np.random.default_rng(seed)
    n = int(source.integers(2, 9))
    kept = np.sort(source.choice(n, int(source.integers(1, n)), replace=False))
    left, _, right = np.linalg.svd(source.normal(size=(n, n)))
    return source, left * source.uniform(0.3, 3, n) @ right, kept


def information(found):
    return found.root.T @ found.root


@pytest.mark.parametrize("seed", range(30))
def test_it_is_the_schur_complement(seed):
    _, R, kept = example(seed)
    found = marginal(spaces_of(R), 0, kept)
    np.testing.assert_allclose(information(found), schur(R.T @ R, kept), rtol=1e-9, atol=1e-10)
    assert found.decided


@pytest.mark.parametrize("seed", range(15))
def test_it_is_the_inverse_of_the_covariance_of_the_states_kept(seed):
    _, R, kept = example(seed)
    covariance = np.linalg.inv(R.T @ R)[np.ix_(kept, kept)]
    np.testing.assert_allclose(
        np.linalg.inv(information(marginal(spaces_of(R), 0, kept))), covariance, rtol=1e-8, atol=1e-10
    )


@pytest.mark.parametrize("seed", range(30))
def test_units_by_powers_of_two_change_nothing_beyond_the_error(seed):
    """|S v| of a Gramian known to some hundred units of rounding; S itself is free up to a rotation."""
    source, R, kept = example(seed)
    units = 2.0 ** source.integers(-3, 4, len(R))
    error = (256 * EPS) ** 2 * np.diag((R**2).sum(axis=0))
    one, other = (marginal(spaces_of(R, error, D), 0, kept) for D in (None, units))
    assert one.decided
    assert other.decided
    for v in np.vstack([np.eye(len(kept)), source.normal(size=(10, len(kept)))]):
        moved = abs(np.linalg.norm(one.root @ v) - np.linalg.norm(other.root @ v))
        assert moved <= np.sqrt(v @ one.error @ v) + np.sqrt(v @ other.error @ v)


@pytest.mark.parametrize("seed", range(15))
def test_all_states_kept_nothing_is_eliminated(seed):
    _, R, _ = example(seed)
    found = marginal(spaces_of(R), 0, np.arange(len(R)))
    np.testing.assert_allclose(information(found), R.T @ R, rtol=1e-12, atol=1e-13)


def blind(seed):
    """The same with columns of zeros for the states that are eliminated, and what is told of the others."""
    _, R, kept = example(seed)
    R[:, np.setdiff1d(np.arange(len(R)), kept)] = 0.0
    return marginal(spaces_of(R), 0, kept), (R.T @ R)[np.ix_(kept, kept)]


def test_states_that_nothing_sees_take_nothing_away():
    for seed in range(100):
        found, W = blind(seed)
        assert found.decided
        np.testing.assert_allclose(information(found), W, rtol=1e-9, atol=1e-10)


@pytest.mark.parametrize("seed", range(15))
def test_what_goes_with_the_unknown_states_is_not_known(seed):
    """y = ξ + c: nothing is left of c; with c' beside it, that is left."""
    source = np.random.default_rng(seed)
    F, G = source.normal(size=(6, 2)), source.normal(size=(6, 2))
    rows = np.hstack([F, F @ source.normal(size=(2, 2)), G])
    R = np.linalg.qr(rows)[1]
    found = marginal(spaces_of(np.vstack([R, np.zeros((6 - len(R), 6))])), 0, np.arange(2, 6))
    values = np.linalg.svd(found.root, compute_uv=False)
    assert (values > 1e-3).sum() == 2


@pytest.mark.parametrize("size", [1e-9, 1e-6, 1e-4])
@pytest.mark.parametrize("seed", range(20))
def test_its_error_covers_what_a_perturbation_changes(seed, size):
    """R + ΔR with E = ΔRᵀ ΔR: | |S' v| − |S v| | ≤ √(vᵀ E v) of the marginal, to first order."""
    source, R, kept = example(seed)
    off = size * source.normal(size=R.shape)
    found = marginal(spaces_of(R, error=off.T @ off), 0, kept)
    true = marginal(spaces_of(R + off), 0, kept)
    for _ in range(50):
        v = source.normal(size=len(kept))
        moved = abs(np.linalg.norm(true.root @ v) - np.linalg.norm(found.root @ v))
        assert moved <= np.sqrt(v @ found.error @ v) * (1 + 100 * size) + 1e-14 * np.linalg.norm(v)


@pytest.mark.parametrize("seed", range(10))
def test_its_error_is_no_larger_than_it_has_to_be(seed):
    """Some perturbation of the size of the error moves S v by a good part of the bound."""
    source, R, kept = example(seed)
    size, best = 1e-7, 0.0
    E = size**2 * np.eye(len(R))
    found = marginal(spaces_of(R, error=E), 0, kept)
    v = source.normal(size=len(kept))
    bound = np.sqrt(v @ found.error @ v)
    for _ in range(200):
        off = source.normal(size=R.shape)
        off *= size / np.linalg.norm(off, 2)
        true = marginal(spaces_of(R + off), 0, kept)
        best = max(best, abs(np.linalg.norm(true.root @ v) - np.linalg.norm(found.root @ v)))
    assert bound / 30 < best <= bound * (1 + 1e-4)


@pytest.mark.parametrize("seed", range(10))
def test_runs_add_up(seed):
    """The joint Gramian is the sum of what each tells; its error the sum of theirs."""
    source, R, kept = example(seed)
    parts = [marginal(spaces_of(R + 0.1 * source.normal(size=R.shape)), 0, kept) for _ in range(3)]
    labels = np.array([1.0, 2.0])
    both = joined(labels, [parts[:2], parts])
    for W, group, error in zip(
        both.matrices.transpose(0, 2, 1) @ both.matrices, (parts[:2], parts), both.error, strict=True
    ):
        np.testing.assert_allclose(W, sum(information(one) for one in group), rtol=1e-10, atol=1e-12)
        assert np.linalg.eigvalsh(error - sum(one.error for one in group)).min() >= -1e-25
    assert list(both.instants) == [1.0, 2.0]
    assert both.is_root


def test_a_direction_between_noise_and_information_is_not_decided():
    """ξ is seen at 50 times its noise: it may be there, and take a row of c away, or not."""
    R = np.array([[1e-6, 1.0], [0.0, 1.0]])
    error = np.diag([(2e-8) ** 2, 0.0])
    assert not marginal(spaces_of(R, error=error), 0, np.array([1])).decided
    assert marginal(spaces_of(R), 0, np.array([1])).decided
