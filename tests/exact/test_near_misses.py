"""Values that miss a critical condition by little: the rank stays exact, and the distance is told."""

from fractions import Fraction

import numpy as np
import pytest

from obscli.exact.analysis import Options, analyze
from obscli.pipelines.describe.ranks import rank_blocks


SINGLE = (
    "parameters: {{g: 9.8, a_om: {{value: {a_om}, unit: '{unit}'}}, a_w: {{value: {a_w}, unit: '{unit}'}}}}\n"
    "states: [alpha, V, R, dOm, dW]\n"
    "A: [[0,0,0,1,0],[g,0,0,0,1],[0,1,0,0,0],[0,0,0,a_om,0],[0,0,0,0,a_w]]\nH: [[0,1,0,0,0],[0,0,1,0,0]]\n"
)


def found_at(system, a_om, a_w, unit=""):
    text = SINGLE.format(a_om=a_om, a_w=a_w, unit=unit)
    return analyze(system(text), Options(certificate=False, structure=False))


def float_rank(A, H):
    blocks = [H]
    for _ in range(len(A) - 1):
        blocks.append(blocks[-1] @ A)
    return np.linalg.matrix_rank(np.vstack(blocks))


def float_rank_of_single(a_om, a_w):
    A = np.zeros((5, 5))
    A[0, 3], A[1, 0], A[1, 4], A[2, 1], A[3, 3], A[4, 4] = 1, 9.8, 1, 1, a_om, a_w
    return float_rank(A, np.eye(5)[1:3])


@pytest.mark.parametrize(
    ("a_om", "a_w", "nearly"),
    [
        ("1e-3", "1e-3*(1 + 1e-9)", [("a_w = a_om", 4, 1e-9, "value")]),
        ("1e-3", "1e-12", [("a_w = 0", 4, 1e-9, "rate")]),
        ("1e-7", "2e-7", []),
    ],
)
def test_what_floating_point_takes_for_rank_4_is_5_exactly(system, a_om, a_w, nearly):
    finding = found_at(system, a_om, a_w)
    assert finding.rank == finding.at_values.rank == 5
    found = [(one.condition, one.rank, one.distance, one.measure) for one in finding.at_values.nearly]
    assert found == [(c, r, pytest.approx(d, rel=1e-6), m) for c, r, d, m in nearly]
    values = [float(eval(text)) for text in (a_om, a_w)]
    assert float_rank_of_single(*values) == 4


def test_decimals_are_the_numbers_they_look_like(system):
    finding = found_at(system, "0.3", "0.1 + 0.2")
    assert (finding.rank, finding.at_values.rank) == (5, 4)
    assert finding.at_values.because == ("a_w = a_om",)
    assert not finding.at_values.nearly
    assert 0.1 + 0.2 != 0.3  # which is why binary fractions taken as exact give 5
    binary = found_at(system, "0.3", str(Fraction(0.1) + Fraction(0.2)))
    assert binary.at_values.rank == 5
    assert [one.condition for one in binary.at_values.nearly] == ["a_w = a_om"]


@pytest.mark.parametrize("exponent", [-7, -12, -40, -100])
def test_the_distance_is_exact_however_small(system, exponent):
    finding = found_at(system, "0.02", f"0.02*(1 - 10^{exponent})")
    assert finding.at_values.rank == 5
    (one,) = finding.at_values.nearly
    assert one.distance == pytest.approx(10.0**exponent, rel=1e-12)


@pytest.mark.parametrize("a_w", ["0.02*(1 + 1e-5)", "-0.02", "5"])
def test_what_is_not_near_is_not_mentioned(system, a_w):
    assert not found_at(system, "0.02", a_w).at_values.nearly


def test_a_condition_that_is_zero_needs_something_to_compare_with(system):
    """|p − 0|/|p| is 1 for every p: with no other rate and no other parameter of the unit nothing is said."""
    assert not found_at(system, "0", "1e-12").at_values.nearly
    (by_rate,) = found_at(system, "0.02", "1e-9").at_values.nearly
    assert (by_rate.measure, by_rate.distance) == ("rate", pytest.approx(5e-8))
    (by_unit,) = found_at(system, "0.02", "1e-9", unit="1/s").at_values.nearly
    assert (by_unit.measure, by_unit.distance) == ("unit", pytest.approx(5e-8))


def test_a_length_is_no_rate(system):
    """A small lever arm is not small because the system has a rate of 100."""
    text = (
        "parameters: {l: 1e-9, w: 100}\nstates: [x, y, b]\n"
        "A: [[0, w, 0], [-w, 0, 0], [0, 0, 0]]\nH: [[1, 0, l]]\n"
    )
    finding = analyze(system(text), Options(certificate=False, structure=False))
    assert "l = 0" in [one.condition for one in finding.critical.values]
    assert not finding.at_values.nearly


def test_an_angle_is_near_a_right_angle(system):
    text = "parameters: {phi: pi/2*(1 - 1e-8)}\nstates: [a, b]\nA: zeros(2, 2)\nH: [[cos(phi), 0], [0, 1]]\n"
    finding = analyze(system(text), Options(certificate=False, structure=False))
    (one,) = finding.at_values.nearly
    assert (one.rank, one.distance) == (1, pytest.approx(1e-8, rel=1e-6))


def test_the_frequency_of_an_angle_is_a_rate(system):
    text = (
        "parameters: {w: 1e-9, v: 3}\nstates: [a, b, c]\nA: zeros(3, 3)\n"
        "H: [[cos(w*t), sin(w*t), 0], [0, 0, cos(v*t)]]\n"
    )
    finding = analyze(system(text), Options(certificate=False, structure=False))
    assert finding.at_values.rank == 3
    (one,) = finding.at_values.nearly
    assert (one.condition, one.rank, one.measure) == ("w = 0", 2, "rate")
    assert one.distance == pytest.approx(1e-9 / 3)


def test_the_report_says_what_is_nearly_met(system):
    finding = found_at(system, "1e-3", "1e-3*(1 + 1e-9)")
    table = next(iter(rank_blocks(finding)))
    text = "".join(part.text for row in table.rows for cell in row for inline in cell for part in inline)
    assert "the same; nearly 4: a_w = a_om is missed by 1e-9 of its value" in text


#: Kortunov & Proskura (2006), case 1, linearised, six decimals; s scales both kinds of Gauss-Markov rates.
SIXTEEN = """
parameters: {{s: {s}}}
states: [dL1, dL2, dL3, dL4, dVx, dVy, dVz, dRx, dRy, dRz, dOx, dOy, dOz, dWx, dWy, dWz]
A:
  dL1: {{dL2: -0.054619, dL3: -0.005529, dL4: -0.044570, dOx: -0.033933, dOy: 0.052141, dOz: -0.060249}}
  dL2: {{dL1: 0.054619, dL3: 0.044570, dL4: -0.005529, dOx: 0.475174, dOy: -0.146663, dOz: 0.014125}}
  dL3: {{dL1: 0.005529, dL2: -0.044570, dL4: 0.054619, dOx: 0.151485, dOy: 0.464926, dOz: -0.091632}}
  dL4: {{dL1: 0.044570, dL2: 0.005529, dL3: -0.054619, dOx: 0.010510, dOy: 0.098058, dOz: 0.487621}}
  dVx: {{dL1: -1.773033, dL2: -1.930010, dL3: 2.078499, dL4: -19.313758, dWx: 0.975170, dWy: -0.186723, dWz: 0.119070}}
  dVy: {{dL1: 19.313758, dL2: -2.078499, dL3: -1.930010, dL4: -1.773033, dWx: 0.198670, dWy: 0.975170, dWz: -0.097844}}
  dVz: {{dL1: 2.078499, dL2: 19.313758, dL3: 1.773033, dL4: -1.930010, dWx: -0.097844, dWy: 0.119070, dWz: 0.988053}}
  dRx: {{dVx: 1}}
  dRy: {{dVy: 1}}
  dRz: {{dVz: 1}}
  dOx: {{dOx: s*0.001}}
  dOy: {{dOy: s*0.04}}
  dOz: {{dOz: s*0.025}}
  dWx: {{dWx: s*0.001}}
  dWy: {{dWy: s*0.04}}
  dWz: {{dWz: s*0.025}}
H:
  V: {{dVx: 1}}
  V2: {{dVy: 1}}
  V3: {{dVz: 1}}
  R: {{dRx: 1}}
  R2: {{dRy: 1}}
  R3: {{dRz: 1}}
"""


@pytest.mark.parametrize(("scale", "by_floats"), [("1", 16), ("1e-7", 16), ("1e-10", 14), ("1e-12", 13)])
def test_slow_rates_do_not_lower_the_rank(system, scale, by_floats):
    """Sixteen states at every scale of the rates; floating point loses one after the other."""
    read = system(SIXTEEN.format(s=scale))
    finding = analyze(read, Options(certificate=False, structure=False))
    assert finding.rank == finding.at_values.rank == 16
    A, H = np.zeros((16, 16)), np.eye(16)[4:10]
    names = {state: j for j, state in enumerate(read.state_names)}
    text = SIXTEEN.split("A:\n")[1].split("H:", maxsplit=1)[0].replace("{{", "{").replace("}}", "}")
    for row in text.strip().splitlines():
        state, entries = row.strip().split(": ", 1)
        for entry in entries.strip("{}").split(", "):
            other, value = entry.split(": ")
            A[names[state], names[other]] = eval(value, {"s": float(scale)})
    assert float_rank(A, H) == by_floats
    nearly = {(one.condition, one.rank, one.measure) for one in finding.at_values.nearly}
    assert nearly == ({("s = 0", 13, "rate")} if float(scale) < 1e-6 else set())
