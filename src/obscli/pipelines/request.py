"""What the user asks of a pipeline, in words: how to change the model, which stages, which basis."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal, TypeAlias


#: Told what is being done; may be called often.
Progress: TypeAlias = Callable[[str], None]


class RequestError(ValueError):
    """A request that does not fit the model: an unknown stage, a state that is not there."""


@dataclass(frozen=True, slots=True)
class Changes:
    """Changes made to the file's system while reading it, as the texts the user gave.

    ``settings``: new nominal values; ``fix``: exact substitutions; ``outputs``: keep only these (empty: all);
    ``without``: states removed.
    """

    settings: Mapping[str, str] = field(default_factory=dict)
    fix: Mapping[str, str] = field(default_factory=dict)
    outputs: tuple[str, ...] = ()
    without: tuple[str, ...] = ()

    def data(self) -> dict[str, object]:
        """Return the changes as JSON values."""
        return {
            "set": dict(self.settings),
            "fix": dict(self.fix),
            "outputs": list(self.outputs),
            "without": list(self.without),
        }


@dataclass(frozen=True, slots=True)
class AnalyzeRequest:
    """How to analyse: stages (empty: all), basis (a path: rows preferred), pivots, critical search."""

    stages: tuple[str, ...] = ()
    basis: Literal["echelon", "sparse"] | Path = "echelon"
    pivot_order: tuple[str, ...] = ()
    critical: bool = True


def silent(_: str) -> None:
    """Progress that nobody watches."""
