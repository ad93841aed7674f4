"""Systems in new variables: identities in rational numbers, and a verification that is not blind."""

import importlib.util
import random
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import pytest
from flint import fmpq, fmpq_mat

from obscli.exact.dropped import drop_unobservable
from obscli.exact.prove import prove
from obscli.exact.reduced import in_variables
from obscli.exact.reproduction import reproduction
from obscli.exact.transformed import transformed_system
from obscli.model.expression import add, number
from obscli.model.library import bundled_models
from obscli.model.reader import load, read_text
from obscli.model.variables import variable_names
from obscli.model.write import write_model


_spec = importlib.util.spec_from_file_location("known", Path(__file__).with_name("known.py"))
known = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(known)


def reduced(system):
    """Return the observable combinations and the system in them, as its file reads."""
    proof = prove(system, range(system.n))
    coordinates = in_variables(system, proof.echelon, range(system.n))
    made, notes = transformed_system(coordinates)
    return coordinates, read_text(write_model(made), "made.yaml").systems[0], notes


def dense(matrix):
    return fmpq_mat(
        matrix.rows,
        matrix.columns,
        [rational(matrix.entries.get((i, j))) for i in range(matrix.rows) for j in range(matrix.columns)],
    )


def rational(entry):
    return fmpq(0) if entry is None else fmpq(entry.value.numerator, entry.value.denominator)


def forms_matrix(coordinates):
    names = coordinates.system.state_names
    rows = [[rational(form.get(name)) for name in names] for form in coordinates.forms]
    return fmpq_mat(len(rows), len(names), [entry for row in rows for entry in row])


def observability(A, H):
    rows, level = [], H
    for _ in range(A.nrows()):
        rows += level.table()
        level = level * A
    return fmpq_mat(len(rows), A.nrows(), [entry for row in rows for entry in row])


def random_system(source):
    """A system of rational numbers with hidden states: block triangular, in other coordinates."""
    n, seen, m = source.randint(2, 7), source.randint(1, 4), source.randint(1, 2)
    seen = min(seen, n)
    entry = lambda wanted: fmpq(source.choice([0, 0, 1, -1, 2]) if wanted else 0)  # noqa: E731
    A = fmpq_mat(n, n, [entry(i >= seen or j < seen) for i in range(n) for j in range(n)])
    H = fmpq_mat(m, n, [entry(j < seen) for _ in range(m) for j in range(n)])
    T = fmpq_mat(n, n, [fmpq(i == j) for i in range(n) for j in range(n)])
    for _ in range(6):
        i, j = source.sample(range(n), 2)
        shear = fmpq_mat(n, n, [fmpq(a == b) for a in range(n) for b in range(n)])
        shear[i, j] = source.choice([1, -1, 2])
        T = shear * T
    G = [[source.choice([0, 1, -2]) for _ in range(2)] for _ in range(n)]
    P = [source.randint(1, 5) for _ in range(n)]
    text = (
        f"states: [{', '.join(f'x{k}' for k in range(n))}]\nA: {rows_text(T * A * T.inv())}\nH: {rows_text(H * T.inv())}\n"
        f"G: {G}\nnoise: {{Q: [2, 3], R: 1, P0: {P}}}\n"
    )
    return read_text(text, "random.yaml").systems[0]


def rows_text(matrix):
    return "[" + ", ".join("[" + ", ".join(map(str, row)) + "]" for row in matrix.table()) + "]"


def test_identities_hold_in_rational_numbers():
    source = random.Random(11)
    smaller = 0
    for _ in range(60):
        system = random_system(source)
        rank = observability(dense(system.A), dense(system.H)).rank()
        if not rank:
            continue
        smaller += rank < system.n
        coordinates, made, notes = reduced(system)
        S, A, H = forms_matrix(coordinates), dense(made.A), dense(made.H)
        assert made.n == rank == S.rank() == observability(A, H).rank()
        assert S * dense(system.A) == A * S
        assert dense(system.H) == H * S
        assert S * dense(system.G) == dense(made.G)
        assert dense(made.noise.Q) == dense(system.noise.Q)
        assert dense(made.noise.R) == dense(system.noise.R)
        assert S * dense(system.noise.P0) * S.transpose() == dense(made.noise.P0)
        assert not notes
    assert smaller > 20


def test_noise_of_the_states_enters_by_the_combinations():
    source = random.Random(12)
    for _ in range(20):
        base = random_system(source)
        system = replace(
            base, G=None, disturbances=(), noise=replace(base.noise, Q=base.noise.P0, driven="states")
        )
        if not observability(dense(system.A), dense(system.H)).rank():
            continue
        coordinates, made, _ = reduced(system)
        S = forms_matrix(coordinates)
        density = dense(made.noise.Q)
        if made.noise.driven == "disturbances":
            density = dense(made.G) * density * dense(made.G).transpose()
        assert density == S * dense(system.noise.Q) * S.transpose()


def test_a_prior_of_some_states_only_is_that_of_the_combinations_of_these():
    text = (
        "states: [a, b, c]\nA: [[0, 0, 0], [0, 0, 0], [0, 0, 0]]\nH: [[1, -1, 0], [0, 0, 1]]\n"
        "noise: {P0: {c: 4, a: 1}}\n"
    )
    _, made, notes = reduced(read_text(text, "m.yaml").systems[0])
    assert made.state_names == ("z_a", "c")
    assert {key: entry.value for key, entry in made.noise.P0.entries.items()} == {(1, 1): 4}
    assert not notes


def test_a_prior_that_depends_on_time_is_left_out_and_said():
    text = "states: [a, b]\nA: [[0, -2*t], [0, 0]]\nH: [[1, t^2 + 1]]\nnoise: {P0: [1, 1]}\n"
    _, made, notes = reduced(read_text(text, "m.yaml").systems[0])
    assert made.n == 1
    assert "depends on time and is left out" in notes[0]
    assert made.noise is None or not (made.noise.P0 and made.noise.P0.entries)


@pytest.mark.parametrize("seed", range(25))
def test_known_systems_are_reproduced_and_fully_observable(seed):
    built = known.build(seed, breakable=False)
    system = read_text(built.text, "known.yaml").systems[0]
    coordinates, made, _ = reduced(system)
    assert made.n == built.rank
    found = reproduction(system, coordinates.forms, made)
    assert found.dynamics
    assert found.outputs
    assert prove(made, range(made.n)).rank == made.n


@pytest.mark.parametrize("matrix", ["A", "H", "G", "Q", "P0"])
def test_the_verification_sees_a_wrong_entry(matrix):
    system = load(bundled_models()["calibration/table_plan"]).systems[0]
    coordinates, made, _ = reduced(system)
    assert all(value is not False for value in vars_of(reproduction(system, coordinates.forms, made)))
    if matrix == "G":
        system = load(bundled_models()["kortunov/single_channel"]).systems[0]
        coordinates, made, _ = reduced(system)
    wrong = tampered(made, matrix)
    assert False in vars_of(reproduction(system, coordinates.forms, wrong))


def vars_of(found):
    return found.dynamics, found.outputs, found.inputs, found.noise


def tampered(system, matrix):
    """Return the system with 1/1000 added to one entry of a matrix."""
    holder = system.noise if matrix in {"Q", "P0"} else system
    old = getattr(holder, matrix)
    key = max(old.entries)
    new = replace(old, entries={**old.entries, key: add(old.entries[key], number(Fraction(1, 1000)))})
    if holder is system:
        return replace(system, **{matrix: new})
    return replace(system, noise=replace(system.noise, **{matrix: new}))


def test_names_do_not_collide():
    text = (
        "parameters: {z_a: 2}\nstates: [a, b, c]\nA: [[0, 0, 0], [0, 0, 0], [0, 0, 0]]\nH: [[z_a, 1, 0]]\n"
        "quantities: {z_a_2: c}\n"
    )
    system = read_text(text, "m.yaml").systems[0]
    assert variable_names(system, prove(system, range(3)).echelon) == ("z_a_3",)


def test_what_the_combinations_determine_stays_a_quantity():
    text = (
        "states: [a, b, c]\nA: [[0, 0, 0], [0, 0, 0], [0, 0, 0]]\nH: [[1, 1, 0], [0, 1, 2]]\n"
        "quantities: {both: 2*a + 3*b + 2*c, a_alone: a}\n"
    )
    system = read_text(text, "m.yaml").systems[0]
    coordinates, made, notes = reduced(system)
    [both] = made.quantities
    names = made.state_names
    total = {
        state: sum(
            both.coefficients[z].value * form[state].value
            for z, form in zip(names, coordinates.forms, strict=True)
            if state in form
        )
        for state in system.state_names
    }
    assert total == {"a": 2, "b": 3, "c": 2}
    assert notes == ("not observable, and left out: a_alone (quantities)",)


def test_states_that_do_not_move_are_dropped_rather():
    """a' = c and y = a + b: dropping c would be no good, dropping b loses nothing."""
    text = "states: [b, a, c]\nA: [[0, 0, 0], [0, 0, 1], [0, 0, 0]]\nH: [[1, 1, 0]]\n"
    system = read_text(text, "m.yaml").systems[0]
    found = drop_unobservable(system, range(3))
    assert (found.states, found.is_exact) == (("b",), True)
    kept = drop_unobservable(system, [0, 1, 2], in_order=True)
    assert (kept.states, kept.is_exact, kept.moved) == (("a", "c"), False, ())
    assert kept.system.state_names == ("b",)
    assert prove(kept.system, range(1)).rank == 1


@pytest.mark.parametrize("seed", range(12))
def test_what_is_left_after_dropping_is_observable(seed):
    built = known.build(100 + seed, breakable=False)
    system = read_text(built.text, "known.yaml").systems[0]
    found = drop_unobservable(system, range(system.n))
    assert prove(found.system, range(found.system.n)).rank == found.system.n
    assert len(found.states) + found.system.n == system.n
    if found.is_exact:
        assert found.system.n == built.rank
        assert all(
            next(iter(form)) == name for form, name in zip(found.forms, found.system.state_names, strict=True)
        )
