"""One file of ``signals`` as it is written: columns by name, numbers evaluated."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from obscli.model.expression import Expression
from obscli.model.tree import Node, Scalar


if TYPE_CHECKING:
    from obscli.model.signal_file import Interpolation


@dataclass(frozen=True, slots=True, eq=False)
class ColumnDraft:
    """A column, what its values are multiplied by, and the jump of a full turn in it."""

    column: Scalar
    factor: Expression | None
    unwrap: Expression | None


@dataclass(frozen=True, slots=True, eq=False)
class SignalDraft:
    """A function of time and its columns, by rows."""

    name: str
    key: Scalar
    shape: tuple[int, ...]
    columns: tuple[ColumnDraft, ...]


@dataclass(frozen=True, slots=True, eq=False)
class SignalFileDraft:
    """One file; ``file`` None where only the stages name it; times are (column − zero) · factor."""

    node: Node
    file: Path | None
    time: Scalar | None
    factor: Expression | None
    zero: Expression | str
    interpolation: Interpolation
    max_gap: Expression | None
    signals: tuple[SignalDraft, ...]
