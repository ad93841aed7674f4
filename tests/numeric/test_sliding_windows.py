"""Windows that share their panels say what each says alone, and never claim more than they know."""

import numpy as np
import pytest

from obscli.numeric import sliding_windows
from obscli.numeric.errors import UnfitRequestError
from obscli.numeric.scaling import scaled
from obscli.numeric.sliding_windows import Windows, even_windows, slide
from obscli.numeric.stretches import stretches
from obscli.numeric.subspace import subspaces


VALUES = {"w": 0.7, "v": 1.3, "c1": 1.1, "c2": -0.6, "c3": 0.8, "c4": 1.7, "c5": 0.9, "c6": -1.2}

#: Bounds are standard deviations of random roundings.
OVER = 3

#: Nine kinds of windows: half overlapping, much overlapping, disjoint, with ends that never meet starts.
PLACED = [(0, 8, 2, 1), (0, 8, 3, 0.25), (1, 9, 1, 2), (0, 7, 2.2, 0.7)]

DECAYING = """
states: [a, b, c]
A: [[0, 1, 0], [-1, 0, 0], [0, 2, -3]]
H: [[1, 0, 1]]
"""
TURNING = """
states: [a, b, c, d]
A: [[0, 1 + t/10, 0, 0], [-1, 0, sin(2*t), 0], [0, 0, 0, 0], [0, 0, 0, 0]]
H: [[1, 0, 0, cos(t)], [0, 0, 1, 1]]
"""


def joined(pieces):
    """Arrays of all windows: ranks, decided, values, noise."""
    pieces = list(pieces)
    return tuple(
        np.concatenate([getattr(one, name) for one in pieces])
        for name in ("rank", "decided", "values", "noise")
    )


def all_at_once(given, windows):
    """The Gramians of all windows, as they are shared, in the file's units."""
    pieces = list(slide(given, windows, scaling="none"))
    assert len(pieces) == 1
    return pieces[0].gramian


def random_system(known, system, seed):
    built = known.build(seed, breakable=seed % 2 == 0)
    text = built.text
    for name, value in VALUES.items():
        text = text.replace(f"{name}: null", f"{name}: {value}")
    return built, system(text)


@pytest.mark.parametrize("text", [DECAYING, TURNING])
@pytest.mark.parametrize("placed", PLACED)
def test_every_window_has_the_gramian_it_has_alone(system, gramian, matrices, text, placed):
    given, windows = system(text), even_windows(*placed)
    together = matrices(all_at_once(given, windows))
    for i, (s, t) in enumerate(zip(windows.starts, windows.stops, strict=True)):
        alone = matrices(gramian(given, [t], start=s))[0]
        size = np.sqrt(np.diag(alone))
        np.testing.assert_allclose(
            together[i] / size / size[:, None], alone / size / size[:, None], atol=1e-13
        )


@pytest.mark.parametrize("seed", range(40))
def test_random_windows_show_the_rank_and_the_kernel_they_show_alone(known, system, gramian, seed):
    """The kernel found alone is the kernel of the shared root, to its own error bound."""
    built, given = random_system(known, system, seed)
    windows = even_windows(0, 12, 4, 1)
    together = subspaces(scaled(all_at_once(given, windows), given, "none"))
    for i in (0, 3, 4, 8):
        s, t = windows.starts[i], windows.stops[i]
        alone = subspaces(scaled(gramian(given, [t], start=s), given, "none"))
        assert together.rank[i] <= built.rank or not together.decided[i]
        if not alone.decided[0]:
            continue
        assert together.rank[i] == alone.rank[0]
        kernel = alone.right[0, alone.rank[0] :].T
        shown = np.linalg.norm(together.gramian.matrices[i] @ kernel, axis=0)
        bound = np.hypot(together.noise_along(kernel, i), alone.noise_along(kernel, 0))
        assert (shown <= OVER * bound).all()
        assert (
            np.abs(together.values[i] - alone.values[0]) <= OVER * (together.noise[i, 0] + alone.noise[0, 0])
        ).all()


@pytest.mark.parametrize(
    ("text", "placed", "wider"),
    [
        (TURNING, (0, 12, 3, 0.75), 2),
        (TURNING, (0, 12, 1.5, 0.75), 2),
        (TURNING, (0, 9, 6, 0.25), 10),
        (DECAYING, (0, 10, 2, 0.5), 2),
        (DECAYING, (0, 10, 6, 0.25), 5),
    ],
)
def test_the_bound_is_that_of_a_window_alone(system, gramian, text, placed, wider):
    """Sharing makes the bound wider, little on the same panels, some on more panels, and never narrower."""
    given, windows = system(text), even_windows(*placed)
    shared = all_at_once(given, windows)
    for i in range(len(windows.starts)):
        alone = gramian(given, [windows.stops[i]], start=windows.starts[i])
        alone = alone.in_units(1 / alone.units)
        _, _, right = np.linalg.svd(alone.matrices[0])
        for v in (*right, *np.eye(given.n)):
            narrow, wide = (np.sqrt(v @ one @ v) for one in (alone.error[0], shared.error[i]))
            assert 0.9 * narrow <= wide <= wider * narrow


@pytest.mark.parametrize(
    ("path", "stage"),
    [
        ("ins_calibration/pole.yaml", "stage_1"),
        ("ins_calibration/vertical.yaml", "stage_3"),
        ("calibration/table_plan.yaml", "y_turns"),
        ("kortunov/sixteen_states_case_3.yaml", "with_heading"),
        ("textbook/attitude_quaternion.yaml", "any_motion"),
        ("textbook/ins_velocity_aiding.yaml", "constant_velocity"),
        ("textbook/mixed_coefficients.yaml", None),
        ("textbook/wu.yaml", None),
    ],
)
def test_windows_of_bundled_models_all_decide_the_rank_of_the_whole(bundled, numeric, path, stage):
    """Coefficients are analytic: a quarter of the interval shows what the whole shows."""
    given = bundled(path, stage)
    whole = numeric(given)
    start, stop = whole.horizon.start, whole.horizon.stop
    windows = even_windows(start, stop, (stop - start) / 4, (stop - start) / 40)
    rank, decided, _, _ = joined(slide(given, windows))
    assert len(rank) == 31
    assert (rank == whole.rank).all()
    assert decided.all()


def test_all_windows_of_a_time_invariant_system_are_alike(system, matrices):
    found = matrices(all_at_once(system(DECAYING), even_windows(3, 13, 2, 0.5)))
    np.testing.assert_allclose(found, np.broadcast_to(found[0], found.shape), rtol=1e-12)


def test_windows_add_up(system, matrices, transition):
    """W(c, a) = Φᵀ(b, c) W(b, a) Φ(b, c) + W(c, b)."""
    given = system(TURNING)
    a, b, c = 1.0, 2.5, 4.2
    parts = matrices(all_at_once(given, Windows(np.array([a, a, b]), np.array([b, c, c]))))
    phi, _, _ = transition(given, b, c)
    np.testing.assert_allclose(phi.T @ parts[0] @ phi + parts[2], parts[1], rtol=1e-12, atol=1e-13)


def test_rank_and_singular_values_follow_what_moves(system):
    """b is told from a only where the bump is seen: rank 2 there, 1 elsewhere."""
    given = system("states: [a, b]\nA: [[0, 0], [0, 0]]\nH: [[1, 1 + exp(-4*(t - 10)^2)]]")
    windows = even_windows(0, 20, 2, 0.25)
    rank, decided, values, _ = joined(slide(given, windows))
    near = (windows.starts < 11) & (windows.stops > 9)
    far = (windows.starts > 14) | (windows.stops < 6)
    assert (rank[near] == 2).all()
    assert decided[near].all()
    assert (rank[far] == 1).all()
    assert (values[near, 1] > values[far, 1].max()).all()


@pytest.mark.parametrize(("flash", "weak"), [(14, "1"), (11, "10^(-8)")])
def test_a_flash_of_information_does_not_blind_the_windows_after_it(system, flash, weak):
    """Windows that no longer hold the flash show what they show alone, although the shared bound still holds it."""
    given = system(
        "states: [a, b]\nA: [[0, 0], [0, 0]]\n"
        f"H: [[10^{flash}*exp(-40*(t - 2)^2), 10^{flash}*exp(-40*(t - 2)^2)], [1, {weak}*sin(t)]]"
    )
    windows = even_windows(0, 12, 2, 0.5)
    rank, decided, _, _ = joined(slide(given, windows, scaling="none"))
    after = windows.starts >= 3.5
    assert (rank[after] == 2).all()
    assert decided[after].all()


def test_where_columns_grow_beyond_all_range_nothing_is_claimed(system):
    given = system("states: [a, b]\nA: [[-1000, 0], [0, 0]]\nH: [[1, 1]]")
    rank, decided, values, _ = joined(slide(given, even_windows(0, 6, 2, 1)))
    assert np.isfinite(values).all()
    assert ((rank == 1) | ~decided).all()


@pytest.mark.parametrize("chunk", [1, 2000, 10_000])
def test_portions_do_not_change_what_is_found(system, monkeypatch, chunk):
    given, windows = system(TURNING), even_windows(0, 60, 1.5, 0.5)
    at_once = list(slide(given, windows, scaling="none"))
    monkeypatch.setattr(sliding_windows, "_CHUNK", chunk)
    portions = list(slide(given, windows, scaling="none"))
    assert len(at_once) == 1
    assert len(portions) > 1
    np.testing.assert_array_equal(np.concatenate([one.instants for one in portions]), windows.stops)
    np.testing.assert_allclose(joined(portions)[2], joined(at_once)[2], rtol=1e-11)
    np.testing.assert_array_equal(joined(portions)[0], joined(at_once)[0])


@pytest.mark.parametrize("length", [1, 2, 3, 7])
@pytest.mark.parametrize("step", [1, 2, 5])
@pytest.mark.parametrize("reach", [1, 2, 100])
def test_no_panel_is_walked_twice_where_nothing_limits_the_points(length, step, reach):
    a = step * np.arange(30)
    which = stretches(a, a + length, a + reach)
    c = which.points[which.group]
    assert ((which.a < c) & (c <= which.b) & (c <= which.a[which.first][which.group] + reach)).all()
    assert (which.starts[1:] >= which.points[:-1]).all()
    assert reach < length or (which.stops[:-1] <= which.points[1:]).all()


@pytest.mark.parametrize(
    ("placed", "count"),
    [((0, 603, 120, 3), 162), ((0, 1, 0.1, 0.1), 10), ((0, 5, 5, 1), 1), ((2, 7, 2.2, 0.7), 5)],
)
def test_as_many_windows_as_fit(placed, count):
    windows = even_windows(*placed)
    assert len(windows.starts) == count
    np.testing.assert_allclose(windows.stops - windows.starts, placed[2], rtol=1e-12)
    assert windows.stops[-1] <= placed[1] * (1 + 1e-12) < windows.stops[-1] + placed[3]


def test_starts_and_stops_that_coincide_are_the_same_number():
    windows = even_windows(0.3, 300, 0.7, 0.1)
    assert np.isin(windows.stops[:-7], windows.starts).all()


@pytest.mark.parametrize(
    "placed", [(0, 10, 0, 1), (0, 10, 1, 0), (0, 10, -1, 1), (0, 10, 11, 1), (0, 10, float("nan"), 1)]
)
def test_windows_that_cannot_be_are_refused(placed):
    with pytest.raises(UnfitRequestError, match="window"):
        even_windows(*placed)


def test_too_many_steps_are_refused(system):
    with pytest.raises(Exception, match="steps"):
        list(slide(system("states: [a]\nA: [['cos(10^9*t)']]\nH: [[1]]"), even_windows(0, 100, 10, 5)))
