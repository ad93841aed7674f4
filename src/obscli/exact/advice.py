"""What to do with the result: the decision scheme of Bagmut (2009, introduction), in a few lines.

Observable: design the estimator. Otherwise: extend the measurements or the motion so that the
unobservable states are seen, or leave them out of the estimator. (Whether unobservable states die out by
themselves, so that an estimator may carry them, is the question of detectability.)
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING


if TYPE_CHECKING:
    from obscli.exact.finding import Analysis

_MOST_NAMES = 6
_MOST_GROUPS = 3


def advise(analysis: Analysis) -> tuple[str, ...]:
    """Return a few lines of advice: estimate, measure or move, leave out."""
    n = analysis.system.n
    missing = n - analysis.rank
    if not missing:
        return (
            "Every state is observable: an estimator of the full state can be designed.",
            *_at_values(analysis),
        )
    alone = [state for state, verdict in analysis.states.items() if verdict == "unobservable"]
    return (
        (
            f"Estimate the {analysis.rank} combinations above, not the {n} states: "
            f"{missing} direction{'s leave' if missing > 1 else ' leaves'} no trace in the outputs."
        ),
        *_measure(analysis, alone),
        *_leave_out(analysis, alone),
        *_at_values(analysis),
    )


def missing_in_group(analysis: Analysis, group: Sequence[str]) -> int:
    """Return how many unobservable directions lie in a group of coupled states."""
    return sum(any(state in direction for state in group) for direction in analysis.unobservable)


def _measure(analysis: Analysis, alone: list[str]) -> list[str]:
    """Say which measurement would separate which group, and that the rest needs another motion."""
    parts = []
    for group in analysis.groups[:_MOST_GROUPS]:
        missing = missing_in_group(analysis, group)
        seen = list(dict.fromkeys(s for d in analysis.unobservable for s in d if s in group))
        if missing:
            many = "one more output" if missing == 1 else f"{missing} more outputs"
            parts.append(f"{many} among {_join(seen, 'and')}")
    if len(analysis.groups) > _MOST_GROUPS:
        parts.append(f"the like for {len(analysis.groups) - _MOST_GROUPS} more groups")
    lines = [f"To separate the coupled states, measure {'; '.join(parts)}."] if parts else []
    if alone:
        lines.append(
            f"{_join(alone, 'and')}: no output contains {'it' if len(alone) == 1 else 'them'}, at any order; "
            "only another motion or orientation, or an output that contains "
            f"{'it' if len(alone) == 1 else 'them'}, would show {'it' if len(alone) == 1 else 'them'}."
        )
    return lines


def _leave_out(analysis: Analysis, alone: list[str]) -> list[str]:
    """Say which states a reduced estimator can do without: the free states of the kernel."""
    free = [list(direction)[-1] for direction in analysis.unobservable]
    coupled = [state for state in free if state not in alone]
    parts = []
    if alone:
        parts.append(f"drop {_join(alone, 'and')}")
    if coupled:
        what = "their values are" if len(coupled) > 1 else "its value is"
        parts.append(f"fix {_join(coupled, 'and')} where {what} known or small")
    return [f"For an estimator of {analysis.rank} states instead: {', and '.join(parts)}."]


def _at_values(analysis: Analysis) -> list[str]:
    at_values = analysis.at_values
    if at_values.rank is None or at_values.rank == analysis.rank:
        return []
    because = ", ".join(at_values.because) or "together"
    return [
        (
            f"The file's values ({because}) cost {analysis.rank - at_values.rank} of the rank: "
            f"change them to reach {analysis.rank}."
        )
    ]


def _join(names: list[str], word: str) -> str:
    if len(names) > _MOST_NAMES:
        return f"{', '.join(names[:_MOST_NAMES])} {word} {len(names) - _MOST_NAMES} more"
    if len(names) == 1:
        return names[0]
    return f"{', '.join(names[:-1])} {word} {names[-1]}"
