"""The independent route behind models/calibration/*.yaml: no obscli code, no obscli parser.

The runs of calibration_runs.py, each with Taylor series about one instant: the k-th Taylor coefficient of
H Phi has the rows of L_k(t0) / k!, blocks are taken until one adds nothing. Everything is exact (fractions);
the rank at a random point is the generic rank with probability one, and two points must agree. In each run
the states that start anew are eliminated first; the rows without them are what the run says about the
constants, and these are stacked.

    python tests/independent/calibration_rank.py    # table of ranks, determined constants, kernels

calibration_claims.py compares with the claims of the models.
"""

from __future__ import annotations

import functools
import re
import sys
from collections import Counter
from fractions import Fraction
from itertools import combinations
from pathlib import Path


sys.path.insert(0, str(Path(__file__).resolve().parent))

from calibration_runs import EXPERIMENTS, INS, TERMS, UNIT, Point, series


def reduced(rows):
    """Reduced echelon form and pivots; exact."""
    rows, pivots = [row for row in rows if any(row)], []
    for column in range(len(rows[0]) if rows else 0):
        top = len(pivots)
        found = next((i for i in range(top, len(rows)) if rows[i][column]), None)
        if found is None:
            continue
        rows[top], rows[found] = rows[found], rows[top]
        rows[top] = [x / rows[top][column] for x in rows[top]]
        for i, row in enumerate(rows):
            if i != top and row[column]:
                rows[i] = [x - row[column] * y if y else x for x, y in zip(row, rows[top], strict=True)]
        rows = [row for i, row in enumerate(rows) if i <= top or any(row)]
        pivots.append(column)
    return rows, pivots


def kernel(rows, pivots, size):
    for free in sorted(set(range(size)) - set(pivots)):
        vector = [Fraction(int(j == free)) for j in range(size)]
        for row, pivot in zip(rows, pivots, strict=True):
            vector[pivot] = -row[free]
        yield vector


@functools.cache
def said(model, stage, fix, seed):
    """Rank of a run over all its states, the rows it gives on the constants alone, and the point."""
    p = Point(seed, dict(fix))
    F, B, K, D = EXPERIMENTS[model][1](p, stage)
    n, B, D = len(F), [[series(x).c for x in row] for row in B], [[series(x).c for x in row] for row in D]
    phi = [[Fraction(x) for x in row] for row in UNIT[:n]]  # of fresh by fresh, Taylor coefficient k
    drive = [[Fraction(0)] * len(D[0]) for _ in range(n)]  # of fresh by the constants
    rows = []
    for k in range(TERMS):
        block = [
            [sum(a * phi[i][j] for i, a in enumerate(row)) for j in range(n)]
            + [d[k] + sum(a * drive[i][j] for i, a in enumerate(row)) for j, d in enumerate(D[m])]
            for m, row in enumerate(K)
        ]
        before, (rows, pivots) = len(rows), reduced(rows + [[Fraction(x) for x in row] for row in block])
        if len(rows) == before or len(rows) == n + len(D[0]):
            return len(rows), [row[n:] for row, pivot in zip(rows, pivots, strict=True) if pivot >= n], p
        drive = [[(sum(F[i][l] * drive[l][j] for l in range(n)) + b[k]) / (k + 1) for j, b in enumerate(B[i])]
                 for i in range(n)]  # fmt: skip
        phi = [[sum(F[i][l] * phi[l][j] for l in range(n)) / (k + 1) for j in range(n)] for i in range(n)]
    raise AssertionError(f"{model} {stage}: more Taylor coefficients are needed")


def rows_of(model, label, seed):
    stage, fix = EXPERIMENTS[model][2][label]
    return said(model, stage, tuple(fix.items()), seed)[1]


def together(model, labels, seed=0):
    """What runs determine together: rows in reduced form, and their pivots."""
    return reduced([row for label in labels for row in rows_of(model, label, seed)])


def show(model, title, labels):
    constants = EXPERIMENTS[model][0]
    (rows, pivots), again = together(model, labels), together(model, labels, seed=1)[0]
    assert len(rows) == len(again)
    alone = [constants[p] for row, p in zip(rows, pivots, strict=True) if sum(map(bool, row)) == 1]
    left = " ".join(c for c in constants if c not in alone)
    rank = f"rank {len(rows)} of {len(constants)}"
    sys.stdout.write(f"{model}, {title}: {rank}; not determined: {left or '-'}\n")
    for vector in kernel(rows, pivots, len(constants)):
        entries = " ".join(f"{c}:{x}" for c, x in zip(constants, vector, strict=True) if x)
        sys.stdout.write(f"    kernel {entries}\n")


def count(model, sizes):
    labels = list(EXPERIMENTS[model][2])
    for size in sizes:
        ranks = {s: len(together(model, s)[0]) for s in combinations(labels, size)}
        full = sum(rank == 21 for rank in ranks.values())
        sys.stdout.write(f"{model}, {size} of {len(labels)} runs: {full} of {len(ranks)} reach 21; ")
        sys.stdout.write(f"ranks {dict(sorted(Counter(ranks.values()).items()))}\n")
        if size == 3 and len(labels) == 6:
            sys.stdout.writelines(f"    {rank}: {'; '.join(subset)}\n" for subset, rank in ranks.items())


PARTS = [  # model, title, which runs
    ("six_position", "levelled", "[xyz]_"),
    ("six_position", "levelled, upwards only", "[xyz]_up"),
    ("six_position", "rough", "rough"),
    ("six_position", "rough and edges", "rough|edge"),
    ("twenty_four_positions", "all", ""),
    ("twenty_four_positions", "one heading", r".*heading = 0,"),
    ("twenty_four_positions", "opposite headings", r".*heading = (0|pi),"),
    ("twenty_four_positions", "headings at a right angle", r".*heading = (0|pi/2),"),
    ("two_axis_table", "inner axis, up and east", r"inner_turns \(outer = (0|pi/2)\b"),
    ("two_axis_table", "inner axis, one way", r"inner_turns \(outer = [^,]*$"),
    ("two_axis_table", "inner axis", "inner_turns"),
    ("two_axis_table", "outer axis", "outer_turns"),
    ("table_errors", "one run", "x_east"),
    ("table_errors", "turned end for end", "x_"),
    ("table_errors", "two faces", "[xy]_east"),
    ("table_errors", "all", ""),
    *(("modulus", stage, stage) for stage in ("motor", "by_hand", "any_motion", "one_axis")),
]


def table():
    """Print ranks of the experiments and of telling parts; in the kernels g = 7, omega = 3, omega_ie = 5."""
    level, plan = "paper, axis level", "table_plan"
    stacked = sum(len(rows_of(level, label, 0)) for label in EXPERIMENTS[level][2])
    sys.stdout.write(f"{level}: the stacked matrix is {stacked} x {len(INS)}\n")
    count(level, range(1, 7))
    up = [label for label in EXPERIMENTS[plan][2] if "outer = 0" in label]
    show(plan, "axis up (paper's vertical axis), three runs", up[::2])
    show(plan, "axis up, six runs, both ways", up)
    show(plan, "axis up and down, six runs", up[::2] + [label.replace("= 0", "= pi") for label in up[::2]])
    count(plan, (1, 2, 3))
    for model, title, pattern in PARTS:
        show(model, title, [label for label in EXPERIMENTS[model][2] if re.match(pattern, label)])


if __name__ == "__main__":
    table()
