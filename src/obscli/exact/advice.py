"""What to do with the result: the decision scheme of Bagmut (2009, introduction), in two or three lines.

Observable: design the estimator. Otherwise: extend the measurements or the motion so that the
unobservable states are seen, or leave them out of the estimator. (Whether unobservable states die out by
themselves, so that an estimator may carry them, is the question of detectability.)
"""

from __future__ import annotations

from typing import TYPE_CHECKING


if TYPE_CHECKING:
    from obscli.exact.finding import Analysis

_MOST_NAMES = 6


def advise(analysis: Analysis) -> tuple[str, ...]:
    """Return two or three lines of advice."""
    n = analysis.system.n
    missing = n - analysis.rank
    if not missing:
        return ("Every state is observable: an estimator of the full state can be designed.", *_weakness(analysis))
    direct = measurable(analysis)
    lines = [
        f"{missing} of {n} directions cannot be estimated from these outputs; estimate the "
        f"{analysis.rank} combinations above, not the states in them."
    ]
    if direct:
        lines.append(f"To see more: one more output that measures {_or(direct)} adds one combination each.")
    else:
        lines.append(f"To see more: add outputs or motion that separate the groups; {missing} are missing.")
    lines.append(_reduction(analysis))
    return (*lines, *_weakness(analysis))


def measurable(analysis: Analysis) -> list[str]:
    """Return states, one for each unobservable direction, whose measurement would add a combination."""
    taken: list[str] = []
    for direction in analysis.unobservable:
        pivots = [name for name in direction if name not in taken]
        if pivots:
            taken.append(pivots[-1])
    return taken


def _reduction(analysis: Analysis) -> str:
    alone = [s for s, verdict in analysis.states.items() if verdict == "unobservable"]
    coupled = [s for s in measurable(analysis) if s not in alone]
    parts = []
    if alone:
        parts.append(f"drop {_and(alone)} (in no combination)")
    if coupled:
        parts.append(f"fix one state of each group, for example {_and(coupled)}, if its value is known or small")
    return f"To reduce the estimator: {'; '.join(parts)}."


def _weakness(analysis: Analysis) -> tuple[str, ...]:
    if analysis.at_values.rank is not None and analysis.at_values.rank < analysis.rank:
        because = ", ".join(analysis.at_values.because) or "the values of the file"
        return (f"At the file's values the rank drops to {analysis.at_values.rank} ({because}): change these values.",)
    return ()


def _or(names: list[str]) -> str:
    return _join(names, "or")


def _and(names: list[str]) -> str:
    return _join(names, "and")


def _join(names: list[str], word: str) -> str:
    if len(names) > _MOST_NAMES:
        return f"{', '.join(names[:_MOST_NAMES])} {word} {len(names) - _MOST_NAMES} more"
    if len(names) == 1:
        return names[0]
    return f"{', '.join(names[:-1])} {word} {names[-1]}"
