"""Units of the states in which the rank is decided: where it is clear, it does not depend on them."""

import numpy as np
import pytest

from obscli.numeric.errors import NotComputableError


STATES = "states: {a: {scale: 1e3}, b: {scale: 1e-2}, c: {scale: k}}\n"
PLAIN = "states: [a, b, c]\n"
BODY = "parameters: {k: 5}\nA: {a: {b: 1}, b: {a: -4, c: cos(t)}}\nH: {y: {a: 1}}\ninterval: {stop: 8, samples: 10}\n"
NOISE = "noise: {P0_std: {a: 10, b: 0.1, c: 2*k}}\n"


@pytest.mark.parametrize("scaling", ["automatic", "scale", "prior", "none"])
@pytest.mark.parametrize("hidden", [False, True])
def test_the_rank_is_the_same_in_all_units(numeric, scaling, hidden):
    body = BODY.replace(", c: cos(t)", "") if hidden else BODY
    found = numeric(STATES + body + NOISE, scaling=scaling)
    assert found.scaling == scaling
    assert found.rank == (2 if hidden else 3)
    assert found.conclusive.all()


@pytest.mark.parametrize(
    ("scaling", "sizes"), [("scale", [1e3, 1e-2, 5]), ("prior", [10, 0.1, 10]), ("none", [1, 1, 1])]
)
def test_units_are_those_asked_for(numeric, scaling, sizes):
    found = numeric(STATES + BODY + NOISE, scaling=scaling)
    np.testing.assert_allclose(found.spaces.gramian.units, np.tile(sizes, (10, 1)), rtol=1e-15)


@pytest.mark.parametrize("method", ["quadrature", "lyapunov"])
def test_automatic_units_give_the_gramian_a_diagonal_of_ones(numeric, method):
    M = numeric(PLAIN + BODY, method=method, scaling="automatic").spaces.gramian.matrices
    np.testing.assert_allclose(np.einsum("ijj->ij", M), 1, rtol=1e-12)


def test_automatic_units_give_the_columns_of_the_root_their_clearness(numeric):
    """The clearest column gets length 1; one that is noisier, relative to its length, less by just that."""
    g = numeric(PLAIN + BODY, scaling="automatic").spaces.gramian
    size = np.linalg.norm(g.matrices, axis=1)
    np.testing.assert_allclose(size.max(axis=1), 1, rtol=1e-12)
    noise = np.sqrt(np.einsum("ijj->ij", g.error))
    np.testing.assert_allclose(noise / noise[:, :1], 1, rtol=1e-9)
    assert size.min() > 0.1


def test_the_files_sizes_are_taken_where_every_state_has_one(numeric):
    assert numeric(STATES + BODY).scaling == "scale"
    assert numeric(PLAIN + BODY).scaling == "automatic"
    assert numeric(STATES.replace(", c: {scale: k}", ", c: {}") + BODY).scaling == "automatic"


@pytest.mark.parametrize(
    ("states", "noise", "scaling", "message"),
    [
        (PLAIN, "", "scale", "--scaling scale needs `scale` of the states; missing for a, b, c"),
        ("states: {a: {scale: 1}, b: {}, c: {}}\n", "", "scale", "missing for b, c"),
        (PLAIN, "", "prior", "--scaling prior needs `P0_std` under `noise`; missing for a, b, c"),
        (PLAIN, "noise: {P0_std: {a: 1, c: 0}}\n", "prior", "missing for b"),
        (STATES.replace("1e3", "0"), "", "scale", "the size of a is not positive"),
        (STATES.replace("1e3", "-k"), "", "scale", "the size of a is not positive"),
        (PLAIN, "noise: {P0_std: {a: 1, b: 1, c: 0}}\n", "prior", "the size of c is not positive"),
    ],
)
def test_sizes_that_are_missing_or_wrong_are_named(numeric, states, noise, scaling, message):
    with pytest.raises(NotComputableError) as error:
        numeric(states + BODY + noise, scaling=scaling)
    assert message in str(error.value)


def test_extreme_sizes_change_the_clarity_not_the_rank(numeric):
    """Sizes 1e12 apart cost digits of the gap, and what is decided stays right."""
    states = "states: {a: {scale: 1e6}, b: {scale: 1e-6}, c: {scale: 1}}\n"
    for body, rank in ((BODY, 3), (BODY.replace(", c: cos(t)", ""), 2)):
        found = numeric(states + body, scaling="scale")
        assert (found.spaces.rank[found.spaces.decided] == rank).all()


@pytest.mark.parametrize("path", ["ins_calibration/horizontal.yaml", "ins_calibration/vertical.yaml"])
def test_the_rank_of_a_calibration_in_the_files_units(numeric, bundled, path):
    """Radians, rad/s, m/s² and pure numbers together."""
    given = bundled(path, "stage_1")
    plain, none = (numeric(given, scaling=one, samples=10) for one in ("automatic", "none"))
    assert plain.rank == none.rank
    assert (none.spaces.rank[none.spaces.decided] <= plain.rank).all()
