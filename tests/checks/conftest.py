"""Systems of the bundled models with their analysis and their Gramian, each found once."""

from functools import cache
from pathlib import Path

import pytest

from obscli.exact.analysis import Options, analyze
from obscli.model.reader import load
from obscli.numeric.analysis import analyze as look
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
