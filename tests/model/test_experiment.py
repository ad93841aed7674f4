"""``experiment`` and ``plan``: the runs as systems, their names and order, and the states they share."""

from itertools import product

import pytest

from obscli.core.place import ModelError
from obscli.model.notation import to_text
from obscli.model.reader import load, read_text


MODEL = """\
states: {psi: 2, b: 2, d: 1}
parameters: {w: 1, g: 9.8}
functions: {f: 2}
let: {a: w, k: 2*a}
dynamics: {psi: k*b}
measurements: {y: psi, z: g*d}
noise: {R: 1, P0_std: {d: g}}
interval: {start: 0, stop: 60}
stages: {one: {}, two: {let: {a: g}}, doubled: {fix: {w: 2*w}}}
"""


def experiment(*lines, model=MODEL, **options):
    return read_text(model + "\n".join(lines), "model.yaml", **options).experiment


def runs(text, **options):
    return experiment(f"experiment: {{runs: {text}}}", **options).runs


def names(text, **options):
    return [run.name for run in runs(text, **options)]


def shared(*lines, **options):
    return experiment(*lines, **options).shared


def gain(run):
    """The coefficient of b1 in the derivative of psi1."""
    return to_text(run.system.A.entries[0, 2])


def problems(*lines, model=MODEL):
    with pytest.raises(ModelError) as caught:
        experiment(*lines, model=model)
    return [problem.message for problem in caught.value.problems]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("[one]", ["one"]),
        ("[{stage: one}]", ["one"]),
        ("[two, one, two]", ["two", "one", "two #2"]),
        ("[{stage: [two, one]}]", ["two", "one"]),
        ("[{stage: one, repeat: 3}]", ["one", "one #2", "one #3"]),
        ("[{stage: [one, two], repeat: 2}]", ["one", "one #2", "two", "two #2"]),
        ("[{stage: one, fix: {w: -w}}]", ["one (w = -w)"]),
        ("[{stage: one, fix: {w: 2*pi/3, f: '[t, 1]'}}]", ["one (w = 2*pi/3, f = [t, 1])"]),
        ("[{stage: one, fix: {f: [t, 1]}}]", ["one (f = [t, 1])"]),
        ("[{stage: one, grid: {w: [0, pi/2]}}]", ["one (w = 0)", "one (w = pi/2)"]),
        ("[{stage: one, fix: {g: 1}, grid: {w: [0]}}]", ["one (g = 1, w = 0)"]),
        ("[{stage: one, parameters: {w: 2}, let: {a: 3}}]", ["one"]),
        (
            "[{stage: one, grid: {g: [1, g], w: [w, -w]}}]",
            ["one (g = 1)", "one (g = 1, w = -w)", "one", "one (w = -w)"],
        ),
        ("[{stage: one, name: back, fix: {w: -w}}]", ["back"]),
        ("[{stage: one, name: back, repeat: 2}]", ["back", "back #2"]),
        ("[{stage: one, name: up, grid: {w: [1, 2]}}]", ["up (w = 1)", "up (w = 2)"]),
        ("[{fix: {w: 0}}]", ["w = 0"]),
        ("[{name: rest, fix: {w: 0}}]", ["rest"]),
        ("[{}, {interval: {stop: 5}}]", ["run", "run #2"]),
        ("[{stage: one, grid: {w: [1, 1]}}]", ["one (w = 1)", "one (w = 1) #2"]),
        ("[{stage: two, name: 'one #2'}, one, one]", ["one #2", "one", "one #3"]),
    ],
)
def test_names(text, expected):
    assert names(text) == expected


def test_runs_that_differ_by_their_number_share_a_system():
    found = runs("[one, {stage: [one, two], grid: {w: [1, 2]}, repeat: 2}, two, two]")

    assert [run.system.stage for run in found] == [
        *("one", "one (w = 1)", "one (w = 1)", "one (w = 2)", "one (w = 2)"),
        *("two (w = 1)", "two (w = 1)", "two (w = 2)", "two (w = 2)", "two", "two"),
    ]
    assert all((a.system is b.system) == (a.system.stage == b.system.stage) for a, b in product(found, found))


def test_a_run_knows_its_stage_and_its_place():
    found = experiment(
        "experiment:", "  runs:", "  - two", "  - {stage: [one, two]}", "  - {fix: {w: 1}}"
    ).runs

    assert [run.stage for run in found] == ["two", "one", "two", None]
    assert [run.place.line for run in found] == [12, 13, 13, 14]


@pytest.mark.parametrize(
    ("text", "name"),
    [
        ("[{stage: one, name: x}, {stage: two, name: x}]", "x"),
        ("[two, {stage: one, name: two}]", "two"),
        ("[{stage: one, name: two}, two]", "two"),
        ("[{stage: one, name: x, grid: {w: [1]}}, {stage: two, name: x (w = 1)}]", "x (w = 1)"),
        ("[one, one, {stage: one, name: 'one #2'}]", "one #2"),
    ],
)
def test_a_name_given_to_different_runs_is_refused(text, name):
    assert problems(f"experiment: {{runs: {text}}}") == [f"there is a run '{name}' already, in line 10"]


def test_a_run_is_its_stage():
    for run, stage in zip(runs("[one, two, doubled]"), ("2*w", "2*g", "4*w"), strict=True):
        assert gain(run) == stage
        assert to_text(run.system.interval.stop) == "60"
        assert run.system.claims == ()


def test_the_first_key_of_a_grid_is_the_slowest():
    found = runs("[{stage: [one, two], grid: {w: [1, 2], g: [3, 4, 5]}}]")

    assert [run.name for run in found] == [
        f"{stage} (w = {w}, g = {g})" for stage, w, g in product(("one", "two"), (1, 2), (3, 4, 5))
    ]
    assert [gain(run) for run in found] == ["2", "2", "2", "4", "4", "4", *("6", "8", "10") * 2]


@pytest.mark.parametrize(
    ("run", "options", "expected"),
    [
        ("{fix: {w: -w}}", {}, "-2*w"),
        ("{fix: {w: 3}}", {}, "6"),
        ("{fix: {w: g, g: w}}", {}, "2*g"),
        ("{stage: two, fix: {w: g, g: w}}", {}, "2*w"),
        ("{stage: doubled, fix: {w: -w}}", {}, "-4*w"),
        ("{stage: doubled, fix: {w: w + g}}", {}, "2*(2*w + g)"),
        ("{stage: two, fix: {g: w}}", {}, "2*w"),
        ("{stage: doubled, let: {a: g}, fix: {g: w}}", {}, "4*w"),
        ("{fix: {w: -w}}", {"fix": {"w": "3"}}, "-6"),
        ("{stage: doubled, fix: {w: -w}}", {"fix": {"w": "3"}}, "-6"),
        ("{stage: two, fix: {g: 2*w}}", {"fix": {"w": "3"}}, "12"),
        ("{fix: {w: 5}}", {"fix": {"w": "3"}}, "10"),
        ("{stage: one}", {"fix": {"w": "3"}}, "6"),
        ("{stage: doubled, grid: {w: [w + 1]}}", {}, "2*(1 + 2*w)"),
    ],
)
def test_a_fix_of_a_run_refers_to_the_value_outside(run, options, expected):
    (found,) = runs(f"[{run}]", **options)

    assert gain(found) == expected


def test_a_fix_in_a_file_read_from_disk(tmp_path):
    path = tmp_path / "turned.yaml"
    path.write_text(f"{MODEL}experiment: {{runs: [doubled, {{stage: doubled, fix: {{w: -w}}}}]}}\n")

    assert [gain(run) for run in load(path).experiment.runs] == ["4*w", "-4*w"]
    assert [gain(run) for run in load(path, fix={"w": "g"}).experiment.runs] == ["2*g", "-2*g"]


@pytest.mark.parametrize(("fix", "expected"), [("f: [t, 1]", "t"), ("f1: t^2", "t**2"), ("f1: 2*f2", "2*f2")])
def test_a_function_is_fixed(fix, expected):
    (run,) = runs(f"[{{fix: {{{fix}}}}}]", model=MODEL.replace("psi: k*b", "psi1: f1*b1 + f2*b2"))

    assert gain(run) == expected


def test_what_a_run_replaces():
    plain, run = runs(
        "[one, {stage: two, let: {k: a^2}, parameters: {g: {value: 1.6, unit: m/s^2}},"
        " interval: {stop: 5, samples: 7}, noise: {R: [g, 2, 3]}}]"
    )

    assert gain(run) == "g**2"
    assert [(p.name, to_text(p.nominal), p.unit) for p in run.system.parameters] == [
        ("w", "1", ""),
        ("g", "8/5", "m/s^2"),
    ]
    assert [to_text(run.system.noise.R.entries[k, k]) for k in range(3)] == ["g", "2", "3"]
    assert run.system.noise.P0.entries.keys() == {(4, 4)}
    interval = run.system.interval
    assert (to_text(interval.start), to_text(interval.stop), interval.samples) == ("0", "5", 7)
    assert [to_text(one) for one in plain.system.noise.R.entries.values()] == ["1"] * 3
    assert (gain(plain), to_text(plain.system.interval.stop)) == ("2*w", "60")


def test_what_stands_still_everywhere_is_shared():
    assert shared("experiment: {runs: [one, two]}") == ("b1", "b2", "d")
    assert shared("experiment: {runs: [{fix: {w: 0}}]}") == ("psi1", "psi2", "b1", "b2", "d")
    assert shared("experiment: {runs: [{fix: {w: 0}}, one]}") == ("b1", "b2", "d")


def test_what_is_driven_does_not_stand_still():
    model = (
        MODEL.replace("{psi: k*b}", "{psi1: 0*b1, b1: u, b2: n, d: 0*u}") + "inputs: [u]\ndisturbances: [n]\n"
    )

    assert shared("experiment: {runs: [one]}", model=model) == ("psi1", "psi2", "d")


def test_the_candidates_of_a_plan_count_too():
    lines = "experiment: {runs: [{fix: {w: 0}}]}", "plan: {candidates: [two]}"

    assert shared(*lines) == ("b1", "b2", "d")


@pytest.mark.parametrize(
    ("lists", "expected"),
    [
        ("fresh: [b]", ("d",)),
        ("fresh: [b2, d]", ("b1",)),
        ("fresh: [psi1]", ("b1", "b2", "d")),
        ("fresh: []", ("b1", "b2", "d")),
        ("constant: [b]", ("b1", "b2")),
        ("constant: [d, b1]", ("b1", "d")),
        ("constant: []", ()),
    ],
)
def test_shared_by_name(lists, expected):
    assert shared(f"experiment: {{runs: [one, two], {lists}}}") == expected


def test_a_constant_that_moves_is_refused():
    found = problems("experiment: {runs: [{fix: {w: 0}}, two], constant: [psi, b, d]}")

    assert found == [f"'psi{k}' is not constant: its derivative is not zero in run 'two'" for k in (1, 2)]


def test_a_plan():
    found = experiment(
        "experiment: {runs: [one]}",
        "plan: {candidates: [two, {stage: one, grid: {w: [1, 2]}}], setup_time: 10*w,",
        "       forbidden: [two, ['one (w = 1)', one (w = 2)]]}",
    )

    assert [run.name for run in found.runs] == ["one"]
    assert [run.name for run in found.plan.candidates] == ["two", "one (w = 1)", "one (w = 2)"]
    assert [gain(run) for run in found.plan.candidates] == ["2*g", "2", "4"]
    assert found.plan.forbidden == (("two",), ("one (w = 1)", "one (w = 2)"))
    assert to_text(found.plan.setup_time) == "10*w"


def test_a_plan_chooses_from_the_runs_of_the_experiment():
    plan = experiment("experiment: {runs: [one, two]}", "plan: {forbidden: [[one, two]]}").plan

    assert (plan.candidates, plan.forbidden, plan.setup_time) == (None, (("one", "two"),), None)


def test_a_plan_without_an_experiment():
    found = experiment("plan: {candidates: [one, two]}")

    assert (found.name, found.runs, found.shared) == ("", (), ("b1", "b2", "d"))
    assert [run.name for run in found.plan.candidates] == ["one", "two"]


def test_neither_experiment_nor_plan():
    assert experiment() is None
    assert experiment("experiment: {name: e, description: two spins, runs: [one]}").plan is None


def test_options_reach_the_runs():
    lines = "experiment: {runs: [one, {stage: two, parameters: {w: 7}}]}", "plan: {candidates: [doubled]}"
    found = experiment(*lines, settings={"w": "5"}, outputs=["z"], without=["d", "psi2"])

    for run in (*found.runs, *found.plan.candidates):
        assert run.system.state_names == ("psi1", "b1", "b2")
        assert [one.name for one in run.system.outputs] == ["z"]
        assert to_text(run.system.parameters[0].nominal) == "5"
    assert found.shared == ("b1", "b2")


@pytest.mark.parametrize(
    "text",
    [
        "[{stage: one, repeat: 500}, two]",
        "[{stage: [one, two], repeat: 251}]",
        f"[{{stage: one, grid: {{w: [1{', 1' * 500}]}}}}]",
        f"[{{stage: one, grid: {{w: [1{', 1' * 999}], g: [1{', 1' * 999}]}}}}]",
        f"[{{stage: one, grid: {{w: [1{', 1' * 90_000}]}}}}]",
        f"[one{', one' * 90_000}]",
    ],
)
def test_too_many_runs(text, monkeypatch):
    """Refused before one of them is made, whatever their number."""
    monkeypatch.setattr("obscli.model.stages.Variants.run", None)

    assert problems(f"experiment: {{runs: {text}}}") == ["more than 500 runs"]


def test_a_hundred_thousand_combinations_are_not_written_out(monkeypatch):
    made = []
    monkeypatch.setattr("obscli.model.experiment.label", lambda *_: made.append(1) or "x")

    axes = ", ".join(f"{name}: [1, 2, 3, 4, 5, 6, 7, 8, 9, 10]" for name in ("w", "g", "f1", "f2", "h"))
    model = MODEL.replace("g: 9.8", "g: 9.8, h: 1")
    assert problems(f"experiment: {{runs: [{{grid: {{{axes}}}}}]}}", model=model) == ["more than 500 runs"]
    assert len(made) == 501


def test_as_many_runs_as_may_be():
    found = experiment(
        "experiment: {runs: [{stage: one, repeat: 500}]}", "plan: {candidates: [{repeat: 500}]}"
    )

    assert len({run.name for run in found.runs}) == len(found.plan.candidates) == 500


def test_a_file_without_stages():
    model = "states: [x, b]\nparameters: {w: 1}\nA: [[0, w], [0, 0]]\nH: [[1, 0]]\n"
    found = experiment("experiment: {runs: [{name: there}, {name: back, fix: {w: -w}}]}", model=model)

    assert [(run.name, run.stage, to_text(run.system.A.entries[0, 1])) for run in found.runs] == [
        ("there", None, "w"),
        ("back", None, "-w"),
    ]
    assert found.shared == ("b",)


INCOMPLETE = (
    "states: [x]\nparameters: {g: 1}\nlet: {Q: , a: 2*Q}\nA: [[a]]\nH: [[1]]\nstages: {one: {let: {Q: g}}}\n"
)


def test_a_run_may_complete_the_base():
    found = runs("[{let: {Q: 3}}, one]", model=INCOMPLETE)

    assert [to_text(run.system.A.entries[0, 0]) for run in found] == ["6", "2*g"]


def test_a_run_of_an_incomplete_base_is_refused():
    found = problems("experiment: {runs: [one, {name: bare, fix: {g: 2}}]}", model=INCOMPLETE)

    assert found == ["'Q' has no value in this stage; only 'one' define it (in run 'bare')"]


def test_a_run_of_a_base_without_measurements_is_refused():
    model = "states: [x]\nparameters: {g: 1}\nA: [[g]]\nstages: {one: {H: [[1]]}}\n"
    (message,) = problems("experiment: {runs: [one, {name: bare}]}", model=model)

    assert message.endswith("has neither `H` nor `measurements` (in run 'bare')")
