"""The example of the contract against matrices written out by hand in numpy."""

import numpy as np
import pytest

from obscli.model.reader import read_text


EXAMPLE = """
title: INS calibration on a one-axis table, axis horizontal
source: Morozov & Baklanov 2018, (5)-(7)
parameters: {omega: 0.1, omega_ie: 2*pi/86400, phi: 0.47, g: 9.81}
states: {psi: 3, b_g: 3, b_a: 3, M_g: [3, 3], M_a: {shape: [3, 3], structure: lower}}
let:
  c: cos(omega*t)
  s: sin(omega*t)
  R_nb: [[1, 0, 0], [0, c, -s], [0, s, c]]
  w_ie: [0, omega_ie*cos(phi), omega_ie*sin(phi)]
  w_ib: R_nb.T @ (w_ie + [omega, 0, 0])
  f_b: R_nb.T @ [0, 0, g]
dynamics:
  psi: -cross(w_ie, psi) + R_nb @ (b_g + M_g @ w_ib)
measurements:
  y: cross([0, 0, 1], psi) + R_nb @ (b_a + M_a @ f_b)/g
stages:
  stage_1: {}
  stage_2: {let: {R_nb: [[0, 1, 0], [c, 0, s], [s, 0, -c]]}}
"""
VALUES = {"t": 3.3, "omega": 0.7, "omega_ie": 0.2, "phi": 0.47, "g": 9.81}


def skew(v):
    return np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


def by_hand(stage):
    c, s = np.cos(0.7 * 3.3), np.sin(0.7 * 3.3)
    first = np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
    R = first if stage == "stage_1" else np.array([[0, 1, 0], [c, 0, s], [s, 0, -c]])
    w_ie = 0.2 * np.array([0, np.cos(0.47), np.sin(0.47)])
    w_ib = R.T @ (w_ie + np.array([0.7, 0, 0]))
    f_b = R.T @ [0, 0, 9.81]
    lower = [(i, j) for i in range(3) for j in range(i + 1)]
    A, H = np.zeros((24, 24)), np.zeros((3, 24))
    A[:3, :3], A[:3, 3:6] = -skew(w_ie), R
    H[:, :3], H[:, 6:9] = skew([0, 0, 1]), R / 9.81
    for i in range(3):
        for j in range(3):
            A[:3, 9 + 3 * i + j] = R[:, i] * w_ib[j]
    for k, (i, j) in enumerate(lower):
        H[:, 18 + k] = R[:, i] * f_b[j] / 9.81
    return A, H


@pytest.mark.parametrize("position", [0, 1])
def test_matrices(dense, position):
    system = read_text(EXAMPLE, "ins.yaml").systems[position]
    A, H = by_hand(system.stage)
    np.testing.assert_allclose(dense(system.A, VALUES), A, rtol=0, atol=1e-14)
    np.testing.assert_allclose(dense(system.H, VALUES), H, rtol=0, atol=1e-14)


def test_shape_and_names():
    model = read_text(EXAMPLE, "ins.yaml")
    assert [system.stage for system in model.systems] == ["stage_1", "stage_2"]
    system = model.systems[0]
    assert (system.n, system.m) == (24, 3)
    assert system.state_names[:3] == ("psi1", "psi2", "psi3")
    assert system.state_names[-6:] == ("M_a11", "M_a21", "M_a22", "M_a31", "M_a32", "M_a33")
    assert [output.name for output in system.outputs] == ["y1", "y2", "y3"]
    assert [parameter.name for parameter in system.parameters] == ["omega", "omega_ie", "phi", "g"]
    assert model.title == "INS calibration on a one-axis table, axis horizontal"
    assert model.name == "ins"


def test_places_of_entries():
    system = read_text(EXAMPLE, "ins.yaml").systems[0]
    place = system.A.places[0, 2]
    assert (place.file, place.line, place.column) == ("ins.yaml", 14, 8)
