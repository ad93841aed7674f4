"""The rank of a generated model by a route that shares nothing with obscli, to check `generators.py`.

The text is read by PyYAML and evaluated by Python with power series in time modulo a prime p, at a random
time and random parameters: y(t0 + h) = H Φ x0, Φ' = A Φ, and the coefficient of h^k is L_k / k!. The rank
modulo p at one point is a lower bound of the generic rank and, but for a chance of about n / p, equal to it;
no new rows at one order mean no new rows at any later one (generically). Only for text of our own
generators: entries go through `eval`.

    python benchmarks/witness.py        checks every size that growth.py uses
"""

from __future__ import annotations

import argparse
import random
from typing import TYPE_CHECKING

import generators
import numpy as np
import yaml


if TYPE_CHECKING:
    from collections.abc import Callable


P = 1_048_573  # prime; n p^2 < 2^53, so that float64 matrix products are exact


class Series:
    """A power series in h modulo p, cut after ``order``."""

    def __init__(self, *c: int):
        self.c = [int(v) % P for v in c] + [0] * (Series.order + 1 - len(c))

    def __add__(self, other):
        if isinstance(other, Form | np.ndarray):
            return NotImplemented
        return Series(*(a + b for a, b in zip(self.c, _series(other).c, strict=True)))

    def __mul__(self, other):
        if isinstance(other, Form | np.ndarray):
            return NotImplemented
        b = _series(other).c
        return Series(*(sum(self.c[i] * b[k - i] for i in range(k + 1)) for k in range(Series.order + 1)))

    def __neg__(self):
        return self * -1

    def __sub__(self, other):
        return self + other * -1

    def __rsub__(self, other):
        return -self + other

    def __truediv__(self, other):
        inverse = pow(_series(other).c[0], -1, P)
        assert not any(_series(other).c[1:]), "division by constants only"
        return self * inverse

    __radd__, __rmul__ = __add__, __mul__


class Form:
    """A linear form in the states: state -> Series."""

    def __init__(self, terms: dict[str, Series]):
        self.terms = terms

    def __add__(self, other):
        if not isinstance(other, Form):
            assert not any(_series(other).c), "a form plus a constant is not linear"
            return self
        both = self.terms.keys() | other.terms.keys()
        zero = Series(0)
        return Form({k: self.terms.get(k, zero) + other.terms.get(k, zero) for k in both})

    def __mul__(self, other):
        return Form({k: v * other for k, v in self.terms.items()})

    def __neg__(self):
        return self * -1

    def __sub__(self, other):
        return self + other * -1

    def __rsub__(self, other):
        return -self + other

    def __truediv__(self, other):
        return Form({k: v / other for k, v in self.terms.items()})

    __radd__, __rmul__ = __add__, __mul__


def _series(value) -> Series:
    return value if isinstance(value, Series) else Series(value)


class Trigonometry:
    """Sin and cos of series, one random half-angle for each argument: c0^2 + s0^2 = 1 modulo p."""

    def __init__(self, draw: random.Random):
        self.draw, self.known = draw, {}

    def pair(self, argument) -> tuple[Series, Series]:
        a = tuple(_series(argument).c)
        if a not in self.known:
            half = self.draw.randrange(2, P)
            scale = pow(1 + half * half, -1, P)
            c, s = [(1 - half * half) * scale % P], [2 * half * scale % P]
            for k in range(1, Series.order + 1):
                inverse = pow(k, -1, P)
                c.append(-inverse * sum(i * a[i] * s[k - i] for i in range(1, k + 1)) % P)
                s.append(inverse * sum(i * a[i] * c[k - i] for i in range(1, k + 1)) % P)
            self.known[a] = Series(*c), Series(*s)
        return self.known[a]


def _vectors(value):
    return np.array(value, dtype=object) if isinstance(value, list) else value


def _cross(a, b):
    cyclic = ((1, 2), (2, 0), (0, 1))
    return np.array([a[i] * b[j] - a[j] * b[i] for i, j in cyclic], dtype=object)


def _text(value) -> str:
    return str(value) if not isinstance(value, list) else "[" + ", ".join(map(_text, value)) + "]"


def _evaluator(draw: random.Random, data: dict) -> tuple[Callable, dict]:
    trigonometry = Trigonometry(draw)
    scope = {name: Series(draw.randrange(2, P)) for name in data.get("parameters", {})}
    scope |= {"t": Series(draw.randrange(2, P), 1), "array": lambda v: np.array(v, dtype=object)}
    scope |= {"cos": lambda a: trigonometry.pair(a)[0], "sin": lambda a: trigonometry.pair(a)[1]}
    scope["cross"] = lambda a, b: _cross(np.array(a, dtype=object), b)

    def evaluate(text):
        source = _text(text).replace("@ [", "@ Array[").replace("+ [", "+ Array[")
        return _vectors(eval(source, {"Array": _Arrays(), **scope}))

    return evaluate, scope


class _Arrays:
    """``Array[0, 0, g]`` is the vector: Python's lists do not add."""

    def __getitem__(self, parts):
        return np.array(parts, dtype=object)


def _names(data: dict, scope: dict) -> list[str]:
    """The states in order; vectors and matrices of states enter the scope."""
    if isinstance(data["states"], list):
        return data["states"]
    names = []
    for name, spec in data["states"].items():
        shape = spec if isinstance(spec, list) else [spec] if isinstance(spec, int) else spec["shape"]
        lower = isinstance(spec, dict)
        values = np.zeros(shape, dtype=object)
        for index in np.ndindex(*shape):
            if not lower or index[1] <= index[0]:
                names.append(name + "".join(str(i + 1) for i in index))
                values[index] = Form({names[-1]: Series(1)})
        scope[name] = values
    return names


def coefficients(text: str, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """A and H as arrays (order + 1, rows, n) of their Taylor coefficients modulo p."""
    data = yaml.safe_load(text)
    evaluate, scope = _evaluator(random.Random(seed), data)
    names = _names(data, scope)
    column = {name: j for j, name in enumerate(names)}
    for name, value in data.get("let", {}).items():
        scope[name] = evaluate(value)
    if "A" in data:
        A = {} if isinstance(data["A"], list) else data["A"]
        rows = [{j: evaluate(v) for j, v in A.get(name, {}).items()} for name in names]
        outputs = [{j: evaluate(v) for j, v in row.items()} for row in data["H"].values()]
    else:
        found = {name: evaluate(v) for name, v in data["dynamics"].items()}
        parts = {f"{name}{i + 1}": form.terms for name, v in found.items() for i, form in enumerate(v)}
        rows = [parts.get(name, {}) for name in names]
        outputs = [form.terms for v in data["measurements"].values() for form in evaluate(v)]
    return _stack(rows, column), _stack(outputs, column)


def _stack(rows: list[dict], column: dict[str, int]) -> np.ndarray:
    result = np.zeros((Series.order + 1, len(rows), len(column)))
    for i, row in enumerate(rows):
        for name, value in row.items():
            result[:, i, column[name]] = _series(value).c
    return result


def _independent(rows: np.ndarray) -> int:
    rows = rows.astype(np.int64) % P
    rank = 0
    for j in range(rows.shape[1]):
        pivots = np.nonzero(rows[rank:, j])[0]
        if len(pivots):
            i = rank + pivots[0]
            rows[[rank, i]] = rows[[i, rank]]
            rows[rank] = rows[rank] * pow(int(rows[rank, j]), -1, P) % P
            below = rank + 1 + np.nonzero(rows[rank + 1 :, j])[0]
            rows[below] = (rows[below] - rows[below, j][:, None] * rows[rank]) % P
            rank += 1
    return rank


def ranks(text: str, order: int, seed: int = 1) -> list[int]:
    """The ranks modulo p of (L_0; ...; L_k) for k = 0 ... order."""
    Series.order = order
    A, H = coefficients(text, seed)
    present = [k for k in range(order + 1) if A[k].any()]
    Phi = [np.eye(A.shape[1])]
    for k in range(1, order + 1):
        total = sum((A[i] @ Phi[k - 1 - i] % P for i in present if i < k), start=np.zeros_like(Phi[0]))
        Phi.append(total * pow(k, -1, P) % P)
    Y = [sum(H[i] @ Phi[k - i] % P for i in range(k + 1)) % P for k in range(order + 1)]
    found = []
    for k in range(order + 1):
        found.append(_independent(np.vstack(Y[: k + 1])))
        if k and found[-1] == found[-2]:
            break
    return found


def main() -> None:
    argparse.ArgumentParser(description="Check the ranks that the generators promise.").parse_args()
    cases = [
        (f"IMUs {n}", generators.imu_array(n), generators.imu_array_rank(n), 8) for n in (1, 2, 4, 8, 16)
    ]
    cases += [(f"chain {n}", generators.integrator_chain(n), n, n) for n in (1, 2, 25, 50, 100, 200)]
    for n in (4, 25, 50, 100, 200):
        cases += [
            (f"sparse {n}", generators.random_sparse(n, 3 * n // 4, s), 3 * n // 4, 12) for s in (1, 2, 3)
        ]
    for name, text, expected, order in cases:
        found = ranks(text, order)
        steady = len(found) > 1 and found[-1] == found[-2]
        verdict = "ok" if steady and found[-1] == expected else "WRONG"
        steps = found if len(found) < 10 else [*found[:4], "...", *found[-3:]]
        print(f"{name:12} {verdict:6} expected {expected:4}, found for L_0 ... L_{len(found) - 1}:", *steps)


if __name__ == "__main__":
    main()
