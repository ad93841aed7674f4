"""The application: its commands, one file each."""

from __future__ import annotations

from typing import Annotated

import typer

from obscli.cli.analyze import analyze
from obscli.cli.calibrate import calibrate
from obscli.cli.measures import measures
from obscli.cli.model import model_app
from obscli.cli.plan import plan
from obscli.cli.simulate import simulate
from obscli.cli.transform import transform
from obscli.cli.verify import verify
from obscli.cli.why import why


SETTINGS = {"help_option_names": ["-h", "--help"], "max_content_width": 100}

app = typer.Typer(
    help="Which linear combinations of the states of x' = A(t)x, y = H(t)x are observable, with proof.",
    epilog="Exit codes: 0 done, 1 a check failed, 2 usage or model file, 3 internal error, "
    "4 undecided (with --strict), 130 interrupted.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    context_settings=SETTINGS,
)
app.command("analyze")(analyze)
app.command("verify")(verify)
app.command("calibrate")(calibrate)
app.command("plan")(plan)
app.command("measures")(measures)
app.command("simulate")(simulate)
app.command("transform")(transform)
app.command("why")(why)
app.add_typer(model_app, name="model")


def _print_version(wanted: bool) -> None:  # noqa: FBT001 - the signature of an option's callback
    if wanted:
        from obscli.core.version import VERSION  # noqa: PLC0415

        typer.echo(f"obscli {VERSION}")
        raise typer.Exit


@app.callback()
def root(
    *,
    _version: Annotated[
        bool,
        typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version and exit."),
    ] = False,
) -> None:
    """Which linear combinations of the states of x' = A(t)x, y = H(t)x are observable, with proof."""
