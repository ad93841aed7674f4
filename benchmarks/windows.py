"""Local observability along a flight: CPU time of 1017 windows, rate and memory of a million.

python benchmarks/windows.py [--windows 1000000]

Fifteen states, six outputs, 15 samples a window, scaled by the prior: models/rocket/ins_gnss_enu.yaml. In
one process, warm: the first series is not counted.
"""

from __future__ import annotations

import argparse
import resource
import sys
import time
from pathlib import Path

from measure import table


ROOT = Path(__file__).resolve().parent.parent
MODEL = ROOT / "models/rocket/ins_gnss_enu.yaml"
LENGTH, STEP, FLIGHT = 1.5, 0.1, 1017


def series(windows: int, *, frozen: bool):
    """Yield the portions of some windows from t = 5."""
    from obscli.model.reader import load
    from obscli.numeric.local_windows import WindowSettings, sampling_of, window_series
    from obscli.numeric.numeric_system import NumericSystem
    from obscli.numeric.window_scaling import window_scaling

    system = next(one for one in load(MODEL).systems if one.stage == "flight")
    start, stop = 5.0, 5.0 + STEP * (windows - 1 + 14)
    # the motion is that of one flight, over and over: a longer one would be slower, and easier
    numeric = NumericSystem(system, start, start + STEP * (FLIGHT + 13))
    settings = WindowSettings(LENGTH, STEP, frozen=frozen)
    sampling = sampling_of(numeric, settings, start, stop)
    assert (sampling.windows, sampling.samples) == (windows, 15)
    return window_series(numeric, sampling, settings, window_scaling(numeric, None, sampling.h))


def spent(windows: int, *, frozen: bool) -> float:
    """CPU seconds for some windows; the values are looked at and let go."""
    parts = series(windows, frozen=frozen)
    start = time.process_time()
    seen = sum(len(part.t) for part in parts)
    assert seen == windows
    return time.process_time() - start


def peak() -> float:
    """Peak memory of this process in MB."""
    unit = 1 if sys.platform == "darwin" else 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit / 1e6


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--windows", type=int, default=1_000_000)
    many = options.parse_args().windows
    rows = []
    for name, frozen in (("frozen", True), ("true", False)):
        spent(FLIGHT, frozen=frozen)
        cpu = spent(FLIGHT, frozen=frozen)
        target = "1.5" if frozen else ""
        rows.append(
            [f"{FLIGHT} windows, {name}", f"{cpu:.2f}", f"{FLIGHT / cpu:.0f}", f"{peak():.0f}", target]
        )
    cpu = spent(many, frozen=True)
    rows.append([f"{many} windows, frozen", f"{cpu:.1f}", f"{many / cpu:.0f}", f"{peak():.0f}", ""])
    print(table(["what", "CPU s", "windows/s", "peak MB", "target s"], rows))


if __name__ == "__main__":
    main()
