"""``obscli measures``."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, cast

import typer

from obscli.cli.errors import CommandError
from obscli.cli.options import (
    FixBeforeOption,
    FormatOption,
    FromOption,
    MeasureScalingOption,
    MeasureStepOption,
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
from obscli.cli.window_options import (
    AdviceOption,
    FrozenOption,
    MuOption,
    ShowOption,
    StackOption,
    WindowOption,
    refuse_with_window,
    refuse_without_window,
    windows_request,
)


if TYPE_CHECKING:
    from obscli.api import MeasuresReport, WindowsReport
    from obscli.pipelines.request import (
        Changes,
        MeasureScaling,
        MeasuresRequest,
        Progress,
        WindowsRequest,
    )


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
    scaling: MeasureScalingOption = None,
    step: MeasureStepOption = None,
    window: WindowOption = None,
    stack: StackOption = "discrete",
    frozen: FrozenOption = True,
    mu: MuOption = "squared",
    advice: AdviceOption = False,
    show: ShowOption = None,
    plot: PlotOption = None,
    details: Annotated[
        bool, typer.Option("--details", help="Show the directions that belong to singular values and modes.")
    ] = False,
    strict: StrictOption = False,
) -> int:
    """Measure how well states and combinations are observable: by the papers' measures and by the noise."""
    from obscli.cli.exit_codes import ExitCode  # noqa: PLC0415 - heavy imports inside command bodies
    from obscli.cli.figures import draw  # noqa: PLC0415
    from obscli.cli.output import deliver  # noqa: PLC0415
    from obscli.cli.progress import ProgressLine  # noqa: PLC0415
    from obscli.cli.refusals import refusals  # noqa: PLC0415
    from obscli.pipelines.request import (  # noqa: PLC0415
        Changes,
        MeasuresRequest,
        NumericRequest,
    )

    changes = Changes(pairs("--set", settings), pairs("--fix", fix), names(outputs), names(without))
    numeric = NumericRequest(start=start, stop=stop)
    request: MeasuresRequest | WindowsRequest
    if window is not None:
        refuse_with_window(
            segments=segments, at=at, times=times, select=select, option=option, threshold=threshold
        )
        looked = windows_request(window, step, stack, mu, scaling, frozen=frozen, advice=advice)
        request = replace(looked, stages=tuple(stage or ()), numeric=numeric, show=names(show))
    else:
        refuse_without_window(stack=stack, frozen=frozen, mu=mu, advice=advice, show=bool(show))
        request = MeasuresRequest(
            stages=tuple(stage or ()),
            at=_instants(at, times),
            select=names(select),
            options=pairs("--option", option),
            thresholds=pairs("--threshold", threshold),
            scaling=cast("MeasureScaling", scaling or "none"),
            numeric=numeric,
            step=step,
            curves=plot is not None,
            segments=segments,
        )
    with refusals(), ProgressLine() as progress:
        report = _run(model, request, changes, progress)
        draw(report, plot, progress)
    deliver(report, form, output, details=details)
    if report.failed:
        return ExitCode.FAILED
    return ExitCode.UNDECIDED if strict and report.undecided else ExitCode.DONE


def _instants(at: str | None, times: list[str] | None) -> tuple[str, ...]:
    if at is not None and times:
        raise CommandError("--at gives one instant, --times several; one of the two")
    return (at,) if at is not None else names(times)


def _run(
    model: Path, request: MeasuresRequest | WindowsRequest, changes: Changes, progress: Progress
) -> MeasuresReport | WindowsReport:
    from obscli.api import measure, windows  # noqa: PLC0415 - heavy
    from obscli.pipelines.request import WindowsRequest  # noqa: PLC0415

    if isinstance(request, WindowsRequest):
        return windows(model, request=request, changes=changes, progress=progress)
    return measure(model, request=request, changes=changes, progress=progress)
