"""The Gramian through a stationary system: the same as without it, within the errors of both."""

from dataclasses import dataclass

import numpy as np
import pytest
from scipy.linalg import expm

from obscli.exact.stationary_form import lift_of
from obscli.model.covector import parse_scalar
from obscli.model.expression import Number
from obscli.numeric.analysis import analyze
from obscli.numeric.errors import TooManyStepsError, UnfitRequestError
from obscli.numeric.horizon import Wanted
from obscli.numeric.lifted_gramian import lifted_gramian
from obscli.numeric.numeric_system import NumericSystem
from obscli.numeric.rates import rates_of
from obscli.numeric.settings import Effort, Settings


STAGES = [
    (f"ins_calibration/{file}", f"stage_{k}")
    for file in ("horizontal.yaml", "vertical.yaml")
    for k in (1, 2, 3)
]

#: One error is one standard deviation of many roundings.
DEVIATIONS = 4


@dataclass(frozen=True)
class Form:
    variables: tuple
    A: tuple
    H: tuple


def sparse(matrix):
    return tuple({j: Number(e) for j, e in enumerate(row) if e} for row in np.asarray(matrix, dtype=object))


def own(system):
    """Return a time-invariant system as its own form."""

    def rows(matrix):
        return tuple({j: e for (i, j), e in matrix.entries.items() if i == k} for k in range(matrix.rows))

    one = Number(1)
    return Form(tuple({name: one} for name in system.state_names), rows(system.A), rows(system.H))


def lifted(system, form, instants, start=0.0):
    instants = np.array(instants, dtype=float)
    found = NumericSystem(system, start, instants[-1])
    rates = rates_of(found, instants)
    return lifted_gramian(form, found, start, instants, rates, Effort(0.0, 20_000))


def information(gramian, v):
    """|R v| at every instant, and what it may be wrong by: v (n, k) gives (N, k) twice."""
    v = np.broadcast_to(v, (len(gramian.instants), *v.shape[-2:])) / gramian.units[:, :, None]
    size = np.linalg.norm(gramian.matrices @ v, axis=1)
    return size, np.sqrt(np.einsum("kia,kij,kja->ka", v, gramian.error, v))


def agree(one, other, v):
    (a, error_a), (b, error_b) = information(one, v), information(other, v)
    return np.abs(a - b) <= DEVIATIONS * (error_a + error_b)


def dense(gramian):
    M = gramian.matrices / gramian.units[:, None, :]
    return M.transpose(0, 2, 1) @ M


@pytest.mark.parametrize(("file", "stage"), STAGES)
def test_the_stages_agree_with_the_square_root(bundled, gramian, file, stage):
    system = bundled(file, stage)
    instants = [10.0, 60.0, 600.0, 1500.0]
    found, usual = lifted(system, lift_of(system), instants), gramian(system, instants)
    directions = np.random.default_rng(1).normal(size=(system.n, 40))
    assert agree(found, usual, np.eye(system.n)).all()
    assert agree(found, usual, directions).all()


@pytest.mark.parametrize(("file", "stage"), STAGES)
def test_the_exact_kernel_is_within_the_error(bundled, exact, file, stage):
    system = bundled(file, stage)
    instants = np.array([10.0, 60.0, 600.0, 1500.0])
    found = lifted(system, lift_of(system), instants)
    numeric = NumericSystem(system, 0.0, 1500.0)
    kernel, _ = numeric.covectors(exact(system).unobservable, instants)
    size, error = information(found, kernel.transpose(0, 2, 1))
    assert (size <= DEVIATIONS * error).all()


def test_the_rank_of_a_stage_by_the_whole_pipeline(bundled):
    system = bundled("ins_calibration/horizontal.yaml", "stage_1")
    found = analyze(system, Settings(method="lift", lift=lift_of(system)))
    assert found.rank == 16
    assert found.conclusive.all()


CONSTANT = {
    "double integrator": ("A: [[0, 1], [0, 0]]\nH: [[1, 0]]", 2, [1.0, 50.0, 1000.0]),
    "oscillator": ("A: [[0, 1, 0], [-4, 0, 0], [0, 0, 0]]\nH: [[1, 0, 1]]", 3, [0.5, 20.0, 300.0]),
    "decaying": ("A: [[-1, 1, 0], [0, -2, 1], [0, 0, -1/2]]\nH: [[1, 0, 1]]", 3, [0.25, 2.0, 8.0]),
    "stiff": ("A: [[-50, 1, 0], [0, -1/10, 1], [0, 0, 0]]\nH: [[1, 1, 0], [0, 0, 1]]", 3, [0.1, 0.5, 2.0]),
    "units": ("A: [[0, 1e9, 0], [0, 0, 1e-12], [0, 0, 0]]\nH: [[1e-7, 0, 0]]", 3, [1.0, 10.0]),
    "at rest": ("A: [[0, 0, 0], [0, 0, 0], [0, 0, 0]]\nH: [[1, 2, 0]]", 3, [1.0, 10.0]),
}


@pytest.mark.parametrize("name", CONSTANT)
def test_a_stationary_system_is_its_own(system, gramian, name):
    text, n, instants = CONSTANT[name]
    given = system(f"states: [{', '.join('abc'[:n])}]\n{text}\n")
    found, usual = lifted(given, own(given), instants), gramian(given, instants)
    directions = np.random.default_rng(2).normal(size=(n, 20))
    assert agree(found, usual, np.eye(n)).all()
    assert agree(found, usual, directions).all()
    size = np.sqrt(np.einsum("ijj->ij", dense(usual)))
    size = np.where(size > 0, size, 1.0)
    relative = np.abs(dense(found) - dense(usual)) / size[:, :, None] / size[:, None, :]
    assert relative.max() < 1e-12


@pytest.mark.parametrize("name", CONSTANT)
def test_the_semigroup_law(system, name):
    """W(t, t0) = Φᵀ(t1, t) W(t1, t0) Φ(t1, t) + W(t, t1)."""
    text, n, (first, *_, last) = CONSTANT[name]
    given = system(f"states: [{', '.join('abc'[:n])}]\n{text}\n")
    A = np.zeros((n, n))
    A[NumericSystem(given, 0.0, last).moving] = NumericSystem(given, 0.0, last).matrices(np.zeros(1))[0][0]
    whole = dense(lifted(given, own(given), [last]))[0]
    before = dense(lifted(given, own(given), [first]))[0]
    after = dense(lifted(given, own(given), [last], start=first))[0]
    back = expm(A * (first - last))
    summed = back.T @ before @ back + after
    size = np.sqrt(whole.diagonal())
    size = np.where(size > 0, size, 1.0)
    assert np.abs((whole - summed) / size[:, None] / size).max() < 1e-10


FUNCTIONS = {
    "tones": (["1", "cos(2*t)", "sin(2*t)"], [[0, 0, 0], [0, 0, -2], [0, 2, 0]]),
    "polynomials": (["1", "t", "t^2", "t^3"], [[0, 0, 0, 0], [1, 0, 0, 0], [0, 2, 0, 0], [0, 0, 3, 0]]),
    "growing": (["exp(t/2)", "t*exp(t/2)"], [[0.5, 0], [1, 0.5]]),
    "fading": (["1", "exp(-3*t)"], [[0, 0], [0, -3]]),
    "growing tones": (["exp(t)*cos(5*t)", "exp(t)*sin(5*t)"], [[1, -5], [5, 1]]),
}


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("name", FUNCTIONS)
def test_outputs_made_of_functions(system, gramian, name, seed):
    """x' = A x, y = Σ f_j H_j x with f' = S f: z = f ⊗ x, z' = (S ⊗ I + I ⊗ A) z, y = (H_1 … H_l) z."""
    texts, S = FUNCTIONS[name]
    source = np.random.default_rng(seed)
    n, m = 4, 2
    parts = source.integers(-3, 4, size=(len(texts), m, n))
    A = source.integers(-4, 5, size=(n, n)) / 8 * (source.random((n, n)) < 0.4)
    entries = [
        [
            "+".join(f"({part[i, j]})*({text})" for part, text in zip(parts, texts, strict=True))
            for j in range(n)
        ]
        for i in range(m)
    ]
    given = system(f"states: [a, b, c, d]\nA: {A.tolist()}\nH: {entries}\n")
    forms = [{name: parse_scalar(given, text, "test")} for text in texts for name in given.state_names]
    lift = np.kron(S, np.eye(n)) + np.kron(np.eye(len(texts)), A)
    form = Form(tuple(forms), sparse(lift), sparse(np.hstack(list(parts))))
    instants = [0.5, 3.0, 10.0]
    found, usual = lifted(given, form, instants), gramian(given, instants)
    assert agree(found, usual, np.eye(n)).all()
    assert agree(found, usual, source.normal(size=(n, 20))).all()


def test_powers_of_time_beyond_what_one_panel_integrates(system):
    """y = t^20 x, x' = 0: z = (x, t x, …, t^20 x), W = t^41/41."""
    given = system("states: [x]\nA: [[0]]\nH: [[t^20]]\n")
    forms = tuple({"x": parse_scalar(given, f"t^{k}", "test")} for k in range(21))
    form = Form(forms, sparse(np.diag(range(1, 21), -1)), sparse([[0] * 20 + [1]]))
    found = dense(lifted(given, form, [0.5, 1.0, 8.0]))[:, 0, 0]
    np.testing.assert_allclose(found, np.array([0.5, 1.0, 8.0]) ** 41 / 41, rtol=1e-11)


def test_the_method_needs_a_form_and_makes_no_step_error(system):
    given = system("states: [a, b]\nA: [[0, 1], [0, 0]]\nH: [[1, 0]]\n")
    with pytest.raises(UnfitRequestError, match="needs a stationary system"):
        analyze(given, Settings(method="lift"))
    with pytest.raises(UnfitRequestError, match="no step error"):
        analyze(given, Settings(method="lift", lift=own(given), rtol=1e-9))


def test_an_interval_of_too_many_steps(system):
    given = system("states: [a, b]\nA: [[0, 1], [-1e8, 0]]\nH: [[1, 0]]\n")
    with pytest.raises(TooManyStepsError, match="shorter interval"):
        lifted(given, own(given), [1e6])


def test_windows_are_shortened_where_decay_drowns_the_rest(system):
    """Over the whole interval rows grow by e^1000; the last part of it shows the rank."""
    given = system("states: [a, b]\nA: [[-1, 1], [0, -1/2]]\nH: [[1, 0]]\n")
    times = tuple(parse_scalar(given, text, "test") for text in ("10", "1000"))
    found = analyze(given, Settings(Wanted(times=times), "lift", lift=own(given)))
    assert found.rank == 2
    assert found.spaces.decided.all()
