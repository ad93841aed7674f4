"""What to do with the result: the decision scheme of Bagmut (2009, introduction), in a few lines.

Observable: design the estimator. Otherwise: extend the measurements or the motion so that the
unobservable states are seen, or leave them out of the estimator. (Whether unobservable states die out by
themselves, so that an estimator may carry them, is the question of detectability.)
"""

from __future__ import annotations

from typing import TYPE_CHECKING


if TYPE_CHECKING:
    from collections.abc import Sequence

    from obscli.exact.finding import Analysis

_MOST_NAMES = 8


def advise(analysis: Analysis) -> tuple[str, ...]:
    """Return a few lines of advice: estimate, measure or move, leave out."""
    missing = analysis.system.n - analysis.rank
    if not missing:
        whole = "Every state is observable: an estimator of the full state can be designed."
        if analysis.system.sampled:
            whole = (
                "Generic motion makes every state observable: an estimator of the full state can be designed "
                "for motion that excites it; which states this record excites stands under Signals."
            )
        return (whole, *_at_values(analysis))
    leave = "directions of the state leave" if missing > 1 else "direction of the state leaves"
    estimate = (
        f"Estimate the {_plural(analysis.rank, 'observable combination')} above, not the "
        f"{_plural(analysis.system.n, 'state')}: {missing} {leave} no trace in the outputs."
    )
    return (estimate, *_measure(analysis), *_leave_out(analysis), *_at_values(analysis))


def _measure(analysis: Analysis) -> list[str]:
    """Say which measurements would complete the rank, and which states need another motion.

    The free states of a reduced kernel are a set that works: measured, each removes one direction.
    """
    lines = []
    coupled = [state for state in analysis.free if analysis.states[state] == "coupled"]
    alone = [state for state, verdict in analysis.states.items() if verdict == "unobservable"]
    if coupled:
        each = "each adds one combination" if len(coupled) > 1 else "it adds one combination"
        lines.append(f"To separate the coupled states, measure {_join(coupled)} as well: {each}.")
    if alone:
        them = "them" if len(alone) > 1 else "it"
        lines.append(
            f"{_join(alone)}: no output contains {them}, at any order; only another motion or orientation, "
            f"or an output that contains {them}, would show {them}."
        )
    return lines


def _leave_out(analysis: Analysis) -> list[str]:
    """Say how a reduced estimator does without the free states of the kernel."""
    alone = [state for state, verdict in analysis.states.items() if verdict == "unobservable"]
    coupled = [state for state in analysis.free if state not in alone]
    parts = [f"drop {_join(alone)}"] if alone else []
    if coupled:
        what = "their values are" if len(coupled) > 1 else "its value is"
        parts.append(f"fix {_join(coupled)} where {what} known or small")
    return [f"For an estimator of {_plural(analysis.rank, 'state')} instead: {', and '.join(parts)}."]


def _at_values(analysis: Analysis) -> list[str]:
    at_values = analysis.at_values
    if at_values.rank is None or at_values.rank == analysis.rank:
        return []
    because = f" ({', '.join(at_values.because)})" if at_values.because else ""
    lost = analysis.rank - at_values.rank
    return [f"The file's values{because} cost {lost} of the rank: change them to reach {analysis.rank}."]


def _plural(count: int, noun: str) -> str:
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


def _join(names: Sequence[str]) -> str:
    if len(names) > _MOST_NAMES:
        names = [*names[: _MOST_NAMES - 1], f"{len(names) - _MOST_NAMES + 1} more"]
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"
