"""``obscli analyze``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, cast

import typer

from obscli.cli.options import (
    BasisOption,
    CertifyOption,
    CrossCheckOption,
    DetailsOption,
    DualOption,
    FixOption,
    FormatOption,
    FromOption,
    FrozenOption,
    GramianOption,
    NoCriticalOption,
    OnlyOption,
    OutputOption,
    OutputsOption,
    PivotOption,
    PlotOption,
    RtolOption,
    SamplesOption,
    ScalingOption,
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
    from obscli.pipelines.request import Part


def analyze(  # noqa: PLR0913 - one parameter an option
    model: Annotated[
        Path, typer.Argument(metavar="MODEL", help="The model file (YAML).", show_default=False)
    ],
    *,
    form: FormatOption = "terminal",
    output: OutputOption = None,
    stage: StageOption = None,
    segments: SegmentsOption = False,
    settings: SetOption = None,
    fix: FixOption = None,
    outputs: OutputsOption = None,
    without: WithoutOption = None,
    dual: DualOption = False,
    frozen_at: FrozenOption = None,
    basis: BasisOption = "echelon",
    pivot_order: PivotOption = None,
    no_critical: NoCriticalOption = False,
    details: DetailsOption = False,
    only: OnlyOption = None,
    start: FromOption = None,
    stop: ToOption = None,
    samples: SamplesOption = None,
    times: TimesOption = None,
    gramian: GramianOption = "square-root",
    rtol: RtolOption = None,
    scaling: ScalingOption = None,
    cross_check: CrossCheckOption = False,
    certify: CertifyOption = False,
    plot: PlotOption = None,
    strict: StrictOption = False,
) -> int:
    """Find exactly which combinations of the states are observable, and hold that against the Gramian."""
    from obscli.api import analyze as run  # noqa: PLC0415 - heavy imports inside command bodies
    from obscli.cli.exit_codes import ExitCode  # noqa: PLC0415
    from obscli.cli.figures import draw  # noqa: PLC0415
    from obscli.cli.numeric import forbid_numeric, numeric_request  # noqa: PLC0415
    from obscli.cli.output import deliver  # noqa: PLC0415
    from obscli.cli.progress import ProgressLine  # noqa: PLC0415
    from obscli.cli.refusals import refusals  # noqa: PLC0415
    from obscli.pipelines.request import AnalyzeRequest, Changes  # noqa: PLC0415

    numeric = numeric_request(
        start=start, stop=stop, samples=samples, times=times, method=gramian, rtol=rtol, scaling=scaling
    )
    if only == "analytic":
        forbid_numeric(numeric, plot, "--only analytic")
    changes = Changes(pairs("--set", settings), pairs("--fix", fix), names(outputs), names(without))
    request = AnalyzeRequest(
        stages=tuple(stage or ()),
        basis="sparse" if basis == "sparse" else "echelon" if basis == "echelon" else Path(basis),
        pivot_order=names(pivot_order),
        critical=not no_critical,
        only=cast("Part | None", only),
        numeric=numeric,
        curves=details or plot is not None,
        relations=details,
        cross_check=cross_check,
        dual=dual,
        frozen_at=frozen_at,
        certify=certify,
        segments=segments,
    )
    with refusals(), ProgressLine() as progress:
        report = run(model, request=request, changes=changes, progress=progress)
        draw(report, plot, progress)
    deliver(report, form, output, details=details)
    if report.failed:
        return ExitCode.FAILED
    return ExitCode.UNDECIDED if strict and report.undecided else ExitCode.DONE
