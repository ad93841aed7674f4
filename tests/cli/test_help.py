"""Help names everything there is, and costs no heavy import."""

import subprocess
import sys

import pytest


GRAMIAN = ["--from", "--to", "--samples", "--times", "--gramian", "--rtol", "--scaling", "--plot"]
ANALYZE = [
    *GRAMIAN,
    "--format",
    "--output",
    "--stage",
    "--set",
    "--fix",
    "--outputs",
    "--without",
    "--basis",
    "--pivot-order",
    "--no-critical",
    "--details",
    "--only",
    "--strict",
]
VERIFY = [
    *GRAMIAN,
    "--certificate",
    "--claims",
    "--claim",
    "--stage",
    "--set",
    "--format",
    "--output",
    "--details",
    "--strict",
]
HEAVY = (
    "numpy",
    "scipy",
    "sympy",
    "matplotlib",
    "flint",
    "yaml",
    "rich.console",
    "obscli.exact.analysis",
    "obscli.numeric",
)


@pytest.mark.parametrize(("command", "options"), [("analyze", ANALYZE), ("verify", VERIFY)])
def test_help_lists_every_option(obscli, command, options):
    outcome = obscli(command, "--help")

    assert outcome.status == 0
    assert [option for option in options if option not in outcome.out] == []


def test_help_lists_every_command(obscli):
    outcome = obscli("--help")

    assert outcome.status == 0
    assert all(command in outcome.out for command in ("analyze", "verify", "model"))


@pytest.mark.parametrize("command", ["list", "show", "check"])
def test_model_has_its_commands(obscli, command):
    assert command in obscli("model", "--help").out


def test_version_is_the_project_s(obscli):
    import tomllib
    from pathlib import Path

    project = tomllib.loads((Path(__file__).parents[2] / "pyproject.toml").read_text())["project"]

    assert obscli("--version").out == f"obscli {project['version']}\n"


def test_help_imports_nothing_heavy():
    code = (
        "import sys\nfrom obscli.cli.boundary import main\nmain(['analyze', '--help'])\n"
        f"sys.exit(str([name for name in {HEAVY!r} if name in sys.modules] or ''))"
    )

    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)

    assert done.stderr.strip() == ""


def test_importing_obscli_imports_nothing_heavy():
    code = f"import sys, obscli\nsys.exit(str([n for n in {(*HEAVY, 'typer')!r} if n in sys.modules] or ''))"

    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)

    assert done.stderr.strip() == ""
