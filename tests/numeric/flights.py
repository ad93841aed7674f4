"""The 15 errors of a guided rocket's INS/GNSS written out in numpy, along three flights (CSV in ``data``).

Apart from the models of the project: A(t) and H are those of the theory, entry by entry, in metres, East-North-Up.
"""

import csv
from pathlib import Path

import numpy as np

from obscli.numeric.numeric_system import Coefficients


WE, E2, RE = 7.292115e-5, 6.69437999014e-3, 6378137.0
DEG = np.pi / 180

#: One standard deviation of the prior, and of one sample.
PRIOR = np.repeat([5 * DEG, 0.5, 10.0, 100 * DEG / 3600, 10e-3 * 9.80665], 3)
NOISE = np.repeat([0.1, 3.0], 3)

CASES = ("uncontrolled", "pitch", "yaw")
MOVING = np.arange(9)


def skew(v):
    found = np.zeros((len(v), 3, 3))
    found[:, 0, 1], found[:, 0, 2], found[:, 1, 2] = -v[:, 2], v[:, 1], -v[:, 0]
    return found - found.transpose(0, 2, 1)


def matrices(rows):
    return np.array(rows).transpose(2, 0, 1)


class Flight:
    """One flight at its instants; ``at`` picks some."""

    def __init__(self, case):
        with (Path(__file__).parent / f"data/flight_{case}.csv").open() as file:
            rows = list(csv.DictReader(file))
        self.case = case
        self.data = {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}
        self.t = self.data["t_s"]

    def at(self, instants):
        place = [int(np.abs(self.t - t).argmin()) for t in instants]
        assert np.abs(self.t[place] - instants).max() < 1e-9
        found = object.__new__(Flight)
        found.case, found.data, found.t = (
            self.case,
            {k: v[place] for k, v in self.data.items()},
            self.t[place],
        )
        return found

    @property
    def f(self):
        """Specific force in quasi-body axes, (k, 3)."""
        return np.stack([self.data[f"fq_{a}"] for a in "xyz"], axis=1)

    @property
    def C(self):
        """C_q^n, (k, 3, 3)."""
        theta, psi = self.data["pitch_deg"] * DEG, self.data["heading_deg_ccw_from_N"] * DEG
        s, c, sp, cp, o = np.sin(theta), np.cos(theta), np.sin(psi), np.cos(psi), np.zeros(len(theta))
        return np.array([[-c * sp, s * sp, cp], [c * cp, -s * cp, sp], [s, c, o]]).transpose(2, 0, 1)

    def radii(self):
        """Radii of meridian and prime vertical, height added."""
        W = np.sqrt(1 - E2 * np.sin(self.data["lat_deg"] * DEG) ** 2)
        return RE * (1 - E2) / W**3 + self.data["h_m"], RE / W + self.data["h_m"]

    def coefficients(self, earth=True, C_b=None, f_sign=1.0):
        """Return A's moving rows and H; ``earth``: whether it turns and is round; ``C_b``: body to quasi-body."""
        L, h = self.data["lat_deg"] * DEG, self.data["h_m"]
        vE, vN, vU = (self.data[name] for name in ("vE", "vN", "vU"))
        we, flat = (WE, 1.0) if earth else (0.0, 1e100)
        a, b = (flat * one for one in self.radii())
        sL, cL, tL, o = np.sin(L), np.cos(L), np.tan(L), np.zeros(len(L))
        W = np.sqrt(1 - E2 * sL**2)
        g = 9.7803253359 * (1 + 0.00193185265241 * sL**2) / W * (1 - 2 * h / RE)
        w_ie, w_en = np.stack([o, we * cL, we * sL], 1), np.stack([-vN / a, vE / b, vE * tL / b], 1)
        v, f = np.stack([vE, vN, vU], 1), f_sign * np.einsum("kij,kj->ki", self.C, self.f)
        # by metres: of dL = dp_N/a, dlam = dp_E/(b cos L), dh = dp_U
        M1 = matrices([[o, o, o], [o, -we * sL / a, o], [o, we * cL / a, o]])
        M2 = matrices([[o, o, vN / a**2], [o, o, -vE / b**2], [o, vE / (b * cL**2) / a, -vE * tL / b**2]])
        Mav = matrices([[o, -1 / a, o], [1 / b, o, o], [tL / b, o, o]])
        Mpp = matrices([[o, vE * tL / a, -vE / b], [o, o, -vN / a], [o, o, o]])
        G = matrices([[o, o, o], [o, o, o], [o, o, 2 * g / b]])
        C = self.C if C_b is None else self.C @ C_b
        A, k = np.zeros((len(L), 9, 15)), len(L)
        A[:, :3, :3], A[:, :3, 3:6], A[:, :3, 6:9], A[:, :3, 9:12] = -skew(w_ie + w_en), Mav, M1 + M2, -C
        A[:, 3:6, :3], A[:, 3:6, 12:] = skew(f), C
        A[:, 3:6, 3:6] = skew(v) @ Mav - skew(2 * w_ie + w_en)
        A[:, 3:6, 6:9] = skew(v) @ (2 * M1 + M2) + G
        A[:, 6:9, 3:6], A[:, 6:9, 6:9] = np.eye(3), Mpp
        H = np.broadcast_to(np.eye(15)[3:9], (k, 6, 15))
        return Coefficients(A, H, 1e-16 * np.abs(A), np.zeros((k, 6, 15)))

    def forms(self):
        """Return roll, pitch (about the quasi-body's x and z) and azimuth as covectors, (k, 3, 15)."""
        found = np.zeros((len(self.t), 3, 15))
        found[:, 0, :3], found[:, 1, :3], found[:, 2, 2] = self.C[:, :, 0], self.C[:, :, 2], 1
        return found
