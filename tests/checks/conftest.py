"""Systems of the bundled models with their analysis and their Gramian, each found once; ways to check."""

import importlib.util
from functools import cache
from pathlib import Path

import pytest

from obscli.checks.claims import check_claims
from obscli.exact.analysis import Options, analyze
from obscli.model.covector import parse_scalar
from obscli.model.reader import load, read_text
from obscli.numeric.analysis import analyze as look
from obscli.numeric.horizon import Wanted
from obscli.numeric.settings import Settings


MODELS = Path(__file__).parents[2] / "models"
FAST = Options(critical=False, certificate=False)


@cache
def _bundled(file, stage):
    system = next(s for s in load(MODELS / file).systems if s.stage == stage)
    return system, analyze(system, FAST), look(system, Settings())


@pytest.fixture(scope="session")
def bundled():
    """Return the function (file, stage) -> system, its analysis, its Gramian."""
    return _bundled


@pytest.fixture(scope="session")
def stage_2():
    return _bundled("ins_calibration/horizontal.yaml", "stage_2")


@pytest.fixture(scope="session")
def known():
    """Return the module that builds systems from a known decomposition."""
    file = Path(__file__).parents[1] / "exact" / "known.py"
    spec = importlib.util.spec_from_file_location("known", file)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def _instants(system, *texts):
    return Settings(Wanted(times=tuple(parse_scalar(system, text, "test") for text in texts)))


@pytest.fixture(scope="session")
def instants():
    """Return the function (system, texts of instants) -> settings of the numerical side."""
    return _instants


def _checked(text, *times, gramian=True):
    """Return the checks of the first system of a model text, by both sides unless told otherwise."""
    system = read_text(text, "test.yaml").systems[0]
    return check_claims(
        system,
        analyze(system, FAST),
        (lambda there: look(there, _instants(there, *times))) if gramian else None,
    )


@pytest.fixture(scope="session")
def checked():
    """Return the function (model text, instants) -> results of its claims."""
    return _checked
