"""``obscli transform``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, cast

import typer

from obscli.cli.errors import CommandError
from obscli.cli.options import (
    DropOption,
    EquationsOption,
    FixBeforeOption,
    FormatOption,
    FormBasisOption,
    MadeOption,
    OutputsOption,
    PivotOption,
    SetOption,
    StageOption,
    StrictOption,
    TargetOption,
    WithoutOption,
)
from obscli.cli.texts import names, pairs


if TYPE_CHECKING:
    from typing import Literal

    from obscli.pipelines.request import Target


def transform(  # noqa: PLR0913 - one parameter an option
    model: Annotated[
        Path, typer.Argument(metavar="MODEL", help="The model file (YAML).", show_default=False)
    ],
    *,
    to: TargetOption = None,
    drop: DropOption = False,
    output: MadeOption = None,
    form: FormatOption = "terminal",
    stage: StageOption = None,
    settings: SetOption = None,
    fix: FixBeforeOption = None,
    outputs: OutputsOption = None,
    without: WithoutOption = None,
    basis: FormBasisOption = "echelon",
    pivot_order: PivotOption = None,
    details: EquationsOption = False,
    strict: StrictOption = False,
) -> int:
    """Make a model of what is observable, the Kalman decomposition, a stationary one, or without some states.

    The report goes to standard output, the model to the file named by -o; the model is read back and checked.
    """
    from obscli.api import transform as run  # noqa: PLC0415 - heavy imports inside command bodies
    from obscli.cli.boundary import complain  # noqa: PLC0415
    from obscli.cli.exit_codes import ExitCode  # noqa: PLC0415
    from obscli.cli.output import deliver, write  # noqa: PLC0415
    from obscli.cli.progress import ProgressLine  # noqa: PLC0415
    from obscli.cli.refusals import refusals  # noqa: PLC0415
    from obscli.pipelines.request import Changes, TransformRequest  # noqa: PLC0415

    if drop == (to is not None):
        raise CommandError("say what to make: --to observable, --to kalman, --to stationary, or --drop")
    if basis != "echelon" and to != "observable":
        raise CommandError(f"--basis {basis} is about --to observable")
    changes = Changes(pairs("--set", settings), pairs("--fix", fix), names(outputs), names(without))
    request = TransformRequest(
        to=cast("Target", to or "drop"),
        stages=tuple(stage or ()),
        basis=cast("Literal['echelon', 'sparse']", basis),
        pivot_order=names(pivot_order),
        one=output is not None,
    )
    with refusals(), ProgressLine() as progress:
        report = run(model, request=request, changes=changes, progress=progress)
    deliver(report, form, None, details=details)
    made = report.text
    if output is not None and made and not report.failed:
        write(made, output)
    elif output is not None:
        complain(f"obscli: --output {output}: nothing is written, see the report")
        strict = True
    if report.failed or (output is not None and not made and not report.undecided):
        return ExitCode.FAILED
    return ExitCode.UNDECIDED if strict and report.undecided else ExitCode.DONE
