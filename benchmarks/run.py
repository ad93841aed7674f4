"""Everything: speed, growth, peers, and the check of the generators, as Markdown.

python benchmarks/run.py [--quick] > benchmarks/results.md
"""

from __future__ import annotations

import argparse
import os
import platform
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path


PACKAGES = ("obscli", "python-flint", "sympy", "symident", "numpy", "scipy", "typer")
QUICK = {
    "speed.py": ["--runs", "3"],
    "growth.py": ["--runs", "1"],
    "gramian.py": ["--runs", "3"],
    "calibration.py": ["--runs", "3"],
    "structure.py": ["--runs", "3"],
    "simulate.py": ["--runs", "1"],
    "windows.py": ["--windows", "20000"],
    "pybounds_peer.py": ["--runs", "3"],
    "peers.py": ["--runs", "1", "--reduce-limit", "0"],
}
TITLES = {
    "speed.py": "Speed: INS calibration stage 1",
    "growth.py": "Growth",
    "gramian.py": "The Gramian: INS calibration stage 2",
    "calibration.py": "Experiments: six runs, 24 candidates, 8 IMUs",
    "structure.py": "Structure: smaller models, explanations",
    "simulate.py": "The Kalman filter: INS calibration stage 1 at 10 Hz",
    "windows.py": "Local observability in windows: a guided rocket",
    "pybounds_peer.py": "Sliding windows: INS calibration stage 1, beside pybounds",
    "peers.py": "Side by side: INS calibration stage 1",
    "witness.py": "The generators, checked by modular power series",
}


def machine() -> str:
    """Processor, cores, Python, packages."""
    info = Path("/proc/cpuinfo")
    names = [line.split(":")[1].strip() for line in _lines(info) if line.startswith("model name")]
    packages = ", ".join(f"{name} {version(name)}" for name in PACKAGES)
    return (
        f"{names[0] if names else platform.processor()}, {os.cpu_count()} cores, {platform.system()}, "
        f"Python {platform.python_version()}; {packages}"
    )


def _lines(file: Path) -> list[str]:
    return file.read_text().splitlines() if file.exists() else []


def main() -> int:
    parser = argparse.ArgumentParser(description="Run every benchmark and print one report.")
    parser.add_argument("--quick", action="store_true", help="fewer runs, without the slowest peer")
    given = parser.parse_args()
    print(
        f"# Benchmarks\n\n{machine()}. CPU seconds (user + system) of fresh processes, medians.", flush=True
    )
    failed = 0
    for script, title in TITLES.items():
        print(f"\n## {title}\n", flush=True)
        options = QUICK.get(script, []) if given.quick else []
        wrap = script == "witness.py"
        if wrap:
            print("```", flush=True)
        failed += (
            subprocess.run(
                [sys.executable, Path(__file__).with_name(script), *options], check=False
            ).returncode
            != 0
        )
        if wrap:
            print("```", flush=True)
    return int(bool(failed))


if __name__ == "__main__":
    sys.exit(main())
