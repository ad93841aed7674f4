"""Files of samples that a model takes functions of time from: what its key ``signals`` means."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal, TypeAlias

from obscli.core.place import Place
from obscli.model.expression import Expression


#: How a signal goes from sample to sample.
Interpolation: TypeAlias = Literal["cubic", "linear", "previous"]


@dataclass(frozen=True, slots=True, eq=False)
class SignalColumn:
    """A column of a file that is a function of time: ``name`` = factor · column.

    ``unwrap``: the jump of a full turn, taken out of the column before; None: there is none.
    """

    name: str
    column: str
    factor: Expression | None
    unwrap: Expression | None
    place: Place


@dataclass(frozen=True, slots=True, eq=False)
class SignalFile:
    """A file with samples of functions of time, at times (``time`` − ``zero``) · ``factor``.

    Parameters
    ----------
    zero : "first": the first time; "value": 0
    max_gap : the longest step that is interpolated across; None: ten times the median one
    """

    file: Path
    place: Place
    time: str
    columns: tuple[SignalColumn, ...]
    factor: Expression | None = None
    zero: Expression | str = "value"
    interpolation: Interpolation = "cubic"
    max_gap: Expression | None = None
