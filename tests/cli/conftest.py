"""Small model files, and the command line run in this process."""

from dataclasses import dataclass

import pytest

from obscli.cli.boundary import main


INTEGRATOR = """\
title: Double integrator
states: [position, velocity]
A: [[0, 1], [0, 0]]
H: [[1, 0]]
claims:
  - rank: 2
    observable: [velocity]
"""
STAGES = """\
title: A tilt and a bias
parameters: {g: 9.81, w: 0.1}
states: [tilt, bias, drift]
let: {k: 1}
dynamics: {tilt: w*k*drift}
measurements: {y: g*tilt - bias}
quantities: {sum: tilt + bias}
stages:
  still: {fix: {w: 0}}
  turning: {}
"""


@pytest.fixture(autouse=True)
def patient(monkeypatch):
    """However slow the machine, no command loses patience and tells its progress on stderr."""
    monkeypatch.setattr("obscli.cli.progress.PATIENCE", 3600.0)


@dataclass(frozen=True)
class Outcome:
    status: int
    out: str
    err: str


@pytest.fixture
def obscli(capsys):
    """Run the command line; return exit code, stdout, stderr."""

    def run(*arguments):
        status = main([str(argument) for argument in arguments])
        captured = capsys.readouterr()
        return Outcome(int(status), captured.out, captured.err)

    return run


@pytest.fixture
def integrator(tmp_path):
    file = tmp_path / "integrator.yaml"
    file.write_text(INTEGRATOR)
    return file


@pytest.fixture
def stages(tmp_path):
    file = tmp_path / "stages.yaml"
    file.write_text(STAGES)
    return file
