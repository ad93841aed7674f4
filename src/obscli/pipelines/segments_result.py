"""What was found about the segments of a model together."""

from __future__ import annotations

from dataclasses import dataclass

from obscli.checks.certified_segments import CertifiedSegments
from obscli.checks.turned_between import Turn
from obscli.exact.finding import Analysis, Undecided
from obscli.model.system import Model, Segments
from obscli.numeric.finding import NotComputed, NumericFinding
from obscli.pipelines.request import Part


@dataclass(frozen=True, slots=True)
class SegmentEnd:
    """What is known at the end of one segment, all before it included.

    ``proved``: so many independent combinations at least; ``rank``, ``decided``, ``gap``: of the Gramian.
    None: not looked at.
    """

    name: str
    start: float
    stop: float
    jumps: bool
    proved: int | None
    rank: int | None = None
    decided: bool = False
    gap: float | None = None


@dataclass(frozen=True, slots=True, eq=False)
class SegmentsResult:
    """Segments one after the other, the whole state carried through.

    Parameters
    ----------
    exact : what constant directions hidden all the way leave: its rank is never exceeded; None: not asked for
    there : the same at the file's values, where that was needed
    outputs : outputs as functions of the state at the start, where they have a closed form and were needed
    certified : how many independent combinations are proved at the file's values
    numeric : the Gramian over all segments
    ends : by segment; empty where nothing has numbers
    turns : orientation that changes without a motion
    """

    model: Model
    segments: Segments
    exact: Analysis | Undecided | None
    there: Analysis | Undecided | None
    outputs: Analysis | Undecided | None
    certified: CertifiedSegments | None
    numeric: NumericFinding | NotComputed | None
    ends: tuple[SegmentEnd, ...]
    turns: tuple[Turn, ...]
    shown: Part | None = None

    @property
    def title(self) -> str:
        """The name of the model, and what of it this is."""
        return f"{self.model.name} · segments"

    @property
    def n(self) -> int:
        """The number of states."""
        return self.segments.parts[0].system.n

    @property
    def least(self) -> int | None:
        """The rank is proved not to be below this at the file's values; None: not looked at."""
        return None if self.certified is None else self.certified.rank

    @property
    def most(self) -> int | None:
        """The rank is proved not to exceed this at the file's values; None: not looked at."""
        bounds = [one.rank for one in (self.exact, self.outputs, self.there) if isinstance(one, Analysis)]
        return min(bounds, default=None if self.certified is None else self.n)

    @property
    def rank(self) -> int | None:
        """The rank, proved at the file's values; None: not so."""
        return self.least if self.least == self.most else None

    @property
    def proved(self) -> Analysis | None:
        """The exact finding where both bounds meet: then it is all that the segments show."""
        for one in (self.exact, self.outputs, self.there):
            if isinstance(one, Analysis) and one.rank == self.least and not one.undecided:
                return one
        return None

    @property
    def is_generic(self) -> bool:
        """Whether the rank is proved for generic parameters too."""
        return self.rank is not None and (self.rank == self.n or self.proved is not self.there)

    @property
    def is_at_start(self) -> bool:
        """Whether the combinations are those of the state at the start, else of the state at any time."""
        return self.proved is not None and self.proved is self.outputs

    @property
    def seen(self) -> int | None:
        """The rank that the Gramian decides at the end; None: it does not."""
        return self.ends[-1].rank if self.ends and self.ends[-1].decided else None

    @property
    def is_contradicted(self) -> bool:
        """Whether the Gramian at the end is outside what is proved."""
        if self.seen is None:
            return False
        too_many = self.most is not None and self.seen > self.most
        return too_many or (self.least is not None and self.seen < self.least)

    @property
    def is_undecided(self) -> bool:
        """Whether what was asked about the rank stayed open."""
        exactly = self.shown != "numeric" and self.rank is None
        return exactly or (self.shown != "analytic" and self.seen is None)
