"""The smallest and the emptiest systems have the rank that one sees at once; so have coefficients that cancel."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from obscli.numeric.echelon import echelon_curves
from obscli.numeric.errors import NotComputableError
from obscli.numeric.summary import finding_of


PLAIN = [
    ("nothing is measured", "states: [a, b]\nA: [[0, 1], [0, 0]]\nH: [[0, 0]]\n", 0),
    ("one state, not measured", "states: [a]\nA: [[0]]\nH: [[0]]\n", 0),
    ("one constant", "states: [a]\nA: [[0]]\nH: [[1]]\n", 1),
    ("one state that decays", "states: [a]\nA: [[-2]]\nH: [[1]]\n", 1),
    ("one state that grows", "states: [a]\nA: [[3]]\nH: [[1]]\n", 1),
    ("no state moves", "states: [a, b]\nA: zeros(2, 2)\nH: [[1, t]]\n", 2),
    ("no state moves, coupled", "states: [a, b]\nA: zeros(2, 2)\nH: [[1, 2]]\n", 1),
    ("full rank", "states: [a, b, c]\nA: [[0, 1, 0], [0, 0, 1], [-1, -2, -3]]\nH: [[1, 0, 0]]\n", 3),
    ("all states measured", "states: [a, b]\nA: [[0, 5], [-5, 0]]\nH: eye(2)\n", 2),
    ("a state that never appears", "states: [a, b, c]\nA: [[0, 1, 0], [-1, 0, 0], [0, 0, -3]]\nH: [[1, 0, 0]]\n", 2),
    ("a state that is only driven", "states: [a, b, c]\nA: [[0, 1, 0], [-1, 0, 0], [1, 1, -3]]\nH: [[1, 0, 0]]\n", 2),
    ("an output that is zero", "states: [a, b]\nA: [[0, 1], [0, 0]]\nH: [[1, 0], [0, 0]]\n", 2),
    ("a long chain", f"states: [{', '.join(f'x{k}' for k in range(1, 9))}]\nA: {{{', '.join(f'x{k}: {{x{k + 1}: 1}}' for k in range(1, 8))}}}\nH: {{y: {{x1: 1}}}}\n", 8),
]  # fmt: skip


@pytest.mark.parametrize(("text", "rank"), [pytest.param(*one[1:], id=one[0]) for one in PLAIN])
def test_the_rank_is_the_obvious_one(numeric, exact, system, text, rank):
    found = numeric(text)
    assert found.rank == rank == exact(system(text)).at_values.rank
    assert found.conclusive[-1]
    assert (found.spaces.rank[found.spaces.decided] <= rank).all()
    kernel = found.spaces.kernel(-1)
    assert kernel.shape == (found.system.n, found.system.n - rank)
    gap = found.spaces.gap[-1]
    assert np.isnan(gap) if rank == 0 else gap >= 100


@pytest.mark.parametrize("text", [one[1] for one in PLAIN])
def test_the_summary_says_the_same(numeric, exact, system, text):
    found = numeric(text)
    summary = finding_of(found, bases=True)
    assert dict(summary.states) == dict(exact(system(text)).states)
    last = summary.points[-1]
    assert (last.rank, last.decided, last.gap is None) == (found.rank, True, found.rank == 0)
    basis = np.array(last.basis).reshape(found.rank, found.system.n)
    np.testing.assert_allclose(basis @ basis.T, np.eye(found.rank), atol=1e-13)
    kernel = found.spaces.gramian.units[-1][:, None] * found.spaces.kernel(-1)
    assert np.abs(basis @ kernel).max(initial=0) < 1e-12
    assert (last.weakest is None) == (found.rank == 0)
    assert echelon_curves(found) is not None


@pytest.mark.parametrize("order", ["a, b, c", "a, c, b", "b, a, c", "b, c, a", "c, a, b", "c, b, a"])
@pytest.mark.parametrize(
    "body",
    ["A: {a: {c: 1}, c: {a: -1}}\nH: {y: {a: 1}}\n", "A: {c: {a: t}}\nH: {y: {a: 1}, z: {a: t, c: 1}}\n"],
)
def test_a_state_that_never_appears_may_stand_anywhere(numeric, order, body):
    """A column of zeros has no error, but the singular values have: they are rounded to eps of the largest."""
    found = numeric(f"states: [{order}]\n{body}")
    assert (found.spaces.rank[found.spaces.decided] == 2).all()
    assert found.rank == 2
    assert finding_of(found).states == {"a": "observable", "b": "unobservable", "c": "observable"}


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10**6))
def test_random_systems_with_a_state_that_never_appears(numeric, seed):
    source = np.random.default_rng(seed)
    k = int(source.integers(2, 6))
    A = source.integers(-9, 10, (k, k)) / 8
    names = [f"x{j}" for j in source.permutation(k + 1)]  # x0 appears nowhere
    rows = "".join(
        f"  x{i + 1}: {{{', '.join(f'x{j + 1}: {A[i, j]}' for j in range(k))}}}\n" for i in range(k)
    )
    text = f"states: [{', '.join(names)}]\nA:\n{rows}H: {{y: {{x1: 1, x2: 1}}}}\ninterval: {{stop: 4, samples: 10}}\n"
    found = numeric(text)
    assert (found.spaces.rank[found.spaces.decided] <= k).all()


@pytest.mark.parametrize("size", ["1", "1/10^6", "1/10^10", "1/10^14"])
@pytest.mark.parametrize("scaling", ["automatic", "none"])
def test_states_of_small_size_that_are_coupled(numeric, size, scaling):
    """Only b + 3 c is seen, of whatever size: in the file's units its column is small, and the rounding is not."""
    text = (
        f"parameters: {{e: {size}}}\nstates: [a, b, c, d]\n"
        "A: {a: {d: 1, b: e, c: 3*e}, d: {a: -1, b: 0.3*e, c: 0.9*e}}\nH: {y: {a: 1}}\ninterval: {stop: 10, samples: 20}\n"
    )
    found = numeric(text, scaling=scaling)
    assert (found.spaces.rank[found.spaces.decided] <= 3).all()
    assert found.rank == 3 or (scaling, size) == ("none", "1/10^14")


def test_a_direction_unseen_at_first_is_seen_later(numeric):
    """y = a + max(0, …) would not be analytic; y = a + t⁴⁰ b is, and b is below rounding at the start."""
    found = numeric("states: [a, b]\nA: zeros(2, 2)\nH: [[1, 't^40']]\ninterval: {stop: 2, samples: 100}\n")
    assert found.rank == 2
    assert found.conclusive[-1]


CANCELLING = {
    "a product of parameters": ("{a: 1/3}", "3*a - 1", 1),
    "two parameters": ("{a: 3, b: (1 + sqrt(2))^2 - 2*sqrt(2)}", "a - b", 1),
    "a number and a parameter": ("{a: (1 + sqrt(2))^2 - 2*sqrt(2)}", "a - 3", 1),
    "big parameters": ("{a: 10^9, b: 10^9}", "a - b", 1),
    "a small difference": ("{a: 1.000001, b: 1}", "a - b", 2),
    "sine and cosine": ("{a: 0.3}", "sin(a)^2 + cos(a)^2 - 1", 1),
    "in time": ("{a: 0.3}", "sin(a*t)^2 + cos(a*t)^2 - 1", 1),
}


@pytest.mark.parametrize("name", CANCELLING)
def test_an_entry_that_is_zero_but_for_rounding_is_no_information(numeric, exact, system, name):
    """y1 = a, y2 = (what cancels) b: in units of the Gramian 1e-16 is as good as 1, but for its error."""
    parameters, entry, rank = CANCELLING[name]
    model = system(f"parameters: {parameters}\nstates: [x, y]\nA: zeros(2, 2)\nH: [[1, 0], [0, '{entry}']]\n")
    assert exact(model).at_values.rank == rank
    found = numeric(model)
    assert (found.spaces.rank[found.spaces.decided] <= rank).all()
    assert found.rank == rank


def test_partial_sums_that_cancel_are_no_information(numeric, exact, system):
    """a + b + c with a = −c is b, and both outputs are the same; in doubles a + b − a is 1.5 b."""
    model = system(
        "parameters: {a: 1e8, b: 1e-8, c: -1e8}\nstates: [x, y]\nA: zeros(2, 2)\nH: [['a + b + c', 1], [b, 1]]\n"
    )
    assert exact(model).at_values.rank == 1
    assert numeric(model).rank == 1


@pytest.mark.parametrize(
    ("A", "H"),
    [
        ("[[0, 1, 0], [0, 0, 0], [0, 0, 0]]", "[[1, 0, 1e155]]"),
        ("[[0, 1, 0], [0, 0, 0], [0, 0, 0]]", "[[1, 0, 1e170]]"),
        ("[[1e200, 1, 0], [0, 0, 0], [0, 0, 0]]", "[[1, 0, 1e300]]"),
    ],
)
def test_entries_whose_squares_are_too_large_decide_nothing_wrong(numeric, A, H):
    """x1 and x2 with x3: rank 2 or undecided, and no warning."""
    found = numeric(f"states: [x1, x2, x3]\nA: {A}\nH: {H}\n")
    assert (found.spaces.rank[found.spaces.decided] <= 2).all()
    for i in (0, -1):
        assert found.spaces.kernel(i).shape == (3, 3 - found.spaces.rank[i])


@pytest.mark.parametrize("entry", ["1/(t - 3.3)", "1/(t - 3.3)^2"])
def test_a_pole_inside_the_interval_is_no_information_lost_in_silence(numeric, entry):
    text = f"states: [x1, x2]\nA: [[0, '{entry}'], [0, 0]]\nH: [[1, 0]]\ninterval: {{stop: 10, samples: 7}}\n"
    with pytest.raises(NotComputableError, match=r"near t = 3\.3|more than 20000 steps"):
        numeric(text)
