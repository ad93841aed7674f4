"""Small files that would make large algebra: undecided with a reason, in seconds and in little memory."""

import resource

import pytest

from obscli.exact.analysis import analyze
from obscli.exact.finding import Undecided


def _nested(function, depth, inner="t"):
    for _ in range(depth):
        inner = function.replace("_", inner)
    return inner


HOSTILE = {
    "power": "(a + b + c)^200",
    "fraction": "(a + b + c + t)^200/(a - b + c - t)^150",
    "sines": _nested("sin(_)", 40),
    "roots": _nested("sqrt(_ + 1)", 40, "t^2 + 1"),
    "sum of roots": "1/(" + " + ".join(f"sqrt(t^2 + {k})" for k in range(1, 13)) + ")",
    "high root": "sqrt(p) + p^(1/3) + p^(1/5) + p^(1/7) + p^(1/11)",
    "tones": " + ".join(f"sin(w{k}*t)" for k in range(20)),
    "poles": " + ".join(f"1/(t + {k} + a)^3" for k in range(60)) + " + 1/(a + b + c)^60",
}


@pytest.mark.parametrize("entry", HOSTILE.values(), ids=HOSTILE)
def test_a_hostile_entry_is_undecided(row, entry):
    names = dict.fromkeys("abc", "") | {"p": "{assume: positive}"} | {f"w{k}": "" for k in range(20)}
    before = resource.getrusage(resource.RUSAGE_SELF)
    found = analyze(row(names, entry, "t*a"))
    after = resource.getrusage(resource.RUSAGE_SELF)
    assert isinstance(found, Undecided)
    assert "exact algebra" in found.reason
    assert after.ru_utime - before.ru_utime < 10
    assert after.ru_maxrss - before.ru_maxrss < 300_000


@pytest.mark.parametrize("size", [8, 12])
def test_a_hostile_matrix_is_undecided(system, size):
    A = [[f"m{i}_{j}" for j in range(size)] for i in range(size)]
    names = ", ".join(f"{name}: 1" for line in A for name in line)
    states = ", ".join(f"x{k}" for k in range(size))
    A = ", ".join(f"[{', '.join(line)}]" for line in A)
    ones = ", ".join(["1"] * size)
    found = analyze(system(f"parameters: {{{names}}}\nstates: [{states}]\nA: [{A}]\nH: [[{ones}]]\n"))
    assert isinstance(found, Undecided)
    assert "exact algebra" in found.reason
