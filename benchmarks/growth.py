"""How CPU time and memory grow with the number of states, YAML to report, each time in a fresh process.

python benchmarks/growth.py [--families imus chains sparse] [--max-states 400] [--no-critical]
"""

from __future__ import annotations

import argparse
import json
import tempfile
from dataclasses import dataclass
from pathlib import Path

import generators
from measure import OBSCLI, Run, exponent, fresh, median, peak, table


SEED = 1
START_UP_NOISE = 0.03  # seconds above start-up below which a size says nothing about growth


@dataclass(frozen=True, slots=True)
class Case:
    """One generated model."""

    family: str
    label: str
    n: int
    rank: int
    text: str


def cases() -> list[Case]:
    """Every family in growing size."""
    sizes = (25, 50, 100, 200)
    imus = [
        Case(
            "imus",
            f"{k} IMUs",
            generators.imu_array_states(k),
            generators.imu_array_rank(k),
            generators.imu_array(k),
        )
        for k in (1, 2, 4, 8, 16)
    ]
    chains = [Case("chains", f"chain of {n}", n, n, generators.integrator_chain(n)) for n in sizes]
    sparse = [
        Case("sparse", f"sparse {n}", n, 3 * n // 4, generators.random_sparse(n, 3 * n // 4, SEED))
        for n in sizes
    ]
    return imus + chains + sparse


def analyze(text: str, options: list[str], runs: int, limit: int) -> tuple[list[Run], Run]:
    """Runs that print the report for the terminal, and one that prints JSON, for the rank."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "model.yaml"
        file.write_text(text)
        command = [OBSCLI, "analyze", str(file), "--only", "analytic", *options]
        report = []
        while len(report) < runs and not (report and (report[-1].trouble or report[-1].cpu > 20)):
            report.append(fresh(command, limit))
        return report, fresh([*command, "--format", "json"], limit)


def rank_found(run: Run) -> str:
    """The rank in the JSON report, or why there is none."""
    if run.trouble:
        return run.trouble
    try:
        return str(json.loads(run.out)["results"][0]["analytic"]["rank"])
    except (ValueError, KeyError, IndexError, TypeError) as error:
        return f"no rank in the JSON: {error!r}"[:60]


def main() -> None:
    parser = argparse.ArgumentParser(description="Growth of CPU time and memory with the number of states.")
    parser.add_argument("--families", nargs="+", default=["imus", "chains", "sparse"])
    parser.add_argument("--max-states", type=int, default=400)
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--limit", type=int, default=120, help="CPU seconds for one run")
    parser.add_argument("--no-critical", action="store_true", help="without the critical search")
    given = parser.parse_args()
    options = ["--no-critical"] if given.no_critical else []
    start_up = median(analyze(generators.integrator_chain(1), options, 5, given.limit)[0])
    rows, points = [], {}
    for case in cases():
        if case.family not in given.families or case.n > given.max_states:
            continue
        report, data = analyze(case.text, options, given.runs, given.limit)
        cpu, found = median(report), rank_found(data)
        trouble = next((run.trouble for run in report if run.trouble), "")
        verdict = trouble or ("ok" if found == str(case.rank) else "WRONG")
        target = "5 s, 300 MB" if case.label == "16 IMUs" else ""
        rows.append(
            [
                case.label,
                str(case.n),
                str(case.rank),
                found,
                verdict,
                "–" if trouble else f"{cpu:.2f}",
                "–" if data.trouble else f"{data.cpu:.2f}",
                f"{peak(report):.0f}",
                target,
            ]
        )
        if not trouble:
            points.setdefault(case.family, []).append((case.n, cpu))
    header = ["model", "n", "rank expected", "found", "", "CPU s", "as JSON", "peak MB", "target"]
    print(table(header, rows))
    print(f"\nstart-up (one integrator, median of 5): {start_up:.2f} s")
    for family, pairs in points.items():
        net = [(n, cpu - start_up) for n, cpu in pairs if cpu - start_up > START_UP_NOISE]
        whole, above = exponent(*_columns(pairs)), exponent(*_columns(net))
        print(f"{family}: time ~ n^{whole:.2f}; above start-up ~ n^{above:.2f} ({len(net)} of {len(pairs)})")


def _columns(pairs: list[tuple[int, float]]) -> tuple[list[float], list[float]]:
    return [n for n, _ in pairs], [seconds for _, seconds in pairs]


if __name__ == "__main__":
    main()
