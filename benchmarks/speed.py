"""CPU time and memory of the main job, INS calibration stage 1, against its targets.

python benchmarks/speed.py [--runs 7]
"""

from __future__ import annotations

import argparse
import json
import statistics
import sys
from pathlib import Path

from measure import OBSCLI, ROOT, fresh, median, peak, spread, table


MODEL = "models/ins_calibration/horizontal.yaml"
STAGE = "stage_1"
COMMANDS = {
    "obscli analyze, stage 1, critical search": (
        [OBSCLI, "analyze", MODEL, "--stage", STAGE, "--only", "analytic"],
        "0.9",
    ),
    "the same with --no-critical": (
        [OBSCLI, "analyze", MODEL, "--stage", STAGE, "--only", "analytic", "--no-critical"],
        "",
    ),
    "obscli --help": ([OBSCLI, "--help"], "0.3"),
    "python -c pass": ([sys.executable, "-c", "pass"], ""),
    "import flint": ([sys.executable, "-c", "import flint"], ""),
    "import typer, rich.console": ([sys.executable, "-c", "import typer, rich.console"], ""),
    "import numpy": ([sys.executable, "-c", "import numpy"], ""),
    "import scipy.linalg": ([sys.executable, "-c", "import scipy.linalg"], ""),
    "import sympy": ([sys.executable, "-c", "import sympy"], ""),
}
MEMORY_TARGET = "150"


def fresh_rows(runs: int) -> list[list[str]]:
    """Rows of the commands, each run once unmeasured, then in turn."""
    found = {name: [] for name in COMMANDS}
    for turn in range(runs + 1):
        for name, (command, _) in COMMANDS.items():
            run = fresh(command)
            if turn:
                found[name].append(run)
    rows = []
    for name, (_, target) in COMMANDS.items():
        runs, wanted = found[name], f" ({MEMORY_TARGET})" if name.startswith("obscli analyze") else ""
        trouble = next((run.trouble for run in runs if run.trouble), "")
        figures = [f"{median(runs):.2f}", spread([run.cpu for run in runs]), f"{peak(runs):.0f}{wanted}"]
        cpu, least_most, memory = ["–"] * 3 if trouble else figures
        rows.append([name, cpu, least_most, target, memory, trouble])
    return rows


def warm_rows(runs: int) -> list[list[str]]:
    """Rows of the pipeline in one process: cold, then warm and its two parts."""
    run = fresh([sys.executable, str(Path(__file__).with_name("warm.py")), MODEL, STAGE, str(runs)])
    if run.trouble:
        return [["pipeline alone", "", "", "0.2", "", run.trouble]]
    cold, *warm = json.loads(run.out)
    parts = {
        "pipeline alone, warm: YAML to Analysis": ([sum(pair) for pair in warm], "0.2"),
        "  of it reading": ([read for read, _ in warm], ""),
        "  of it exact analysis": ([exact for _, exact in warm], ""),
        "pipeline alone, first time": ([sum(cold)], ""),
    }
    return [
        [name, f"{statistics.median(values):.3f}", spread(values), target, "", ""]
        for name, (values, target) in parts.items()
    ]


def main() -> None:
    parser = argparse.ArgumentParser(description="Speed of the main job against its targets.")
    parser.add_argument("--runs", type=int, default=7, help="measured runs of each command")
    given = parser.parse_args()
    if not (ROOT / MODEL).exists():
        parser.exit(2, f"{MODEL} is missing\n")
    header = ["what", "CPU s, median", "min–max", "target s", "peak MB (target)", "remark"]
    print(table(header, fresh_rows(given.runs) + warm_rows(given.runs)))


if __name__ == "__main__":
    main()
