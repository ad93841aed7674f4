"""What a system lacks for a simulation of its Kalman filter, all at once, and the lines to add."""

from __future__ import annotations

from collections.abc import Iterator

from obscli.model.expression import Expression, is_zero
from obscli.model.notation import to_text
from obscli.model.system import Matrix, System
from obscli.numeric.errors import NotComputableError
from obscli.numeric.numeric_system import missing_values


#: So many names are spelled out in an example.
_SHOWN = 3


def refuse_lacking(system: System, whose: str = "", *, prior: bool = True) -> None:
    """Refuse a system that lacks something.

    Parameters
    ----------
    whose : what the message begins with
    prior : whether the states need an initial deviation

    Raises
    ------
    NotComputableError
        with what the file has to give besides, and an example in its own names
    """
    needs = "; ".join(_needs(system, prior=prior))
    if needs:
        raise NotComputableError(whose + needs)


def _needs(system: System, *, prior: bool) -> Iterator[str]:
    without_value = [one.name for one in system.parameters if one.nominal is None]
    if without_value:
        yield missing_values(without_value)
    noise = system.noise
    R, P0 = (None, None) if noise is None else (noise.R, noise.P0)
    silent = [one.name for k, one in enumerate(system.outputs) if not _has(R, k)]
    unknown = [one.name for k, one in enumerate(system.states) if prior and not _has(P0, k)]
    if not silent and not unknown:
        return
    lack, lines = [], []
    if silent:
        lack.append(f"the noise of {_few(silent)}")
        lines.append(f"R: {{{_entries(dict.fromkeys(silent, '…'))}}}")
        if noise is None or (noise.step is None and any(one.every is None for one in system.outputs)):
            lines.append("step: …")
    if unknown:
        lack.append(f"the initial deviation of {_few(unknown)}")
        lines.append(f"P0_std: {{{_entries({name: _scale(system, name) for name in unknown})}}}")
    head = "the file has no `noise`" if noise is None else "`noise` is not complete"
    yield f"{head}: give {' and '.join(lack)}, as in `noise: {{{', '.join(lines)}}}`"


def _has(matrix: Matrix | None, k: int) -> bool:
    entry = matrix.entries.get((k, k)) if matrix else None
    return entry is not None and not is_zero(entry)


def _scale(system: System, name: str) -> str:
    scale: Expression | None = next(one.scale for one in system.states if one.name == name)
    return "…" if scale is None else to_text(scale)


def _few(names: list[str]) -> str:
    more = f" and {len(names) - 2 * _SHOWN} more" if len(names) > 2 * _SHOWN else ""
    return ", ".join(names[: 2 * _SHOWN]) + more


def _entries(values: dict[str, str]) -> str:
    shown = [f"{name}: {value}" for name, value in list(values.items())[:_SHOWN]]
    return ", ".join([*shown, *(["…"] if len(values) > _SHOWN else [])])
