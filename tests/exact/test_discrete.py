"""Discrete-time systems, exactly: ranks by an independent route, roots inside the unit circle, laws of sampling."""

import random
from dataclasses import replace
from fractions import Fraction
from itertools import product

import numpy as np
import pytest

from obscli.checks.certificate import check_certificate
from obscli.exact.analysis import Options, analyze
from obscli.exact.finding import Analysis, Undecided
from obscli.model.dual import dual
from obscli.model.expression import negate
from obscli.model.notation import to_text
from obscli.model.reader import load, read_text


QUICK = Options(critical=False)


def text(F, H, more=""):
    def rows(matrix):
        return "[" + ", ".join("[" + ", ".join(map(str, row)) + "]" for row in matrix) + "]"

    states = ", ".join(f"x{j + 1}" for j in range(len(F)))
    return f"states: [{states}]\nF: {rows(F)}\nH: {rows(H)}\n{more}"


def system(F, H, more=""):
    return read_text(text(F, H, more), "test").systems[0]


def verdict(F, H=None, more=""):
    """The structure where nothing is seen of x."""
    found = analyze(system(F, H or [[0] * len(F)], more), QUICK)
    assert isinstance(found, Analysis)
    return found.structure


def basis(found):
    return tuple(one.coefficients for one in found.combinations)


def fractions_rank(rows):
    """The rank of rows of fractions, by elimination."""
    rows, rank = [list(map(Fraction, row)) for row in rows], 0
    for j in range(len(rows[0])):
        pivot = next((i for i in range(rank, len(rows)) if rows[i][j]), None)
        if pivot is None:
            continue
        rows[rank], rows[pivot] = rows[pivot], rows[rank]
        for i in range(rank + 1, len(rows)):
            f = rows[i][j] / rows[rank][j]
            rows[i] = [a - f * b for a, b in zip(rows[i], rows[rank], strict=True)]
        rank += 1
    return rank


def stacked(F, H):
    found, row = [], [list(r) for r in H]
    for _ in F:
        found += row
        row = [[sum(r[i] * F[i][j] for i in range(len(F))) for j in range(len(F))] for r in row]
    return found


@pytest.mark.parametrize("seed", range(12))
def test_the_rank_is_that_of_the_samples(seed):
    source = random.Random(seed)
    n = source.randint(2, 5)
    F = [[source.choice([0, 0, 0, 1, 1, -1, 2]) for _ in range(n)] for _ in range(n)]  # some singular
    H = [[source.choice([0, 0, 1]) for _ in range(n)] for _ in range(source.randint(1, 2))]
    given = system(F, H)
    found = analyze(given, QUICK)
    assert found.rank == fractions_rank(stacked(F, H))
    assert check_certificate(given, found.certificate, basis(found)).verdict == "holds"


@pytest.mark.parametrize("seed", range(6))
def test_the_dual_shows_what_inputs_reach(seed):
    source = random.Random(100 + seed)
    n = source.randint(2, 4)
    F = [[source.choice([0, 0, 1, -1, 2]) for _ in range(n)] for _ in range(n)]
    B = [[source.choice([0, 1])] for _ in range(n)]
    given = system(F, [[1] + [0] * (n - 1)], f"B: {B}\n")
    transposed = [list(column) for column in zip(*F, strict=True)]
    reached = fractions_rank(stacked(transposed, [[row[0] for row in B]]))
    assert analyze(dual(given), QUICK).rank == reached
    assert analyze(dual(dual(given)), QUICK).rank == analyze(given, QUICK).rank


# -- the certificate


def test_the_certificate_says_how_the_kernel_moves():
    given = system([[2, 1, 0], [0, 3, 0], [1, 0, 5]], [[0, 1, 0]])
    found = analyze(given, QUICK)
    moved = {(0, 0): "2", (0, 1): "1", (1, 1): "5"}  # F N = N X for N = (e1, e3)
    columns = found.certificate.upper.multiplier
    assert [[to_text(e) for e in column] for column in columns] == [
        [moved.get((0, j), "0") for j in range(2)],
        ["0", "5"],
    ]


def test_a_certificate_with_the_sign_of_continuous_time_is_refused():
    given = system([[2, 1], [0, 3]], [[0, 1]])
    one = analyze(given, QUICK).certificate
    wrong = replace(
        one, upper=replace(one.upper, multiplier=tuple((negate(e),) for (e,) in one.upper.multiplier))
    )
    assert check_certificate(given, wrong, None).verdict != "holds"
    assert "F N = N X" in check_certificate(given, wrong, None).reason


def test_certificates_tell_the_two_kinds_apart():
    discrete = system([[2, 1], [0, 3]], [[1, 0]])
    continuous = read_text(text([[2, 1], [0, 3]], [[1, 0]]).replace("F:", "A:"), "test").systems[0]
    assert check_certificate(continuous, analyze(discrete, QUICK).certificate, None).verdict != "holds"


# -- inside the unit circle


@pytest.mark.parametrize("seed", range(25))
def test_hidden_errors_die_out_inside_the_unit_circle(seed):
    """The verdict on a random companion matrix is that of its eigenvalues in floating point."""
    source = random.Random(seed)
    k = source.randint(1, 4)
    c = [Fraction(source.randint(-9, 9), source.choice([4, 7, 10, 20])) for _ in range(k)]
    F = [[int(j == i + 1) for j in range(k)] for i in range(k)]
    F[-1] = [-one for one in c]
    largest = max(abs(np.linalg.eigvals(np.array(F, dtype=float))))
    if abs(largest - 1) > 1e-6:
        assert verdict(F).verdict == ("detectable" if largest < 1 else "not detectable")


@pytest.mark.parametrize(
    ("F", "kind", "expected"),
    [
        ([[1]], "neutral", "not detectable"),
        ([[-1]], "neutral", "not detectable"),
        ([[0]], "decaying", "detectable"),
        ([["1/2"]], "decaying", "detectable"),
        ([["-3/2"]], "growing", "not detectable"),
        ([[0, 1], [-1, 0]], "neutral", "not detectable"),
        ([["3/5", "4/5"], ["-4/5", "3/5"]], "neutral", "not detectable"),
        ([["1/2", "1/2"], ["-1/2", "1/2"]], "decaying", "detectable"),
        ([[1, 1], [-1, 1]], "growing", "not detectable"),
        ([[0, 1, 0], [0, 0, 1], [1, 0, 0]], "neutral", "not detectable"),
    ],
)
def test_kinds_of_modes(F, kind, expected):
    found = verdict(F)
    assert {mode.kind for mode in found.modes} == {kind}
    assert found.verdict == expected


def test_a_chain_on_the_circle_grows():
    found = verdict([[1, 1], [0, 1]])
    assert sorted(mode.kind for mode in found.modes) == ["growing", "neutral"]


def test_everything_in_a_nilpotent_chain_is_gone():
    found = verdict([[0, 1, 0], [0, 0, 1], [0, 0, 0]])
    assert found.verdict == "detectable"
    assert {mode.values for mode in found.modes} == {(0j,)}


def test_the_condition_on_a_parameter():
    found = verdict([["a"]], more="parameters: {a: 0.9}")
    assert found.verdict == "depends"
    assert found.condition == "a**2 - 1 < 0"
    assert found.modes[0].kind_there == "decaying"


def test_the_conditions_on_a_pair_are_those_of_jury():
    """s^2 + b s + c: |c| < 1 and |b| < 1 + c; compared with the roots at a grid of values."""
    found = verdict([[0, 1], ["-c", "-b"]], more="parameters: {b: , c: }")
    assert found.verdict == "depends"
    python = found.condition.replace(" and ", ") and (")
    for b, c in product(np.linspace(-2.45, 2.55, 12), np.linspace(-1.45, 1.55, 12)):
        inside = max(abs(np.roots([1, b, c]))) < 1
        assert eval(f"({python})", {"b": b, "c": c}) == inside


# -- sampling


OSCILLATOR = "discrete/sampled_oscillator.yaml"


@pytest.fixture(scope="module")
def oscillator(request):
    return load(request.config.rootpath / "models" / OSCILLATOR).systems[0]


def test_the_critical_sampling_period_is_found(oscillator):
    found = analyze(oscillator, Options())
    conditions = {one.condition for one in found.critical.values if one.kind == "confirmed"}
    assert "T = pi/omega" in conditions


@pytest.mark.parametrize(
    ("period", "rank"), [("pi/omega", 1), ("2*pi/omega", 1), ("pi/(2*omega)", 2), ("1/omega", 2)]
)
def test_sampling_keeps_the_kernel_but_at_critical_periods(request, period, rank):
    file = request.config.rootpath / "models" / OSCILLATOR
    given = load(file, fix={"T": period}).systems[0]
    assert analyze(given, QUICK).rank == rank


@pytest.mark.parametrize("seed", range(6))
def test_sampling_keeps_the_kernel(seed):
    """F = exp(N T) for a nilpotent N, exactly: it has no critical periods, so rank and directions stay."""
    source = random.Random(seed)
    n = source.randint(2, 4)
    N = [[source.choice([0, 1, 2]) if j > i else 0 for j in range(n)] for i in range(n)]
    H = [[source.choice([0, 1]) for _ in range(n)]]
    term, F = [[Fraction(int(i == j)) for j in range(n)] for i in range(n)], None
    for k in range(n):
        F = (
            term
            if F is None
            else [[a + b for a, b in zip(r, s, strict=True)] for r, s in zip(F, term, strict=True)]
        )
        term = [[sum(term[i][m] * N[m][j] for m in range(n)) / (k + 1) for j in range(n)] for i in range(n)]
    sampled = analyze(system(F, H), QUICK)
    continuous = analyze(read_text(text(N, H).replace("F:", "A:"), "test").systems[0], QUICK)
    assert sampled.rank == continuous.rank
    assert [{s: to_text(e) for s, e in one.items()} for one in sampled.unobservable] == [
        {s: to_text(e) for s, e in one.items()} for one in continuous.unobservable
    ]


# -- what keeps its value, and what is not done yet


def test_what_keeps_its_value_is_what_f_leaves_alone():
    found = analyze(system([[1, 0], [0, 2]], [[1, 0], [0, 1]]), QUICK)
    assert {next(iter(one.coefficients)): one.constant for one in found.combinations} == {
        "x1": True,
        "x2": False,
    }


# -- coefficients that depend on the step


def changing(F, H, change, shift):
    """The system in z(k) = T(k) x(k):  T(k+1) F T(k)^-1 and H T(k)^-1 as text, T = [[1, g(k)], [0, 1]]."""
    (a, b), (c, d) = F
    g, after = change, shift
    moved = [
        [f"({a}) + ({after})*({c})", f"({b}) + ({after})*({d}) - ({g})*(({a}) + ({after})*({c}))"],
        [f"{c}", f"({d}) - ({g})*({c})"],
    ]
    seen = [[f"{h}", f"({i}) - ({g})*({h})"] for h, i in H]
    return system(moved, seen, "parameters: {w: 0.7, a: 0.3}\n")


@pytest.mark.parametrize(
    ("change", "shift"),
    [("k", "k + 1"), ("k^2", "(k + 1)^2"), ("cos(w*k)", "cos(w*(k + 1))"), ("exp(-a*k)", "exp(-a*(k + 1))")],
)
@pytest.mark.parametrize(
    ("F", "H", "rank"),
    [([[2, 0], [0, 3]], [[1, 0]], 1), ([[2, 1], [0, 3]], [[1, 0]], 2), ([[0, 0], [1, 0]], [[1, 0]], 1)],
)
def test_a_change_of_variables_that_moves_keeps_the_rank(change, shift, F, H, rank):
    given = changing(F, H, change, shift)
    found = analyze(given, QUICK)
    assert isinstance(found, Analysis)
    assert found.rank == rank == analyze(system(F, H), QUICK).rank
    assert check_certificate(given, found.certificate, basis(found)).verdict == "holds"
    assert found.system is given
    assert found.at_values.rank == rank


def test_a_combination_that_moves_with_the_step():
    found = analyze(system([[1, -1], [0, 1]], [[1, "k"]]), Options())
    [one] = found.combinations
    assert {state: to_text(e) for state, e in one.coefficients.items()} == {"x1": "1", "x2": "k"}
    assert (one.output, one.order, one.constant) == ("y1", 0, True)
    assert found.structure.verdict == "undecided"


def test_the_order_is_that_of_the_samples():
    found = analyze(system([[1, "k"], [0, 1]], [[1, 0]]), QUICK)
    assert found.order == 1
    assert [(one.output, one.order) for one in found.combinations] == [("y1", 0), ("y1", 1)]


@pytest.mark.parametrize(
    ("F", "H"), [([["cos(pi*k)"]], [[1]]), ([["sin(2*asin(1)*k)"]], [[1]]), ([[1]], [["sin(2*pi*k)"]])]
)
def test_what_repeats_at_whole_steps_is_refused(F, H):
    """sin(2 pi k) is zero at every step, though it is no zero function of a real k."""
    found = analyze(system(F, H), QUICK)
    assert isinstance(found, Undecided)
    assert "repeats at whole steps" in found.reason


def test_values_that_make_it_repeat_leave_the_rank_there_open():
    found = analyze(system([[1]], [["sin(w*k)"]], "parameters: {w: 2*pi}\n"), QUICK)
    assert found.rank == 1
    assert found.at_values.rank is None
    assert "repeats at whole steps" in found.at_values.reason
