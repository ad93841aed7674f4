"""Short ways to read models, to calibrate and to plan, and modules that lie elsewhere."""

import importlib.util
import re
from pathlib import Path

import numpy as np
import pytest

from obscli.api import calibrate, plan
from obscli.model.reader import read_text
from obscli.numeric.noise import noise_model
from obscli.numeric.numeric_system import NumericSystem
from obscli.numeric.program import constant_value
from obscli.pipelines.request import CalibrateRequest, PlanRequest


ROOT = Path(__file__).parents[2]
LONG = ("claims", "expect", "experiment", "plan")


def _model(text, **options):
    return read_text(text, "test.yaml", **options)


def _calibrated(text, *runs, critical=False, only=None, **options):
    """Return what was found of the experiment of a model text, or of a model."""
    given = _model(text, **options) if isinstance(text, str) else text
    [result] = calibrate(given, request=CalibrateRequest(tuple(runs), critical, only)).results
    return result


def _planned(text, *runs, **options):
    """Return the plan for a model text, or a model."""
    given = _model(text, **options) if isinstance(text, str) else text
    [result] = plan(given, request=PlanRequest(tuple(runs))).results
    return result


def _told(text, **options):
    """Return what the runs of an experiment tell, roots of information: the plan for them is made of it."""
    return _planned(text, **options).plan.informed


def _noise(text, stop):
    """Return the noise of a model's first system in numbers."""
    return noise_model(NumericSystem(_model(text).systems[0], 0.0, stop))


def _rows(covectors, names, values=None):
    """Return covectors as rows of numbers."""
    numbers = np.zeros((len(covectors), len(names)))
    for row, covector in zip(numbers, covectors, strict=True):
        for name, entry in covector.items():
            row[names.index(name)] = constant_value(entry, values or {})
    return numbers


def _bare(path):
    """Return the text of a bundled model without claims, experiment and plan of its own."""
    text = (ROOT / "models" / path).read_text(encoding="utf-8")
    parts = re.split(r"^(?=\w+:)", text, flags=re.MULTILINE)
    return "".join(part for part in parts if part.split(":")[0] not in LONG)


def _load_module(path):
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="session")
def model():
    return _model


@pytest.fixture(scope="session")
def calibrated():
    return _calibrated


@pytest.fixture(scope="session")
def planned():
    return _planned


@pytest.fixture(scope="session")
def told():
    return _told


@pytest.fixture(scope="session")
def noise():
    return _noise


@pytest.fixture(scope="session")
def numbers():
    return _rows


@pytest.fixture(scope="session")
def bare():
    return _bare


@pytest.fixture(scope="session")
def known():
    """Experiments of known answer."""
    return _load_module(Path(__file__).parent / "known.py")
