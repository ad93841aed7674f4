"""The s-node rule integrates polynomials exactly: to degree s − 1 through its nodes, to 2s − 1 over [0, 1]."""

from fractions import Fraction

import numpy as np
import pytest
from numpy.polynomial import legendre

from obscli.numeric.collocation import gauss_legendre


SIZES = [1, 2, 3, 5, 8, 16, 20]
ROUNDING = 1e-14  # a hundred roundings of numbers up to 1


@pytest.mark.parametrize("s", SIZES)
def test_backward_and_forward_integrals_of_monomials(s):
    rule, x = gauss_legendre(s), gauss_legendre(s).nodes
    for k in range(s):
        np.testing.assert_allclose(rule.backward @ x**k, (1 - x ** (k + 1)) / (k + 1), rtol=0, atol=ROUNDING)
        np.testing.assert_allclose(rule.forward @ x**k, x ** (k + 1) / (k + 1), rtol=0, atol=ROUNDING)


@pytest.mark.parametrize("s", SIZES)
def test_weights_integrate_twice_the_degree_and_no_more(s):
    rule = gauss_legendre(s)
    for k in range(2 * s):
        assert rule.weights @ rule.nodes**k == pytest.approx(float(Fraction(1, k + 1)), abs=ROUNDING)
    if s <= 8:  # the error at degree 2s is the square of the monic node polynomial, 4^-2s and less
        missed = np.prod([(rule.nodes - one) ** 2 for one in rule.nodes], axis=0)
        assert rule.weights @ missed == pytest.approx(0, abs=ROUNDING)
        top = rule.weights @ rule.nodes ** (2 * s) - 1 / (2 * s + 1)
        assert abs(top) > 4.0 ** (-2 * s - 3)


@pytest.mark.parametrize("s", SIZES)
def test_the_last_backward_integral_is_the_rest_of_the_whole(s):
    rule = gauss_legendre(s)
    np.testing.assert_allclose(rule.forward + rule.backward, np.tile(rule.weights, (s, 1)), atol=ROUNDING)


@pytest.mark.parametrize("s", SIZES)
def test_the_spectrum_turns_values_into_legendre_coefficients_and_back(s):
    rule = gauss_legendre(s)
    P = legendre.legvander(2 * rule.nodes - 1, s - 1)
    np.testing.assert_allclose(rule.spectrum @ P, np.eye(s), atol=1e-13)
    np.testing.assert_allclose(P @ rule.spectrum, np.eye(s), atol=1e-13)
    c = np.random.default_rng(s).normal(size=s)
    np.testing.assert_allclose(rule.spectrum @ legendre.legval(2 * rule.nodes - 1, c), c, atol=1e-13)


def test_nodes_lie_inside_in_order_and_symmetric():
    for s in SIZES:
        x = gauss_legendre(s).nodes
        assert 0 < x[0] <= x[-1] < 1
        assert (np.diff(x) > 0).all()
        np.testing.assert_allclose(x + x[::-1], 1, atol=1e-15)
