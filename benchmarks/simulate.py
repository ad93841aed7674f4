"""The Kalman filter on INS calibration stage 1: 24 states, 3 outputs at 10 Hz over 1500 s (15001 instants).

    python benchmarks/simulate.py [--runs 5] [--command]

Covariance alone, beside the textbook (Joseph's update with transition matrices given: the least that a loop
over the samples costs), a filter run on another model, 200 Monte Carlo runs; each without driving noise, with
noise of the attitude (3 sources), and of all states (24). Every row is a fresh process with imports; the
answer tells the CPU time of the computation alone, one thread. ``--command``: `obscli simulate` as well.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import tempfile
import time
from pathlib import Path


os.environ |= dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1")

from measure import OBSCLI, ROOT, Run, row, table


LIMIT = 120
MODEL = ROOT / "models/ins_calibration/horizontal.yaml"
PRIOR = "P0_std: {{psi: 0.01, b_g: 1e-5, b_a: 1e-2, M_g: 1e-3, M_a: 1e-3}}"
NOISE = "noise: {{R: {{y: 1e-6}}, step: 0.1, " + PRIOR + "{}}}\n"
DRIVEN = {
    "no driving noise": "",
    "attitude driven": ", Q: {psi: 1e-12}",
    "all states driven": ", Q: {psi: 1e-12, b_g: 1e-16, b_a: 1e-10, M_g: 1e-12, M_a: 1e-12}",
}
WORK = {"covariance": "2 s CPU", "textbook": "–", "mismatch": "–", "200 runs": "30 s on two cores"}


def text(driven: str) -> str:
    """The bundled model with noise."""
    return MODEL.read_text(encoding="utf-8") + NOISE.format(DRIVEN[driven])


def child(work: str, driven: str) -> dict:
    """One computation: its CPU seconds, and what it found."""
    from obscli.model.reader import read_text
    from obscli.numeric.linear_forms import forms_of
    from obscli.numeric.schedule import schedule_of

    system = next(one for one in read_text(text(driven), "horizontal.yaml").systems if one.stage == "stage_1")
    schedule, forms = schedule_of(system, 0, 1500), forms_of(system)
    compute = {"covariance": covariance, "textbook": textbook, "mismatch": mismatch, "200 runs": runs}[work]
    start = time.process_time()
    found = compute(system, schedule, forms)
    return {"cpu": time.process_time() - start, "found": found}


def covariance(system, schedule, forms) -> str:
    from obscli.numeric.kalman import covariance_history

    found = covariance_history(system, schedule, forms)
    return f"{found.samples} samples, σ(psi1) = {found.deviations[-1, 0]:.5e}"


def textbook(system, schedule, _forms) -> str:
    """Full matrices, sample by sample; transition matrices and noise are not counted."""
    import numpy as np

    from obscli.numeric.sampled_system import SampledSystem, timeline_of

    sampled = SampledSystem(system, schedule)
    timeline = timeline_of([sampled], schedule)
    prepared = []
    for stretch in sampled.stretches(timeline):
        noise = stretch.noise
        entered = np.zeros((len(stretch.rows), 24, 24)) if noise is None else noise @ noise.swapaxes(1, 2)
        prepared.append((stretch.rows, entered, stretch.transition[-1]))
    P, R, unit = sampled.noise.P0, schedule.R, np.eye(24)
    start = time.process_time()
    for rows, entered, onward in prepared:
        for H, Q in zip(rows, entered, strict=True):
            P = P + Q
            K = np.linalg.solve(H @ P @ H.T + R, H @ P).T
            kept = unit - K @ H
            P = kept @ P @ kept.T + K @ R @ K.T
        P = onward @ P @ onward.T
    return f"loop alone {time.process_time() - start:.2f} s, σ(psi1) = {P[0, 0] ** 0.5:.5e}"


def mismatch(system, schedule, forms) -> str:
    from obscli.numeric.mismatched import mismatch_history
    from obscli.numeric.recorded_errors import recorded_errors

    found = mismatch_history(recorded_errors(system, schedule, forms, filter_=system))
    return f"true/claimed − 1 ≤ {abs(found.true / found.claimed - 1).max():.0e}"


def runs(system, schedule, forms) -> str:
    from obscli.numeric.monte_carlo import monte_carlo
    from obscli.numeric.recorded_errors import recorded_errors

    found = monte_carlo(recorded_errors(system, schedule, forms, 200), 200, 1)
    return f"inside: NEES {found.nees.inside:.3f}, NIS {found.nis.inside:.3f}"


def main() -> None:
    parser = argparse.ArgumentParser(description="The Kalman filter on INS calibration stage 1.")
    parser.add_argument("--child", nargs=2, help=argparse.SUPPRESS)
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--command", action="store_true", help="`obscli simulate` as well")
    given = parser.parse_args()
    if given.child:
        print(json.dumps(child(*given.child)))
        return
    rows = [
        row(
            f"{work}, {driven}",
            [sys.executable, str(Path(__file__).resolve()), "--child", work, driven],
            given.runs,
            target,
            LIMIT,
            _answer,
        )
        for work, target in WORK.items()
        for driven in DRIVEN
    ]
    if given.command:
        rows += _commands(given.runs)
    print(table(["what", "CPU s", "min–max", "MB", "target", "answer"], rows))


def _commands(count: int) -> list[list[str]]:
    """`obscli simulate`, with the analysis that finds what is observable."""
    with tempfile.TemporaryDirectory() as directory:
        model = Path(directory) / "horizontal.yaml"
        model.write_text(text("attitude driven"), encoding="utf-8")
        command = [OBSCLI, "simulate", str(model), "--stage", "stage_1", "--format", "json"]
        return [
            row("obscli simulate, attitude driven", command, count, "–", LIMIT, _length),
            row("obscli simulate --runs 200", [*command, "--runs", "200"], count, "–", LIMIT, _length),
        ]


def _answer(run: Run) -> str:
    found = json.loads(run.out)
    return f"{found['cpu']:.2f} s alone: {found['found']}"


def _length(run: Run) -> str:
    return f"{len(run.out) // 1000} kB of JSON"


if __name__ == "__main__":
    main()
