"""Signals: how fast a record is read, and a Gramian found over all of it, in how much memory.

    python benchmarks/signals.py [samples]

A record of specific force and attitude at 100 Hz (10⁶ samples: 2.8 hours), 12 states (attitude and velocity
errors, biases of gyroscopes and accelerometers), velocity measured. Every sample is an edge of a panel.
"""

import resource
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from obscli.model.reader import load
from obscli.numeric.analysis import analyze
from obscli.numeric.horizon import Wanted
from obscli.numeric.settings import Settings
from obscli.numeric.signals import samples_of


MODEL = """\
states: {phi: 3, dv: 3, eps: 3, nabla: 3}
signals: {file: record.csv, time: t, columns: {f: [fx, fy, fz], roll: roll, pitch: pitch, yaw: yaw}}
let: {C: rotz(yaw) @ rotx(pitch) @ roty(roll)}
dynamics: {phi: -C @ eps, dv: "cross(f, phi) + C @ nabla"}
measurements: {y: dv}
"""


def record(path, count):
    """Write a record of some motion, with the noise of real sensors."""
    rng = np.random.default_rng(1)
    t = np.arange(count) / 100
    with path.open("w") as stream:
        stream.write("t,fx,fy,fz,roll,pitch,yaw\n")
        for part in np.array_split(t, max(count // 100_000, 1)):
            slow = np.outer(part, [0.11, 0.07, 0.05, 0.02, 0.03, 0.01])
            values = [0.5, 0.5, 0.2, 0.1, 0.1, 1.0] * np.sin(slow) + [0, 0, 9.81, 0, 0, 0]
            values += [0.05, 0.05, 0.05, 2e-4, 2e-4, 2e-4] * rng.standard_normal(values.shape)
            np.savetxt(stream, np.column_stack([part, values]), delimiter=",", fmt="%.9g")


def main():
    """Print the rates."""
    count = int(float(sys.argv[1])) if len(sys.argv) > 1 else 100_000
    with tempfile.TemporaryDirectory() as directory:
        path = Path(directory)
        record(path / "record.csv", count)
        (path / "m.yaml").write_text(MODEL)
        system = load(path / "m.yaml").systems[0]
        before = time.process_time()
        samples_of(system)
        loaded = time.process_time()
        print(f"{count} samples of 6 signals read and prepared in {loaded - before:.2f} s CPU", end="")
        print(f" ({count / (loaded - before):.3g} samples/s)")
        found = analyze(system, Settings(Wanted(samples=20)))
        took = time.process_time() - loaded
        print(f"Gramian over all of it, rank {found.rank} of {system.n}: {took:.1f} s CPU", end="")
        print(f" ({count / took:.3g} samples/s)")
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        print(f"largest memory {peak:.0f} MB")


if __name__ == "__main__":
    main()
