"""The reduced echelon basis in time: pivots as algebra has them, zeros where the exact entries are zero."""

import numpy as np
import pytest

from obscli.numeric.echelon import echelon_curves


ROTATING = """
parameters: {w: 0.7, k: 3}
states: [a, b, c, d]
A: zeros(4, 4)
H: [[1, 0, 'k*sin(w*t)', 0], [0, 1, 0, 0]]
interval: {stop: 20, samples: 40}
"""


def test_a_basis_written_down(numeric):
    """z = a + k sin(w t) c is not constant, so a and c are known alone; b is; d is not."""
    found = echelon_curves(numeric(ROTATING))
    assert found.states == {"a": "observable", "b": "observable", "c": "observable", "d": "unobservable"}
    assert found.coefficients.shape == (40, 3, 1)
    assert not found.present.any()
    assert not found.cleaned.any()


HIDDEN = """
parameters: {w: 0.7, k: 3}
states: [a, b, c, d]
A:
  a: {c: "k*w*cos(w*t)"}
H: {y: {a: 1, d: 2}, z: {b: 1}}
interval: {stop: 20, samples: 40}
"""


def test_coefficients_follow_the_exact_ones(numeric):
    """a' = k w cos(w t) c: known are c, b and a + 2 d."""
    found = echelon_curves(numeric(HIDDEN))
    assert [found.names[p] for p in found.pivots] == ["a", "b", "c"]
    assert [found.names[f] for f in found.free] == ["d"]
    assert found.states == {"a": "coupled", "b": "observable", "c": "observable", "d": "coupled"}
    assert found.groups == (("a", "d"), ("b",), ("c",))
    np.testing.assert_allclose(found.coefficients[:, :, 0], np.tile([2, 0, 0], (40, 1)), atol=1e-11)
    assert (np.abs(found.coefficients[:, 1:]) <= found.errors[:, 1:]).all()


def test_a_coefficient_that_varies(numeric):
    """y = a + sin(w t) b − t c with a' = −w cos(w t) b + c: the output is a constant of the motion."""
    text = """
parameters: {w: 0.7}
states: [a, b, c]
A: {a: {b: "-w*cos(w*t)", c: 1}}
H: {y: {a: 1, b: "sin(w*t)", c: "-t"}}
interval: {stop: 20, samples: 40}
"""
    found = echelon_curves(numeric(text))
    assert list(found.pivots) == [0]
    t = found.instants
    np.testing.assert_allclose(found.coefficients[:, 0], np.array([np.sin(0.7 * t), -t]).T, atol=1e-12)
    assert found.present.all()
    assert (found.errors[:, 0] < 1e-12).all()


def test_full_rank_has_no_coefficients(numeric):
    found = echelon_curves(numeric("states: [a, b]\nA: [[0, 1], [-1, 0]]\nH: [[1, 0]]\n"))
    assert found.coefficients.shape[1:] == (2, 0)
    assert found.states == {"a": "observable", "b": "observable"}


def test_where_no_rank_is_decided_there_are_no_curves(numeric):
    """Two outputs alike but for 10⁻¹³: that direction lies between ten and a hundred times its noise."""
    text = (
        "states: [a, b]\nA: zeros(2, 2)\nH: [[1, 1], [1, '1 + t/10^13']]\ninterval: {stop: 1, samples: 1}\n"
    )
    found = numeric(text)
    assert not found.spaces.decided.any()
    assert found.rank is None
    assert not found.conclusive.any()
    assert echelon_curves(found) is None


@pytest.mark.parametrize("sizes", [(1e3, 1, 1e-3, 1), (1e-2, 1e2, 1, 1e3)])
def test_curves_are_in_the_files_units(numeric, sizes):
    """x = D z: the coefficients of z are those of x times d_free/d_pivot, whatever the scaling."""
    plain = echelon_curves(numeric(HIDDEN))
    names = "abcd"
    scaled = HIDDEN
    factor = dict(zip(names, sizes, strict=True))
    scaled = scaled.replace('"k*w*cos(w*t)"', f'"{factor["c"] / factor["a"]!r}*k*w*cos(w*t)"')
    scaled = scaled.replace("{a: 1, d: 2}", f"{{a: {factor['a']!r}, d: {2 * factor['d']!r}}}")
    scaled = scaled.replace("{b: 1}", f"{{b: {factor['b']!r}}}")
    for scaling in ("automatic", "none"):
        found = echelon_curves(numeric(scaled, scaling=scaling))
        expected = plain.coefficients[:, 0, 0] * factor["d"] / factor["a"]
        np.testing.assert_allclose(found.coefficients[:, 0, 0], expected, rtol=1e-9)
        assert found.states == plain.states


def test_pivots_come_first_in_the_order_of_the_states(numeric, bundled):
    """No state before a pivot's free states would do: every row starts with its pivot."""
    for stage in ("stage_1", "stage_2", "stage_3"):
        found = echelon_curves(numeric(bundled("ins_calibration/horizontal.yaml", stage), samples=20))
        for p, row in zip(found.pivots, found.present, strict=True):
            assert (found.free[row] > p).all()
        assert sorted([*found.pivots, *found.free]) == list(range(24))
