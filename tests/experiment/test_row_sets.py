"""Ranks of many unions, and the smallest sets: against proof and against brute force."""

import random
from fractions import Fraction
from itertools import combinations

import pytest

from obscli.exact.row_sets import RowSets
from obscli.experiment import smallest_sets as search
from obscli.experiment.own_symbols import told_apart
from obscli.experiment.smallest_sets import smallest_sets
from obscli.experiment.stacked import proved


LEVEL = """\
experiment:
  runs:
    - {stage: [stage_1, stage_2, stage_3], grid: {omega: [omega, -omega]}}
"""


def subsets(count, largest=None):
    return [some for k in range((largest or count) + 1) for some in combinations(range(count), k)]


# -- the level runs of the paper


@pytest.fixture(scope="module")
def level(model, bare):
    """The paper's six runs with their rows, and the ranks of all unions."""
    given = model(bare("ins_calibration/horizontal.yaml") + LEVEL).experiment
    runs, _ = told_apart(given.runs)
    stack = proved(runs, given.shared)
    return runs, given.shared, stack, RowSets(stack.system, [len(one.rows) for one in stack.runs])


def test_every_rank_of_level_runs_is_the_proved_one(level):
    """Each stacked and proved again, with its certificate: 64 unions of six runs."""
    from obscli.checks.certificate import check_certificate
    from obscli.exact.analysis import Options
    from obscli.experiment.stacked import stacked

    _, shared, stack, rows = level
    for some in subsets(6)[1:]:
        whole = stacked(tuple(stack.runs[k] for k in some), shared, Options(critical=False))
        assert rows.rank(some) == whole.finding.rank
        assert check_certificate(whole.system, whole.finding.certificate, None).verdict == "holds"
    assert rows.rank(()) == 0


def test_three_level_runs_are_the_minimum_and_any_three_suffice(level):
    runs, _, _, rows = level
    stages = [run.stage for run in runs]
    assert {rows.rank(one) for one in subsets(6, 1)[1:]} == {13}
    for i, j in combinations(range(6), 2):
        assert rows.rank((i, j)) == (15 if stages[i] == stages[j] else 20)
    assert {rows.rank(some) for some in combinations(range(6), 3)} == {21}

    found = smallest_sets(rows)
    assert (found.rank, found.size, found.exhaustive) == (21, 3, True)
    assert sorted(found.sets) == list(combinations(range(6), 3))


# -- random matroids


def static(model, groups):
    """Rows of whole numbers in groups, as unions of rows of x' = 0, y = H x."""
    n = len(next(row for group in groups for row in group))
    H = ", ".join(f"[{', '.join(map(str, row))}]" for group in groups for row in group)
    states = ", ".join(f"x{k + 1}" for k in range(n))
    system = model(f"states: [{states}]\nA: zeros({n}, {n})\nH: [{H}]\n").systems[0]
    return RowSets(system, [len(group) for group in groups])


def rank(rows):
    rows, found = [list(map(Fraction, row)) for row in rows], 0
    for column in range(len(rows[0]) if rows else 0):
        pivot = next((row for row in rows if row[column]), None)
        if pivot is None:
            continue
        rows.remove(pivot)
        found += 1
        rows = [
            [x - row[column] / pivot[column] * y for x, y in zip(row, pivot, strict=True)] for row in rows
        ]
    return found


def matroid(seed):
    """Groups of one to three rows over five columns, some of them empty of rank, some alike."""
    source = random.Random(seed)
    pool = [[source.choice([-2, -1, 0, 0, 0, 1, 3]) for _ in range(6)] for _ in range(8)]
    groups = [source.choices(pool, k=source.randint(1, 3)) for _ in range(source.randint(3, 7))]
    if source.random() < 0.3:
        groups.append([[0] * 6])
    return groups


def forbidden_of(seed, count):
    source = random.Random(1000 + seed)
    return [frozenset(source.sample(range(count), source.randint(1, 3))) for _ in range(source.randint(1, 3))]


def brute_force(groups, forbidden=()):
    """The largest rank that an allowed set reaches, and all allowed sets of the smallest size that do."""
    allowed = [some for some in subsets(len(groups)) if not any(one <= set(some) for one in forbidden)]
    ranks = {some: rank([row for k in some for row in groups[k]]) for some in allowed}
    best = max(ranks.values())
    size = min(len(some) for some in allowed if ranks[some] == best)
    return best, [some for some in allowed if ranks[some] == best and len(some) == size]


@pytest.mark.parametrize("seed", range(25))
def test_ranks_of_unions_are_those_in_fractions(model, seed):
    groups = matroid(seed)
    rows = static(model, groups)
    assert len(rows) == len(groups)
    for some in subsets(len(groups)):
        assert rows.rank(some) == rank([row for k in some for row in groups[k]])


@pytest.mark.parametrize("seed", range(25))
def test_the_smallest_sets_are_those_of_brute_force(model, seed):
    groups = matroid(seed)
    best, sets = brute_force(groups)
    found = smallest_sets(static(model, groups))
    assert found.exhaustive
    assert (found.rank, sorted(found.sets)) == (best, sets if best else [])


@pytest.mark.parametrize("seed", range(25))
def test_forbidden_sets_are_never_chosen(model, seed):
    groups = matroid(seed)
    forbidden = forbidden_of(seed, len(groups))
    best, sets = brute_force(groups, forbidden)
    found = smallest_sets(static(model, groups), forbidden)
    assert (found.rank, sorted(found.sets)) == (best, sets if best else [])


@pytest.mark.parametrize("seed", range(25))
def test_the_greedy_choice_reaches_the_same_rank_within_its_guarantee(model, monkeypatch, seed):
    groups = matroid(seed)
    best, sets = brute_force(groups)
    monkeypatch.setattr(search, "MOST_LOOKS", 0)
    found = smallest_sets(static(model, groups))
    largest = max(rank(group) for group in groups)

    [chosen] = found.sets
    assert not found.exhaustive
    assert found.rank == best == rank([row for k in chosen for row in groups[k]])
    assert found.guarantee == pytest.approx(sum(1 / k for k in range(1, largest + 1)))
    assert len(sets[0]) <= len(chosen) <= found.guarantee * len(sets[0])


@pytest.mark.parametrize("seed", range(25))
def test_the_greedy_choice_keeps_to_what_is_allowed(model, monkeypatch, seed):
    groups = matroid(seed)
    forbidden = forbidden_of(seed, len(groups))
    monkeypatch.setattr(search, "MOST_LOOKS", 0)
    found = smallest_sets(static(model, groups), forbidden)

    [chosen] = found.sets
    assert not any(one <= set(chosen) for one in forbidden)
    assert found.rank == rank([row for k in chosen for row in groups[k]])
    assert found.guarantee is None


def test_where_the_search_stops_midway_the_greedy_choice_is_taken(model, monkeypatch):
    groups = [[[int(j == k) for j in range(6)]] for k in range(6)] * 2
    rows = static(model, groups)
    whole = smallest_sets(rows)
    assert (whole.size, len(whole.sets), whole.exhaustive) == (6, 64, True)
    monkeypatch.setattr(search, "MOST_LOOKS", whole.looked_at - 1)
    found = smallest_sets(rows)
    assert (found.rank, found.size, found.exhaustive) == (6, 6, False)
    monkeypatch.setattr(search, "MOST_LOOKS", whole.looked_at)
    assert smallest_sets(rows).exhaustive
