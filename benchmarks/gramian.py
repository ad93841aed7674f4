"""The Gramian of INS calibration stage 2, 0 to 1500 s, at 150 instants: square root against equation (3).

    python benchmarks/gramian.py [--runs 5]

obscli reads the model; the peer, ``scipy.integrate.solve_ivp`` (DOP853, rtol = 1e-10) on
dW/dt = −Aᵀ W − W A + Hᵀ H, gets (5) and (6) of the paper written out by hand in numpy, in units in which W
has a unit diagonal, as obscli decides the rank in. Its right-hand side comes in two kinds: *dense*, two
products of 24 × 24 matrices as equation (3) stands there, and *by rows*, which uses that only the three rows
of psi are not zero. All in this process, in turn, one BLAS thread, CPU time.

The error of W is the largest over the instants, in units of unit diagonal, against the peer's own method at
rtol 1e-13. Separation: σ16/σ17 on the scale of W (squared for the square root); χ: the largest leak of the
paper's right basis into the kernel of dimension 8.
"""

from __future__ import annotations

import os


os.environ |= dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1")

import argparse
import statistics
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from measure import OBSCLI, ROOT, fresh, median, spread, table
from scipy.integrate import solve_ivp

from obscli.model.reader import load
from obscli.numeric.gramian import Gramian
from obscli.numeric.horizon import horizon_of
from obscli.numeric.leak import leak_of
from obscli.numeric.lyapunov import lyapunov_gramian
from obscli.numeric.numeric_system import NumericSystem
from obscli.numeric.quadrature import quadrature_gramian
from obscli.numeric.rates import rates_of
from obscli.numeric.scaling import scaled
from obscli.numeric.settings import Effort, Settings
from obscli.numeric.square_root import square_root_gramian
from obscli.numeric.subspace import Subspaces, subspaces


if TYPE_CHECKING:
    from collections.abc import Callable


MODEL = ROOT / "models/ins_calibration/horizontal.yaml"
STAGE = "stage_2"
INSTANTS = 10.0 * np.arange(1, 151)
SETTLED = 100.0  # χ is a fair measure from here on: before, double precision sees σ16/σ1 = 1e-11
RANK = 16
PEER_RTOL, REFERENCE_RTOL = 1e-10, 1e-13
PEER, KINDS = "scipy DOP853, rtol 1e-10", ("dense", "by rows")
METHODS = {
    "obscli square-root": (square_root_gramian, 1e-14),
    "obscli quadrature": (quadrature_gramian, 1e-14),
    "obscli lyapunov (twice)": (lyapunov_gramian, 1e-10),
}


# ---------------------------------------------------------------- the peer: (5) and (6) of stage 2 by hand


OMEGA, OMEGA_IE, PHI, G = 0.1, 2 * np.pi / 86400, 0.47, 9.81


def stage_2(t: float) -> tuple[np.ndarray, np.ndarray]:
    """The three rows of A that are not zero, (3, 24), and H, (3, 24).

    States: psi, b_g, b_a, M_g by rows, M_a by rows of its lower triangle. The unit turns about its second
    axis: R_nb = [[0, 1, 0], [c, 0, s], [s, 0, −c]].
    """
    c, s = np.cos(OMEGA * t), np.sin(OMEGA * t)
    north, up = OMEGA_IE * np.cos(PHI), OMEGA_IE * np.sin(PHI)
    w1, w2, w3 = c * north + s * up, OMEGA, s * north - c * up
    f1, f3 = s * G, -c * G
    A = np.zeros((3, 24))
    A[:, :3] = [[0, up, -north], [-up, 0, 0], [north, 0, 0]]
    A[0, [4, 12, 13, 14]] = 1, w1, w2, w3
    A[1, [3, 9, 10, 11, 5, 15, 16, 17]] = c, c * w1, c * w2, c * w3, s, s * w1, s * w2, s * w3
    A[2, [3, 9, 10, 11, 5, 15, 16, 17]] = s, s * w1, s * w2, s * w3, -c, -c * w1, -c * w2, -c * w3
    H = np.zeros((3, 24))
    H[0, [1, 7, 19]] = -1, 1 / G, f1 / G
    H[1, [0, 6, 18, 8, 21, 23]] = 1, c / G, c * f1 / G, s / G, s * f1 / G, s * f3 / G
    H[2, [6, 18, 8, 21, 23]] = s / G, s * f1 / G, -c / G, -c * f1 / G, -c * f3 / G
    return A, H


def peer(rtol: float, units: np.ndarray, kind: str = "by rows") -> np.ndarray:
    """W at the instants in units of the states, (150, 24, 24)."""
    ratio = units / units[:3, None]
    square = np.zeros((24, 24))

    def by_rows(t: float, w: np.ndarray) -> np.ndarray:
        A, H = stage_2(t)
        H *= units
        product = w.reshape(24, 24)[:, :3] @ (A * ratio)
        return (H.T @ H - product - product.T).ravel()

    def dense(t: float, w: np.ndarray) -> np.ndarray:
        A, H = stage_2(t)
        H *= units
        square[:3] = A * ratio
        W = w.reshape(24, 24)
        return (H.T @ H - square.T @ W - W @ square).ravel()

    found = solve_ivp(
        by_rows if kind == "by rows" else dense,
        (0.0, INSTANTS[-1]),
        np.zeros(576),
        "DOP853",
        INSTANTS,
        rtol=rtol,
        atol=1e-3 * rtol,
    )
    return found.y.T.reshape(-1, 24, 24)


# ---------------------------------------------------------------- what is measured


@dataclass(frozen=True, slots=True)
class Found:
    """W by one method: CPU seconds of the Gramian and of what follows, and how good it is."""

    gramian: list[float]
    rest: list[float]
    kernel: np.ndarray
    separation: np.ndarray
    chi: np.ndarray
    error: float


def decomposed(gramian: Gramian, system: object, rows: np.ndarray, errors: np.ndarray) -> tuple:
    """The subspaces at every instant, and χ of the rows."""
    spaces = subspaces(scaled(gramian, system, "automatic"))
    return spaces, leak_of(spaces, rows, errors).chi.max(axis=1)


def separation(spaces: Subspaces) -> np.ndarray:
    """σ16/σ17 on the scale of W."""
    ratio = spaces.values[:, RANK - 1] / np.maximum(spaces.values[:, RANK], np.finfo(float).tiny)
    return ratio**2 if spaces.gramian.is_root else ratio


def difference(gramian: Gramian, reference: np.ndarray, units: np.ndarray) -> float:
    """The largest error of W over the instants, in units in which its diagonal is 1."""
    W = gramian.matrices
    if gramian.is_root:
        W = W.transpose(0, 2, 1) @ W
    own = units / gramian.units
    W = W * own[:, :, None] * own[:, None, :]
    size = np.sqrt(np.einsum("ijj->ij", reference))
    size[size == 0] = 1
    return float(np.linalg.norm((W - reference) / size[:, :, None] / size[:, None, :], axis=(1, 2)).max())


def timed(runs: int, work: Callable[[], object]) -> tuple[list[float], object]:
    """CPU seconds of some runs after one that is not measured, and the last result."""
    seconds, result = [], work()
    for _ in range(runs):
        start = time.process_time()
        result = work()
        seconds.append(time.process_time() - start)
    return seconds, result


def gramian_rows(runs: int) -> list[list[str]]:
    """One row for each method and the peer."""
    system = next(one for one in load(MODEL).systems if one.stage == STAGE)
    claim = next(one for one in system.claims if one.basis and one.stage == STAGE)
    settings = Settings()
    horizon = horizon_of(system, settings.wanted)
    assert np.allclose(horizon.instants, INSTANTS)
    numeric = NumericSystem(system, horizon.start, horizon.stop)
    rates = rates_of(numeric, np.linspace(horizon.start, horizon.stop, 18)[1:-1])
    rows, errors = numeric.covectors([q.coefficients for q in claim.basis], INSTANTS)
    for t in (0.0, 12.3, 1499.0):
        A, H = numeric.matrices(np.array([t]))
        by_hand = stage_2(t)
        assert np.allclose(A[0], by_hand[0], atol=1e-15)
        assert np.allclose(H[0], by_hand[1], atol=1e-15)

    root = square_root_gramian(numeric, 0.0, INSTANTS, rates, Effort(1e-14, 20_000))
    sizes = np.linalg.norm((root.matrices / root.units[:, None, :])[-1], axis=0)
    units = 1 / np.where(sizes > 0, sizes, 1.0)
    reference = peer(REFERENCE_RTOL, units)

    def measured(work: Callable[[], Gramian]) -> Found:
        seconds, gramian = timed(runs, work)
        rest, (spaces, chi) = timed(runs, lambda: decomposed(gramian, system, rows, errors))
        kernel = 24 - spaces.rank
        return Found(seconds, rest, kernel, separation(spaces), chi, difference(gramian, reference, units))

    def by_peer(kind: str) -> Gramian:
        W = peer(PEER_RTOL, units, kind)
        error = np.broadcast_to((100 * PEER_RTOL) ** 2 * np.eye(24), W.shape)
        alike, zero = np.broadcast_to(units, W.shape[:2]), np.zeros(len(W))
        return Gramian("lyapunov", INSTANTS, zero, W, alike, error, zero)

    found = {f"{PEER}, {kind}": measured(lambda k=kind: by_peer(k)) for kind in KINDS}
    for name, (method, rtol) in METHODS.items():
        effort = Effort(rtol, 20_000)
        found[name] = measured(lambda m=method, e=effort: m(numeric, 0.0, INSTANTS, rates, e))
    peers = [statistics.median(found[f"{PEER}, {kind}"].gramian) for kind in KINDS]
    return [_row(name, one, peers) for name, one in found.items()]


def _row(name: str, one: Found, peers: list[float]) -> list[str]:
    alone = statistics.median(one.gramian)
    whole = statistics.median(a + b for a, b in zip(one.gramian, one.rest, strict=True))
    late = INSTANTS >= SETTLED
    right = int((one.kernel == 24 - RANK).sum())
    chi = f"{one.chi[0]:.1e}; {one.chi[late].max():.1e}" if right else "–"
    return [
        name,
        f"{alone:.4f} ({min(one.gramian):.4f}–{max(one.gramian):.4f})",
        f"{whole:.4f}",
        "; ".join(f"{time / alone:.1f}" for time in peers),
        f"{one.error:.0e}",
        f"{right} of {len(INSTANTS)}",
        f"{one.separation.min():.0e}; {np.median(one.separation):.0e}; {one.separation[-1]:.0e}",
        chi,
    ]


COMMANDS = {
    "obscli verify, every bundled model": (["verify"], "20"),
    "obscli analyze, stage 1, with everything": (
        ["analyze", "models/ins_calibration/horizontal.yaml", "--stage", "stage_1"],
        "3",
    ),
    "obscli analyze, stage 1, --only numeric": (
        ["analyze", "models/ins_calibration/horizontal.yaml", "--stage", "stage_1", "--only", "numeric"],
        "",
    ),
}


def command_rows(runs: int) -> list[list[str]]:
    """Rows of the commands in fresh processes."""
    rows = []
    for name, (arguments, target) in COMMANDS.items():
        found = [fresh([OBSCLI, *arguments]) for _ in range(runs)]
        trouble = next((run.trouble for run in found if run.trouble), "")
        seconds = [run.cpu for run in found]
        rows.append([name, f"{median(found):.2f}", spread(seconds), target, trouble])
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(description="The Gramian by its square root and by equation (3).")
    parser.add_argument("--runs", type=int, default=5, help="measured runs of each")
    given = parser.parse_args()
    header = [
        "method",
        "CPU s of the Gramian",
        "with ranks and χ",
        "times faster than scipy: dense; by rows",
        "error of W",
        "q = 8 at",
        "σ16/σ17 of W: least; median; last",
        "χ at 10 s; from 100 s",
    ]
    print(table(header, gramian_rows(given.runs)))
    print()
    print(table(["command", "CPU s, median", "min–max", "target s", "remark"], command_rows(given.runs)))


if __name__ == "__main__":
    main()
