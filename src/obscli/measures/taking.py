"""Takes measures of a subject: what each finds, or why it finds nothing."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from obscli.measures.measure import Found, Measure, NotMeasuredError
from obscli.measures.subject import Subject
from obscli.numeric.errors import NotComputableError
from obscli.numeric.finding import NotComputed
from obscli.numeric.program import Array


def take(
    subject: Subject, measures: Sequence[Measure], progress: Callable[[str], None] = lambda _: None
) -> dict[str, Found | NotComputed]:
    """Return what measures find, by key."""
    found: dict[str, Found | NotComputed] = {}
    for measure in measures:
        progress(measure.title)
        try:
            found[measure.key] = measure.compute(subject)
        except (NotMeasuredError, NotComputableError) as error:
            found[measure.key] = NotComputed(str(error))
    return found


def ranking(subject: Subject, measure: Measure, found: Found) -> tuple[str, ...]:
    """Return the observable states from the best to the worst, by a measure."""
    values = [
        (value if measure.better == "smaller" else -value, target.name)
        for target, value in zip(subject.targets, found.targets, strict=True)
        if target.kind == "state" and target.observable and value is not None and np.isfinite(value)
    ]
    return tuple(name for _, name in sorted(values, key=lambda one: one[0]))


def in_units(subject: Subject, units: Array) -> Subject:
    """Return the same subject, to be measured in other units of the states."""
    return replace(subject, units=units)
