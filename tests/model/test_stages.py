import pytest

from obscli.core.place import ModelError
from obscli.model.covector import parse_covector
from obscli.model.notation import to_text
from obscli.model.reader import read_text


def read(*lines, **options):
    return read_text("\n".join(lines), "model.yaml", **options)


def A(system):
    return {key: to_text(node) for key, node in sorted(system.A.entries.items())}


BASE = (
    "states: [x, v]",
    "parameters: {g: 9.8, w: 1}",
    "let: {a: w, b: a*t}",
    "dynamics: {x: v, v: b*x}",
    "measurements: {y: x}",
)


def stages(model):
    return [system.stage for system in model.systems]


def test_the_base_comes_first():
    assert stages(read(*BASE, "stages: {one: {let: {a: g}}}")) == [None, "one"]


def test_an_empty_stage_is_the_base():
    assert stages(read(*BASE, "stages: {one: {}, two: {let: {a: g}}}")) == ["one", "two"]
    assert stages(read(*BASE, "stages: {one: }")) == ["one"]


def test_a_replaced_entry_keeps_its_place():
    model = read(*BASE, "stages: {one: {let: {a: g^2}}}")
    assert A(model.systems[0])[1, 0] == "w*t"
    assert A(model.systems[1])[1, 0] == "g**2*t"


def test_equations_are_replaced_one_by_one():
    model = read(*BASE, "stages: {one: {dynamics: {v: 0*x}, measurements: {z: v}}}")
    one = model.systems[1]
    assert A(one) == {(0, 1): "1"}
    assert [output.name for output in one.outputs] == ["y", "z"]


def test_a_matrix_replaces_equations_and_the_reverse():
    model = read(*BASE, "stages: {one: {A: eye(2), H: [[0, 1]]}}")
    assert A(model.systems[1]) == {(0, 0): "1", (1, 1): "1"}
    model = read(
        "states: [x]", "A: [[1]]", "H: [[1]]", "stages: {one: {dynamics: {x: 2*x}, measurements: {z: x}}}"
    )
    assert A(model.systems[1]) == {(0, 0): "2"}
    assert model.systems[1].outputs[0].name == "z"


def test_rows_of_a_sparse_matrix_are_replaced():
    model = read(
        "states: [x, v]", "A: {x: {v: 1}, v: {x: 2}}", "H: {y: {x: 1}}", "stages: {one: {A: {v: {v: 3}}}}"
    )
    assert A(model.systems[1]) == {(0, 1): "1", (1, 1): "3"}


def test_nominal_values_of_a_stage():
    model = read(*BASE, "stages: {one: {parameters: {g: 1.6, w: g}}}")
    one = model.systems[1]
    assert [(p.name, to_text(p.nominal)) for p in one.parameters] == [("g", "8/5")]
    assert A(one)[1, 0] == "g*t"


@pytest.mark.parametrize(
    "let",
    ["let: {Q: , a: Q}", "let: {a: Q}"],
)
def test_an_incomplete_base_is_passed_over(let):
    """A name that only stages define, with a placeholder in the base or without."""
    model = read(
        "states: [x]",
        "parameters: {g: 1}",
        let,
        "A: [[a]]",
        "H: [[1]]",
        "stages: {one: {let: {Q: g}}, two: {let: {Q: 2*g}}}",
    )
    assert stages(model) == ["one", "two"]
    assert A(model.systems[1]) == {(0, 0): "2*g"}


def test_a_base_without_matrices_is_passed_over():
    model = read("states: [x]", "A: [[1]]", "stages: {one: {H: [[1]]}, two: {H: [[2]]}}")
    assert stages(model) == ["one", "two"]


def test_a_stage_without_matrices_is_a_problem():
    with pytest.raises(ModelError, match="stage 'one' has neither `H` nor `measurements`"):
        read("states: [x]", "A: [[1]]", "stages: {one: {parameters: {}}, two: {H: [[2]]}}")


def test_new_entries_stand_after_what_they_use():
    lines = ("states: [x]", "let: {c: cos(t), R: , w: R*2}", "A: [[w]]", "H: [[1]]")
    model = read(*lines, "stages: {one: {let: {k: c + 1, R: k*c}}}")
    assert A(model.systems[0]) == {(0, 0): "2*(1 + cos(t))*cos(t)"}


def test_fix_of_a_stage():
    model = read(*BASE, "stages: {one: {fix: {w: pi/2}}, two: {fix: {w: -w}}, three: {fix: {w: 2*g}}}")
    one, two, three = model.systems[1:]
    assert A(one)[1, 0] == "pi*t/2"
    assert [p.name for p in one.parameters] == ["g"]
    assert A(two)[1, 0] == "-w*t"
    assert [p.name for p in two.parameters] == ["g", "w"]
    assert A(three)[1, 0] == "2*g*t"


def test_fix_of_functions():
    lines = (
        "states: [x]",
        "functions: {f: {components: [E, N]}, h: {derivative: -h}}",
        "A: [['deriv(f_E) + f_N']]",
        "H: [['deriv(h)']]",
    )
    model = read(
        *lines, "stages: {one: {fix: {f_E: t^2, h: 0}}, two: {fix: {f: 0}}, three: {fix: {f: [t, 1]}}}"
    )
    base, one, two, three = model.systems
    assert A(base) == {(0, 0): "deriv(f_E) + f_N"}
    assert A(one) == {(0, 0): "2*t + f_N"}
    assert [function.name for function in one.functions] == ["f_N"]
    assert one.H.entries == {}
    assert A(two) == {}
    assert A(three) == {(0, 0): "2"}


def test_a_derived_parameter_follows_what_is_fixed():
    model = read("parameters: {a: 1, b: 2*a}", "states: [x]", "A: [[b]]", "H: [[1]]", fix={"a": "3"})
    assert A(model.systems[0]) == {(0, 0): "6"}
    assert model.systems[0].parameters == ()


def test_fix_from_outside_wins():
    model = read(*BASE, "stages: {one: {fix: {w: g}}}", fix={"w": "7", "g": "w"})
    base, one = model.systems
    assert A(base)[1, 0] == "7*t"
    assert A(one)[1, 0] == "7*t"


def test_set_changes_the_nominal_value():
    model = read(*BASE, "stages: {one: {parameters: {w: 5}}}", settings={"w": "0.2"})
    assert [to_text(system.parameters[1].nominal) for system in model.systems] == ["1/5", "1/5"]


@pytest.mark.parametrize(
    ("options", "place", "message"),
    [
        ({"fix": {"W": "0"}}, ("--fix", 1, 1), "'W' is no parameter or function; did you mean 'w'"),
        ({"fix": {"x": "0"}}, ("--fix", 1, 1), "'x' is no parameter or function"),
        ({"fix": {"w": "2*"}}, ("--fix", 1, 5), "the expression ends"),
        ({"fix": {"w": "x"}}, ("--fix", 1, 3), "unknown name 'x'"),
        ({"settings": {"gg": "0"}}, ("--set", 1, 1), "'gg' is no parameter; did you mean 'g'"),
        ({"settings": {"g": "t"}}, ("--set", 1, 3), "'t' is no parameter"),
        ({"outputs": ["y", "yy"]}, ("--outputs", 1, 3), "'yy' is no output; did you mean 'y'"),
        ({"without": ["v", "z"]}, ("--without", 1, 3), "'z' is no state"),
        ({"without": ["x\x1b"]}, ("--without", 1, 1), "is no state"),
    ],
)
def test_wrong_options(options, place, message):
    with pytest.raises(ModelError, match=message) as caught:
        read(*BASE, **options)
    (problem,) = caught.value.problems
    assert (problem.place.file, problem.place.line, problem.place.column) == place


def test_outputs_and_without():
    lines = (
        "states: {psi: 3, b: 1}",
        "dynamics: {psi1: b + psi2, b: 2*b}",
        "measurements: {y: psi, z: b, s: psi1 + b}",
        "quantities: {e: psi1 + b, d: b}",
        "claims: [{rank: 3}]",
    )
    whole = read(*lines).systems[0]
    assert len(whole.claims) == 1
    some = read(*lines, outputs=["z", "y"]).systems[0]
    assert [output.name for output in some.outputs] == ["y1", "y2", "y3", "z"]
    assert some.H.rows == 4
    assert some.claims == ()
    less = read(*lines, without=["b", "psi3"]).systems[0]
    assert less.state_names == ("psi1", "psi2")
    assert A(less) == {(0, 1): "1"}
    assert (less.A.rows, less.A.columns, less.H.columns) == (2, 2, 2)
    assert [(one.name, list(one.coefficients)) for one in less.quantities] == [("e", ["psi1"])]
    assert set(less.A.places) == set(less.A.entries)
    assert list(parse_covector(less, "psi[1] + psi[3]", "--why").coefficients) == ["psi1"]
    with pytest.raises(ModelError, match="'b' is left out"):
        parse_covector(less, "b", "--why")
