"""``obscli model``: the bundled models, and a check of a model file without analysing it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from obscli.cli.errors import CommandError
from obscli.cli.options import OutputOption


model_app = typer.Typer(
    help="List, print and check model files.",
    no_args_is_help=True,
    rich_markup_mode=None,
    add_completion=False,
)


@model_app.command("list")
def list_models() -> int:
    """List the bundled models."""
    from obscli.cli.output import write  # noqa: PLC0415 - heavy imports inside command bodies
    from obscli.model.library import bundled_models  # noqa: PLC0415

    models = bundled_models()
    if not models:
        raise CommandError("this installation has no bundled models")
    width = max(len(name) for name in models)
    write("".join(f"{name:{width}}  {_title(file)}".rstrip() + "\n" for name, file in models.items()), None)
    return 0


@model_app.command("show")
def show_model(
    name: Annotated[str, typer.Argument(metavar="NAME", help="A name from `obscli model list`.")],
    output: OutputOption = None,
) -> int:
    """Print a bundled model, to read it or to start one's own from (--output FILE)."""
    from obscli.cli.output import write  # noqa: PLC0415
    from obscli.model.library import bundled_model  # noqa: PLC0415

    try:
        file = bundled_model(name)
    except KeyError:
        raise CommandError(f"no bundled model {name!r}; `obscli model list` names them") from None
    write(file.read_text(encoding="utf-8"), output)
    return 0


@model_app.command("check")
def check_models(
    models: Annotated[list[Path], typer.Argument(metavar="MODEL", help="Model files (YAML).")],
) -> int:
    """Read model files and report every problem in them."""
    from obscli.api import load  # noqa: PLC0415
    from obscli.cli.output import write  # noqa: PLC0415
    from obscli.core.place import ModelError, Problem  # noqa: PLC0415
    from obscli.core.visible import visible  # noqa: PLC0415

    problems: list[Problem] = []
    for file in models:
        try:
            model = load(file)
        except ModelError as error:
            problems += error.problems
            continue
        stages = ", ".join(
            f"{system.stage or 'base'} (n = {system.n}, m = {system.m})" for system in model.systems
        )
        write(visible(f"{file}: {stages}") + "\n", None)
    if problems:
        raise ModelError(problems)
    return 0


def _title(file: Path) -> str:
    """Return the title of a bundled model, or nothing where it cannot be read."""
    from obscli.api import load  # noqa: PLC0415
    from obscli.core.place import ModelError  # noqa: PLC0415

    try:
        return load(file).title
    except ModelError:
        return ""
