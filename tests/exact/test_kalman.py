"""The Kalman decomposition: systems whose decomposition is known beforehand, and the identities x = T x̄ obeys."""

import random
from fractions import Fraction

import pytest
from flint import fmpq, fmpq_mat, fmpq_poly

from obscli.exact import kalman
from obscli.exact.errors import UndecidedError
from obscli.exact.exact_system import read_system
from obscli.exact.kalman import Kalman, kalman_decomposition, kalman_dimensions
from obscli.exact.kalman_parts import four_parts
from obscli.exact.prove import prove
from obscli.exact.rows import dot, drift
from obscli.model.library import bundled_models
from obscli.model.notation import to_text
from obscli.model.reader import load, read_text


SYSTEMS = 200
VARYING = 20
#: Which blocks of Ā may differ from zero, by row.
ALLOWED = ({0, 1, 2, 3}, {1, 3}, {2, 3}, {3})


def product(*matrices):
    result = matrices[0]
    for other in matrices[1:]:
        columns = list(zip(*other, strict=True))
        result = [
            [sum((a * b for a, b in zip(row, column, strict=True)), 0 * row[0]) for column in columns]
            for row in result
        ]
    return result


def rank(rows):
    entries = [fmpq(x.numerator, x.denominator) for row in rows for x in row]
    return fmpq_mat(len(rows), len(rows[0]), entries).rank()


def chain(first, A):
    """Return first, first A, first A², … on top of each other."""
    rows = list(first)
    for _ in range(len(A) - 1):
        first = product(first, A)
        rows += first
    return rows


def decomposed(source, sizes, outputs, inputs):
    """Ā, B̄, H̄ of parts of these sizes: random in the blocks that are not structurally zero."""
    part = [k for k, size in enumerate(sizes) for _ in range(size)]
    n = len(part)
    entry = lambda wanted: Fraction(source.choice([0, 0, 1, -1, 2, -3])) if wanted else Fraction(0)  # noqa: E731
    A = [[entry(part[j] in ALLOWED[part[i]]) for j in range(n)] for i in range(n)]
    B = [[entry(part[i] < 2) for _ in range(inputs)] for i in range(n)]
    H = [[entry(part[j] in {1, 3}) for j in range(n)] for _ in range(outputs)]
    return A, B, H


def has_sizes(sizes, A, B, H):
    """Whether the parts are reachable and observable as far as they should be, by rank of the matrices of Kalman."""
    seen = rank(chain(H, A))
    turned = [list(column) for column in zip(*A, strict=True)]
    reached = rank(chain([list(column) for column in zip(*B, strict=True)], turned))
    return reached == sizes[0] + sizes[1] and seen == sizes[1] + sizes[3]


def known(source, most=8):
    """Return sizes and a system of them."""
    while True:
        sizes = tuple(source.randint(0, 3) for _ in range(4))
        if not 1 <= sum(sizes) <= most:
            continue
        for _ in range(20):
            system = decomposed(source, sizes, source.randint(1, 2), source.randint(1, 2))
            if has_sizes(sizes, *system):
                return sizes, system


def shears(source, n, functions, count=8):
    """Return a random product of shears and its inverse."""
    one, zero = functions[0] ** 0, 0 * functions[0]
    T, S = ([[one if i == j else zero for j in range(n)] for i in range(n)] for _ in "TS")
    for _ in range(count if n > 1 else 0):
        i, j = source.sample(range(n), 2)
        f = source.choice(functions)
        T[i] = [a + f * b for a, b in zip(T[i], T[j], strict=True)]
        for row in S:
            row[j] -= f * row[i]
    return T, S


def matrix_text(rows):
    return "[" + ", ".join("[" + ", ".join(map(text_of, row)) + "]" for row in rows) + "]"


def text_of(entry):
    if isinstance(entry, fmpq_poly):
        return " + ".join(f"({c})*t^{k}" for k, c in enumerate(entry.coeffs())) or "0"
    return str(entry)


def model_of(A, B, H):
    names = ", ".join(f"x{k}" for k in range(1, len(A) + 1))
    rows = "".join(f"{key}: {matrix_text(rows)}\n" for key, rows in (("A", A), ("B", B), ("H", H)))
    return read_text(f"states: [{names}]\n{rows}", "known.yaml").systems[0]


def numbers(rows, columns):
    return [[row[j].value if j in row else Fraction(0) for j in range(columns)] for row in rows]


def by_state(columns, names):
    return [[column[name].value if name in column else Fraction(0) for column in columns] for name in names]


def test_dimensions_and_blocks_of_200_known_systems():
    source = random.Random(5)
    seen = set()
    for _ in range(SYSTEMS):
        sizes, (A, B, H) = known(source)
        n = len(A)
        T, S = shears(source, n, [Fraction(k) for k in (1, -1, 2, -2)])
        A, B, H = product(T, A, S), product(T, B), product(H, S)
        system = model_of(A, B, H)
        proof = prove(system, range(n))
        assert kalman_dimensions(proof) == sizes
        found = kalman_decomposition(proof)
        assert found.dimensions == found.sizes == sizes
        assert_blocks(found)
        names = system.state_names
        P = by_state(found.columns, names)
        Q = [[row[name].value if name in row else Fraction(0) for name in names] for row in found.variables]
        assert product(P, Q) == [[Fraction(int(i == j)) for j in range(n)] for i in range(n)]
        assert product(P, numbers(found.A, n), Q) == A
        assert product(P, numbers(found.B, len(B[0]))) == B
        assert product(numbers(found.H, n), Q) == H
        seen.add(sizes)
    assert len(seen) > 60  # of many shapes


def test_varying_systems_decompose_by_the_same_rule():
    source = random.Random(7)
    t = fmpq_poly([0, 1])
    for _ in range(VARYING):
        sizes, (A, B, H) = known(source, most=5)
        A, B, H = ([[fmpq_poly([int(x)]) for x in row] for row in one] for one in (A, B, H))
        T, S = shears(source, len(A), [t, -t, t * t, fmpq_poly([2]), fmpq_poly([-1])], count=3)
        moving = [[entry.derivative() for entry in row] for row in T]
        A = product(added(product(T, A), moving), S)
        proof = prove(model_of(A, product(T, B), product(H, S)), range(len(A)))
        assert kalman_dimensions(proof) == sizes
        assert_decomposes(kalman_decomposition(proof), sizes)


def added(left, right):
    return [[a + b for a, b in zip(*rows, strict=True)] for rows in zip(left, right, strict=True)]


def assert_blocks(found: Kalman):
    """Every structural zero, from what is printed."""
    part = [k for k, size in enumerate(found.sizes) for _ in range(size)]
    if found.by is None:
        assert all(part[j] <= part[i] for i, row in enumerate(found.A) for j in row)
        assert all(part[j] == 0 for row in found.H for j in row)
    else:
        assert all(part[j] in ALLOWED[part[i]] for i, row in enumerate(found.A) for j in row)
        assert all(part[j] in {1, 3} for row in found.H for j in row)
        assert all(part[i] in {0, 1} for i, row in enumerate(found.B) if row)


def assert_decomposes(found: Kalman, sizes=None):
    """Every structural zero, and A T − T' = T Ā, T B̄ = B, H T = H̄, from what is printed, read anew."""
    assert sizes is None or found.sizes == sizes
    assert_blocks(found)
    system = found.proof.exact.system
    printed = [
        e
        for rows in (found.A, found.H, found.B or (), found.columns, found.variables)
        for r in rows
        for e in r.values()
    ]
    exact = read_system(system, [*printed, *(system.B.entries.values() if system.B else ())])
    read, field = exact.interpreter.read, exact.field
    T = [exact.row(column) for column in found.columns]
    for j, column in enumerate(T):
        left = drift(exact, column)  # T' − A T
        for i, row in enumerate(found.A):
            for k, entry in T[i].items() if j in row else ():
                left[k] = left.get(k, field.zero) + read(row[j]) * entry
        assert not any(left.values())
        for row, printed_row in zip(exact.H, found.H, strict=True):
            value = dot(field, row, column)
            assert value == (read(printed_row[j]) if j in printed_row else field.zero)
    for i, form in enumerate(found.variables):
        products = [dot(field, exact.row(form), column) for column in T]
        assert all(bool(p) == (i == j) for j, p in enumerate(products))
        assert products[i] == field.one
    if found.by == "B":
        for k in range(system.B.columns):
            for s, name in enumerate(system.state_names):
                left = sum(
                    (read(row[k]) * T[i].get(s, field.zero) for i, row in enumerate(found.B) if k in row),
                    field.zero,
                )
                entry = system.B.entries.get((s, k))
                assert left == (field.zero if entry is None else read(entry)), name


@pytest.mark.parametrize(
    "name", [name for name in sorted(bundled_models()) if not name.startswith("calibration")]
)
def test_bundled_models_decompose(name):
    for system in load(bundled_models()[name]).systems:
        proof = prove(system, range(system.n))
        found = kalman_decomposition(proof)
        assert_decomposes(found)
        assert sum(found.sizes) == system.n
        if found.by is None:
            assert kalman_dimensions(proof) is None
            assert found.dimensions is None
            assert found.sizes == (proof.rank, system.n - proof.rank)
        else:
            assert kalman_dimensions(proof) == found.dimensions


def test_inputs_come_before_disturbances():
    text = "states: [a, b]\nA: [[0, 1], [0, 0]]\nH: [[1, 0]]\nB: [[0], [0]]\nG: [[0], [1]]\n"
    system = read_text(text, "both.yaml").systems[0]
    found = kalman_decomposition(prove(system, range(2)))
    assert (found.by, found.sizes) == ("B", (0, 0, 0, 2))
    system = read_text(text.replace("B: [[0], [0]]\n", ""), "one.yaml").systems[0]
    found = kalman_decomposition(prove(system, range(2)))
    assert (found.by, found.sizes) == ("G", (0, 2, 0, 0))


def test_inputs_may_bring_functions_that_the_system_lacks():
    text = (
        "parameters: {w: 1}\nfunctions: [f]\nstates: [a, b, c]\n"
        "A: [[0, 0, 0], [0, 0, 0], [0, 0, 0]]\nH: [[1, 0, 0]]\nB: [[sin(w*t)], [cos(w*t)], [f]]\n"
    )
    system = read_text(text, "moved.yaml").systems[0]
    assert kalman_dimensions(prove(system, range(3))) == (2, 1, 0, 0)
    system = read_text(text.replace("[f]]", "[0]]"), "moved.yaml").systems[0]
    assert kalman_dimensions(prove(system, range(3))) == (1, 1, 1, 0)


def test_a_wrong_zero_is_not_passed_over(monkeypatch):
    """Were the parts mixed up, the blocks would not be zero, and that is said."""
    system = model_of([[0, 1, 0], [0, 0, 0], [0, 0, 1]], [[0], [1], [1]], [[1, 0, 0]])
    proof = prove(system, range(3))
    monkeypatch.setattr(kalman, "four_parts", lambda *given: four_parts(*given)[::-1])
    with pytest.raises(UndecidedError, match="should be zero"):
        kalman_decomposition(proof)


def test_the_reader_sees_expressions_of_the_file():
    system = read_text(
        "parameters: {g: 9.8}\nstates: [v, a, d]\nA: [[0, -g, 1], [0, 0, 0], [0, 0, 0]]\nH: [[1, 0, 0]]\n",
        "m.yaml",
    ).systems[0]
    found = kalman_decomposition(prove(system, range(3)))
    assert [{k: to_text(e) for k, e in row.items()} for row in found.variables] == [
        {"v": "1"},
        {"a": "g", "d": "-1"},
        {"d": "1"},
    ]
    assert [{k: to_text(e) for k, e in row.items()} for row in found.A] == [{1: "-1"}, {}, {}]


@pytest.mark.parametrize("A", ["0", "w"])
def test_an_input_that_does_not_exist_is_undecided(A):
    text = f"parameters: {{w: 1}}\nstates: [a]\nA: [[{A}]]\nH: [[1]]\nB: [[1/(sin(w)^2 + cos(w)^2 - 1)]]\n"
    system = read_text(text, "m.yaml").systems[0]
    with pytest.raises(
        UndecidedError, match="an entry of B does not exist: the denominator is identically zero"
    ):
        kalman_dimensions(prove(system, range(1)))
