"""The mean errors after an initial error in the report: a table of forms; what is fed back, in words."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Final

from obscli.core.document import Block, Cell, Column, Heading, Note, Table, Text, line, plain
from obscli.core.number import plain as number
from obscli.core.number import short
from obscli.pipelines.simulate_result import Initial


if TYPE_CHECKING:
    from obscli.numeric.feedback import Feedback
    from obscli.numeric.simulation_finding import MeanResponse

COLUMNS: Final = (
    Column("", breaks=True),
    Column("unit"),
    Column("initial", "right"),
    Column("end", "right"),
    Column("largest", "right"),
    Column("when", "right"),
)
LEGEND: Final = (
    "the errors of the filter without noise, in the units of the file: before the first sample, at the end; "
    "largest: after a sample, in absolute value, and when."
)


def mean_blocks(one: Initial, names: Mapping[str, Cell], units: Mapping[str, str]) -> Iterator[Block]:
    """Yield the response of every form to the initial error; ``names``: as set."""
    yield Heading(2, plain("Mean response to the initial error"))
    rows = tuple(
        (
            names.get(name) or line(Text(name, "name")),
            line(Text(units.get(name, ""), "faint")),
            *_numbers(one.response, k),
        )
        for k, name in enumerate(one.response.names)
    )
    yield Table(COLUMNS, rows, (Text(LEGEND, "faint"),), folds=True)


def _numbers(found: MeanResponse, k: int) -> Iterator[Cell]:
    own: list[float] = found.mean[:, k].tolist()
    largest = max(range(len(own)), key=lambda j: abs(own[j]))
    values = (float(found.before[k]), own[-1], own[largest])
    yield from (line(Text(short(value, 3))) for value in values)
    yield line(Text(number(float(found.t[largest]))))


#: Of which the equivalent singular value is taken.
_WINDOW: Final = "as many samples as states, A and H frozen, in units of P0 and the noise"


def feedback_note(feedback: Feedback, *, mismatched: bool) -> Note:
    """Return what is fed back, and what that changes."""
    what = "the estimates" if feedback.states is None else f"the estimates of {', '.join(feedback.states)}"
    limits = []
    if feedback.above is not None:
        limits.append(f"equivalent singular value (of {_WINDOW}) is above {short(feedback.above)}")
    if feedback.below is not None:
        limits.append(f"deviation is below {short(feedback.below)} of the prior, as the filter claims it")
    limit = f" whose {' and whose '.join(limits)}," if limits else ""
    same = "" if mismatched else "; the filter has the model itself: errors are those of output correction"
    return Note("note", plain(f"{what}{limit} are fed back after each sample{same}"))
