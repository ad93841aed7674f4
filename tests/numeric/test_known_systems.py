"""Random systems whose rank is known by construction: the Gramian shows it and decides none above it."""

import numpy as np
import pytest

from obscli.numeric.errors import TooManyStepsError
from obscli.numeric.leak import leak_of


SEEDS = range(60)
VALUES = {"w": 0.7, "v": 1.3, "c1": 1.1, "c2": -0.6, "c3": 0.8, "c4": 1.7, "c5": 0.9, "c6": -1.2}

#: Bounds are standard deviations of random roundings.
OVER = 3


def build(known, seed):
    built = known.build(seed, breakable=seed % 2 == 0)
    text = built.text
    for name, value in VALUES.items():
        text = text.replace(f"{name}: null", f"{name}: {value}")
    assert "null" not in text
    return built, text


@pytest.fixture(scope="module")
def all_found(known, system, numeric):
    """By seed: what was built and what was found, None where it takes too many steps."""
    result = {}
    for seed in SEEDS:
        built, text = build(known, seed)
        try:
            result[seed] = built, numeric(system(text))
        except TooManyStepsError:
            result[seed] = built, None
    return result


def test_almost_none_takes_too_many_steps(all_found):
    assert sum(found is None for _, found in all_found.values()) <= 1


@pytest.mark.parametrize("seed", SEEDS)
def test_the_rank_is_the_one_built_in(all_found, seed):
    built, found = all_found[seed]
    if found is None:
        pytest.skip("too many steps")
    ranks = found.spaces.rank[found.spaces.decided]
    assert (ranks <= built.rank).all()
    assert found.rank == built.rank
    assert found.conclusive.mean() > 0.8


@pytest.mark.parametrize("seed", SEEDS)
def test_exact_combinations_do_not_leak(all_found, exact, seed):
    _, found = all_found[seed]
    if found is None:
        pytest.skip("too many steps")
    proved = exact(found.system.system)
    rows, errors = found.system.covectors(
        [c.coefficients for c in proved.combinations], found.horizon.instants
    )
    leak = leak_of(found.spaces, rows, errors)
    ends = found.conclusive[:, None] & np.isfinite(leak.chi)
    assert (leak.chi <= OVER * leak.bound)[ends].all()
    assert ends.any()


@pytest.mark.parametrize("seed", SEEDS)
def test_hidden_directions_lie_in_the_kernel(all_found, seed):
    """The outputs do not show a direction that was hidden: |M D⁻¹ d| is rounding, of M and of d."""
    built, found = all_found[seed]
    if found is None or not built.hidden:
        assert found is None or found.rank == built.n
        return
    g = found.spaces.gramian
    functions = {"sin": np.sin, "cos": np.cos, "exp": np.exp}
    for i in (20, 149):
        values = {**VALUES, **functions, "t": found.horizon.instants[i]}
        for direction in built.hidden:
            d = np.zeros(built.n)
            for state, text in direction.items():
                d[int(state[1:]) - 1] = eval(text.replace("^", "**"), {"__builtins__": {}}, values)
            v = d / g.units[i]
            seen = np.linalg.norm(g.matrices[i] @ v)
            # components of d are sums of a few terms that may cancel: 1e-14 of the largest, column by column
            rounding = (
                1e-14 * np.linalg.norm(g.matrices[i], axis=0) @ (np.abs(v) + np.abs(d).max() / g.units[i])
            )
            assert seen <= 6 * found.spaces.noise_along(v[:, None], i)[0] + rounding


@pytest.mark.parametrize("seed", range(0, 60, 6))
def test_a_rank_that_a_broken_link_takes_away_is_gone(known, system, numeric, seed):
    """At a critical value, a link of a chain zero, the rank is lower by the states behind it."""
    built, text = build(known, seed)
    for name, rank in built.critical.items():
        broken = text.replace(f"{name}: {VALUES[name]}", f"{name}: 0")
        found = numeric(system(broken))
        assert found.rank == rank
        assert (found.spaces.rank[found.spaces.decided] <= rank).all()


def test_chains_that_break_are_among_them(known):
    assert sum(bool(build(known, seed)[0].critical) for seed in range(0, 60, 6)) >= 4


@pytest.mark.parametrize("seed", SEEDS)
def test_the_definition_decides_no_rank_above_the_known_one(known, system, numeric, seed):
    built, text = build(known, seed)
    found = numeric(system(text), method="quadrature", samples=10)
    assert (found.spaces.rank[found.spaces.decided] <= built.rank).all()
