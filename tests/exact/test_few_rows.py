"""The count of rows that stands for the elimination where that is too much; roots of small numbers."""

import random
from pathlib import Path

import pytest

from obscli.checks.certificate import check_certificate
from obscli.exact.errors import JetOverflowError
from obscli.exact.exact_system import more_jets, read_system
from obscli.exact.few_rows import most_rows
from obscli.exact.prove import certificate, prove
from obscli.exact.saturation import saturate
from obscli.model.reader import load, read_text


MODELS = sorted((Path(__file__).parents[2] / "models").glob("**/*.yaml"))
PRIMES = [p for p in range(2, 102) if all(p % q for q in range(2, p))]


def system(A, H):
    n = len(A)
    rows = (f"states: [{', '.join(f'x{i}' for i in range(n))}]", f"A: {A}", f"H: {H}")
    return read_text("\n".join(rows).replace("'", ""), "m.yaml").systems[0]


@pytest.mark.parametrize("file", MODELS, ids=[f.stem for f in MODELS])
def test_no_model_has_more_rows(file):
    exact = read_system(load(file).systems[0])
    try:
        found = saturate(exact)
        bounds = [most_rows(exact, k) for k in range(found.order + 1)]
    except JetOverflowError:
        exact = more_jets(exact, ())
        found = saturate(exact)
        bounds = [most_rows(exact, k) for k in range(found.order + 1)]
    for k, bound in enumerate(bounds):
        assert sum(order <= k for order, _ in found.rows) <= bound


@pytest.mark.parametrize("seed", range(40))
def test_the_count_bounds_the_rows(seed):
    """In any outputs; where the derivative of one is another, the count is less."""
    source = random.Random(seed)
    n, m, s = source.randint(3, 6), 2, source.randint(0, 1)
    A = [[source.randint(-2, 2) for _ in range(n)] for _ in range(n)]
    A[1] = [1, *[0] * (n - 1)] if s else A[1]
    a, b = source.randint(-3, 3), source.randint(-3, 3)
    H = [[1 + a * b, a, *[0] * (n - 2)], [b, 1, *[0] * (n - 2)]]
    exact = read_system(system(A, H))
    found = saturate(exact)
    for k in range(found.order + 1):
        assert sum(order <= k for order, _ in found.rows) <= most_rows(exact, k) <= m + k * m
    if s:
        assert most_rows(read_system(system(A, [[1, *[0] * (n - 1)], [0, 1, *[0] * (n - 2)]])), 5) <= m + 5


def test_a_rank_beyond_elimination_is_proved_and_checked():
    """The order is evident from the count: a position beside a velocity brings nothing new."""
    model = load(next(f for f in MODELS if f.stem == "sixteen_states"))
    one = next(s for s in model.systems if s.stage == "manoeuvre")
    proof = prove(one, range(one.n))
    assert (proof.rank, proof.order, proof.flag.eliminated) == (16, 4, False)
    assert proof.order * one.m >= one.n
    assert check_certificate(one, certificate(proof), None).verdict == "holds"


@pytest.mark.parametrize("prime", PRIMES)
def test_roots_of_small_numbers_are_no_obstacle(prime):
    one = system([[0, f"sqrt({prime}/100)"], [0, 0]], [[1, 0]])
    assert prove(one, range(2)).rank == 2
