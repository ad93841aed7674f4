"""A basis altered by hand is told from a right one: exactly, and by the Gramian alone.

The bases of all bundled models are mutated at random, with a seed: a sign flipped, a term dropped or changed
by one percent, a row dropped or added, and row operations that leave the space as it is, time-varying ones
among them. Whatever changes the row space exactly must be caught, the right row named, and where the change
is one coefficient the smallest correction has to undo it; whatever does not must be called equivalent.
"""

import random
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import pytest

from obscli.checks.claims import check_claims
from obscli.core.place import Place
from obscli.exact.analysis import contained
from obscli.model.expression import Apply, Symbol, add, multiply, number
from obscli.model.notation import covector_text
from obscli.model.reader import load
from obscli.model.system import Claim, Quantity


MODELS = Path(__file__).parents[2] / "models"
HERE = Place("mutation", 1, 1)
PERCENT = number(Fraction(101, 100))
#: Bases of more coefficients are sampled: so many draws; so many coefficients of each row, each altered once.
MOST, DRAWS, COEFFICIENTS = 40, 1, 2


def _deficient():
    """The stages of a rank below n and above 0, and the same at the file's values as for generic ones."""
    wanted = []
    for file in sorted(MODELS.glob("**/*.yaml")):
        for system in load(file).systems:
            claimed = [c.rank for c in system.claims if c.rank is not None and c.at is None]
            if claimed and 0 < claimed[0] < system.n:
                name = file.relative_to(MODELS).as_posix()
                wanted.append(pytest.param((name, system.stage), id=f"{file.stem}-{system.stage or 'base'}"))
    return wanted


def _is_large(rows):
    return sum(map(len, rows)) > MOST


def _claim(rows):
    return Claim("claims", HERE, basis=tuple(Quantity(f"row {k}", row, HERE) for k, row in enumerate(rows)))


def _checked(system, analysis, numeric, rows):
    [result] = check_claims(replace(system, claims=(_claim(rows),)), analysis, lambda _: numeric)
    return result


def _bent(row, state, factor):
    return {**row, state: multiply(factor, row[state])}


def _mutations(rows, system, source):
    """Yield (name, rows, index of the row that is changed or None), each a draw."""
    k = source.randrange(len(rows))
    long = [j for j, row in enumerate(rows) if len(row) > 1]
    if long:
        j = source.choice(long)
        state = source.choice(sorted(rows[j]))
        yield "sign", [*rows[:j], _bent(rows[j], state, number(-1)), *rows[j + 1 :]], j
        yield "one percent", [*rows[:j], _bent(rows[j], state, PERCENT), *rows[j + 1 :]], j
        rest = {s: e for s, e in rows[j].items() if s != state}
        yield "term dropped", [*rows[:j], rest, *rows[j + 1 :]], j
    other = source.choice([name for name in system.state_names if name not in rows[k]] or [None])
    if other:
        size = next(iter(rows[k].values()))  # a row may be scaled by numbers beyond which 1 is rounding
        yield "term added", [*rows[:k], {**rows[k], other: size}, *rows[k + 1 :]], k
    yield "row dropped", [*rows[:k], *rows[k + 1 :]], None
    yield "row added", [*rows, {source.choice(system.state_names): number(1)}], None
    yield "row doubled", [*rows, rows[k]], None
    yield "permuted", source.sample(rows, len(rows)), None
    yield (
        "scaled",
        [*rows[:k], {s: multiply(number(-3), e) for s, e in rows[k].items()}, *rows[k + 1 :]],
        None,
    )
    if len(rows) > 1:
        a, b = source.sample(range(len(rows)), 2)
        factor = source.choice([number(2), Symbol(system.time), Apply("cos", Symbol(system.time))])
        mixed = dict(rows[a])
        for s, e in rows[b].items():
            mixed[s] = add(mixed[s], multiply(factor, e)) if s in mixed else multiply(factor, e)
        yield "row operation", [*rows[:a], mixed, *rows[a + 1 :]], None


def _changes_the_space(analysis, rows, size):
    """Whether rows are not a basis of the space: decided by the annihilation of the kernel and their number."""
    return len(rows) != size or not all(contained(analysis, rows))


@pytest.mark.parametrize("which", _deficient())
def test_every_mutation_is_judged_right(bundled, which):
    system, analysis, numeric = bundled(*which)
    rows = [c.coefficients for c in analysis.combinations]
    changed = kept = 0
    for seed in range(DRAWS if _is_large(rows) else 6):
        for name, mutated, row in _mutations(rows, system, random.Random(seed)):
            result = _checked(system, analysis, numeric, mutated)
            if not _changes_the_space(analysis, mutated, len(rows)):
                kept += 1
                assert result.verdict == "holds", (name, result.reason)
                assert result.gramian.agree == result.gramian.of > 0, (name, result.gramian)
                continue
            changed += 1
            assert result.verdict == "fails", name
            assert result.gramian.agree < result.gramian.of, (name, result.gramian)
            if row is not None:
                _the_right_row_is_named(result, f"row {row}", name)
    assert changed
    assert kept


def _the_right_row_is_named(result, row, mutation):
    """Exactly, in the corrections and among the χ indicators: this row and no other."""
    assert f"{row} is not observable" in result.reason, mutation
    assert {change.of for change in result.corrections} == {row}, mutation
    leaking = {one.expression for one in result.verification.combinations if one.holds is False}
    assert leaking <= {row}, mutation


@pytest.mark.parametrize("which", _deficient())
def test_one_changed_coefficient_is_found_and_corrected(bundled, which):
    """The original row is among the smallest corrections, each of which is observable and as small."""
    system, analysis, numeric = bundled(*which)
    states = system.state_names
    tried, source = 0, random.Random(1)
    is_large = _is_large([c.coefficients for c in analysis.combinations])
    for c in analysis.combinations:
        row = c.coefficients
        altered = source.sample(sorted(row), min(COEFFICIENTS, len(row))) if is_large else row
        for state in altered if len(row) > 1 else ():
            rest = {s: e for s, e in row.items() if s != state}
            wrongs = [_bent(row, state, PERCENT), _bent(row, state, number(-1)), rest]
            for wrong in source.sample(wrongs, 1) if is_large else wrongs:
                if contained(analysis, [wrong])[0]:
                    continue
                tried += 1
                claim = Claim("claims", HERE, observable=(Quantity("wrong", wrong, HERE),))
                [result] = check_claims(replace(system, claims=(claim,)), analysis, lambda _: numeric)
                assert result.verdict == "fails"
                assert result.corrections
                texts = {one.corrected for one in result.corrections}
                assert covector_text(row, states) in texts, (covector_text(wrong, states), texts)
    assert tried or all(len(c.coefficients) == 1 for c in analysis.combinations)


def test_the_gramian_alone_sees_even_the_smallest_term(stage_2):
    """Dropping omega_ie sin(phi)/g b_a2 gives χ of 2e-6 only, one percent of it 2e-8: both far above the bound."""
    system, analysis, numeric = stage_2
    k = next(k for k, c in enumerate(analysis.combinations) if "psi3" in c.coefficients)
    row = analysis.combinations[k].coefficients
    rows = [c.coefficients for c in analysis.combinations]
    for factor, least, most in ((None, 1e-6, 4e-6), (Fraction(99, 100), 1e-8, 4e-8)):
        wrong = {s: e for s, e in row.items() if s != "b_a2"}
        if factor is not None:
            wrong = _bent(row, "b_a2", number(factor))
        result = _checked(system, analysis, numeric, [*rows[:k], wrong, *rows[k + 1 :]])
        leak = next(one for one in result.verification.combinations if one.holds is False)
        assert least < leak.chi < most
        assert leak.chi > 10 * leak.bound
