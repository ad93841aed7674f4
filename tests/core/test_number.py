"""Numbers and counts as text: short, without a loss that matters, and the same wherever they are printed."""

import json
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from obscli.core.number import counted, json_number, plain, short


#: the very largest floats would be rounded up to infinity
finite = st.floats(-1e308, 1e308)


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0, "0"),
        (-0.0, "0"),
        (1.0, "1"),
        (16.0, "16"),
        (-3.0, "-3"),
        (1500.0, "1500"),
        (999_999.0, "999999"),
        (1e6, "1e6"),
        (-2.5e9, "-2.5e9"),
        (0.5, "0.5"),
        (0.0942, "0.094"),
        (0.005, "0.005"),
        (2.7e-7, "2.7e-7"),
        (3e-16, "3e-16"),
        (1e-100, "1e-100"),
        (1.23e20, "1.2e20"),
        (5e-324, "4.9e-324"),
        (math.inf, "inf"),
        (-math.inf, "-inf"),
        (math.nan, "–"),
    ],
)
def test_short(value, text):
    assert short(value) == text


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.133333333, "0.133333"),
        (1500.0, "1500"),
        (20.125, "20.125"),
        (1234.5678, "1234.57"),
        (1e-3, "0.001"),
        (1e-5, "1e-5"),
        (1234567.0, "1.23457e6"),
        (math.nan, "–"),
    ],
)
def test_plain(value, text):
    assert plain(value) == text


@given(finite)
def test_short_is_right_to_its_digits(value):
    for digits in (1, 2, 6, 17):
        assert float(short(value, digits)) == pytest.approx(value, rel=10.0 ** (1 - digits), abs=0.0)


@given(st.integers(-999_999, 999_999))
def test_whole_numbers_keep_all_digits(value):
    assert short(float(value)) == plain(float(value)) == str(value)


@given(finite)
def test_exponents_have_no_filling(value):
    mantissa, _, exponent = short(value).partition("e")

    assert not exponent.startswith(("+", "0", "-0"))
    assert len(mantissa.strip("-").replace(".", "").lstrip("0")) <= 6


@given(st.floats(0, 1e300), st.floats(0, 1e300))
def test_order_is_kept(a, b):
    """Of two numbers the smaller is never printed as the larger."""
    low, high = sorted((a, b))

    assert float(plain(low)) <= float(plain(high))


@given(finite)
def test_the_sign_is_in_front(value):
    assert short(-value).removeprefix("-") == short(value).removeprefix("-")


@given(st.floats())
def test_json_numbers_are_json(value):
    text = json.dumps(json_number(value), allow_nan=False)
    back = json.loads(text)

    if math.isnan(value):
        assert back is None
    elif math.isinf(value):
        assert float(back) == value
        assert isinstance(back, str)
    else:
        assert back == value


def test_nothing_is_null():
    assert json_number(None) is None


def test_json_numbers_are_floats_of_python():
    import numpy as np

    assert type(json_number(np.float64(0.25))) is float
    assert type(json_number(3)) is float


@pytest.mark.parametrize(
    ("count", "noun", "text"),
    [
        (0, "state", "0 states"),
        (1, "state", "1 state"),
        (2, "direction", "2 directions"),
        (11, "row", "11 rows"),
    ],
)
def test_counted(count, noun, text):
    assert counted(count, noun) == text
