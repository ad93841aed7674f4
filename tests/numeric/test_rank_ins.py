"""INS calibration, stage 2: rank 16 of 24 at all 150 instants; right combinations do not leak, a wrong one does."""

import numpy as np
import pytest

from obscli.model.covector import parse_covector
from obscli.numeric.leak import leak_of


STAGE = ("ins_calibration/horizontal.yaml", "stage_2")


@pytest.fixture(scope="module")
def found(bundled, numeric):
    return numeric(bundled(*STAGE))


def leak(found, covectors):
    rows, errors = found.system.covectors(covectors, found.horizon.instants)
    return leak_of(found.spaces, rows, errors)


@pytest.fixture(scope="module")
def claimed(found):
    """χ of the basis that the paper gives."""
    (claim,) = (one for one in found.system.system.claims if one.basis)
    return leak(found, [one.coefficients for one in claim.basis])


def test_the_rank_is_16_at_every_instant(found):
    assert found.rank == 16
    assert len(found.horizon.instants) == 150
    np.testing.assert_allclose(found.horizon.instants, np.arange(10, 1501, 10), rtol=1e-14)
    assert (found.spaces.rank == 16).all()
    assert found.spaces.decided.all()
    assert found.conclusive.all()
    assert found.window is None
    assert [found.spaces.kernel(i).shape for i in (0, 149)] == [(24, 8)] * 2


def test_the_claimed_basis_does_not_leak(found, claimed):
    t = found.horizon.instants
    assert claimed.chi.shape == (150, 16)
    assert (claimed.chi <= claimed.bound).all()
    # after ten turns of the table every direction is clear; before, psi3 is known through the Earth's rate only
    assert claimed.chi[t >= 100].max() <= 1e-9
    # 2e-6 at the first instant, to the processor's rounding: the paper's misprint, 0.05, stands 10⁴ above it
    assert 1e4 * claimed.bound.max() <= 0.05


@pytest.mark.parametrize("wrong", ["b_g1 - omega*M_a21", "b_g1", "M_g21 - M_a21", "g*psi2 - b_a2"])
def test_a_wrong_combination_leaks(found, wrong):
    one = leak(found, [parse_covector(found.system.system, wrong, "test").coefficients])
    assert (one.chi > 1e3 * one.bound).mean() > 0.9


def test_the_leak_of_the_papers_misprint(found):
    """b_g1 − ω M_a21 lacks ω M_g12: it leaks by ω = 0.1, or half of that, where the kernel is turned."""
    one = leak(found, [parse_covector(found.system.system, "b_g1 - omega*M_a21", "test").coefficients])
    assert ((one.chi > 0.05) & (one.chi < 0.12)).all()


def test_a_mixture_of_right_rows_does_not_leak_and_a_small_error_in_one_does(found):
    def row(text):
        return parse_covector(found.system.system, text, "test").coefficients

    right = "2*psi1 - 3*(b_g1 + omega*M_g12 - omega*M_a21)/omega + cos(t/7)*(M_g21 + M_a21)"
    one = leak(found, [row(right)])
    assert (one.chi <= one.bound).all()
    off = leak(found, [row(f"{right} + 1/10^6*M_a22")])
    assert (off.chi[found.horizon.instants >= 100] > 10 * off.bound[found.horizon.instants >= 100]).all()


def test_the_length_of_a_row_does_not_matter(found):
    def row(factor):
        return parse_covector(found.system.system, f"{factor}*(b_g1 - omega*M_a21)", "test").coefficients

    one, big, small = (leak(found, [row(factor)]).chi for factor in ("1", "10^9", "10^(-9)"))
    np.testing.assert_allclose(big, one, rtol=1e-12)
    np.testing.assert_allclose(small, one, rtol=1e-12)


def test_a_row_that_vanishes_at_an_instant_says_nothing_there(found):
    row = parse_covector(found.system.system, "(t - 100)*psi1", "test").coefficients
    one = leak(found, [row])
    there = found.horizon.instants == 100
    assert there.sum() == 1
    assert np.isnan(one.chi[there]).all()
    assert (one.chi[~there] <= one.bound[~there]).all()


def test_methods_decide_the_same(numeric, bundled):
    for method in ("quadrature", "lyapunov"):
        other = numeric(bundled(*STAGE), method=method, samples=5, stop="300")
        assert other.rank == 16
        assert (other.spaces.rank[other.spaces.decided] <= 16).all()
