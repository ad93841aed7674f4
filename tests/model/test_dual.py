"""Duality: twice is the system itself, and the rank of the dual is that of the reachability matrix."""

import random
from fractions import Fraction

import pytest

from obscli.exact.prove import prove
from obscli.model.dual import dual, is_constant
from obscli.model.notation import to_text
from obscli.model.reader import read_text


def system(text):
    return read_text(text, "test.yaml").systems[0]


def written(matrix):
    return {place: to_text(entry) for place, entry in matrix.entries.items()}


# polynomials in t as lists of coefficients: a calculus of its own


def plus(a, b):
    length = max(len(a), len(b))
    return [(a[k] if k < len(a) else 0) + (b[k] if k < len(b) else 0) for k in range(length)]


def product(a, b):
    result = [Fraction(0)] * (len(a) + len(b) - 1)
    for i, x in enumerate(a):
        for j, y in enumerate(b):
            result[i + j] += x * y
    return result


def reachability_rank(A, B, t):
    """The rank at t of P_0 … P_{n−1}, P_0 = B, P_{k+1} = A P_k − P_k', by the definition."""
    n, columns, P = len(A), [], B
    for _ in range(n):
        columns += [
            [sum(c * t**k for k, c in enumerate(P[i][j])) for i in range(n)] for j in range(len(P[0]))
        ]
        moved = []
        for i in range(n):
            row = []
            for j in range(len(P[0])):
                total = [-k * c for k, c in enumerate(P[i][j])][1:] or [Fraction(0)]
                for m in range(n):
                    total = plus(total, product(A[i][m], P[m][j]))
                row.append(total)
            moved.append(row)
        P = moved
    return rank(columns)


def rank(rows):
    rows, found = [list(row) for row in rows], 0
    for column in range(len(rows[0])):
        pivot = next((row for row in rows if row[column]), None)
        if pivot is None:
            continue
        found += 1
        rows = [
            [a - row[column] / pivot[column] * b for a, b in zip(row, pivot, strict=True)]
            for row in rows
            if row is not pivot
        ]
    return found


def text_of(polynomial):
    return " + ".join(f"({c})*t^{k}" if k else f"({c})" for k, c in enumerate(polynomial))


def rows_of(matrix):
    return "[" + ", ".join("[" + ", ".join(f'"{text_of(e)}"' for e in row) + "]" for row in matrix) + "]"


def random_matrices(seed, degree):
    """Sparse matrices of polynomials of that degree in t, so that many are not controllable."""
    source = random.Random(seed)

    def entry(density):
        if source.random() > density:
            return [Fraction(0)]
        return [Fraction(source.randint(-2, 2)) for _ in range(source.randint(0, degree) + 1)]

    n, p = source.randint(2, 4), source.randint(1, 2)
    A = [[entry(0.35) for _ in range(n)] for _ in range(n)]
    B = [[entry(0.4) for _ in range(p)] for _ in range(n)]
    H = [[entry(0.6) for _ in range(n)]]
    return A, B, H


def model_of(A, B, H, key="B"):
    states = ", ".join(f"x{k}" for k in range(1, len(A) + 1))
    return system(f"states: [{states}]\nA: {rows_of(A)}\nH: {rows_of(H)}\n{key}: {rows_of(B)}\n")


@pytest.mark.parametrize("degree", [0, 2])
@pytest.mark.parametrize("seed", range(60))
def test_the_rank_of_the_dual_is_that_of_the_reachability_matrix(seed, degree):
    A, B, H = random_matrices(seed, degree)
    there = dual(model_of(A, B, H))
    assert prove(there, range(there.n)).rank == reachability_rank(A, B, Fraction(7919, 1009))


@pytest.mark.parametrize("key", ["B", "G"])
@pytest.mark.parametrize("degree", [0, 2])
@pytest.mark.parametrize("seed", range(10))
def test_the_dual_of_the_dual_is_the_system(seed, degree, key):
    A, B, H = random_matrices(seed, degree)
    first = model_of(A, B, H, key)
    there = dual(first)
    again = dual(there)
    assert (there.dual, again.dual) == (key, None)
    assert is_constant(there) == is_constant(first)
    assert written(again.A) == written(first.A)
    assert written(again.H) == written(first.H)
    matrix, names = ("B", "inputs") if key == "B" else ("G", "disturbances")
    assert written(getattr(again, matrix)) == written(getattr(first, matrix))
    assert getattr(again, names) == getattr(first, names)
    assert [output.name for output in again.outputs] == [output.name for output in first.outputs]


def test_the_dual_goes_backwards_only_where_time_matters():
    still = dual(system("states: [x, v]\nA: [[0, 1], [0, 0]]\nH: [[1, 0]]\nB: [[0], [3]]\n"))
    assert written(still.A) == {(1, 0): "1"}
    assert written(still.H) == {(0, 1): "3"}
    moving = dual(system("states: [x, v]\nA: [[0, 1], [0, 0]]\nH: [[1, 0]]\nB: [[0], [t]]\n"))
    assert written(moving.A) == {(1, 0): "-1"}


def test_what_is_said_about_the_states_is_left_out():
    there = dual(
        system(
            "states: {x: {scale: 10, unit: m}, v: 1}\ninputs: [u]\ndisturbances: [w]\n"
            "dynamics: {x: v, v: u + w}\nmeasurements: {y: x}\nquantities: {q: x + v}\n"
            "noise: {Q: [1], R: [1], P0: [1, 1]}\nclaims: [{rank: 2}]\ninterval: {stop: 5}\n"
        )
    )
    assert there.dual == "B"
    assert [output.name for output in there.outputs] == ["u"]
    assert there.inputs == ("y",)
    assert not there.quantities
    assert not there.claims
    assert there.noise is None
    assert not there.prior
    assert there.interval is not None
    assert to_text(there.states[0].scale) == "1/10"
    assert there.states[0].unit == ""


def test_without_inputs_there_is_no_dual():
    with pytest.raises(ValueError, match="neither inputs nor disturbances"):
        dual(system("states: [x]\nA: [[0]]\nH: [[1]]\n"))


def test_the_single_channel_is_reached_by_its_noise():
    """The noise of gyro and accelerometer reaches all five states; that of the gyro alone all but dW."""
    text = (
        "parameters: {{g: 9.8, a_om: 0.04, a_w: 0.001}}\nstates: [alpha, V, R, dOm, dW]\n"
        "A: [[0,0,0,1,0],[g,0,0,0,1],[0,1,0,0,0],[0,0,0,a_om,0],[0,0,0,0,a_w]]\n"
        "H: [[0,1,0,0,0],[0,0,1,0,0]]\nG: {g}\n"
    )
    both = dual(system(text.format(g="[[0,0],[0,0],[0,0],[1,0],[0,1]]")))
    assert prove(both, range(5)).rank == 5
    gyro = dual(system(text.format(g="[[0],[0],[0],[1],[0]]")))
    proof = prove(gyro, range(5))
    assert proof.rank == 4
    assert [set(one) for one in proof.directions.values()] == [{"dW"}]
