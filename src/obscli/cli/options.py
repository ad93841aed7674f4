"""Options shared by commands, each declared once."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Final, TypeAlias

import typer

from obscli.render.formats import FORMATS


FORMAT_NAMES: Final = tuple(one.name for one in FORMATS)
ONLY: Final = ("analytic", "numeric", "verify", "structure")
METHODS: Final = ("square-root", "lyapunov", "quadrature", "lift")
TARGETS: Final = ("observable", "kalman", "stationary")
BASES: Final = ("echelon", "sparse")
SCALINGS: Final = ("automatic", "scale", "prior", "none")
MEASURE_SCALINGS: Final = ("none", "prior", "scale")


def _one_of(names: tuple[str, ...], given: str) -> str:
    if given not in names:
        raise typer.BadParameter(f"{given!r} is not one of {', '.join(names)}")
    return given


def _known_format(given: str) -> str:
    return _one_of(FORMAT_NAMES, given)


def _known_check_format(given: str) -> str:
    return _one_of(("terminal", "json"), given)


def _known_pipeline(given: str | None) -> str | None:
    return None if given is None else _one_of(ONLY, given)


def _known_part(given: str | None) -> str | None:
    return None if given is None else _one_of(("analytic",), given)


def _known_target(given: str | None) -> str | None:
    return None if given is None else _one_of(TARGETS, given)


def _known_basis(given: str) -> str:
    return _one_of(BASES, given)


def _known_method(given: str) -> str:
    return _one_of(METHODS, given)


def _known_scaling(given: str | None) -> str | None:
    return None if given is None else _one_of(SCALINGS, given)


def _known_units(given: str | None) -> str | None:
    return None if given is None else _one_of(MEASURE_SCALINGS, given)


def _step_error(given: float | None) -> float | None:
    if given is not None and not 1e-16 < given < 0.1:
        raise typer.BadParameter(f"{given:g} is no step error: between 1e-16 and 0.1")
    return given


def _positive(given: float | None) -> float | None:
    if given is not None and not 0 < given < float("inf"):
        raise typer.BadParameter(f"{given:g} is no time between samples: it must be positive")
    return given


def _directory(given: Path | None) -> Path | None:
    for one in () if given is None else (given, *given.parents):
        if one.is_file():
            raise typer.BadParameter(f"{one} is a file; name a directory for the figures")
    return given


def _fraction(given: float) -> float:
    if not 0 < given < 1:
        raise typer.BadParameter(f"{given:g} is no part of a deviation: between 0 and 1")
    return given


FormatOption: TypeAlias = Annotated[
    str,
    typer.Option("--format", callback=_known_format, metavar="|".join(FORMAT_NAMES), help="Output format."),
]
CheckFormatOption: TypeAlias = Annotated[
    str,
    typer.Option("--format", callback=_known_check_format, metavar="terminal|json", help="Output format."),
]
OutputOption: TypeAlias = Annotated[
    Path | None,
    typer.Option("--output", metavar="FILE", help="Write the report to FILE instead of standard output."),
]
StageOption: TypeAlias = Annotated[
    list[str] | None,
    typer.Option("--stage", metavar="NAME", help="Only this stage (repeatable). Default: every stage."),
]
SetOption: TypeAlias = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="NAME=VALUE", help="Change a parameter's nominal value (repeatable)."),
]
FixOption: TypeAlias = Annotated[
    list[str] | None,
    typer.Option(
        "--fix",
        metavar="NAME=EXPRESSION",
        help="Substitute exactly, e.g. omega_ie=0 to neglect a small term; the report says what that changes "
        "(repeatable).",
    ),
]
OutputsOption: TypeAlias = Annotated[
    list[str] | None,
    typer.Option("--outputs", metavar="A,B", help="Use only these outputs."),
]
WithoutOption: TypeAlias = Annotated[
    list[str] | None,
    typer.Option("--without", metavar="STATE,…", help="Leave these states out (repeatable)."),
]
BasisOption: TypeAlias = Annotated[
    str,
    typer.Option(
        "--basis",
        metavar="echelon|sparse|FILE",
        help="Form of the combinations: reduced echelon in the order of the states, as few states as "
        "possible, or the rows of FILE (a YAML list of combinations) completed to a basis.",
    ),
]
PivotOption: TypeAlias = Annotated[
    list[str] | None,
    typer.Option("--pivot-order", metavar="STATE,…", help="States to solve for first in the echelon basis."),
]
NoCriticalOption: TypeAlias = Annotated[
    bool,
    typer.Option("--no-critical", help="Do not search for parameter values at which the rank drops."),
]
TargetOption: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--to",
        callback=_known_target,
        metavar="|".join(TARGETS),
        help="The observable combinations as states, the coordinates in which what outputs see and inputs "
        "reach stands apart, or a time-invariant system with the same outputs.",
    ),
]
DropOption: TypeAlias = Annotated[
    bool,
    typer.Option("--drop", help="Instead: leave out the states that cannot be estimated, as if zero."),
]
MadeOption: TypeAlias = Annotated[
    Path | None,
    typer.Option(
        "-o",
        "--output",
        metavar="FILE",
        help="Write the model made to FILE (YAML); the report goes to standard output all the same.",
    ),
]
FixBeforeOption: TypeAlias = Annotated[
    list[str] | None,
    typer.Option(
        "--fix",
        metavar="NAME=EXPRESSION",
        help="Substitute exactly before, e.g. omega_ie=0 to neglect a small term (repeatable).",
    ),
]
EquationsOption: TypeAlias = Annotated[
    bool,
    typer.Option("--details", help="Show the equations also where no state is new."),
]
FormBasisOption: TypeAlias = Annotated[
    str,
    typer.Option(
        "--basis",
        callback=_known_basis,
        metavar="|".join(BASES),
        help="Form of the observable combinations: reduced echelon in the order of the states, or as few "
        "states in each as possible.",
    ),
]
DetailsOption: TypeAlias = Annotated[
    bool,
    typer.Option("--details", help="Show the certificate, its assumptions, and what was not searched."),
]
DualOption: TypeAlias = Annotated[
    bool,
    typer.Option(
        "--dual",
        help="Controllability instead: the same analysis of the dual system, for what the inputs reach (`B`, "
        "else the disturbances, `G`).",
    ),
]
FrozenOption: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--frozen-at",
        metavar="T",
        help="Take A and H as constant, as they are at this instant; the report says where the true rank "
        "differs.",
    ),
]
OnlyOption: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--only",
        callback=_known_pipeline,
        metavar="|".join(ONLY),
        help="Exact algebra alone, the Gramian alone (no algebra), only how the two compare, or only how the "
        "unobservable subspace moves.",
    ),
]
MoreOption: TypeAlias = Annotated[
    bool,
    typer.Option("--details", help="Show every instant, every combination, and what was tried."),
]
StepErrorOption: TypeAlias = Annotated[
    float | None,
    typer.Option(
        "--rtol",
        callback=_step_error,
        metavar="X",
        help="Relative step error of the Gramians. Default: 1e-14.",
    ),
]
RunFixOption: TypeAlias = Annotated[
    list[str] | None,
    typer.Option(
        "--fix",
        metavar="NAME=EXPRESSION",
        help="Substitute exactly in every run, e.g. omega_ie=0 (repeatable).",
    ),
]
RunSamplesOption: TypeAlias = Annotated[
    int | None,
    typer.Option(
        "--samples",
        min=1,
        max=100_000,
        metavar="N",
        help="Number of instants at which Gramians are looked at.",
    ),
]
RunOption: TypeAlias = Annotated[
    list[str] | None,
    typer.Option("--run", metavar="NAME", help="Only this run (repeatable). Default: every run."),
]
AnalyticOption: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--only", callback=_known_part, metavar="analytic", help="Exact algebra alone, without Gramians."
    ),
]
FromOption: TypeAlias = Annotated[
    str | None,
    typer.Option("--from", metavar="T0", help="Start of the interval of the Gramian, instead of the file's."),
]
ToOption: TypeAlias = Annotated[
    str | None,
    typer.Option("--to", metavar="T", help="End of the interval; an expression such as 2*pi/omega will do."),
]
SamplesOption: TypeAlias = Annotated[
    int | None,
    typer.Option("--samples", min=1, max=100_000, metavar="N", help="Number of instants in the interval."),
]
TimesOption: TypeAlias = Annotated[
    list[str] | None,
    typer.Option("--times", metavar="T1,T2,…", help="Exactly these instants (repeatable)."),
]
GramianOption: TypeAlias = Annotated[
    str,
    typer.Option(
        "--gramian",
        callback=_known_method,
        metavar="|".join(METHODS),
        help="Its square root by QR (well-conditioned), its differential equation as in the papers, its "
        "definition summed, or by matrix exponentials of a stationary system (where it is reducible to one).",
    ),
]
RtolOption: TypeAlias = Annotated[
    float | None,
    typer.Option(
        "--rtol",
        callback=_step_error,
        metavar="X",
        help="Relative step error. Default: 1e-14; lyapunov 1e-10.",
    ),
]
ScalingOption: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--scaling",
        callback=_known_scaling,
        metavar="|".join(SCALINGS),
        help="Units of the states in which the rank is decided. Default: the file's `scale` if it gives all, "
        "else automatic.",
    ),
]
MeasureScalingOption: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--scaling",
        callback=_known_units,
        metavar="|".join(MEASURE_SCALINGS),
        help="Units of the states: as the file gives them (default), the prior's standard deviations "
        "(default with --window), or `scale`.",
    ),
]
PlotOption: TypeAlias = Annotated[
    Path | None,
    typer.Option("--plot", callback=_directory, metavar="DIR", help="Draw figures into DIR, as SVG and PNG."),
]
CrossCheckOption: TypeAlias = Annotated[
    bool,
    typer.Option(
        "--cross-check",
        help="Solve the Riccati equation of the Kalman filter from P0 and 4 P0: where what is hidden dies "
        "out, both end alike. Needs `noise` in the file.",
    ),
]
CertifyOption: TypeAlias = Annotated[
    bool,
    typer.Option(
        "--certify",
        help="Prove the rank of the Gramian at instants (--times; a few of the interval) in ball arithmetic, "
        "where the system is reducible to a stationary one.",
    ),
]
SegmentsOption: TypeAlias = Annotated[
    bool,
    typer.Option(
        "--segments", help="Only the segments of the file, one after the other, the state carried through."
    ),
]
OrdersOption: TypeAlias = Annotated[
    bool,
    typer.Option(
        "--segments",
        help="Instead: the shortest orders of the file's segments, the state carried through.",
    ),
]
StrictOption: TypeAlias = Annotated[
    bool,
    typer.Option("--strict", help="Exit with code 4 where something stays undecided."),
]
StepOption: TypeAlias = Annotated[
    float | None,
    typer.Option(
        "--step",
        callback=_positive,
        metavar="S",
        help="Time between samples of the outputs without `every`, in place of the file's `step`.",
    ),
]
MeasureStepOption: TypeAlias = Annotated[
    float | None,
    typer.Option(
        "--step",
        callback=_positive,
        metavar="S",
        help="Time between samples, where the file does not say; with --window also between windows.",
    ),
]
RecordedOption: TypeAlias = Annotated[
    int,
    typer.Option("--samples", min=2, max=100_000, metavar="N", help="Number of instants in the histories."),
]
RandomRunsOption: TypeAlias = Annotated[
    int,
    typer.Option(
        "--runs", min=0, max=100_000, metavar="N", help="Monte Carlo: so many runs with random errors."
    ),
]
SeedOption: TypeAlias = Annotated[
    int, typer.Option("--seed", min=0, metavar="S", help="Seed of the random errors.")
]
FractionOption: TypeAlias = Annotated[
    float,
    typer.Option(
        "--fraction",
        callback=_fraction,
        metavar="X",
        help="A state counts as observable once its deviation stays below this part of its prior, where the "
        "file requires nothing.",
    ),
]
HistoryOption: TypeAlias = Annotated[
    Path | None,
    typer.Option("--history", metavar="FILE", help="Write the histories to FILE: .csv, .json or .parquet."),
]
DetailsAllOption: TypeAlias = Annotated[
    bool, typer.Option("--details", help="Show the combinations and everything that was simulated.")
]
