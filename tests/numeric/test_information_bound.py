"""Information from samples alone where what is known of a decaying state grows beyond all numbers."""

import numpy as np
import pytest

from obscli.numeric.information_bound import information_roots
from obscli.numeric.kalman import roots_at
from obscli.numeric.schedule import schedule_of


MARKOV = """\
states: [{order}]
dynamics: {{p: b, b: -b/100}}
measurements: {{z: p}}
noise: {{R: 1, step: 10, P0_std: {{p: {prior}, b: {prior}}}{more}}}
"""


def bounds(given, stop, covectors):
    """Return the deviations of linear forms without a prior, the last instant's."""
    [known] = information_roots(given, schedule_of(given, 0, stop), np.array([float(stop)]))
    return np.linalg.norm(known.forms(np.array(covectors, dtype=float)) @ np.linalg.pinv(known.root), axis=1)


@pytest.mark.parametrize("order", ["p, b", "b, p"])
@pytest.mark.parametrize("stop", [200, 86400])
def test_the_position_of_a_decayed_velocity_is_known_as_by_a_regression(system, order, stop):
    """p(t − s) = p − 100 (e^(s/100) − 1) b: two parameters, the second in units e^(T/100) of its own."""
    given = system(MARKOV.format(order=order, prior=1, more=""))
    found = bounds(given, stop, np.eye(2))
    s = np.arange(0, stop + 1, 10.0)
    g = np.exp((s - stop) / 100) - np.exp(-stop / 100)
    names = order.split(", ")
    assert found[names.index("p")] ** 2 == pytest.approx(1 / (len(s) - g.sum() ** 2 / (g @ g)), rel=1e-9)
    along = g - g.mean()
    assert found[names.index("b")] == pytest.approx(
        np.exp(-stop / 100) / 100 / np.linalg.norm(along), rel=1e-9
    )


@pytest.mark.parametrize("order", ["p, b", "b, p"])
def test_driving_noise_leaves_the_bound_that_the_filter_tends_to(system, order):
    """Noise on p bounds what is known of it; of b, which nothing drives, all is known after a day."""
    more = ", Q: {p: 1e-4, b: 0}"
    given = system(MARKOV.format(order=order, prior=1e4, more=more))
    [root], _ = roots_at(given, schedule_of(given, 0, 86400), np.array([86400.0]))
    found = bounds(given, 86400, np.eye(2))
    names = order.split(", ")
    assert found[names.index("p")] == pytest.approx(np.linalg.norm(root[names.index("p")]), rel=1e-9)
    assert found[names.index("b")] == 0
