"""INS calibration, horizontal axis, stage 1, by hand: A(t), H(t) as plain numpy arrays.

Written from (5), (6) of Morozov & Baklanov 2018 without looking at the model files, and not from the
paper's scalar form (18)-(19), which has misprints. State order as in the paper:
psi1-3, b_g1-3, b_a1-3, M_g11 ... M_g33 by rows, M_a11, M_a21, M_a22, M_a31, M_a32, M_a33.
"""

import math

import numpy as np


NOMINAL = {"omega": 0.1, "omega_ie": 2 * math.pi / 86400, "phi": 0.47, "g": 9.81}


def _rotation(t, params):
    c, s = math.cos(params["omega"] * t), math.sin(params["omega"] * t)
    return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])


def A(t, params=NOMINAL):
    """(24, 24): psi' = -w_ie x psi + R (b_g + M_g w_ib); all other states are constant."""
    R = _rotation(t, params)
    east, north, up = (
        0.0,
        params["omega_ie"] * math.cos(params["phi"]),
        params["omega_ie"] * math.sin(params["phi"]),
    )
    w_ib = R.T @ np.array([params["omega"] + east, north, up])
    out = np.zeros((24, 24))
    out[0:3, 0:3] = -np.array([[0.0, -up, north], [up, 0.0, -east], [-north, east, 0.0]])
    out[0:3, 3:6] = R
    for i in range(3):
        for j in range(3):
            for k in range(3):
                out[i, 9 + 3 * j + k] = R[i, j] * w_ib[k]
    return out


def H(t, params=NOMINAL):
    """(3, 24): y = e3 x psi + R (b_a + M_a f_b) / g."""
    R = _rotation(t, params)
    f_b = R.T @ np.array([0.0, 0.0, params["g"]])
    out = np.zeros((3, 24))
    out[0, 1], out[1, 0] = -1.0, 1.0
    out[:, 6:9] = R / params["g"]
    lower = [(0, 0), (1, 0), (1, 1), (2, 0), (2, 1), (2, 2)]
    for column, (j, k) in enumerate(lower, start=18):
        out[:, column] = R[:, j] * f_b[k] / params["g"]
    return out
