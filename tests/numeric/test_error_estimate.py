"""E says how wrong M = R D is: along an exact direction of the kernel |M v| ≈ √(vᵀ E v), neither more nor far less.

The kernel of INS calibration, stage 2, written out by hand, in 40 digits at the doubles that the system uses.
"""

from dataclasses import replace

import mpmath
import numpy as np
import pytest

from obscli.numeric.scaling import scaled
from obscli.numeric.settings import Effort
from obscli.numeric.square_root import square_root_gramian
from obscli.numeric.subspace import subspaces


#: Random roundings add up as E has it to a factor 6; taking them for fully alike would be 100 too much.
HONEST = 6
PESSIMISTIC = 100


def directions(constants, t):
    """The kernel, spanned by 8 directions: state → component."""
    w, earth, phi, g = (mpmath.mpf(constants[name]) for name in ("omega", "omega_ie", "phi", "g"))
    north, up = earth * mpmath.cos(phi), earth * mpmath.sin(phi)
    return [
        {"psi3": 1, "b_g2": north},
        {"psi2": 1 / g, "b_a2": 1, "b_g2": -up / g},
        {"M_g22": 1, "b_g2": -w},
        {"M_g12": 1, "b_g1": -w},
        {
            "M_a21": 1, "psi2": mpmath.sin(w * t), "b_g2": north * mpmath.cos(w * t), "b_g1": w,
            "M_g21": -1,
        },
        {"M_g32": 1, "b_g3": -w},
        {"M_a22": 1},
        {"M_a32": 1},
    ]  # fmt: skip


def normalised(direction, names, units):
    v = [
        mpmath.mpf(direction.get(name, 0)) / mpmath.mpf(float(u))
        for name, u in zip(names, units, strict=True)
    ]
    return mpmath.matrix(v) / mpmath.norm(mpmath.matrix(v))


def off_and_estimate(found, i):
    """|M v| and √(vᵀ E v) for every direction at one instant, and for their sum."""
    names, g = found.system.system.state_names, found.spaces.gramian
    with mpmath.workdps(40):
        M = mpmath.matrix(g.matrices[i].tolist())
        given = directions(found.system.constants, mpmath.mpf(float(g.instants[i])))
        vectors = [normalised(one, names, g.units[i]) for one in given]
        off = [float(mpmath.norm(M * v)) for v in vectors]
    columns = np.array([[float(x) for x in v] for v in vectors]).T
    return np.array(off), found.spaces.noise_along(columns, i)


@pytest.fixture(scope="module")
def usual(bundled, numeric):
    return numeric(bundled("ins_calibration/horizontal.yaml", "stage_2"))


@pytest.fixture(scope="module", params=[(1, 1e-14), (6, 1e-9), (6, 1e-4)], ids=["usual", "long", "longest"])
def found(usual, request):
    """With steps as they are, whose error is rounding, and with steps that are too long for the coefficients."""
    stretched, rtol = request.param
    slow = replace(
        usual.rates,
        coefficients=usual.rates.coefficients / stretched,
        dynamics=usual.rates.dynamics / stretched,
    )
    g = square_root_gramian(usual.system, 0.0, usual.horizon.instants, slow, Effort(rtol, 20_000))
    return replace(usual, spaces=subspaces(scaled(g, usual.system.system, "automatic")))


@pytest.mark.parametrize("i", [0, 4, 19, 49, 99, 149])
def test_exact_directions_are_off_by_their_error(found, i):
    off, estimate = off_and_estimate(found, i)
    assert (off <= HONEST * estimate).all()


@pytest.mark.parametrize("i", [0, 4, 19, 49, 99, 149])
def test_the_error_is_not_far_above_what_it_stands_for(usual, i):
    off, estimate = off_and_estimate(usual, i)
    assert (estimate[:6] <= PESSIMISTIC * off[:6]).all()


def test_states_that_appear_nowhere_have_the_error_of_the_decomposition_only(found):
    names, g = list(found.system.system.state_names), found.spaces.gramian
    for name in ("M_a22", "M_a32"):
        j = names.index(name)
        assert not g.matrices[:, :, j].any()
        assert (np.sqrt(g.error[:, j, j]) < np.finfo(float).eps * found.spaces.values[:, 0]).all()


def test_a_direction_that_is_no_kernel_is_far_above_its_error(found):
    """So that the test above can fail: the sign of one component wrong, and |M v| is a million times its error."""
    names, g = found.system.system.state_names, found.spaces.gramian
    t = mpmath.mpf(float(g.instants[50]))
    wrong = {**directions(found.system.constants, t)[2], "b_g2": mpmath.mpf(found.system.constants["omega"])}
    v = np.array([[float(x) for x in normalised(wrong, names, g.units[50])]]).T
    assert np.linalg.norm(g.matrices[50] @ v) > 1e6 * found.spaces.noise_along(v, 50)


@pytest.mark.parametrize("i", [4, 49, 149])
def test_singular_values_of_the_kernel_stay_below_the_tolerance(found, i):
    spaces = found.spaces
    below = spaces.values[i, 16:]
    assert (below <= 10 * spaces.noise[i, 16:]).all()
    assert spaces.values[i, 15] >= 100 * spaces.noise[i, 16]
