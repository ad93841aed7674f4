"""Ranks of the two-axis table in eight positions, without obscli: NumPy, SciPy, the table's equations alone.

    python tests/independent/segment_ranks.py

x = (psi, b_g, b_a, M_g by rows, M_a lower by rows), 24 states. Every output is a row vector in x at the start,
followed by DOP853 through dwells, turns or jumps. Rows are sampled and their singular values looked at, columns
in units of their own length.
"""

import numpy as np
from scipy.integrate import quad_vec, solve_ivp


OMEGA, PHI, G, DWELL, RATE = 2 * np.pi / 86400, 0.47, 9.81, 60.0, 0.1
LOWER = [(0, 0), (1, 0), (1, 1), (2, 0), (2, 1), (2, 2)]
POSITIONS = [(0, k) for k in range(4)] + [(1, k) for k in (3, 2, 1, 0)]
UP = np.array([0.0, 0.0, 1.0])


def about_y(a):
    return np.array([[np.cos(a), 0, np.sin(a)], [0, 1, 0], [-np.sin(a), 0, np.cos(a)]])


def about_z(a):
    return np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1]])


def cross(a):
    return np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])


def gyro_columns(R, rate):
    """What R (b_g + M_g rate) is of the 24 states, (3, 24)."""
    found = np.zeros((3, 24))
    found[:, 3:6] = R
    for i in range(3):
        for j in range(3):
            found[:, 9 + 3 * i + j] = R[:, i] * rate[j]
    return found


def output(R):
    """H, (3, 24)."""
    found = np.zeros((3, 24))
    found[:, :3] = cross(UP)
    found[:, 6:9] = R / G
    force = R.T @ UP * G
    for k, (i, j) in enumerate(LOWER):
        found[:, 18 + k] = R[:, i] * force[j] / G
    return found


def followed(orientation, turn, duration, earth):
    """Φ at the end and sampled H Φ, for an orientation that is a function of time since the start."""
    w = earth * np.array([0, np.cos(PHI), np.sin(PHI)])

    def motion(t, flat):
        psi = flat.reshape(3, 24)
        R = orientation(t)
        return (-cross(w) @ psi + gyro_columns(R, R.T @ (w + turn))).ravel()

    start = np.eye(24)[:3].ravel()
    times = np.linspace(0, duration, 9)
    found = solve_ivp(motion, (0, duration), start, "DOP853", times, rtol=1e-13, atol=1e-15, max_step=5)
    whole = [np.vstack([psi.reshape(3, 24), np.eye(24)[3:]]) for psi in found.y.T]
    return whole[-1], [output(orientation(t)) @ phi for t, phi in zip(times, whole, strict=True)]


def jump(before, after):
    """What a quick turn from one position to the next does to the state, (24, 24)."""
    (o, i), (p, j) = (np.array(one) * np.pi / 2 for one in (before, after))
    axis = np.array([0.0, 1.0, 0.0]) if o != p else about_y(o) @ UP

    def swept(s):
        R = about_y(o + s * (p - o)) @ about_z(i + s * (j - i))
        found = gyro_columns(R, R.T @ axis * (p - o + j - i))
        found[:, 3:6] = 0  # no time passes
        return found

    found = np.eye(24)
    found[:3] += quad_vec(swept, 0, 1, epsabs=1e-14)[0]
    return found


def rows(*, motion, earth=OMEGA):
    """Sampled outputs as rows in the state at the start; motion: "none", "jumps" or "turns"."""
    found, carried = [], np.eye(24)
    for k, (o, i) in enumerate(POSITIONS):
        R = about_y(o * np.pi / 2) @ about_z(i * np.pi / 2)
        phi, own = followed(lambda _, R=R: R, np.zeros(3), DWELL, earth)
        found += [one @ carried for one in own]
        carried = phi @ carried
        if k + 1 == len(POSITIONS) or motion == "none":
            continue
        if motion == "jumps":
            carried = jump((o, i), POSITIONS[k + 1]) @ carried
            continue
        p, j = POSITIONS[k + 1]
        way = np.array([p - o, j - i]) * RATE

        def turning(t, o=o, i=i, way=way):
            return about_y(o * np.pi / 2 + way[0] * t) @ about_z(i * np.pi / 2 + way[1] * t)

        rate = np.array([0, way[0], 0]) + about_y(o * np.pi / 2) @ UP * way[1]
        phi, own = followed(turning, rate, np.pi / 2 / RATE, earth)
        found += [one @ carried for one in own]
        carried = phi @ carried
    return np.vstack(found)


def rank(matrix, tolerance=1e-11):
    """The number of singular values above the tolerance, columns of length 1."""
    size = np.linalg.norm(matrix, axis=0)
    values = np.linalg.svd(matrix / np.where(size > 1e-12, size, 1.0), compute_uv=False)
    return int((values > tolerance * values[0]).sum()), values


if __name__ == "__main__":
    for what in ("none", "jumps", "turns"):
        for rate in (OMEGA, 0.0):
            number, values = rank(rows(motion=what, earth=rate))
            print(f"{what:6} earth {rate:.3g}: {number}", values[-8:])  # noqa: T201
