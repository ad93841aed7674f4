"""How the unobservable subspace moves: systems whose hidden dynamics are known beforehand, and laws."""

import random
from fractions import Fraction

import mpmath
import pytest

from obscli.exact.analysis import Options, analyze
from obscli.model.notation import to_text


def unimodular(source, n, shears=8):
    """A random integer matrix of determinant 1, and its inverse."""
    T, S = ([[Fraction(int(i == j)) for j in range(n)] for i in range(n)] for _ in "TS")
    for _ in range(shears if n > 1 else 0):
        i, j = source.sample(range(n), 2)
        f = source.choice([-2, -1, 1, 2])
        T[i] = [a + f * b for a, b in zip(T[i], T[j], strict=True)]  # T <- (I + f E_ij) T
        for row in S:  # S <- S (I - f E_ij)
            row[j] -= f * row[i]
    return T, S


def times(*matrices):
    product = matrices[0]
    for other in matrices[1:]:
        product = [
            [sum(a * b for a, b in zip(row, col, strict=True)) for col in zip(*other, strict=True)]
            for row in product
        ]
    return product


def companion(coefficients):
    """The companion matrix of s^k + c_{k-1} s^{k-1} + … + c_0."""
    k = len(coefficients)
    rows = [[Fraction(int(j == i + 1)) for j in range(k)] for i in range(k)]
    rows[-1] = [-Fraction(c) for c in coefficients]
    return rows


def block_diagonal(*blocks):
    n = sum(map(len, blocks))
    rows, start = [], 0
    for block in blocks:
        rows += [[Fraction(0)] * start + row + [Fraction(0)] * (n - start - len(row)) for row in block]
        start += len(block)
    return rows


def hidden_system(source, A22, observed=2):
    """A system with the hidden dynamics A22 beside a chain that is seen, in other coordinates, as a model text."""
    d, n = len(A22), observed + len(A22)
    A = [
        [Fraction(int(j == i + 1)) if j < observed else Fraction(0) for j in range(n)]
        for i in range(observed)
    ]
    A[observed - 1][:observed] = [Fraction(source.randint(-3, 3)) for _ in range(observed)]
    A += [[Fraction(source.randint(-2, 2)) for _ in range(observed)] + list(row) for row in A22]
    H = [[Fraction(int(j == 0)) for j in range(n)]]
    T, S = unimodular(source, n)
    text = (
        f"states: [{', '.join(f'x{k}' for k in range(1, n + 1))}]\n"
        f"A: {rows_text(times(T, A, S))}\nH: {rows_text(times(H, S))}\n"
    )
    return text, d


def rows_text(rows):
    return "[" + ", ".join("[" + ", ".join(map(str, row)) + "]" for row in rows) + "]"


def structure_of(system):
    return analyze(system, Options(critical=False, certificate=False)).structure


def roots_of(coefficients):
    return mpmath.polyroots([1, *reversed(coefficients)], maxsteps=500, extraprec=500)


def kind_of(coefficients):
    """Decaying, neutral or growing, by the roots of an irreducible polynomial in high precision."""
    with mpmath.workdps(60):
        top = max(mpmath.re(root) for root in roots_of(coefficients))
        return "neutral" if abs(top) < mpmath.mpf(10) ** -25 else "growing" if top > 0 else "decaying"


#: Irreducible over Q (Eisenstein, or of degree one, or quadratic without rational roots), by degree.
FACTORS = [
    [0], [1], [-1], [Fraction(1, 3)], [2, 2], [5, -2], [3, 0], [-2, 0], [2, 4, 2], [2, 2, 6], [2, 0, 2, 4],
    [2, 0, 4, 0], [3, 0, 3, 0], [-2, 0, 0], [6, 12, 12, 6], [5, 5, 5, 5, 5],
]  # fmt: skip


@pytest.mark.parametrize("seed", range(60))
def test_the_modes_are_those_the_system_was_built_with(system, seed):
    source = random.Random(seed)
    chosen = [source.choice(FACTORS) for _ in range(source.randint(1, 3))]
    A22 = block_diagonal(*map(companion, chosen))
    P, Q = unimodular(source, len(A22), 3)
    text, d = hidden_system(source, times(P, A22, Q))
    found = structure_of(system(text))
    kinds = {kind_of(c) for c in chosen}
    assert found.dimension == d
    assert len(found.modes) == d
    assert found.verdict == ("detectable" if kinds == {"decaying"} else "not detectable")
    assert {m.kind for m in found.modes} == kinds
    # every direction carries the roots of its polynomial
    expected = [root for c in chosen for _ in c for root in roots_of([rational(v) for v in c])]
    assert in_order([v for m in found.modes for v in m.values]) == pytest.approx(in_order(expected), abs=2e-6)


def rational(value):
    return mpmath.mpf(Fraction(value).numerator) / Fraction(value).denominator


def in_order(values):
    """Real and imaginary parts of complex numbers in an order that rounding does not change."""
    pairs = sorted((round(float(mpmath.re(v)), 6) + 0.0, round(float(mpmath.im(v)), 6) + 0.0) for v in values)
    return [part for pair in pairs for part in pair]


@pytest.mark.parametrize("seed", range(30))
def test_a_direction_of_a_real_eigenvalue_is_an_eigenvector_that_no_output_sees(system, seed):
    source = random.Random(seed)
    A22 = [
        [Fraction(source.choice([0, -1, 1, -2])) if i == j else Fraction(0) for j in range(3)]
        for i in range(3)
    ]
    text, _ = hidden_system(source, A22)
    model = system(text)
    names = model.state_names

    def value(matrix, i, j):
        return fraction(matrix.entries[i, j]) if (i, j) in matrix.entries else Fraction(0)

    for mode in structure_of(model).modes:
        d = [fraction(mode.direction[name]) if name in mode.direction else Fraction(0) for name in names]
        eigenvalue = Fraction(mode.eigenvalue)
        n = len(names)
        assert [sum(value(model.A, i, j) * d[j] for j in range(n)) for i in range(n)] == [
            eigenvalue * x for x in d
        ]
        assert sum(value(model.H, 0, j) * d[j] for j in range(n)) == 0


def fraction(expression):
    return Fraction(to_text(expression))


@pytest.mark.parametrize(("c", "kind"), [([0], "growing"), ([1], "decaying"), ([3, 0], "growing")])
def test_a_defective_mode_is_chained_and_grows_where_it_would_stay(system, c, kind):
    k = len(c)
    one = [[Fraction(int(i == k - 1 and j == 0)) for j in range(k)] for i in range(k)]
    zero = [[Fraction(0)] * k for _ in range(k)]
    block = companion(c)
    A22 = [a + b for a, b in zip(block, one, strict=True)] + [a + b for a, b in zip(zero, block, strict=True)]
    text, d = hidden_system(random.Random(1), A22)
    found = structure_of(system(text))
    assert [m.chained for m in found.modes] == [False] * k + [True] * k
    assert found.modes[-1].kind == kind
    assert found.verdict == ("detectable" if kind == "decaying" else "not detectable")
    assert found.dimension == d == 2 * k


HIDDEN = "states: [y, h1, h2]\nparameters: {{{parameters}}}\ndynamics: {{y: -y, h1: {h1}, h2: {h2}}}\nmeasurements: {{z: y}}\n"


def hidden(system, parameters, h1, h2="-h2"):
    return structure_of(system(HIDDEN.format(parameters=parameters, h1=h1, h2=h2)))


@pytest.mark.parametrize(
    ("parameters", "h1", "condition"),
    [
        ("a: 1", "a*h1", "a < 0"),
        ("a: 1", "-h1/a", "a > 0"),
        ("a: 1, b: 2", "(b - a)*h1", "a - b > 0"),
        ("a: 1", "a^3*h1", "a < 0"),
        ("a: 1, b: {value: 2, assume: positive}", "a*b*h1", "a < 0"),
        ("a: 1, b: {value: 2, assume: nonzero}", "a*b^2*h1", "a < 0"),
    ],
)
def test_the_condition_is_in_its_simplest_form(system, parameters, h1, condition):
    found = hidden(system, parameters, h1)
    assert (found.verdict, found.condition) == ("depends", condition)
    assert found.at_values.verdict in {"detectable", "not detectable"}


@pytest.mark.parametrize(
    ("parameters", "h1", "verdict"),
    [
        ("tau: {value: 1, assume: positive}", "-h1/tau", "detectable"),
        ("tau: {value: 1, assume: positive}", "h1/tau", "not detectable"),
        ("a: 1", "a^2*h1", "depends"),
        ("a: {value: 1, assume: nonzero}", "-a^2*h1", "detectable"),
        ("a: 1", "0*a", "not detectable"),
        ("a: 1", "-(pi - 3)*h1", "detectable"),
        ("a: 1", "(sqrt(2) - 1.4142135623730951)*h1", "detectable"),
        ("a: 1", "(sqrt(2) - 1.414213562373095)*h1", "not detectable"),
        ("a: 1", "cos(2)*h1", "detectable"),
    ],
)
def test_the_sign_of_an_eigenvalue_is_decided_exactly(system, parameters, h1, verdict):
    found = hidden(system, parameters, h1)
    if verdict == "depends":
        assert found.verdict in {"depends", "not detectable"}  # a^2 >= 0 never decays
        assert found.at_values is None or found.at_values.verdict == "not detectable"
    else:
        assert found.verdict == verdict


@pytest.mark.parametrize(
    ("h1", "h2", "verdict", "condition"),
    [
        ("h2", "-w^2*h1", "not detectable", ""),
        ("h2", "-w^2*h1 - 2*d*w*h2", "depends", "w*d > 0"),
        ("h2", "-h1 - a*h2", "depends", "a > 0"),
        ("h2", "-a*h1", "not detectable", ""),
    ],
)
def test_a_pair_decays_on_conditions_of_hurwitz_or_never(system, h1, h2, verdict, condition):
    found = hidden(system, "w: 2, d: 0.5, a: 1", h1, h2)
    assert found.verdict == verdict
    assert found.condition == condition


def test_eigenvalues_are_written_as_an_engineer_writes_them(system):
    assert {m.eigenvalue for m in hidden(system, "w: 2", "h2", "-w^2*h1").modes} == {"±i*w"}
    assert {m.eigenvalue for m in hidden(system, "w: 2", "h2", "-5*h1 - 2*h2").modes} == {
        "-1 ±i*2".replace("±i", "± i")
    }
    assert {m.eigenvalue for m in hidden(system, "w: 2", "h2", "2*h1").modes} == {"±sqrt(2)"}
    assert {m.eigenvalue for m in hidden(system, "w: 2", "h2", "-h1").modes} == {"±i"}
    assert {m.eigenvalue for m in hidden(system, "w: 2", "cos(w)*h2", "-cos(w)*h1").modes} == {"±i*cos(w)"}
    cubic = structure_of(system(
        "parameters: {a: 1, b: 2, c: 3}\nstates: [y, h1, h2, h3]\n"
        "dynamics: {y: -y, h1: h2, h2: h3, h3: -a*h1 - b*h2 - c*h3}\nmeasurements: {z: y}\n"
    ))  # fmt: skip
    assert {m.eigenvalue for m in cubic.modes} == {"roots of s**3 + c*s**2 + b*s + a"}
    assert cubic.condition == "c > 0 and a - b*c < 0 and a > 0"


@pytest.mark.parametrize("seed", range(20))
def test_a_change_of_coordinates_that_moves_changes_no_verdict(system, seed):
    """x = T(t) z with shears by t and sin(t): the hidden directions move, the hidden solutions die or not as before."""
    source = random.Random(seed)
    rate = source.choice([-1, 0, 1])
    f, df = source.choice([("t", "1"), ("sin(3*t)", "3*cos(3*t)"), ("t^2", "2*t"), ("cos(t)", "-sin(t)")])
    # z: y' = -y, h' = rate h; x1 = y, x2 = h, x3 = y + f h (so x3' = -y + f' h + f rate h), seen: y
    text = (
        f"states: [x1, x2, x3, x4]\ndynamics:\n  x1: -x1\n  x2: {rate}*x2\n  x3: -x1 + ({df})*x2 + ({f})*({rate})*x2\n"
        f"  x4: -2*x4 + ({f})*x1\nmeasurements: {{y1: x1, y2: x3 - ({f})*x2, y3: x4}}\n"
    )
    found = structure_of(system(text))
    assert found.dimension == 1
    assert found.verdict == ("detectable" if rate < 0 else "not detectable")
    assert [m.eigenvalue for m in found.modes] == [str(rate)]


def test_what_moves_by_time_varying_coefficients_is_left_open_with_its_period(system):
    found = structure_of(system(
        "states: [y, h]\nparameters: {w: 2}\ndynamics: {y: -y, h: (cos(w*t) - 1)*h}\nmeasurements: {z: y}\n"
    ))  # fmt: skip
    assert (found.verdict, found.modes) == ("undecided", ())
    assert found.period == pytest.approx(3.141592653589793)


def test_a_part_that_stays_decides_beside_one_that_moves_in_time(system):
    text = "states: [y, h, k]\ndynamics: {{y: -y, h: {h}, k: {k}}}\nmeasurements: {{z: y}}\n"
    by_columns = structure_of(system(text.format(h="t*h", k="0")))
    by_rows = structure_of(system(text.format(h="t*h + k*cos(t)", k="0*k")))
    assert by_columns.verdict == by_rows.verdict == "not detectable"
    assert [m.eigenvalue for m in by_columns.modes] == ["0"]
    decaying = structure_of(system(text.format(h="t*h", k="-k")))
    assert decaying.verdict == "undecided"


def test_frozen_eigenvalues_decide_nothing(system):
    """Markus and Yamabe: -1/2 ± i frozen at every instant, and exp(t/2) among the solutions."""
    a = "-1 + 3/2*cos(t)^2", "1 - 3/2*sin(t)*cos(t)", "-1 - 3/2*sin(t)*cos(t)", "-1 + 3/2*sin(t)^2"
    found = structure_of(system(
        f"states: [y, h1, h2]\ndynamics:\n  y: -y\n  h1: ({a[0]})*h1 + ({a[1]})*h2\n"
        f"  h2: ({a[2]})*h1 + ({a[3]})*h2\nmeasurements: {{z: y}}\n"
    ))  # fmt: skip
    assert found.verdict == "undecided"
    assert found.period is not None


def test_the_structure_on_critical_conditions_and_at_the_files_values(system):
    model = system(
        "states: [a, v, r, o, w]\nparameters: {g: {value: 9.8, assume: positive}, p: 0.001, q: 0.001}\n"
        "dynamics: {a: o, v: g*a + w, r: v, o: p*o, w: q*w}\nmeasurements: {y1: v, y2: r}\n"
    )
    found = analyze(model).structure
    assert (found.dimension, found.verdict) == (0, "observable")
    assert found.at_values.verdict == "not detectable"
    assert {one.condition: (one.structure.verdict, one.structure.condition) for one in found.critical} == {
        "q = 0": ("not detectable", ""),
        "q = p": ("depends", "p < 0"),
    }


def test_periods_of_several_angles_are_common_or_not_there(system):
    text = "states: [y, h]\ndynamics: {{y: -y, h: ({f})*h}}\nmeasurements: {{z: y}}\n"
    assert structure_of(system(text.format(f="cos(2*t) + cos(3*t)"))).period == pytest.approx(
        2 * 3.141592653589793
    )
    assert structure_of(system(text.format(f="cos(t) + cos(pi*t)"))).period is None
    assert structure_of(system(text.format(f="cos(t) + t"))).period is None


def test_what_decays_generically_may_stay_at_the_files_values(system):
    found = hidden(system, "a: 0", "-a^2*h1")
    assert (found.verdict, found.at_values.verdict) == ("detectable", "not detectable")
    assert [(m.kind, m.kind_there) for m in found.modes if m.eigenvalue != "-1"] == [("decaying", "neutral")]


def test_an_even_polynomial_never_decays_whatever_its_coefficients(system):
    """s⁴ + 2√2 s² + c: no rational coefficients, no factors found, and yet no doubt."""
    found = structure_of(system(
        "states: [y, h1, h2, h3, h4]\n"
        "dynamics: {y: -y, h1: h2, h2: h3, h3: h4, h4: -(2*sqrt(2)*h3 + 5*h1)}\nmeasurements: {z: y}\n"
    ))  # fmt: skip
    assert (found.verdict, {m.kind for m in found.modes}) == ("not detectable", {"growing"})
