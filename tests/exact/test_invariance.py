"""What is observable does not depend on how the system is written down."""

import random
from dataclasses import replace
from pathlib import Path

import pytest

from obscli.exact.analysis import Options, analyze, contained
from obscli.model.covector import parse_covector
from obscli.model.expression import ZERO, add, multiply, number
from obscli.model.reader import load
from obscli.model.system import Matrix


MODELS = Path(__file__).parents[2] / "models"
FAST = Options(critical=False, certificate=False)
FILES = ["textbook/mixed_coefficients.yaml", "textbook/ins_velocity_aiding.yaml", "textbook/attitude_quaternion.yaml",
         "textbook/frozen_observable.yaml", "kortunov/single_channel.yaml", "bagmut/horizontal_channel.yaml",
         "ins_calibration/stage_1_sparse.yaml", "textbook/levelling.yaml"]  # fmt: skip
SYSTEMS = [pytest.param(s, id=f"{Path(f).stem}-{s.stage}") for f in FILES for s in load(MODELS / f).systems]


def _permuted(system, order):
    """The same system with state order[k] in place k."""
    place = {old: new for new, old in enumerate(order)}
    A = Matrix(system.n, system.n, {(place[i], place[j]): e for (i, j), e in system.A.entries.items()})
    H = Matrix(system.m, system.n, {(i, place[j]): e for (i, j), e in system.H.entries.items()})
    return replace(system, states=tuple(system.states[k] for k in order), A=A, H=H)


def _product(left, right):
    """A product of sparse matrices of expressions."""
    entries = {}
    for (i, k), a in left.items():
        for (l, j), b in right.items():
            if k == l:
                entries[i, j] = add(entries.get((i, j), ZERO), multiply(a, b))
    return entries


def _changed(system, source):
    """The same system in states z, x = T z, T a product of constant shears; and T."""
    n = system.n
    T = {(k, k): number(1) for k in range(n)}
    inverse = dict(T)
    for _ in range(3):
        i, j = source.sample(range(n), 2)
        factor = source.choice([1, -2, 3])
        shear = {**{(k, k): number(1) for k in range(n)}, (i, j): number(factor)}
        T = _product(T, shear)
        inverse = _product({**shear, (i, j): number(-factor)}, inverse)
    A = Matrix(n, n, _product(_product(inverse, system.A.entries), T))
    H = Matrix(system.m, n, _product(system.H.entries, T))
    return replace(system, A=A, H=H, quantities=(), claims=()), T


def _covector_times(covector, system, T):
    index = {name: j for j, name in enumerate(system.state_names)}
    row = _product({(0, index[s]): e for s, e in covector.items()}, T)
    return {system.state_names[j]: e for (_, j), e in row.items()}


@pytest.mark.parametrize("system", SYSTEMS)
def test_permuting_the_states_changes_nothing(system):
    plain = analyze(system, FAST)
    order = list(range(system.n))
    random.Random(system.n).shuffle(order)
    other = analyze(_permuted(system, order), FAST)
    assert (other.rank, other.order, other.frozen_rank) == (plain.rank, plain.order, plain.frozen_rank)
    assert dict(other.states) == dict(plain.states)
    assert {frozenset(g) for g in other.groups} == {frozenset(g) for g in plain.groups}
    assert other.at_values.rank == plain.at_values.rank
    assert {q.name: q.verdict for q in other.quantities} == {q.name: q.verdict for q in plain.quantities}
    assert all(contained(other, [c.coefficients for c in plain.combinations]))


@pytest.mark.parametrize("system", SYSTEMS)
def test_the_order_of_pivots_changes_the_form_and_nothing_else(system):
    plain = analyze(system, FAST)
    names = system.state_names[::-1]
    other = analyze(system, replace(FAST, pivot_order=names))
    assert (other.rank, other.order) == (plain.rank, plain.order)
    assert dict(other.states) == dict(plain.states)
    assert set(other.groups) == set(plain.groups)
    assert all(contained(other, [c.coefficients for c in plain.combinations]))
    assert all(contained(plain, [c.coefficients for c in other.combinations]))


@pytest.mark.parametrize("system", SYSTEMS)
def test_a_constant_change_of_states_transforms_the_row_space(system):
    plain = analyze(system, FAST)
    changed, T = _changed(system, random.Random(system.n + 1))
    other = analyze(changed, FAST)
    assert (other.rank, other.order, other.frozen_rank) == (plain.rank, plain.order, plain.frozen_rank)
    assert all(contained(other, [_covector_times(c.coefficients, system, T) for c in plain.combinations]))


@pytest.mark.parametrize("system", SYSTEMS)
def test_a_sparse_basis_spans_the_same_space_with_no_more_states(system):
    plain = analyze(system, FAST)
    sparse = analyze(system, replace(FAST, basis="sparse"))
    assert len(sparse.combinations) == plain.rank
    assert all(contained(plain, [c.coefficients for c in sparse.combinations]))
    assert sum(len(c.coefficients) for c in sparse.combinations) <= sum(
        len(c.coefficients) for c in plain.combinations
    )
    assert dict(sparse.states) == dict(plain.states)


@pytest.mark.parametrize("system", SYSTEMS)
def test_a_preferred_basis_is_completed_to_the_same_space(system):
    plain = analyze(system, FAST)
    # reversed, one row twice, and one row that is not observable (a hidden state, where there is one)
    own = [parse_covector(system, name, "preferred") for name in system.state_names]
    texts = [replace(own[0], coefficients=c.coefficients) for c in plain.combinations[::-1][:3]]
    found = analyze(system, replace(FAST, basis=(*texts, texts[0], *own)))
    assert len(found.combinations) == plain.rank
    assert all(contained(plain, [c.coefficients for c in found.combinations]))
    unseen = sum(verdict != "observable" for verdict in plain.states.values())
    assert sum("not observable" in note for note in found.notes) == unseen
    from obscli.checks.certificate import check_certificate

    proved = analyze(system, Options(critical=False, basis=(*texts, texts[0], *own)))
    checked = check_certificate(system, proved.certificate, [c.coefficients for c in proved.combinations])
    assert checked.verdict == "holds", checked.reason


@pytest.mark.parametrize("system", SYSTEMS)
def test_repeating_or_mixing_outputs_changes_nothing(system):
    plain = analyze(system, FAST)
    rows = {i: {j: e for (k, j), e in system.H.entries.items() if k == i} for i in range(system.m)}
    doubled = dict(system.H.entries)
    for j in range(system.n):
        parts = [multiply(number(k + 1), row[j]) for k, row in rows.items() if j in row]
        if parts:
            doubled[system.m, j] = add(*parts)
    extra = replace(system.outputs[0], name="mixture")
    H = Matrix(system.m + 1, system.n, doubled)
    other = analyze(replace(system, outputs=(*system.outputs, extra), H=H), FAST)
    assert (other.rank, other.order, dict(other.states)) == (plain.rank, plain.order, dict(plain.states))


@pytest.mark.parametrize("system", SYSTEMS)
def test_each_combination_is_first_yielded_no_later_than_saturation(system):
    plain = analyze(system, FAST)
    assert max(c.order for c in plain.combinations) == plain.order
    assert {c.output for c in plain.combinations} <= {o.name for o in system.outputs}
