"""Experiments of known answer, built in hidden coordinates, and the same answer by a route of its own.

In hidden coordinates the shared constants are z, and run i has fresh states ξ, driven by z and seen in y:

    ξ' = F ξ + B(t) z,   z' = 0,   y = K ξ + D(t) z

made of blocks of which it is known what they tell of z without ξ (``_kinds``). So run i determines the row
space of U_i, known beforehand, although neither its rows of H nor those of L without the columns of ξ do:
stacking these would claim more. Then everything is hidden by unimodular changes, another one for the fresh
states of every run:

    c = V z,   x = W_i ξ + N_i z

``determined`` finds the rows again from the matrices of a run alone: Taylor series of L at a rational point,
in fractions; ``reduced`` is the only elimination used.
"""

import random
from dataclasses import dataclass
from fractions import Fraction


#: Functions of time: their text, and their Taylor coefficients about t0 = 3/7 with w = 5/4 on a rational point
#: of the circle.
TERMS = 10
T0, W, COS, SIN = Fraction(3, 7), Fraction(5, 4), Fraction(3, 5), Fraction(4, 5)


def _series(name):
    if name == "1":
        return [Fraction(int(k == 0)) for k in range(TERMS)]
    if name == "t":
        return [T0, Fraction(1), *[Fraction(0)] * (TERMS - 2)]
    found, factor = [], Fraction(1)
    for k in range(TERMS):
        found.append(factor * (COS, -SIN, -COS, SIN)[k % 4])
        factor *= W / (k + 1)
    return found


#: Text of every function; w = 5/4 in the file.
FUNCTIONS = {"1": "1", "t": "t", "cos": "cos(w*t)"}


# -- matrices as {function: rows}, and rows of fractions


def zeros(m, n):
    return [[0] * n for _ in range(m)]


def product(A, B):
    return [
        [sum(a * b for a, b in zip(row, column, strict=True)) for column in zip(*B, strict=True)] for row in A
    ]


def reduced(rows):
    """The reduced echelon form of rows, in fractions."""
    rows, found = [list(map(Fraction, row)) for row in rows], []
    for column in range(len(rows[0]) if rows else 0):
        pivot = next((row for row in rows if row[column]), None)
        if pivot is None:
            continue
        rows.remove(pivot)
        pivot = [x / pivot[column] for x in pivot]
        rows, found = (
            [[x - row[column] * y for x, y in zip(row, pivot, strict=True)] for row in part]
            for part in (rows, found)
        )
        found.append(pivot)
    return found


def rank(rows):
    return len(reduced(rows))


def kernel(rows, n):
    """A basis of the kernel of rows in reduced form: one vector for each column without a pivot."""
    rows = reduced(rows)
    pivots = [next(j for j, x in enumerate(row) if x) for row in rows]
    found = []
    for free in sorted(set(range(n)) - set(pivots)):
        vector = [Fraction(int(j == free)) for j in range(n)]
        for row, pivot in zip(rows, pivots, strict=True):
            vector[pivot] = -row[free]
        found.append(vector)
    return found


def unimodular(source, n, steps=4):
    """A product of integer shears and its inverse."""
    V, inverse = ([[int(i == j) for j in range(n)] for i in range(n)] for _ in range(2))
    for _ in range(steps if n > 1 else 0):
        i, j = source.sample(range(n), 2)
        f = source.choice([-1, 1, 2])
        V[i] = [x + f * y for x, y in zip(V[i], V[j], strict=True)]
        for row in inverse:
            row[j] -= f * row[i]
    return V, inverse


# -- runs in hidden coordinates


def _row(source, p):
    row = [source.choice([-1, 0, 0, 1, 2]) for _ in range(p)]
    row[source.randrange(p)] = 1
    return row


def _kinds(u, v):
    """Blocks by name: how many fresh states, {F}, {B}, {K}, {D} and the rows U that are determined."""
    p, twice = len(u), [2 * a for a in u]
    return {
        # ξ' = u z, y = ξ + v z: only u z, though y shows v z and ξ together
        "integral": (1, {}, {"1": [u]}, {"1": [[1]]}, {"1": [v]}, [u]),
        # ξ' = λ ξ + 2 u z, y = ξ + v z: y' − λ y = (2 u − λ v) z
        "decay": (1, {"1": [[-1]]}, {"1": [twice]}, {"1": [[1]]}, {"1": [v]},
                  [[a + b for a, b in zip(twice, v, strict=True)]]),
        # y' = (cos(wt) u + v) z: both come apart in time
        "driven": (1, {}, {"cos": [u]}, {"1": [[1]]}, {"t": [v]}, [u, v]),
        # ξ1' = ξ2, ξ2' = u z, y = ξ1 + v z
        "chain": (2, {"1": [[0, 1], [0, 0]]}, {"1": [[0] * p, u]}, {"1": [[1, 0]]}, {"1": [v]}, [u]),
        # a fresh state that nobody sees tells nothing
        "unseen": (1, {"1": [[-1]]}, {"1": [u]}, {"1": [[0]]}, {}, []),
        # no fresh state: u z and v z come apart in time
        "still": (0, {}, {}, {"1": [[]]}, {"1": [u], "t": [v]}, [u, v]),
        "plain": (0, {}, {}, {"1": [[]]}, {"1": [u]}, [u]),
    }  # fmt: skip


def _blocks(source, pool, fresh):
    """Yield the blocks of one run, with rows from a pool, so that runs overlap."""
    left = fresh
    while left:
        kinds = _kinds(*source.sample(pool, 2))
        name = source.choice([k for k, block in kinds.items() if 1 <= block[0] <= left])
        left -= kinds[name][0]
        yield kinds[name]
    if source.random() < 0.4:
        yield _kinds(*source.sample(pool, 2))[source.choice(["still", "plain"])]


@dataclass(frozen=True)
class Run:
    """One run, hidden: A and H over (x, c) as {function: rows}, and what is known: the rows U V⁻¹ over c."""

    name: str
    A: dict
    H: dict
    rows: list


@dataclass(frozen=True)
class Known:
    """An experiment: ``p`` constants c1 …, ``q`` fresh states x1 …, and its runs."""

    p: int
    q: int
    runs: tuple

    @property
    def names(self):
        return [f"c{j + 1}" for j in range(self.p)]

    def together(self, runs=None):
        """The rows over c that some runs determine, in reduced form: known, not computed from the runs."""
        return reduced([row for run in runs or self.runs for row in run.rows])

    def determined(self):
        rows = self.together()
        units = [[Fraction(int(j == k)) for j in range(self.p)] for k in range(self.p)]
        return [
            name for name, unit in zip(self.names, units, strict=True) if rank([*rows, unit]) == len(rows)
        ]

    def text(self, runs=None, more="", entry=lambda run: run.name, units=None):
        """The model, every run a stage of its own.

        ``entry``: what stands under `runs` for each; ``units``: exponents e of the states, x = 2^e x_new.
        """
        runs = self.runs if runs is None else runs
        states = ", ".join([*(f"x{i + 1}" for i in range(self.q)), *self.names])
        e = units or [0] * (self.p + self.q)
        stages = "".join(
            f"  {run.name}:\n    A: {_text(run.A, e, e)}\n    H: {_text(run.H, [0] * 99, e)}\n"
            for run in self.runs
        )
        fresh = ", ".join(f"x{i + 1}" for i in range(self.q))
        return (
            f"parameters: {{w: {W}}}\nstates: [{states}]\ninterval: {{start: 0, stop: 3, samples: 12}}\n"
            f"stages:\n{stages}"
            f"experiment:\n  fresh: [{fresh}]\n  runs: [{', '.join(entry(run) for run in runs)}]\n{more}"
        )


def _text(matrix, left, right):
    """A matrix of sums of functions as the model has it, the exponents of rows and columns put in."""
    height = max((len(rows) for rows in matrix.values()), default=0)
    lines = []
    for i in range(height):
        entries = []
        for j, e in enumerate(right):
            unit = f"2^({e - left[i]})*" if e != left[i] else ""
            terms = [f"{rows[i][j]}*{unit}{FUNCTIONS[f]}" for f, rows in matrix.items() if rows[i][j]]
            entries.append(" + ".join(terms).replace("+ -", "- ") or "0")
        lines.append(f"[{', '.join(entries)}]")
    return f"[{', '.join(lines)}]"


def _stacked(blocks, p, q):
    """The blocks of one run below each other: F, B, K, D as {function: rows}."""
    m = len(blocks)
    F, B, K, D = ({f: zeros(*shape) for f in FUNCTIONS} for shape in ((q, q), (q, p), (m, q), (m, p)))
    start = 0
    for k, (size, f, b, kk, d, _) in enumerate(blocks):
        for whole, part, first, left in (
            (F, f, start, start),
            (B, b, start, 0),
            (K, kk, k, start),
            (D, d, k, 0),
        ):
            for name, rows in part.items():
                for i, row in enumerate(rows):
                    whole[name][first + i][left : left + len(row)] = row
        start += size
    return F, B, K, D


def _hidden(name, blocks, p, q, V_inverse, source):
    """A run with its fresh states and constants in other coordinates: x = W ξ + N z, c = V z."""
    F, B, K, D = _stacked(blocks, p, q)
    W, W_inverse = unimodular(source, q)
    N = [[source.choice([0, 0, 1, -1]) for _ in range(p)] for _ in range(q)]
    A, H = {}, {}
    for f in FUNCTIONS:
        # ξ = W⁻¹ (x − N z): x' = W F W⁻¹ x + (W B − W F W⁻¹ N) z
        A_x = product(product(W, F[f]), W_inverse) if q else []
        K_x = product(K[f], W_inverse) if q else [[] for _ in K[f]]
        shift, seen = (product(M, N) if q else zeros(len(M), p) for M in (A_x, K_x))
        W_B = product(W, B[f]) if q else []
        A_z = [[a - b for a, b in zip(r, s, strict=True)] for r, s in zip(W_B, shift, strict=True)]
        H_z = [[a - b for a, b in zip(r, s, strict=True)] for r, s in zip(D[f], seen, strict=True)]
        A[f] = [[*a, *b] for a, b in zip(A_x, product(A_z, V_inverse) if q else [], strict=True)]
        A[f] += zeros(p, p + q)
        H[f] = [[*a, *b] for a, b in zip(K_x, product(H_z, V_inverse), strict=True)]
    rows = product([row for block in blocks for row in block[5]], V_inverse)
    return Run(name, A, H, rows)


def build(seed):
    """An experiment of two to four runs over three to six constants and one to three fresh states."""
    source = random.Random(seed)
    p, q = source.randint(3, 6), source.randint(1, 3)
    _, V_inverse = unimodular(source, p)
    pool = [_row(source, p) for _ in range(p)]
    runs = []
    for k in range(source.randint(2, 4)):
        blocks = list(_blocks(source, pool, q))
        runs.append(_hidden(f"r{k + 1}", blocks, p, q, V_inverse, source))
    return Known(p, q, tuple(runs))


# -- the route of its own


def _times(a, b):
    return [sum(a[i] * b[k - i] for i in range(k + 1)) for k in range(TERMS)]


def _derivative(a):
    return [*((k + 1) * a[k + 1] for k in range(TERMS - 1)), Fraction(0)]


def _as_series(matrix):
    """A matrix of sums of functions as rows {column: Taylor coefficients}."""
    series = {f: _series(f) for f in matrix}
    height = max(len(rows) for rows in matrix.values())
    found = [{} for _ in range(height)]
    for f, rows in matrix.items():
        for i, row in enumerate(rows):
            for j, x in enumerate(row):
                if x:
                    old = found[i].get(j, [Fraction(0)] * TERMS)
                    found[i][j] = [a + x * b for a, b in zip(old, series[f], strict=True)]
    return found


def determined(run, p, q):
    """The rows over c that a run determines, from its matrices: those of L that are zero on x."""
    A, level, rows = _as_series(run.A), _as_series(run.H), []
    for _ in range(p + q):
        rows += [[row[j][0] if j in row else Fraction(0) for j in range(p + q)] for row in level]
        following = []
        for row in level:
            new = {j: _derivative(series) for j, series in row.items()}
            for i, series in row.items():
                for j, a in A[i].items():
                    old = new.get(j, [Fraction(0)] * TERMS)
                    new[j] = [x + y for x, y in zip(old, _times(series, a), strict=True)]
            following.append(new)
        level = following
    return [row[q:] for row in reduced(rows) if not any(row[:q])]
