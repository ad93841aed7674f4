"""A shorter window holds less information, not more: it is taken where it shows more, and never hides a direction."""

import numpy as np
import pytest

from obscli.numeric.errors import NotComputableError
from obscli.numeric.scaling import scaled
from obscli.numeric.subspace import subspaces


STIFF = """
states: [a, b, c]
A: [[0, 1, 0], [-1, 0, 0], [0, 1000, -1000]]
H: [[1, 0, 1]]
interval: {stop: 100, samples: 10}
"""


def whole(gramian, found):
    """The subspaces on the whole windows, as they are without shortening."""
    given = found.system.system
    return subspaces(scaled(gramian(given, found.horizon.instants), given, found.scaling))


def test_windows_end_at_the_instants_and_start_inside(numeric):
    found = numeric(STIFF)
    starts, instants = found.spaces.gramian.starts, found.spaces.instants
    np.testing.assert_array_equal(instants, found.horizon.instants)
    assert (starts >= found.horizon.start).all()
    assert (starts < instants).all()
    assert (starts > found.horizon.start).any()
    assert found.rank == 3


def test_where_the_whole_interval_shows_as_much_it_is_kept(numeric, gramian):
    for text in (STIFF, STIFF.replace("1000", "3")):
        found = numeric(text)
        before = whole(gramian, found)
        as_much = before.decided & (before.rank == found.spaces.rank)
        assert (found.spaces.gramian.starts[as_much] == found.horizon.start).all()
        assert as_much.any() or text == STIFF


def test_no_window_is_shortened_where_nothing_drowns(numeric, bundled):
    for stage in ("stage_1", "stage_3"):
        found = numeric(bundled("ins_calibration/horizontal.yaml", stage), samples=10)
        assert found.window is None
        assert (found.spaces.gramian.starts == found.horizon.start).all()


@pytest.mark.parametrize(
    ("e", "stop"), [("1/10^7", 100), ("1/10^8", 100), ("1/10^9", 10**5), ("1/10^10", 10**5)]
)
def test_a_window_that_is_taken_shows_no_less_than_the_whole(numeric, gramian, bundled, e, stop):
    """Kortunov's channel, almost critical: directions between noise and information are not to be lost."""
    given = bundled("kortunov/single_channel.yaml", settings={"alpha_w": f"alpha_omega*(1 + {e})"})
    found = numeric(given, stop=stop)
    before = whole(gramian, found)
    shorter = found.spaces.gramian.starts > found.horizon.start
    assert shorter.any() or e == "1/10^8"
    assert (found.spaces.rank[shorter] >= before.rank[shorter]).all()


@pytest.mark.parametrize("rate", ["10^9", "10^12"])
def test_where_steps_would_be_too_many_windows_are_tried(numeric, rate):
    text = f"parameters: {{k: {rate}}}\nstates: [a, b]\nA: [[-k, k], [0, 0]]\nH: [[1, 0]]\ninterval: {{stop: 100, samples: 5}}\n"
    found = numeric(text)
    assert found.rank == 2
    assert found.window * float(eval(rate.replace("^", "**"))) < 1e5


@pytest.mark.parametrize("A", ["exp(t)", "10^15", "10^300", "cos(10^12*t)"])
def test_what_changes_beyond_all_steps_is_refused_or_answered(numeric, A):
    text = f"states: [a]\nA: [['{A}']]\nH: [[1]]\ninterval: {{stop: 100, samples: 5}}\n"
    try:
        answer = numeric(text).rank
    except NotComputableError as error:
        answer = str(error)
    assert answer in (None, 1) or "--to" in answer
