"""Small files that would make large algebra: undecided with a reason, in seconds and in little memory."""

import resource

import pytest

from obscli.checks.certificate import check_certificate
from obscli.exact.analysis import analyze
from obscli.exact.elimination import eliminate
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


def _hostile_matrix(system, size, value):
    """x' = A x of unrelated parameters, one output: full rank at the highest order that can be."""
    A = [[f"m{i}_{j}" for j in range(size)] for i in range(size)]
    names = ", ".join(f"{name}: {value}" for line in A for name in line)
    states = ", ".join(f"x{k}" for k in range(size))
    A = ", ".join(f"[{', '.join(line)}]" for line in A)
    ones = ", ".join(["1"] * size)
    return system(f"parameters: {{{names}}}\nstates: [{states}]\nA: [{A}]\nH: [[{ones}]]\n")


@pytest.mark.parametrize("size", [8, 12])
def test_the_full_rank_of_a_hostile_matrix_is_proved_without_elimination(system, size):
    given = _hostile_matrix(system, size, "null")
    found = analyze(given)
    assert (found.rank, found.order) == (size, size - 1)
    assert [list(one.coefficients) for one in found.combinations] == [[name] for name in given.state_names]
    rows = [one.coefficients for one in found.combinations]
    assert check_certificate(given, found.certificate, rows).verdict == "holds"
    assert found.certificate.upper.delay is None
    assert not found.critical.complete
    assert found.critical.not_searched


def test_what_is_not_of_full_rank_stays_undecided(system):
    """One state more, which nothing sees and the elimination has to find out about."""
    text = "parameters: {{{}}}\nstates: [{}, z]\nA: [{}, [{}]]\nH: [[{}, 0]]\n"
    size = 8
    A = [[f"m{i}_{j}" for j in range(size)] for i in range(size)]
    found = analyze(
        system(
            text.format(
                ", ".join(f"{name}: null" for line in A for name in line),
                ", ".join(f"x{k}" for k in range(size)),
                ", ".join(f"[{', '.join(line)}, 0]" for line in A),
                ", ".join(["1"] * (size + 1)),
                ", ".join(["1"] * size),
            )
        )
    )
    assert isinstance(found, Undecided)
    assert "exact algebra" in found.reason


def test_a_hostile_matrix_with_values_takes_no_elimination_for_each_of_them(system, monkeypatch):
    """Where the generic rank needs no elimination, the one at the values must not take dozens in vain."""
    given, begun = _hostile_matrix(system, 8, 1), []

    def counted(*arguments):
        begun.append(1)
        assert len(begun) < 4, "too many eliminations"
        return eliminate(*arguments)

    monkeypatch.setattr("obscli.exact.prove.eliminate", counted)
    found = analyze(given)
    assert (found.rank, found.at_values.rank) == (8, 1)


def test_a_long_number_under_a_root_is_not_factored_for_hours(system):
    """The product of two primes of 50 digits: undecided at once, not after the age of the universe."""
    p, q = 10**49 + 9, 10**50 + 151
    given = system(f"states: [a, b]\nA: zeros(2, 2)\nH: [[1, sqrt({p * q})]]\n")
    finding = analyze(given)
    assert isinstance(finding, Undecided)
    assert "too long to be factored" in finding.reason


def test_a_critical_condition_with_a_long_discriminant_is_left_open(system):
    """s² + s − p q = 0: its roots are not written, and the search goes on."""
    p, q = 10**49 + 9, 10**50 + 151
    given = system(
        f"parameters: {{s: 1, c: 2}}\nstates: [a, b, d]\nA: zeros(3, 3)\n"
        f"H: [[1, 0, 0], [0, s^2 + s - {p * q}, 0], [0, 0, c]]\n"
    )
    critical = analyze(given).critical
    assert {"c = 0": "confirmed"}.items() <= {one.condition: one.kind for one in critical.values}.items()
    assert "undecided" in {one.kind for one in critical.values}
