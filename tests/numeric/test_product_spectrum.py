"""Products of many matrices: spectra that are known in closed form, however far apart, and their errors."""

from itertools import pairwise

import flint
import numpy as np
import pytest

from obscli.numeric.product_spectrum import product_spectrum


def exactly(factors, bits=4000):
    """ln of the singular values and of the moduli of the eigenvalues, the largest first, in balls."""
    before = flint.ctx.prec
    flint.ctx.prec = bits
    try:
        product = flint.acb_mat(len(factors[0]), len(factors[0]))
        for k in range(len(factors[0])):
            product[k, k] = 1
        for factor in factors:
            product = flint.acb_mat([[float(v) for v in row] for row in factor]) * product
        squares = (product * product.transpose()).eig()
        gains = sorted((float(abs(v).log().mid()) / 2 for v in squares), reverse=True)
        moduli = sorted((float(abs(v).log().mid()) for v in product.eig()), reverse=True)
        return np.array(gains), np.array(moduli)
    finally:
        flint.ctx.prec = before


def random_factors(seed):
    source = np.random.default_rng(seed)
    d, K = source.integers(2, 6), source.integers(1, 60)
    return [source.normal(size=(d, d)) for _ in range(K)]


def spectrum(factors, error=1e-16):
    return product_spectrum(factors, [error] * len(factors), eigenvalues=True)


def moduli(found):
    return np.array([one.log_modulus for one in found.eigenvalues])


@pytest.mark.parametrize("seed", range(12))
def test_every_value_has_the_error_it_says(seed):
    factors = random_factors(seed)
    gains, sizes = exactly(factors)
    found = spectrum(factors)
    assert (np.abs(found.gains - gains) <= found.gain_errors).all()
    assert (np.abs(moduli(found) - sizes) <= found.eigenvalue_errors).all()
    assert found.gain_errors.max() < 1e-8


@pytest.mark.parametrize("K", [1, 30, 1000])
def test_what_shrinks_is_as_accurate_as_what_grows(K):
    """(S Λ S⁻¹)^K = S Λ^K S⁻¹: eigenvalues from 10^-752 to 10^752, one rounding of S Λ S⁻¹ for each."""
    S = np.array([[1.0, 2, 3], [0, 1, 4], [0, 0, 1]])
    rates = np.array([2.5, 0.0, -2.5])
    factor = S @ np.diag(2**rates) @ np.linalg.inv(S)
    found = spectrum([factor] * K, 1e-15)
    assert moduli(found) == pytest.approx(K * rates * np.log(2), abs=K * 1e-13)
    assert (found.eigenvalue_errors < K * 1e-11).all()
    assert found.gains.sum() == pytest.approx(0, abs=K * 1e-12)  # ln det


@pytest.mark.parametrize("seed", range(5))
def test_volumes_multiply(seed):
    factors = random_factors(100 + seed)
    volume = sum(np.linalg.slogdet(one)[1] for one in factors)
    found = spectrum(factors)
    assert found.gains.sum() == pytest.approx(volume, abs=1e-9)
    assert moduli(found).sum() == pytest.approx(volume, abs=1e-9)
    assert all(a >= b for a, b in pairwise(found.gains))
    assert found.gains[0] >= moduli(found)[0] - 1e-12  # no eigenvalue exceeds the norm


@pytest.mark.parametrize("seed", range(5))
def test_the_vectors_are_what_is_stretched_and_what_keeps_its_direction(seed):
    factors = random_factors(200 + seed)[:4]
    found = spectrum(factors)
    product = np.eye(len(factors[0]))
    for factor in factors:
        product = factor @ product
    assert found.right @ found.right.T == pytest.approx(np.eye(len(product)), abs=1e-12)
    assert np.linalg.norm(product @ found.right.T, axis=0) == pytest.approx(np.exp(found.gains), rel=1e-8)
    for one in found.eigenvalues:
        value = np.exp(one.log_modulus) * one.phase
        assert np.abs(product @ one.vector - value * one.vector).max() < 1e-11 * np.linalg.norm(product)


def test_where_factors_begin_changes_no_eigenvalue():
    """C_1 … C_K and C_2 … C_K, C_1 have the same ones."""
    factors = random_factors(7)
    turned = [*factors[1:], factors[0]]
    assert moduli(spectrum(turned)) == pytest.approx(moduli(spectrum(factors)), abs=1e-9)


def test_a_pair_that_cannot_be_told_apart_says_so():
    """The eigenvalues of a Jordan block move like the root of a disturbance; its singular values do not."""
    found = spectrum([np.array([[1.0, 1.0], [0.0, 1.0]])] * 20, 1e-14)
    assert 1e-8 < found.eigenvalue_errors[0] < 1e-4
    assert found.gain_errors.max() < 1e-9
    assert np.abs(moduli(found)).max() <= found.eigenvalue_errors[0]


def test_larger_errors_make_a_larger_error():
    factors = random_factors(3)
    assert spectrum(factors, 1e-10).gain_errors[0] > 1e3 * spectrum(factors, 1e-15).gain_errors[0]
