"""A system written as a model file is read back as it was: over all bundled models, and over texts at random."""

import random
from fractions import Fraction

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from obscli.exact.exact_system import read_system
from obscli.model.compose import compose
from obscli.model.expression import Number, multiply, number
from obscli.model.expression import Symbol as Name
from obscli.model.library import bundled_models
from obscli.model.reader import load, read_text
from obscli.model.source import HARMFUL, checked
from obscli.model.trouble import Problems
from obscli.model.write import Heading, write_model
from obscli.model.write_text import WIDEST, block_lines, formula, prose_lines, scalar


#: What YAML, or the reader of split expressions, might take for its own.
YAML_SIGNS = "ab(){}[]-+*/.,:#'\"\\&!%@`|>?~ =0n^é"


def assert_same(left, right):
    """Two systems with the same names are the same: their matrices, by exact comparison, and everything else."""
    matrices = [(left.A, right.A), (left.H, right.H), (left.B, right.B), (left.G, right.G)]
    noises = [(a.noise, b.noise) for a, b in [(left, right)] if a.noise is not None]
    assert (left.noise is None) == (right.noise is None)
    for mine, other in noises:
        matrices += [(mine.Q, other.Q), (mine.R, other.R), (mine.P0, other.P0)]
        assert mine.driven == other.driven
    assert all((a is None) == (b is None) for a, b in matrices)
    pairs = [(a.entries, b.entries) for a, b in matrices if a is not None]
    pairs += [
        (a.coefficients, b.coefficients) for a, b in zip(left.quantities, right.quantities, strict=True)
    ]
    extra = [e for two in pairs for one in two for e in one.values()]
    exact = read_system(left, extra)
    read, zero = exact.interpreter.read, exact.field.zero
    for mine, other in pairs:
        for key in {*mine, *other}:
            assert (read(mine[key]) if key in mine else zero) == (
                read(other[key]) if key in other else zero
            ), key
    assert left.time == right.time
    assert [vars_of(one) for one in left.parameters] == [vars_of(one) for one in right.parameters]
    assert [one.name for one in left.functions] == [one.name for one in right.functions]
    assert len(left.invariants) == len(right.invariants)
    assert [vars_of(one) for one in left.states] == [vars_of(one) for one in right.states]
    assert [sampling_of(one) for one in left.outputs] == [sampling_of(one) for one in right.outputs]
    assert [one.name for one in left.quantities] == [one.name for one in right.quantities]
    if left.G is not None:
        assert left.disturbances == right.disturbances


def sampling_of(one):
    spans = [tuple(map(formula, span)) for span in one.during or ()]
    return one.name, one.unit, one.every and formula(one.every), spans


def vars_of(one):
    return one.name, one.unit, one.description, getattr(one, "assume", ""), getattr(one, "latex", "")


@pytest.mark.parametrize("name", sorted(bundled_models()))
def test_bundled_models_are_read_back_as_they_were(name):
    model = load(bundled_models()[name])
    heading = Heading(model.name, model.title, model.description, model.source, ("a comment",), rank=1)
    for system in model.systems:
        text = write_model(system, heading)
        again = read_text(text, "written.yaml")
        assert (again.name, again.title, again.description, again.source) == (
            model.name, model.title, model.description, model.source,
        )  # fmt: skip
        assert_same(system, again.systems[0])
        assert again.systems[0].claims[0].rank == 1
        assert write_model(again.systems[0], heading) == text  # deterministic


def test_noise_is_read_back():
    text = (
        "parameters: {q: 2}\nstates: {x: 2, b: 1}\nA: [[0, 1, 0], [0, 0, 1], [0, 0, 0]]\nH: [[1, 0, 0], [0, 1, 0]]\n"
        "noise: {Q: {x: [[2, q], [q, 3]]}, R: [[1, 1/2], [1/2, 1]], P0: [[2, 1, 0], [1, 2, 0], [0, 0, 0.01]], step: 0.1}\n"
        "interval: {start: 1, stop: 2*pi, samples: 7}\nquantities: {sum: x1 - 0.5*x2}\noutputs: {y1: {unit: '%'}}\n"
    )
    system = read_text(text, "noise.yaml").systems[0]
    again = read_text(write_model(system), "again.yaml").systems[0]
    assert_same(system, again)
    assert again.interval.samples == 7
    assert formula(again.interval.stop) == "2*pi"
    assert again.noise.step.value == Fraction(1, 10)


def test_sampling_of_outputs_is_read_back():
    text = (
        "parameters: {f_s: 3, T: 60}\nstates: {x: 2}\ndynamics: {x2: x1}\nmeasurements: {gnss: x, odo: x2}\n"
        "outputs: {gnss: {unit: m/s, every: 1/f_s, during: [[0, T/7], [2*pi*T, 400*T]]}, odo: {every: 1e-3}}\n"
    )
    system = read_text(text, "sampled.yaml").systems[0]
    again = read_text(write_model(system), "again.yaml").systems[0]
    assert_same(system, again)
    assert sampling_of(again.outputs[1]) == ("gnss2", "m/s", "1/f_s", [("0", "T/7"), ("2*pi*T", "400*T")])
    assert sampling_of(again.outputs[2]) == ("odo", "", "0.001", [])


def test_many_outages_are_read_back():
    spans = [[2 * k, 2 * k + 1] for k in range(200)]
    text = f"states: [x]\nA: [[0]]\nH: [[1]]\noutputs: {{y1: {{every: 0.1, during: {spans}}}}}\n"
    written = write_model(read_text(text, "many.yaml").systems[0])
    again = read_text(written, "again.yaml").systems[0]
    assert [tuple(map(formula, span)) for span in again.outputs[0].during] == [
        (str(start), str(stop)) for start, stop in spans
    ]
    assert max(map(len, written.splitlines())) <= WIDEST


def test_names_of_inputs_that_are_taken_are_not_written():
    text = "functions: [w1]\nparameters: {u2: 1}\nstates: [a]\nA: [[w1*u2]]\nH: [[1]]\nG: [[1, 2]]\nB: [[3, 0]]\n"
    system = read_text(text, "taken.yaml").systems[0]
    again = read_text(write_model(system), "again.yaml").systems[0]
    assert_same(system, again)
    assert again.inputs == system.inputs == ("u1", "u2")


def test_no_comment_breaks_out_of_its_line():
    system = read_text("states: [a]\nA: [[0]]\nH: [[1]]\n", "m.yaml").systems[0]
    written = write_model(system, Heading(comments=("one\nname: two\rtime: x",)))
    again = read_text(written, "again.yaml")
    assert (again.name, again.systems[0].time) == ("again", "t")


def test_what_a_file_cannot_say_stands_in_a_comment():
    text = "states: {x: 2, b: 1}\nA: [[0, 0, 0], [0, 0, 0], [0, 0, 0]]\nH: [[1, 0, 0]]\nnoise: {P0: {x: [[2, 1], [1, 2]]}}\n"
    system = read_text(text, "partly.yaml").systems[0]
    written = write_model(system)
    assert "# P0 is given for some only, and correlated" in written
    assert read_text(written, "again.yaml").systems[0].noise.P0 is None


@settings(max_examples=300, deadline=None)
@given(st.text(min_size=1, max_size=30) | st.text(alphabet=YAML_SIGNS, min_size=1, max_size=9))
@example("(")
def test_every_text_survives_quotes(text):
    if HARMFUL.search(text) or "\t" in text or "\n" in text or "\r" in text or not text.isprintable():
        return
    lines = [*block_lines([("k", [("a", scalar(text)), ("b", "1")])], ""), *prose_lines("p", text)]
    root = compose(checked("\n".join(lines) + "\n", "m.yaml"), Problems())
    assert root.get("k").get("a").text == text
    assert " ".join(root.get("p").text.split()) == " ".join(text.split())
    assert not root.get("k").get("a").is_null


@settings(max_examples=300, deadline=None)
@given(st.integers(-(10**25), 10**25), st.integers(0, 25), st.integers(0, 25), st.sampled_from([1, 3, 7]))
def test_numbers_are_exact(above, twos, fives, other):
    value = Fraction(above, 2**twos * 5**fives * other)
    system = read_text(f"states: [a]\nA: [['{formula(Number(value))}']]\nH: [[1]]\n", "m.yaml").systems[0]
    entry = system.A.entries.get((0, 0), number(0))
    assert read_system(system, [entry]).interpreter.read(entry) == read_system(system).field.rational(value)


def test_numbers_are_as_people_write_them():
    values = {
        "9.81": "981/100",
        "0.1": "1/10",
        "1/2": "1/2",
        "1/3": "1/3",
        "1e-9": "1/1000000000",
        "-2.5e-7": "-1/4000000",
    }
    for text, value in values.items():
        assert formula(Number(Fraction(value))) == text
    assert formula(multiply(Number(Fraction(-981, 100)), Name("x"))) == "-9.81*x"
    assert formula(Number(Fraction(6378137))) == "6378137"


def test_random_systems_are_read_back():
    source = random.Random(3)
    entries = [
        "0",
        "0",
        "0",
        "w*t",
        "-sin(w*t)/g",
        "exp(-2*t)",
        "f - 1/3",
        "sqrt(g)*deriv(f)",
        "(t + 1)**3/7",
        "0.125*g",
        "log(g)^2",
    ]
    for _ in range(40):
        n, m = source.randint(1, 5), source.randint(1, 2)
        A, H = ([[source.choice(entries) for _ in range(n)] for _ in range(rows)] for rows in (n, m))
        text = (
            "parameters: {w: 0.1, g: {assume: positive}}\nfunctions: [f]\n"
            f"states: [{', '.join(f'x{k}' for k in range(n))}]\nA: {A}\nH: {H}\n"
        )
        system = read_text(text, "random.yaml").systems[0]
        assert_same(system, read_text(write_model(system), "again.yaml").systems[0])
