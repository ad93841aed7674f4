"""Systems built from a known decomposition x = T(t) z, so that everything about them is known beforehand.

z = (chains, hidden). A chain of integrators z1' = z2, ... is seen through its head; a link c z_{k+1} with a
parameter c breaks at c = 0, and the states behind it are lost. Output injection K(t) H may be added to the
dynamics: it changes no observable subspace. The hidden states are driven by all, and drive nothing. T is a
product of shears I + f(t) E_ij, unimodular for all parameters, so rank, order, kernel and critical set stay.
"""

import math
import random
from dataclasses import dataclass


@dataclass(frozen=True)
class Known:
    text: str
    n: int
    rank: int
    order: int
    hidden: list  # directions as {state: text}
    critical: dict  # parameter that breaks a chain at zero -> rank there
    rates: frozenset  # parameters in T and K only: no value of them matters


def _times(f, g):
    return g if f == "1" else f if g == "1" else f"({f})*({g})"


def _accumulate(matrix, i, j, term):
    matrix[i, j] = f"{matrix[i, j]} + {term}" if (i, j) in matrix else term


def _shear(n, A, H, N, shear):
    """x -> (I + f E_ij) x with f' = rate:  A -> S' S^-1 + S A S^-1,  H -> H S^-1,  N -> S N."""
    i, j, f, rate = shear
    for k in range(n):
        if (j, k) in A:
            _accumulate(A, i, k, _times(f, A[j, k]))
    for matrix in (A, H):
        for r in range(n):
            if (r, i) in matrix:
                _accumulate(
                    matrix, r, j, f"-{_times(f'({f})', matrix[r, i])}" if f != "1" else f"-({matrix[r, i]})"
                )
    for column in N:
        if j in column:
            term = _times(f, column[j])
            column[i] = f"{column[i]} + {term}" if i in column else term
    if rate != "0":
        _accumulate(A, i, j, rate)


def _function(source, rates):
    """A function of time and its derivative, as texts."""
    kind = source.choice(["one", "t", "t^2", "sin", "cos", "exp", "parameter"])
    w = source.choice(sorted(rates))
    return {
        "one": ("2", "0"),
        "t": ("t", "1"),
        "t^2": ("(t^2 - 3*t)", "(2*t - 3)"),
        "sin": (f"sin({w}*t)", f"{w}*cos({w}*t)"),
        "cos": (f"cos({w}*t)", f"(-{w}*sin({w}*t))"),
        "exp": ("exp(-t)", "(-exp(-t))"),
        "parameter": (f"{w}", "0"),
    }[kind]


def _chains(source, lengths, breakable):
    """Chains of integrators seen through their heads, some links broken where a parameter is zero."""
    A, H, heads, critical, start = {}, {}, [], {}, 0
    for output, length in enumerate(lengths):
        heads.append(start)
        H[output, start] = "1"
        for link in range(1, length):
            A[start + link - 1, start + link] = "1"
            if breakable and source.random() < 0.6:
                name = f"c{len(critical) + 1}"
                A[start + link - 1, start + link] = name
                critical[name] = sum(lengths) - (length - link)
        start += length
    return A, H, heads, critical


def build(seed, *, breakable, shears=3):
    source = random.Random(seed)
    lengths = [source.randint(1, 3) for _ in range(source.randint(1, 2))]
    hidden = source.randint(1, 2) if source.random() < 0.8 else 0
    rates = frozenset({"w", "v"}) if source.random() < 0.3 else frozenset({"w"})
    rank, n = sum(lengths), sum(lengths) + hidden
    A, H, heads, critical = _chains(source, lengths, breakable)
    if len(lengths) == 2 and source.random() < 0.5:
        H[1, heads[0]] = source.choice(["t", "3", "w"])  # a mixture of outputs, invertible
    for i in range(n):
        if source.random() < 0.3:
            _accumulate(A, i, source.choice(heads), source.choice(["1", "t", "cos(w*t)", "-2*w"]))
    for i in range(rank, n):
        for j in range(n):
            if source.random() < 0.5:
                _accumulate(A, i, j, source.choice(["1", "-w", "t", "sin(w*t)"]))
    N = [{k: "1"} for k in range(rank, n)]
    for _ in range(source.randint(1, shears) if n > 1 else 0):
        i, j = source.sample(range(n), 2)
        _shear(n, A, H, N, (i, j, *_function(source, rates)))
    return Known(
        _text(n, len(lengths), A, H, [*critical, *sorted(rates)]),
        n, rank, max(lengths) - 1,
        [{f"x{i + 1}": text for i, text in column.items()} for column in N],
        critical, rates,
    )  # fmt: skip


def _text(n, m, A, H, parameters):
    def matrix(rows, entries, names):
        lines = []
        for i in range(rows):
            row = {f"x{j + 1}": entries[i, j] for j in range(n) if (i, j) in entries}
            lines.append(f"  {names}{i + 1}:" + ("".join(f"\n    {s}: {e}" for s, e in row.items()) or " {}"))
        return "\n".join(lines)

    values = ", ".join(f"{name}: null" for name in parameters)
    states = ", ".join(f"x{k + 1}" for k in range(n))
    return f"parameters: {{{values}}}\nstates: [{states}]\nA:\n{matrix(n, A, 'x')}\nH:\n{matrix(m, H, 'y')}\n"


def float_directions(known):
    """Return the hidden directions as rows of floats at a point, one row a direction."""
    values = {"w": 0.7310585, "v": 1.1234, "t": 0.4142135, "sin": math.sin, "cos": math.cos, "exp": math.exp}
    rows = []
    for direction in known.hidden:
        row = [0.0] * known.n
        for state, text in direction.items():
            row[int(state[1:]) - 1] = eval(text.replace("^", "**"), {"__builtins__": {}}, values)
        rows.append(row)
    return rows
