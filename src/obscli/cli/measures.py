"""``obscli measures``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, cast

import typer

from obscli.cli.options import (
    FixBeforeOption,
    FormatOption,
    FromOption,
    MeasureScalingOption,
    OutputOption,
    OutputsOption,
    PlotOption,
    SegmentsOption,
    SetOption,
    StageOption,
    StrictOption,
    TimesOption,
    ToOption,
    WithoutOption,
)
from obscli.cli.texts import names, pairs


if TYPE_CHECKING:
    from obscli.pipelines.request import MeasureScaling


def measures(  # noqa: PLR0913 - one parameter an option
    model: Annotated[
        Path, typer.Argument(metavar="MODEL", help="The model file (YAML).", show_default=False)
    ],
    *,
    form: FormatOption = "terminal",
    output: OutputOption = None,
    stage: StageOption = None,
    segments: SegmentsOption = False,
    settings: SetOption = None,
    fix: FixBeforeOption = None,
    outputs: OutputsOption = None,
    without: WithoutOption = None,
    at: Annotated[
        str | None,
        typer.Option(
            "--at", metavar="T", help="The instant; an expression will do. Default: the end of the interval."
        ),
    ] = None,
    times: TimesOption = None,
    start: FromOption = None,
    stop: ToOption = None,
    select: Annotated[
        list[str] | None,
        typer.Option(
            "--select", metavar="KEY,…", help="Only these measures, by their keys in JSON (repeatable)."
        ),
    ] = None,
    option: Annotated[
        list[str] | None,
        typer.Option(
            "--option",
            metavar="KEY.NAME=VALUE",
            help="An option of a measure, least-squares.dt=1 (repeatable).",
        ),
    ] = None,
    threshold: Annotated[
        list[str] | None,
        typer.Option(
            "--threshold",
            metavar="KEY=VALUE",
            help="Hold every state against a value of a measure; exit code 1 where one misses (repeatable).",
        ),
    ] = None,
    scaling: MeasureScalingOption = "none",
    step: Annotated[
        float | None,
        typer.Option("--step", metavar="S", help="Time between samples, where the file does not say."),
    ] = None,
    plot: PlotOption = None,
    details: Annotated[
        bool, typer.Option("--details", help="Show the directions that belong to singular values and modes.")
    ] = False,
    strict: StrictOption = False,
) -> int:
    """Measure how well states and combinations are observable: by the papers' measures and by the noise."""
    from obscli.api import measure as run  # noqa: PLC0415 - heavy imports inside command bodies
    from obscli.cli.errors import CommandError  # noqa: PLC0415
    from obscli.cli.exit_codes import ExitCode  # noqa: PLC0415
    from obscli.cli.figures import draw  # noqa: PLC0415
    from obscli.cli.output import deliver  # noqa: PLC0415
    from obscli.cli.progress import ProgressLine  # noqa: PLC0415
    from obscli.cli.refusals import refusals  # noqa: PLC0415
    from obscli.pipelines.request import Changes, MeasuresRequest, NumericRequest  # noqa: PLC0415

    if at is not None and times:
        raise CommandError("--at gives one instant, --times several; one of the two")
    changes = Changes(pairs("--set", settings), pairs("--fix", fix), names(outputs), names(without))
    request = MeasuresRequest(
        stages=tuple(stage or ()),
        at=(at,) if at is not None else names(times),
        select=names(select),
        options=pairs("--option", option),
        thresholds=pairs("--threshold", threshold),
        scaling=cast("MeasureScaling", scaling),
        numeric=NumericRequest(start=start, stop=stop),
        step=step,
        curves=plot is not None,
        segments=segments,
    )
    with refusals(), ProgressLine() as progress:
        report = run(model, request=request, changes=changes, progress=progress)
        draw(report, plot, progress)
    deliver(report, form, output, details=details)
    if report.failed:
        return ExitCode.FAILED
    return ExitCode.UNDECIDED if strict and report.undecided else ExitCode.DONE
