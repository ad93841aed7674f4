"""What looks like another unit is asked about; what does not is left alone."""

import numpy as np
import pytest

from obscli.model.reader import load
from obscli.numeric.signal_units import doubts


@pytest.fixture
def asked(tmp_path):
    def found(yaw, column="yaw", time="t", given="", A="[[0, cos(psi)], [0, 0]]"):
        t = np.arange(len(yaw)) * 0.1
        np.savetxt(
            tmp_path / "s.csv",
            np.column_stack([t, yaw]),
            delimiter=",",
            header=f"{time},{column}",
            comments="",
        )
        columns = f'{{psi: {{column: "{column}"{given}}}}}'
        signals = f'{{file: s.csv, time: "{time}", columns: {columns}}}'
        text = f"states: [x, y]\nsignals: {signals}\nA: {A}\nH: [[1, 0]]\n"
        (tmp_path / "m.yaml").write_text(text)
        return doubts(load(tmp_path / "m.yaml").systems[0])

    return found


TURNING = np.arange(100) * 9.0  # degrees


def test_angles_in_radians_raise_no_question(asked):
    assert asked(np.linspace(-3, 3, 50)) == ()
    assert asked(np.deg2rad(TURNING)[:80], "heading") == ()
    assert asked(TURNING % 360, "hdg_deg", given=", factor: pi/180, unwrap: 360") == ()
    assert asked(TURNING % 360, "yaw", given=", unwrap: 360", A="[[0, psi], [0, 0]]") == ()


@pytest.mark.parametrize("column", ["hdg_deg", "yaw(deg)", "deg", "yaw_degrees", "yaw °"])
def test_a_column_that_says_degrees(asked, column):
    (text,) = asked(np.linspace(-1, 1, 50), column)
    assert (
        f"psi is taken in radians and goes from -1 to 1: in degrees? (column: {column}, factor: pi/180)"
        in (text.replace('"', ""))
    )


def test_values_that_are_no_radians(asked):
    (text,) = asked(np.linspace(0, 170, 50), "degraded")
    assert "in degrees?" in text


@pytest.mark.parametrize(
    ("values", "given", "turn"),
    [
        (TURNING % 360, ", factor: pi/180", "360"),
        (np.deg2rad(TURNING) % (2 * np.pi), "", "2*pi"),
        ((TURNING + 180) % 360 - 180, ", factor: -pi/180", "360"),
    ],
)
def test_a_jump_by_a_turn(asked, values, given, turn):
    (text,) = asked(values, given=given)
    assert f"unwrap: {turn})" in text
    assert asked(values, given=f"{given}, unwrap: {turn}") == ()


@pytest.mark.parametrize(
    ("time", "written", "factor"),
    [("t_ms", "t_ms", "1e-3"), ("us", "us", "1e-6"), ("Time [ns]", '"Time [ns]"', "1e-9")],
)
def test_a_time_that_says_its_unit(asked, time, written, factor):
    (text,) = asked(np.linspace(-1, 1, 50), time=time)
    assert f"(time: {{column: {written}, factor: {factor}}})" in text


def test_a_switch_that_is_no_angle_raises_no_question(asked):
    assert asked(6.0 * (np.arange(50) % 10 > 5), A="[[0, psi], [0, 0]]") == ()


def test_names_that_only_look_like_units(asked):
    assert asked(np.linspace(-1, 1, 50), "degraded_yaw", time="items") == ()
