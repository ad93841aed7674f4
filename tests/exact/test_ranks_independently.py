"""The rank of L for every bundled model, by a route that shares nothing with obscli.exact.

Power series in 60-digit floating point, written here: coefficients at a random point, L_{k+1} = L_k' + L_k A,
rank by elimination with complete pivoting. And stage 1 of the INS calibration in hand-coded numpy.
"""

import importlib.util
import random
from pathlib import Path

import mpmath
import numpy as np
import pytest

from obscli.exact.analysis import Options, analyze
from obscli.model.expression import Derivative, Number, Pi, Power, Product, Sum, Symbol
from obscli.model.reader import load


ROOT = Path(__file__).parents[2]
FILES = sorted((ROOT / "models").glob("**/*.yaml"))
SYSTEMS = [
    pytest.param(s, id=f"{f.parent.name}-{f.stem}-{s.stage or 'base'}")
    for f in FILES
    for s in load(f).systems
]
_spec = importlib.util.spec_from_file_location("ins_stage1", ROOT / "tests/independent/ins_stage1_numpy.py")
ins = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(ins)


class Taylor:
    """Truncated power series as lists of mpf, and expressions at one point as such series."""

    def __init__(self, system, length, source, values):
        self.length, self.values, self.memo = length, dict(values), {}
        self.series = {system.time: self.constant(self.random(source, 0.2, 1.4))}
        if length > 1:
            self.series[system.time][1] = mpmath.mpf(1)
        for p in system.parameters:
            self.series[p.name] = self.constant(self.values.get(p.name, self.random(source, 0.3, 1.7)))
        ruled = {f.name: f.derivative for f in system.functions if f.derivative is not None}
        for f in system.functions:
            size = 1 if f.name in ruled else length
            coefficients = [self.random(source, -1, 1) for _ in range(size)]
            self.series[f.name] = coefficients + [mpmath.mpf(0)] * (length - size)
        if system.invariants:  # the bundled ones say |q| = 1 at one instant, or |f| = g at all
            self.keep_invariants([f.name for f in system.functions])
        for k in range(1, length):  # x' = F term by term
            self.memo = {}
            rates = {name: self.value(rule)[k - 1] / k for name, rule in ruled.items()}
            for name, rate in rates.items():
                self.series[name][k] = rate
        self.memo = {}

    @staticmethod
    def random(source, low, high):
        return mpmath.mpf(source.randrange(10**9)) / 10**9 * (high - low) + low

    def keep_invariants(self, names):
        if "q1" in names:
            self.normalise([f"q{k}" for k in range(1, 5)])
        elif "f1" in names:
            self.project([f"f{k}" for k in range(1, 4)], self.series["g"])
        else:
            raise NotImplementedError(names)

    def project(self, names, radius):
        """f on the sphere: the plane of its first two series put there stereographically."""
        u, v = (self.series[name] for name in names[:2])
        square = [a + b for a, b in zip(self.times(u, u), self.times(v, v), strict=True)]
        one = self.constant(1)
        scale = self.times(radius, self.power([a + b for a, b in zip(square, one, strict=True)], -1))
        top = [a - b for a, b in zip(one, square, strict=True)]
        for name, x in zip(names, ([2 * a for a in u], [2 * a for a in v], top), strict=True):
            self.series[name] = self.times(x, scale)

    def normalise(self, names):
        norm = mpmath.sqrt(sum(self.series[q][0] ** 2 for q in names))
        for q in names:
            self.series[q][0] /= norm

    def constant(self, value):
        return [mpmath.mpf(value)] + [mpmath.mpf(0)] * (self.length - 1)

    def times(self, a, b):
        return [mpmath.fsum(a[i] * b[k - i] for i in range(k + 1)) for k in range(self.length)]

    def derivative(self, a):
        return [*((k + 1) * a[k + 1] for k in range(self.length - 1)), mpmath.mpf(0)]

    def composed(self, u, rate_of, first):
        """g = f(u) from g' = r u' where r is computed term by term from g."""
        g = self.constant(first)
        du = self.derivative(u)
        for k in range(1, self.length):
            r = rate_of(g)
            g[k] = mpmath.fsum(r[i] * du[k - 1 - i] for i in range(k)) / k
        return g

    def power(self, u, p):
        """v = u^p from u v' = p u' v."""
        v = self.constant(mpmath.power(u[0], p))
        for k in range(1, self.length):
            v[k] = mpmath.fsum((p * i - (k - i)) * u[i] * v[k - i] for i in range(1, k + 1)) / (k * u[0])
        return v

    def sine_cosine(self, u):
        s, c = self.constant(mpmath.sin(u[0])), self.constant(mpmath.cos(u[0]))
        for k in range(1, self.length):
            s[k] = mpmath.fsum(i * u[i] * c[k - i] for i in range(1, k + 1)) / k
            c[k] = -mpmath.fsum(i * u[i] * s[k - i] for i in range(1, k + 1)) / k
        return s, c

    def value(self, node):
        if id(node) not in self.memo:
            self.memo[id(node)] = (node, self._value(node))
        return self.memo[id(node)][1]

    def _value(self, node):
        match node:
            case Number(value):
                return self.constant(mpmath.mpf(value.numerator) / value.denominator)
            case Pi():
                return self.constant(mpmath.pi)
            case Symbol(name):
                return self.series[name]
            case Derivative(name, order):
                series = self.series[name]
                for _ in range(order):
                    series = self.derivative(series)
                return series
            case Sum(terms):
                return [mpmath.fsum(column) for column in zip(*map(self.value, terms), strict=True)]
            case Product(factors):
                result = self.value(factors[0])
                for factor in factors[1:]:
                    result = self.times(result, self.value(factor))
                return result
            case Power(base, exponent):
                return self._power(self.value(base), exponent)
        return self._apply(node)

    def _power(self, u, exponent):
        if exponent.denominator == 1 and exponent > 0:
            result = u
            for _ in range(int(exponent) - 1):
                result = self.times(result, u)
            return result
        return self.power(u, mpmath.mpf(exponent.numerator) / exponent.denominator)

    def _apply(self, node):
        u = self.value(node.argument)
        match node.function:
            case "sin":
                return self.sine_cosine(u)[0]
            case "cos":
                return self.sine_cosine(u)[1]
            case "exp":
                return self.composed(u, lambda g: g, mpmath.exp(u[0]))
        raise NotImplementedError(node)


def _rank(rows):
    """Rank by elimination with complete pivoting; what is below 1e-25 of the largest entry is zero."""
    rows = [list(row) for row in rows if any(row)]
    scale = max((abs(x) for row in rows for x in row), default=0)
    rank = 0
    while rows:
        r, c = max(
            ((i, j) for i, row in enumerate(rows) for j in range(len(row))),
            key=lambda ij: abs(rows[ij[0]][ij[1]]),
        )
        pivot = rows[r]
        if abs(pivot[c]) < scale * mpmath.mpf("1e-25"):
            break
        rank += 1
        rows = [
            [
                x - row[c] / pivot[c] * y if j != c else mpmath.mpf(0)
                for j, (x, y) in enumerate(zip(row, pivot, strict=True))
            ]
            for i, row in enumerate(rows)
            if i != r
        ]
    return rank


def _blocks(system, orders, seed, values):
    """L_0 ... L_orders at a random point (with the given values of parameters)."""
    with mpmath.workdps(60):
        point = Taylor(system, orders + 3, random.Random(seed), values)
        A = [{} for _ in range(system.n)]
        for (i, j), e in system.A.entries.items():
            A[i][j] = point.value(e)
        level = [{} for _ in range(system.m)]
        for (i, j), e in system.H.entries.items():
            level[i][j] = point.value(e)
        for _ in range(orders + 1):
            yield [[row[j][0] if j in row else mpmath.mpf(0) for j in range(system.n)] for row in level]
            level = [_next(point, row, A) for row in level]


def _next(point, row, A):
    result = {j: point.derivative(series) for j, series in row.items()}
    for i, series in row.items():
        for j, a in A[i].items():
            product = point.times(series, a)
            result[j] = [x + y for x, y in zip(result[j], product, strict=True)] if j in result else product
    return result


def _ranks(system, orders, seed=1, values=()):
    ranks, rows = [], []
    with mpmath.workdps(60):
        for block in _blocks(system, orders, seed, dict(values)):
            rows += block
            ranks.append(_rank(rows))
    return ranks


@pytest.mark.parametrize("system", SYSTEMS)
def test_rank_and_saturation_agree_with_floating_point(system):
    found = analyze(system, Options(critical=False, certificate=False))
    ranks = _ranks(system, min(found.order + 1, max(system.n - 1, found.order)))
    assert max(ranks) == found.rank
    assert ranks.index(found.rank) == found.order
    assert found.frozen_rank == _frozen(system)


def _frozen(system):
    """Rank of (H; HA; HA^2; ...) with A, H frozen at a random instant."""
    with mpmath.workdps(60):
        point = Taylor(system, 3, random.Random(5), {})
        A = [[mpmath.mpf(0)] * system.n for _ in range(system.n)]
        for (i, j), e in system.A.entries.items():
            A[i][j] = point.value(e)[0]
        block = [[mpmath.mpf(0)] * system.n for _ in range(system.m)]
        for (i, j), e in system.H.entries.items():
            block[i][j] = point.value(e)[0]
        rows, ranks = list(block), [_rank(block)]
        while len(ranks) < 2 or ranks[-1] != ranks[-2]:
            block = [[mpmath.fdot(row, column) for column in zip(*A, strict=True)] for row in block]
            rows += block
            ranks.append(_rank(rows))
        return ranks[-1]


@pytest.mark.parametrize("system", [s for s in SYSTEMS if s.values[0].parameters])
def test_the_rank_at_the_files_values_agrees_with_floating_point(system):
    found = analyze(system, Options(critical=False, certificate=False))
    values = {}
    with mpmath.workdps(60):
        for p in system.parameters:
            values[p.name] = Taylor(system, 1, random.Random(0), {}).value(p.nominal)[0]
    scaled = _nominal_rank(system, found.order + 1, values)
    assert found.at_values.rank == scaled


def _nominal_rank(system, orders, values):
    """Rank with rows scaled to 1, in 200 digits, since R^-5 is 1e-34 and omega_ie^5 is 1e-21."""
    rows = []
    with mpmath.workdps(200):
        for block in _blocks(system, orders, 3, values):
            rows += [[x / max(map(abs, row)) for x in row] for row in block if any(row)]
        return _rank_of_scaled(rows)


def _rank_of_scaled(rows):
    rank = 0
    while rows:
        rows = [
            [x / max(map(abs, row)) for x in row] for row in rows if max(map(abs, row)) > mpmath.mpf("1e-50")
        ]
        if not rows:
            break
        r, c = max(
            ((i, j) for i, row in enumerate(rows) for j in range(len(row))),
            key=lambda ij: abs(rows[ij[0]][ij[1]]),
        )
        pivot, rank = rows[r], rank + 1
        rows = [
            [
                x - row[c] / pivot[c] * y if j != c else mpmath.mpf(0)
                for j, (x, y) in enumerate(zip(row, pivot, strict=True))
            ]
            for i, row in enumerate(rows)
            if i != r
        ]
    return rank


# -- INS calibration, stage 1, in hand-coded numpy


def _numbers(covectors, system, t, params):
    """Covectors as rows of floats, by a plain evaluation of their expressions."""
    point = Taylor(system, 1, random.Random(0), params)
    point.series[system.time] = point.constant(t)
    rows = np.zeros((len(covectors), system.n))
    for k, covector in enumerate(covectors):
        for state, entry in covector.items():
            rows[k, system.state_names.index(state)] = float(point.value(entry)[0])
    return rows


PARAMS = {"omega": 0.9, "omega_ie": 0.35, "phi": 0.47, "g": 9.81}
STAGE_1 = [
    pytest.param(load(ROOT / "models/ins_calibration" / f).systems[0], id=f)
    for f in ("horizontal.yaml", "stage_1_sparse.yaml")
]


@pytest.mark.parametrize("system", STAGE_1)
def test_stage_1_has_the_matrices_coded_by_hand(system):
    for t in (0.0, 0.7, 2.9):
        point = Taylor(system, 1, random.Random(0), PARAMS)
        point.series[system.time] = point.constant(t)
        for matrix, expected in ((system.A, ins.A(t, PARAMS)), (system.H, ins.H(t, PARAMS))):
            mine = np.zeros(expected.shape)
            for place, e in matrix.entries.items():
                mine[place] = float(point.value(e)[0])
            assert np.abs(mine - expected).max() < 1e-12


@pytest.mark.parametrize("system", STAGE_1)
def test_what_stage_1_calls_unobservable_is_never_seen_along_hand_coded_solutions(system):
    found = analyze(system, Options(critical=False))
    t0, step, steps = 0.3, 0.002, 2000
    x = _numbers(found.unobservable, system, t0, PARAMS).T
    assert np.linalg.matrix_rank(x) == 8
    # a direction that is seen, so that the test can fail
    seen = _numbers([c.coefficients for c in found.combinations], system, t0, PARAMS)[3:4].T
    x = np.hstack([x, seen])
    worst = np.abs(ins.H(t0, PARAMS) @ x).max(axis=0)
    for k in range(steps):
        t = t0 + k * step
        a, b, c = ins.A(t, PARAMS), ins.A(t + step / 2, PARAMS), ins.A(t + step, PARAMS)
        k1 = a @ x
        k2 = b @ (x + step / 2 * k1)
        k3 = b @ (x + step / 2 * k2)
        k4 = c @ (x + step * k3)
        x = x + step / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        worst = np.maximum(worst, np.abs(ins.H(t + step, PARAMS) @ x).max(axis=0))
    assert worst[:8].max() < 1e-9
    assert worst[8] > 1e-2
    # N(t) spans at the end what the solutions have become
    final = _numbers(found.unobservable, system, t0 + steps * step, PARAMS).T
    assert np.linalg.matrix_rank(np.hstack([final, x[:, :8]]), tol=1e-7) == 8


@pytest.mark.parametrize("system", STAGE_1)
def test_stage_1_gives_sixteen_combinations_that_annihilate_the_directions(system):
    found = analyze(system, Options(critical=False))
    assert (found.rank, found.order, found.frozen_rank) == (16, 5, 6)
    for t in (0.0, 1.3):
        S = _numbers([c.coefficients for c in found.combinations], system, t, PARAMS)
        N = _numbers(found.unobservable, system, t, PARAMS).T
        assert np.linalg.matrix_rank(S) == 16
        assert np.linalg.matrix_rank(N) == 8
        assert np.abs(S @ N).max() < 1e-12


@pytest.mark.parametrize("system", STAGE_1)
def test_a_constant_combination_of_stage_1_keeps_its_value(system):
    """d(xi x)/dt = (xi' + xi A) x = 0 for all x, by a central difference and the hand-coded A."""
    found = analyze(system, Options(critical=False))
    t, h = 0.8, 1e-5
    covectors = [c.coefficients for c in found.combinations]
    middle = _numbers(covectors, system, t, PARAMS)
    rate = (_numbers(covectors, system, t + h, PARAMS) - _numbers(covectors, system, t - h, PARAMS)) / (2 * h)
    still = np.abs(rate + middle @ ins.A(t, PARAMS)).max(axis=1) < 1e-7
    assert list(still) == [c.constant for c in found.combinations]
