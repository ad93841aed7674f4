"""Every exit code, through the real command line."""

import os
import signal
import subprocess
import sys
import time

import pytest


def obscli_process(*arguments, prepare="", **options):
    """Start obscli in a process of its own, never impatient; ``prepare`` is Python run before it."""
    patient = "import obscli.cli.progress as progress\nprogress.PATIENCE = 3600"
    code = f"import sys\nsys.argv = ['obscli', *sys.argv[1:]]\n{patient}\n{prepare}\nfrom obscli.cli import run\nrun()\n"
    command = [sys.executable, "-c", code, *(str(argument) for argument in arguments)]
    pipe = subprocess.PIPE
    return subprocess.Popen(command, stdout=pipe, stderr=pipe, text=True, encoding="utf-8", **options)


def finished(process):
    out, err = process.communicate(timeout=60)
    return process.returncode, out, err


SLOW = """
import obscli.exact.analysis as engine, time
def analyze(system, options, progress):
    print("started", file=sys.stderr, flush=True)
    time.sleep(60)
engine.analyze = analyze
"""
BROKEN = """
import obscli.exact.analysis as engine
def analyze(system, options, progress):
    raise RuntimeError("the engine is broken")
engine.analyze = analyze
"""
LYING = """
import obscli.exact.analysis as engine
from dataclasses import replace
truly = engine.analyze
def analyze(system, options, progress):
    found = truly(system, options, progress)
    wrong = replace(found.combinations[0], coefficients={"drift": found.combinations[0].coefficients["tilt"]})
    return replace(found, combinations=(wrong, *found.combinations[1:]))
engine.analyze = analyze
"""
UNDECIDED = """
import obscli.exact.analysis as engine
from obscli.exact.finding import Undecided
engine.analyze = lambda system, options, progress: Undecided(system, "cannot say whether c is zero")
"""


def test_done_is_0(integrator):
    status, out, err = finished(obscli_process("analyze", integrator))

    assert (status, err) == (0, "")
    assert "Double integrator" in out


def test_false_claim_is_1(integrator):
    integrator.write_text(integrator.read_text().replace("rank: 2", "rank: 1"))

    status, out, err = finished(obscli_process("verify", integrator))

    assert (status, err) == (1, "")
    assert "✗" in out


def test_false_claim_is_1_also_where_only_the_gramian_can_tell(stages):
    """The exact side is undecided; the Gramian alone refutes with certainty."""
    status, out, err = finished(
        obscli_process("verify", stages, "--stage", "still", "--claim", "drift", prepare=UNDECIDED)
    )

    assert (status, err) == (1, "")
    assert "the Gramian denies it" in " ".join(out.split())


def test_an_analysis_that_the_gramian_contradicts_is_1(stages):
    given = ("analyze", stages, "--stage", "still", "--no-critical", "--only", "verify")

    status, out, err = finished(obscli_process(*given, prepare=LYING))

    assert (status, err) == (1, "")
    assert "contradicted by the Gramian" in " ".join(out.split())
    assert finished(obscli_process(*given))[0] == 0


def test_usage_is_2(integrator):
    status, out, err = finished(obscli_process("analyze", integrator, "--format", "paper"))

    assert (status, out) == (2, "")
    assert "terminal, json, markdown, latex" in err


def test_model_error_is_2_with_every_problem(tmp_path):
    file = tmp_path / "bad.yaml"
    file.write_text("states: [a, b]\nA: [[0, omga], [0, 0]]\nH: [[1, foo]]\n")

    status, out, err = finished(obscli_process("analyze", file))

    assert (status, out) == (2, "")
    assert "bad.yaml:2:" in err
    assert "bad.yaml:3:" in err


def test_internal_error_is_3_and_asks_for_a_report(integrator):
    status, out, err = finished(obscli_process("analyze", integrator, prepare=BROKEN))

    assert (status, out) == (3, "")
    assert "RuntimeError: the engine is broken" in err
    assert "please report" in err.lower()


@pytest.mark.parametrize(("strict", "expected"), [((), 0), (("--strict",), 4)])
def test_undecided_is_4_where_strict(integrator, strict, expected):
    status, out, err = finished(obscli_process("analyze", integrator, *strict, prepare=UNDECIDED))

    assert (status, err) == (expected, "")
    assert "cannot say whether c is zero" in out


@pytest.mark.skipif(os.name == "nt", reason="no SIGINT for a child there")
def test_interrupted_is_130_without_traceback(integrator):
    process = obscli_process("analyze", integrator, prepare=SLOW)
    assert process.stderr.readline() == "started\n"
    time.sleep(0.2)
    process.send_signal(signal.SIGINT)

    status, out, err = finished(process)

    assert (status, out) == (130, "")
    assert err.strip().endswith("obscli: interrupted")
    assert "Traceback" not in err


def test_a_reader_that_leaves_is_no_error(integrator):
    process = obscli_process("analyze", integrator, "--format", "json")
    process.stdout.close()

    err = process.stderr.read()

    assert (process.wait(timeout=60), err) == (0, "")
    process.stderr.close()
