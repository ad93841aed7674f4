"""W(t, t0) = ∫ Φᵀ(τ, t) Hᵀ H Φ(τ, t) dτ: closed forms, its differential equation, additivity, three methods."""

import mpmath
import numpy as np
import pytest

from obscli.numeric.numeric_system import NumericSystem


METHODS = ("square-root", "quadrature", "lyapunov")
EPS = np.finfo(float).eps

ORDINARY = """
states: [a, b, c, d]
A: [[0, 1, 0, cos(t)], [-4, -0.1, 1, 0], [0, 0, -0.5, sin(3*t)], [0, 0, 0, 0]]
H: [[1, 0, 0, 0], [0, 0, 1/(1 + t), 1]]
"""
GROWING = "states: [a, b, c]\nA: [[-0.3, 1, 0], [cos(t), -0.5, 1], [0, 0, -0.5]]\nH: [[1, 0, 1]]\n"
FAST = "states: [a, b, c]\nA: [[-1, 1, 0], [cos(t), -2, 1], [0, 0, -0.5]]\nH: [[1, 0, 1]]\n"
STIFF = "states: [a, b, c]\nA: [[-50, 1, 0], [0, -0.1, cos(t)], [0, 0, 0]]\nH: [[1, 1, 0], [0, 0, 1]]\n"

#: What decays in time grows in W: by e^6, e^32 and e^200 here.
MODELS = {
    "ordinary": (ORDINARY, (1.0, 4.0, 12.0)),
    "growing": (GROWING, (2.0, 5.0, 8.0)),
    "fast growing": (FAST, (0.5, 2.0, 8.0)),
    "stiff": (STIFF, (0.1, 0.5, 2.0)),
}


def relative(W, other):
    """The largest |ΔW_ij| / √(W_ii W_jj) at each instant."""
    size = np.sqrt(np.einsum("ijj->ij", W))
    return np.abs((W - other) / size[:, :, None] / size[:, None, :]).max(axis=(1, 2))


@pytest.mark.parametrize(("method", "tolerance"), [("quadrature", 1e-11), ("lyapunov", 1e-6)])
@pytest.mark.parametrize("name", MODELS)
def test_the_methods_agree(gramian, matrices, name, method, tolerance):
    text, instants = MODELS[name]
    W, other = (matrices(gramian(text, instants, one)) for one in ("square-root", method))
    assert relative(W, other).max() <= tolerance


@pytest.mark.parametrize("method", ["quadrature", "lyapunov"])
@pytest.mark.parametrize("name", MODELS)
def test_the_stated_error_covers_the_difference_from_the_square_root(gramian, matrices, name, method):
    text, instants = MODELS[name]
    W, found = matrices(gramian(text, instants)), gramian(text, instants, method)
    units = found.units[:, :, None] * found.units[:, None, :]
    off = np.linalg.norm((matrices(found) - W) * units, axis=(1, 2))
    assert (off <= 3 * np.sqrt(found.error[:, 0, 0])).all()


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(
    ("A", "H", "exact"),
    [
        ("0", "1", lambda t: t),
        ("0", "2*t", lambda t: 4 * t**3 / 3),
        ("0.5", "1", lambda t: 1 - mpmath.exp(-t)),
        ("-0.5", "1", lambda t: mpmath.exp(t) - 1),
        ("-1/(1 + t)", "1", lambda t: (1 + t) * t),
        ("cos(t)", "exp(sin(t))", lambda t: mpmath.exp(-2 * mpmath.sin(t)) * mpmath.quad(
            lambda s: mpmath.exp(4 * mpmath.sin(s)), mpmath.linspace(0, t, 8))),
    ],
)  # fmt: skip
def test_scalar_closed_forms(gramian, matrices, A, H, exact, method):
    """x' = a x, y = x: Φ(τ, t) = e^(a(τ − t)), so W = (1 − e^(−2at))/(2a)."""
    instants = [0.25, 1.0, 3.0]
    W = matrices(gramian(f"states: [x]\nA: [['{A}']]\nH: [['{H}']]\n", instants, method))[:, 0, 0]
    with mpmath.workdps(20):
        expected = [float(exact(mpmath.mpf(t))) for t in instants]
    # the methods' step errors, 1e-14 and 1e-10, and what dozens of steps add up to
    np.testing.assert_allclose(W, expected, rtol=1e-8 if method == "lyapunov" else 100 * EPS)


@pytest.mark.parametrize("method", METHODS)
def test_the_double_integrator(gramian, matrices, method):
    """y = x + … : the row at τ is (1, τ − t), so W = [[t, −t²/2], [−t²/2, t³/3]]."""
    W = matrices(gramian("states: [x, v]\nA: [[0, 1], [0, 0]]\nH: [[1, 0]]\n", [2.0], method))[0]
    np.testing.assert_allclose(W, [[2, -2], [-2, 8 / 3]], rtol=1e-8 if method == "lyapunov" else 100 * EPS)


@pytest.mark.parametrize("method", METHODS)
def test_it_satisfies_its_differential_equation(gramian, matrices, system, method):
    """dW/dt = −Aᵀ W − W A + Hᵀ H by central differences: off by h² times the third derivative (≤ 10² W)."""
    h = {"lyapunov": 1e-2}.get(method, 1e-3)
    t = np.array([0.5, 1.5, 3.0])
    W = matrices(gramian(ORDINARY, np.sort(np.concatenate([t - h, t, t + h])), method)).reshape(3, 3, 4, 4)
    given = NumericSystem(system(ORDINARY), 0, 4)
    c = given.coefficients(t)
    A = np.zeros((3, 4, 4))
    A[:, given.moving] = c.A
    for k in range(3):
        slope = (W[k, 2] - W[k, 0]) / (2 * h)
        expected = -A[k].T @ W[k, 1] - W[k, 1] @ A[k] + c.H[k].T @ c.H[k]
        assert np.abs(slope - expected).max() <= 100 * h**2 * np.abs(W[k, 1]).max()


def test_it_is_additive(gramian, matrices, transition):
    """W(c, a) = Φᵀ(b, c) W(b, a) Φ(b, c) + W(c, b)."""
    for a, b, c in ((0.0, 1.0, 3.0), (0.5, 4.0, 4.1)):
        whole = matrices(gramian(ORDINARY, [c], start=a))
        phi = transition(ORDINARY, b, c)[0]
        parts = (
            phi.T @ matrices(gramian(ORDINARY, [b], start=a))[0] @ phi
            + matrices(gramian(ORDINARY, [c], start=b))[0]
        )
        assert relative(whole, parts[None]).max() < 1e-12


@pytest.mark.parametrize("method", METHODS)
def test_it_is_symmetric_and_not_negative(gramian, matrices, method):
    for text, instants in MODELS.values():
        found = gramian(text, instants, method)
        for W, one in zip(matrices(found), found.units, strict=True):
            scaled = W * one[:, None] * one
            np.testing.assert_allclose(scaled, scaled.T, atol=1e-12 * np.abs(scaled).max())
            if method != "lyapunov":
                assert np.linalg.eigvalsh(scaled).min() > -1e-13 * np.abs(scaled).max()


def test_instants_between_do_not_matter(gramian, matrices):
    many, few = (matrices(gramian(ORDINARY, one)) for one in (np.linspace(0.1, 5, 50), [5.0]))
    assert relative(few, many[-1:]).max() < 1e-12


def test_the_ins_gramian_by_all_methods(gramian, matrices, bundled):
    given = bundled("ins_calibration/horizontal.yaml", "stage_2")
    W, quadrature, lyapunov = (matrices(gramian(given, [10.0, 60.0], method)) for method in METHODS)
    seen = np.flatnonzero(W[0].diagonal() > 0)
    part = np.ix_(range(2), seen, seen)
    assert 16 <= len(seen) < 24
    assert relative(W[part], quadrature[part]).max() <= 1e-11
    assert relative(W[part], lyapunov[part]).max() <= 1e-6


@pytest.mark.parametrize("method", METHODS)
def test_the_error_keeps_its_meaning_in_other_units(gramian, method):
    """|ΔM v|² ≤ vᵀ E v for R D with columns, for D W D with rows and columns multiplied."""
    source = np.random.default_rng(1)
    found = gramian(ORDINARY, [2.0], method)
    factors = np.array([[1e-3, 1.0, 50.0, 1e4]])
    E, changed = found.error[0], found.in_units(factors).error[0]
    for _ in range(20):
        off = source.normal(size=(4, 4))
        off *= 1 / np.linalg.norm(off, 2)
        off = off @ np.linalg.cholesky(E).T  # so that |off v|² ≤ vᵀ E v, with equality for some v
        in_units = off * factors if found.is_root else off * factors * factors.T
        v = source.normal(size=4) / factors[0]
        assert np.linalg.norm(in_units @ v) ** 2 <= v @ changed @ v * (1 + 1e-9)


@pytest.mark.parametrize("method", METHODS)
def test_units_multiplied_are_those_of_the_matrices(gramian, matrices, method):
    found = gramian(ORDINARY, [1.0, 2.0], method)
    factors = np.random.default_rng(0).uniform(0.1, 10, (2, 4))
    np.testing.assert_allclose(matrices(found.in_units(factors)), matrices(found), rtol=1e-13)
