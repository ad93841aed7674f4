"""How well an experiment determines each shared state, and whether that meets what is asked for."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from obscli.experiment.informed import Informed
from obscli.numeric.program import Array


@dataclass(frozen=True, slots=True, eq=False)
class Deviation:
    """Standard deviation of one shared state: before, after each run together with those before it, alone.

    ``alone``: after each run by itself, with the prior; ``unit``: as the file labels it.
    """

    name: str
    unit: str
    before: float
    after: float
    runs: tuple[float, ...]
    alone: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Required:
    """A requirement: one standard deviation asked for, and what there is before and after."""

    name: str
    unit: str
    required: float
    before: float
    after: float

    @property
    def margin(self) -> float:
        """How many times better than asked; below 1 the requirement is not met."""
        return self.required / self.after if self.after else np.inf

    @property
    def is_met(self) -> bool:
        """Whether the deviation is at most what is asked for."""
        return self.after <= self.required


@dataclass(frozen=True, slots=True, eq=False)
class History:
    """Deviations of all shared states in time since the start of the first run; ``ends``: of the runs.

    Setting up between runs takes no time here. ``values``: by state, shape (len(times),) each.
    """

    times: tuple[float, ...]
    ends: tuple[float, ...]
    values: tuple[tuple[float, ...], ...]


@dataclass(frozen=True, slots=True, eq=False)
class Accuracy:
    """The accuracy of an experiment; ``notes``: what was assumed."""

    states: tuple[Deviation, ...]
    required: tuple[Required, ...]
    history: History
    notes: tuple[str, ...]

    @property
    def worst(self) -> Required | None:
        """The requirement with the smallest margin, None where nothing is asked for."""
        return min(self.required, key=lambda one: one.margin, default=None)


def accuracy(informed: Informed) -> Accuracy:
    """Return the deviations after the runs, one after the other."""
    ends = [(k, -1) for k in range(len(informed.runs))]
    before = informed.deviation([])
    runs = np.array([informed.deviation(ends[: k + 1]) for k in range(len(ends))])
    alone = np.array([informed.deviation([end]) for end in ends])
    asked_before = informed.deviation([], required=True)
    asked_after = informed.deviation(ends, required=True)
    return Accuracy(
        tuple(
            Deviation(
                name,
                informed.units.get(name, ""),
                float(before[j]),
                float(runs[-1, j]),
                tuple(runs[:, j].tolist()),
                tuple(alone[:, j].tolist()),
            )
            for j, name in enumerate(informed.states)
        ),
        tuple(
            Required(name, informed.units.get(name, ""), value, float(asked_before[k]), float(asked_after[k]))
            for k, (name, value) in enumerate(informed.required)
        ),
        _history(informed, ends, before),
        _notes(informed, runs[-1], before),
    )


def _history(informed: Informed, ends: list[tuple[int, int]], before: Array) -> History:
    times, values, marks, start = [0.0], [before], [], 0.0
    for k, one in enumerate(informed.runs):
        for j, elapsed in enumerate(one.elapsed):
            times.append(start + float(elapsed))
            values.append(informed.deviation([*ends[:k], (k, j)]))
        start += one.duration
        marks.append(start)
    columns = np.array(values).T
    return History(tuple(times), tuple(marks), tuple(tuple(row.tolist()) for row in columns))


def _notes(informed: Informed, after: Array, before: Array) -> tuple[str, ...]:
    notes = []
    kernel = np.abs(informed.undetermined()).max(axis=1, initial=0.0)
    rests = [
        name
        for j, name in enumerate(informed.states)
        if kernel[j] > 0 and np.isfinite(after[j]) and after[j] < before[j] * (1 - 1e-9)
    ]
    if rests:
        names = ", ".join(rests)
        notes.append(f"the runs alone do not determine {names}: what is better than before rests on priors")
    unseen = np.abs(informed.unseen(range(len(informed.runs)))).max(axis=1, initial=0.0)
    lost = [name for j, name in enumerate(informed.states) if np.isinf(after[j]) and unseen[j] == 0]
    if lost:
        names = ", ".join(lost)
        notes.append(
            f"what the runs tell of {names} is lost to rounding: a state that starts anew decays too far; "
            "give a shorter interval"
        )
    if informed.driven:
        names = ", ".join(informed.driven)
        notes.append(
            f"`noise: Q` on {names} is left out: what the runs share is constant (`fresh` says otherwise)"
        )
    if informed.beside:
        names = ", ".join(informed.beside)
        notes.append(f"`require` for {names} is not judged here: it starts anew in every run")
    if informed.other_priors:
        names = ", ".join(informed.other_priors)
        notes.append(f"the runs give different priors for {names}: that of the first run counts")
    if informed.correlated:
        notes.append("`noise: P0` correlates what is shared with what starts anew: that is left out")
    return tuple(notes)
