"""A basis in another form: T(t) S = C exactly, with T invertible; anything else is refused.

The claimed basis is C = T S with a T drawn at random: row operations I + f(t) E_ij, rows scaled by functions
without zeros, rows exchanged. T is unimodular up to the scaling, so it has to come back as it was put in.
"""

import random
from dataclasses import replace
from itertools import permutations

import pytest

from obscli.checks.claims import check_claims
from obscli.core.place import Place
from obscli.exact.analysis import Options, analyze
from obscli.exact.interpreter import Interpreter
from obscli.model.covector import parse_scalar
from obscli.model.expression import add, multiply, negate, number
from obscli.model.reader import read_text
from obscli.model.system import Claim, Quantity


HERE = Place("here", 1, 1)
FAST = Options(critical=False, certificate=False)
ZERO, ONE = number(0), number(1)
FUNCTIONS = ("2", "t", "t^2 - 3*t", "cos(w*t)", "sin(w*t)", "exp(-t)", "w", "1/w")
SCALES = ("-1", "2", "3/7", "w", "exp(t)", "2 + cos(w*t)", "1 + t^2")
EQUIVALENT = "proved exactly (equivalent: another basis of the same space)"


def _zero(system, *expressions):
    interpreter = Interpreter(system, expressions)
    return not any(interpreter.read(one) for one in expressions)


def _random_matrix(source, system, size):
    """Return an invertible matrix of functions of time."""

    def draw(texts):
        return parse_scalar(system, source.choice(texts), "T")

    T = [[ONE if i == j else ZERO for j in range(size)] for i in range(size)]
    for _ in range(source.randint(1, 3)):
        i, j = source.sample(range(size), 2)
        f = draw(FUNCTIONS)
        T[i] = [add(a, multiply(f, b)) for a, b in zip(T[i], T[j], strict=True)]
    for i in range(size):
        if source.random() < 0.4:
            f = draw(SCALES)
            T[i] = [multiply(f, a) for a in T[i]]
    source.shuffle(T)
    return T


def _times(T, basis):
    """Return T S, rows by state."""
    names = [s for row in basis for s in row]
    return [
        {s: add(ZERO, *(multiply(f, row[s]) for f, row in zip(line, basis, strict=True) if s in row))
         for s in names}
        for line in T
    ]  # fmt: skip


def _claimed(system, analysis, rows, at=None):
    basis = tuple(Quantity(f"row {k}", row, HERE) for k, row in enumerate(rows))
    claim = Claim("claims", HERE, at=at, basis=basis)
    [result] = check_claims(replace(system, claims=(claim,)), analysis)
    return result


def _read(system, transformation):
    return [[parse_scalar(system, text, "T") for text in line] for line in transformation]


@pytest.fixture(params=range(30))
def drawn(request, known):
    """A system, its analysis and a random T; the system has at least two observable combinations."""
    seed = request.param
    while known.build(seed, breakable=False).rank < 2:
        seed += 100
    system = read_text(known.build(seed, breakable=False).text, "known.yaml").systems[0]
    analysis = analyze(system, FAST)
    return system, analysis, _random_matrix(random.Random(seed), system, analysis.rank)


def _rearranged(system, T):
    """Whether each row of T has one entry only."""
    return all(sum(not _zero(system, entry) for entry in line) == 1 for line in T)


def test_the_matrix_put_in_comes_out(drawn):
    system, analysis, T = drawn
    basis = [one.coefficients for one in analysis.combinations]
    claimed = _times(T, basis)
    result = _claimed(system, analysis, claimed)

    assert result.verdict == "holds"
    if _rearranged(system, T):
        assert (result.reason, result.transformation) == ("proved exactly", ())
        return
    assert result.reason == EQUIVALENT
    found = _read(system, result.transformation)
    assert len(found) == len(found[0]) == analysis.rank
    assert _zero(system, *(add(a, negate(b)) for x, y in zip(found, T, strict=True)
                           for a, b in zip(x, y, strict=True)))  # fmt: skip
    product = _times(found, basis)
    assert _zero(system, *(add(x[s], negate(y[s])) for x, y in zip(product, claimed, strict=True) for s in x))


def _determinant(T):
    """Return the determinant by its definition."""
    size = len(T)
    terms = []
    for order in permutations(range(size)):
        odd = sum(order[i] > order[j] for i in range(size) for j in range(i + 1, size)) % 2
        terms.append(multiply(number(-1 if odd else 1), *(T[i][order[i]] for i in range(size))))
    return add(ZERO, *terms)


def test_the_matrix_is_invertible(drawn):
    system, analysis, T = drawn
    if analysis.rank > 5:
        pytest.skip("the definition of the determinant has too many terms")
    result = _claimed(system, analysis, _times(T, [one.coefficients for one in analysis.combinations]))
    if result.transformation:
        assert not _zero(system, _determinant(_read(system, result.transformation)))


def test_a_singular_matrix_is_refused(drawn):
    """One row of T made a combination of the others: the claimed rows span less."""
    system, analysis, T = drawn
    source = random.Random(5)
    f = parse_scalar(system, source.choice(FUNCTIONS), "T")
    i, j = source.sample(range(len(T)), 2)
    T[i] = [multiply(f, a) for a in T[j]]
    result = _claimed(system, analysis, _times(T, [one.coefficients for one in analysis.combinations]))

    assert (result.verdict, result.transformation) == ("fails", ())
    assert f"row {max(i, j)} is superfluous: it depends on the rows above it; 1 forgotten" in result.reason


def test_a_row_outside_the_space_is_refused(drawn):
    system, analysis, T = drawn
    if analysis.rank == system.n:
        return
    rows = _times(T, [one.coefficients for one in analysis.combinations])
    hidden = next(iter(analysis.unobservable[0]))
    rows[0] = {**rows[0], hidden: add(rows[0].get(hidden, ZERO), parse_scalar(system, "1 + t^2", "T"))}
    result = _claimed(system, analysis, rows)

    assert (result.verdict, result.transformation) == ("fails", ())
    assert "row 0 is not observable" in result.reason
    assert "row 1" not in result.reason


def test_a_row_too_few_is_refused(drawn):
    system, analysis, T = drawn
    rows = _times(T, [one.coefficients for one in analysis.combinations])
    result = _claimed(system, analysis, rows[1:])

    assert (result.verdict, result.transformation) == ("fails", ())
    assert result.reason.startswith("1 forgotten, for example ")


def test_the_proved_basis_rearranged_is_no_other_basis(drawn):
    system, analysis, _ = drawn
    rows = [one.coefficients for one in analysis.combinations]
    random.Random(1).shuffle(rows)
    rows[0] = {s: multiply(parse_scalar(system, "-2*exp(t)", "T"), e) for s, e in rows[0].items()}
    result = _claimed(system, analysis, rows)

    assert (result.verdict, result.reason, result.transformation) == ("holds", "proved exactly", ())


def test_at_values_the_matrix_is_that_of_these_values():
    text = (
        "parameters: {g: 10, w: 1/2}\nstates: [v, tilt, b]\ndynamics: {v: g*tilt + b}\nmeasurements: {y: v}\n"
        "claims:\n  - basis: [v + w*(g*tilt + b), v]\n"
        "  - {at: {w: 3}, basis: [v + w*(g*tilt + b), v]}\n"
        "  - {at: {w: 0}, basis: [v + w*(g*tilt + b), v]}\n"
        "  - {at: nominal, basis: [v + w*(g*tilt + b), v]}\n"
    )
    system = read_text(text, "values.yaml").systems[0]
    generic, three, zero, nominal = check_claims(system, analyze(system, FAST))

    assert generic.transformation == (("1", "w"), ("1", "0"))
    assert three.transformation == (("1", "3"), ("1", "0"))
    assert nominal.transformation == (("1", "1/2"), ("1", "0"))
    assert (zero.verdict, zero.transformation) == ("fails", ())
    assert "v is superfluous" in zero.reason
