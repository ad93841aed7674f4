"""The real logarithm undoes the exponential, and is refused where there is none."""

import numpy as np
import pytest
from scipy.linalg import expm

from obscli.numeric.errors import NotComputableError
from obscli.numeric.matrix_logarithm import real_logarithm, square_root


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("n", [1, 2, 5, 12])
def test_it_undoes_the_exponential(n, seed):
    X = np.random.default_rng(seed).normal(size=(n, n))
    X *= 2 / np.linalg.norm(X, 2)  # eigenvalues within ±π
    np.testing.assert_allclose(real_logarithm(expm(X)), X, atol=1e-13 * n)


@pytest.mark.parametrize("angle", [0.0, 1.0, 3.0, 3.14])
def test_rotations_have_their_angle(angle):
    """Near the half turn roots and logarithm each magnify rounding by the angle that is left."""
    J = np.array([[0.0, -1.0], [1.0, 0.0]])
    allowed = 1e-14 + np.finfo(float).eps / (np.pi - angle) ** 2
    np.testing.assert_allclose(real_logarithm(expm(angle * J)), angle * J, rtol=0, atol=allowed)


@pytest.mark.parametrize("n", [2, 3, 6])
def test_jordan_blocks(n):
    N = np.eye(n, k=1)
    np.testing.assert_allclose(real_logarithm(expm(N)), N, atol=1e-12)
    np.testing.assert_allclose(
        square_root(np.eye(n) + N) @ square_root(np.eye(n) + N), np.eye(n) + N, atol=1e-12
    )


@pytest.mark.parametrize("seed", range(10))
def test_roots_multiply_to_the_matrix(seed):
    A = expm(np.random.default_rng(seed).normal(size=(6, 6)))
    root = square_root(A)
    assert np.linalg.norm(root @ root - A) < 1e-13 * np.linalg.norm(root) ** 2


def test_logarithms_of_commuting_matrices_add():
    A = np.array([[2.0, 1.0], [0.5, 3.0]])
    np.testing.assert_allclose(real_logarithm(A @ A @ A), 3 * real_logarithm(A), rtol=1e-12)


@pytest.mark.parametrize(
    "A", [[[-1.0]], [[0.0]], [[1.0, 0.0], [0.0, -2.0]], [[-1.0, 0.0], [0.0, -1.0]], [[1.0, 1.0], [1.0, 1.0]]]
)
def test_what_has_no_principal_real_logarithm_is_refused(A):
    with pytest.raises(NotComputableError, match="negative real axis"):
        real_logarithm(np.array(A))
