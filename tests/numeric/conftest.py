"""Short ways to build systems, to run the numerical side on them, and to load modules that lie elsewhere."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest

from obscli.exact import analysis as exact_side
from obscli.model.covector import parse_scalar
from obscli.model.reader import load, read_text
from obscli.numeric.analysis import METHODS, analyze
from obscli.numeric.horizon import Wanted
from obscli.numeric.numeric_system import NumericSystem
from obscli.numeric.rates import rates_of
from obscli.numeric.settings import STEP_ERROR, Effort, Settings
from obscli.numeric.transition import edges_of, longest_step, panels


ROOT = Path(__file__).parents[2]


def _system(text, **options):
    """Return the first system of a model text."""
    return read_text(text, "test.yaml", **options).systems[0]


def _bundled(path, stage=None, **options):
    """Return a stage of a bundled model."""
    return next(s for s in load(ROOT / "models" / path, **options).systems if s.stage == stage)


def _wanted(given, start=None, stop=None, samples=None, times=()):
    """Return instants given as texts, as the command line gives them."""

    def read(text):
        return None if text is None else parse_scalar(given, str(text), "test")

    return Wanted(read(start), read(stop), samples, tuple(read(one) for one in times))


def _numeric(given, method="square-root", scaling=None, **instants):
    """Return the numerical analysis of a system (or of a model text)."""
    given = _system(given) if isinstance(given, str) else given
    return analyze(given, Settings(_wanted(given, **instants), method, None, scaling))


def _exact(given):
    """Return the exact analysis of a system, without critical values."""
    return exact_side.analyze(given, exact_side.Options(critical=False, certificate=False))


def _gramian(given, instants, method="square-root", start=0.0, rtol=None):
    """Return the Gramian of a system (or of a model text) by one method, as that method finds it."""
    given = _system(given) if isinstance(given, str) else given
    instants = np.array(instants, dtype=float)
    found = NumericSystem(given, start, instants[-1])
    rates = rates_of(found, np.linspace(start, instants[-1], 18)[1:-1])
    return METHODS[method](found, start, instants, rates, Effort(rtol or STEP_ERROR[method], 100_000))


def _matrices(gramian):
    """Return W (N, n, n) in the file's units."""
    M = gramian.matrices
    W = M.transpose(0, 2, 1) @ M if gramian.is_root else M
    return W / gramian.units[:, :, None] / gramian.units[:, None, :]


def _transition(given, start, stop, longest=None, rtol=1e-14, most_steps=20_000):
    """Return Φ(start, stop) assembled from panels, the squared error of its panels summed, and their ends."""
    given = _system(given) if isinstance(given, str) else given
    found = NumericSystem(given, start, stop)
    rates = rates_of(found, np.linspace(start, stop, 18)[1:-1])
    edges = edges_of(start, np.array([stop]), longest or longest_step(rates), most_steps)
    whole, squared, ends = np.eye(found.n), np.zeros((found.n, found.n)), []
    for piece in panels(found, edges, Effort(rtol, most_steps)):
        for end, rows, error in zip(piece.ends, piece.transition, piece.transition_error, strict=True):
            phi, local = np.eye(found.n), np.zeros((found.n, found.n))
            phi[found.moving], local[found.moving] = rows, error
            # errors of independent panels add in squares: Φ(a, c) = Φ(a, b) Φ(b, c)
            squared = squared @ phi**2 + whole**2 @ local
            whole = whole @ phi
            ends.append(end)
    return whole, np.sqrt(squared), np.array(ends)


def _load_module(path):
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="session")
def root():
    return ROOT


@pytest.fixture(scope="session")
def system():
    return _system


@pytest.fixture(scope="session")
def bundled():
    return _bundled


@pytest.fixture(scope="session")
def wanted():
    return _wanted


@pytest.fixture(scope="session")
def numeric():
    return _numeric


@pytest.fixture(scope="session")
def exact():
    return _exact


@pytest.fixture(scope="session")
def gramian():
    return _gramian


@pytest.fixture(scope="session")
def matrices():
    return _matrices


@pytest.fixture(scope="session")
def transition():
    return _transition


@pytest.fixture(scope="session")
def stage_1():
    """INS calibration, stage 1, coded by hand in numpy."""
    return _load_module(ROOT / "tests/independent/ins_stage1_numpy.py")


@pytest.fixture(scope="session")
def known():
    """Random systems whose rank is known by construction."""
    return _load_module(ROOT / "tests/exact/known.py")
