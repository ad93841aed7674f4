"""Measured numbers in an expression are printed as decimals, the exact ones as they are."""

import random
from fractions import Fraction

import pytest

from obscli.model.expression import Apply, Symbol, add, divide, multiply, negate, number, power
from obscli.model.notation import decimal_text, to_text


omega, t = Symbol("omega"), Symbol("t")
MEASURED = number(Fraction("0.10003293"))
LONG = number(Fraction(1, 3_000_000))


@pytest.mark.parametrize(
    ("expression", "text"),
    [
        (MEASURED, "0.10003293"),
        (negate(MEASURED), "-0.10003293"),
        (number(Fraction(1, 3)), "1/3"),
        (number(Fraction(-7, 999)), "-7/999"),
        (number(Fraction(1, 1000)), "0.001"),
        (number(123456), "123456"),
        (multiply(MEASURED, Apply("cos", multiply(omega, t))), "0.10003293*cos(omega*t)"),
        (add(t, multiply(negate(MEASURED), omega)), "t - 0.10003293*omega"),
        (add(multiply(number(Fraction(-1, 2)), t), MEASURED), "0.10003293 - t/2"),
        (divide(omega, add(t, MEASURED)), "omega/(0.10003293 + t)"),
        (power(add(t, negate(MEASURED)), 2), "(t - 0.10003293)**2"),
        (LONG, "3.333333333e-07"),
        (omega, "omega"),
    ],
)
def test_decimal_text(expression, text):
    assert decimal_text(expression) == text


def _random(source, depth):
    if not depth:
        value = Fraction(source.randint(-999, 999), source.choice([1, 2, 7, 10**3, 10**6 + 3]))
        return source.choice([number(value), omega, t])
    first, second = _random(source, depth - 1), _random(source, depth - 1)
    kind = source.choice(["sum", "product", "difference", "quotient", "cos", "square"])
    return {
        "sum": lambda: add(first, second),
        "product": lambda: multiply(first, second),
        "difference": lambda: add(first, negate(second)),
        "quotient": lambda: divide(first, add(power(second, 2), number(2))),
        "cos": lambda: Apply("cos", first),
        "square": lambda: power(first, 2),
    }[kind]()


@pytest.mark.parametrize("seed", range(40))
def test_the_value_stays_to_the_digits_printed(seed, scalar, number):
    """Both texts, read back by the grammar of the file, are the same function to so many digits."""
    expression = _random(random.Random(seed), 2)
    values = {"a": 0.37, "t": 0.71}
    exact, rounded = (
        number(scalar(text.replace("omega", "a")), values)
        for text in (to_text(expression), decimal_text(expression))
    )

    assert rounded == pytest.approx(exact, rel=1e-9, abs=1e-9)


def test_short_fractions_make_no_difference():
    expression = add(multiply(number(Fraction(3, 7)), t), number(Fraction(-5, 13)))

    assert decimal_text(expression) == to_text(expression)
