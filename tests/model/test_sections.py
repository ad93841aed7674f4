"""Every key of the contract: what it means, as far as the model says it."""

from fractions import Fraction

import pytest

from obscli.core.place import ModelError
from obscli.model.expression import Number
from obscli.model.notation import covector_text, to_text
from obscli.model.reader import read_text


def system(*lines, **options):
    return read_text("\n".join(lines), "model.yaml", **options).systems[0]


def entries(matrix):
    return {key: to_text(node) for key, node in sorted(matrix.entries.items())}


def state_names(text):
    names = system(f"states: {text}", "dynamics: {}", "measurements: {}").state_names
    return " ".join(names)


def test_the_four_line_model():
    one = system(
        "states: [dv, alpha, domega]",
        "parameters: {g: 9.81, R: 6378137}",
        "A: [[0, -g, 0], [1/R, 0, 1], [0, 0, 0]]",
        "H: [[1, 0, 0]]",
    )
    assert entries(one.A) == {(0, 1): "-g", (1, 0): "1/R", (1, 2): "1"}
    assert entries(one.H) == {(0, 0): "1"}
    assert [output.name for output in one.outputs] == ["y1"]
    assert one.stage is None
    assert one.time == "t"
    assert one.parameters[0].nominal.value == Fraction(981, 100)


@pytest.mark.parametrize(
    ("text", "names"),
    [
        ("[a, b]", "a b"),
        ("{h: 1}", "h"),
        ("{h: {}}", "h"),
        ("{h: }", "h"),
        ("{psi: 3}", "psi1 psi2 psi3"),
        ("{psi: {shape: 2}, b: 1}", "psi1 psi2 b"),
        ("{M: [2, 2]}", "M11 M12 M21 M22"),
        ("{M: {shape: [3, 3], structure: lower}}", "M11 M21 M22 M31 M32 M33"),
        ("{M: {shape: [3, 3], structure: upper}}", "M11 M12 M13 M22 M23 M33"),
        ("{M: {shape: [2, 2], structure: diagonal}}", "M11 M22"),
        ("{M: {shape: [2, 2], structure: symmetric}}", "M11 M12 M22"),
        ("{phi: {components: [E, N, U]}}", "phi_E phi_N phi_U"),
        ("{M: [1, 10]}", " ".join(f"M_1_{k}" for k in range(1, 11))),
        ("{v: 10}", " ".join(f"v_{k}" for k in range(1, 11))),
    ],
)
def test_state_names(text, names):
    assert state_names(text) == names


def test_components_in_expressions():
    one = system(
        "states: {psi: 3, M: [2, 2], v: 12, S: {shape: [2, 2], structure: symmetric}}",
        "dynamics: {psi1: 'psi[2] + M[1, 2] + v[12] + v12 + v_12', S: 2*S}",
        "measurements: {y: 'S[2, 1]'}",
    )
    names = one.state_names
    assert {names[j]: text for (i, j), text in entries(one.A).items() if i == 0} == {
        "psi2": "1",
        "M12": "1",
        "v_12": "3",
    }
    assert {names[j]: text for (_, j), text in entries(one.H).items()} == {"S12": "1"}


def test_state_attributes():
    one = system(
        "states: {psi: {shape: 2, unit: rad, description: attitude, latex: \\psi, scale: 5*pi/180}, b: 1}",
        "dynamics: {psi1: b}",
        "measurements: {y: b}",
    )
    first, _, last = one.states
    assert (first.vector, first.unit, first.description, first.latex) == (
        "psi",
        "rad",
        "attitude",
        "{\\psi}_{1}",
    )
    assert to_text(first.scale) == "pi/36"
    assert (last.vector, last.unit, last.latex, last.scale) == ("", "", "", None)
    assert (first.place.line, first.place.column) == (1, 10)


def test_parameters():
    one = system(
        "parameters:",
        "  g: {value: 9.81, unit: m/s^2, description: gravity, assume: positive}",
        "  w: 2*pi/86400",
        "  free:",
        "  gone: null",
        "  a_w: w",
        "  twice: 2*a_w + g",
        "states: [x]",
        "A: [[twice + free]]",
        "H: [[gone]]",
    )
    assert [parameter.name for parameter in one.parameters] == ["g", "w", "free", "gone"]
    g, w, free, gone = one.parameters
    assert (g.unit, g.description, g.assume) == ("m/s^2", "gravity", "positive")
    assert to_text(w.nominal) == "pi/43200"
    assert (free.nominal, gone.nominal) == (None, None)
    assert entries(one.A) == {(0, 0): "2*w + g + free"}


def test_functions():
    one = system(
        "time: tau",
        "functions:",
        "  q: {shape: 4, derivative: 1/2*omega4(w) @ q, invariant: norm(q)**2 - 1}",
        "  f: {components: [E, N]}",
        "  h: {derivative: -h}",
        "  r: ",
        "let: {w: [tau, r, 0]}",
        "states: [x]",
        "A: [['deriv(deriv(h)) + deriv(q[2]) + deriv(f_E*tau)']]",
        "H: [['f[2] + deriv(deriv(r))']]",
    )
    functions = {function.name: function for function in one.functions}
    assert list(functions) == ["q1", "q2", "q3", "q4", "f_E", "f_N", "h", "r"]
    assert to_text(functions["q1"].derivative) == "-tau*q2/2 - r*q3/2"
    assert functions["f_E"].derivative is None
    assert [to_text(one.expression) for one in one.invariants] == ["q1**2 + q2**2 + q3**2 + q4**2 - 1"]
    assert entries(one.A) == {(0, 0): "h + tau*q1/2 - r*q4/2 + deriv(f_E)*tau + f_E"}
    assert entries(one.H) == {(0, 0): "f_N + deriv(deriv(r))"}


def test_list_of_functions():
    assert [
        one.name for one in system("functions: [f, g]", "states: [x]", "A: [[f]]", "H: [[g]]").functions
    ] == ["f", "g"]


def test_let_in_order_and_shapes():
    one = system(
        "states: {x: 2}",
        "let: {a: t, v: [a, 1], M: [[a, 2], [3, 4]], w: M @ v}",
        "dynamics: {x: M @ x}",
        "measurements: {y: w @ x}",
    )
    assert entries(one.A) == {(0, 0): "t", (0, 1): "2", (1, 0): "3", (1, 1): "4"}
    assert entries(one.H) == {(0, 0): "2 + t**2", (0, 1): "4 + 3*t"}


def test_sparse_matrices():
    one = system(
        "states: {psi: 2, b: 1}",
        "parameters: {w: 1}",
        "A: {psi1: {psi2: 'cross([w, 0, 0], [0, 1, 0])[3]', b: 1}, b: [0, 0, w]}",
        "H: {gnss: {psi1: 1}, baro: {b: 1/w}}",
        "outputs: {gnss: {unit: m}}",
    )
    assert entries(one.A) == {(0, 1): "w", (0, 2): "1", (2, 2): "w"}
    assert entries(one.H) == {(0, 0): "1", (1, 2): "1/w"}
    assert [(output.name, output.unit) for output in one.outputs] == [("gnss", "m"), ("baro", "")]


def test_matrix_expressions():
    one = system(
        "states: [x, v]",
        "A: 'block([[zeros(1, 1), 1], [0, -2]])'",
        "H: eye(2)",
        "B: '[[0], [1]]'",
        "G: eye(2)",
    )
    assert entries(one.A) == {(0, 1): "1", (1, 1): "-2"}
    assert (one.inputs, one.disturbances) == (("u1",), ("w1", "w2"))
    assert entries(one.B) == {(1, 0): "1"}


def test_inputs_and_disturbances():
    one = system(
        "states: {b: 3}",
        "parameters: {tau: 100}",
        "inputs: [u]",
        "disturbances: {w: 3}",
        "dynamics: {b: '-b/tau + w + [u, 0, 0]'}",
        "measurements: {y: b}",
    )
    assert one.inputs == ("u",)
    assert one.disturbances == ("w1", "w2", "w3")
    assert entries(one.B) == {(0, 0): "1"}
    assert entries(one.G) == {(0, 0): "1", (1, 1): "1", (2, 2): "1"}
    assert entries(one.A) == {(k, k): "-1/tau" for k in range(3)}


def test_output_names():
    def names(*lines):
        return [
            (one.name, one.vector, one.unit)
            for one in system("states: {x: 2}", "dynamics: {}", *lines).outputs
        ]

    assert names("H: eye(2)") == [("y1", "y", ""), ("y2", "y", "")]
    assert names("H: eye(2)", "outputs: {a: {unit: m}, b: }") == [("a", "", "m"), ("b", "", "")]
    assert names("H: eye(2)", "outputs: {y: {unit: m}}") == [("y1", "y", "m"), ("y2", "y", "m")]
    assert names("measurements: {y: x, z: x1}", "outputs: {y2: {unit: m}}") == [
        ("y1", "y", ""),
        ("y2", "y", "m"),
        ("z", "", ""),
    ]


def test_a_nonlinear_word_that_cancels_nothing():
    with pytest.raises(ModelError, match="not linear in the states"):
        system("states: [x]", "dynamics: {x: x^2}", "measurements: {y: x}")


def test_yaml_anchors_are_reused():
    one = system("states: [x]", "parameters: &p {g: 1}", "A: [[&e g]]", "H: [[*e]]")
    assert entries(one.H) == {(0, 0): "g"}


def test_quantities():
    one = system(
        "states: {psi: 3, b: 1}", "parameters: {g: 9.8}", "dynamics: {}", "measurements: {y: b}",
        "quantities: {e: -psi3, v: g*psi, z: 'g*psi2 - b'}",
    )  # fmt: skip
    assert [one.name for one in one.quantities] == ["e", "v1", "v2", "v3", "z"]
    assert {name: to_text(node) for name, node in one.quantities[-1].coefficients.items()} == {
        "psi2": "g",
        "b": "-1",
    }
    assert one.quantities[-1].text == "g*psi2 - b"


def test_the_keys_of_a_whole_file():
    model = read_text(
        """
format: 1
name: demo
description: >-
  two
  lines
states: {psi: 3, b: 1, c: 1}
parameters: {tau: 100, g: 9.8}
disturbances: {w: 3}
dynamics: {psi: w, b: -b/tau}
measurements: {y: psi}
noise: {Q: {w: 1e-6}, R: [1, 1, g], P0_std: {psi: 5*pi/180, b: 0.01}, step: 0.1}
interval: {start: 0, stop: 600, samples: 200}
quantities: {e: -psi3}
require: {b: 0.01*pi/180/3600, e: 0.5*pi/180}
stages: {one: {}, two: {noise: {R: 4}, interval: {stop: 60}}}
experiment: {name: both, runs: [one, {stage: two, name: back, fix: {g: 2*g}, repeat: 2, grid: {tau: [1, 2]}}], constant: [c], fresh: [psi1]}
plan: {forbidden: [back (tau = 1)], setup_time: 10*tau}
""",
        "file.yaml",
    )
    assert (model.name, model.description) == ("demo", "two lines")
    first, second = model.systems
    assert entries(first.noise.Q) == {(k, k): "1/1000000" for k in range(3)}
    assert first.noise.driven == "disturbances"
    assert entries(first.noise.R) == {(0, 0): "1", (1, 1): "1", (2, 2): "g"}
    assert entries(first.noise.P0) == {
        **{(k, k): "(pi/36)**2" for k in range(3)}, (3, 3): "1/10000"
    }  # fmt: skip
    assert entries(second.noise.Q) == entries(first.noise.Q)
    assert entries(second.noise.R) == {(k, k): "4" for k in range(3)}
    assert to_text(second.noise.step) == "1/10"
    assert first.noise.place.line == 12
    assert (to_text(second.interval.start), to_text(second.interval.stop)) == ("0", "60")
    assert second.interval.samples == 200
    assert {name: to_text(std) for name, std in first.prior.items()} == {
        **dict.fromkeys(("psi1", "psi2", "psi3"), "pi/36"), "b": "1/100"
    }  # fmt: skip
    assert [(one.name, to_text(one.value)) for one in model.require] == [
        ("b", "pi/64800000"),
        ("e", "pi/360"),
    ]
    assert [covector_text(one.coefficients, first.state_names) for one in model.require] == ["b", "-psi3"]
    assert (model.experiment.name, model.experiment.shared) == ("both", ("c",))
    assert [run.name for run in model.experiment.runs] == [
        "one", "back (tau = 1)", "back (tau = 1) #2", "back (tau = 2)", "back (tau = 2) #2",
    ]  # fmt: skip
    assert [run.place.line for run in model.experiment.runs] == [17] * 5
    assert model.experiment.plan.forbidden == (("back (tau = 1)",),)
    assert to_text(model.experiment.plan.setup_time) == "10*tau"


NOISY = (
    "states: {psi: 2, b: 1}", "parameters: {g: 9.8, s: 1}", "dynamics: {psi1: b}", "measurements: {y: psi, z: b}",
)  # fmt: skip


@pytest.mark.parametrize(
    ("key", "text", "expected"),
    [
        ("R", "2", {(0, 0): "2", (1, 1): "2", (2, 2): "2"}),
        ("R", "0", {(0, 0): "0", (1, 1): "0", (2, 2): "0"}),
        ("R", "[1, s, 3]", {(0, 0): "1", (1, 1): "s", (2, 2): "3"}),
        ("R", "{y: s, z: 4}", {(0, 0): "s", (1, 1): "s", (2, 2): "4"}),
        ("R", "{y: [1, 2]}", {(0, 0): "1", (1, 1): "2"}),
        ("R", "{y: '[[1, s], [s, 2]]'}", {(0, 0): "1", (0, 1): "s", (1, 0): "s", (1, 1): "2"}),
        ("R", "{y: 1, y2: s}", {(0, 0): "1", (1, 1): "s"}),
        ("Q", "{b: t}", {(2, 2): "t"}),
        ("P0", "{psi: '[[4, 0], [0, 9]]'}", {(0, 0): "4", (1, 1): "9"}),
        ("P0_std", "{psi: [2, g]}", {(0, 0): "4", (1, 1): "g**2"}),
    ],
)
def test_noise_is_a_matrix(key, text, expected):
    noise = system(*NOISY, f"noise: {{{key}: {text}}}").noise

    given = {
        name: entries(matrix) for name in ("Q", "R", "P0") if (matrix := getattr(noise, name)) is not None
    }
    assert given == {key.removesuffix("_std"): expected}


def test_noise_drives_the_disturbances_where_there_are_some():
    assert system(*NOISY, "noise: {Q: 1}").noise.driven == "states"
    driven = system(
        "states: {psi: 2}", "disturbances: {n: 2, m: 1}", "dynamics: {psi: 'n + [m, 0]'}", "measurements: {y: psi}",
        "noise: {Q: {n: 2, m: 3}}",
    ).noise  # fmt: skip
    assert (driven.driven, entries(driven.Q)) == ("disturbances", {(0, 0): "2", (1, 1): "2", (2, 2): "3"})
    columns = system("states: [x, y]", "A: eye(2)", "G: eye(2)", "H: eye(2)", "noise: {Q: {w2: 5}}").noise
    assert (columns.driven, entries(columns.Q)) == ("disturbances", {(1, 1): "5"})


def test_noise_is_evaluated_in_the_names_of_the_stage():
    one, two = read_text(
        "\n".join([*NOISY, "let: {r: s}", "noise: {R: r}", "stages: {one: {}, two: {let: {r: 2*g}}}"]), "file"
    ).systems
    assert [entries(one.noise.R)[0, 0], entries(two.noise.R)[0, 0]] == ["s", "2*g"]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("{b: 0.1}", {"b": ("b", "1/10")}),
        ("{psi: s}", {"psi1": ("psi1", "s"), "psi2": ("psi2", "s")}),
        ("{psi: [1, 2]}", {"psi1": ("psi1", "1"), "psi2": ("psi2", "2")}),
        ("{psi2: 1}", {"psi2": ("psi2", "1")}),
        ("{e: 1}", {"e": ("-psi2 + b", "1")}),
        ("{e2: 1}", {"e2": ("psi1", "1")}),
        ("{v: [1, 2]}", {"v1": ("g*psi1", "1"), "v2": ("g*psi2", "2")}),
    ],
)
def test_requirements(text, expected):
    model = read_text(
        "\n".join([*NOISY, "quantities: {e: b - psi2, e2: psi1, v: g*psi}", f"require: {text}"]), "file"
    )
    assert {
        one.name: (covector_text(one.coefficients, model.systems[0].state_names), to_text(one.value))
        for one in model.require
    } == expected
    assert {one.place.line for one in model.require} == {6}


def test_carriage_returns_and_byte_order_mark():
    one = read_text("\ufeffstates: [x]\r\nA: [[0]]\r\nH: [[1]]\r\n", "dos.yaml").systems[0]
    assert one.state_names == ("x",)
    assert one.H.places[0, 0].line == 3


def test_a_number_is_exact():
    node = system("states: [x]", "A: [[0.1]]", "H: [[1e-3]]").A.entries[0, 0]
    assert isinstance(node, Number)
    assert node.value == Fraction(1, 10)
