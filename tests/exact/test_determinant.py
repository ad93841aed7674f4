"""The sparse determinant in balls contains the determinant that FLINT finds exactly."""

import random

import pytest
from flint import arb, fmpz_mat

from obscli.exact.ball import precision
from obscli.exact.determinant import determinant


@pytest.mark.parametrize("seed", range(60))
def test_it_contains_the_exact_determinant(seed):
    source = random.Random(seed)
    n = source.randrange(0, 9)
    full = [[source.choice([0, 0, 1, -2, 3, 7]) for _ in range(n)] for _ in range(n)]
    with precision(128, 1):
        found = determinant([{j: arb(x) for j, x in enumerate(row) if x} for row in full])
        assert found.contains(int(fmpz_mat(n, n, [x for row in full for x in row]).det()))


def test_no_pivot_away_from_zero_gives_no_number():
    with precision(128, 1):
        unsure = arb("0 +/- 1e-20")
        assert determinant([{0: unsure}]).contains(0)
        assert determinant([{0: unsure, 1: unsure}, {0: arb(1), 1: arb(1)}]).contains(0)


def test_the_empty_determinant_is_one():
    assert determinant([]) == 1
