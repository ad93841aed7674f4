"""Child of speed.py: the pipeline alone, again and again in one process; prints CPU seconds as JSON.

Each entry is [reading the YAML text, exact analysis with certificate and critical search]; the first one is
the cold one.
"""

from __future__ import annotations

import argparse
import json
import time
from pathlib import Path

from obscli.exact.analysis import Options, analyze
from obscli.model.reader import load


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("model", type=Path)
    parser.add_argument("stage")
    parser.add_argument("runs", type=int)
    given = parser.parse_args()
    times = []
    for _ in range(given.runs + 1):
        start = time.process_time()
        model = load(given.model)
        read = time.process_time()
        system = next(one for one in model.systems if one.stage == given.stage)
        analyze(system, Options(), lambda _step: None)
        times.append([read - start, time.process_time() - read])
    print(json.dumps(times))


if __name__ == "__main__":
    main()
