"""``obscli verify``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from obscli.cli.errors import CommandError
from obscli.cli.options import (
    CheckFormatOption,
    DetailsOption,
    FromOption,
    GramianOption,
    OutputOption,
    PlotOption,
    RtolOption,
    SamplesOption,
    ScalingOption,
    SetOption,
    StageOption,
    StrictOption,
    TimesOption,
    ToOption,
)
from obscli.cli.texts import pairs


if TYPE_CHECKING:
    from obscli.core.report import Report
    from obscli.model.system import Model
    from obscli.pipelines.request import NumericRequest, Progress


def verify(  # noqa: PLR0913 - one parameter an option
    models: Annotated[
        list[Path] | None,
        typer.Argument(metavar="MODEL", help="Model files. Default: every model under ./models, else here."),
    ] = None,
    *,
    certificate: Annotated[
        Path | None,
        typer.Option(
            "--certificate", metavar="FILE", help="Check the certificates in a JSON report of analyze."
        ),
    ] = None,
    claims: Annotated[
        Path | None,
        typer.Option("--claims", metavar="FILE", help="Check the claims in FILE instead of the model's own."),
    ] = None,
    claim: Annotated[
        list[str] | None,
        typer.Option(
            "--claim",
            metavar="TEXT",
            help="Check only that this combination is observable (repeatable).",
        ),
    ] = None,
    stage: StageOption = None,
    settings: SetOption = None,
    form: CheckFormatOption = "terminal",
    output: OutputOption = None,
    details: DetailsOption = False,
    start: FromOption = None,
    stop: ToOption = None,
    samples: SamplesOption = None,
    times: TimesOption = None,
    gramian: GramianOption = "square-root",
    rtol: RtolOption = None,
    scaling: ScalingOption = None,
    plot: PlotOption = None,
    strict: StrictOption = False,
) -> int:
    """Check the proof of the rank and everything that models claim and expect, by algebra and Gramian."""
    from obscli.cli.exit_codes import ExitCode  # noqa: PLC0415 - heavy imports inside command bodies
    from obscli.cli.figures import draw  # noqa: PLC0415
    from obscli.cli.numeric import forbid_numeric, numeric_request  # noqa: PLC0415
    from obscli.cli.output import deliver  # noqa: PLC0415
    from obscli.cli.progress import ProgressLine  # noqa: PLC0415
    from obscli.cli.refusals import refusals  # noqa: PLC0415

    stages = tuple(stage or ())
    files = tuple(models or ()) or _models_here()
    if (certificate or claims) and len(files) != 1:
        raise CommandError(
            f"--{'certificate' if certificate else 'claims'} is about one model; {len(files)} are given"
        )
    if certificate and (claims or claim or settings):
        raise CommandError(
            "--certificate checks the certificates of a report only; leave out --claims, --claim and --set"
        )
    numeric = numeric_request(
        start=start, stop=stop, samples=samples, times=times, method=gramian, rtol=rtol, scaling=scaling
    )
    if certificate:
        forbid_numeric(numeric, plot, "--certificate")
    with refusals(), ProgressLine() as progress:
        if certificate:
            report = _certificates(files[0], certificate, stages, progress)
        else:
            read = _read(files, claims, pairs("--set", settings))
            report = _claims(read, stages, tuple(claim or ()), numeric, progress)
        draw(report, plot, progress)
    deliver(report, form, output, details=details)
    if report.failed:
        return ExitCode.FAILED
    return ExitCode.UNDECIDED if strict and report.undecided else ExitCode.DONE


def _models_here() -> tuple[Path, ...]:
    from obscli.model.library import models_here  # noqa: PLC0415

    here = Path()
    files = models_here(here)
    if not files:
        raise CommandError(f"no models under {here / 'models'} nor in the current directory; name a MODEL")
    return files


def _read(files: tuple[Path, ...], claims: Path | None, settings: dict[str, str]) -> list[Model]:
    """Read all models; the problems of all files are reported together."""
    from obscli.api import load  # noqa: PLC0415
    from obscli.core.place import ModelError, Problem  # noqa: PLC0415
    from obscli.pipelines.reading import with_claims  # noqa: PLC0415

    models: list[Model] = []
    problems: list[Problem] = []
    for file in files:
        try:
            models.append(load(file, settings=settings))
        except ModelError as error:
            problems += error.problems
    if problems:
        raise ModelError(problems)
    return [with_claims(model, claims) for model in models] if claims else models


def _claims(
    models: list[Model],
    stages: tuple[str, ...],
    texts: tuple[str, ...],
    numeric: NumericRequest,
    progress: Progress,
) -> Report:
    from obscli.api import verify as run  # noqa: PLC0415

    return run(*models, stages=stages, claims=texts, numeric=numeric, progress=progress)


def _certificates(file: Path, certificate: Path, stages: tuple[str, ...], progress: Progress) -> Report:
    from obscli.cli.json_file import read_json  # noqa: PLC0415
    from obscli.pipelines.reading import load  # noqa: PLC0415
    from obscli.pipelines.verify_certificate import recorded_changes, verify_certificates  # noqa: PLC0415

    data = read_json(certificate)
    return verify_certificates(load(file, recorded_changes(data)), data, stages, progress)
