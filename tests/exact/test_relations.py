"""The method of unobservable states: relations of systems known beforehand, held against the outputs."""

import importlib.util
import math
import random
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import expm

from obscli.exact.errors import UndecidedError
from obscli.exact.prove import prove
from obscli.exact.relations import relations_of
from obscli.exact.verdicts import groups, state_verdicts
from obscli.model.library import bundled_model
from obscli.model.notation import to_text
from obscli.model.reader import load


_spec = importlib.util.spec_from_file_location("known_in_time", Path(__file__).with_name("known.py"))
KNOWN = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(KNOWN)

FUNCTIONS = {name: getattr(math, name) for name in ("sin", "cos", "exp", "sinh", "cosh", "sqrt", "pi")}
VERDICTS = {1: "observable", 2: "coupled", 3: "unobservable"}
BUNDLED = [
    "kortunov/single_channel", "bagmut/accelerometer", "bagmut/horizontal_channel", "textbook/levelling",
    "textbook/two_tones", "textbook/attitude_quaternion", "textbook/ins_velocity_aiding", "calibration/six_position",
    "ins_calibration/stage_1_sparse", "ins_calibration/pole",
]  # fmt: skip

#: Irreducible over Q, by rising degree and monic, without the leading 1; each with its kind of functions.
FACTORS = [[0], [1], [-2], [Fraction(1, 3)], [3, 0], [2, 2], [-2, 0], [-3, 2], [2, 2, 2], [-2, 0, 0]]


def value(expression, names):
    """An expression of a result as a number, by Python: another reader of the same text."""
    return eval(to_text(expression), {"__builtins__": {}}, {**FUNCTIONS, **names})


def fractions(rows):
    return [[Fraction(entry) for entry in row] for row in rows]


def times(left, right):
    return [
        [sum(a * b for a, b in zip(row, column, strict=True)) for column in zip(*right, strict=True)]
        for row in left
    ]


def echelon(rows):
    """The reduced echelon form over the rationals, by Gauss and Jordan."""
    rows, found = [list(row) for row in rows], []
    for column in range(len(rows[0]) if rows else 0):
        pivot = next((row for row in rows if row[column]), None)
        if pivot is None:
            continue
        rows.remove(pivot)
        pivot = [entry / pivot[column] for entry in pivot]
        rows = [cleared(row, pivot, column) for row in rows]
        found = [*(cleared(row, pivot, column) for row in found), pivot]
    return found


def cleared(row, pivot, column):
    return [a - row[column] * b for a, b in zip(row, pivot, strict=True)]


def flat(block):
    return [entry for row in block for entry in row]


def companion(coefficients):
    k = len(coefficients)
    return [
        *([Fraction(int(j == i + 1)) for j in range(k)] for i in range(k - 1)),
        [-Fraction(c) for c in coefficients],
    ]


def block_diagonal(blocks):
    n, rows, start = sum(map(len, blocks)), [], 0
    for block in blocks:
        rows += [[Fraction(0)] * start + row + [Fraction(0)] * (n - start - len(row)) for row in block]
        start += len(block)
    return rows


def unimodular(source, n):
    T, S = ([[Fraction(int(i == j)) for j in range(n)] for i in range(n)] for _ in "TS")
    for _ in range(2 * n if n > 1 else 0):
        i, j = source.sample(range(n), 2)
        f = source.choice([-2, -1, 1, 2])
        T[i] = [a + f * b for a, b in zip(T[i], T[j], strict=True)]
        for row in S:
            row[j] -= f * row[i]
    return T, S


def known_system(seed):
    """A and H with blocks of known eigenvalues, some hidden, in other coordinates; the visible blocks."""
    source = random.Random(seed)
    chosen = []
    while sum(map(len, chosen)) < source.randint(2, 5):
        chosen.append(source.choice([f for f in FACTORS if sum(map(len, chosen)) + len(f) <= 6]))
    if source.random() < 0.4 and sum(map(len, chosen)) + len(chosen[0]) <= 6:
        chosen.append(chosen[0])  # twice the same eigenvalues, perhaps in one Jordan chain
    A = block_diagonal(list(map(companion, chosen)))
    starts = [sum(map(len, chosen[:k])) for k in range(len(chosen))]
    chained = len(chosen) > 1 and chosen[-1] == chosen[0] and source.random() < 0.5
    if chained:
        for k in range(len(chosen[0])):
            A[k][starts[-1] + k] = Fraction(1)
    H = [[Fraction(0)] * len(A) for _ in range(source.randint(1, 2))]
    visible = [k for k in range(len(chosen)) if source.random() < 0.7] or [0]
    for row in H:
        for k in visible:
            for j in range(len(chosen[k])):
                row[starts[k] + j] = Fraction(source.randint(-2, 2))
    T, S = unimodular(source, len(A))
    return times(times(T, A), S), times(H, S)


def text_of(A, H):
    def rows(matrix):
        return "[" + ", ".join("[" + ", ".join(map(str, row)) + "]" for row in matrix) + "]"

    return f"states: [{', '.join(f'x{k + 1}' for k in range(len(A)))}]\nA: {rows(A)}\nH: {rows(H)}\n"


def canonical_values(relations, t, names):
    """The values at t of canonical functions, by the exponential of a companion matrix."""
    found = {}
    for one in relations.canonical:
        q = [value(c, names) for c in one.polynomial[:-1]]
        k = len(q)
        step = expm(np.array([*np.eye(k)[1:], [-c for c in q]], dtype=float) * t)
        found.update(zip(one.names, step[0], strict=True))  # row 0: the value of each solution begun with e_i
    return found


def outputs_by_relations(relations, system, t, names):
    """The matrix with which the relations take x0 to the outputs at t."""
    names = {**names, system.time: t}
    names |= canonical_values(relations, t, names)
    total = np.zeros((system.m, system.n))
    row = {output.name: i for i, output in enumerate(system.outputs)}
    column = {name: j for j, name in enumerate(system.state_names)}
    for one in relations.relations:
        f = value(one.function, names)
        for state, entry in one.coefficients.items():
            total[row[one.output], column[state]] += f * value(entry, names)
    return total


def rows_of(relations, system, *, independent=False):
    return [
        [
            Fraction(to_text(one.coefficients[name])) if name in one.coefficients else Fraction(0)
            for name in system.state_names
        ]
        for one in relations.relations
        if one.independent or not independent
    ]


@pytest.mark.parametrize("seed", range(200))
def test_the_relations_are_the_outputs_and_span_the_observability_matrix(system, seed):
    A, H = known_system(seed)
    read = system(text_of(A, H))
    found = relations_of(prove(read, range(read.n)))
    assert found.exact
    # the outputs, exactly: H exp(A t) by another way
    t = 0.7
    expected = np.array(H, dtype=float) @ expm(np.array(A, dtype=float) * t)
    assert outputs_by_relations(found, read, t, {}) == pytest.approx(
        expected, rel=1e-7, abs=1e-7 * (1 + abs(expected).max())
    )
    # the span, and its basis among the relations
    blocks, block = [], H
    for _ in range(len(A)):
        blocks, block = blocks + block, times(block, A)
    seen = echelon(blocks)
    assert echelon(rows_of(found, read)) == seen
    assert sum(one.independent for one in found.relations) == len(seen)
    assert echelon(rows_of(found, read, independent=True)) == seen
    # the situations, from that echelon form
    for j, name in enumerate(read.state_names):
        touching = [row for row in seen if row[j]]
        alone = any(sum(map(bool, row)) == 1 for row in touching)
        assert found.situations[name] == (1 if alone else 2 if touching else 3)


@pytest.mark.parametrize("seed", range(0, 200, 4))
def test_no_function_is_superfluous(system, seed):
    """As many functions as the least polynomial that annihilates the rows of H has roots: no fewer will do."""
    A, H = known_system(seed)
    read = system(text_of(A, H))
    found = relations_of(prove(read, range(read.n)))
    krylov, block = [flat(H)], H
    while len(echelon([*krylov, flat(block := times(block, A))])) > len(krylov):
        krylov.append(flat(block))
    d = len(krylov) if any(krylov[0]) else 0
    assert len({to_text(one.function) for one in found.relations}) == d


def test_the_functions_of_each_kind(system):
    """s², s − λ twice, oscillation, hyperbolic, damped oscillation: every readable form at once."""
    read = system(
        "parameters: {w: {value: 2, assume: positive}, a: 0.5}\n"
        "states: [p, v, e, de, c, s, h, dh, f, df]\n"
        "A:\n  p: {v: 1}\n  e: {e: -a, de: 1}\n  de: {de: -a}\n  c: {s: w}\n  s: {c: -w}\n  h: {dh: 1}\n  dh: {h: 3}\n"
        "  f: {df: 1}\n  df: {f: -5, df: -2}\n"
        "H: [[1, 0, 1, 0, 1, 0, 1, 0, 1, 0]]\n"
    )
    found = relations_of(prove(read, range(read.n)))
    assert {to_text(one.function) for one in found.relations} == {
        "1", "t", "exp(-a*t)", "t*exp(-a*t)", "cos(w*t)", "sin(w*t)/w", "cosh(sqrt(3)*t)", "sinh(sqrt(3)*t)/sqrt(3)",
        "exp(-t)*cos(2*t)", "exp(-t)*sin(2*t)/2",
    }  # fmt: skip
    assert set(found.situations.values()) == {1}
    A = np.zeros((10, 10))
    for (i, j), entry in read.A.entries.items():
        A[i, j] = value(entry, {"w": 2, "a": 0.5})
    expected = np.array([[1, 0] * 5]) @ expm(A * 0.9)
    assert outputs_by_relations(found, read, 0.9, {"w": 2, "a": 0.5}) == pytest.approx(
        expected, rel=1e-10, abs=1e-10
    )


SINGLE = (
    "parameters: {{g: 9.8, a_om: 0.04, a_w: {a_w}}}\nstates: [alpha, V, R, dOm, dW]\n"
    "A: [[0,0,0,1,0],[g,0,0,0,1],[0,1,0,0,0],[0,0,0,a_om,0],[0,0,0,0,a_w]]\nH: [[0,1,0,0,0],[0,0,1,0,0]]\n"
)


def test_the_single_channel_by_hand(system):
    """V = V0 + g α0 t + g dOm (e^{at} − 1 − at)/a² + dW (e^{wt} − 1)/w, sorted by functions of time."""
    read = system(SINGLE.format(a_w="0.001"))
    found = relations_of(prove(read, range(5)))
    terms = written(found)
    assert terms["1", "y1"] == {"V": "1", "dOm": "-g/a_om**2", "dW": "-1/a_w"}
    assert terms["t", "y1"] == {"alpha": "g", "dOm": "-g/a_om"}
    assert terms["exp(a_om*t)", "y1"] == {"dOm": "g/a_om**2"}
    assert terms["exp(a_w*t)", "y1"] == {"dW": "1/a_w"}
    assert terms["t**2", "y2"] == {"alpha": "g/2", "dOm": "-g/(2*a_om)"}
    assert set(found.situations.values()) == {1}


@pytest.mark.parametrize(
    ("a_w", "situations"),
    [
        ("a_om", {"alpha": 2, "V": 1, "R": 1, "dOm": 2, "dW": 2}),
        ("0*a_om", {"alpha": 2, "V": 1, "R": 1, "dOm": 1, "dW": 2}),
    ],
)
def test_the_situations_of_the_single_channel_where_it_loses_rank(system, a_w, situations):
    found = relations_of(prove(system(SINGLE.format(a_w=a_w)), range(5)))
    assert found.situations == situations


def test_the_sign_of_a_square_is_the_one_at_the_files_values(system):
    text = "parameters: {{b: {b}, c: 4}}\nstates: [x, v]\nA: [[0, 1], [-c, -b]]\nH: [[1, 0]]\n"
    for b, form in (("1", "cos"), ("5", "cosh"), ("null", "cos")):
        found = relations_of(prove(system(text.format(b=b)), range(2)))
        assert any(f"{form}(" in to_text(one.function) for one in found.relations)
        assert len(found.notes) == 1
    overdamped = system(text.format(b="5"))
    found = relations_of(prove(overdamped, range(2)))
    expected = np.array([[1.0, 0.0]]) @ expm(np.array([[0, 1], [-4, -5]]) * 0.8)
    assert outputs_by_relations(found, overdamped, 0.8, {"b": 5, "c": 4}) == pytest.approx(expected)


def test_roots_in_the_coefficients_do_not_make_functions_dependent(system):
    """√a twice in one block and ±√a in another: the factors have roots in common that no factorisation shows."""
    read = system(
        "parameters: {a: {value: 2, assume: positive}}\nstates: [x1, x2, x3, x4]\n"
        "A: [[sqrt(a),1,0,0],[0,sqrt(a),0,0],[0,0,0,1],[0,0,a,0]]\nH: [[1,0,1,0],[0,sqrt(2),0,0]]\n"
    )
    found = relations_of(prove(read, range(4)))
    A = np.array([[2**0.5, 1, 0, 0], [0, 2**0.5, 0, 0], [0, 0, 0, 1], [0, 0, 2, 0]])
    expected = np.array([[1, 0, 1, 0], [0, 2**0.5, 0, 0]]) @ expm(A * 0.6)
    assert outputs_by_relations(found, read, 0.6, {"a": 2}) == pytest.approx(expected)
    assert found.situations == {"x1": 2, "x2": 1, "x3": 2, "x4": 2}


def test_names_of_canonical_functions_are_new(system):
    read = system("states: [phi_0, phi_1, x]\nA: [[0, 1, 0], [0, 0, 1], [-2, -2, -2]]\nH: [[1, 0, 0]]\n")
    (canonical,) = relations_of(prove(read, range(3))).canonical
    assert canonical.names == ("phi__0", "phi__1", "phi__2")
    assert [to_text(c) for c in canonical.polynomial] == ["2", "2", "2", "1"]


@pytest.mark.parametrize("seed", range(40))
def test_hidden_directions_of_systems_in_time_satisfy_every_relation(system, seed):
    known = KNOWN.build(seed, breakable=False)
    read = system(known.text)
    proof = prove(read, range(read.n))
    found = relations_of(proof)
    names = {"w": 0.7310585, "v": 1.1234}
    t0 = value(found.instant, {"t0": 0.4142135, **names}) if found.instant else 0.4142135
    names |= {"t": t0, "t0": t0}
    rows = np.array(
        [
            [value(one.coefficients[s], names) if s in one.coefficients else 0.0 for s in read.state_names]
            for one in found.relations
        ]
    )
    hidden = np.array(
        [[value_of_text(column.get(s, "0"), names) for s in read.state_names] for column in known.hidden]
    ).reshape(-1, read.n)
    assert rows @ hidden.T == pytest.approx(
        0 * (rows @ hidden.T), abs=1e-9 * (1 + abs(rows).max() * (1 + abs(hidden).max(initial=0)))
    )
    scaled = rows / np.linalg.norm(rows, axis=1, keepdims=True)
    assert np.linalg.matrix_rank(scaled, tol=1e-9) == known.rank
    assert sum(one.independent for one in found.relations) == known.rank


def value_of_text(text, names):
    return eval(text.replace("^", "**"), {"__builtins__": {}}, {**FUNCTIONS, **names})


def test_more_blocks_are_taken_at_an_instant_where_the_first_do_not_suffice(system):
    """H = [1, t³] loses rank at t = 0 up to the third derivative, of which the generic rank needs one."""
    found = relations_of(prove(system("states: [a, b]\nA: zeros(2, 2)\nH: [[1, t^3]]\n"), range(2)))
    assert [to_text(one.function) for one in found.relations] == ["1", "t**3/6"]
    assert to_text(found.instant) == "0"
    assert found.situations == {"a": 1, "b": 1}


def test_an_instant_may_tell_more_of_a_state_than_others(system):
    """y = x1 + t x2 with y' = 0: x1 is known at t = 0, and only there."""
    found = relations_of(prove(system("states: [x1, x2]\nA: [[0, -1], [0, 0]]\nH: [[1, t]]\n"), range(2)))
    assert found.situations == {"x1": 1, "x2": 3}
    assert found.differing == ("x1", "x2")
    later = "states: [x1, x2]\nA: [[0, -1], [0, 0]]\nH: [[1, t]]\ninterval: {start: 2}\n"
    found = relations_of(prove(system(later), range(2)))
    assert to_text(found.instant) == "2"
    assert found.situations == {"x1": 2, "x2": 2}
    assert not found.differing


def test_an_instant_without_coefficients_is_left_open(system):
    found = relations_of(prove(system("states: [x1, x2]\nA: zeros(2, 2)\nH: [[1, 1/t]]\n"), range(2)))
    assert to_text(found.instant) == "t0"
    assert "1/t0" in {to_text(entry) for one in found.relations for entry in one.coefficients.values()}


def test_many_parameters_are_met_column_by_column(system, monkeypatch):
    """The same relations, whether all columns are taken together or each with its own parameters."""
    from obscli.exact import relations as module

    read = system(SINGLE.format(a_w="0.001"))
    together = relations_of(prove(read, range(5)))
    monkeypatch.setattr(module, "annihilator", refuse)
    apart = relations_of(prove(read, range(5)))
    assert written(apart) == written(together)
    assert apart.situations == together.situations


@pytest.mark.parametrize("seed", range(0, 200, 5))
def test_columns_taken_one_by_one_make_the_same_outputs(system, monkeypatch, seed):
    from obscli.exact import relations as module

    A, H = known_system(seed)
    read = system(text_of(A, H))
    proof = prove(read, range(read.n))
    together = relations_of(proof)
    monkeypatch.setattr(module, "annihilator", refuse)
    assert written(relations_of(proof)) == written(together)


def refuse(_):
    raise UndecidedError("too large")


def written(relations):
    return {
        (to_text(one.function), one.output): {
            state: to_text(entry) for state, entry in one.coefficients.items()
        }
        for one in relations.relations
    }


@pytest.mark.parametrize("stage", ["rest", "rest_heading"])
def test_sixteen_states_with_six_rates(stage):
    read = next(one for one in load(bundled_model("kortunov/sixteen_states")).systems if one.stage == stage)
    found = relations_of(prove(read, range(16)))
    names = {}
    for parameter in read.parameters:
        names[parameter.name] = value(parameter.nominal, names)
    A, H = np.zeros((16, 16)), np.zeros((read.m, 16))
    for matrix, entries in ((A, read.A.entries), (H, read.H.entries)):
        for place, entry in entries.items():
            matrix[place] = value(entry, names)
    expected = H @ expm(3 * A)
    assert outputs_by_relations(found, read, 3.0, names) == pytest.approx(expected, rel=1e-6, abs=1e-6)
    functions = {to_text(one.function) for one in found.relations}
    assert len(functions) == 10
    assert sum("exp(" in one for one in functions) == 6


def test_too_large_is_undecided_and_quick(system):
    names = [f"p{k}" for k in range(12)]
    source = random.Random(1)
    rows = ["[" + ", ".join(source.choice(names) for _ in range(12)) + "]" for _ in range(12)]
    text = f"parameters: {{{', '.join(f'{name}: null' for name in names)}}}\nstates: [{', '.join(f'x{k}' for k in range(12))}]\n"
    dense = system(
        f"{text}A: [{', '.join(rows)}]\nH: [[{', '.join('1' if k == 0 else '0' for k in range(12))}]]\n"
    )
    proof = prove(dense, range(12))
    with pytest.raises(UndecidedError):
        relations_of(proof)


@pytest.mark.parametrize("name", BUNDLED)
def test_the_situations_are_the_verdicts_of_the_elimination(name):
    for one in load(bundled_model(name)).systems:
        proof = prove(one, range(one.n))
        verdicts = state_verdicts(one.state_names, groups(proof.flag.rows))
        found = relations_of(proof)
        assert {state: VERDICTS[k] for state, k in found.situations.items()} == verdicts
        assert not found.differing
        assert sum(relation.independent for relation in found.relations) == proof.rank
