"""Options of ``obscli measures --window``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Final, TypeAlias, cast

import typer

from obscli.cli.errors import CommandError


if TYPE_CHECKING:
    from obscli.pipelines.request import MeasureScaling, Stack, Weights, WindowsRequest


STACKS: Final = ("discrete", "continuous")
WEIGHTS: Final = ("squared", "abs")


def _known_stack(given: str) -> str:
    if given not in STACKS:
        raise typer.BadParameter(f"{given!r} is not one of {', '.join(STACKS)}")
    return given


def _known_weights(given: str) -> str:
    if given not in WEIGHTS:
        raise typer.BadParameter(f"{given!r} is not one of {', '.join(WEIGHTS)}")
    return given


WindowOption: TypeAlias = Annotated[
    float | None,
    typer.Option(
        "--window",
        metavar="T",
        help="Local observability along the interval instead: in windows of this length, --step apart.",
    ),
]
StackOption: TypeAlias = Annotated[
    str,
    typer.Option(
        "--stack",
        callback=_known_stack,
        metavar="|".join(STACKS),
        help="With --window: samples of the outputs, or outputs and derivatives at the start.",
    ),
]
FrozenOption: TypeAlias = Annotated[
    bool,
    typer.Option(
        "--frozen/--true",
        help="With --window: A and H kept as at the start of each window, or varying along it.",
    ),
]
MuOption: TypeAlias = Annotated[
    str,
    typer.Option(
        "--mu",
        callback=_known_weights,
        metavar="|".join(WEIGHTS),
        help="With --window: weigh singular values by squared components, or by sizes (not unique).",
    ),
]
AdviceOption: TypeAlias = Annotated[
    bool,
    typer.Option("--advice", help="With --window: find, exactly, which motion the states need."),
]
ShowOption: TypeAlias = Annotated[
    list[str] | None,
    typer.Option(
        "--show",
        metavar="NAME,…",
        help="With --window: tables and figures of these states, vectors and quantities only (repeatable).",
    ),
]


def refuse_with_window(**options: object) -> None:
    """Refuse options that ask for one instant, for measures that windows do not have, or for segments."""
    given = [name for name, value in options.items() if value]
    if "segments" in given:
        raise CommandError("--segments does not go with --window: windows are of stages (--stage)")
    if given:
        raise CommandError(
            f"--{given[0]} does not go with --window, which takes all its values in every window"
        )


def refuse_without_window(*, stack: str, frozen: bool, mu: str, advice: bool, show: bool) -> None:
    """Refuse options that mean nothing without windows."""
    changed = {
        "--stack": stack != STACKS[0],
        "--true": not frozen,
        "--mu": mu != WEIGHTS[0],
        "--advice": advice,
        "--show": show,
    }
    given = [name for name, value in changed.items() if value]
    if given:
        raise CommandError(f"{given[0]} is about windows: give their length, --window T")


def windows_request(
    window: float,
    step: float | None,
    stack: str,
    mu: str,
    scaling: str | None,
    *,
    frozen: bool,
    advice: bool,
) -> WindowsRequest:
    """Return what the options ask for."""
    from obscli.pipelines.request import WindowsRequest  # noqa: PLC0415 - imports inside command bodies

    return WindowsRequest(
        window,
        step,
        stack=cast("Stack", stack),
        frozen=frozen,
        weights=cast("Weights", mu),
        scaling=cast("MeasureScaling | None", scaling),
        advice=advice,
    )
