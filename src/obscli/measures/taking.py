"""Takes measures of a subject: what each finds, or why it finds nothing."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from obscli.measures.measure import Found, Measure, NotMeasuredError
from obscli.measures.subject import Subject
from obscli.model.expression import Expression
from obscli.numeric.errors import NotComputableError
from obscli.numeric.finding import NotComputed
from obscli.numeric.program import Array


#: Values that agree so well, relatively, rank alike.
_TIED: Final = 1e-9

#: A closed form has the value found if they agree so well, relatively.
_FORM: Final = 1e-9


def take(
    subject: Subject, measures: Sequence[Measure], progress: Callable[[str], None] = lambda _: None
) -> dict[str, Found | NotComputed]:
    """Return what measures find, by key."""
    found: dict[str, Found | NotComputed] = {}
    for measure in measures:
        progress(measure.title)
        try:
            found[measure.key] = _confirmed(subject, measure.compute(subject))
        except (NotMeasuredError, NotComputableError) as error:
            found[measure.key] = NotComputed(str(error))
    return found


def _confirmed(subject: Subject, found: Found) -> Found:
    """Return what was found with those closed forms that have its values.

    They are those of generic values: at the file's, or at one instant, a row that matters may vanish.
    """
    names = (target.name for target in subject.targets)
    values: dict[str, object] = dict(zip(names, found.targets, strict=False))
    values.update(found.system)

    def agrees(name: str, form: Expression) -> bool:
        value = values.get(name)
        try:
            return isinstance(value, float | int) and bool(
                np.isclose(subject.value(form), value, rtol=_FORM, atol=0)
            )
        except NotComputableError:
            return False

    return replace(found, forms={name: form for name, form in found.forms.items() if agrees(name, form)})


def ranked(subject: Subject, measure: Measure, found: Found) -> dict[str, float]:
    """Return the values of the observable states, from the best to the worst."""
    sign = 1 if measure.better == "smaller" else -1
    values = {
        target.name: value
        for target, value in zip(subject.targets, found.targets, strict=True)
        if target.kind == "state" and target.observable and value is not None and np.isfinite(value)
    }
    return dict(sorted(values.items(), key=lambda one: sign * one[1]))


def reverses(one: Mapping[str, float], other: Mapping[str, float]) -> bool:
    """Whether two states stand in one order by some values and clearly in the reverse by others."""
    names = [name for name in one if name in other]
    a, b = (np.array([values[name] for name in names]) for values in (one, other))
    apart = [np.sign(x[:, None] - x) * (abs(x[:, None] - x) > _TIED * abs(x)) for x in (a, b)]
    return bool((apart[0] * apart[1] < 0).any())


def in_units(subject: Subject, units: Array) -> Subject:
    """Return the same subject, to be measured in other units of the states."""
    return replace(subject, units=units)
