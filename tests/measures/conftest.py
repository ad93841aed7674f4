"""Measures of small systems given as text, or by matrices."""

from pathlib import Path

import numpy as np
import pytest

from obscli.model.reader import load, read_text
from obscli.pipelines.measures import measures
from obscli.pipelines.request import MeasuresRequest, NumericRequest


MODELS = Path(__file__).parents[2] / "models"


class Measured:
    """The measures of one system: ``state(key)`` by state, ``system(key)``, ``combination(key)`` in order."""

    def __init__(self, report):
        self.report = report
        self.result = report.results[0]
        assert isinstance(self.result.taken, tuple), self.result.taken
        self.taken = self.result.taken[-1]
        self.subject = self.taken.subject

    def _values(self, key, kind):
        pairs = zip(self.subject.targets, self.taken.found[key].targets, strict=True)
        return {target.name: value for target, value in pairs if target.kind == kind}

    def state(self, key):
        return list(self._values(key, "state").values())

    def quantity(self, key):
        return self._values(key, "quantity")

    def combination(self, key):
        return list(self._values(key, "combination").values())

    def system(self, key):
        found = {
            name: value
            for one in self.taken.found.values()
            for name, value in getattr(one, "system", {}).items()
        }
        return found[key]

    def sizes(self, key):
        return [one.value for one in self.system(key)]


def text_of(A, H, **more):
    """Return a model file with constant matrices, exactly as their decimals."""
    n = len(np.atleast_2d(A))
    lines = [
        f"states: [{', '.join(f'x{k + 1}' for k in range(n))}]",
        f"A: {np.atleast_2d(A).tolist()}",
        f"H: {np.atleast_2d(H).tolist()}",
        *(f"{key}: {value}" for key, value in more.items()),
    ]
    return "\n".join(lines) + "\n"


@pytest.fixture
def measure():
    def run(text, start=None, stop=None, **asked):
        request = MeasuresRequest(numeric=NumericRequest(start=start, stop=stop), **asked)
        return Measured(measures(read_text(text, "test.yaml"), request))

    return run


@pytest.fixture
def of_matrices(measure):
    def run(A, H, more=None, **asked):
        return measure(text_of(A, H, **(more or {})), **asked)

    return run


@pytest.fixture
def bundled():
    def run(path, stage=None, start=None, stop=None, **asked):
        stages = () if stage is None else (stage,)
        request = MeasuresRequest(stages=stages, numeric=NumericRequest(start=start, stop=stop), **asked)
        return Measured(measures(load(MODELS / path), request))

    return run
