"""CPU time and peak memory of a fresh process; medians and tables (standard library only, on purpose).

CPU time (user + system) is what the kernel counted for the process and the children it waited for: on a
machine shared with others it moves far less than wall time. Peak memory is ``ru_maxrss``, which a process
inherits from the one that started it: therefore nothing heavy may be imported here.
"""

from __future__ import annotations

import math
import os
import resource
import statistics
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING


if TYPE_CHECKING:
    from collections.abc import Callable, Sequence


ROOT = Path(__file__).resolve().parent.parent
OBSCLI = str(Path(sys.executable).with_name("obscli"))


@dataclass(frozen=True, slots=True)
class Run:
    """One finished process: CPU seconds, peak MB (10^6 bytes), exit code (-signal), output."""

    cpu: float
    mb: float
    code: int
    out: str
    err: str

    @property
    def trouble(self) -> str:
        """Empty where the process ended well, else the reason in a few words."""
        if self.code == 0:
            return ""
        lines = self.err.strip().splitlines() or ["no message"]
        return f"exit {self.code}: {lines[-1][:90]}" if self.code > 0 else f"stopped by signal {-self.code}"


def fresh(command: Sequence[str], cpu_limit: int = 300) -> Run:
    """Run a command to its end, or to its limit of CPU seconds (then code is -SIGXCPU or -SIGKILL)."""

    def limit() -> None:
        resource.setrlimit(resource.RLIMIT_CPU, (cpu_limit, cpu_limit + 1))

    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        process = subprocess.Popen(list(command), stdout=out, stderr=err, cwd=ROOT, preexec_fn=limit)  # noqa: PLW1509
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        out.seek(0)
        err.seek(0)
        unit = 1 if sys.platform == "darwin" else 1024
        return Run(
            cpu=usage.ru_utime + usage.ru_stime,
            mb=usage.ru_maxrss * unit / 1e6,
            code=process.returncode,
            out=out.read().decode(errors="replace"),
            err=err.read().decode(errors="replace"),
        )


def median(runs: Sequence[Run]) -> float:
    """The median CPU time."""
    return statistics.median(run.cpu for run in runs)


def peak(runs: Sequence[Run]) -> float:
    """The median peak memory."""
    return statistics.median(run.mb for run in runs)


def spread(values: Sequence[float]) -> str:
    """The least and the largest value."""
    return f"{min(values):.2f}–{max(values):.2f}"


def exponent(sizes: Sequence[float], seconds: Sequence[float]) -> float:
    """The slope of log seconds against log size by least squares; nan for fewer than two points."""
    if len(sizes) < 2:
        return math.nan
    x, y = [math.log(v) for v in sizes], [math.log(v) for v in seconds]
    return statistics.linear_regression(x, y).slope


def table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A Markdown table with aligned columns."""
    lines = [header, *rows]
    width = [max(len(line[i]) for line in lines) for i in range(len(header))]
    text = [
        "| " + " | ".join(cell.ljust(w) for cell, w in zip(line, width, strict=True)) + " |" for line in lines
    ]
    text.insert(1, "| " + " | ".join("-" * w for w in width) + " |")
    return "\n".join(text)


def row(
    name: str, command: list[str], count: int, target: str, limit: int, answer: Callable[[Run], str]
) -> list[str]:
    """A table row of one command in fresh processes: CPU seconds, their range, memory, target, answer."""
    fresh(command, limit)  # unmeasured: compiles modules, fills file caches
    runs = [fresh(command, limit) for _ in range(count)]
    if runs[-1].trouble:
        return [name, *["–"] * 4, runs[-1].trouble]
    spent = spread([run.cpu for run in runs])
    return [name, f"{median(runs):.2f}", spent, f"{peak(runs):.0f}", target, answer(runs[-1])]
