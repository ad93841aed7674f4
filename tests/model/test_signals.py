"""``signals`` read: names become functions, stages replace files, what is written is read back."""

from fractions import Fraction

import pytest

from obscli.core.place import ModelError
from obscli.model.expression import Number
from obscli.model.frozen import frozen_at
from obscli.model.notation import to_text
from obscli.model.reader import load
from obscli.model.write import write_model


MODEL = """\
states: [x, y]
signals:
  file: imu.csv
  time: {column: t_ms, factor: 1e-3, zero: first}
  interpolation: linear
  columns: {f: [fx, fy], yaw: {column: hdg, factor: pi/180, unwrap: 360}}
let: {rate: deriv(yaw)}
A: [[f1, rate], [0, f2]]
H: [[cos(yaw), 1]]
"""


def texts(entries):
    return {key: to_text(one) for key, one in entries.items()}


@pytest.fixture
def write(tmp_path):
    """Write a model and the files it names; return the path of the model."""

    def files(text, *names, header="t_ms,fx,fy,hdg"):
        (tmp_path / "m.yaml").write_text(text)
        for name in names or ("imu.csv",):
            (tmp_path / name).write_text(f"{header}\n0,1,2,3\n10,2,3,4\n")
        return tmp_path / "m.yaml"

    return files


def test_columns_are_functions_of_time(write):
    system = load(write(MODEL)).systems[0]
    assert [one.name for one in system.functions] == ["f1", "f2", "yaw"]
    assert system.sampled == ("f1", "f2", "yaw")
    assert to_text(system.A.entries[0, 0]) == "f1"
    assert to_text(system.A.entries[0, 1]) == "deriv(yaw)"


def test_what_is_read_of_a_file(write):
    path = write(MODEL)
    (file,) = load(path).systems[0].signals
    assert file.file == path.parent / "imu.csv"
    assert (file.time, file.zero, file.interpolation) == ("t_ms", "first", "linear")
    assert [(one.name, one.column) for one in file.columns] == [("f1", "fx"), ("f2", "fy"), ("yaw", "hdg")]


def test_a_stage_replaces_keys_of_signals(write):
    path = write(
        MODEL + "stages:\n  a: {}\n  b: {signals: {file: other.csv, interpolation: cubic}}\n",
        "imu.csv",
        "other.csv",
    )
    a, b = load(path).systems
    assert [one.signals[0].file.name for one in (a, b)] == ["imu.csv", "other.csv"]
    assert [one.signals[0].interpolation for one in (a, b)] == ["linear", "cubic"]
    assert a.sampled == b.sampled


def test_the_base_may_leave_the_file_to_its_stages(write):
    path = write(MODEL.replace("  file: imu.csv\n", "") + "stages:\n  a: {signals: {file: imu.csv}}\n")
    assert [one.stage for one in load(path).systems] == ["a"]


def test_a_model_without_the_file_is_refused(write):
    with pytest.raises(ModelError, match="`file` is missing"):
        load(write(MODEL.replace("  file: imu.csv\n", "")))


def test_fix_takes_the_place_of_a_signal(write):
    system = load(write(MODEL), fix={"f1": "0"}).systems[0]
    assert system.sampled == ("f2", "yaw")
    assert (0, 0) not in system.A.entries


def test_a_signal_listed_under_functions_keeps_its_relations(write):
    text = MODEL.replace("let:", "functions: {f: {shape: 2, invariant: norm(f)**2 - 1}}\nlet:")
    system = load(write(text)).systems[0]
    assert system.sampled == ("f1", "f2", "yaw")
    assert len(system.invariants) == 1


def test_matrices_are_lists_of_lists(write):
    text = MODEL.replace("f: [fx, fy]", "f: [fx, fy], M: [[fx, fy], [fy, hdg]]").replace("rate, ", "")
    system = load(write(text.replace("[[f1, rate]", "[[f1, M12]"))).systems[0]
    assert "M12" in system.sampled


def test_the_noise_of_signals(write):
    noise = load(write(MODEL + "noise: {signals: {f: 0.05, yaw: 1/10}}\n")).systems[0].noise
    assert noise is not None
    assert {name: one.value for name, one in noise.signals.items()} == {
        "f1": Fraction(1, 20),
        "f2": Fraction(1, 20),
        "yaw": Fraction(1, 10),
    }


@pytest.mark.parametrize("noise", ["{signals: {fy: 1}}", "{signals: {f: -1}}", "{signals: {x: 1}}"])
def test_noise_of_what_is_no_signal_is_refused(write, noise):
    with pytest.raises(ModelError):
        load(write(f"{MODEL}noise: {noise}\n"))


def test_what_is_written_is_read_back(write, tmp_path):
    system = load(write(MODEL + "noise: {signals: {f: 0.05}}\n")).systems[0]
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    (elsewhere / "copy.yaml").write_text(write_model(system))
    again = load(elsewhere / "copy.yaml").systems[0]
    assert again.sampled == system.sampled
    assert texts(again.A.entries) == texts(system.A.entries)
    (mine,), (other,) = system.signals, again.signals
    assert mine.file.resolve() == other.file.resolve()
    assert (mine.time, mine.zero, mine.interpolation) == (other.time, other.zero, other.interpolation)
    assert to_text(mine.factor) == to_text(other.factor)
    assert [(c.name, c.column) for c in mine.columns] == [(c.name, c.column) for c in other.columns]
    factors = [[to_text(c.factor) for c in one.columns if c.factor is not None] for one in (mine, other)]
    assert factors[0] == factors[1] == ["pi/180"]
    assert system.noise is not None
    assert again.noise is not None
    assert texts(again.noise.signals) == texts(system.noise.signals)


def test_a_frozen_system_has_no_signals(write):
    frozen = frozen_at(load(write(MODEL)).systems[0], Number(1))
    assert not frozen.sampled
    assert all(one.derivative is not None for one in frozen.functions)


@pytest.mark.parametrize(
    ("header", "name"),
    [
        ("t;a b;c", "a b"),
        ("# t, a, c", "a"),
        ("\ufefft,a,c", "t"),
        ("t\ta\tc", "c"),
        ("t a c", "c"),
        ('"t","a","c"', "a"),
    ],
)
def test_headers(tmp_path, header, name):
    (tmp_path / "d.csv").write_text(
        f"\n{header}\n0,1,2\n" if not header.startswith("\ufeff") else f"{header}\n0,1,2\n", encoding="utf-8"
    )
    (tmp_path / "m.yaml").write_text(
        f"states: [x]\nsignals: {{file: d.csv, time: t, columns: {{f: '{name}'}}}}\nA: [[f]]\nH: [[1]]\n"
    )
    assert load(tmp_path / "m.yaml").systems[0].sampled == ("f",)
