"""Units, order and names of the states, units of time: they change what is printed, not what is observable."""

import numpy as np
import pytest


A = [["0", "1", "0", "cos(t)"], ["-4", "-0.1", "1", "0"], ["0", "0", "-0.5", "0"], ["0", "0", "0", "0"]]
H = [["1", "0", "0", "0"]]

#: What is hidden: x3 and x4 enter as x3 + 2 x4 only; x2 and x4 as x2 + 2 x4 only.
SYSTEMS = {
    "full": (A, H, 4),
    "hidden": ([["0", "1", "1", "2"], ["-1", "0", "3", "6"], ["0"] * 4, ["0"] * 4], H, 3),
    "varying": ([["0", "1", "1", "2"], ["-1", "0", "sin(t)", "0"], ["0"] * 4, ["0"] * 4], H, 3),
}
SIZES = [np.array([1e3, 1e-6, 7.3, 2e-2]), np.array([1.0, 1e8, 1.0, 1e-8]), np.array([2.0, 4.0, 0.5, 1024.0])]


def text(A, H, sizes=None, order=None):
    """x = D z: z' = D⁻¹ A D z, y = H D z; then z in another order."""
    n = len(A)
    sizes = np.ones(n) if sizes is None else sizes
    order = range(n) if order is None else order

    def entry(e, factor):
        return "0" if e == "0" else f"{factor!r}*({e})" if factor != 1 else e

    a = [[entry(A[i][j], float(sizes[j] / sizes[i])) for j in order] for i in order]
    h = [[entry(row[j], float(sizes[j])) for j in order] for row in H]
    rows = [f"[{', '.join(repr(e) for e in row)}]" for row in a]
    outputs = [f"[{', '.join(repr(e) for e in row)}]" for row in h]
    names = ", ".join(f"x{j + 1}" for j in order)
    return f"states: [{names}]\nA: [{', '.join(rows)}]\nH: [{', '.join(outputs)}]\ninterval: {{stop: 6, samples: 12}}\n"


def kernel(numeric, i):
    """The kernel in the file's units."""
    return numeric.spaces.gramian.units[i][:, None] * numeric.spaces.kernel(i)


def same_span(a, b, tolerance):
    """Whether two sets of columns span the same, each normalised."""
    qa, qb = (np.linalg.qr(one)[0] for one in (a, b))
    return np.linalg.norm(qa @ qa.T - qb @ qb.T, 2) < tolerance


@pytest.mark.parametrize("sizes", SIZES)
@pytest.mark.parametrize("name", SYSTEMS)
def test_units_of_the_states(numeric, gramian, matrices, name, sizes):
    A, H, rank = SYSTEMS[name]
    plain, changed = numeric(text(A, H)), numeric(text(A, H, sizes))
    assert plain.rank == changed.rank == rank
    assert plain.spaces.decided.all()
    assert (plain.spaces.rank == changed.spaces.rank).all()
    W, scaled = (matrices(gramian(one, [2.0, 6.0])) for one in (text(A, H), text(A, H, sizes)))
    np.testing.assert_allclose(scaled, W * sizes * sizes[:, None], atol=1e-300, rtol=1e-9)
    if rank < 4:
        for i in (0, -1):
            # in the units of the plain system, where the direction is (0, …, 2, −1)
            assert same_span(kernel(plain, i), sizes[:, None] * kernel(changed, i), 1e-11)


@pytest.mark.parametrize("order", [[3, 2, 1, 0], [1, 3, 0, 2]])
@pytest.mark.parametrize("name", SYSTEMS)
def test_order_of_the_states(numeric, gramian, matrices, name, order):
    A, H, rank = SYSTEMS[name]
    plain, changed = numeric(text(A, H)), numeric(text(A, H, order=order))
    assert plain.rank == changed.rank == rank
    assert changed.spaces.decided.all()
    W, other = (matrices(gramian(one, [2.0, 6.0])) for one in (text(A, H), text(A, H, order=order)))
    np.testing.assert_allclose(other, W[:, order][:, :, order], rtol=1e-9, atol=1e-13 * np.abs(W).max())
    if rank < 4:
        assert same_span(kernel(plain, -1)[order], kernel(changed, -1), 1e-9)


@pytest.mark.parametrize("factor", [1e-6, 1e-3, 60.0, 86400.0])
def test_units_of_time(numeric, factor):
    """x' = A(t) x in another unit of time: t = factor·s, dx/ds = factor·A(factor·s) x."""
    for A, H, rank in SYSTEMS.values():
        scaled = [
            [e if e == "0" else f"{factor}*({e.replace('(t)', f'({factor}*t)')})" for e in row] for row in A
        ]
        changed = text(scaled, H).replace("stop: 6", f"stop: {6 / factor}")
        found = numeric(changed)
        assert found.rank == rank
        assert found.spaces.decided.all()


def test_an_output_repeated_or_multiplied_changes_no_rank(numeric):
    A, H, rank = SYSTEMS["hidden"]
    for rows in ([*H, *H], [["1e-9", "0", "0", "0"]], [*H, ["1e6", "0", "0", "0"]], [["-3", "0", "0", "0"]]):
        found = numeric(text(A, rows))
        assert found.rank == rank
        assert found.spaces.decided.all()
        assert same_span(kernel(found, -1), kernel(numeric(text(A, H)), -1), 1e-10)
