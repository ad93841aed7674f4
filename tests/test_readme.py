"""The README, run: every command of its console blocks prints what stands below it.

With OBSCLI_WRITE_README=1 the outputs are written anew.
"""

from __future__ import annotations

import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest


ROOT = Path(__file__).parents[1]
README = ROOT / "README.md"
CONSOLE = re.compile(r"```console\n(.*?)```", re.DOTALL)
PYTHON = re.compile(r"```python\n(.*?)```", re.DOTALL)
YAML = re.compile(r"```yaml\n(.*?)```", re.DOTALL)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with the bundled models, in which the commands may write."""
    place = tmp_path_factory.mktemp("readme")
    shutil.copytree(ROOT / "models", place / "models")
    return place


def commands(block):
    """Split a block into (command, output) pairs."""
    parts = re.split(r"^\$ (.*)\n", block, flags=re.MULTILINE)
    return list(zip(parts[1::2], parts[2::2], strict=True))


def run(command, folder):
    words = shlex.split(command)
    assert words[0] == "obscli"
    done = subprocess.run(
        [sys.executable, "-m", "obscli", *words[1:]],
        cwd=folder, env={**os.environ, "COLUMNS": "110", "PYTHONUTF8": "1"},
        capture_output=True, text=True, check=False, encoding="utf-8",
    )  # fmt: skip
    assert done.returncode in {0, 1}, done.stderr
    return "".join(line.rstrip() + "\n" for line in done.stdout.splitlines())


def test_every_command_prints_what_the_readme_shows(folder):
    text = README.read_text(encoding="utf-8")
    shown = [pair for block in CONSOLE.findall(text) for pair in commands(block)]
    printed = [(command, run(command, folder)) for command, _ in shown]
    if os.environ.get("OBSCLI_WRITE_README"):
        pairs = iter(printed)

        def fresh(match):
            again = (next(pairs) for _ in commands(match[1]))
            return "```console\n" + "".join(f"$ {command}\n{out}" for command, out in again) + "```"

        README.write_text(CONSOLE.sub(fresh, text), encoding="utf-8")
        return
    assert len(shown) >= 6
    assert printed == shown


def test_the_python_block_runs(folder):
    (code,) = PYTHON.findall(README.read_text(encoding="utf-8"))
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=folder, capture_output=True, text=True, check=True, encoding="utf-8"
    )
    assert "alpha_w = alpha_omega" in done.stdout


def test_the_smallest_model_is_read(tmp_path):
    (model,) = YAML.findall(README.read_text(encoding="utf-8"))
    file = tmp_path / "smallest.yaml"
    file.write_text(model, encoding="utf-8")
    assert "generic rank" in run(f"obscli analyze {file}", tmp_path)


def test_every_command_and_exit_code_is_named():
    text = README.read_text(encoding="utf-8")
    for word in ("obscli analyze", "obscli verify", "obscli model list", "| 130 |", "| 4 |"):
        assert word in text


def test_ci_calls_the_test_command_of_the_readme():
    text = README.read_text(encoding="utf-8")
    assert re.search(r"<!-- \.ci/run calls this very line -->\n```sh\n.*pytest.*\n```", text)
    assert "calls this very line" in (ROOT / ".ci" / "run").read_text(encoding="utf-8")
