"""Functions left open follow a sample motion: smooth, away from zero, on their relations, the same every time."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from obscli.numeric.errors import NotComputableError
from obscli.numeric.motion import Tones
from obscli.numeric.numeric_system import NumericSystem
from obscli.numeric.program import jet


def body(entries, functions, extra=""):
    return f"{extra}functions: {functions}\nstates: [x]\nA: [[0]]\nH: [[{entries}]]\n"


@pytest.fixture(scope="session")
def motion_of(system):
    def make(entries, functions, start=0.0, stop=10.0, extra=""):
        return NumericSystem(system(body(entries, functions, extra)), start, stop).motion

    return make


tones = st.lists(
    st.tuples(st.floats(0.1, 1), st.floats(0.1, 5), st.floats(0, 6.3)), min_size=1, max_size=3
).map(lambda parts: Tones(1.5, 0.7, tuple(parts)))


@settings(max_examples=60, deadline=None)
@given(tones, st.floats(-10, 10), st.integers(1, 3))
def test_derivatives_of_tones(one, t, order):
    """The central difference of the derivative before: off by h²/6 of the third next, and rounding."""
    h = 1e-4
    at = np.array([t - h, t + h])
    before = one.value(at, order - 1)
    size = sum(a * rate ** (order + 2) for a, rate, _ in one.tones)
    lower = 1.5 + sum(a * rate ** (order - 1) * (1 + abs(rate * t)) for a, rate, _ in one.tones)
    slope = (before[1] - before[0]) / (2 * h)
    assert abs(slope - one.value(np.array([t]), order)[0]) <= size * h**2 + 1e-15 * lower / h


def test_functions_stay_away_from_zero(motion_of):
    """So that 1/f, log f and the root of f exist; and they move."""
    values = motion_of("1/f + log(g) + sqrt(k)", "[f, g, k]").values(np.linspace(0, 10, 2001), {})
    for name in "fgk":
        assert values[name].min() > 0.05
        assert np.ptp(values[name]) > 0.3
    assert np.abs(np.corrcoef([values[name] for name in "fgk"]) - np.eye(3)).max() < 0.9


def test_derivatives_come_with_the_functions(motion_of):
    t = np.linspace(0, 10, 7)
    values = motion_of("f", "[f]").values(t, {"f": 3})
    h = 1e-4
    before, after = (motion_of("f", "[f]").values(t + one, {"f": 2}) for one in (-h, h))
    for k in (1, 2, 3):
        slope = (after[jet("f", k - 1)] - before[jet("f", k - 1)]) / (2 * h)
        np.testing.assert_allclose(values[jet("f", k)], slope, atol=1e-6)


def test_the_motion_is_the_same_every_time(motion_of):
    t = np.linspace(0, 10, 11)
    for functions in ("[f, g]", "{f: {invariant: f^2 + g^2 - 4}, g: {}}", "{f: {derivative: -f*g}, g: {}}"):
        first, second = (motion_of("f + g", functions).values(t, {}) for _ in range(2))
        for name in ("f", "g"):
            assert (first[name] == second[name]).all()


RELATIONS = [
    ("f + g + k", "{f: {invariant: f^2 + g^2 + k^2 - r^2}, g: {}, k: {}}", lambda v: v["f"] ** 2 + v["g"] ** 2 + v["k"] ** 2 - 9.81**2),
    ("f + g", "{f: {invariant: f*g - 1}, g: {}}", lambda v: v["f"] * v["g"] - 1),
    ("f + g", "{f: {invariant: f - exp(-g)}, g: {}}", lambda v: v["f"] - np.exp(-v["g"])),
    ("f + g", "{f: {invariant: f - sin(t)}, g: {}}", lambda v: v["f"] - np.sin(np.linspace(0, 10, 57))),
]  # fmt: skip


@pytest.mark.parametrize(("entries", "functions", "relation"), RELATIONS)
def test_relations_hold_at_every_instant(motion_of, entries, functions, relation):
    values = motion_of(entries, functions, extra="parameters: {r: 9.81}\n").values(np.linspace(0, 10, 57), {})
    size = 1 + max(np.abs(one).max() for one in values.values())
    # Gauss–Newton stops at 1e-15 of the size of the functions; a product of two has that of both
    assert np.abs(relation(values)).max() <= 1e-13 * size**2
    free = {name: np.ptp(one) for name, one in values.items()}
    assert max(free.values()) > 0.1


def test_a_relation_moves_only_what_it_names(motion_of):
    t = np.linspace(0, 10, 9)
    tied = motion_of("f + g + k", "{f: {invariant: f*g - 1}, g: {}, k: {}}").values(t, {})
    loose = motion_of("f + g + k", "[f, g, k]").values(t, {})
    assert (tied["k"] == loose["k"]).all()
    assert (tied["f"] != loose["f"]).any()


@pytest.mark.parametrize(
    ("functions", "text"),
    [
        ("{f: {invariant: f^2 + 1}}", r"no sample motion .* --fix f=sin\(t\)"),
        ("{f: {invariant: f^2 + 1/10^6}}", "no sample motion"),
        ("{f: {invariant: f - 2}, g: {invariant: f - 3}}", "no sample motion"),
        ("{f: {derivative: 1, invariant: f^2 - 1}}", "do not hold along a sample motion"),
        ("{f: {derivative: f*g, invariant: f^2 + 1}, g: {}}", "no sample motion"),
        ("{f: {derivative: f^2*f*9}}", "^f: the rules cannot be followed beyond t = "),
    ],
)
@pytest.mark.filterwarnings("ignore:.*encountered in matmul")  # seen apart, in test_rules
def test_motions_that_cannot_be_found_are_explained(motion_of, functions, text):
    with pytest.raises(NotComputableError, match=text):
        motion_of("f", functions)


@pytest.mark.parametrize(
    ("functions", "text"),
    [
        ("{f: {invariant: f*g - 1}, g: {}}", "derivatives of f, which satisfies a relation, are not sampled"),
        ("{f: {derivative: -f}, g: {}}", "a derivative of f, which has a rule, is not sampled"),
    ],
)
def test_derivatives_that_are_not_sampled_are_named(motion_of, functions, text):
    motion = motion_of("f + g", functions)
    with pytest.raises(NotComputableError, match=text):
        motion.values(np.array([1.0]), {"f": 1})


def test_a_relation_among_ruled_functions_is_kept_by_the_rule(motion_of):
    values = motion_of("f", "{f: {derivative: g, invariant: f^2 + g^2 - 2}, g: {derivative: -f}}").values(
        np.linspace(0, 10, 33), {}
    )
    np.testing.assert_allclose(values["f"] ** 2 + values["g"] ** 2, 2, atol=1e-12)
    assert np.ptp(values["f"]) > 2


def test_the_motion_reaches_over_the_interval(motion_of):
    """Its slowest tone makes one turn at least, wherever the interval lies; its rate is that of the fastest."""
    for start, stop in ((0, 1e-3), (100, 1e5)):
        motion = motion_of("f", "[f]", start, stop)
        assert np.ptp(motion.values(np.linspace(start, stop, 101), {})["f"]) > 0.3
        assert 2 * np.pi * 3.28 / (stop - start) <= motion.rate <= 2 * np.pi * 4.92 / (stop - start)
