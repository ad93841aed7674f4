"""Where an experiment determines less, and parameters that are not the same in all runs."""

import pytest

from obscli.api import verify


LEVEL = """\
experiment:
  name: level
  runs:
    - {stage: [stage_1, stage_2, stage_3], grid: {omega: [omega, -omega]}}
"""
TWO_RATES = """\
parameters: {w: 1}
states: [a, b]
dynamics: {}
measurements: {y: a + w*b}
interval: {stop: 10}
"""


def conditions(found):
    return {one.condition: (one.kind, one.rank) for one in found.exact.special.drops}


# -- the paper's level runs


@pytest.fixture(scope="module")
def level(model, bare, calibrated):
    return calibrated(model(bare("ins_calibration/horizontal.yaml") + LEVEL), critical=True, only="analytic")


def test_a_table_at_rest_leaves_nine_of_level_runs(level):
    assert conditions(level)["omega = 0"] == ("confirmed", 9)


def test_the_pole_costs_level_runs_no_rank(level):
    """Each run by itself loses rank at cos(phi) = 0 (15 of 16); all together determine everything still."""
    assert not any("phi" in condition for condition in conditions(level))
    alone = level.exact.stack.runs[0].finding.critical
    assert any("phi" in one.condition for one in alone.values)


def test_claims_at_these_values_hold_and_no_others(model, bare):
    cases = [("{omega: 0}", 9), ("{phi: pi/2}", 21), ("nominal", 21)]
    asserted = [(at, rank + off) for at, rank in cases for off in (0, -1, 1)]
    claims = "".join(f"  - {{experiment: level, at: {at}, rank: {rank}}}\n" for at, rank in asserted)
    given = model(bare("ins_calibration/horizontal.yaml") + LEVEL + "claims:\n" + claims)

    assert [one.verdict for one in about(given)] == ["holds", "fails", "fails"] * 3


def about(given):
    """The results of the claims about the experiment, by both sides."""
    return [check for check in verify(given).results[-1].checks if check.place is not None]


# -- own symbols


@pytest.mark.parametrize(
    ("runs", "rank", "own"),
    [
        ("[{name: one}, {name: two}]", 1, ()),
        ("[{name: one}, {name: two, parameters: {w: 1}}]", 1, ()),
        ("[{name: one}, {name: two, parameters: {w: 2}}]", 2, (("w", "2", ("two",)),)),
        ("[{name: one, parameters: {w: 2}}, {name: two, parameters: {w: 2}}]", 1, None),
        ("[{name: one}, {name: two, fix: {w: -w}}]", 2, ()),
        (
            (
                "[{name: one}, {name: two, parameters: {w: 2}}, {name: three, parameters: {w: 3}},"
                " {name: again, parameters: {w: 2}}]"
            ),
            2,
            (("w", "2", ("two", "again")), ("w", "3", ("three",))),
        ),
    ],
)
def test_every_value_of_a_parameter_is_a_symbol_of_its_own(calibrated, runs, rank, own):
    found = calibrated(TWO_RATES + f"experiment: {{runs: {runs}}}\n")

    assert found.exact.rank == found.exact.at_file.rank == found.together.rank == rank
    if own is not None:
        assert tuple((one.of, one.value, one.runs) for one in found.exact.own) == own
    names = [one.name for one in found.exact.own]
    assert len(names) == len(set(names))
    assert not set(names) & {"w", "a", "b", "t"}


def test_own_symbols_take_no_name_of_the_file(calibrated):
    """w_2 is a state already."""
    text = TWO_RATES.replace("b", "w_2") + (
        "experiment: {runs: [{name: one}, {name: two, parameters: {w: 2}}]}\n"
    )
    found = calibrated(text)

    assert found.exact.rank == 2
    [own] = found.exact.own
    assert own.name not in {"w", "a", "w_2", "t"}


OWN = TWO_RATES + "experiment: {name: e, runs: [{name: one}, {name: two, parameters: {w: 2}}]}\n"


@pytest.mark.parametrize(("at", "rank"), [("{w: 0}", 1), ("{w: 3}", 1), ("nominal", 2), (None, 2)])
def test_a_claim_at_a_value_reaches_every_symbol_of_the_parameter(model, at, rank):
    where = f"at: {at}, " if at else ""
    claims = f"claims: [{{experiment: e, {where}rank: {rank}}}, {{experiment: e, {where}rank: {3 - rank}}}]\n"

    assert [one.verdict for one in about(model(OWN + claims))] == ["holds", "fails"]
    report = verify(model(OWN + claims))
    assert (report.failed, report.undecided) == (1, 0)


def test_that_two_symbols_are_equal_is_a_critical_condition(calibrated):
    found = calibrated(OWN, critical=True)
    drops = found.exact.special.drops

    assert [(one.kind, one.rank) for one in drops] == [("confirmed", 1)]
    assert sorted(drops[0].condition.split(" = ")) == ["w", found.exact.own[0].name]
    assert found.exact.special.complete


def test_a_condition_that_holds_at_the_files_values_is_the_reason_for_a_lower_rank(calibrated):
    found = calibrated(
        TWO_RATES.replace("w: 1", "w: 0")
        + "experiment: {runs: [{name: there}, {name: back, fix: {w: -w}}]}\n",
        critical=True,
    )

    assert (found.exact.rank, found.exact.at_file.rank, found.together.rank) == (2, 1, 1)
    assert found.exact.at_file.because == ("w = 0",)
    assert conditions(found) == {"w = 0": ("confirmed", 1)}
    assert {one.verdict for one in found.verifications} == {"verified"}


def test_at_a_special_value_what_is_fresh_may_hide_what_is_shared(calibrated):
    """At k = 1 the fresh x grows as exp(t)*a does."""
    text = """\
parameters: {k: 1}
states: [x, a, b]
dynamics: {x: k*x}
measurements: {y: x + exp(t)*a, z: b}
interval: {stop: 1}
experiment: {fresh: [x], runs: [{name: one}]}
"""
    found = calibrated(text, critical=True)
    assert (found.exact.rank, found.exact.at_file.rank, found.together.rank) == (2, 1, 1)
    assert conditions(found) == {"k = 1": ("confirmed", 1)}
    assert {one.verdict for one in found.verifications} == {"verified"}


def test_at_a_special_value_what_is_fresh_may_be_out_of_the_way(calibrated):
    """At k = 0 nothing of the fresh x is in y: a, which is hidden else, is determined there."""
    text = """\
parameters: {k: 0}
states: [x, a]
dynamics: {}
measurements: {y: k*x + a}
noise: {R: 1}
interval: {stop: 4}
experiment: {fresh: [x], runs: [{name: one}]}
"""
    found = calibrated(text, critical=True)
    assert (found.exact.rank, found.exact.at_file.rank, found.together.rank) == (0, 1, 1)
    assert found.accuracy.states[0].after == pytest.approx(0.5)
    assert {one.verdict for one in found.verifications} == {"verified"}
    assert found.exact.special.drops == ()
