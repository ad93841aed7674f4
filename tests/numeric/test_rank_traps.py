"""Systems whose Gramian spans more than doubles hold: no decided rank is above the exact one, and most are decided."""

from pathlib import Path

import pytest
import yaml

from obscli.numeric.errors import NotComputableError


DATA = Path(__file__).parent / "data"


# -- 16 states with growth rates up to 0.04, over 1 to 1000 s


def sixteen(case, outputs, stop):
    data = yaml.safe_load((DATA / f"k16_case{case}.yaml").read_text())
    A, H = (", ".join(f"[{', '.join(row)}]" for row in data[key]) for key in ("A", outputs))
    names = ", ".join(data["states"])
    return f"states: [{names}]\nA: [{A}]\nH: [{H}]\ninterval: {{stop: {stop}, samples: 60}}\n"


@pytest.mark.parametrize("stop", [1, 10, 100, 1000])
@pytest.mark.parametrize(("case", "outputs", "rank"), [(1, "C_VR", 16), (3, "C_VR", 13), (3, "C_VR_dL3", 14)])
def test_sixteen_states_with_growth(numeric, exact, system, case, outputs, rank, stop):
    given = system(sixteen(case, outputs, stop))
    assert exact(given).at_values.rank == rank
    found = numeric(given)
    decided = found.spaces.decided
    assert (found.spaces.rank[decided] == rank).all()
    assert decided.mean() > 0.9
    assert found.rank == rank


# -- directions that decay fast, turned into all states: x = T z, z' = diag(−k, [0 1; 0 0]) z

ROTATED = """
states: [a, b, c]
let:
  T: [[1, 2, 1], [0, 1, 3], [1, 0, 1]]
  D: [[-(K), 0, 0], [0, 0, 1], [0, 0, 0]]
  Ti: [[1/6, -2/6, 5/6], [3/6, 0, -3/6], [-1/6, 2/6, 1/6]]
A: T @ D @ Ti
H: "[[ROW]] @ Ti"
interval: {stop: 10}
"""
ROWS = [("1,1,0", 3), ("0,1,0", 2), ("1,0,0", 1)]


def rotated(k, row):
    return ROTATED.replace("K", str(k)).replace("ROW", row)


@pytest.mark.parametrize(("row", "rank"), ROWS)
@pytest.mark.parametrize("k", [50, 3, -3, 0.3])
def test_decaying_directions(numeric, k, row, rank):
    found = numeric(rotated(k, row))
    assert found.rank == rank
    assert found.spaces.decided.all()
    assert (found.spaces.rank == rank).all()


@pytest.mark.parametrize(
    ("method", "k"), [("quadrature", 50), ("quadrature", 3), ("quadrature", 1), ("quadrature", -3), ("lyapunov", 3), ("lyapunov", 1), ("lyapunov", -3)]
)  # fmt: skip
@pytest.mark.parametrize(("row", "rank"), ROWS)
def test_no_method_decides_a_rank_above_the_exact_one(numeric, k, row, rank, method):
    found = numeric(rotated(k, row), method=method, samples=20)
    assert (found.spaces.rank[found.spaces.decided] <= rank).all()
    assert found.rank == rank


def test_what_is_too_stiff_for_an_explicit_integrator_is_refused(numeric):
    with pytest.raises(NotComputableError, match="could not be integrated"):
        numeric(rotated(50, "0,1,0"), method="lyapunov", samples=2)


@pytest.mark.parametrize(("k", "windowed"), [(50, True), (3, False), (-3, False), (-50, False)])
def test_the_window_is_reported_where_the_whole_interval_drowns(numeric, k, windowed):
    """Φ(τ, t) grows backwards by e^500 for k = 50; for k < 0 it fades, and the whole interval serves."""
    found = numeric(rotated(k, "0,1,0"))
    assert (found.window is not None) == windowed
    if windowed:
        length = found.horizon.instants - found.spaces.gramian.starts
        assert found.window == pytest.approx(length[found.spaces.gramian.starts > 0].min())
        assert found.window * k < 100
        assert (length > 0).all()


@pytest.mark.parametrize("rate", [30, 300, 3000])
def test_a_state_that_decays_at_once_hides_nothing(numeric, rate):
    """A fast filter behind slow states: y = x1 + x3, x3' = −rate (x3 − x2)."""
    text = f"states: [a, b, c]\nA: [[0, 1, 0], [-1, 0, 0], [0, {rate}, -{rate}]]\nH: [[1, 0, 1]]\ninterval: {{stop: 30, samples: 10}}\n"
    found = numeric(text)
    assert found.rank == 3
    assert (found.spaces.rank[found.spaces.decided] <= 3).all()


# -- an almost critical system: alpha_w = alpha_omega (1 + e)


@pytest.mark.parametrize(
    ("e", "expected"), [("1/10^4", {5}), ("1/10^6", {5}), ("1/10^9", {4, 5}), ("1/10^13", {4}), ("0", {4})]
)
def test_an_almost_critical_system(numeric, exact, bundled, e, expected):
    """The fifth singular value is about e/15 of the fourth; below 1e-14 of it everything is rounding.

    So e = 1e-9 stands 150 times above its noise and may be seen, and 1e-13 is never: rank 4 is then a lower
    bound, as it says. Never is rank 5 decided where both rates are equal.
    """
    given = bundled("kortunov/single_channel.yaml", settings={"alpha_w": f"alpha_omega*(1 + {e})"})
    rank = exact(given).at_values.rank
    found = numeric(given)
    ranks = found.spaces.rank[found.spaces.decided]
    assert (ranks <= rank).all()
    assert set(ranks.tolist()) <= expected
    assert found.rank in expected
    assert rank == (4 if e == "0" else 5)
