"""What each measure promises: identities between them, invariances, bounds; over random systems."""

import numpy as np
import pytest
from scipy.linalg import expm

from obscli.model.notation import to_text
from obscli.numeric.numeric_system import constants_of
from obscli.numeric.program import constant_value


def random_system(seed, n=4, m=1, hidden=0):
    """Return A, H of a random system, the last ``hidden`` states of a block triangular form unseen, mixed."""
    source = np.random.default_rng(seed)
    A = source.integers(-3, 4, (n, n)).astype(float)
    H = source.integers(-2, 3, (m, n)).astype(float)
    H[:, 0] += 1
    if hidden:
        A[: n - hidden, n - hidden :], H[:, n - hidden :] = 0, 0
        T = np.eye(n) + np.tril(source.integers(-1, 2, (n, n)), -1)
        A, H = np.rint(T @ A @ np.linalg.inv(T)), np.rint(H @ np.linalg.inv(T))
    return A, H


def matrix(A, H):
    rows, n = [H], len(A)
    for _ in range(n - 1):
        rows.append(rows[-1] @ A)
    return np.concatenate(rows)


def rotation(seed, n):
    return np.linalg.qr(np.random.default_rng(seed).normal(size=(n, n)))[0]


@pytest.fixture
def observable():
    """Random systems of which numpy says, far from any doubt, that they are observable."""
    found = []
    for seed in range(60):
        A, H = random_system(seed, n=4, m=1 + seed % 2)
        values = np.linalg.svd(matrix(A, H), compute_uv=False)
        if values[-1] > 1e-2:
            found.append((A, H))
    assert len(found) > 30
    return found[:12]


def test_matrix_measures_are_those_of_the_matrix(observable, of_matrices):
    for A, H in observable:
        M, found = matrix(A, H), of_matrices(A, H)
        sigma = np.linalg.svd(M, compute_uv=False)
        assert found.sizes("singular-values") == pytest.approx(sigma)
        assert found.system("condition-number") == pytest.approx(sigma[0] / sigma[-1])
        assert found.system("determinant") == pytest.approx(np.linalg.det(M.T @ M), rel=1e-6)
        assert found.state("pseudo-inverse") == pytest.approx(np.abs(np.linalg.pinv(M)).max(axis=1))
        assert found.state("column-norm") == pytest.approx(np.linalg.norm(M, axis=0))


def test_the_chain_is_the_superdiagonal_of_f_and_multiplies_to_the_determinant(of_matrices):
    """One output: μ_k = |f_{k−1,k}| for F = U A Uᵀ; det(MᵀM) = Π r_k², r_k = Π_{l ≤ k} μ_l."""
    for seed in range(8):
        A, H = random_system(seed)
        if np.linalg.matrix_rank(matrix(A, H)) < 4:
            continue
        found = of_matrices(A, H)
        U = np.linalg.qr(matrix(A, H).T)[0].T
        F, mu = U @ A @ U.T, found.sizes("deterministic")
        assert mu[1:] == pytest.approx(np.abs(np.diag(F, 1)), rel=1e-9)
        assert np.prod(np.cumprod(mu) ** 2) == pytest.approx(found.system("determinant"), rel=1e-9)


def test_equivalent_singular_values_add_up_and_lie_between_their_bounds(observable, of_matrices):
    for A, H in observable:
        found = of_matrices(A, H)
        sizes, values = found.sizes("singular-values"), np.array(found.state("equivalent-singular-value"))
        assert values.sum() == pytest.approx(sum(sizes))
        assert (values >= min(sizes) * (1 - 1e-12)).all()
        assert (values <= np.array(found.state("column-norm")) * (1 + 1e-12)).all()
        assert max(found.state("column-norm")) <= max(sizes) * (1 + 1e-12)


def test_of_two_states_that_only_their_sum_shows_neither_is_observable_though_the_gain_is_positive(
    of_matrices,
):
    found = of_matrices(np.zeros((2, 2)), [[1, 1]])
    assert found.state("equivalent-singular-value") == pytest.approx([np.sqrt(0.5)] * 2)
    assert found.state("pseudo-inverse") == [np.inf, np.inf]
    assert [one.observable for one in found.subject.targets[:2]] == [False, False]
    assert found.combination("pseudo-inverse") == pytest.approx([1])


def test_an_orthogonal_change_of_the_outputs_changes_no_measure_but_the_chain(observable, of_matrices):
    Q = np.array([[3, -4], [4, 3]]) / 5
    for A, H in observable:
        if len(H) == 1:
            continue
        one, other = (of_matrices(A, y, options={"least-squares.dt": "0.1"}) for y in (H, Q @ H))
        for key in ("equivalent-singular-value", "column-norm", "least-squares"):
            assert other.state(key) == pytest.approx(one.state(key), rel=1e-9)
        assert other.sizes("singular-values") == pytest.approx(one.sizes("singular-values"))
        assert other.system("determinant") == pytest.approx(one.system("determinant"))
        assert other.sizes("modal") == pytest.approx(one.sizes("modal"), rel=1e-6)


def test_an_orthogonal_change_of_the_state_keeps_what_is_said_of_the_system(observable, of_matrices):
    T = np.array([[3, -4, 0, 0], [4, 3, 0, 0], [0, 0, 5, 0], [0, 0, 0, 5]]) / 5
    for A, H in observable[:6]:
        one, other = of_matrices(A, H), of_matrices(T @ A @ T.T, H @ T.T)
        assert other.sizes("deterministic") == pytest.approx(one.sizes("deterministic"))
        assert other.sizes("singular-values") == pytest.approx(one.sizes("singular-values"))
        assert other.sizes("modal") == pytest.approx(one.sizes("modal"), rel=1e-6)
        assert other.system("determinant") == pytest.approx(one.system("determinant"))


def test_another_unit_of_time_scales_the_determinant_by_its_power(observable, of_matrices):
    """Block k is multiplied by T^k: one output, n states: det by T^(n(n−1)), each link of the chain by T."""
    for A, H in observable[:6]:
        if len(H) > 1:
            continue
        one, other = of_matrices(A, H), of_matrices(2 * A, H)
        assert other.system("determinant") == pytest.approx(2.0**12 * one.system("determinant"))
        assert other.sizes("deterministic")[1:] == pytest.approx(2 * np.array(one.sizes("deterministic")[1:]))


SCALED = """\
states: {{x1: {{scale: 100}}, x2: {{scale: 1/8}}}}
A: [[0, 1], [-2, -1/2]]
H: [[1, 3]]
"""


def test_a_scaling_is_the_same_as_other_units_in_the_file(measure, of_matrices):
    """x = D z: A → D⁻¹ A D, H → H D."""
    D = np.array([100, 1 / 8])
    A, H = np.array([[0, 1], [-2, -0.5]]), np.array([[1.0, 3.0]])
    scaled = measure(SCALED.format(), scaling="scale", stop="4")
    other = of_matrices(A * D / D[:, None], H * D, stop="4")
    for key in (
        "deterministic",
        "least-squares",
        "pseudo-inverse",
        "equivalent-singular-value",
        "column-norm",
    ):
        assert scaled.state(key) == pytest.approx(other.state(key), rel=1e-9)
    for key in ("singular-values", "gramian-singular-values", "modal"):
        assert scaled.sizes(key) == pytest.approx(other.sizes(key), rel=1e-9)


def test_a_ranking_that_depends_on_the_units_is_told(measure):
    """Both measured, the second twice as strongly; in their sizes the first is the larger by far."""
    states = "{x1: {scale: 100}, x2: {scale: 1/8}}"
    found = measure(f"states: {states}\nA: [[0, 0], [0, 0]]\nH: [[1, 0], [0, 2]]\n")
    assert found.state("pseudo-inverse") == pytest.approx([1, 0.5])
    told = {one.key: (one.given, one.other, one.units) for one in found.result.reordered}
    assert told["pseudo-inverse"] == (("x2", "x1"), ("x1", "x2"), "scale")
    alike = measure("states: {x1: {scale: 3}, x2: {scale: 3}}\nA: [[0, 0], [0, 0]]\nH: [[1, 0], [0, 2]]\n")
    assert alike.result.reordered == ()


def test_least_squares_does_not_depend_on_the_basis_of_an_eigenspace(of_matrices):
    """B = 11 I: 1/11 for both, in any coordinates; the weight counts with its square."""
    Q = np.array([[3, -4], [4, 3]]) / 5
    for H in (np.eye(2), Q):
        assert of_matrices(np.zeros((2, 2)), H).state("least-squares") == pytest.approx([1 / 11] * 2)
    weighted = of_matrices(np.zeros((2, 2)), np.eye(2), options={"least-squares.W": "3"})
    assert weighted.state("least-squares") == pytest.approx([1 / 99] * 2)


def test_least_squares_is_that_of_the_normal_equations(of_matrices):
    A, H = np.array([[0, 1, 0], [-1, -0.5, 1], [0, 0, -0.25]]), np.array([[1.0, 0, 0]])
    Phi = expm(-0.5 * A)
    rows = [H]
    for _ in range(6):
        rows.append(rows[-1] @ Phi)
    B = sum(h.T @ h for h in rows)
    values, vectors = np.linalg.eigh(B)
    found = of_matrices(A, H, options={"least-squares.dt": "0.5", "least-squares.N": "7"})
    assert found.state("least-squares") == pytest.approx((np.abs(vectors) / values).max(axis=1), rel=1e-7)


def test_too_few_samples_are_refused_and_not_inverted(of_matrices):
    A = np.diag([1.0, 1.0, 1.0], 1)
    found = of_matrices(A, [[1, 0, 0, 0]], options={"least-squares.N": "3"})
    assert (
        "3 samples do not tell the 4 observable combinations apart"
        in found.taken.found["least-squares"].reason
    )


def test_what_is_not_observable_is_so_by_every_measure(of_matrices):
    for seed in range(8):
        A, H = random_system(seed, n=4, m=1, hidden=1)
        found = of_matrices(A, H, options={"least-squares.dt": "0.1"})
        for k, target in enumerate(found.subject.targets[:4]):
            if not target.observable:
                assert found.state("deterministic")[k] == 0
                assert found.state("least-squares")[k] == np.inf
                assert found.state("pseudo-inverse")[k] == np.inf
        assert found.system("determinant") == 0
        assert found.system("condition-number") == np.inf
        assert found.sizes("singular-values")[found.subject.rank :] == [0] * (4 - found.subject.rank)
        assert found.sizes("gramian-singular-values")[found.subject.rank :] == [0] * (4 - found.subject.rank)
        assert (min(found.sizes("modal")) < 1e-12) == (found.subject.rank < 4)


def test_modes_of_a_jordan_block_stay_together(of_matrices):
    """One eigenvector for each of 0 (three integrators) and −1; the second output sees the second."""
    A = np.zeros((5, 5))
    A[0, 1] = A[1, 2] = 1
    A[3, 3], A[4, 4] = -1, -1
    modes = of_matrices(A, [[1, 0, 0, 0, 0], [0, 0, 0, 2, 0]]).system("modal")
    assert [one.eigenvalue for one in modes] == [-1, 0]
    assert [one.value for one in modes] == pytest.approx([0, 1])
    assert modes[0].components == {"x5": 1.0}


def test_gramian_eigenvalues_are_those_of_the_integral(of_matrices):
    """x' = −x, y = x over T: (1 − e^(−2T))/2 of e^(2T) at the end."""
    found = of_matrices([[-1]], [[1]], stop="1")
    assert found.sizes("gramian-singular-values") == pytest.approx([(np.exp(2) - 1) / 2])


def test_closed_forms_have_the_values_of_the_numbers(measure):
    text = (
        "parameters: {a: 1.5, b: -0.7}\nstates: [x, y, z]\n"
        "A: [[0, a, 0], [b, 0, 1], [0, 0, 0]]\nH: [[1, 0, b]]\nquantities: {q: x - 2*z}\n"
    )
    found = measure(text)
    constants = constants_of(found.subject.system)
    assert len(found.taken.found["pseudo-inverse"].forms) == 4
    for key in ("deterministic", "pseudo-inverse"):
        values = dict(zip(("x", "y", "z"), found.state(key), strict=True)) | found.quantity(key)
        for name, form in found.taken.found[key].forms.items():
            assert constant_value(form, constants) == pytest.approx(values[name], rel=1e-12), to_text(form)
    form = found.taken.found["determinant"].forms["determinant"]
    assert constant_value(form, constants) == pytest.approx(found.system("determinant"), rel=1e-12)


def test_the_conventional_rule_is_taken_only_where_asked_for_and_says_what_it_leaves_open(of_matrices):
    A, H = np.zeros((3, 3)), np.eye(3)
    assert "conventional-singular-value" not in of_matrices(A, H).taken.found
    found = of_matrices(A, H, select=("conventional-singular-value",))
    assert any("repeat" in one for one in found.taken.found["conventional-singular-value"].remarks)
    shared = of_matrices(np.zeros((2, 2)), [[3, 1], [0, 1e-3]], select=("conventional-singular-value",))
    assert shared.state("conventional-singular-value") == pytest.approx(
        [np.sqrt(10), 3e-3 / np.sqrt(10)], rel=1e-3
    )


def test_a_state_that_gets_no_singular_value_has_none(of_matrices):
    """Of (2, 1, 1)/√6 and nothing else two states get nothing, which is not zero."""
    found = of_matrices(np.zeros((3, 3)), [[2, 1, 1]], select=("conventional-singular-value",))
    assert found.state("conventional-singular-value") == [pytest.approx(np.sqrt(6)), None, None]
    assert (
        "2 of 3 states get no singular value" in found.taken.found["conventional-singular-value"].remarks[-1]
    )


def test_functions_left_open_follow_the_sample_motion(measure):
    """x' = f(t) y, y constant, z = x: M = (1, 0; 0, f): (17) of y is 1/|f(t)|."""
    found = measure("functions: [f]\nstates: [x, y]\nA: [[0, f], [0, 0]]\nH: [[1, 0]]\n", at=("2",))
    f = found.subject.numeric.values(np.array([2.0]), {})["f"][0]
    assert found.state("pseudo-inverse") == pytest.approx((1, 1 / abs(f)), rel=1e-12)


def test_a_closed_form_with_the_derivative_of_a_function_left_open(measure):
    """y = x + f b: M = (1, f; 0, f'), so that the row of b in the inverse is (0, 1/f')."""
    found = measure("functions: [f]\nstates: [x, b]\nA: [[0, 0], [0, 0]]\nH: [[1, f]]\n", at=("2",))
    rate = found.subject.numeric.values(np.array([2.0]), {"f": 1})["f'"][0]
    assert found.state("pseudo-inverse")[1] == pytest.approx(1 / abs(rate), rel=1e-9)
    assert "deriv(f)" in to_text(found.taken.found["pseudo-inverse"].forms["b"])


@pytest.mark.parametrize(
    ("text", "at"),
    [
        ("parameters: {e: 0}\nstates: [a, b]\nA: [[0, 1], [0, 0]]\nH: [[1, 0], [1, e]]\n", "1"),
        ("states: [a, b]\nA: [[0, 1], [0, 0]]\nH: [[1, 0], [1, t - 20]]\n", "20"),
    ],
)
def test_a_closed_form_of_generic_values_is_left_out_where_the_values_are_special(measure, text, at):
    """For e ≠ 0 the second output is the link to b, and μ = |e|; for e = 0 its derivative is, and μ = 1."""
    found = measure(text, at=(at,))
    assert found.state("deterministic") == pytest.approx([1, 1])
    assert "b" not in found.taken.found["deterministic"].forms


def test_the_first_sample_counts_at_the_start(measure):
    found = measure(
        "states: [x]\nA: [[0]]\nH: [[1]]\nnoise: {R: 4, step: 1, P0_std: 3}\n", at=("0",), stop="9"
    )
    assert found.state("standard-deviation") == pytest.approx([1 / np.sqrt(1 / 9 + 1 / 4)])
