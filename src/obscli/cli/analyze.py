"""``obscli analyze``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from obscli.cli.options import (
    BasisOption,
    DetailsOption,
    FixOption,
    FormatOption,
    NoCriticalOption,
    OnlyOption,
    OutputOption,
    OutputsOption,
    PivotOption,
    SetOption,
    StageOption,
    StrictOption,
    WithoutOption,
)
from obscli.cli.texts import names, pairs


def analyze(  # noqa: PLR0913 - one parameter an option
    model: Annotated[
        Path, typer.Argument(metavar="MODEL", help="The model file (YAML).", show_default=False)
    ],
    *,
    form: FormatOption = "terminal",
    output: OutputOption = None,
    stage: StageOption = None,
    settings: SetOption = None,
    fix: FixOption = None,
    outputs: OutputsOption = None,
    without: WithoutOption = None,
    basis: BasisOption = "echelon",
    pivot_order: PivotOption = None,
    no_critical: NoCriticalOption = False,
    details: DetailsOption = False,
    only: OnlyOption = None,
    strict: StrictOption = False,
) -> int:
    """Find exactly which combinations of the states are observable, stage by stage."""
    from obscli.api import analyze as run  # noqa: PLC0415 - heavy imports inside command bodies
    from obscli.cli.exit_codes import ExitCode  # noqa: PLC0415
    from obscli.cli.output import deliver  # noqa: PLC0415
    from obscli.cli.progress import ProgressLine  # noqa: PLC0415
    from obscli.cli.refusals import refusals  # noqa: PLC0415
    from obscli.pipelines.request import AnalyzeRequest, Changes  # noqa: PLC0415

    del only  # checked by its option; there is one pipeline so far
    changes = Changes(pairs("--set", settings), pairs("--fix", fix), names(outputs), names(without))
    request = AnalyzeRequest(
        stages=tuple(stage or ()),
        basis="sparse" if basis == "sparse" else "echelon" if basis == "echelon" else Path(basis),
        pivot_order=names(pivot_order),
        critical=not no_critical,
    )
    with refusals(), ProgressLine() as progress:
        report = run(model, request=request, changes=changes, progress=progress)
    deliver(report, form, output, details=details)
    return ExitCode.UNDECIDED if strict and report.undecided else ExitCode.DONE
