"""The names an expression may use, and why others may not be used here."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

from obscli.model.catalogue import RESERVED
from obscli.model.expression import Expression
from obscli.model.meter import Meter
from obscli.model.tensor import Tensor
from obscli.model.trouble import Incomplete, Silence, nearest, shown


@dataclass(frozen=True, slots=True, eq=False)
class Absent:
    """A name that exists but has no value here: why, and what to do."""

    message: str
    hint: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class Scope:
    """Names with values, and names with reasons.

    ``silent`` are those whose own definition is already reported; ``elsewhere`` those that only some
    stages define.
    """

    values: Mapping[str, Tensor]
    derive: Callable[[Expression], Expression]
    meter: Meter
    absent: Mapping[str, Absent] = field(default_factory=dict)
    silent: frozenset[str] = frozenset()
    elsewhere: frozenset[str] = frozenset()

    def with_values(self, values: Mapping[str, Tensor]) -> Scope:
        """Return the scope with further names."""
        return replace(self, values={**self.values, **values})

    def find(self, name: str) -> Tensor | Absent:
        """Return the value of the name, or why it has none.

        Raises
        ------
        Silence
            where the name is already reported, ``Incomplete`` where only stages define it
        """
        if name in self.values:
            return self.values[name]
        if name in self.silent:
            raise Silence
        if name in self.elsewhere:
            raise Incomplete(name)
        if name in self.absent:
            return self.absent[name]
        if name in RESERVED:
            return Absent(f"'{name}' is a function and takes arguments: {name}(…)")
        if name.lower() in {"nan", "inf", "infinity"}:
            return Absent(f"'{name}' is no number; numbers must be finite")
        return Absent(f"unknown name '{shown(name)}'{nearest(name, [*self.values, 'pi'])}")
