"""What algebra says of an experiment: each run and all together, at generic, special and nominal values."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from obscli.exact.finding import Analysis
from obscli.experiment.own_symbols import OwnSymbol, told_apart
from obscli.experiment.special import AtFile, Special, at_file, search
from obscli.experiment.stacked import Progress, Stack, analysed
from obscli.model.system import Run, System


@dataclass(frozen=True, eq=False)
class Exact:
    """What algebra says of an experiment.

    Parameters
    ----------
    runs : with a symbol for every value of a parameter
    own : these symbols
    shared, fresh : the states that the runs share, and those that start anew
    stack : what the runs determine, each and together
    special : where that is less; None: not searched
    at_file : what they determine at the file's values
    """

    runs: tuple[Run, ...]
    own: tuple[OwnSymbol, ...]
    shared: tuple[str, ...]
    fresh: tuple[str, ...]
    stack: Stack
    special: Special | None
    at_file: AtFile

    @property
    def rank(self) -> int | None:
        """The generic rank of M, None where it is undecided."""
        return self.stack.finding.rank if isinstance(self.stack.finding, Analysis) else None


def exactly(
    runs: Sequence[Run], shared: tuple[str, ...], base: System, progress: Progress, *, critical: bool
) -> Exact:
    """Return what algebra says of some runs; ``base``: the file's system, for its quantities."""
    apart, own = told_apart(runs, base)
    stack = analysed(apart, shared, progress, critical=critical, base=base)
    special, there = None, AtFile(None, reason="undecided")
    if isinstance(stack.finding, Analysis):
        if critical:
            special = search(stack, shared, progress)
        progress("the experiment at the file's values")
        there = at_file(stack, shared, special)
    fresh = tuple(name for name in apart[0].system.state_names if name not in set(shared))
    return Exact(apart, own, shared, fresh, stack, special, there)
