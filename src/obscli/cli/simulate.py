"""``obscli simulate``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from obscli.cli.errors import CommandError
from obscli.cli.options import (
    DetailsAllOption,
    FixBeforeOption,
    FormatOption,
    FractionOption,
    FromOption,
    HistoryOption,
    OutputOption,
    OutputsOption,
    PlotOption,
    RandomRunsOption,
    RecordedOption,
    SeedOption,
    SegmentsOption,
    SetOption,
    StageOption,
    StepOption,
    StrictOption,
    ToOption,
    WithoutOption,
)
from obscli.cli.texts import assignments, names, pairs


def simulate(  # noqa: PLR0913 - one parameter an option
    model: Annotated[
        Path | None, typer.Argument(metavar="MODEL", help="The model file (YAML).", show_default=False)
    ] = None,
    *,
    form: FormatOption = "terminal",
    output: OutputOption = None,
    stage: StageOption = None,
    segments: SegmentsOption = False,
    settings: SetOption = None,
    fix: FixBeforeOption = None,
    outputs: OutputsOption = None,
    without: WithoutOption = None,
    start: FromOption = None,
    stop: ToOption = None,
    step: StepOption = None,
    samples: RecordedOption = 500,
    runs: RandomRunsOption = 0,
    seed: SeedOption = 0,
    truth: Annotated[
        Path | None,
        typer.Option(
            "--truth", metavar="FILE", help="The same as MODEL, beside --filter.", show_default=False
        ),
    ] = None,
    design: Annotated[
        Path | None,
        typer.Option(
            "--filter",
            metavar="FILE",
            help="Run the filter designed on this model on MODEL: what it claims, and its true errors. "
            "Changes such as --set are made to MODEL only.",
            show_default=False,
        ),
    ] = None,
    initial: Annotated[
        list[str] | None,
        typer.Option(
            "--initial",
            metavar="STATE=EXPRESSION,…",
            help="An error at the start: the mean response of the filter to it, without noise (repeatable).",
        ),
    ] = None,
    correction: Annotated[
        str | None,
        typer.Option(
            "--correction",
            metavar="output|feedback",
            help="Correct the output by the estimate, or feed it back after each sample and start from zero.",
            show_default="output",
        ),
    ] = None,
    feedback: Annotated[
        list[str] | None,
        typer.Option(
            "--feedback",
            metavar="STATE,…",
            help="Feed back the estimates of these states or vectors only; sigma>C: only while their "
            "equivalent singular value is above C; sigma<C: while their deviation is below C of its prior.",
        ),
    ] = None,
    fraction: FractionOption = 0.1,
    history: HistoryOption = None,
    plot: PlotOption = None,
    details: DetailsAllOption = False,
    strict: StrictOption = False,
) -> int:
    """Run the Kalman filter's covariance along the interval: how well each state is known, from when on."""
    from obscli.api import load  # noqa: PLC0415 - heavy imports inside command bodies
    from obscli.api import simulate as run  # noqa: PLC0415
    from obscli.cli.exit_codes import ExitCode  # noqa: PLC0415
    from obscli.cli.figures import draw  # noqa: PLC0415
    from obscli.cli.history_file import check_history, save_history  # noqa: PLC0415
    from obscli.cli.output import deliver  # noqa: PLC0415
    from obscli.cli.progress import ProgressLine  # noqa: PLC0415
    from obscli.cli.refusals import refusals  # noqa: PLC0415
    from obscli.pipelines.request import Changes, NumericRequest, SimulateRequest  # noqa: PLC0415

    file = _truth(model, truth, design)
    check_history(history)
    changes = Changes(pairs("--set", settings), pairs("--fix", fix), names(outputs), names(without))
    request = SimulateRequest(
        stages=tuple(stage or ()),
        step=step,
        recorded=samples,
        runs=runs,
        seed=seed,
        fraction=fraction,
        segments=segments,
        initial=tuple(assignments("--initial", initial).items()),
        feedback=_feedback(correction, feedback),
        numeric=NumericRequest(start=start, stop=stop),
    )
    with refusals(), ProgressLine() as progress:
        other = None if design is None else load(design)
        report = run(file, request=request, changes=changes, progress=progress, design=other)
        draw(report, plot, progress)
        save_history(report, history)
    deliver(report, form, output, details=details, figures=True)
    if report.interrupted:
        return ExitCode.INTERRUPTED
    if not report.simulated:
        return ExitCode.USAGE
    if report.failed:
        return ExitCode.FAILED
    return ExitCode.UNDECIDED if strict and report.undecided else ExitCode.DONE


def _feedback(correction: str | None, given: list[str] | None) -> tuple[str, ...] | None:
    """Return what is to be fed back, None: nothing.

    Raises
    ------
    CommandError
        where states are named though nothing is to be fed back, or the correction is neither
    """
    if correction not in (None, "output", "feedback"):
        raise CommandError(f"--correction {correction}: expected output or feedback")
    if given is not None and correction == "output":
        raise CommandError("--feedback with --correction output, which feeds nothing back; leave one out")
    if given is None and correction != "feedback":
        return None
    return names(given)


def _truth(model: Path | None, truth: Path | None, design: Path | None) -> Path:
    """Return the file of the system that is simulated.

    Raises
    ------
    CommandError
        where it is named twice or not at all
    """
    if truth is not None and design is None:
        raise CommandError("--truth without --filter: name the filter's model too, or give MODEL alone")
    if truth is not None and model is not None:
        raise CommandError(f"{model} and --truth {truth} both name the truth; leave one out")
    file = truth or model
    if file is None:
        raise CommandError("no model: give MODEL, or --truth FILE and --filter FILE")
    return file
