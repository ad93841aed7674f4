"""The independent route behind the ranks in models/*.yaml: no obscli code, no obscli parser.

Every model is written here a second time, by hand, as Taylor series about one instant t0. With
Phi' = A Phi, Phi(t0) = I, the k-th Taylor coefficient of H Phi is L_k(t0) / k!, so the stacked
coefficients 0 .. n-1 have the rank of the observability matrix. Angles are rational points of the
unit circle, exp(-t) and t are independent rationals, sqrt(1 + t^2) has a rational t with a rational root:
everything is exact (fractions), and the rank at a random point is the generic rank with probability one
(it is a lower bound with certainty; three points must agree). Nominal values are computed in 150 digits.

    python tests/independent/observability_rank.py            # table of ranks and verdicts
    python tests/independent/observability_rank.py --check    # compare with claims/expect of models/
"""

from __future__ import annotations

import argparse
import functools
import random
import sys
from fractions import Fraction
from pathlib import Path

import mpmath
import sympy
import yaml


MODELS = Path(__file__).resolve().parents[2] / "models"
mpmath.mp.dps = 150


# ------------------------------------------------------------------------------- truncated power series


class Series:
    """c[0] + c[1] h + c[2] h^2 + ...: h = t - t0, as many coefficients as the case needs."""

    def __init__(self, c):
        self.c = list(c)

    def _other(self, other):
        return other if isinstance(other, Series) else Series([other] + [0] * (len(self.c) - 1))

    def __add__(self, other):
        return Series(a + b for a, b in zip(self.c, self._other(other).c, strict=True))

    def __mul__(self, other):
        if not isinstance(other, Series):
            return Series(a * other for a in self.c)
        n = len(self.c)
        return Series(sum(self.c[j] * other.c[k - j] for j in range(k + 1)) for k in range(n))

    def __neg__(self):
        return Series(-a for a in self.c)

    def __sub__(self, other):
        return self + (-self._other(other))

    def __rsub__(self, other):
        return self._other(other) - self

    def inverse(self):
        out = [1 / self.c[0]]
        for k in range(1, len(self.c)):
            out.append(-sum(self.c[j] * out[k - j] for j in range(1, k + 1)) / self.c[0])
        return Series(out)

    def root(self, value):
        """The square root whose value at t0 is ``value``."""
        out = [value]
        for k in range(1, len(self.c)):
            out.append((self.c[k] - sum(out[j] * out[k - j] for j in range(1, k))) / (2 * value))
        return Series(out)

    __radd__ = __add__
    __rmul__ = __mul__


def coefficients(entry, terms):
    return entry.c if isinstance(entry, Series) else [entry] + [0] * (terms - 1)


# ---------------------------------------------------------------------------------------------- points


class Point:
    """One random rational point: parameters, time, angles; ``fixed`` holds exact substitutions as text."""

    def __init__(self, seed, fixed, terms):
        self.random, self.fixed, self.terms = random.Random(seed), dict(fixed), terms
        self.seen, self.phases = {}, {}
        self.values = {}  # what the text of a claim may contain, at t0

    def draw(self):
        return Fraction(self.random.randint(2, 40) * self.random.choice([-1, 1]), self.random.randint(3, 23))

    def number(self, name):
        if name not in self.seen:
            text = self.fixed.get(name)
            if text is None:
                value = self.draw()
            elif text.lstrip("-").isidentifier():
                value = self.number(text.lstrip("-")) * (-1 if text[0] == "-" else 1)
            else:
                value = Fraction(text)
            self.seen[name] = self.values[name] = value
        return self.seen[name]

    def positive(self, name):
        self.seen[name] = self.values[name] = abs(self.number(name))
        return self.seen[name]

    def circle(self):
        """A rational point of the unit circle, off the axes."""
        u = self.draw()
        while abs(u) == 1:
            u = self.draw()
        return (1 - u * u) / (1 + u * u), 2 * u / (1 + u * u)

    def angle(self, name):
        """cos and sin of a constant angle."""
        exact = {"0": (1, 0), "pi": (-1, 0), "pi/2": (0, 1), None: None}[self.fixed.get(name)]
        c, s = map(Fraction, exact) if exact else self.circle()
        self.values[f"cos({name})"], self.values[f"sin({name})"] = c, s
        return c, s

    def trig(self, name):
        """cos(name*t), sin(name*t) as series; equal rates share their phase, rate 0 is the angle 0."""
        rate = self.number(name)
        if abs(rate) not in self.phases:
            self.phases[abs(rate)] = self.circle() if rate else (Fraction(1), Fraction(0))
        c, s = self.phases[abs(rate)]
        s = s if rate >= 0 else -s
        cos, sin = [c], [s]
        for k in range(1, self.terms):
            cos, sin = [*cos, -rate * sin[k - 1] / k], [*sin, rate * cos[k - 1] / k]
        self.values[f"cos({name}*t)"], self.values[f"sin({name}*t)"] = c, s
        return Series(cos), Series(sin)

    def function(self, name):
        """An arbitrary function of time: random jets."""
        if name in self.fixed:
            return (
                self.number(self.fixed[name])
                if self.fixed[name].isidentifier()
                else Fraction(self.fixed[name])
            )
        out = Series(self.draw() for _ in range(self.terms))
        self.values[name] = out.c[0]
        return out

    def time(self):
        """t with sqrt(1 + t^2) rational."""
        m = 1 + abs(self.draw())
        t = (m * m - 1) / (2 * m)
        series = Series([t, Fraction(1)] + [Fraction(0)] * (self.terms - 2))
        self.values["t"] = t
        return series, (m * m + 1) / (2 * m)

    def decay(self, rate):
        """exp(-rate t), its value at t0 an independent rational."""
        out = [abs(self.draw())]
        for k in range(1, self.terms):
            out.append(-rate * out[-1] / k)
        return Series(out)


VALUES = {"omega": "0.1", "g": "9.81", "phi": "0.47", "alpha_omega": "0.001", "alpha_w": "0.001"}


class Nominal(Point):
    """The file's values, in 150 digits, at t = 1.7."""

    def __init__(self, values, terms):
        super().__init__(0, {}, terms)
        self.nominal = {**{k: mpmath.mpf(v) for k, v in VALUES.items()}, "omega_ie": 2 * mpmath.pi / 86400}
        self.nominal |= {k: mpmath.mpf(v) for k, v in values.items()}
        self.t0 = mpmath.mpf("1.7")

    def number(self, name):
        self.values[name] = self.nominal[name]
        return self.nominal[name]

    positive = number

    def angle(self, name):
        value = self.number(name)
        self.values[f"cos({name})"], self.values[f"sin({name})"] = mpmath.cos(value), mpmath.sin(value)
        return mpmath.cos(value), mpmath.sin(value)

    def trig(self, name):
        angle = abs(self.number(name)) * self.t0
        self.phases[abs(self.number(name))] = (mpmath.cos(angle), mpmath.sin(angle))
        return super().trig(name)


# ---------------------------------------------------------------------------------------------- models
# Each function returns the names of the states, A (rows) and H (rows), entries numbers or Series.


def names(**shapes):
    return [f"{name}{i}" for name, size in shapes.items() for i in range(1, size + 1)]


def zeros(rows, columns):
    return [[0] * columns for _ in range(rows)]


def product(P, Q):
    return [[sum(P[i][k] * Q[k][j] for k in range(len(Q))) for j in range(len(Q[0]))] for i in range(len(P))]


INS_STATES = (
    names(psi=3, b_g=3, b_a=3)
    + [f"M_g{i}{j}" for i in (1, 2, 3) for j in (1, 2, 3)]
    + [f"M_a{i}{j}" for i in (1, 2, 3) for j in range(1, i + 1)]
)


def ins(p, R, rate, c_phi, s_phi):
    """(5), (6): psi' = -w x psi + R(b_g + M_g R^T(w + rate)), y = e3 x psi + R(b_a/g + M_a R^T e3)."""
    g, w = p.positive("g"), p.positive("omega_ie")
    w2, w3 = w * c_phi, w * s_phi
    column = {name: i for i, name in enumerate(INS_STATES)}
    turn = [rate[0], w2 + rate[1], w3 + rate[2]]
    w_ib = [sum(R[j][i] * turn[j] for j in range(3)) for i in range(3)]
    f = [R[2][i] for i in range(3)]
    A, H = zeros(24, 24), zeros(3, 24)
    A[0][1], A[0][2], A[1][0], A[2][0] = w3, -w2, -w3, w2
    H[0][1], H[1][0] = -1, 1
    for i in range(3):
        for j in range(3):
            A[i][column[f"b_g{j + 1}"]] = R[i][j]
            H[i][column[f"b_a{j + 1}"]] = R[i][j] * (1 / g)
            for k in range(3):
                A[i][column[f"M_g{j + 1}{k + 1}"]] = R[i][j] * w_ib[k]
                if k <= j:
                    H[i][column[f"M_a{j + 1}{k + 1}"]] = R[i][j] * f[k]
    return INS_STATES, A, H


def ins_horizontal(p, stage):
    c, s = p.trig("omega")
    R = {
        "stage_1": [[1, 0, 0], [0, c, -s], [0, s, c]],
        "stage_2": [[0, 1, 0], [c, 0, s], [s, 0, -c]],
        "stage_3": [[0, 0, 1], [-s, -c, 0], [c, -s, 0]],
    }[stage or "stage_1"]
    return ins(p, R, [p.number("omega"), 0, 0], *p.angle("phi"))


def ins_vertical(p, stage):
    c, s = p.trig("omega")
    P = {  # column i is the navigation axis along which body axis i points at t = 0
        "stage_1": [[0, 1, 0], [0, 0, 1], [1, 0, 0]],
        "stage_2": [[0, 0, 1], [1, 0, 0], [0, 1, 0]],
        "stage_3": [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
    }[stage]
    R = product([[c, -s, 0], [s, c, 0], [0, 0, 1]], P)
    return ins(p, R, [0, 0, p.number("omega")], *p.angle("phi"))


def ins_sparse(p, stage):
    assert stage is None
    return ins_horizontal(p, "stage_1")


def ins_equator(p, stage):
    p.fixed["phi"] = "0"
    return ins_horizontal(p, stage)


def ins_pole(p, stage):
    p.fixed["phi"] = "pi/2"
    return ins_horizontal(p, stage)


def bagmut_full(p, stage):
    g, R = p.positive("g"), p.positive("R")
    A = [[0, -g, 0, 1], [1 / R, 0, 1, 0], [0] * 4, [0] * 4]
    return ["dv", "alpha", "domega", "da"], A, [{"velocity": [1, 0, 0, 0], "attitude": [0, 1, 0, 0]}[stage]]


def bagmut_gyro(p, stage):
    g, R = p.positive("g"), p.positive("R")
    A = [[0, -g, 0], [1 / R, 0, 1], [0] * 3]
    return ["dv", "alpha", "domega"], A, [{"velocity": [1, 0, 0], "attitude": [0, 1, 0]}[stage]]


def bagmut_accel(p, stage):
    g, R = p.positive("g"), p.positive("R")
    A = [[0, -g, 1], [1 / R, 0, 0], [0] * 3]
    return ["dv", "alpha", "da"], A, [{"velocity": [1, 0, 0], "attitude": [0, 1, 0]}[stage]]


def kortunov(p, states):
    g = p.positive("g")
    everything = ["alpha", "V", "R", "dOm", "dW"]
    entry = {("alpha", "dOm"): 1, ("V", "alpha"): g, ("V", "dW"): 1, ("R", "V"): 1}
    if "dOm" in states:
        entry["dOm", "dOm"] = p.number("alpha_omega")
    if "dW" in states:
        entry["dW", "dW"] = p.number("alpha_w")
    chosen = [x for x in everything if x in states]
    A = [[entry.get((i, j), 0) for j in chosen] for i in chosen]
    return chosen, A, [[int(x == y) for x in chosen] for y in ("V", "R")]


def double_integrator(_p, stage):
    return ["x", "v"], [[0, 1], [0, 0]], [{"position": [1, 0], "velocity": [0, 1]}[stage]]


def rotating_pair(p, _stage):
    w = p.number("omega")
    return ["x1", "x2"], [[0, -w], [w, 0]], [[1, 0]]


def oscillator(p, _stage):
    w, a, (c, _) = p.number("omega"), p.number("a"), p.trig("omega")
    return ["dx", "dv", "domega"], [[0, 1, 0], [-w * w, 0, c * (-2 * w * a)], [0, 0, 0]], [[1, 0, 0]]


def frozen_unobservable(p, _stage):
    c, s = p.trig("omega")
    return ["h1", "h2"], zeros(2, 2), [[c, s]]


def frozen_observable(p, _stage):
    w, (c, s) = p.number("omega"), p.trig("omega")
    return ["x1", "x2"], [[0, -w], [w, 0]], [[c, s]]


def mixed(p, _stage):
    t, root = p.time()
    A = zeros(4, 4)
    A[0][0], A[0][1] = -(1 + t).inverse(), p.decay(1)
    r = (1 + t * t).root(root)
    p.values["sqrt(1 + t**2)"] = root
    return ["x1", "x2", "x3", "x4"], A, [[1, 0, r, -r]]


def aiding(p, stage):
    w, (c, s) = p.number("omega_ie"), p.angle("L")
    p.fixed |= {
        "manoeuvre": {},
        "straight_line": {"f_E": "0"},
        "constant_velocity": {"f_E": "0", "f_N": "0", "f_U": "g"},
    }[stage]
    if stage == "constant_velocity":
        p.positive("g")
    f_E, f_N, f_U = p.function("f_E"), p.function("f_N"), p.function("f_U")
    states = ["v_E", "v_N", "phi_E", "phi_N", "phi_U", "b_E", "b_N", "b_U"]
    A = zeros(8, 8)
    A[0][4], A[0][3] = f_N, -f_U
    A[1][2], A[1][4] = f_U, -f_E
    A[2][3], A[2][4], A[2][5] = w * s, -w * c, 1
    A[3][2], A[3][6] = -w * s, 1
    A[4][2], A[4][7] = w * c, 1
    return states, A, [[1, 0, 0, 0, 0, 0, 0, 0], [0, 1, 0, 0, 0, 0, 0, 0]]


def two_tones(p, _stage):
    return ["x1", "x2"], zeros(2, 2), [[p.trig("a")[1], p.trig("b")[1]]]


def cardioid(p, _stage):
    c, _ = p.angle("phi")
    return ["s1", "s2"], zeros(2, 2), [[1, 1], [0, (1 + c) / 2]]


def quaternion(p, stage):
    """q' = q o (0, w)/2 about a rational unit quaternion, w arbitrary; R rotates body to navigation axes."""
    p.fixed |= {
        "any_motion": {},
        "one_axis": {"w1": "0", "w2": "0"},
        "no_rotation": {"w1": "0", "w2": "0", "w3": "0"},
    }[stage]
    w = [coefficients(p.function(f"w{i}"), p.terms) for i in (1, 2, 3)]
    u = [p.draw() for _ in range(3)]
    n = sum(x * x for x in u)
    q = [[(1 - n) / (1 + n)], *([2 * x / (1 + n)] for x in u)]
    for k in range(p.terms - 1):

        def conv(a, b, k=k):
            return sum(q[a][j] * w[b][k - j] for j in range(k + 1))

        half = Fraction(1, 2 * (k + 1))
        new = [
            -conv(1, 0) - conv(2, 1) - conv(3, 2),
            conv(0, 0) + conv(2, 2) - conv(3, 1),
            conv(0, 1) + conv(3, 0) - conv(1, 2),
            conv(0, 2) + conv(1, 1) - conv(2, 0),
        ]
        for part, value in zip(q, new, strict=True):
            part.append(value * half)
    a, b, c, d = map(Series, q)
    p.values |= {f"q{i + 1}": q[i][0] for i in range(4)}
    R = [
        [a * a + b * b - c * c - d * d, 2 * (b * c - a * d), 2 * (b * d + a * c)],
        [2 * (b * c + a * d), a * a - b * b + c * c - d * d, 2 * (c * d - a * b)],
        [2 * (b * d - a * c), 2 * (c * d + a * b), a * a - b * b - c * c + d * d],
    ]
    A, H = zeros(9, 9), zeros(6, 9)
    for i in range(3):
        H[i][i], A[i][3 + i], H[3 + i][6 + i] = 1, 1, 1
        for j in range(3):
            A[i][6 + j] = R[i][j]
            H[3 + i][3 + j] = R[j][i]
    return names(v=3, d=3, b_a=3), A, H


def levelling(p, _stage):
    g = p.positive("g")
    return ["v", "tilt", "b_a", "b_g"], [[0, g, 1, 0], [0, 0, 0, 1], [0] * 4, [0] * 4], [[1, 0, 0, 0]]


INS3 = ["stage_1", "stage_2", "stage_3"]
CASES = {
    "ins_calibration/horizontal": (ins_horizontal, INS3),
    "ins_calibration/stage_1_sparse": (ins_sparse, [None]),
    "ins_calibration/vertical": (ins_vertical, INS3),
    "ins_calibration/equator": (ins_equator, INS3),
    "ins_calibration/pole": (ins_pole, INS3),
    "bagmut/horizontal_channel": (bagmut_full, ["velocity", "attitude"]),
    "bagmut/gyro": (bagmut_gyro, ["velocity", "attitude"]),
    "bagmut/accelerometer": (bagmut_accel, ["velocity", "attitude"]),
    "kortunov/single_channel": (lambda p, _: kortunov(p, ["alpha", "V", "R", "dOm", "dW"]), [None]),
    "kortunov/three_states": (lambda p, _: kortunov(p, ["alpha", "V", "R"]), [None]),
    "kortunov/gyro_only": (lambda p, _: kortunov(p, ["alpha", "V", "R", "dOm"]), [None]),
    "kortunov/accelerometer_only": (lambda p, _: kortunov(p, ["alpha", "V", "R", "dW"]), [None]),
    "textbook/double_integrator": (double_integrator, ["position", "velocity"]),
    "textbook/rotating_pair": (rotating_pair, [None]),
    "textbook/oscillator_frequency": (oscillator, [None]),
    "textbook/frozen_unobservable": (frozen_unobservable, [None]),
    "textbook/frozen_observable": (frozen_observable, [None]),
    "textbook/mixed_coefficients": (mixed, [None]),
    "textbook/ins_velocity_aiding": (aiding, ["manoeuvre", "straight_line", "constant_velocity"]),
    "textbook/two_tones": (two_tones, [None]),
    "textbook/cardioid": (cardioid, [None]),
    "textbook/attitude_quaternion": (quaternion, ["any_motion", "one_axis", "no_rotation"]),
    "textbook/levelling": (levelling, [None]),
}
SIZE = {"ins_calibration": 24}
NOMINAL = {  # where a file differs from VALUES
    "kortunov": {"g": "9.8"},
    "bagmut": {"g": "9.8", "R": "6378137"},
    "rotating_pair": {"omega": "0.5"},
    "oscillator_frequency": {"omega": "2", "a": "0.1"},
    "frozen_unobservable": {"omega": "0.2"},
    "frozen_observable": {"omega": "0.2"},
    "two_tones": {"a": "2", "b": "3"},
    "cardioid": {"phi": "0.8"},
}


# ------------------------------------------------------------------------------- rank and row space of L


def stacked(A, H, terms):
    """The Taylor coefficients of H Phi, k = 0 .. terms-1, one above the other."""
    n = len(A)
    a = {(i, j): coefficients(A[i][j], terms) for i in range(n) for j in range(n)}
    a = {k: c for k, c in a.items() if any(c)}
    h = {(i, j): coefficients(H[i][j], terms) for i in range(len(H)) for j in range(n)}
    h = {k: c for k, c in h.items() if any(c)}
    Phi = [[[int(i == j) for j in range(n)] for i in range(n)]]
    for k in range(terms - 1):
        new = zeros(n, n)
        for (i, j), c in a.items():
            for power in range(k + 1):
                if c[power]:
                    new[i] = [
                        x + c[power] * y if y else x for x, y in zip(new[i], Phi[k - power][j], strict=True)
                    ]
        Phi.append(
            [
                [x * Fraction(1, k + 1) if isinstance(x, (int, Fraction)) else x / (k + 1) for x in row]
                for row in new
            ]
        )
    rows = []
    for k in range(terms):
        new = zeros(len(H), n)
        for (i, j), c in h.items():
            for power in range(k + 1):
                if c[power]:
                    new[i] = [
                        x + c[power] * y if y else x for x, y in zip(new[i], Phi[k - power][j], strict=True)
                    ]
        rows += new
    return rows


def reduce_rows(rows, tolerance=0):
    """Reduced echelon form (largest pivot of the column, rows scaled), and the pivot columns."""
    rows = [list(r) for r in rows]
    if tolerance:
        rows = [
            [x / max(map(abs, r)) for x in r] if max(map(abs, r)) > tolerance else [0 * x for x in r]
            for r in rows
        ]
    pivots, top = [], 0
    for column in range(len(rows[0]) if rows else 0):
        best = max(range(top, len(rows)), key=lambda i: abs(rows[i][column]), default=None)
        if best is None or abs(rows[best][column]) <= tolerance:
            continue
        rows[top], rows[best] = rows[best], rows[top]
        pivot = rows[top][column]
        rows[top] = [x / pivot for x in rows[top]]
        for i, row in enumerate(rows):
            if i != top and row[column]:
                rows[i] = [x - row[column] * y for x, y in zip(row, rows[top], strict=True)]
                rows[i][column] = 0 * pivot
        pivots.append(column)
        top += 1
    return rows[:top], pivots


class Case:
    """One model, one stage, one point: row space of L."""

    def __init__(self, model, stage, at, seed=0):
        function, _ = CASES[model]
        terms = SIZE.get(model.split("/")[0], 9)
        at = at if isinstance(at, str) else dict(at)
        nominal = at == "nominal"
        folder, name = model.split("/")
        p = (
            Nominal({**NOMINAL.get(folder, {}), **NOMINAL.get(name, {})}, terms)
            if nominal
            else Point(seed, at, terms)
        )
        self.states, A, H = function(p, stage)
        assert terms >= len(self.states)
        self.values = p.values
        self.tolerance = mpmath.mpf(10) ** -60 if nominal else 0
        self.one = mpmath.mpf(1) if nominal else Fraction(1)
        rows = [[self.one * x for x in row] for row in stacked(A, H, terms)]
        self.basis, self.pivots = reduce_rows(rows, self.tolerance)
        self.rank = len(self.basis)

    def contains(self, row):
        for base, pivot in zip(self.basis, self.pivots, strict=True):
            if row[pivot]:
                row = [x - row[pivot] * y for x, y in zip(row, base, strict=True)]
        return all(abs(x) <= self.tolerance for x in row)

    def verdict(self, state):
        i = self.states.index(state)
        if self.contains([self.one * (j == i) for j in range(len(self.states))]):
            return "observable"
        return "coupled" if any(abs(row[i]) > self.tolerance for row in self.basis) else "unobservable"

    # the text of a claim, read by sympy and evaluated at this point

    @functools.cached_property
    def symbols(self):
        return {
            name: sympy.Symbol(name)
            for name in (*self.states, "t", "phi", *(k for k in self.values if k.isidentifier()))
        }

    @functools.cached_property
    def table(self):
        pairs = [(sympy.sympify(k, locals=self.symbols), sympy.sympify(v)) for k, v in self.values.items()]
        return sorted(pairs, key=lambda pair: -sympy.count_ops(pair[0]))

    def value(self, expression):
        out = expression.subs(self.table) if expression.free_symbols else expression
        if out.is_Rational:
            return self.one * Fraction(int(out.p), int(out.q))
        if self.tolerance and out.is_number:
            return mpmath.mpf(out.evalf(140)._mpf_)
        raise ValueError(f"{expression}: left at {out}")

    def row(self, text):
        expression = sympy.expand(sympy.sympify(text, locals=self.symbols))
        return [self.value(expression.coeff(self.symbols[s], 1)) for s in self.states]

    def vector(self, mapping):
        assert set(mapping) <= set(self.states), mapping
        return [self.value(sympy.sympify(mapping.get(s, "0"), locals=self.symbols)) for s in self.states]

    def annihilates(self, vector):
        return all(
            abs(sum(a * b for a, b in zip(row, vector, strict=True))) <= self.tolerance * 10**20
            for row in self.basis
        )


def frozen_rank(model, stage, seed=1):
    """The rank with A, H at t0 taken as constant: what tools for time-invariant systems compute."""
    _, A, H = CASES[model][0](Point(seed, {}, 24), stage)
    A, H = ([[Fraction(coefficients(x, 24)[0]) for x in row] for row in M] for M in (A, H))
    rows = stacked(A, H, len(A))
    return len(reduce_rows([[Fraction(x) for x in row] for row in rows])[0])


def table():
    """Print rank and verdicts of every model and stage (o observable, c coupled, . unobservable)."""
    for model, (_, stages) in CASES.items():
        for stage in stages:
            cases = [Case(model, stage, {}, seed) for seed in (1, 2, 3)]
            assert len({c.rank for c in cases}) == 1
            case = cases[0]
            sign = {"observable": "o", "coupled": "c", "unobservable": "."}
            verdicts = " ".join(sign[case.verdict(s)] + s for s in case.states)
            rank = f"rank {case.rank:2} of {len(case.states):2}, frozen {frozen_rank(model, stage):2}"
            sys.stdout.write(f"{model:32} {stage or '-':18} {rank}  {verdicts}\n")


def check(models=MODELS):
    """Compare every claim and expectation with the rows computed here; return the list of disagreements."""
    wrong, count = [], 0
    case_at = functools.cache(Case)
    for model in CASES:
        document = yaml.load((models / f"{model}.yaml").read_text(encoding="utf-8"), Loader=yaml.BaseLoader)
        for kind in ("claims", "expect"):
            for number, claim in enumerate(document.get(kind, [])):
                at = claim.get("at", {})
                for seed in [0] if at == "nominal" else [1, 2, 3]:
                    case = case_at(
                        model, claim.get("stage"), at if at == "nominal" else tuple(at.items()), seed
                    )
                    head = f"{model} {kind}[{number}] at {at or 'generic'}, point {seed}"
                    wrong.extend(f"{head}: {problem}" for problem in disagreements(case, claim))
                count += 1
    return wrong, count


def disagreements(case, claim):
    known = {"stage", "at", "rank", "basis", "observable", "unobservable", "directions", "states"}
    yield from (f"field {key} is not checked here" for key in set(claim) - known)
    if "rank" in claim and int(claim["rank"]) != case.rank:
        yield f"rank {claim['rank']}, computed {case.rank}"
    if "basis" in claim:
        rows = [case.row(text) for text in claim["basis"]]
        yield from (
            f"basis: {text} is not observable"
            for text, row in zip(claim["basis"], rows, strict=True)
            if not case.contains(row)
        )
        if not len(rows) == len(reduce_rows(rows, case.tolerance)[0]) == case.rank:
            yield f"basis: {len(rows)} rows, rank {len(reduce_rows(rows)[0])}, computed {case.rank}"
    yield from (
        f"observable: {text} is not"
        for text in claim.get("observable", [])
        if not case.contains(case.row(text))
    )
    yield from (
        f"unobservable: {text} is observable"
        for text in claim.get("unobservable", [])
        if case.contains(case.row(text))
    )
    yield from (
        f"direction {d} is seen"
        for d in claim.get("directions", [])
        if not case.annihilates(case.vector(d)) or not any(case.vector(d))
    )
    for state, verdict in claim.get("states", {}).items():
        if case.verdict(state) != verdict:
            yield f"{state}: {verdict}, computed {case.verdict(state)}"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true")
    if not parser.parse_args().check:
        table()
        return 0
    wrong, count = check()
    sys.stdout.write(("\n".join(wrong) or f"all {count} entries agree") + "\n")
    return bool(wrong)


if __name__ == "__main__":
    sys.exit(main())
