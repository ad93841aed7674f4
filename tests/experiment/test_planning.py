"""Which runs to make, and how long: shared states, what is forbidden, rankings, durations, suggestions."""

import random
from itertools import product

import numpy as np
import pytest

from obscli.experiment.durations import shortest
from obscli.pipelines.request import RequestError


# -- what the candidates share


MOVING = """\
states: [x, c, d]
let: {k: 0, on: 1}
dynamics: {x: k*d}
measurements: {y: x + on*c}
interval: {stop: 100}
"""
CANDIDATES = "plan:\n  candidates: [{name: with_c, let: {k: 1}}, {name: without_c, let: {k: 1, on: 0}}]\n"


@pytest.mark.parametrize(
    "experiment",
    ["", "experiment: {runs: [{name: with_c, let: {k: 1}}, {name: without_c, let: {k: 1, on: 0}}]}\n"],
)
def test_the_candidates_say_what_is_shared_and_no_stage_does(planned, experiment):
    """In the base model x stands still as well; in the candidates d drives it, and c hides behind it."""
    found = planned(MOVING + experiment + CANDIDATES)

    assert (found.plan.shared, found.plan.fresh) == (("c", "d"), ("x",))
    assert (found.plan.found.rank, found.plan.found.size) == (1, 1)
    assert sorted(found.plan.found.sets) == [(0,), (1,)]
    assert found.verification.verdict == "verified"


def test_where_there_are_only_stages_each_is_a_candidate(planned):
    stages = "stages: {with_c: {let: {k: 1}}, without_c: {let: {k: 1, on: 0}}}\n"
    found = planned(MOVING + stages)

    assert found.is_default
    assert [run.name for run in found.plan.runs] == ["test", "with_c", "without_c"]
    assert (found.plan.shared, found.plan.fresh) == (("c", "d"), ("x",))


# -- sets


LINES = """\
parameters: {{w: 1}}
states: [a, b, c]
dynamics: {{}}
measurements: {{y: p*a + q*b + r*c}}
let: {{p: 0, q: 0, r: 0}}
noise: {{R: 1{prior}}}
interval: {{stop: 100}}
{more}plan:
  setup_time: 10
  candidates:
"""
ROWS = {"a": (1, 0, 0), "b": (0, 1, 0), "c": (0, 0, 1), "ab": (1, 1, 0), "abc": (1, 1, 1)}


def lines(rows=ROWS, prior="", more="", forbidden=""):
    """A model whose candidates measure one row of whole numbers each."""
    text = LINES.format(prior=prior, more=more)
    for name, (p, q, r) in rows.items():
        text += f"    - {{name: {name}, let: {{p: {p}, q: {q}, r: {r}}}}}\n"
    return text + (f"  forbidden: {forbidden}\n" if forbidden else "")


def names(found, runs):
    return tuple(found.plan.runs[k].name for k in runs)


def sets(found):
    return {frozenset(names(found, runs)) for runs in found.plan.found.sets}


def test_all_smallest_sets_are_found(planned):
    found = planned(lines())

    bases = {frozenset(s) for s in ("a b c", "a b abc", "a c ab", "a c abc", "b c ab", "b c abc", "c ab a",
                                    "a ab abc", "b ab abc") for s in [s.split()]}  # fmt: skip
    assert sets(found) == bases
    assert (found.plan.found.rank, found.plan.found.exhaustive) == (3, True)
    assert found.plan.chosen.duration == 330
    assert found.verification.verdict == "verified"


@pytest.mark.parametrize(
    ("forbidden", "gone", "rank"),
    [
        ("[a]", lambda s: "a" in s, 3),
        ("[[a, b]]", lambda s: s >= {"a", "b"}, 3),
        ("[a, [b, ab]]", lambda s: "a" in s or s >= {"b", "ab"}, 3),
        ("[c, abc]", lambda s: s & {"c", "abc"}, 2),
        ("[[c, abc], abc, c]", lambda s: s & {"c", "abc"}, 2),
    ],
)
def test_what_is_forbidden_is_not_chosen(planned, forbidden, gone, rank):
    free, found = planned(lines()), planned(lines(forbidden=forbidden))

    assert found.plan.found.rank == rank
    assert not any(gone(one) for one in sets(found))
    if rank == 3:
        assert sets(found) == {one for one in sets(free) if not gone(one)}
    else:
        assert sets(found) == {frozenset(s) for s in ({"a", "b"}, {"a", "ab"}, {"b", "ab"})}
    assert found.verification.verdict == "verified"


def test_everything_forbidden_is_refused(planned):
    with pytest.raises(RequestError, match="all are forbidden"):
        planned(lines(forbidden="[a, b, c, ab, abc]"))


def test_candidates_by_name(planned):
    found = planned(lines(forbidden="[[a, b]]"), "abc", "a", "ab")

    assert [run.name for run in found.plan.runs] == ["a", "ab", "abc"]
    assert sets(found) == {frozenset({"a", "ab", "abc"})}


@pytest.mark.parametrize("name", ["d", "A", ""])
def test_a_candidate_that_is_not_there_is_refused(planned, name):
    with pytest.raises(RequestError, match="no run"):
        planned(lines(), name)


# -- accuracy of plans


def full(found):
    return found.plan.informed


def variances(told, parts):
    """Deviations of what is required by direct inversion; parts: run and index of the instant."""
    information = told.prior.T @ told.prior
    for k, j in parts:
        root = told.runs[k].roots[j]
        information = information + root.T @ root
    covariance = np.linalg.inv(information)
    return np.sqrt(np.einsum("ki,ij,kj->k", told.covectors, covariance, told.covectors))


def margin(told, parts):
    asked = np.array([value for _, value in told.required])
    return (asked / variances(told, parts)).min()


PRIOR = ", P0_std: {a: 100, b: 100, c: 100}"


def test_the_ranking_goes_by_what_is_met_then_by_time(planned):
    """b is asked for most: the sets that measure it by itself come first, and end earlier."""
    found = planned(lines(prior=PRIOR, more="require: {a: 0.3, b: 0.11, c: 0.3}\n"))
    told = full(found)

    for one in found.plan.ranked:
        assert one.margin == pytest.approx(margin(told, [(k, -1) for k in one.runs]), rel=1e-6)
        assert one.is_met == (one.margin >= 1)
        assert one.duration == 330
    met = [one for one in found.plan.ranked if one.is_met]
    assert met == list(found.plan.ranked[: len(met)])
    assert 0 < len(met) < len(found.plan.ranked)
    assert [one.needed for one in met] == sorted(one.needed for one in met)
    missed = found.plan.ranked[len(met) :]
    assert [one.margin for one in missed] == sorted((one.margin for one in missed), reverse=True)
    assert all("b" in names(found, one.runs) for one in met)
    assert not found.failed
    assert found.plan.extended is None


def test_more_runs_are_made_where_the_smallest_set_is_not_enough(planned):
    """Three runs leave 0.1 or more."""
    found = planned(lines(prior=PRIOR, more="require: {a: 0.08, b: 0.08, c: 0.08}\n"))
    told, chosen = full(found), found.plan.extended

    assert not any(one.is_met for one in found.plan.ranked)
    assert chosen is found.plan.chosen
    assert margin(told, [(k, -1) for k in chosen.runs]) >= 1
    assert len(chosen.runs) > 3
    assert all(one.is_met for one in found.accuracy.required)
    assert not found.failed
    for k in range(len(chosen.runs)):  # none of them could be spared
        rest = [(j, -1) for j in (*chosen.runs[:k], *chosen.runs[k + 1 :])]
        assert margin(told, rest) < 1


def test_more_runs_keep_to_what_is_forbidden(planned):
    more = "require: {a: 0.12, b: 0.09, c: 0.09}\n"
    found = planned(lines(prior=PRIOR, more=more, forbidden="[a, [b, ab]]"))

    assert found.plan.extended
    chosen = set(names(found, found.plan.chosen.runs))
    assert "a" not in chosen
    assert not chosen >= {"b", "ab"}


def test_what_no_plan_can_meet_fails(planned):
    """Nothing sees c: its prior is all there is."""
    rows = {name: row for name, row in ROWS.items() if "c" not in name}
    found = planned(lines(rows, prior=PRIOR, more="require: {a: 1, c: 1}\n"))

    assert found.failed
    assert found.plan.found.rank == 2
    assert [one.name for one in found.accuracy.required if not one.is_met] == ["c"]


def test_what_has_neither_prior_nor_measurement_stays_infinite(planned):
    rows = {name: row for name, row in ROWS.items() if "c" not in name}
    found = planned(lines(rows, more="require: {a: 1, c: 1e9}\n"))

    required = {one.name: one for one in found.accuracy.required}
    assert found.failed
    assert required["c"].after == np.inf
    assert required["a"].is_met


# -- durations


def random_lines(seed):
    """Three candidates of random rows, and requirements that full length meets by 1.2 to 3."""
    source = random.Random(seed)
    rows = {f"r{k}": tuple(source.choice([-2, -1, 0, 1, 2]) for _ in range(3)) for k in range(4)}
    return lines(rows, prior=PRIOR, more="require: {a: 1, b: 1, c: 1}\n"), source.uniform(1.2, 3)


@pytest.fixture(scope="module", params=range(8))
def searched(request, planned):
    """What random candidates tell, with requirements all of them together meet, and the durations found."""
    from dataclasses import replace

    text, slack = random_lines(request.param)
    told = full(planned(text))
    runs = range(len(told.runs))
    after = variances(told, [(k, -1) for k in runs])
    asked = tuple((name, slack * float(one)) for (name, _), one in zip(told.required, after, strict=True))
    told = replace(told, required=asked)
    return told, runs, shortest(told, runs)


def ends(told, found):
    """The indices of the instants at which runs end."""
    return [
        (k, int(np.flatnonzero(np.isclose(one.elapsed, duration))[0]))
        for k, (one, duration) in enumerate(zip(told.runs, found.durations, strict=True))
    ]


def test_the_shortest_durations_meet_the_requirements(searched):
    told, _, found = searched
    assert margin(told, ends(told, found)) >= 1 - 1e-9
    assert found.total == pytest.approx(sum(found.durations))


def test_no_single_run_can_end_an_instant_earlier(searched):
    told, _, found = searched
    parts = ends(told, found)
    for place, (k, j) in enumerate(parts):
        if j:
            earlier = [*parts[:place], (k, j - 1), *parts[place + 1 :]]
            assert margin(told, earlier) < 1


def test_no_shorter_total_than_the_best_of_all(searched):
    """All pairs of ends of the first two runs, the others at the ends found."""
    told, _, found = searched
    parts = ends(told, found)
    rest = parts[2:]
    better = [
        told.runs[0].elapsed[i] + told.runs[1].elapsed[j]
        for i, j in product(range(len(told.runs[0].elapsed)), range(len(told.runs[1].elapsed)))
        if margin(told, [(0, i), (1, j), *rest]) >= 1
    ]
    assert min(better) > 0
    assert sum(found.durations[:2]) >= min(better) - 1e-9


def test_no_durations_where_full_length_is_not_enough(searched):
    from dataclasses import replace

    told, runs, _ = searched
    after = variances(told, [(k, -1) for k in runs])
    below = tuple((name, 0.99 * float(one)) for (name, _), one in zip(told.required, after, strict=True))
    assert shortest(replace(told, required=below), runs) is None
    exactly = tuple((name, 1.001 * float(one)) for (name, _), one in zip(told.required, after, strict=True))
    assert shortest(replace(told, required=exactly), runs) is not None
    assert shortest(replace(told, required=()), runs) is None


def test_the_plan_takes_no_longer_than_it_has_to(planned):
    """One state, R = 1: 100 s give 0.1, so 0.2 takes 25 s, a fortieth of the run more or less."""
    found = planned(
        "states: [a]\ndynamics: {}\nmeasurements: {y: a}\nnoise: {R: 1}\ninterval: {stop: 100}\n"
        "require: {a: 0.2001}\nexperiment: {runs: [{name: one}]}\nplan: {setup_time: 5}\n"
    )
    chosen = found.plan.chosen
    assert chosen.shortest.durations == (25.0,)
    assert (chosen.needed, chosen.duration) == (30.0, 105.0)
    assert found.accuracy.required[0].after == pytest.approx(0.2)
    assert found.accuracy.required[0].is_met
    assert found.accuracy.history.ends == (25.0,)


# -- suggestions


def test_turning_the_unit_over_is_suggested_where_the_axis_is_vertical(planned, bare):
    runs = "experiment: {runs: [stage_1, stage_2, stage_3]}\n"
    found = planned(bare("ins_calibration/vertical.yaml") + runs)

    assert (found.plan.found.rank, len(found.plan.shared)) == (18, 21)
    over = [one for one in found.plan.suggestions if "half a turn" in one.words]
    assert over
    assert {one.rank for one in over} == {21}
    assert [one.rank for one in found.plan.suggestions] == sorted(
        (one.rank for one in found.plan.suggestions), reverse=True
    )
    assert {one.words for one in found.plan.suggestions} <= set(found.plan.tried)


def test_the_other_way_round_is_suggested_where_one_way_is_not_enough(planned):
    text = (
        "parameters: {w: 2}\nstates: [b, m]\ndynamics: {}\nmeasurements: {y: b + w*m}\ninterval: {stop: 9}\n"
    )
    found = planned(text + "experiment: {runs: [{name: there}]}\n")

    assert found.plan.found.rank == 1
    assert any(one.rank == 2 and one.words.startswith("w ") for one in found.plan.suggestions)


def test_nothing_is_suggested_where_all_is_determined(planned):
    found = planned(lines())
    assert (found.plan.suggestions, found.plan.tried) == ((), ())


def test_nothing_helps_where_a_state_is_in_no_output(planned):
    text = "parameters: {w: 2}\nstates: [b, m]\ndynamics: {}\nmeasurements: {y: w*b}\ninterval: {stop: 9}\n"
    found = planned(text + "experiment: {runs: [{name: there}]}\n")

    assert found.plan.suggestions == ()
    assert found.plan.tried
