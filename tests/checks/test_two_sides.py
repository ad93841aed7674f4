"""Exact algebra and Gramian put together: who decides, who refutes, and when the Gramian is no witness."""

from dataclasses import replace

import pytest

from obscli.checks.claims import check_claims
from obscli.exact.analysis import Options, analyze
from obscli.exact.finding import Undecided
from obscli.model.covector import parse_covector
from obscli.model.reader import read_text
from obscli.numeric.analysis import analyze as look


FAST = Options(critical=False, certificate=False)
TIMES = ("1", "2", "3")
#: the root of t^2 has no sign, so algebra decides nothing; the Gramian sees v and g*tilt + b
OPAQUE = """\
parameters: {g: 10}
states: [v, tilt, b]
dynamics: {v: sqrt(t^2)*(g*tilt + b)}
measurements: {y: v}
claims:
  - """
#: at w = 0 nothing shows d
CRITICAL = """\
parameters: {g: 10, w: 0}
states: [v, tilt, b, d]
dynamics: {v: g*tilt + b + w*t*d}
measurements: {y: v}
claims:
  - """
UNKNOWN_SIGN = "the sign of t is not known, so its root is not determined"
AGREES = "the Gramian agrees at 3 of 3 instants"
NO_WITNESS = "the Gramian is no witness: at the file's values the rank is 2"


@pytest.mark.parametrize(
    ("claim", "words"),
    [
        ("rank: 1", "the Gramian shows 2 directions far above its tolerance"),
        ("rank: 0", "the Gramian shows 2 directions far above its tolerance"),
        ("basis: [v]", "the Gramian shows 2 directions far above its tolerance"),
        ("basis: [v, g*tilt - b]", "the Gramian denies it: χ = "),
        ("observable: [tilt]", "the Gramian denies it: χ = "),
        ("observable: [v + b]", "the Gramian denies it: χ = "),
        ("directions: [{v: 1}]", "the Gramian shows this direction "),
        ("directions: [{tilt: 1, b: g}]", "the Gramian shows this direction "),
    ],
)
def test_the_gramian_alone_refutes(checked, claim, words):
    [result] = checked(OPAQUE + claim + "\n", *TIMES)

    assert result.verdict == "fails"
    assert result.reason.startswith("undecided exactly (test.yaml:3:15: A[v, tilt]: " + UNKNOWN_SIGN)
    assert f"); {words}" in result.reason
    assert (result.corrections, result.counterexample, result.transformation) == ((), None, ())


@pytest.mark.parametrize(
    "claim",
    [
        "rank: 2",
        "basis: [v, g*tilt + b]",
        "observable: [v - 3*t*(tilt + b/g)]",
        "unobservable: [tilt]",
        "directions: [{tilt: 1, b: -g}]",
        "states: {v: observable}",
        "states: {b: coupled}",
    ],
)
def test_the_gramian_alone_confirms_but_does_not_prove(checked, claim):
    [result] = checked(OPAQUE + claim + "\n", *TIMES)

    assert result.verdict == "undecided"
    assert UNKNOWN_SIGN in result.reason
    assert f"; {AGREES}" in result.reason
    assert (result.gramian.agree, result.gramian.of) == (3, 3)


@pytest.mark.parametrize(
    ("claim", "words"),
    [
        ("rank: 3", "the Gramian shows only 2 directions above its tolerance"),
        ("states: {b: unobservable}", "the Gramian shows b as coupled"),
        ("unobservable: [v]", ""),
    ],
)
def test_what_a_longer_window_might_change_stays_open(checked, claim, words):
    [result] = checked(OPAQUE + claim + "\n", *TIMES)

    assert result.verdict == "undecided"
    assert words in result.reason


@pytest.mark.parametrize("claim", ["rank: 1", "observable: [tilt]", "basis: [v]", "directions: [{v: 1}]"])
def test_without_a_gramian_nothing_is_refuted(checked, claim):
    [result] = checked(OPAQUE + claim + "\n", gramian=False)

    assert result.verdict == "undecided"
    assert result.gramian is None


@pytest.mark.parametrize("claim", ["unobservable: [v]", "unobservable: [g*tilt + b]"])
def test_the_gramian_agrees_only_with_what_is_claimed(checked, claim):
    [result] = checked(OPAQUE + claim + "\n", *TIMES)

    assert "the Gramian agrees" not in result.reason


def test_a_basis_with_rows_that_leak_is_refuted_also_where_it_is_too_long(checked):
    [result] = checked(OPAQUE + "basis: [v, tilt, b]\n", *TIMES)

    assert result.verification.verdict == "contradicted"
    assert result.verdict == "fails"


def test_one_combination_that_cannot_be_read_leaves_the_rest_of_its_claim_to_be_checked(checked):
    text = OPAQUE.replace("sqrt(t^2)*", "") + "{rank: 3, observable: [sqrt(t^2)*v]}\n"

    assert "fails" in {result.verdict for result in checked(text, *TIMES)}


def _wrong_analysis(text, row):
    """Return a system, its analysis with one combination replaced, and its Gramian."""
    system = read_text(text, "test.yaml").systems[0]
    analysis = analyze(system, FAST)
    other = replace(analysis.combinations[0], coefficients=parse_covector(system, row, "row").coefficients)
    return system, replace(analysis, combinations=(other, *analysis.combinations[1:]), unobservable=())


def test_the_gramian_contradicts_a_wrong_proof(instants):
    """An analysis that takes tilt for observable proves the claim; the Gramian denies it, and that counts."""
    text = OPAQUE.replace("sqrt(t^2)*", "") + "observable: [tilt]\n"
    system, wrong = _wrong_analysis(text, "tilt")
    settings = instants(system, *TIMES)
    [alone] = check_claims(system, wrong)
    [both] = check_claims(system, wrong, lambda one: look(one, settings))

    assert (alone.verdict, alone.reason) == ("holds", "proved exactly")
    assert both.verdict == "fails"
    assert both.reason.startswith("proved exactly, but the Gramian denies it: χ = ")


@pytest.mark.parametrize("claim", ["rank: 3", "observable: [d, v]", "basis: [v, g*tilt + b, d]"])
def test_nominal_values_below_the_generic_rank_are_explained_not_called_a_contradiction(checked, claim):
    for result in checked(CRITICAL + claim + "\n", *TIMES):
        assert (result.verdict, result.reason) == ("holds", f"proved exactly; {NO_WITNESS}")
        assert (result.gramian, result.verification) == (None, None)


def test_a_false_claim_there_has_a_counterexample_in_symbols_only(checked):
    [result] = checked(CRITICAL + "observable: [tilt]\n", *TIMES)

    assert result.verdict == "fails"
    assert result.reason.endswith(NO_WITNESS)
    assert result.counterexample.direction == {"tilt": "1", "b": "-g"}
    assert result.counterexample.trajectories is None
    assert [one.corrected for one in result.corrections] == ["tilt + 1/g*b"]


@pytest.mark.parametrize(
    ("claim", "verdicts"),
    [
        ("{at: nominal, rank: 2, basis: [v, 10*tilt + b]}", ["holds", "holds"]),
        ("{at: nominal, states: {d: unobservable, b: coupled}}", ["holds", "holds"]),
        ("{at: nominal, rank: 3}", ["fails"]),
        ("{at: nominal, observable: [d]}", ["fails"]),
        ("{at: {w: 0}, rank: 2, unobservable: [d]}", ["holds", "holds"]),
        ("{at: {w: 1}, rank: 3, observable: [d]}", ["holds", "holds"]),
        ("{at: {w: 1}, rank: 2, states: {d: unobservable}}", ["fails", "fails"]),
    ],
)
def test_at_values_the_gramian_is_that_of_these_values(checked, claim, verdicts):
    results = checked(CRITICAL + claim + "\n", *TIMES)

    assert [result.verdict for result in results] == verdicts
    for result in results:
        assert "no witness" not in result.reason
        assert (AGREES in result.reason) == (result.verdict == "holds")


def test_the_reason_for_the_lower_rank_is_the_value():
    system = read_text(CRITICAL + "rank: 3\n", "test.yaml").systems[0]
    at = analyze(system, FAST).at_values

    assert (at.rank, at.because) == (2, ("w = 0",))


def test_a_parameter_without_value_has_no_gramian_but_a_proof(checked):
    [result] = checked(CRITICAL.replace("w: 0", "w: null") + "rank: 3\n", *TIMES)

    assert result.verdict == "holds"
    assert result.reason.startswith("proved exactly; no Gramian: parameter without a value: w")


EXPECTED = """\
states: [x, v]
A: [[0, 1], [0, 0]]
H: [[1, 0]]
expect:
  - rank: 2
    observable: [v]
  - rank: 1
    unobservable: [v]
"""


def test_what_is_expected_holds_or_fails_as_claims_do_each_at_its_place(checked):
    results = checked(EXPECTED, *TIMES)

    assert [(one.claim, one.verdict, str(one.place)) for one in results] == [
        ("rank 2", "holds", "test.yaml:5:11"),
        ("v is observable", "holds", "test.yaml:6:18"),
        ("rank 1", "fails", "test.yaml:7:11"),
        ("v is not observable", "fails", "test.yaml:8:20"),
    ]
    assert results[2].reason == "the rank is 2; the Gramian shows 2 directions far above its tolerance"
    assert results[3].reason.startswith("it is an observable combination")


def test_expected_or_claimed_is_the_same_to_both_sides(checked):
    as_claims = EXPECTED.replace("expect:", "claims:")
    pairs = zip(checked(EXPECTED, *TIMES), checked(as_claims, *TIMES), strict=True)
    for expected, claimed in pairs:
        assert (expected.claim, expected.verdict, expected.reason) == (
            claimed.claim,
            claimed.verdict,
            claimed.reason,
        )


def test_an_undecided_analysis_is_what_these_tests_rest_on():
    system = read_text(OPAQUE + "rank: 2\n", "test.yaml").systems[0]
    assert isinstance(analyze(system, FAST), Undecided)


GROWING = """parameters: {alpha: 0.04, k: 2}
states: [x1, x2, x3, x4]
A: [[alpha, 1, 0, 0], [0, -alpha, 1, 0], [0, 0, 0, 0], [0, 0, 0, 0]]
H: [[1, 0, 0, k]]
claims:
  - """


def test_a_bound_near_one_lets_nothing_agree(checked):
    """χ is at most 1: over 2000 s x2 grows backwards by e^80, and anything may leak."""
    [wrong] = checked(GROWING + "observable: [x1 + 3*x4]\n", "2000")
    assert wrong.verdict == "fails"
    assert "the Gramian tells at no instant: its error hides what may leak" in wrong.reason
    [basis] = checked(GROWING + "{at: nominal, basis: [x1 + 3*x4, alpha*x1 + x2, alpha^2*x1 + x3]}\n", "2000")
    assert basis.verification.verdict == "undecided"
    assert basis.verification.reason == (
        "the error of the Gramian hides what may leak at every instant; others may tell"
    )
    assert not any(point.conclusive or point.agrees for point in basis.verification.points)


def test_true_at_the_files_values_only_is_explained(checked):
    """k is 2 in the file: x1 + 2 x4 is observable there, and nowhere else."""
    [result] = checked(GROWING + "observable: [x1 + 2*x4]\n", "20", "40")
    assert result.verdict == "fails"
    assert "; at the file's values, the Gramian agrees at 2 of 2 instants" in result.reason
    [there] = checked(GROWING + "{at: nominal, observable: [x1 + 2*x4]}\n", "20", "40")
    assert there.verdict == "holds"
