"""The README and pages of docs, run: every command of their console blocks prints what stands below it.

Numbers at rounding level differ from machine to machine: they are compared in magnitude only.
With OBSCLI_WRITE_README=1 the outputs are written anew.
"""

from __future__ import annotations

import itertools
import json
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
# The pages, and how many commands each shows at least.
PAGES = {
    "README.md": 16,
    "docs/verification.md": 5,
    "docs/calibration.md": 6,
    "docs/structure.md": 7,
    "docs/measures.md": 3,
    "docs/reducible.md": 2,
    "docs/windows.md": 2,
    "docs/simulation.md": 5,
}
CONSOLE = re.compile(r"```console\n(.*?)```", re.DOTALL)
PYTHON = re.compile(r"```python\n(.*?)```", re.DOTALL)
YAML = re.compile(r"```yaml\n(.*?)```", re.DOTALL)
LINK = re.compile(r"\]\(([^)#:]+)(?:#[^)]*)?\)")

#: 1.4e-8, 2.4e12, 0.097; and by what factor such numbers may differ.
ROUNDED = re.compile(r"(?<![\w.])(?:\d+(?:\.\d+)?e-?\d+|0\.\d+)(?!\w)")
FACTOR = 30


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with the bundled models and the claims of the figures, in which the commands may write."""
    place = tmp_path_factory.mktemp("readme")
    shutil.copytree(ROOT / "models", place / "models")
    shutil.copytree(ROOT / "docs" / "figures", place / "docs" / "figures")
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
    assert done.returncode in {0, 1, 4}, done.stderr
    return "".join(line.rstrip() + "\n" for line in done.stdout.splitlines())


def alike(shown, printed):
    """Compare paragraph by paragraph: the same text, or the same words with numbers of the same magnitude.

    Of paragraphs with such numbers only the words are compared, since longer numbers break lines elsewhere.
    """
    pairs = itertools.zip_longest(shown.split("\n\n"), printed.split("\n\n"), fillvalue="")
    return all(a == b or same_words(a, b) for a, b in pairs)


def same_words(a, b):
    a, b = " ".join(a.split()), " ".join(b.split())
    numbers = ROUNDED.findall(a)
    pairs = zip(numbers, ROUNDED.findall(b), strict=False)
    return (
        any("e" in number for number in numbers)
        and ROUNDED.sub("~", a) == ROUNDED.sub("~", b)
        and all(float(x) <= FACTOR * float(y) and float(y) <= FACTOR * float(x) for x, y in pairs)
    )


@pytest.mark.parametrize(("page", "least"), PAGES.items())
def test_every_command_prints_what_the_page_shows(page, least, folder):
    text = (ROOT / page).read_text(encoding="utf-8")
    shown = [pair for block in CONSOLE.findall(text) for pair in commands(block)]
    printed = [(command, run(command, folder)) for command, _ in shown]
    if os.environ.get("OBSCLI_WRITE_README"):
        pairs = iter(printed)

        def fresh(match):
            again = (next(pairs) for _ in commands(match[1]))
            return "```console\n" + "".join(f"$ {command}\n{out}" for command, out in again) + "```"

        (ROOT / page).write_text(CONSOLE.sub(fresh, text), encoding="utf-8")
        return
    assert len(shown) >= least
    for (command, below), (_, out) in zip(shown, printed, strict=True):
        assert alike(below, out), f"$ {command}\n{out}"


ROUNDING = """\
  rank      3 of 4 at 150 of 150 instants, gap at least 4.4e11; tolerance 3.3e-15

  ✓ the Gramian agrees at 150 of 150 instants, worst
    leak 2.8e-7
"""


@pytest.mark.parametrize(
    ("old", "new", "same"),
    [
        ("2.8e-7", "3.4e-7", True),
        ("4.4e11", "9e10", True),
        ("worst\n    leak", "worst leak", True),
        ("2.8e-7", "2.8e-5", False),
        ("2.8e-7", "-2.8e-7", False),
        ("2.8e-7", "0", False),
        ("3 of 4", "4 of 4", False),
        ("150 of 150", "149 of 150", False),
        ("worst", "least", False),
        ("✓", "✗", False),
        ("; tolerance 3.3e-15", "", False),
        ("leak 2.8e-7\n", "leak 2.8e-7\n\nmore\n", False),
    ],
)
def test_only_rounding_may_differ(old, new, same):
    assert alike(ROUNDING, ROUNDING.replace(old, new)) is same


def test_without_numbers_at_rounding_level_every_blank_counts():
    assert alike("rank  16\n", "rank  16\n")
    assert not alike("rank  16\n", "rank 16\n")
    assert not alike("omega = 0.1\n", "omega = 0.2\n")


def test_every_link_of_the_pages_leads_somewhere():
    pages = [README, ROOT / "CHANGELOG.md", *sorted((ROOT / "docs").glob("*.md"))]
    broken = [
        f"{page.name}: {target}"
        for page in pages
        for target in LINK.findall(page.read_text(encoding="utf-8"))
        if not (page.parent / target).exists()
    ]
    assert not broken


@pytest.mark.parametrize(
    ("page", "word"),
    [
        ("README.md", "alpha_w = alpha_omega"),
        ("README.md", "24 → 19 states, 16 seen; same combinations: True"),
        ("docs/calibration.md", "outer_turns"),
    ],
)
def test_the_python_block_runs(page, word, folder):
    blocks = PYTHON.findall((ROOT / page).read_text(encoding="utf-8"))
    printed = [
        subprocess.run(
            [sys.executable, "-X", "utf8", "-c", code], cwd=folder,
            capture_output=True, text=True, check=True, encoding="utf-8",
        ).stdout
        for code in blocks
    ]  # fmt: skip
    assert any(word in out for out in printed)


def test_the_smallest_model_is_read(tmp_path):
    model, _ = YAML.findall(README.read_text(encoding="utf-8"))
    file = tmp_path / "smallest.yaml"
    file.write_text(model, encoding="utf-8")
    assert "generic rank" in run(f"obscli analyze {file}", tmp_path)


def test_files_are_shown_as_they_are():
    _, experiment = YAML.findall(README.read_text(encoding="utf-8"))
    assert experiment in (ROOT / "models/ins_calibration/horizontal.yaml").read_text(encoding="utf-8")
    (table,) = YAML.findall((ROOT / "docs/calibration.md").read_text(encoding="utf-8"))
    assert table == (ROOT / "docs/figures/leaning_table.yaml").read_text(encoding="utf-8")


def test_every_command_and_exit_code_is_named():
    text = README.read_text(encoding="utf-8")
    for word in (
        "obscli analyze", "obscli verify", "obscli calibrate", "obscli plan", "obscli measures", "obscli simulate",
        "obscli model list", "| 130 |", "| 4 |",
    ):  # fmt: skip
        assert word in text


def test_every_field_of_the_json_is_explained(folder):
    """Every key that calibrate and plan write stands in the page, but for what verification.md explains."""
    page = (ROOT / "docs/calibration.md").read_text(encoding="utf-8")
    elsewhere = {"numeric", "verification", "certificate", "changes"}
    named = {"states", "quantities", "standard_deviation", "coefficients"}  # keys below are names of the file
    for command in ("calibrate", "plan"):
        found = json.loads(run(f"obscli {command} docs/figures/leaning_table.yaml --format json", folder))
        missing = {key for key in _keys(found, elsewhere, named) if not re.search(rf"`(\w+\.)*{key}`", page)}
        assert not missing


def test_every_field_of_the_json_of_the_structure_is_explained(folder):
    """Every key of ``structure``, ``why`` and ``transform``, but for names of the file and formulas."""
    page = (ROOT / "docs/structure.md").read_text(encoding="utf-8")
    elsewhere = {
        "relations", "direction", "standard_deviation", "standard_deviation_from_4P0", "situations", "coefficients",
        "A", "H", "B", "G", "back", "checks", "directions", "combinations", "correction", "states", "without",
    }  # fmt: skip
    missing = set()
    for part, command in {
        "structure": "analyze models/kortunov/single_channel.yaml --only structure --cross-check --details",
        "why": "why models/kortunov/single_channel.yaml dW",
        "transform": "transform models/kortunov/single_channel.yaml --to kalman",
    }.items():
        found = json.loads(run(f"obscli {command} --format json", folder))["results"][0][part]
        missing |= {key for key in _keys(found, elsewhere, set()) if not re.search(rf"`(\w+\.)*{key}`", page)}
    periodic = json.loads(
        run("obscli analyze models/textbook/wu.yaml --only structure --format json", folder)
    )
    found = periodic["results"][0]["structure"]
    missing |= {key for key in _keys(found, elsewhere, set()) if not re.search(rf"`(\w+\.)*{key}`", page)}
    assert not missing


@pytest.mark.parametrize(
    ("page", "part", "command", "elsewhere"),
    [
        (
            "measures.md", "measures", "measures models/bagmut/accelerometer.yaml --stage attitude --times 10,50",
            {"states", "quantities", "system", "closed_forms", "units", "options", "measures", "remarks", "direction",
             "coefficients", "not_measured"},
        ),
        (
            "reducible.md", "transform", "transform models/ins_calibration/horizontal.yaml --to stationary --stage stage_2",
            {"A", "H", "S", "coefficients", "checks", "notes", "undecided", "reason"},
        ),
    ],
)  # fmt: skip
def test_every_field_of_the_json_of_a_page_is_explained(page, part, command, elsewhere, folder):
    """Every key, but for names of the file and formulas, and what other pages explain."""
    text = (ROOT / "docs" / page).read_text(encoding="utf-8")
    found = json.loads(run(f"obscli {command} --format json", folder))["results"][0][part]
    assert not {key for key in _keys(found, elsewhere, set()) if not re.search(rf"`(\w+\.)*{key}`", text)}


def _keys(value, elsewhere, named):
    if isinstance(value, list):
        for item in value:
            yield from _keys(item, elsewhere, named)
    if isinstance(value, dict):
        for key, below in value.items():
            yield key
            if key in named and isinstance(below, dict):
                for item in below.values():
                    yield from _keys(item, elsewhere, named)
            elif key not in elsewhere:
                yield from _keys(below, elsewhere, named)


def test_ci_calls_the_test_command_of_the_readme():
    text = README.read_text(encoding="utf-8")
    assert re.search(r"<!-- \.ci/run calls this very line -->\n```sh\n.*pytest.*\n```", text)
    assert "calls this very line" in (ROOT / ".ci" / "run").read_text(encoding="utf-8")
