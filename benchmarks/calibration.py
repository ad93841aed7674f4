"""Experiments: calibrate and plan in fresh processes, beside symident on the same six runs.

    python benchmarks/calibration.py [--runs 5]

symident gets the six runs of the paper (stages 1 to 3, table turning both ways) as one system written out by
hand: six attitude errors, 21 constants, cos and sin of omega*t as known states. It says which constants are
identifiable; obscli adds the matrix, critical values, Gramians, the verification of both.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from pathlib import Path

from generators import imu_array
from measure import OBSCLI, Run, row, table
from peers import CONSTANTS, FULL, LOWER


HORIZONTAL = "models/ins_calibration/horizontal.yaml"
CANDIDATES = "models/calibration/table_plan.yaml"
LIMIT = 120

ROTATIONS = (
    (("1", "0", "0"), ("0", "c", "-s"), ("0", "s", "c")),
    (("0", "1", "0"), ("c", "0", "s"), ("s", "0", "-c")),
    (("0", "0", "1"), ("-s", "-c", "0"), ("c", "-s", "0")),
)
STAGES = """
interval: {start: 0, stop: 1500}
stages:
  stage_1: {}
  stage_2: {let: {R_nb: [[0, 1, 0], [c, 0, s], [s, 0, -c]]}}
  stage_3: {let: {R_nb: [[0, 0, 1], [-s, -c, 0], [c, -s, 0]]}}
experiment:
  runs:
    - {stage: [stage_1, stage_2, stage_3], grid: {omega: [omega, -omega]}}
"""


def six_runs() -> tuple[dict[str, str], dict[str, str]]:
    """(5) and (6) of the paper for six runs that share the constants: right-hand sides and outputs."""
    constants = [f"b_{kind}{i}" for kind in "ga" for i in (1, 2, 3)]
    constants += [f"M_g{k}" for k in FULL] + [f"M_a{k}" for k in LOWER]
    odes, outputs = dict.fromkeys(constants, "0"), {}
    runs = [(rotation, sign) for rotation in ROTATIONS for sign in ("", "-")]
    for k, (rotation, sign) in enumerate(runs, start=1):
        one = _run([[_turned(entry, sign) for entry in row] for row in rotation], f"({sign}omega)", f"p{k}_")
        odes |= one[0]
        outputs |= {f"y{k}_{i}": text for i, text in enumerate(one[1], start=1)}
    return odes, outputs


def _turned(entry: str, sign: str) -> str:
    """sin(-omega*t) is -s."""
    if not sign or "s" not in entry:
        return entry
    return entry[1:] if entry.startswith("-") else f"-{entry}"


def _run(R: list[list[str]], omega: str, psi: str) -> tuple[dict[str, str], list[str]]:
    earth = [omega, "omega_ie*cphi", "omega_ie*sphi"]
    w = [_sum(f"({R[j][i]})*{earth[j]}" for j in range(3) if R[j][i] != "0") for i in range(3)]
    f = [R[2][i] for i in range(3)]
    e = [_sum([f"b_g{i}", *(f"M_g{i}{j + 1}*({w[j]})" for j in range(3))]) for i in (1, 2, 3)]
    a = [
        _sum([f"b_a{i}/g", *(f"M_a{i}{j}*({f[j - 1]})" for j in range(1, i + 1) if f[j - 1] != "0")])
        for i in (1, 2, 3)
    ]
    p = [f"{psi}{i}" for i in (1, 2, 3)]
    cross = [
        f"omega_ie*sphi*{p[1]} - omega_ie*cphi*{p[2]}",
        f"-omega_ie*sphi*{p[0]}",
        f"omega_ie*cphi*{p[0]}",
    ]
    level = [f"-{p[1]}", p[0], "0"]
    return (
        {p[i]: _sum([cross[i], *_applied(R[i], e)]) for i in range(3)},
        [_sum([level[i], *_applied(R[i], a)]) for i in range(3)],
    )


def _applied(row: list[str], texts: list[str]) -> list[str]:
    return [f"({entry})*({text})" for entry, text in zip(row, texts, strict=True) if entry != "0"]


def _sum(terms) -> str:
    return " + ".join(f"({term})" for term in terms)


def symident_detect() -> dict:
    """Which of the 39 states are identifiable, with its fastest options."""
    import symident

    odes, outputs = six_runs()
    odes |= {"c": "-omega*s", "s": "omega*c"}
    result = symident.detect(symident.Model(odes, outputs, fixed=[*CONSTANTS, "c", "s"]), reconstruct=True)
    return {"rank": result.rank, "states": result.dim, "directions": len(result.symmetries)}


def main() -> None:
    parser = argparse.ArgumentParser(description="Experiments in fresh processes.")
    parser.add_argument("--child", action="store_true", help=argparse.SUPPRESS)
    parser.add_argument("--runs", type=int, default=5)
    given = parser.parse_args()
    if given.child:
        print(json.dumps(symident_detect()))
        return
    with tempfile.TemporaryDirectory() as directory:
        array = Path(directory) / "array.yaml"
        array.write_text(imu_array(8) + STAGES, encoding="utf-8")
        rows = [row(name, *command, LIMIT, _answer) for name, command in _commands(array, given.runs).items()]
    print(table(["what", "CPU s", "min–max", "MB", "wall limit", "answer"], rows))


def _commands(array: Path, runs: int) -> dict[str, tuple[list[str], int, str]]:
    """What is measured: command, how often, target."""
    calibrate = [OBSCLI, "calibrate", HORIZONTAL, "--format", "json"]
    return {
        "calibrate, six runs": (calibrate, runs, "3 s CPU"),
        "calibrate, six runs, --only analytic --no-critical": (
            [*calibrate, "--only", "analytic", "--no-critical"],
            runs,
            "–",
        ),
        "symident detect, six runs": ([sys.executable, str(Path(__file__).resolve()), "--child"], runs, "–"),
        "plan, 24 candidates": ([OBSCLI, "plan", CANDIDATES, "--format", "json"], runs, "30 s on two cores"),
        "calibrate, 8 IMUs, 168 constants, six runs": (
            [OBSCLI, "calibrate", str(array), "--format", "json"],
            1,
            "60 s",
        ),
    }


def _answer(run: Run) -> str:
    found = json.loads(run.out.splitlines()[-1] if run.out.count("\n") < 2 else run.out)
    if "results" not in found:
        return f"rank {found['rank']} of {found['states']}, {found['directions']} directions"
    result = found["results"][0]
    if "plan" in result:
        plan = result["plan"]
        best = len(plan["recommended"]["runs"])
        reach = f"{plan['rank']} of {plan['columns']}"
        return f"{plan['count']} smallest sets of {plan['size']} reach {reach}; recommended {best} runs"
    matrix, verification = result["experiment"]["matrix"], result["verification"]
    verdict = f", {verification['verdict']}" if verification else ""
    return f"M {matrix['rows']} × {matrix['columns']}, rank {matrix['rank']}{verdict}"


if __name__ == "__main__":
    main()
