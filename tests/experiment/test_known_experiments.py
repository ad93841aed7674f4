"""Experiments whose answer is known by construction, hidden, and found again by three routes."""

import random
from fractions import Fraction

import pytest

from obscli.api import verify


SEEDS = range(40)


def _fractions(covector, names):
    """A covector of rational coefficients as a row."""
    return [Fraction(getattr(covector.get(name), "value", 0)) for name in names]


@pytest.mark.parametrize("seed", SEEDS)
def test_the_known_answer_is_found_in_fractions(known, seed):
    """The construction itself, by Taylor series of every run and elimination of its fresh states."""
    experiment = known.build(seed)
    for run in experiment.runs:
        assert known.determined(run, experiment.p, experiment.q) == known.reduced(run.rows)


def test_stacking_without_eliminating_would_claim_more(known):
    """The columns of the constants alone, those of the fresh states dropped, are no answer: mostly too much."""
    wrong = 0
    for seed in SEEDS:
        experiment = known.build(seed)
        q = experiment.q
        rows = [row[q:] for run in experiment.runs for rows in run.H.values() for row in rows]
        wrong += known.rank(rows) > len(experiment.together())
    assert wrong > len(SEEDS) / 4


@pytest.mark.parametrize("seed", SEEDS)
def test_exact_and_numeric_side_find_the_known_answer(known, calibrated, seed):
    experiment = known.build(seed)
    found = calibrated(experiment.text())
    rows, finding = experiment.together(), found.exact.stack.finding
    after = [len(experiment.together(experiment.runs[: k + 1])) for k in range(len(experiment.runs))]

    assert found.exact.shared == tuple(experiment.names)
    assert finding.rank == found.exact.at_file.rank == found.together.rank == len(rows)
    assert found.after == tuple(after)
    assert [name for name, v in finding.states.items() if v == "observable"] == experiment.determined()
    assert [name for name, v in finding.states.items() if v == "unobservable"] == [
        name for j, name in enumerate(experiment.names) if not any(row[j] for row in rows)
    ]
    assert {one.verdict for one in found.verifications} == {"verified"}


@pytest.mark.parametrize("seed", SEEDS)
def test_combinations_and_directions_are_the_known_ones(known, calibrated, seed):
    experiment = known.build(seed)
    finding = calibrated(experiment.text(), only="analytic").exact.stack.finding
    combinations = [_fractions(one.coefficients, experiment.names) for one in finding.combinations]
    directions = [_fractions(one, experiment.names) for one in finding.unobservable]

    assert known.reduced(combinations) == experiment.together()
    assert known.reduced(directions) == known.reduced(known.kernel(experiment.together(), experiment.p))


@pytest.mark.parametrize("seed", SEEDS)
def test_every_run_determines_its_known_rows(known, calibrated, seed):
    experiment = known.build(seed)
    found = calibrated(experiment.text(), only="analytic")
    for run, one in zip(experiment.runs, found.runs, strict=True):
        rows = [_fractions(row, experiment.names) for row in one.rows.rows]
        assert known.reduced(rows) == known.reduced(run.rows)
        assert len(rows) == known.rank(rows)
    adds = [len(rows) for rows in found.exact.stack.adds]
    after = [len(experiment.together(experiment.runs[: k + 1])) for k in range(len(experiment.runs))]
    assert [sum(adds[: k + 1]) for k in range(len(adds))] == after


def _sum(row, names):
    return " + ".join(f"({x})*{name}" for x, name in zip(row, names, strict=True) if x)


def _claims(known, experiment, rank):
    """The known answer as a claim: rank, basis, states and directions."""
    names, rows = experiment.names, experiment.together()
    directions = [
        ", ".join(f"{name}: {x}" for x, name in zip(one, names, strict=True) if x)
        for one in known.kernel(rows, len(names))
    ]
    return (
        f"claims:\n  - experiment: hidden\n    rank: {rank}\n"
        f"    basis: [{', '.join(_sum(row, names) for row in rows)}]\n"
        f"    determined: [{', '.join(experiment.determined())}]\n"
        f"    directions: [{', '.join(f'{{{one}}}' for one in directions)}]\n"
    )


@pytest.mark.parametrize("seed", SEEDS[::4])
@pytest.mark.parametrize("more", [0, 1])
def test_verify_confirms_the_known_answer_and_no_other(known, model, seed, more):
    experiment = known.build(seed)
    rank = len(experiment.together())
    text = experiment.text().replace("experiment:\n", "experiment:\n  name: hidden\n")
    report = verify(model(text + _claims(known, experiment, rank + more)))

    assert (report.failed, report.undecided) == (more, 0)


def _of_runs(found, experiment):
    return {run.run.name: [_fractions(row, experiment.names) for row in run.rows.rows] for run in found.runs}


@pytest.mark.parametrize("seed", SEEDS[::2])
def test_the_order_of_runs_does_not_matter(known, calibrated, seed):
    experiment = known.build(seed)
    order = random.Random(seed).sample(experiment.runs, len(experiment.runs))
    here, there = (calibrated(experiment.text(runs)) for runs in (experiment.runs, order))

    assert here.exact.rank == there.exact.rank == there.together.rank
    assert here.exact.stack.finding.states == there.exact.stack.finding.states
    assert _of_runs(here, experiment) == _of_runs(there, experiment)
    for one, other in zip(*(f.exact.stack.finding.unobservable for f in (here, there)), strict=True):
        assert _fractions(one, experiment.names) == _fractions(other, experiment.names)
    assert {one.verdict for one in there.verifications} == {"verified"}


@pytest.mark.parametrize("seed", SEEDS[::4])
def test_a_run_done_again_adds_nothing_to_the_rank(known, calibrated, seed):
    experiment = known.build(seed)
    again = experiment.text(entry=lambda run: f"{{stage: {run.name}, repeat: 2}}")
    found = calibrated(again)

    assert found.exact.rank == found.together.rank == len(experiment.together())
    assert all(not rows for rows in found.exact.stack.adds[1::2])
    assert found.after[1::2] == found.after[::2]


@pytest.mark.parametrize("seed", SEEDS[::4])
def test_runs_by_name_are_an_experiment_of_their_own(known, calibrated, seed):
    experiment = known.build(seed)
    some = experiment.runs[1:]
    found = calibrated(experiment.text(), *(run.name for run in reversed(some)))

    assert [run.run.name for run in found.runs] == [run.name for run in some]
    assert found.exact.rank == found.together.rank == len(experiment.together(some))


@pytest.mark.parametrize("seed", SEEDS[::3])
def test_units_by_powers_of_two_change_nothing(known, calibrated, seed):
    """States from 2^-13 to 2^13 of what they were: ranks, verdicts, and that both sides agree."""
    experiment, source = known.build(seed), random.Random(seed)
    units = [source.randint(-13, 13) for _ in range(experiment.p + experiment.q)]
    plain, found = (calibrated(experiment.text(units=one)) for one in (None, units))

    assert found.exact.rank == found.together.rank == plain.exact.rank
    assert found.exact.stack.finding.states == plain.exact.stack.finding.states
    assert found.after == plain.after
    assert {one.verdict for one in found.verifications} == {"verified"}


@pytest.mark.parametrize("driven", [False, True])
@pytest.mark.parametrize("seed", SEEDS[1::4])
def test_deviations_are_in_the_units_of_the_states(known, calibrated, seed, driven):
    """A prior of some states, driven fresh ones or not: x = 2^e x_new, so σ = 2^e σ_new."""
    experiment, source = known.build(seed), random.Random(seed)
    names = [*(f"x{i + 1}" for i in range(experiment.q)), *experiment.names]
    units = [source.randint(-13, 13) for _ in names]
    priors = {name: source.choice(["1", "3", "1/4"]) for name in names if source.random() < 0.5}

    def deviations(e):
        given = ", ".join(
            f"{name}: ({priors[name]})*2^({-e[k]})" for k, name in enumerate(names) if name in priors
        )
        drive = f", Q: {{x1: 2^({-4 - 2 * e[0]})}}" if driven else ""
        found = calibrated(
            experiment.text(more=f"noise: {{R: 1/64, P0_std: {{{given}}}{drive}}}\n", units=e)
            if given
            else experiment.text(more=f"noise: {{R: 1/64{drive}}}\n", units=e)
        )
        assert found.accuracy is not None, found.no_accuracy
        return [one.after for one in found.accuracy.states]

    plain, other = deviations([0] * len(names)), deviations(units)
    assert other == pytest.approx(
        [one * 2.0**-e for one, e in zip(plain, units[experiment.q :], strict=True)], rel=1e-5
    )
