"""Every run of models/calibration/*.yaml a second time, by hand: no obscli code, no obscli parser.

A run is x = (fresh, c) with fresh' = F fresh + B(t) c, c' = 0, y = K fresh + D(t) c. B and D are Taylor
series about one instant; angles are rational points of the unit circle, parameters random rationals: all is
exact.
"""

from __future__ import annotations

import functools
import random
from fractions import Fraction


TERMS = 12  # Taylor coefficients
RIGHT = {"0": (1, 0), "pi/2": (0, 1), "pi": (-1, 0), "3*pi/2": (0, -1), "-pi/2": (0, -1)}


# --------------------------------------------------------------------------------------- series and vectors


class Series:
    """c[0] + c[1] h + ... about t0."""

    def __init__(self, c):
        self.c = [*c, *[Fraction(0)] * (TERMS - len(c))]

    def __add__(self, other):
        return Series([a + b for a, b in zip(self.c, series(other).c, strict=True)])

    def __mul__(self, other):
        if not isinstance(other, Series):
            return Series([a * other for a in self.c])
        return Series([sum(self.c[j] * other.c[k - j] for j in range(k + 1)) for k in range(TERMS)])

    def __neg__(self):
        return self * -1

    def __sub__(self, other):
        return self + -series(other)

    def __rsub__(self, other):
        return series(other) - self

    def inverse(self):
        out = [1 / self.c[0]]
        for k in range(1, TERMS):
            out.append(-sum(self.c[j] * out[k - j] for j in range(1, k + 1)) / self.c[0])
        return Series(out)

    __radd__, __rmul__ = __add__, __mul__


def series(x):
    return x if isinstance(x, Series) else Series([Fraction(x)])


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def times(M, v):
    return [sum(a * x for a, x in zip(row, v, strict=True)) for row in M]


def transpose(M):
    return [list(row) for row in zip(*M, strict=True)]


def product(*matrices):
    return functools.reduce(lambda P, Q: transpose([times(P, column) for column in transpose(Q)]), matrices)


def turn(axis, c, s):
    """Right-handed rotation about axis 0, 1, 2 by the angle of cosine c, sine s."""
    j, k, M = (axis + 1) % 3, (axis + 2) % 3, [[int(a == b) for b in range(3)] for a in range(3)]
    M[j][j], M[j][k], M[k][j], M[k][k] = c, -s, s, c
    return M


UNIT = turn(0, 1, 0)
UP = {"x": [UNIT[1], UNIT[2], UNIT[0]], "y": [UNIT[2], UNIT[0], UNIT[1]], "z": UNIT}  # body axis up at rest


# --------------------------------------------------------------------------------------- points and physics


class Point:
    """Parameters at random (seed 0: primes, recognised in the kernels); ``fix``: given angles, omega."""

    def __init__(self, seed, fix):
        draw = random.Random(seed)
        self.draw = lambda: Fraction(draw.choice([-1, 1]) * draw.randint(2, 30), draw.randint(3, 23))
        chosen = [Fraction(x) for x in (3, 7, 5)] if seed == 0 else [abs(self.draw()) for _ in range(3)]
        self.omega, self.g, self.omega_ie = chosen
        self.values = {"omega": self.omega, "g": self.g, "omega_ie": self.omega_ie}
        self.phi = self.circle()  # every run of an experiment draws the same latitude: it is drawn first
        self.fix = fix
        self.rate = -self.omega if fix.get("omega") == "-omega" else self.omega
        self.w_ie = [Fraction(0), self.omega_ie * self.phi[0], self.omega_ie * self.phi[1]]
        self.gravity = [Fraction(0), Fraction(0), self.g]

    def circle(self):
        u = self.draw()
        while abs(u) == 1:
            u = self.draw()
        return (1 - u * u) / (1 + u * u), 2 * u / (1 + u * u)

    def angle(self, name):
        return tuple(map(Fraction, RIGHT[self.fix[name]])) if name in self.fix else self.circle()

    def phase(self, speed):
        """cos and sin of an angle of which ``speed`` is the derivative."""
        (c, s), speed = ([x] for x in self.circle()), series(speed).c
        for k in range(TERMS - 1):
            new = [sum(speed[j] * v[k - j] for j in range(k + 1)) / (k + 1) for v in (c, s)]
            c, s = [*c, -new[1]], [*s, new[0]]
        return Series(c), Series(s)


def names(**vectors):
    return [f"{name}{index}" for name, indices in vectors.items() for index in indices.split()]


VECTOR, FULL, LOWER = "1 2 3", "11 12 13 21 22 23 31 32 33", "11 21 22 31 32 33"
INS = names(b_g=VECTOR, b_a=VECTOR, M_g=FULL, M_a=LOWER)
SIX = names(b_a=VECTOR, M_a=FULL, b_g=VECTOR)
TABLE = [*names(b_g=VECTOR, b_a=VECTOR, M_g=FULL, M_a=FULL, tau="1 2", mu=VECTOR), "kappa"]
NINE = names(b_a=VECTOR, M_a=LOWER)


def instrument(name, letter, u):
    """Column of b + M u for one constant: zero unless it belongs to this triad."""
    if name[:3] not in (f"b_{letter}", f"M_{letter}"):
        return [0, 0, 0]
    return [(u[int(name[4]) - 1] if name[0] == "M" else 1) * int(i == int(name[3]) - 1) for i in range(3)]


def inertial(p, R, rate):
    """psi' = -w_ie x psi + R(b_g + M_g R^T(w_ie + rate)), y = e3 x psi + R(b_a + M_a R^T gravity)/g."""
    w_ib = times(transpose(R), [a + b for a, b in zip(p.w_ie, rate, strict=True)])
    f_b = times(transpose(R), p.gravity)
    F = transpose([[-x for x in cross(p.w_ie, e)] for e in UNIT])
    B = transpose([times(R, instrument(name, "g", w_ib)) for name in INS])
    D = transpose([[x * (1 / p.g) for x in times(R, instrument(name, "a", f_b))] for name in INS])
    return F, B, transpose([cross(UNIT[2], e) for e in UNIT]), D


def paper_level(p, stage):
    c, s = p.phase(p.rate)
    R = {
        "stage_1": [[1, 0, 0], [0, c, -s], [0, s, c]],
        "stage_2": [[0, 1, 0], [c, 0, s], [s, 0, -c]],
        "stage_3": [[0, 0, 1], [-s, -c, 0], [c, -s, 0]],
    }[stage]
    return inertial(p, R, [p.rate, 0, 0])


def on_table(p, outer, mounting):
    """The inner axis turns on an outer one (about north) that stands: 0 is up, pi/2 is east."""
    O = turn(1, *outer)
    return inertial(p, product(O, turn(2, *p.phase(p.rate)), mounting), times(O, [0, 0, p.rate]))


def two_axis(p, stage):
    if stage == "inner_turns":
        return on_table(p, p.angle("outer"), UNIT)
    return inertial(p, product(turn(1, *p.phase(p.rate)), turn(2, *p.angle("inner"))), [0, p.rate, 0])


def cube(p, _stage):
    angles = ((2, "heading"), (1, "pitch"), (0, "roll"))
    return inertial(p, product(*(turn(axis, *p.angle(name)) for axis, name in angles)), [0, 0, 0])


def six(p, stage):
    """Readings in body axes; psi constant; ``stage``: kind and orientation, such as 'levelled x_down'."""
    kind, position = ([*stage.split(), "z_up"])[:2]
    tilt = {"up": (1, 0), "down": (-1, 0), "edge": p.angle("edge")}[position[2:]]
    back = transpose(product(turn(0, *tilt), UP[position[0]]))
    D = [instrument(name, "a", times(back, p.gravity)) for name in SIX]
    K = [times(back, cross(p.gravity, e)) for e in UNIT]
    if kind == "levelled":
        D = [d + instrument(name, "g", []) + [0] * 3 for d, name in zip(D, SIX, strict=True)]
        K = [k + times(back, cross(p.w_ie, e)) + e for k, e in zip(K, UNIT, strict=True)]
    return [[0] * 3] * 3, [[0] * len(SIX)] * 3, transpose(K), transpose(D)


def table_errors(p, stage):
    """R = (1 + tau x) R(theta) (1 + kappa theta e1 x) C (1 + mu x); readings in body axes, minus nominal."""
    C = {"x": UNIT, "y": UP["x"], "z": UP["y"]}[(stage or "x_east")[0]]
    C = product(turn(2, -1, 0), C) if (stage or "").endswith("west") else C
    R = product(turn(0, *p.phase(p.rate)), C)
    back, theta = transpose(R), Series([p.draw(), p.rate])
    w_ib, f_b = times(back, [p.rate + p.w_ie[0], *p.w_ie[1:]]), times(back, p.gravity)
    columns = []
    for name in TABLE:
        a, w = instrument(name, "a", f_b), instrument(name, "g", w_ib)
        if name[:2] == "mu":
            a, w = (cross(x, UNIT[int(name[2]) - 1]) for x in (f_b, w_ib))
        elif name in ("tau1", "tau2", "kappa"):
            turned = {"tau1": UNIT[1], "tau2": UNIT[2], "kappa": [theta, 0, 0]}[name]
            a, w = (times(back, cross(x, turned)) for x in (p.gravity, p.w_ie))
            if name == "kappa":
                w = [x + y for x, y in zip(w, times(back, [p.rate, 0, 0]), strict=True)]
        columns.append(a + w)
    return [], [], [[]] * 6, transpose(columns)


def modulus(p, stage):
    if stage == "any_motion":  # the whole sphere, by stereographic projection
        u, v = (Series([p.draw() for _ in range(TERMS)]) for _ in range(2))
        scale = (u * u + v * v + 1).inverse()
        f = [2 * u * scale, 2 * v * scale, (1 - u * u - v * v) * scale]
    else:
        c, s = p.phase(p.omega if stage == "motor" else Series([p.draw() for _ in range(TERMS)]))
        f = [c, s, series(0)] if stage == "one_axis" else [c, s * (c * c - s * s), s * (2 * s * c)]
    f = [x * p.g for x in f]
    row = [sum(x * y for x, y in zip(f, instrument(name, "a", f), strict=True)) * (1 / p.g) for name in NINE]
    return [], [], [[]], [row]


# -------------------------------------------------------------------------------------- runs and experiments


def grid(stage, **values):
    """Label → (stage, exact values), labels as for a `grid`; a value that is its own name is left out."""
    runs = {"": {}}
    for name, texts in values.items():
        runs = {f"{label}, {name} = {text}" if text != name else label: fix | {name: text}
                for label, fix in runs.items() for text in texts}  # fmt: skip
    return {f"{stage} ({label[2:]})" if label else stage: (stage, fix) for label, fix in runs.items()}


EDGES = {"xz": "x", "xy": "y", "yz": "z"}
ENDS = [f"{axis}_{end}" for axis in "xyz" for end in ("east", "west")]
BOTH, QUARTERS = ["omega", "-omega"], ["0", "pi/2", "pi", "3*pi/2"]
FACES = [f"{axis}_{end}" for axis in "xyz" for end in ("up", "down")]
EXPERIMENTS = {  # model: constants, function, label → (stage, fix)
    "paper, axis level": (INS, paper_level, {
        k: v for stage in ("stage_1", "stage_2", "stage_3") for k, v in grid(stage, omega=BOTH).items()}),
    "six_position": (SIX, six, {f: (f"levelled {f}", {}) for f in FACES}
        | {f"rough_{f}": (f"rough {f}", {}) for f in FACES}
        | {f"edge_{pair}": (f"rough {axis}_edge", {}) for pair, axis in EDGES.items()}),
    "twenty_four_positions": (INS, cube, grid("upright", heading=QUARTERS, roll=QUARTERS, pitch=["0"])
        | grid("on_end", heading=QUARTERS, pitch=["pi/2", "-pi/2"], roll=["0"])),
    "two_axis_table": (INS, two_axis, grid("inner_turns", outer=QUARTERS, omega=BOTH)
        | grid("outer_turns", inner=QUARTERS[:2], omega=BOTH)),
    "table_plan": (INS, lambda p, stage: on_table(p, p.angle("outer"), UP[stage[0]]), {
        k: v for axis in "xyz"
        for k, v in grid(f"{axis}_turns", outer=["0", "pi/2", "pi", "-pi/2"], omega=BOTH).items()}),
    "table_errors": (TABLE, table_errors, {end: (end, {}) for end in ENDS}),
    "modulus": (NINE, modulus, {s: (s, {}) for s in ("motor", "by_hand", "any_motion", "one_axis")}),
}  # fmt: skip
