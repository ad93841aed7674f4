"""The paper's table, row by row, each reached through a model with a claimed basis, word for word.

χ large at some times, or r + q ≠ n     suspect an algebra error
all χ small, r + q < n                  a combination was forgotten
r + q > n                               certainly an error
"""

from itertools import combinations

import pytest

from obscli.checks.agreement import verify_basis
from obscli.checks.diagnosis import Seen, diagnose
from obscli.checks.witness import Witness
from obscli.exact.analysis import Options, analyze
from obscli.model.covector import parse_covector
from obscli.model.reader import read_text
from obscli.numeric.analysis import analyze as look


TIMES = ("1", "2", "3", "4")
#: observable: v, g*tilt - b, d + w*k; the kernel has two dimensions
FIVE = """\
parameters: {g: 9.81, w: 1/2}
states: [v, tilt, b, d, k]
dynamics: {v: g*tilt - b, tilt: 0, b: 0}
measurements: {y: v, z: d + w*k}
claims:
  - basis: """
#: everything is observable
FULL = "states: [x, v]\nA: [[0, 1], [0, 0]]\nH: [[1, 0]]\nclaims:\n  - basis: "
#: b is in the output, but 1e-20 is far below what double precision resolves
FAINT = "parameters: {e: 1e-20}\nstates: [a, b]\nA: zeros(2, 2)\nH: [[1, 1 + e*t]]\nclaims:\n  - basis: "
#: b shows only when the window is no longer a moment
LATE = "states: [a, b]\nA: zeros(2, 2)\nH: [[1, 1 + t]]\nclaims:\n  - basis: "

TABLE = {
    "right": (
        FIVE + "[v, g*tilt - b, d + w*k]",
        TIMES,
        "All χ are below their bounds and r + q = n: nothing speaks against it.",
    ),
    "right, in another form": (
        FIVE + "[v + sin(t)*(d + w*k), tilt - b/g, 2*d + 2*w*k]",
        TIMES,
        "All χ are below their bounds and r + q = n: nothing speaks against it.",
    ),
    "one wrong": (
        FIVE + "[v, g*tilt + b, d + w*k]",
        TIMES,
        "χ is above its bound at 4 of 4 instants: suspect an algebra error in the combinations that leak.",
    ),
    "one wrong, one forgotten": (
        FIVE + "[v, g*tilt + b]",
        TIMES,
        (
            "χ is above its bound at 4 of 4 instants: suspect an algebra error in the combinations that leak. "
            "And r + q < n (4 < 5): rows are missing."
        ),
    ),
    "one forgotten": (
        FIVE + "[v, g*tilt - b]",
        TIMES,
        "All χ are small, r + q < n (4 < 5) at all times: a combination was forgotten.",
    ),
    "two forgotten": (
        FIVE + "[d + w*k]",
        TIMES,
        "All χ are small, r + q < n (3 < 5) at all times: 2 combinations were forgotten.",
    ),
    "one too many, observable": (
        FIVE + "[v, g*tilt - b, d + w*k, v + d + w*k]",
        TIMES,
        "r + q > n (6 > 5) at all times: certainly an error, 1 row too many or rows that are not observable.",
    ),
    "two too many, not observable": (
        FIVE + "[v, g*tilt - b, d + w*k, tilt, k]",
        TIMES,
        (
            "r + q > n (7 > 5) at all times: certainly an error, "
            "2 rows too many or rows that are not observable."
        ),
    ),
    "everything observable": (
        FULL + "[x + v, x - v]",
        TIMES,
        "q = 0: the Gramian has no kernel, every combination is observable.",
    ),
    "everything observable, one forgotten": (
        FULL + "[x + v]",
        TIMES,
        "All χ are small, r + q < n (1 < 2) at all times: a combination was forgotten.",
    ),
    "everything observable, one too many": (
        FULL + "[x, v, x + v]",
        TIMES,
        "r + q > n (3 > 2) at all times: certainly an error, 1 row too many or rows that are not observable.",
    ),
    "too faint": (
        FAINT + "[a, b]",
        TIMES,
        "At no instant is the Gramian clear enough: nothing can be said.",
    ),
    "too early at first": (
        LATE + "[a, b]",
        ("1e-15", "1", "2"),
        (
            "q = 0: the Gramian has no kernel, every combination is observable. "
            "(1 of 3 instants are not clear enough and are left out.)"
        ),
    ),
    "too early at first, one forgotten": (
        LATE + "[a + b]",
        ("1e-15", "2e-15", "1", "2"),
        (
            "All χ are small, r + q < n (1 < 2) at all times: a combination was forgotten. "
            "(2 of 4 instants are not clear enough and are left out.)"
        ),
    ),
}


@pytest.mark.parametrize("row", TABLE)
def test_each_row_of_the_table(checked, row):
    text, times, diagnosis = TABLE[row]
    [result] = checked(text, *times)

    assert result.verification.diagnosis == diagnosis
    right = row.startswith(("right", "everything observable", "too")) and "one" not in row
    assert result.verdict == ("holds" if right else "fails")


@pytest.mark.parametrize("row", [row for row in TABLE if row != "too faint"])
def test_the_numbers_are_those_of_the_instants(checked, row):
    """r + q against n in the words is r + q against n at every conclusive instant."""
    text, times, diagnosis = TABLE[row]
    [result] = checked(text, *times)
    found = result.verification
    seen = [point for point in found.points if point.conclusive]

    assert len(found.points) == len(times)
    assert {point.r for point in seen} == {len(found.combinations)}
    [total] = {point.r + point.q for point in seen}
    sign = "<" if total < found.n else ">"
    fits = total == found.n
    assert (f"({total} {sign} {found.n})" in diagnosis) == (not fits)
    leaking = [point for point in seen if point.chi is not None and point.chi > point.bound]
    assert all(point.agrees == (fits and point not in leaking) for point in seen)
    assert found.verdict == ("verified" if fits and not leaking else "contradicted")
    assert bool(leaking) == (False in {one.holds for one in found.combinations})


def _witness(instants, text, expected=None):
    system = read_text(text + "[]", "test.yaml").systems[0]
    return system, Witness(look(system, instants(system, *TIMES)), expected)


def test_any_rows_left_out_of_a_basis_are_counted(instants):
    """Of r observable rows any k taken: r + q = n exactly for k = r, else the words count what is missing."""
    system, witness = _witness(instants, FIVE)
    rows = [parse_covector(system, text, "row").coefficients for text in ("v", "g*tilt - b", "d + w*k")]
    for count in range(4):
        for some in combinations(rows, count):
            found = verify_basis(witness, some)
            assert ("forgotten" in found.diagnosis) == (count < 3)
            assert (f"{3 - count} combinations were" in found.diagnosis) == (count < 2)
            assert (found.verdict == "verified") == (count == 3)


def test_nothing_claimed_to_be_a_basis(checked):
    [result] = checked(FIVE + "[]", *TIMES)

    assert (result.claim, result.verdict) == ("these 0 combinations are a complete basis (rank 3)", "fails")
    assert result.reason.startswith("3 forgotten, for example v")


def test_rows_that_leak_are_told_from_those_that_do_not(instants):
    system, witness = _witness(instants, FIVE)
    right, wrong = ["v", "g*tilt - b", "d + w*k"], ["v + k", "tilt - b", "d - w*k"]
    for k in range(3):
        texts = [*right[:k], wrong[k], *right[k + 1 :]]
        found = verify_basis(
            witness, [parse_covector(system, one, "row").coefficients for one in texts], texts
        )
        assert [one.expression for one in found.combinations if one.holds is False] == [wrong[k]]
        assert [one.holds for one in found.combinations].count(True) == 2
        assert found.worst.chi == max(one.chi for one in found.combinations)


@pytest.mark.parametrize("expected", [0, 1, 2])
def test_a_rank_above_the_exact_one_is_an_error_of_obscli(instants, expected):
    """Reached only where the analysis is wrong: the Gramian is read with a rank that is too small."""
    system, witness = _witness(instants, FIVE, expected)
    rows = [parse_covector(system, "v", "row").coefficients]
    found = verify_basis(witness, rows)

    assert found.verdict == "contradicted"
    assert found.reason == f"the Gramian shows rank 3, above the exact rank {expected}"
    assert found.diagnosis == (
        f"The Gramian shows 3 directions far above its tolerance, algebra {expected}: "
        "one of the two sides is wrong. Please report it."
    )


def test_one_instant_that_agrees_is_not_contradicted_by_those_that_cannot_tell(instants):
    text = LATE + "[]"
    system = read_text(text, "test.yaml").systems[0]
    analysis = analyze(system, Options(critical=False, certificate=False))
    witness = Witness(look(system, instants(system, "1e-15", "1")), analysis.rank)
    found = verify_basis(witness, [one.coefficients for one in analysis.combinations])

    assert (found.verdict, found.reason) == ("verified", "the Gramian agrees at 1 of 2 instants")
    assert [point.conclusive for point in found.points] == [False, True]


@pytest.mark.parametrize("rows", range(6))
@pytest.mark.parametrize("kernel", range(5))
@pytest.mark.parametrize("leaking", [0, 3])
def test_every_case_falls_into_one_row(rows, kernel, leaking):
    seen = Seen(5, 5, leaking, bool(leaking), rows, kernel, 4, None, 4 - kernel)
    words = diagnose(seen)
    signs = ("forgotten", "certainly an error", "suspect an algebra error", "nothing speaks", "no kernel")

    assert [sign in words for sign in signs].count(True) == 1
    if rows + kernel > 4:
        assert "certainly" in words
    elif leaking:
        assert "suspect" in words
    else:
        assert ("forgotten" in words) == (rows + kernel < 4)
