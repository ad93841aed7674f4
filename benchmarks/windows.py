"""Along a flight: CPU time of 1017 windows and of 200 random runs, rate and memory of a million windows.

python benchmarks/windows.py [--windows 1000000]

Fifteen states, six outputs, 15 samples a window, scaled by the prior: models/rocket/ins_gnss_enu.yaml. In
one process, warm: the first series is not counted. The runs are of the filter on a recorded flight of 106 s
at 10 Hz, models/rocket/flights_enu.yaml, its covariance and the reading of the file included.
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
FLIGHTS = ROOT / "models/rocket/flights_enu.yaml"
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


def random_runs() -> tuple[float, str]:
    """CPU seconds for 200 runs of the filter, and whether they are consistent."""
    from obscli.model.reader import load
    from obscli.numeric.horizon import Wanted, horizon_of
    from obscli.numeric.linear_forms import forms_of
    from obscli.numeric.monte_carlo import monte_carlo
    from obscli.numeric.recorded_errors import recorded_errors
    from obscli.numeric.schedule import schedule_of

    start = time.process_time()
    system = load(FLIGHTS).systems[0]
    interval = horizon_of(system, Wanted())
    schedule = schedule_of(system, interval.start, interval.stop)
    found = monte_carlo(recorded_errors(system, schedule, forms_of(system), 200), 200, 1)
    spent = time.process_time() - start
    told = f"{len(schedule.t)} samples, inside: NEES {found.nees.inside:.2f}, NIS {found.nis.inside:.2f}"
    return spent, told


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
    cpu, told = random_runs()
    rows.append(["200 random runs", f"{cpu:.2f}", "", f"{peak():.0f}", "20"])
    cpu = spent(many, frozen=True)
    rows.append([f"{many} windows, frozen", f"{cpu:.1f}", f"{many / cpu:.0f}", f"{peak():.0f}", ""])
    print(table(["what", "CPU s", "windows/s", "peak MB", "target s"], rows))
    print(f"random runs: {told}")


if __name__ == "__main__":
    main()
