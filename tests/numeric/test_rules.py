"""A function with a rule f' = F(f, t) follows it: against scipy, closed forms and its own derivative."""

import mpmath
import numpy as np
import pytest
from numpy.polynomial import legendre
from scipy.integrate import solve_ivp

from obscli.model.covector import parse_scalar
from obscli.numeric.errors import NotComputableError
from obscli.numeric.numeric_system import NumericSystem
from obscli.numeric.program import Program
from obscli.numeric.rule import solve_rules


NAMES = ("f", "g", "h")


@pytest.fixture(scope="session")
def solved(system):
    def solve(rules, initial, start=0.0, stop=10.0):
        listed = ", ".join(rules)
        given = system(f"functions: [{listed}]\nstates: [x]\nA: [[0]]\nH: [[{'+'.join(rules)}]]\n")
        read = {name: parse_scalar(given, rule, "test") for name, rule in rules.items()}
        found = solve_rules(read, np.array(initial, dtype=float), lambda t: {"t": t}, start, stop)
        program = Program(list(read.values()))

        def rate(t, f):
            values = {"t": t, **dict(zip(rules, f, strict=True))}
            return np.array([np.broadcast_to(one, np.shape(t)) for one in program.run(values)], dtype=float)

        return found, rate

    return solve


SYSTEMS = [
    ({"f": "-f + sin(3*t)", "g": "f*g/(1 + t)"}, [1, 0.5]),
    ({"f": "g", "g": "2*(1 - f^2)*g - f"}, [2, 0]),
    ({"f": "g - f", "g": "f*(1 - h) - g", "h": "f*g - 2*h/3"}, [1, 1, 1]),
    ({"f": "cos(t^2/4)"}, [0]),
]


@pytest.mark.parametrize(("rules", "initial"), SYSTEMS)
def test_solutions_agree_with_scipy(solved, rules, initial):
    found, rate = solved(rules, initial)
    t = np.linspace(0, 10, 41)
    other = solve_ivp(rate, (0, 10), initial, method="DOP853", t_eval=t, rtol=1e-13, atol=1e-13).y
    mine = np.array(list(found.values(t).values()))
    # scipy makes 1e-13 a step, some hundred steps, and errors may grow tenfold on the way
    np.testing.assert_allclose(mine, other, rtol=1e-10, atol=1e-10)


@pytest.mark.parametrize(("rules", "initial"), SYSTEMS)
def test_the_derivative_of_the_pieces_is_the_rule(solved, rules, initial):
    """On every panel d/dt of the polynomial equals F to the accuracy of its last coefficients."""
    found, rate = solved(rules, initial)
    for a, b, c in zip(found.edges[:-1], found.edges[1:], found.coefficients, strict=True):
        u = np.linspace(-1, 1, 9)
        f = np.array([legendre.legval(u, c[:, q]) for q in range(len(initial))])
        slope = np.array([legendre.legval(u, legendre.legder(c[:, q])) for q in range(len(initial))])
        F = rate((a + b) / 2 + (b - a) / 2 * u, f)
        # 16 nodes, coefficients below 1e-14 (1 + |f|)/h, of which a few times more shows at the ends
        assert np.abs(2 / (b - a) * slope - F).max() < 1e-11 * (
            1 + np.abs(F).max() + np.abs(f).max() / (b - a)
        )


@pytest.mark.parametrize(
    ("rule", "initial", "exact"),
    [
        ("-f", 1.0, lambda t: mpmath.exp(-t)),
        ("f", 1.0, mpmath.exp),
        ("-2*t*f", 1.0, lambda t: mpmath.exp(-t * t)),
        ("1 - f^2", 0.0, mpmath.tanh),
        ("1/(1 + t)", 0.0, lambda t: mpmath.log(1 + t)),
        ("0", 3.0, lambda _: mpmath.mpf(3)),
        ("20*cos(20*t)", 0.0, lambda t: mpmath.sin(20 * t)),
    ],
)
def test_closed_forms(solved, rule, initial, exact):
    found, _ = solved({"f": rule}, [initial], stop=4.0)
    t = np.linspace(0, 4, 33)
    off = [
        float(abs(mpmath.mpf(f) - exact(mpmath.mpf(one))))
        for f, one in zip(found.values(t)["f"], t, strict=True)
    ]
    largest = max(1.0, *(float(abs(exact(mpmath.mpf(one)))) for one in t))
    assert max(off) <= 100 * found.error * largest


def test_pieces_join(solved):
    found, _ = solved(*SYSTEMS[1])
    inner = found.edges[1:-1]
    before, after = (np.array(list(found.values(t).values())) for t in (np.nextafter(inner, 0), inner))
    np.testing.assert_allclose(before, after, atol=1e-13)
    assert found.edges[0] == 0
    assert found.edges[-1] == 10


@pytest.mark.parametrize(("start", "stop"), [(5.0, 7.0), (-3.0, -1.0), (-1.0, 2.0), (1e6, 1e6 + 2.0)])
def test_the_interval_may_lie_anywhere(solved, start, stop):
    found, _ = solved({"f": "-f + 1"}, [3.0], start, stop)
    t = np.linspace(start, stop, 7)
    # an instant is known to half a unit in its last place only
    tolerance = 1e-13 + np.spacing(max(abs(start), abs(stop)))
    np.testing.assert_allclose(found.values(t)["f"], 1 + 2 * np.exp(-(t - start)), atol=4 * tolerance)


@pytest.mark.parametrize(("rule", "where"), [("f^2", 1.0), ("1 + f^2", np.pi / 4), ("log(2 - t)*f", 2.0)])
def test_functions_that_run_away_are_named_with_the_instant(solved, rule, where):
    with pytest.raises(
        NotComputableError, match=r"^f: the rules cannot be followed beyond t = ([\d.]+)"
    ) as error:
        solved({"f": rule}, [1.0])
    assert float(str(error.value).split("=")[1]) == pytest.approx(where, abs=1e-3)


QUATERNION = """
functions:
  w: {shape: 3}
  q: {shape: 4, derivative: 1/2*omega4(w) @ q, invariant: norm(q)**2 - 1}
states: [x]
A: [[0]]
H: [[q1 + w1]]
"""


def test_a_unit_quaternion_keeps_its_norm_and_satisfies_its_rule(system):
    motion = NumericSystem(system(QUATERNION), 0.0, 30.0).motion
    t = np.linspace(0, 30, 301)[1:-1]
    values = motion.values(t, {})
    q, w = (np.array([values[f"{name}{k}"] for k in range(1, n + 1)]) for name, n in (("q", 4), ("w", 3)))
    np.testing.assert_allclose((q**2).sum(axis=0), 1, atol=1e-12)
    # q' = q ∘ (0, w)/2, Hamilton's product, written out
    half = 0.5 * np.array([
        -q[1] * w[0] - q[2] * w[1] - q[3] * w[2],
        q[0] * w[0] + q[2] * w[2] - q[3] * w[1],
        q[0] * w[1] + q[3] * w[0] - q[1] * w[2],
        q[0] * w[2] + q[1] * w[1] - q[2] * w[0],
    ])  # fmt: skip
    h = 1e-4
    before, after = (motion.values(t + one, {}) for one in (-h, h))
    slope = np.array([(after[f"q{k}"] - before[f"q{k}"]) / (2 * h) for k in range(1, 5)])
    # third derivatives of q are at most (|w| + …)³ ~ 30; the differences round to eps/h
    assert np.abs(slope - half).max() < 30 * h**2 + 1e-11
    assert np.ptp(q[0]) > 0.5
