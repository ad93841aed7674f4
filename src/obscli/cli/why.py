"""``obscli why``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, cast

import typer

from obscli.cli.options import (
    AnalyticOption,
    FixBeforeOption,
    FormatOption,
    FromOption,
    OutputOption,
    OutputsOption,
    SetOption,
    StageOption,
    StrictOption,
    ToOption,
    WithoutOption,
)
from obscli.cli.texts import names, pairs


if TYPE_CHECKING:
    from obscli.pipelines.request import WhyPart


def why(  # noqa: PLR0913 - one parameter an option
    model: Annotated[
        Path, typer.Argument(metavar="MODEL", help="The model file (YAML).", show_default=False)
    ],
    target: Annotated[
        str,
        typer.Argument(
            metavar="TARGET",
            help="A state, a vector of states, a quantity of the file, or a combination such as "
            "'b_g3 + omega*M_g31'.",
            show_default=False,
        ),
    ],
    *,
    form: FormatOption = "terminal",
    output: OutputOption = None,
    stage: StageOption = None,
    settings: SetOption = None,
    fix: FixBeforeOption = None,
    outputs: OutputsOption = None,
    without: WithoutOption = None,
    only: AnalyticOption = None,
    start: FromOption = None,
    stop: ToOption = None,
    details: Annotated[
        bool, typer.Option("--details", help="Show all directions and combinations, long ones in full.")
    ] = False,
    strict: StrictOption = False,
) -> int:
    """Say why a state can be estimated or not, what hides it, and what would make it observable."""
    from obscli.api import why as run  # noqa: PLC0415 - heavy imports inside command bodies
    from obscli.cli.exit_codes import ExitCode  # noqa: PLC0415
    from obscli.cli.output import deliver  # noqa: PLC0415
    from obscli.cli.progress import ProgressLine  # noqa: PLC0415
    from obscli.cli.refusals import refusals  # noqa: PLC0415
    from obscli.pipelines.request import Changes, NumericRequest, WhyRequest  # noqa: PLC0415

    changes = Changes(pairs("--set", settings), pairs("--fix", fix), names(outputs), names(without))
    numeric = NumericRequest(start=start, stop=stop)
    request = WhyRequest(target, tuple(stage or ()), cast("WhyPart | None", only), numeric)
    with refusals(), ProgressLine() as progress:
        report = run(model, request=request, changes=changes, progress=progress)
    deliver(report, form, output, details=details)
    return ExitCode.UNDECIDED if strict and report.undecided else ExitCode.DONE
