"""Stationary systems of reducible ones: identities that they satisfy, and the same observable combinations."""

import random
from fractions import Fraction

import pytest
from flint import fmpq, fmpq_mat, nmod_mat

from obscli.exact.errors import UndecidedError
from obscli.exact.exact_system import read_system
from obscli.exact.exponential_polynomial import Expansion
from obscli.exact.hidden_dynamics import is_constant
from obscli.exact.lift_finding import NotReducible, Stationary
from obscli.exact.modes import Modes
from obscli.exact.prove import prove
from obscli.exact.restore import Restorer
from obscli.exact.rows import combined, rate_of
from obscli.exact.series import PRIME
from obscli.exact.stationary import find_stationary, stationary_of
from obscli.model.covector import parse_scalar
from obscli.model.expression import Apply, Number, Power, Product, Sum, Symbol
from obscli.model.library import bundled_model, bundled_models
from obscli.model.notation import covector_text
from obscli.model.reader import load, read_text


def bundled(name, stage=None):
    return next(one for one in load(bundled_model(name)).systems if one.stage == stage)


def lifts(found):
    """All lifts that were found, those in the same variables once."""
    full = None if found.full is None else found.full.lift
    every = [lift for lift in (full, found.smallest, found.observable, found.same_order) if lift is not None]
    return list({tuple(texts(found.system, lift.variables)): lift for lift in every}.values())


def holds(system, lift):
    """V' + V A = A_z V and H = H_z V, in a field of its own, with constant A_z, H_z."""
    constant = [e for matrix in (lift.A, lift.H) for row in matrix for e in row.values()]
    exact = read_system(system, [*constant, *(e for form in lift.variables for e in form.values())])
    assert is_constant(exact.field, dict(enumerate(map(exact.interpreter.read, constant))))
    V = [exact.row(form) for form in lift.variables]

    def image(row):
        return combined(exact.field, [(exact.interpreter.read(e), V[k]) for k, e in row.items()])

    assert all(dict(rate_of(exact, v)) == image(row) for v, row in zip(V, lift.A, strict=True))
    assert all(dict(h) == image(row) for h, row in zip(exact.H, lift.H, strict=True))


def texts(system, forms):
    return [covector_text(form, system.state_names) for form in forms]


def agrees_with_the_observability_matrix(proof, found):
    assert found.agrees
    assert texts(found.system, found.combinations) == texts(found.system, proof.echelon)


@pytest.mark.parametrize("name", sorted(bundled_models()))
def test_every_lift_of_a_bundled_model_is_one(name):
    for system in load(bundled_models()[name]).systems:
        proof = prove(system, range(system.n))
        if system.discrete:
            with pytest.raises(UndecidedError, match="continuous time"):
                stationary_of(proof)
            continue
        found = stationary_of(proof)
        if isinstance(found, Stationary):
            agrees_with_the_observability_matrix(proof, found)
            assert found.rank == found.observable.n <= found.smallest.n
            for lift in lifts(found):
                holds(system, lift)
                assert len(set(lift.names)) == lift.n
                for own, form in zip(lift.names, lift.variables, strict=True):
                    assert own not in system.state_names or texts(system, [form]) == [own]


@pytest.mark.parametrize(("stage", "smallest"), [("stage_1", 19), ("stage_2", 21), ("stage_3", 21)])
def test_numbers_of_the_paper(stage, smallest):
    found = find_stationary(bundled("horizontal", stage))
    assert (found.full.n, found.smallest.n, found.rank) == (108, smallest, 16)
    assert found.same_order.n == 24
    assert len(found.functions.f) == 5
    assert found.left_out == ()
    assert sum(len(chain.forms) for chain in found.chains) == 16


def test_the_chain_of_the_third_output_has_five_links_as_in_the_paper():
    first = find_stationary(bundled("horizontal", "stage_1")).chains[0]
    assert (first.output, len(first.forms)) == ("y3", 5)


def value(expression, known):
    """The value modulo PRIME of an expression in parameters and cosines and sines of parameters."""
    match expression:
        case Number(number):
            return number.numerator * pow(number.denominator, -1, PRIME) % PRIME
        case Symbol(name):
            return known[name]
        case Apply(function, Symbol(name)):
            return known[f"{function} {name}"]
        case Power(base, exponent):
            return pow(value(base, known), int(exponent), PRIME)
        case Sum(terms):
            return sum(value(term, known) for term in terms) % PRIME
        case Product(factors):
            result = 1
            for factor in factors:
                result = result * value(factor, known) % PRIME
            return result
    raise AssertionError(expression)


def stationary_rank(lift, known):
    """The rank of the observability matrix of a lift from A and H alone."""
    A = nmod_mat(lift.n, lift.n, PRIME)
    for i, row in enumerate(lift.A):
        for j, entry in row.items():
            A[i, j] = value(entry, known)
    rows = []
    level = nmod_mat(len(lift.H), lift.n, PRIME)
    for i, row in enumerate(lift.H):
        for j, entry in row.items():
            level[i, j] = value(entry, known)
    for _ in range(lift.n):
        rows += level.table()
        level = level * A
    return nmod_mat(len(rows), lift.n, [int(e) for row in rows for e in row], PRIME).rank()


def test_the_observable_dimension_does_not_depend_on_the_lift():
    found = find_stationary(bundled("horizontal", "stage_1"))
    tangent = 12345
    below = pow(1 + tangent**2, -1, PRIME)
    known = {"omega": 71, "omega_ie": 1009, "g": 31, "phi": 5}
    known |= {"cos phi": (1 - tangent**2) * below % PRIME, "sin phi": 2 * tangent * below % PRIME}
    assert [stationary_rank(lift, known) for lift in lifts(found)] == [16] * 4


WAVES = [
    "1",
    "t",
    "t^2",
    "cos(a*t)",
    "sin(a*t)",
    "sin(2*a*t)",
    "cos(b*t)",
    "exp(-t)",
    "exp(c*t)*cos(a*t)",
    "t*sin(b*t)",
]


def entry(source, waves):
    terms = [f"{source.choice([1, -1, 2, 3])}*{wave}" for wave in source.sample(waves, source.randint(1, 2))]
    return " + ".join(terms)


def random_reducible(source):
    """x₁' = A₁₁ x₁ + A₁₂(t) x₂, x₂' = 0, y = H₁ x₁ + H(t) x₂, H₁ constant or not."""
    constantly = source.random() < 0.6
    moving, constant, outputs = source.randint(1, 3), source.randint(1, 4), source.randint(1, 2)
    waves = source.sample(WAVES, 3)
    names = [f"x{i}" for i in range(moving)] + [f"c{i}" for i in range(constant)]
    lines = []
    for i in range(moving):
        terms = [f"{source.choice([1, -1, 2])}*x{j}" for j in range(moving) if source.random() < 0.5]
        terms += [f"({entry(source, waves)})*c{j}" for j in range(constant) if source.random() < 0.5]
        lines.append(f"  x{i}: {' + '.join([*terms, 'x0'])}")
    rows = []
    for i in range(outputs):
        seen = [
            f"{source.choice([1, -1, 2])}" if constantly else f"({entry(source, waves)})"
            for _ in range(moving)
        ]
        terms = [f"{h}*x{j}" for j, h in enumerate(seen) if source.random() < 0.5]
        terms += [f"({entry(source, waves)})*c{j}" for j in range(constant) if source.random() < 0.6]
        rows.append(f"  y{i}: {' + '.join([*terms, 'c0'])}")
    return read_text(
        f"parameters: {{a: 2, b: 3, c: 5}}\nstates: [{', '.join(names)}]\ndynamics:\n"
        + "\n".join(lines)
        + "\nmeasurements:\n"
        + "\n".join(rows),
        "random.yaml",
    ).systems[0]


@pytest.mark.parametrize("seed", [*range(14), 24, 27])
def test_random_reducible_systems_agree_with_the_observability_matrix(seed):
    system = random_reducible(random.Random(seed))
    proof = prove(system, range(system.n))
    found = stationary_of(proof)
    agrees_with_the_observability_matrix(proof, found)
    assert found.full is not None
    assert found.rank <= found.smallest.n <= found.full.n
    for lift in lifts(found):
        holds(system, lift)


def rotated(source):
    """A constant pair seen from axes that turn by half the frequency in A(t): x = R(t) z."""
    p, q, r, s, w = (source.choice([-3, -2, -1, 1, 2, 3]) for _ in range(5))
    half, rest = Fraction(p + s, 2), Fraction(p - s, 2)
    even, odd = Fraction(q + r, 2), Fraction(q - r, 2) - w
    c, d = f"cos({2 * w}*t)", f"sin({2 * w}*t)"
    text = (
        "states: [x1, x2, u]\ndynamics:\n"
        f"  x1: ({half} + ({rest})*{c} - ({even})*{d})*x1 + (({rest})*{d} + ({even})*{c} + ({odd}))*x2\n"
        f"  x2: (({rest})*{d} + ({even})*{c} - ({odd}))*x1 + ({half} - ({rest})*{c} + ({even})*{d})*x2\n"
        f"  u: {source.choice([-1, 2])}*u\nmeasurements:\n  y: u\n"
    )
    return read_text(text, "rotated.yaml").systems[0], fmpq_mat(2, 2, [p, q, r, s])


def rational(rows, n):
    entry = lambda e: fmpq(e.value.numerator, e.value.denominator)  # noqa: E731
    return fmpq_mat(n, n, [entry(row[j]) if j in row else fmpq(0) for row in rows for j in range(n)])


@pytest.mark.parametrize("seed", range(12))
def test_turning_axes_are_found(seed):
    system, constant = rotated(random.Random(seed))
    found = find_stationary(system)
    assert found.same_order is not None
    holds(system, found.same_order)
    own = rational(found.same_order.A, 3).charpoly()
    assert divmod(own, constant.charpoly())[1] == 0


@pytest.mark.parametrize(
    ("name", "exponents"), [("markus_yamabe", [-1, -1, fmpq(1, 2)]), ("wu", [-1, -1, -10])]
)
def test_exponents_of_known_periodic_systems(name, exponents):
    found = find_stationary(bundled(name))
    diagonal = fmpq_mat(3, 3, [exponents[i] if i == j else 0 for i in range(3) for j in range(3)])
    assert rational(found.same_order.A, 3).charpoly() == diagonal.charpoly()


@pytest.mark.parametrize(
    ("coefficient", "functions", "reason"),
    [
        ("1/t", "", "1/t is no polynomial, exponential, sine or cosine of time, nor a product of them"),
        ("tan(t)", "", "tan(t) is no polynomial"),
        ("tan(t/2)^3", "", "tan(t/2) is no polynomial"),
        ("1/cos(t)", "", "1/cos(t) is no polynomial"),
        ("1/(2 + sin(t))", "", "1/(2 + sin(t)) is no polynomial"),
        ("sqrt(t)", "", "sqrt(t) is no polynomial"),
        ("log(1 + t)", "", "log(1 + t) is no polynomial"),
        ("cos(t^2)", "", "sin, cos of t**2, which does not grow at a constant rate"),
        ("exp(-t^2)", "", "exp of "),
        ("sin(f)", "functions: [f]", "f is a function left open"),
        ("deriv(f)", "functions: [f]", "f is a function left open"),
        ("f", "functions: {f: {derivative: -f}}", "f is a function given by its derivative"),
    ],
)
def test_what_stands_in_the_way_is_named(coefficient, functions, reason):
    text = f"states: [p, q]\n{functions}\nA: zeros(2, 2)\nmeasurements:\n  y: p + {coefficient}*q\n"
    found = find_stationary(read_text(text, "test.yaml").systems[0])
    assert isinstance(found, NotReducible)
    [obstacle] = found.obstacles
    assert obstacle.entry == "H[y, q]"
    assert obstacle.place.startswith("test.yaml:5:")
    assert reason in obstacle.reason


def test_outputs_that_bring_ever_new_functions():
    text = "states: [x, h]\ndynamics:\n  x: cos(t)*x + h\n  h: -h\nmeasurements:\n  y: x\n"
    found = find_stationary(read_text(text, "test.yaml").systems[0])
    assert [obstacle.entry for obstacle in found.obstacles] == ["A[x, x]"]
    assert "new functions of time" in found.obstacles[0].reason


def test_moving_states_that_do_not_close_are_left_out():
    text = "states: [x, h]\ndynamics:\n  x: -x\n  h: t*h + x\nmeasurements:\n  y: x\n"
    found = find_stationary(read_text(text, "test.yaml").systems[0])
    assert found.left_out == ("h",)
    assert found.smallest.names == ("x",)
    assert found.full is None
    assert found.same_order is None


def test_more_variables_than_states_where_tones_are_heard_together():
    found = find_stationary(bundled("two_tones"))
    assert found.same_order is None
    assert (found.rank, len(found.combinations)) == (4, 2)


def test_new_names_differ_from_those_of_the_file():
    text = "states: [z1, z2]\nparameters: {z3: 1}\nA: zeros(2, 2)\nmeasurements:\n  y: cos(z3*t)*z1 + sin(z3*t)*z2\n"
    found = find_stationary(read_text(text, "test.yaml").systems[0])
    assert found.observable.names == ("z4", "z5")


PARTS = [
    "cos(sqrt(2)*t)",
    "sin(pi*t/3)",
    "cosh(a*t)",
    "2^t",
    "cos(t/3)",
    "sqrt(a^2 + 1)*t",
    "t",
    "cos(a*t)",
    "sin(b*t + 1)",
    "exp(-2*t)",
    "cos(3*a*t)",
    "exp(a*t)",
    "sin(a*t)^3",
    "t^2*cos(a*t - b*t)",
    "a/b",
]


@pytest.mark.parametrize("seed", range(12))
def test_expansion_is_a_homomorphism_that_commutes_with_the_derivative(seed):
    source = random.Random(seed)
    system = read_text("parameters: {a: 2, b: 3}\nstates: [x]\nA: [[0]]\nH: [[t]]\n", "test.yaml").systems[0]
    text = [f"({source.choice(PARTS)} - {source.randint(1, 3)}*{source.choice(PARTS)})" for _ in range(2)]
    expressions = [parse_scalar(system, one, "test") for one in [*text, f"{text[0]}*{text[1]}"]]
    exact = read_system(system, expressions)
    modes = Modes(exact)
    expand = Expansion(modes, Restorer(exact.interpreter))
    for element in map(exact.interpreter.read, expressions):
        expanded = expand(element)
        back = sum((c * modes.element(mode) for mode, c in expanded.items()), exact.field.zero)
        assert back == element
        rate = combined(exact.field, [(c, dict(modes.rate(mode))) for mode, c in expanded.items()])
        assert rate == expand(exact.field.derive(element))
