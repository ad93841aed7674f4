"""Samples as functions of time: what interpolation reproduces, and what of a file is refused."""

from itertools import pairwise

import numpy as np
import pyarrow as pa
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pyarrow.parquet import write_table

from obscli.core.place import ModelError
from obscli.model.reader import load
from obscli.numeric.analysis import analyze
from obscli.numeric.errors import NotComputableError
from obscli.numeric.horizon import Wanted, horizon_of
from obscli.numeric.motion import Motion
from obscli.numeric.numeric_system import NumericSystem
from obscli.numeric.program import Program, jet
from obscli.numeric.settings import Settings
from obscli.numeric.signal_noise import noisier
from obscli.numeric.signal_table import read_columns
from obscli.numeric.signals import Samples, Signals, slopes_of


def samples(t, values, interpolation="cubic"):
    values = np.asarray(values, dtype=float).reshape(len(t), -1)
    names = tuple(f"f{k}" for k in range(values.shape[1]))
    return Samples("f.csv", names, interpolation, t, values, slopes_of(t, values))


@pytest.fixture
def model(tmp_path):
    """Return a system over a table of samples: f and g, or whatever the columns say."""

    def build(
        rows,
        columns="{f: a, g: b}",
        header="t,a,b",
        name="s.csv",
        rest="A: [[0, f], [0, 0]]\nH: [[g, 0]]",
        **keys,
    ):
        lines = (
            rows if isinstance(rows, str) else "\n".join(",".join(f"{x:.17g}" for x in row) for row in rows)
        )
        (tmp_path / name).write_text(f"{header}\n{lines}\n")
        given = "".join(f", {key}: {value}" for key, value in keys.items() if key != "time")
        signals = f"{{file: {name}, time: {keys.get('time', 't')}, columns: {columns}{given}}}"
        (tmp_path / "m.yaml").write_text(f"states: [x, y]\nsignals: {signals}\n{rest}\n")
        return load(tmp_path / "m.yaml").systems[0]

    return build


def motion(system, start, stop):
    return Motion(system, {}, start, stop)


@settings(max_examples=40, deadline=None)
@given(
    st.lists(st.floats(0.05, 3), min_size=4, max_size=30), st.lists(st.floats(-2, 2), min_size=4, max_size=4)
)
def test_cubics_are_reproduced_with_all_derivatives(steps, coefficients):
    t = np.cumsum(steps)
    cubic = np.polynomial.Polynomial(coefficients)
    found = samples(t, cubic(t))
    at = np.linspace(t[0], t[-1], 57)
    scale = max(np.abs(cubic(t)).max(), 1.0)
    for order in range(4):
        exact = cubic.deriv(order)(at) if order else cubic(at)
        assert np.abs(found.at(at, order, [0])[0] - exact).max() <= 1e-9 * scale / np.min(steps) ** order


def test_lines_are_reproduced_by_linear_interpolation():
    t = np.array([0.0, 0.5, 2.0, 2.1])
    found = samples(t, 3 - 2 * t, "linear")
    at = np.linspace(0, 2.1, 31)
    assert np.allclose(found.at(at, 0, [0])[0], 3 - 2 * at, atol=1e-14)
    assert np.allclose(found.at(at, 1, [0])[0], -2)


def test_previous_holds_the_last_sample():
    found = samples(np.array([0.0, 1.0, 2.0]), [5, 6, 7], "previous")
    assert found.at(np.array([0.0, 0.99, 1.0, 1.5, 2.0]), 0, [0])[0].tolist() == [5, 5, 6, 6, 7]


def test_a_derivative_is_that_of_the_interpolation():
    t = np.sort(np.random.default_rng(1).uniform(0, 5, 40))
    found = samples(t, np.sin(t))
    at, h = np.linspace(t[1], t[-2], 33), 1e-6
    for order in range(2):
        slope = (found.at(at + h, order, [0]) - found.at(at - h, order, [0])) / (2 * h)
        assert np.abs(found.at(at, order + 1, [0]) - slope).max() < 1e-5


def test_angles_are_unwrapped_before_their_factor(model):
    t = np.arange(0, 20, 0.5)
    system = model(
        np.column_stack([t, (40 * t) % 360, t]), "{f: {column: a, factor: pi/180, unwrap: 360}, g: b}"
    )
    at = np.linspace(0, 19, 41)
    found = motion(system, 0, 19).values(at, {"f": 1})
    assert np.allclose(found["f"], np.deg2rad(40 * at), atol=1e-12)
    assert np.allclose(found[jet("f", 1)], np.deg2rad(40), atol=1e-12)


@pytest.mark.parametrize(
    ("time", "start"),
    [
        ("{column: t, factor: 1e-3, zero: first}", 0.0),
        ("{column: t, factor: 1e-3}", 7.0),
        ("{column: t, factor: 1e-3, zero: 5000}", 2.0),
    ],
)
def test_time_is_column_minus_zero_times_factor(model, time, start):
    t = 7000 + np.arange(0, 1000, 50.0)
    horizon = horizon_of(model(np.column_stack([t, t, t]), time=time), Wanted())
    assert (horizon.start, horizon.origin) == (pytest.approx(start), "default")
    assert horizon.stop == pytest.approx(start + 0.95)


def test_the_default_interval_is_what_all_files_cover(tmp_path):
    for name, start, stop, step in (("a.csv", 0, 10, 0.1), ("b.csv", 3, 12, 0.25)):
        t = np.arange(start, stop + step / 2, step)
        np.savetxt(tmp_path / name, np.column_stack([t, np.sin(t)]), delimiter=",", header="t,a", comments="")
    (tmp_path / "m.yaml").write_text(
        "states: [x, y]\nsignals:\n- {file: a.csv, time: t, columns: {f: a}}\n"
        "- {file: b.csv, time: t, columns: {g: a}}\nA: [[0, f], [0, 0]]\nH: [[g, 0]]\n"
    )
    system = load(tmp_path / "m.yaml").systems[0]
    horizon = horizon_of(system, Wanted())
    assert (horizon.start, horizon.stop) == (pytest.approx(3), pytest.approx(10))
    found = motion(system, 3, 10).values(np.array([4.0, 9.0]), {})
    assert np.allclose(found["f"], np.sin([4, 9]), atol=1e-5)
    assert np.allclose(found["g"], np.sin([4, 9]), atol=1e-4)
    with pytest.raises(NotComputableError, match=r"a\.csv from 0 to 10, b\.csv from 3 to 12.*within 3 to 10"):
        motion(system, 0, 10)


def test_files_without_common_time_are_refused(tmp_path):
    for name, t in (("a.csv", "0\n1"), ("b.csv", "2\n3")):
        (tmp_path / name).write_text(f"t\n{t}\n")
    (tmp_path / "m.yaml").write_text(
        "states: [x]\nsignals:\n- {file: a.csv, time: t, columns: {f: t}}\n"
        "- {file: b.csv, time: t, columns: {g: t}}\nA: [[f]]\nH: [[g]]\n"
    )
    with pytest.raises(NotComputableError, match="do not overlap"):
        horizon_of(load(tmp_path / "m.yaml").systems[0], Wanted())


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        ("0,1,2\n1,,2", "line 3, column 'a': the cell is empty"),
        ("0,1,2\n1,n/a,2", "line 3, column 'a': 'n/a' is no number: leave out the line"),
        ("0,1,2\n1,5", "line 3: there are 2 cells, and none for 'b'"),
        ("0,1,2\n1,nan,2", "row 2 of the samples, column 'a': nan is no value"),
        ("0,1,2\n1,2,inf", "row 2 of the samples, column 'b': inf is no value"),
        ("0,1,2", "1 rows of samples; at least 2"),
        ("", "0 rows of samples; at least 2"),
        ("0,1,2\n1,1,2,3", "line 3: there are 4 cells, and 3 names of columns"),
        ("0,1,5,2\n1,2,5,2", "line 2: there are 4 cells.*decimals after a point"),
        ('0,"1,5",2\n1,1,2', "line 2, column 'a': '1,5' is no number: write the decimals after a point"),
        ("0,1,2\n1,1,2\n1,1,2\n2,1,1", "rows 2 and 3 .* stands twice"),
        ("0,1,2\n2,1,2\n1,1,2\n3,1,1", "rows 2 and 3 .* 1 follows 2"),
        ("3,1,2\n2,1,2\n1,1,2", "times go backwards"),
        ("t,1,2\n2,1,2", "line 2, column 't': 't' is no number"),
    ],
)
def test_what_is_no_record_is_refused_with_its_place(model, rows, message):
    with pytest.raises(NotComputableError, match=rf"s\.csv.*{message}"):
        horizon_of(model(rows), Wanted())


def test_a_decimal_comma_is_told(model):
    with pytest.raises(NotComputableError, match="decimals after a point"):
        horizon_of(model("0;1,5;2\n1;1;2", header="t;a;b"), Wanted())


def test_cells_that_are_empty_need_no_name(model):
    assert motion(model("0,1,2,\n1,1,2,,\n2,1,2"), 0, 2).values(np.array([1.0]), {})["f"] == pytest.approx(1)


def test_a_gap_is_refused_where_it_is(model):
    t = np.concatenate([np.arange(0, 3, 0.1), np.arange(7, 9, 0.1)])
    rows = np.column_stack([t, t, t])
    system = model(rows)
    with pytest.raises(NotComputableError, match=r"no samples from 2\.9 to 7, 41 times the median"):
        motion(system, 0, 8)
    assert motion(system, 0, 2.5).values(np.array([1.0]), {})["f"] == pytest.approx(1)
    assert motion(model(rows, max_gap=5), 0, 8).values(np.array([5.0]), {})["f"] == pytest.approx(5)


@pytest.mark.parametrize(("interpolation", "most"), [("cubic", 3), ("linear", 1), ("previous", 0)])
def test_derivatives_beyond_the_interpolation_are_refused(model, interpolation, most):
    t = np.arange(0, 5, 0.1)
    found = motion(model(np.column_stack([t, t, t]), interpolation=interpolation), 0, 4)
    found.values(np.array([1.0]), {"f": most})
    with pytest.raises(NotComputableError, match=f"order {most + 1} of the signal f"):
        found.values(np.array([1.0]), {"f": most + 1})


@pytest.mark.parametrize("interpolation", ["cubic", "linear", "previous"])
def test_edges_stand_at_the_samples(model, interpolation):
    """The Gramian of a kinked record is that of its pieces, each integrated by itself."""
    rng = np.random.default_rng(5)
    t = np.cumsum(rng.uniform(0.1, 0.4, 24))
    rows = np.column_stack([t, rng.uniform(-1, 1, 24), rng.uniform(1, 2, 24)])
    system = model(rows, interpolation=interpolation)
    numeric = NumericSystem(system, t[0], t[-1])
    fine, weights = np.polynomial.legendre.leggauss(12)
    W, phi = np.zeros((2, 2)), 0.0  # x' = f y, y' = 0: x(τ) = x(t) − ∫_τ^t f y
    for a, b in reversed(list(pairwise(t))):
        nodes, h = (a + b) / 2 + (b - a) / 2 * fine, b - a
        inner = [(x + b) / 2 + (b - x) / 2 * fine for x in nodes]
        parts = [(b - x) / 2 * weights @ f(numeric, one, "f") for x, one in zip(nodes, inner, strict=True)]
        g = f(numeric, nodes, "g")
        rows_ = np.column_stack([g, -g * (phi + np.array(parts))])
        W += rows_.T @ (h / 2 * weights[:, None] * rows_)
        phi += h / 2 * weights @ f(numeric, nodes, "f")
    found = analyze(system, Settings(Wanted(samples=1))).spaces.gramian
    root = found.matrices[0] / found.units[0]
    assert np.allclose(root.T @ root, W, rtol=1e-11, atol=1e-12)


def f(numeric, t, name):
    return numeric.values(t, {})[name]


ANALYTIC = "let: {f: 2 + sin(3*t), g: cos(t), h: exp(-t/5)}\n"
REST = "states: [x, y, z]\nA: [[0, f, 0], [0, 0, g], [0, 0, 0]]\nH: [[1, h, 0]]\ninterval: {start: 1, stop: 6, samples: 5}\n"


def test_dense_samples_are_the_function(tmp_path):
    t = np.arange(0, 7.0001, 0.01)
    columns = [t, 2 + np.sin(3 * t), np.cos(t), np.exp(-t / 5)]
    np.savetxt(
        tmp_path / "s.csv",
        np.column_stack(columns),
        delimiter=",",
        header="t,f,g,h",
        comments="",
        fmt="%.17g",
    )
    (tmp_path / "a.yaml").write_text(ANALYTIC + REST)
    (tmp_path / "s.yaml").write_text("signals: {file: s.csv, time: t, columns: {f: f, g: g, h: h}}\n" + REST)
    a, s = (analyze(load(tmp_path / name).systems[0], Settings()) for name in ("a.yaml", "s.yaml"))
    assert a.rank == s.rank == 3
    roots = [one.spaces.gramian.matrices / one.spaces.gramian.units[:, None] for one in (a, s)]
    W, other = (np.swapaxes(root, 1, 2) @ root for root in roots)
    size = np.sqrt(np.einsum("ijj->ij", W))
    assert np.abs((W - other) / size[:, :, None] / size[:, None, :]).max() < 1e-6


def test_signals_in_the_nominal_trajectory_of_a_linearisation(tmp_path):
    t = np.arange(0, 5, 0.1)
    np.savetxt(tmp_path / "s.csv", np.column_stack([t, 3 * t]), delimiter=",", header="t,a", comments="")
    (tmp_path / "m.yaml").write_text(
        "states: [p, q]\nsignals: {file: s.csv, time: t, columns: {path: a}}\ndynamics: {p: q}\n"
        "measurements: {y: p**2}\nlinearize: {trajectory: {p: path, q: deriv(path)}}\n"
    )
    system = load(tmp_path / "m.yaml").systems[0]
    (entry,) = system.H.entries.values()
    numeric = NumericSystem(system, 0, 4)
    assert Program([entry]).run(numeric.values(np.array([2.0]), {}))[0] == pytest.approx(12.0)


def test_knots_at_an_edge_are_no_edges_of_their_own(model):
    t = np.arange(0, 5, 0.1)
    numeric = NumericSystem(model(np.column_stack([t, t, t])), 0, 4)
    assert np.allclose(numeric.knots(0.1, 0.5), [0.2, 0.3, 0.4])


def test_variables_of_archives(tmp_path):
    from scipy.io import savemat

    t, v = np.arange(5.0), np.arange(15.0).reshape(5, 3)
    np.savez(tmp_path / "a.npz", t=t, v=v)
    savemat(tmp_path / "a.mat", {"t": t, "v": v})
    for name in ("a.npz", "a.mat"):
        found = read_columns(tmp_path / name, ["t", "v[2]"])
        assert found.tolist() == [t.tolist(), v[:, 1].tolist()]
        with pytest.raises(NotComputableError, match=r"v is 5×3, no column"):
            read_columns(tmp_path / name, ["t", "v"])
        with pytest.raises(NotComputableError, match="v has 3 columns, not 4"):
            read_columns(tmp_path / name, ["t", "v[4]"])
        with pytest.raises(NotComputableError, match="no variable 'w'"):
            read_columns(tmp_path / name, ["w"])


def test_entries_on_one_file_get_noise_of_their_own(tmp_path):
    t = np.arange(0, 50, 0.1)
    np.savetxt(tmp_path / "s.csv", np.column_stack([t, 0 * t]), delimiter=",", header="t,a", comments="")
    (tmp_path / "m.yaml").write_text(
        "states: [x]\nsignals:\n- {file: s.csv, time: t, columns: {f: a}}\n"
        "- {file: s.csv, time: t, columns: {g: a}}\nA: [[f]]\nH: [[g]]\n"
    )
    system = load(tmp_path / "m.yaml").systems[0]

    def drawn(draw):
        found = Signals(system, 0, 49, noisier({"f": 1.0, "g": 2.0}, draw)).values(t[:490], {})
        return np.array([found["f"], found["g"]])

    noise = np.concatenate([drawn(0), drawn(1)])
    assert np.allclose(np.std(noise, axis=1), [1, 2, 1, 2], rtol=0.15)
    assert np.abs(np.corrcoef(noise) - np.eye(4)).max() < 0.2
    assert np.array_equal(drawn(0), noise[:2])


def test_parquet_is_read_by_column(tmp_path):
    t, v = np.arange(5.0), np.arange(5) ** 2
    write_table(pa.table({"t": t, "v": v, "w": ["x"] * 5}), tmp_path / "a.parquet")
    assert read_columns(tmp_path / "a.parquet", ["v", "t"]).tolist() == [v.tolist(), t.tolist()]
    with pytest.raises(NotComputableError, match="no variable 'u'"):
        read_columns(tmp_path / "a.parquet", ["t", "u"])
    with pytest.raises(NotComputableError, match="w holds no real numbers"):
        read_columns(tmp_path / "a.parquet", ["t", "w"])


@pytest.mark.parametrize("ending", ["npz", "mat", "parquet"])
@pytest.mark.parametrize("text", ["", "no archive"])
def test_what_is_no_archive_is_refused(tmp_path, ending, text):
    (tmp_path / f"a.{ending}").write_text(text)
    with pytest.raises(NotComputableError, match=f"a.{ending} cannot be read as a "):
        read_columns(tmp_path / f"a.{ending}", ["t"])


def test_damaged_archives_are_refused(tmp_path):
    """Whatever bytes are changed or cut off, samples are read or refused, never anything else."""
    np.savez(tmp_path / "a.npz", t=np.arange(50.0))
    whole = (tmp_path / "a.npz").read_bytes()
    rng, outcomes = np.random.default_rng(2), set()
    for k in range(60):
        changed = bytearray(whole if k % 3 else whole[: rng.integers(len(whole))])
        for place in rng.integers(max(len(changed), 1), size=min(k % 3, len(changed))):
            changed[place] ^= 1 + rng.integers(255)
        (tmp_path / "a.npz").write_bytes(changed)
        try:
            outcomes.add(len(read_columns(tmp_path / "a.npz", ["t"])))
        except NotComputableError as error:
            outcomes.add(str(error).split(":")[0])
    assert "a.npz cannot be read as a NumPy archive" in outcomes


def test_text_that_is_not_in_utf_8_is_refused(tmp_path):
    (tmp_path / "s.csv").write_text("t,a\n0,1\n1,2\n", encoding="utf-16")
    (tmp_path / "m.yaml").write_text(
        "states: [x]\nsignals: {file: s.csv, time: t, columns: {f: a}}\nA: [[f]]\nH: [[1]]\n"
    )
    with pytest.raises(ModelError, match=r"s\.csv: the file is no text in UTF-8"):
        load(tmp_path / "m.yaml")


def test_an_array_without_a_name_is_no_archive(tmp_path):
    np.save(tmp_path / "a.npy", np.arange(5.0))
    (tmp_path / "a.npy").rename(tmp_path / "a.npz")
    with pytest.raises(NotComputableError, match=r"one array without a name: save it by np\.savez"):
        read_columns(tmp_path / "a.npz", ["t"])


def test_a_changed_file_is_read_again(model):
    t = np.arange(0, 5, 0.1)
    first = motion(model(np.column_stack([t, t, t])), 0, 4).values(np.array([2.0]), {})["f"]
    second = motion(model(np.column_stack([t, 2 * t + 1, t])), 0, 4).values(np.array([2.0]), {})["f"]
    assert (float(first[0]), float(second[0])) == (pytest.approx(2), pytest.approx(5))


def test_rounding_of_time_is_an_error_of_the_signal(model):
    """Late in a long record a fast signal is known as well as time is."""
    t = 1e6 + np.arange(0, 5, 0.01)
    system = model(np.column_stack([t, np.sin(100 * t), t]))
    numeric = NumericSystem(system, t[0], t[-1])
    at = t[0] + np.linspace(1, 3, 7)
    errors = numeric.errors(numeric.values(at, {}))["f"]
    assert (errors > 1e-17 * 1e6).all()
