"""The bundled flights of a guided rocket: the table of the theory by the tool itself, what the paper concludes from it."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest

from obscli import WindowsRequest, load, windows
from obscli.pipelines.request import NumericRequest


ROCKET = Path(__file__).parents[2] / "models/rocket"
ANGLES = ("roll_error", "pitch_error", "azimuth_error")

#: Values are tabulated to half a unit of the fourth decimal; roll on the ballistic arc to one digit.
HALF, FEW = 0.51e-4, 0.35
CONTINUOUS = {"stack": "continuous", "scaling": "none"}
DISCRETE = {"scaling": "none"}
SCALED = {}

#: Flight, instant; roll, pitch, azimuth of the continuous stack, of 15 samples 0.1 s apart, and of these scaled.
TABLE = [
    ("uncontrolled", 5.1, (0, 28.3938, 18.8571), (0, 66.7536, 44.3388), (3e-5, 54.1528, 35.9705)),
    ("uncontrolled", 12, (0, 15.2324, 10.9781), (0, 35.6117, 25.6684), (2e-5, 27.7005, 19.9667)),
    ("uncontrolled", 50, (0, 2.4549, 2.4535), (0, 5.3463, 5.3435), (2e-6, 3.3182, 3.3164)),
    ("uncontrolled", 105, (0, 13.4292, 6.2414), (0, 31.3380, 14.5637), (1e-5, 24.0757, 11.1883)),
    ("pitch", 12, (18.4225, 26.9954, 24.2151), (43.3043, 63.4514, 56.9129), (35.0493, 51.3547, 46.0622)),
    ("pitch", 18.5, (20.7608, 24.0646, 0.0678), (48.7589, 56.5195, 0.1589), (39.2290, 45.4732, 0.1278)),
    ("yaw", 12, (18.4430, 8.6209, 24.1935), (43.3500, 20.2603, 56.8659), (35.0881, 16.3984, 46.0280)),
    ("yaw", 18.5, (20.5957, 3.6624, 22.9692), (48.3728, 8.6031, 53.9495), (38.9299, 6.9240, 43.4187)),
]  # fmt: skip


@cache
def model(name):
    return load(ROCKET / f"{name}.yaml")


@cache
def flown(case, name="flights_enu", start=None, stop=None, **how):
    """The windows of one flight: their starts, and a function from key and name to values."""
    request = WindowsRequest(1.5, 0.1, stages=(case,), numeric=NumericRequest(start=start, stop=stop), **how)
    return windows(model(name), request=request).results[0].found


def angles(case, t=None, **how):
    """σ̃ of roll, pitch, azimuth at an instant, or at all."""
    found = flown(case, **how)
    columns = [found.names.index(name) for name in ANGLES]
    values = found.values.equivalent[:, columns]
    if t is None:
        return found.values.t, values
    [place] = np.flatnonzero(np.abs(found.values.t - t) < 1e-9)
    return values[place]


@pytest.mark.parametrize("row", TABLE, ids=[f"{row[0]}-{row[1]}" for row in TABLE])
def test_the_table_of_the_theory(row):
    case, t, *expected = row
    for how, (roll, *others) in zip((CONTINUOUS, DISCRETE, SCALED), expected, strict=True):
        found = angles(case, t, **how)
        if roll > 1:
            np.testing.assert_allclose(found[0], roll, rtol=0, atol=HALF)
        elif roll:
            np.testing.assert_allclose(found[0], roll, rtol=FEW)
        else:
            assert found[0] < HALF
        np.testing.assert_allclose(found[1:], others, rtol=0, atol=HALF)


@pytest.mark.parametrize("case", ["pitch", "yaw"])
def test_roll_is_seen_by_normal_acceleration_only(case):
    before = np.array([angles(case, t) for t in (5.5, 7, 9)])
    during = np.array([angles(case, t) for t in (12, 14, 18.5, 20)])
    assert (before[:, 0] < 1e-4 * before[:, 1]).all()
    reference = np.array([angles("pitch", t)[1] for t in (12, 14, 18.5, 20)])
    assert (during[:, 0] > 0.5 * reference).all()
    assert during[:, 0].min() > 1e4 * before[:, 0].max()


def test_pitch_goes_with_axial_acceleration_on_the_ballistic_arc():
    """σ̃ is linear in |f_x|; the samples of the file are those of the windows' starts up to 25 s, then every fifth."""
    record = np.genfromtxt(ROCKET / "flight_uncontrolled.csv", delimiter=",", names=True)
    t, values = angles("uncontrolled", **DISCRETE)
    f = np.abs(np.interp(t, record["t"], record["f_x"]))
    on_record = np.abs(t[:, None] - record["t"]).min(axis=1) < 1e-9
    f, pitch = f[on_record], values[on_record, 1]
    slope, level = np.polyfit(f, pitch, 1)
    rest = pitch - slope * f - level
    assert 1 - rest.var() / pitch.var() > 0.998
    rising = pitch[np.argsort(f)]
    assert (
        np.diff(rising) > -1e-4 * rising[1:]
    ).all()  # but for the rate of the Earth and the grid of the record
    assert 3.3 < slope < 3.5
    assert 1.7 < angles("pitch", 12)[1] / angles("uncontrolled", 12)[1] < 1.9


def test_azimuth_goes_with_horizontal_specific_force():
    record = np.genfromtxt(ROCKET / "flight_uncontrolled.csv", delimiter=",", names=True)
    t, values = angles("uncontrolled", **CONTINUOUS)
    theta = np.interp(t, record["t"], np.radians(record["pitch"]))
    on_record = np.abs(t[:, None] - record["t"]).min(axis=1) < 1e-9
    ratio = values[on_record, 2] / values[on_record, 1]
    np.testing.assert_allclose(ratio, np.cos(theta[on_record]) ** 2, atol=1e-3)
    free, pitched, yawed = (
        {t: angles(case, t)[2] for t in (12, 19)} for case in ("uncontrolled", "pitch", "yaw")
    )
    assert 2.1 < yawed[12] / free[12] < 2.4
    assert pitched[12] > 2 * free[12]
    assert pitched[19] < 0.02 * free[19]


def test_yaw_lowers_the_index_of_pitch_but_neither_its_column_norm_nor_its_rank():
    assert 0.5 < angles("yaw", 12)[1] / angles("uncontrolled", 12)[1] < 0.65
    norms, ranks = [], []
    for case in ("yaw", "uncontrolled"):
        found = flown(case)
        [at] = np.flatnonzero(np.abs(found.values.t - 12) < 1e-9)
        norms.append(found.values.column_norm[at, found.names.index("pitch_error")])
        ranks.append(set(found.values.rank.tolist()))
    assert norms[0] > 0.99 * norms[1]
    assert ranks == [{12}, {12}]


def test_axes_that_turn_change_what_a_frozen_window_shows_of_roll():
    """Quasi-body axes turn with the flight: their turning is frozen in, that of the other file is not."""
    turning = flown("uncontrolled", "flights_quasi_body", stop="15")
    roll = turning.values.equivalent[:, turning.names.index("roll_error")]
    assert roll.min() > 50 * angles("uncontrolled", 12)[0]
    pitch = turning.values.equivalent[:, turning.names.index("pitch_error")]
    np.testing.assert_allclose(pitch, angles("uncontrolled")[1][: len(pitch), 1], rtol=1e-2)


def test_true_windows_do_not_depend_on_the_axes():
    """One prior, turned, as it is the same in all directions: what a window leaves is the same in both axes."""
    left = []
    for name in ("flights_enu", "flights_quasi_body"):
        found = flown("yaw", name, start="10", stop="14", frozen=False)
        left.append(found.values.posterior[:, [found.names.index(one) for one in ANGLES]])
    np.testing.assert_allclose(left[0], left[1], rtol=1e-3)


@pytest.mark.parametrize("case", ["uncontrolled", "pitch", "yaw"])
def test_all_states_are_observable_soon(case):
    """Local rank 12; the segments together 15, the condition of the stripped matrix holds."""
    segments = flown(case).segments
    assert segments.holds
    assert set(segments.local_rank.tolist()) == {12}
    assert (segments.total_rank[-1], segments.stripped_rank[-1]) == (15, 15)
    assert segments.since.max() < 9.5


def test_a_log_of_ones_own_fits_the_model_of_the_page(tmp_path):
    """A drive round a bend; the columns are those that docs/windows.md shows."""
    page = (Path(__file__).parents[2] / "docs/windows.md").read_text(encoding="utf-8")
    header = page.split("```csv\n")[1].split("\n")[0]
    t = np.arange(0, 30.01, 0.2)
    yaw, speed = np.where(t < 15, 0, 0.2 * (t - 15)), 10 + 2 * np.sin(0.3 * t)
    record = {
        "time_ms": 1000 * t + 5000, "ax": 0.6 * np.cos(0.3 * t), "ay": np.where(t < 15, 0, 0.2 * speed),
        "az": -9.81 + 0 * t, "roll": 0 * t, "pitch": 0 * t, "yaw": np.degrees(yaw) % 360, "vn": speed * np.cos(yaw),
        "ve": speed * np.sin(yaw), "vd": 0 * t, "lat": 47.37 + 0 * t, "lon": 8.54 + 0 * t, "height": 410 + 0 * t,
    }  # fmt: skip
    rows = np.column_stack([record[name] for name in header.split(",")])
    np.savetxt(tmp_path / "log.csv", rows, delimiter=",", header=header, comments="", fmt="%.10g")
    (tmp_path / "log.yaml").write_text(page.split("```yaml\n")[1].split("```")[0], encoding="utf-8")
    request = WindowsRequest(2, 0.2, show=("phi", "heading_error"))
    [result] = windows(load(tmp_path / "log.yaml"), request=request).results
    found = result.found
    assert [found.names[k] for k in found.shown] == ["phi_N", "phi_E", "phi_D", "heading_error"]
    assert set(found.values.rank.tolist()) == {12}
    assert found.segments.total_rank[-1] == 15
    gain = 1 - found.values.posterior[:, found.names.index("heading_error")]
    straight, bend = (found.values.t > 3) & (found.values.t < 6), found.values.t > 20
    assert gain[bend].min() > 10 * gain[straight].max()
