"""A model frozen at an instant, and how its ranks compare with those of the model that moves."""

from __future__ import annotations

from dataclasses import dataclass, replace

from obscli.exact.errors import UndecidedError, UndefinedError
from obscli.exact.finding import Analysis, Undecided
from obscli.exact.prove import prove
from obscli.model.covector import parse_scalar
from obscli.model.expression import symbols
from obscli.model.frozen import frozen_at
from obscli.model.system import Model, System
from obscli.pipelines.reading import chosen_systems
from obscli.pipelines.request import RequestError


@dataclass(frozen=True, slots=True)
class Frozen:
    """The instant, as it was asked for; the generic ranks frozen there and in truth, None where undecided.

    ``reason``: why the true rank is not known. ``constants``: the functions of time that are constants now.
    """

    at: str
    rank: int | None
    true_rank: int | None
    reason: str = ""
    constants: tuple[str, ...] = ()

    @property
    def differs(self) -> bool:
        """Whether the two ranks are known and differ."""
        return None not in {self.rank, self.true_rank} and self.rank != self.true_rank

    def data(self) -> dict[str, object]:
        """Return the ranks as JSON values."""
        return {"at": self.at, "rank": self.rank, "true_rank": self.true_rank}


def frozen_system(system: System, instant: str) -> System:
    """Return the system frozen at an instant, in the names of the file; raises as ``frozen_model``."""
    try:
        return frozen_at(system, parse_scalar(system, instant, "--frozen-at"))
    except ValueError as error:
        raise RequestError(f"--frozen-at {instant}: {error}") from None


def frozen_model(model: Model, stages: tuple[str, ...], instant: str) -> Model:
    """Return the model with the named stages (none: all) frozen at an instant, in the names of the file.

    Raises
    ------
    RequestError
        where a stage is not there, or the instant is no constant
    ModelError
        where the instant is no expression, or a coefficient does not exist there
    """
    systems = tuple(frozen_system(system, instant) for system in chosen_systems(model, stages))
    return replace(model, systems=systems, experiment=None, require=(), claims=())


def beside_truth(
    moving: System, finding: Analysis | Undecided | None, frozen: System, instant: str
) -> Frozen:
    """Return the rank of the frozen system, and that of the one that moves where a finding is there."""
    used = symbols(*frozen.A.entries.values(), *frozen.H.entries.values())
    constants = tuple(one.name for one in frozen.functions if one.name in used)
    if finding is None:
        return Frozen(instant, None, None, "no exact algebra was asked for", constants)
    rank = finding.rank if isinstance(finding, Analysis) else None
    try:
        return Frozen(instant, rank, prove(moving, range(moving.n)).rank, "", constants)
    except (UndecidedError, UndefinedError) as error:
        return Frozen(instant, rank, None, str(error) or "a coefficient does not exist", constants)
