"""Standard deviations from prior and information: direct inversion, what is infinite, what must not change."""

import numpy as np
import pytest

from obscli.numeric.deviation import deviations, unseen


INF = np.inf


def found(prior, root, forms, rows=None):
    """Deviations of linear forms; ``rows``: what is seen exactly, where it is not the root itself."""
    prior, root, forms = (
        np.array(one, dtype=float).reshape(-1, np.shape(forms)[1]) for one in (prior, root, forms)
    )
    seen = root if rows is None else np.array(rows, dtype=float).reshape(-1, forms.shape[1])
    return deviations(prior, root, forms, unseen(seen))


def inverted(prior, root, forms):
    """By direct inversion of the information, where it can be inverted."""
    covariance = np.linalg.inv(prior.T @ prior + root.T @ root)
    return np.sqrt(np.einsum("ki,ij,kj->k", forms, covariance, forms))


def with_prior(source, n, given, *, correlated=False):
    """Rows of information of a random prior on some states."""
    P = np.diag(source.uniform(0.3, 3, n) ** 2)[np.ix_(given, given)]
    if correlated:
        mixed = source.normal(size=(len(given), len(given)))
        P = P + 0.3 * mixed @ mixed.T
    rows = np.zeros((len(given), n))
    if len(given):
        rows[:, given] = np.linalg.inv(np.linalg.cholesky(P))
    return rows


def forms_of(source, n):
    return np.vstack([np.eye(n), source.normal(size=(4, n))])


@pytest.mark.parametrize("correlated", [False, True])
@pytest.mark.parametrize("seed", range(10))
def test_with_a_full_prior_by_direct_inversion(seed, correlated):
    source = np.random.default_rng(seed)
    n = int(source.integers(1, 7))
    prior = with_prior(source, n, np.arange(n), correlated=correlated)
    forms = forms_of(source, n)
    for r in range(n + 3):
        root = source.normal(size=(r, n))
        np.testing.assert_allclose(found(prior, root, forms), inverted(prior, root, forms), rtol=1e-9)


@pytest.mark.parametrize("seed", range(10))
def test_without_a_prior_by_direct_inversion(seed):
    source = np.random.default_rng(seed)
    n = int(source.integers(1, 7))
    root, forms = source.normal(size=(n + 2, n)), forms_of(source, n)
    np.testing.assert_allclose(
        found(np.zeros((0, n)), root, forms), inverted(np.zeros((0, n)), root, forms), rtol=1e-9
    )


@pytest.mark.parametrize("correlated", [False, True])
@pytest.mark.parametrize("seed", range(20))
def test_with_a_prior_of_some_states_by_direct_inversion(seed, correlated):
    """As many rows as states without a prior, or more: together they see everything."""
    source = np.random.default_rng(seed)
    n = int(source.integers(2, 7))
    given = np.sort(source.choice(n, int(source.integers(1, n)), replace=False))
    prior, forms = with_prior(source, n, given, correlated=correlated), forms_of(source, n)
    for r in range(n - len(given), n + 2):
        root = source.normal(size=(r, n))
        np.testing.assert_allclose(found(prior, root, forms), inverted(prior, root, forms), rtol=1e-8)


@pytest.mark.parametrize("seed", range(10))
def test_with_nothing_learned_only_the_prior_is_left(seed):
    source = np.random.default_rng(seed)
    n = int(source.integers(2, 6))
    given = np.sort(source.choice(n, int(source.integers(1, n)), replace=False))
    prior = with_prior(source, n, given, correlated=True)
    P = np.linalg.inv(prior[:, given].T @ prior[:, given])
    expected = np.full(n, INF)
    expected[given] = np.sqrt(np.diag(P))
    np.testing.assert_allclose(found(prior, np.zeros((0, n)), np.eye(n)), expected, rtol=1e-10)
    np.testing.assert_allclose(found(prior, np.zeros((3, n)), np.eye(n)), expected, rtol=1e-10)


# -- what is infinite


@pytest.mark.parametrize(
    ("prior", "root", "form", "expected"),
    [
        # b goes with c, whatever the size of what is known of a
        ([], [[1e-3, 0, 0], [0, 1e6, 1e6]], [1, 1, 0], INF),
        ([], [[1e-3, 0, 0], [0, 1e6, 1e6]], [0, 1, 1], 1e-6),
        ([], [[1e-3, 0, 0], [0, 1e6, 1e6]], [1, 0, 0], 1e3),
        ([], [[1, 0], [1e-9, 1e-9]], [0, 1], 1e9),
        ([], [[1, -1, 0]], [1, -1, 0], 1),
        ([], [[1, -1, 0]], [1, 0, 0], INF),
        ([], [[1, -1, 0]], [0, 0, 1], INF),
        # nothing sees b, though a - c is known badly
        ([], [[1e-7, 0, -1e-7]], [-1, 1, 1], INF),
        ([], [[1e-7, 0, -1e-7]], [-1, 0, 1], 1e7),
        # c of the prior's b and d, which y = b - c - d ties together, while nothing sees a
        ([[0, 0.2, 0, 0], [0, 0, 0, 0.5]], [[0, 1, -1, -1]], [0, 1, 0, 0], 5),
        ([[0, 0.2, 0, 0], [0, 0, 0, 0.5]], [[0, 1, -1, -1]], [1, 0, 0, 0], INF),
        ([[1]], [], [1], 1),
        ([], [], [1], INF),
    ],
)
def test_what_is_known_and_what_is_not(prior, root, form, expected):
    np.testing.assert_allclose(found(prior, root, [form]), [expected], rtol=1e-9)


@pytest.mark.parametrize(
    ("root", "form"),
    [
        ([[0, -2, -1, 0, 0]], [0, -2, -1, 0, 0]),
        ([[0, 2, 1, 0, 0]], [0, 2, 1, 0, 0]),
        ([[0, 2, 2, -1, 1]], [0, 2, 2, -1, 1]),
    ],
)
def test_what_is_measured_itself_is_as_good_as_its_noise(root, form):
    np.testing.assert_allclose(found([], root, [form]), [1])


@pytest.mark.parametrize(
    ("prior", "root", "form", "expected"),
    [
        # c = b - d - y: known from the priors of b and d and the noise
        ([[0, 0.2, 0, 0], [0, 0, 0, 0.5]], [[0, 1, -1, -1]], [0, 0, 1, 0], 30**0.5),
        ([[1, 0, 0, 0, 0]], [[0, 1, -2, -1, -1], [-2, 1, 2, 1, 1]], [0, 1, 0, 0, 0], 1.5**0.5),
    ],
)
def test_what_priors_and_noise_tie_down_is_finite(prior, root, form, expected):
    np.testing.assert_allclose(found(prior, root, [form]), [expected])


def by_null_space(prior, root, forms):
    """The reference where not all is known: pseudo-inverse of a well-conditioned information of whole numbers."""
    information = prior.T @ prior + root.T @ root
    covariance = np.linalg.pinv(information, rcond=1e-9)
    inside = np.abs(forms @ covariance @ information - forms).max(axis=1) < 1e-7
    squared = np.einsum("ki,ij,kj->k", forms, covariance, forms)
    return np.where(inside, np.sqrt(np.maximum(squared, 0.0)), INF)


def rows_of_whole_numbers(source):
    n = int(source.integers(2, 6))
    return source.integers(-2, 3, (int(source.integers(1, n + 1)), n)).astype(float)


@pytest.mark.parametrize("share", [0.0, 0.4])
def test_where_not_all_is_seen_by_the_pseudo_inverse(known, share):
    for seed in range(300):
        source = np.random.default_rng(seed)
        root = rows_of_whole_numbers(source)
        n = root.shape[1]
        prior = with_prior(source, n, np.flatnonzero(source.random(n) < share))
        forms = np.vstack([np.eye(n), root, source.integers(-1, 2, (4, len(root))) @ root])
        rows = [[float(x) for x in row] for row in known.reduced(root.tolist())]
        np.testing.assert_allclose(
            found(prior, root, forms, rows), by_null_space(prior, root, forms), rtol=1e-6, atol=1e-12
        )


# -- a prior is finite, and learning does no harm


@pytest.mark.parametrize("width", [1, 1e3, 1e6, 1e9])
@pytest.mark.parametrize("noise", [1e-14, 1e-6, 1.0, 1e6])
def test_measuring_a_sum_leaves_each_part_at_its_prior_over_the_root_of_two(width, noise):
    """y = a + b with R; P0_std of a and b alike."""
    a, b, total = found(np.eye(2) / width, [[noise**-0.5, noise**-0.5]], [[1, 0], [0, 1], [1, 1]])
    part = width * ((width**2 + noise) / (2 * width**2 + noise)) ** 0.5
    np.testing.assert_allclose([a, b], part, rtol=1e-6)
    # of the sum only what noise and width leave of their digits
    expected = (2 * width**2 * noise / (2 * width**2 + noise)) ** 0.5
    assert total == pytest.approx(expected, rel=1e-6, abs=1e-14 * width)


@pytest.mark.parametrize("seed", range(40))
def test_a_finite_prior_never_becomes_infinite_or_wider_by_measuring(seed):
    """States from 1e-8 to 1e8, rows from 1e-8 to 1e8, taken in one after the other."""
    source = np.random.default_rng(seed)
    n = int(source.integers(1, 6))
    prior = np.diag(10.0 ** source.uniform(-8, 8, n))
    root, before = np.zeros((0, n)), found(prior, np.zeros((0, n)), np.eye(n))
    np.testing.assert_allclose(before, 1 / np.diag(prior), rtol=1e-12)
    for _ in range(2 * n):
        root = np.vstack([root, source.integers(-2, 3, n) * 10.0 ** source.uniform(-8, 8)])
        after = found(prior, root, np.eye(n))
        assert np.isfinite(after).all()
        assert (after <= before * (1 + 1e-6)).all()
        before = after


@pytest.mark.parametrize("seed", range(20))
def test_more_information_makes_no_deviation_larger(seed):
    """Without any prior, once all is seen."""
    source = np.random.default_rng(seed)
    n = int(source.integers(1, 6))
    root, forms = source.normal(size=(n, n)), forms_of(source, n)
    before = found(np.zeros((0, n)), root, forms)
    for _ in range(n):
        root = np.vstack([root, source.normal(size=n) * 10.0 ** source.uniform(-3, 3)])
        after = found(np.zeros((0, n)), root, forms)
        assert (after <= before * (1 + 1e-9)).all()
        before = after


@pytest.mark.parametrize("seed", range(20))
def test_units_by_powers_of_two_change_nothing(seed):
    source = np.random.default_rng(seed)
    n = int(source.integers(2, 6))
    given = np.sort(source.choice(n, int(source.integers(1, n)), replace=False))
    prior, forms = with_prior(source, n, given, correlated=True), forms_of(source, n)
    root = source.normal(size=(n + 1, n))
    units = 2.0 ** source.integers(-30, 31, n)
    np.testing.assert_allclose(
        found(prior * units, root * units, forms * units), found(prior, root, forms), rtol=1e-9
    )


@pytest.mark.parametrize("seed", range(10))
def test_the_noise_by_a_power_of_two_scales_what_is_learned(seed):
    source = np.random.default_rng(seed)
    n = int(source.integers(1, 6))
    root, forms = source.normal(size=(n + 1, n)), forms_of(source, n)
    none = np.zeros((0, n))
    np.testing.assert_allclose(found(none, root / 8, forms), 8 * found(none, root, forms), rtol=1e-12)
