"""``obscli plan``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from obscli.cli.options import (
    FormatOption,
    MoreOption,
    OrdersOption,
    OutputOption,
    OutputsOption,
    PlotOption,
    RunFixOption,
    RunOption,
    RunSamplesOption,
    ScalingOption,
    SetOption,
    StepErrorOption,
    StrictOption,
    WithoutOption,
)
from obscli.cli.texts import names, pairs


def plan(  # noqa: PLR0913 - one parameter an option
    model: Annotated[
        Path, typer.Argument(metavar="MODEL", help="The model file (YAML).", show_default=False)
    ],
    *,
    form: FormatOption = "terminal",
    output: OutputOption = None,
    run: RunOption = None,
    segments: OrdersOption = False,
    settings: SetOption = None,
    fix: RunFixOption = None,
    outputs: OutputsOption = None,
    without: WithoutOption = None,
    details: MoreOption = False,
    samples: RunSamplesOption = None,
    rtol: StepErrorOption = None,
    scaling: ScalingOption = None,
    plot: PlotOption = None,
    strict: StrictOption = False,
) -> int:
    """Choose among candidate runs: the smallest sets that determine most, ranked, and how long each run."""
    from obscli.api import plan as run_pipeline  # noqa: PLC0415 - heavy imports inside command bodies
    from obscli.cli.exit_codes import ExitCode  # noqa: PLC0415
    from obscli.cli.figures import draw  # noqa: PLC0415
    from obscli.cli.numeric import numeric_request  # noqa: PLC0415
    from obscli.cli.output import deliver  # noqa: PLC0415
    from obscli.cli.progress import ProgressLine  # noqa: PLC0415
    from obscli.cli.refusals import refusals  # noqa: PLC0415
    from obscli.pipelines.request import Changes, PlanRequest  # noqa: PLC0415

    numeric = numeric_request(
        start=None, stop=None, samples=samples, times=None, method="square-root", rtol=rtol, scaling=scaling
    )
    changes = Changes(pairs("--set", settings), pairs("--fix", fix), names(outputs), names(without))
    request = PlanRequest(runs=tuple(run or ()), numeric=numeric, segments=segments)
    with refusals(), ProgressLine() as progress:
        report = run_pipeline(model, request=request, changes=changes, progress=progress)
        draw(report, plot, progress)
    deliver(report, form, output, details=details, figures=True)
    if report.failed:
        return ExitCode.FAILED
    return ExitCode.UNDECIDED if strict and report.undecided else ExitCode.DONE
