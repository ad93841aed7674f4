"""Windows that slide along INS calibration stage 1, side by side with pybounds.

    python benchmarks/pybounds_peer.py [--runs 5]

Two jobs: one window of 600 s, and 162 windows of 120 s, 3 s apart (0 to 603 s; 41 samples each for pybounds).
The right rank is 16 of 24, certified by obscli's algebra in the same run; 12 states are determined by
themselves.

pybounds gets (5) and (6) of the paper written out by hand for each of its backends, with time as a 25th state
(its f and h know only x and u), which is then selected out as known. Every method is a process of its own;
imports, the model file and the construction of the simulator do not count. A call is what a user writes: for
pybounds ObservabilityAnalysis(…).run().min_error_variance(…), for obscli ranks, gaps, singular values and
kernels of all windows from a System. CPU seconds of the first call, then median and range of further ones.

pybounds does not state ranks. *ceiling*: how many states it tells from unobservable ones, those whose error
variance "sits near 1/λ": within a factor of 10 of it, λ being its default. *rank O; F*: numpy's matrix_rank,
as it is, of its observability matrix and of its Fisher information. Its stochastic methods need process
noise: 1e-12 is taken, and their noise-free matrices for the ranks. *by hand* is its shortest way to F without
noise: its linearisation, then its function deterministic_observability_gramian.
"""

from __future__ import annotations

import os


os.environ |= dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1")

import argparse
import json
import math
import statistics
import sys
import time
import warnings
from pathlib import Path

from measure import ROOT, fresh, table


MODEL, STAGE = "models/ins_calibration/horizontal.yaml", "stage_1"
STEP, STATES = 3.0, 24
OMEGA, OMEGA_IE, PHI, G = 0.1, 2 * math.pi / 86400, 0.47, 9.81

#: Samples in all and in a window.
JOBS = {"one": (201, 201), "sliding": (202, 41)}
NAMES = [f"x{i}" for i in range(STATES)]
NOISE = 1e-12

#: Windows that the slowest method is given; its time for all of them is in proportion.
FEW = 3


# ---------------------------------------------------------------- pybounds


def stage_1(cos, sin, x):
    """Derivatives of psi, and y; states psi, b_g, b_a, M_g by rows, M_a by rows of its triangle, t."""
    c, s = cos(OMEGA * x[STATES]), sin(OMEGA * x[STATES])
    north, up = OMEGA_IE * math.cos(PHI), OMEGA_IE * math.sin(PHI)
    w = [OMEGA, c * north + s * up, c * up - s * north]
    e = [x[3 + i] + sum(x[9 + 3 * i + j] * w[j] for j in range(3)) for i in range(3)]
    a = [x[6] / G, x[7] / G + x[20] * s, x[8] / G + x[22] * s + x[23] * c]
    psi = [
        up * x[1] - north * x[2] + e[0],
        -up * x[0] + c * e[1] - s * e[2],
        north * x[0] + s * e[1] + c * e[2],
    ]
    return psi, [-x[1] + a[0], x[0] + c * a[1] - s * a[2], s * a[1] + c * a[2]]


def jax_simulator():
    """For *-jax: pure JAX, fourth-order Runge-Kutta, one step a sample (its default)."""
    import jax.numpy as jnp
    import pybounds

    def f(x, _u):
        return jnp.concatenate([jnp.stack(stage_1(jnp.cos, jnp.sin, x)[0]), jnp.zeros(21), jnp.ones(1)])

    def h(x, _u):
        return jnp.stack(stage_1(jnp.cos, jnp.sin, x)[1])

    return pybounds.JaxSimulator(f, h, STEP, [*NAMES, "t"], ["u"], ["y1", "y2", "y3"])


def casadi_simulator():
    """For *-empirical and *-classic: CasADi and IDAS (its default)."""
    import casadi
    import pybounds

    def f(x, _u):
        return [*stage_1(casadi.cos, casadi.sin, x)[0], *[0 * x[3]] * 21, 1 + 0 * x[3]]

    def h(x, _u):
        return stage_1(casadi.cos, casadi.sin, x)[1]

    return pybounds.Simulator(
        f, h, STEP, state_names=[*NAMES, "t"], input_names=["u"], measurement_names=["y1", "y2", "y3"]
    )


PYBOUNDS = {
    "bounds-jax": (jax_simulator, {}),
    "stochastic-observability-jax": (jax_simulator, {"Q": NOISE}),
    "stochastic-observability-classic": (casadi_simulator, {"Q": NOISE}),
    "bounds-empirical": (casadi_simulator, {}),
}
BY_HAND = "by hand"


def pybounds_call(method: str, job: str):
    """A call of pybounds on a job, what it says, and how many windows of the job it is given."""
    import numpy as np
    import pybounds

    samples, w = JOBS[job]
    windows = samples - w + 1
    if method == "bounds-empirical" and windows > FEW:
        samples = w + FEW - 1
    make, options = PYBOUNDS["stochastic-observability-classic" if method == BY_HAND else method]
    simulator, t = make(), STEP * np.arange(samples)
    x = np.zeros((samples, STATES + 1))
    x[:, STATES] = t
    noise = {"y1": 1.0, "y2": 1.0, "y3": 1.0}

    def analysis():
        named = "stochastic-observability-classic" if method == BY_HAND else method
        found = pybounds.ObservabilityAnalysis(
            simulator, t, x, np.zeros((samples, 1)), method=named, w=w, R=noise, **options
        )
        return found.run()

    def answer():
        found = analysis()
        return found, found.min_error_variance(states=NAMES)

    def information():
        found = analysis().linearization
        k = np.arange(w)[:, None] + np.arange(samples - w + 1)
        Phi, C = found.Phi[k[:-1], :STATES, :STATES], found.C[k, :, :STATES]
        return pybounds.stochastic.deterministic_observability_gramian(list(Phi), list(C), [np.eye(3)] * w)

    def told(result) -> dict:
        if method == BY_HAND:
            return {"F": _ranks(result)}
        found, variance = result
        O = np.stack([frame.to_numpy()[:, :STATES] for frame in found.O_df_sliding])
        seen = (variance[NAMES].dropna().to_numpy() < 0.1 / pybounds.observability.DEFAULT_LAM).sum(axis=1)
        return {"ceiling": _span(seen), "O": _ranks(O), "F": _ranks(O.swapaxes(1, 2) @ O)}

    return (information if method == BY_HAND else answer), told, samples - w + 1


def _ranks(matrices) -> str:
    import numpy as np

    return _span(np.linalg.matrix_rank(matrices))


def _span(counts) -> str:
    return f"{min(counts)}" if min(counts) == max(counts) else f"{min(counts)}–{max(counts)}"


# ---------------------------------------------------------------- obscli


def obscli_call(job: str):
    """The same for obscli: its shared panels and square roots, at its defaults."""
    import numpy as np

    from obscli.model.reader import load
    from obscli.numeric.sliding_windows import even_windows, slide

    system = next(one for one in load(ROOT / MODEL).systems if one.stage == STAGE)
    samples, w = JOBS[job]
    windows = even_windows(0.0, STEP * (samples - 1), STEP * (w - 1), STEP)

    def told(result) -> dict:
        return {
            "rank": _span(np.concatenate([one.rank for one in result])),
            "gap": float(min(one.gap.min() for one in result)),
            "decided": bool(all(one.decided.all() for one in result)),
        }

    return lambda: list(slide(system, windows)), told, len(windows.starts)


def certified() -> str:
    """The rank by algebra, with its proof."""
    from obscli.exact.analysis import Options, analyze
    from obscli.model.reader import load

    system = next(one for one in load(ROOT / MODEL).systems if one.stage == STAGE)
    found = analyze(system, Options(critical=False))
    return f"rank {found.rank} of {system.n}"


# ---------------------------------------------------------------- measuring


def measured(method: str, job: str, runs: int) -> dict:
    """CPU seconds of the calls, and what was found, in this process."""
    warnings.simplefilter("ignore")
    call, told, windows = obscli_call(job) if method == "obscli" else pybounds_call(method, job)
    spent, result = [], None
    for _ in range(1 if method == "bounds-empirical" else runs + 1):
        start = time.process_time()
        result = call()
        spent.append(time.process_time() - start)
    return {"cpu": spent, "windows": windows, **told(result)}


def main() -> None:
    parser = argparse.ArgumentParser(description="Sliding windows beside pybounds.")
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--one", nargs=2, metavar=("METHOD", "JOB"), help="a child's work")
    given = parser.parse_args()
    if given.one:
        print(json.dumps(measured(*given.one, given.runs)))
        return
    print(f"By algebra, with proof: {certified()}.\n")
    for job, (samples, w) in JOBS.items():
        count = samples - w + 1
        print(f"{count} window{'s' * (count > 1)} of {STEP * (w - 1):.0f} s:\n")
        print(_table(job, count, given.runs), end="\n\n")


def _table(job: str, count: int, runs: int) -> str:
    rows, fastest = [], None
    for method in ("obscli", *PYBOUNDS, BY_HAND):
        child = fresh(
            [sys.executable, str(Path(__file__).resolve()), "--one", method, job, "--runs", str(runs)], 900
        )
        if child.trouble:
            rows.append([_name(method), *["–"] * 6, child.trouble])
            continue
        found = json.loads(child.out.splitlines()[-1])
        scale = count / found["windows"]
        first, *warm = [scale * one for one in found["cpu"]]
        typical = statistics.median(warm or [first])
        fastest = fastest or typical
        remark = f"{found['windows']} windows timed, in proportion" if scale > 1 else ""
        if method == "obscli":
            remark = f"gap {found['gap']:.0e}, {'all' if found['decided'] else 'not all'} decided"
        rows.append(
            [
                _name(method),
                f"{first:.3f}",
                f"{typical:.4f}" + (f" ({min(warm):.4f}–{max(warm):.4f})" if warm else ""),
                f"{typical / fastest:.1f}",
                found.get("rank", "–"),
                found.get("ceiling", "–"),
                f"{found.get('O', '–')}; {found.get('F', '–')}",
                remark,
            ]
        )
    return table(["method", "first", "CPU s", "ratio", "rank", "ceiling", "rank O; F", "remark"], rows)


def _name(method: str) -> str:
    return method if method == "obscli" else f"pybounds {method}"


if __name__ == "__main__":
    main()
