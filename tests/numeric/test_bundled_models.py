"""Every bundled model: the Gramian shows the exact rank, the exact combinations, the exact verdicts and curves."""

from pathlib import Path

import numpy as np
import pytest

from obscli.model.reader import load
from obscli.numeric.echelon import echelon_curves
from obscli.numeric.leak import leak_of


ROOT = Path(__file__).parents[2]
SYSTEMS = [
    pytest.param(s, id=f"{f.parent.name}-{f.stem}-{s.stage or 'base'}")
    for f in sorted((ROOT / "models").glob("**/*.yaml"))
    for s in load(f).systems
]
EPS = np.finfo(float).eps

#: Stated errors are standard deviations of random roundings; see test_error_estimate.
HONEST = 6

#: Instants at the start that may show less than the whole rank.
FIRST = 3


@pytest.fixture(scope="module", params=SYSTEMS)
def both(request, numeric, exact):
    """The numerical and the exact analysis of one stage."""
    return numeric(request.param), exact(request.param)


@pytest.fixture
def generic(both):
    """The same where the rank at the file's values is the generic one, so that the combinations hold there."""
    found, proved = both
    if proved.at_values.rank != proved.rank:
        assert found.system.system.state_names == ("alpha", "V", "R", "dOm", "dW")  # Kortunov's channel only
        pytest.skip("the file's values are critical")
    return both


def test_the_rank_is_the_exact_one(both):
    found, proved = both
    assert found.rank == proved.at_values.rank
    assert (found.spaces.rank[found.spaces.decided] <= proved.at_values.rank).all()
    assert found.conclusive[FIRST:].all()


def test_exact_combinations_do_not_leak(generic):
    found, proved = generic
    rows, errors = found.system.covectors(
        [c.coefficients for c in proved.combinations], found.horizon.instants
    )
    leak = leak_of(found.spaces, rows, errors)
    assert np.isfinite(leak.chi[found.conclusive]).all()
    assert (leak.chi <= leak.bound)[found.conclusive].all()


def test_verdicts_are_the_exact_ones(generic):
    found, proved = generic
    curves = echelon_curves(found)
    assert curves.states == dict(proved.states)
    assert tuple(group for group in curves.groups if len(group) > 1) == proved.groups


def test_curves_are_the_exact_coefficients(generic):
    """Exact rows evaluated and divided by their pivot, against coefficients with their stated errors."""
    found, proved = generic
    curves, names = echelon_curves(found), found.system.system.state_names
    combinations = [c.coefficients for c in proved.combinations]
    first = [min(names.index(state) for state in row) for row in combinations]
    assert list(curves.pivots) == first
    rows, _ = found.system.covectors(combinations, curves.instants)
    expected = rows / np.take_along_axis(rows, np.array(first, dtype=int)[None, :, None], axis=2)
    expected = expected[:, :, curves.free]
    off = np.abs(curves.coefficients - expected)
    assert (off <= HONEST * curves.errors + 8 * EPS * np.abs(expected)).all()
    assert ((expected != 0).any(axis=0) == curves.present).all()


#: The definition is an integral: that of discrete-time systems, a sum, is tried in test_discrete.
INTEGRATED = [one for one in SYSTEMS if not one.values[0].discrete]


@pytest.mark.parametrize("given", INTEGRATED)
def test_the_definition_shows_the_same_rank(numeric, exact, given):
    found, rank = numeric(given, method="quadrature", samples=20), exact(given).at_values.rank
    assert found.rank == rank
    assert (found.spaces.rank[found.spaces.decided] <= rank).all()
