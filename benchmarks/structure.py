"""Structure: transform, why, measures, certified ranks and the section of analyze, in fresh processes.

python benchmarks/structure.py [--runs 5]
"""

from __future__ import annotations

import argparse
import json

from measure import OBSCLI, Run, row, table


STAGE_1 = ["models/ins_calibration/horizontal.yaml", "--stage", "stage_1"]
CONSTANT_ERRORS = "models/kortunov/sixteen_states_case_3.yaml"
LIMIT = 60

#: What is measured, with its target.
COMMANDS = {
    "transform --to observable, INS stage 1": (["transform", *STAGE_1, "--to", "observable"], "2 s CPU"),
    "transform --to kalman, INS stage 1": (["transform", *STAGE_1, "--to", "kalman"], "–"),
    "transform --to observable, 16 states, constant errors": (
        ["transform", CONSTANT_ERRORS, "--to", "observable", "--stage", "velocity_position"],
        "–",
    ),
    "transform --to stationary, INS stage 1": (["transform", *STAGE_1, "--to", "stationary"], "2 s CPU"),
    "analyze --certify at 60 and 600 s, INS stage 1": (
        ["analyze", *STAGE_1, "--certify", "--times", "60,600", "--no-critical"],
        "5 s CPU an instant",
    ),
    "measures, INS stage 1": (["measures", *STAGE_1], "–"),
    "analyze --only structure, INS stage 1": (["analyze", *STAGE_1, "--only", "structure"], "–"),
    "why b_g3, INS stage 1": (["why", STAGE_1[0], "b_g3", *STAGE_1[1:]], "–"),
}


def main() -> None:
    parser = argparse.ArgumentParser(description="Structure in fresh processes.")
    parser.add_argument("--runs", type=int, default=5)
    given = parser.parse_args()
    rows = [
        row(name, [OBSCLI, *words, "--format", "json"], given.runs, target, LIMIT, _answer)
        for name, (words, target) in COMMANDS.items()
    ]
    print(table(["what", "CPU s", "min–max", "MB", "limit", "answer"], rows))


def _answer(run: Run) -> str:
    result = json.loads(run.out)["results"][0]
    if "transform" in result:
        made = result["transform"]
        if made["to"] == "stationary":
            return f"full lift {made['full']['n']}, smallest {made['smallest']['n']}, rank {made['rank']}"
        return f"{made['n']} states, {sum(one['verdict'] == 'holds' for one in made['checks'])} checks hold"
    if "why" in result:
        told = result["why"]
        return f"{told['verdict']}, {len(told['conditions'])} remedies"
    if "measures" in result:
        return f"{len(result['measures']['states'])} states, rank {result['measures']['rank']}"
    if result["certified"]:
        return ", ".join(f"rank {one['rank']} at {one['t']:g}" for one in result["certified"])
    found = result["structure"]
    return f"{found['unobservable_dimension']} hidden, {found['verdict']}"


if __name__ == "__main__":
    main()
