"""``obscli measures`` from the command line: tables, options, what is refused, exit codes, JSON."""

import json

import pytest

from obscli.render.line import cell_width


TILT = """\
parameters: {g: 9.8, R: 6378137}
states:
  dv: {unit: m/s, scale: 1}
  alpha: {unit: rad, scale: 1e-3}
  domega: {unit: rad/s, scale: 1e-4}
A: [[0, -g, 0], [1/R, 0, 1], [0, 0, 0]]
H: [[1, 0, 0]]
quantities: {drift: domega - alpha/100}
noise: {R: 1e-4, step: 1, P0_std: [1, 1e-3, 1e-4]}
interval: {stop: 50}
require: {domega: 1e-5}
"""
HIDDEN = "states: [tilt, bias]\nA: [[0, 0], [0, 0]]\nH: [[9.81, -1]]\nquantities: {seen: 9.81*tilt - bias}\n"


@pytest.fixture
def put(tmp_path):
    return lambda name, text: (tmp_path / name).write_text(text)


@pytest.fixture
def measures(obscli, put, tmp_path):
    put("tilt.yaml", TILT)
    put("hidden.yaml", HIDDEN)

    def run(*words, model="tilt.yaml"):
        found = obscli("measures", tmp_path / model, *words)
        return found.status, found.out, found.err

    return run


def test_the_tables_say_when_in_which_units_and_how_each_measure_is_read(measures):
    status, out, err = measures()
    assert (status, err) == (0, "")
    assert (
        "At t = 50, from t = 0. Rank 3 of 3 at the file's values. Units of the states: as the file gives them."
        in " ".join(out.split())
    )
    assert "determinant                  9223.68" in out
    assert "= g**4" in out
    assert "(17) row of the pseudo-inverse: smaller is better" in out
    assert "the ranking of the states by" in out
    assert "✓ 1 of 1 value asked for met" in out


@pytest.mark.parametrize("width", ["60", "80", "120"])
def test_no_line_is_wider_than_the_terminal(measures, monkeypatch, width):
    monkeypatch.setenv("COLUMNS", width)
    _, out, _ = measures("--details")
    assert max(map(cell_width, out.splitlines())) <= int(width)


def test_a_table_too_wide_is_folded_with_the_states_in_every_part(measures, monkeypatch):
    monkeypatch.setenv("COLUMNS", "50")
    _, out, _ = measures()
    table = out[: out.index("The system as a whole")]
    assert table.count("\n  alpha") > 1
    assert table.count("(17)") == 1


def test_what_is_not_observable_is_marked_in_every_column(measures):
    _, out, _ = measures(model="hidden.yaml")
    rows = [line.split() for line in out.splitlines() if line.strip().startswith(("tilt ", "bias "))]
    assert all(row.count("✗") == len(row[1:]) // 2 for row in rows)
    assert "9.81*tilt - bias" in out or "seen" in out
    assert "not measured: stochastic" in out


def test_json_has_every_measure_by_its_key(measures):
    status, out, _ = measures("--format", "json")
    assert status == 0
    found = json.loads(out)["results"][0]["measures"]
    assert (found["at"], found["scaling"], found["rank"]) == (50, "none", 3)
    assert set(found["states"]["alpha"]) == {
        "observable", "deterministic", "stochastic", "least-squares", "pseudo-inverse", "equivalent-singular-value",
        "column-norm", "covariance-reduction", "standard-deviation", "cramer-rao",
    }  # fmt: skip
    assert found["closed_forms"]["determinant"] == {"determinant": "g**4"}
    assert found["quantities"]["drift"]["observable"] is True
    assert found["quantities"]["drift"]["column-norm"] is None
    assert [one["met"] for one in found["limits"]] == [True]
    hidden = json.loads(measures("--format", "json", model="hidden.yaml")[1])["results"][0]["measures"]
    assert hidden["states"]["tilt"]["pseudo-inverse"] == "inf"
    assert hidden["combinations"][0]["expression"]
    assert "no `noise`" in hidden["not_measured"]["stochastic"]


def test_several_instants_are_measured_one_after_the_other(measures):
    _, out, _ = measures("--times", "10,50", "--select", "stochastic")
    assert "States at t = 10" in out
    assert "States at t = 50" in out
    found = json.loads(measures("--times", "10,50", "--format", "json")[1])["results"][0]["measures"]
    assert [one["at"] for one in found["times"]] == [10, 50]
    assert found["times"][1]["states"] == found["states"]


def test_a_threshold_that_is_missed_is_exit_code_1(measures):
    assert measures("--threshold", "pseudo-inverse=1")[0] == 0
    status, out, _ = measures("--threshold", "pseudo-inverse=0.5")
    assert status == 1
    assert "dv: pseudo-inverse is 1, at most 0.5 asked for" in out
    assert measures("--set", "g=9.8", "--threshold", "deterministic=2")[0] == 1


def test_a_requirement_that_is_not_met_is_exit_code_1(measures, put):
    put("strict.yaml", TILT.replace("1e-5}", "1e-7}"))
    status, out, _ = measures(model="strict.yaml")
    assert status == 1
    assert "domega: standard-deviation is 1.474e-6, at most 1e-7 asked for" in out


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("--select", "least-square"), "no measure 'least-square'; did you mean 'least-squares'?"),
        (
            ("--option", "least-squares.ds=3"),
            "no option 'least-squares.ds'; did you mean 'least-squares.dt'?",
        ),
        (("--option", "least-squares.N=2.5"), "a positive whole number is expected, not '2.5'"),
        (("--option", "least-squares.dt=0"), "a positive number is expected, not '0'"),
        (("--select", "modal", "--option", "least-squares.N=3"), "the measure least-squares is not selected"),
        (("--threshold", "modal=1"), "no measure of states 'modal'"),
        (("--threshold", "cramer-rao=x"), "a number is expected, not 'x'"),
        (("--at", "1", "--times", "2"), "--at gives one instant, --times several"),
        (("--at", "-1"), "the instant -1 is before the start 0"),
        (("--at", "10*u"), "unknown name 'u'"),
        (("--scaling", "automatic"), "'automatic' is not one of none, prior, scale"),
        (("--stage", "no"), "no stage 'no'"),
    ],
)
def test_what_does_not_fit_is_refused_by_name(measures, words, told):
    status, out, err = measures(*words)
    assert (status, out) == (2, "")
    assert told in " ".join(err.split())


def test_scaling_needs_the_sizes_of_all_states(measures):
    status, _, err = measures("--scaling", "prior", model="hidden.yaml")
    assert status == 2
    assert "--scaling prior needs `P0_std` under `noise`; missing for tilt, bias" in " ".join(err.split())


def test_nothing_measured_is_undecided_only_where_strict(measures, put):
    put("open.yaml", "parameters: {a: }\nstates: [x]\nA: [[a]]\nH: [[1]]\n")
    status, out, _ = measures(model="open.yaml")
    assert status == 0
    assert "not measured: parameter without a value: a" in out
    assert measures("--strict", model="open.yaml")[0] == 4


def test_figures_are_drawn_where_there_is_noise(measures, tmp_path):
    figures = tmp_path / "figures"
    assert measures("--plot", str(figures), "--select", "stochastic,standard-deviation")[0] == 0
    assert sorted(one.name for one in figures.glob("*.svg")) == ["tilt-deviation.svg", "tilt-stochastic.svg"]


def test_a_threshold_on_what_is_not_observable_is_missed_whatever_the_number(measures):
    status, out, _ = measures("--threshold", "column-norm=0.1", model="hidden.yaml")
    assert status == 1
    assert "tilt: column-norm is 9.81, and it is not observable, at least 0.1 asked for" in " ".join(
        out.split()
    )


def test_a_threshold_that_cannot_be_judged_is_undecided(measures):
    status, out, _ = measures("--threshold", "standard-deviation=1", "--strict", model="hidden.yaml")
    assert status == 4
    assert "tilt: standard-deviation is not known, asked for 1" in out


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("--select", "modal", "--threshold", "pseudo-inverse=1"), "this measure is not selected"),
        (("--threshold", "pseudo-inverse=nan"), "a number is expected, not 'nan'"),
        (("--at", "t"), "t has no value that is a constant"),
        (("--at", "1e400"), "the instant is not finite"),
    ],
)
def test_more_that_does_not_fit_is_refused(measures, words, told):
    status, out, err = measures(*words)
    assert (status, out) == (2, "")
    assert told in " ".join(err.split())


def test_what_is_missing_at_one_of_several_instants_is_said_with_the_instant(measures, put):
    put("parabola.yaml", "states: [a, b]\nA: [[0, 0], [0, 0]]\nH: [[1, t^2]]\n")
    _, out, _ = measures("--times", "0,5", "--select", "pseudo-inverse", model="parabola.yaml")
    assert "not measured: pseudo-inverse at 0:" in out
    assert "States at t = 5" in out


def test_a_step_that_had_to_be_taken_and_a_sample_motion_are_told(measures, put):
    put("open.yaml", "functions: [f]\nstates: [x, y]\nA: [[0, f], [0, 0]]\nH: [[1, 0]]\n"
                     "noise: {R: 1, P0_std: [1, 1]}\ninterval: {stop: 40}\n")  # fmt: skip
    out = " ".join(measures(model="open.yaml")[1].split())
    assert "one every 0.1 is taken (--step)" in out
    assert "f: left open in the file, taken along a sample motion" in out
    found = json.loads(measures("--format", "json", model="open.yaml")[1])["results"][0]["measures"]
    assert (found["assumed_step"], found["sampled_functions"]) == (0.1, ["f"])
    assert json.loads(measures("--format", "json")[1])["results"][0]["measures"]["assumed_step"] is None
