"""The errors of a filter designed on one model and run on another, beside the true states, step by step.

True states x, the filter's estimate x̂, and e = E x − x̂, E the states of the filter among the true ones (a
state that the truth does not have is zero there). On a panel from a, z = x(a), ε = E z − x̂(a):

    x = Φ z,    e = Φ_f ε + (E Φ − Φ_f E) z
    ν = D z + B ε + W v,    B = W H_f Φ_f,    D = W H Φ − B E,    W Cov(v) Wᵀ = I where the filter is right
    ε⁺ = ε − K ν

D and E Φ − Φ_f E are zero for equal models: e is then the error of the ordinary filter, and z, which may grow
without bound where e does not, is left out (n_x = 0). Where estimates are fed back, see ``feedback``, that
follows the sample; it changes nothing for equal models.
"""

from __future__ import annotations

from collections.abc import Generator, Iterator, Sequence
from dataclasses import dataclass
from typing import Final, Protocol

import numpy as np

from obscli.numeric.errors import NotComputableError
from obscli.numeric.feedback import Feedback, fed_back
from obscli.numeric.program import Array, Counts, Flags
from obscli.numeric.progress import Progress
from obscli.numeric.sampled_system import SampledSystem, Stretch, Timeline
from obscli.numeric.schedule import Schedule
from obscli.numeric.square_root_filter import compressed, measured, refuse_infinite
from obscli.numeric.well_observable import equivalent_at_samples


#: Instants closer than this, in steps, are one.
_SAME: Final = 1e-9

#: At so many instants functions of both models are compared, to so many digits.
_PROBES: Final = 17
_ALIKE: Final = 1e-6


class Errors(Protocol):
    """What stands for the joint distribution of (z, ε): a square root of it, or draws from it."""

    @property
    def columns(self) -> Array:
        """The columns (z, ε), shape (n_x + n_f, c)."""

    def add(self, root: Array) -> None:
        """Add an error with covariance root rootᵀ that is independent of all before."""

    def correct(self, rows: Array, noise: Array, gain: Array) -> Array | None:
        """Take a sample: ν = rows (z, ε) + noise v, ε ← ε − gain ν; return ν of draws, (m, c)."""

    def move(self, transition: Array) -> None:
        """Take (z, ε) to the next panel, or to what is after a feedback."""


@dataclass(frozen=True, slots=True, eq=False)
class Known:
    """What is known at a mark.

    Parameters
    ----------
    index : of the instant in the timeline
    root : L of the filter's covariance in coordinates of the panel's start, shape (n_f, n_f)
    filter_transition : Φ_f, shape (n_f, n_f)
    error_transition : from (z, ε) to e, shape (n_f, n_x + n_f)
    innovation : S^−½ ν of the draws, shape (m, c); None: no draws, or no sample
    outputs : how many outputs of the filter are sampled then
    """

    index: int
    root: Array
    filter_transition: Array
    error_transition: Array
    innovation: Array | None
    outputs: int


@dataclass(frozen=True, slots=True, eq=False)
class _Outputs:
    """On a panel, in units of the noise that the filter expects: B, (D B), W R^½; how many are sampled."""

    rows: Array
    joint: Array
    noise: Array
    count: Counts

    def taken(self, k: int, root: Array, entered: Array | None, errors: Errors) -> tuple[Array, Array | None]:
        """Correct the errors by the sample at an instant; return L after driving noise and it, S^−½ ν."""
        if not self.count[k]:
            return (root if entered is None else compressed([root, entered])), None
        root, S, gain = measured(root, self.rows[k], entered)
        inverse = np.linalg.inv(S)
        found = errors.correct(self.joint[k], self.noise[k], gain @ inverse)
        return root, None if found is None else inverse @ found


class Pair:
    """A true system and the filter designed on another, or on itself; states and outputs matched by name.

    ``feedback``: what is fed back after each sample; None: nothing, output correction.

    Raises
    ------
    NotComputableError
        where an output of the filter is not one of the truth
    UnfitRequestError
        where a state to be fed back is not one of both
    """

    def __init__(self, truth: SampledSystem, design: SampledSystem, feedback: Feedback | None = None) -> None:
        self.truth = truth
        self.design = design
        self.own = truth is design
        states = (design.numeric.system.state_names, truth.numeric.system.state_names)
        self.common = _among(*states)
        self._feedback = feedback
        self._allowed = None if feedback is None else feedback.allowed(*states)
        self._equivalent = None
        if feedback is not None and feedback.above is not None and not self.own:
            self._equivalent = equivalent_at_samples(design)
        self._check_time()
        names = [[one.name for one in system.numeric.system.outputs] for system in (design, truth)]
        self._outputs = _among(*names)
        unknown = [name for name in names[0] if name not in names[1]]
        if unknown:
            raise NotComputableError(
                f"the true model has no output {', '.join(unknown)}: name the outputs of both models alike, "
                "or leave it out of the filter (--outputs)"
            )
        self._noise: Array = self._outputs @ np.linalg.cholesky(truth.schedule.R)
        self._check_samples()
        self._check_motions()

    @property
    def prior(self) -> Array:
        """A square root of the covariance of (z, ε) before the first sample, where x̂ = 0."""
        return self.joint(self.truth.prior)

    @property
    def states(self) -> int:
        """How many true states are followed beside the errors, n_x."""
        return 0 if self.own else self.truth.numeric.n

    def joint(self, root: Array) -> Array:
        """Return what enters (z, ε) where ``root`` enters z."""
        return root if self.own else np.concatenate([root, self.common @ root])

    def _check_time(self) -> None:
        """Refuse a filter in discrete time on a truth in continuous time, and the other way round."""
        kinds = [one.numeric.system.discrete for one in (self.design, self.truth)]
        if kinds[0] != kinds[1]:
            words = ["discrete" if one else "continuous" for one in kinds]
            raise NotComputableError(
                f"the filter is in {words[0]} time, the true model in {words[1]} time: give both the same"
            )

    def _check_samples(self) -> None:
        """Refuse a filter that wants samples that the truth does not have."""
        wanted, given = self.design.schedule, self.truth.schedule
        if wanted.start != given.start:
            raise NotComputableError(
                f"the filter starts at {wanted.start:.6g}, the true model at {given.start:.6g}: P0 is that "
                "of the start, give both the same (--from)"
            )
        place, same = matched(given, wanted.t)
        has = (given.sampled[place] @ self._outputs.T > 0) & same[:, None]
        lacking = np.argwhere(wanted.sampled & ~has)
        if len(lacking):
            k, i = lacking[0]
            name = self.design.numeric.system.outputs[i].name
            raise NotComputableError(
                f"the filter takes a sample of {name} at {wanted.t[k]:.6g}, but the true model has none: "
                "give the filter a step that is a multiple of that of the truth (`every`, `noise: step`)"
            )

    def _check_motions(self) -> None:
        """Refuse functions left open that both models have and that do not move alike."""
        t = np.linspace(self.design.schedule.start, self.design.schedule.stop, _PROBES)
        true, own = (one.numeric.values(t, {}) for one in (self.truth, self.design))
        for function in self.design.numeric.system.functions:
            name = function.name
            if name in true and not np.allclose(true[name], own[name], rtol=_ALIKE, atol=0):
                raise NotComputableError(
                    f"{name} is left open, and does not move alike in the two models: write it as an "
                    "expression, or give both models the same functions in the same order"
                )

    def follow(
        self, errors: Errors, root: Array, timeline: Timeline, marks: Flags, progress: Progress
    ) -> Generator[Known, None, Array]:
        """Run the filter on the errors, and yield what is known at the marks; return L at the end.

        Parameters
        ----------
        root : L before the first sample, shape (n_f, n_f)

        Raises
        ------
        NotComputableError
            where the covariance is beyond all numbers
        """
        for true, own in self._stretches(timeline):
            part = slice(own.first, own.first + len(own.rows))
            progress(timeline.progress(part.start))
            outputs = self._outputs_of(true, own, timeline.sample[part])
            for k in range(len(own.rows)):
                if true.noise is not None:
                    errors.add(self.joint(true.noise[k]))
                entered = None if own.noise is None else own.noise[k]
                root, innovation = outputs.taken(k, root, entered, errors)
                if outputs.count[k]:
                    parts = true.transition[k], own.transition[k]
                    self._feed_back(*parts, root, int(timeline.sample[own.first + k]), errors)
                if marks[own.first + k]:
                    refuse_infinite(timeline.t[own.first + k], root, errors.columns)
                    to_errors = self._errors_by(true.transition[k], own.transition[k])
                    count = outputs.count[k]
                    yield Known(own.first + k, root, own.transition[k], to_errors, innovation, count)
            root = own.onward @ root
            errors.move(self._onward(true, own))
        return root

    def _stretches(self, timeline: Timeline) -> Iterator[tuple[Stretch, Stretch]]:
        """Yield the panels of the truth and of the filter side by side."""
        if self.own:
            return ((one, one) for one in self.design.stretches(timeline))
        return zip(self.truth.stretches(timeline), self.design.stretches(timeline), strict=True)

    def _feed_back(self, true_part: Array, own_part: Array, root: Array, sample: int, errors: Errors) -> None:
        """Feed back the estimates at an instant of a panel, those that are to be."""
        taken, feedback = self._allowed, self._feedback
        if taken is None or feedback is None or self.own:
            return
        if feedback.below is not None:
            deviations = np.linalg.norm(own_part @ root, axis=1)
            taken = taken & (deviations < feedback.below * np.linalg.norm(self.design.prior, axis=1))
        if feedback.above is not None and self._equivalent is not None:
            taken = taken & (self._equivalent[sample] > feedback.above)
        if taken.any():
            errors.move(fed_back(self.common, true_part, own_part, taken))

    def _outputs_of(self, true: Stretch, own: Stretch, sample: Counts) -> _Outputs:
        whitening = self.design.whitening(sample)
        rows = whitening @ own.rows
        count: Counts = np.where(sample >= 0, self.design.schedule.sampled[sample].sum(axis=1), 0)
        if self.own:
            return _Outputs(rows, rows, whitening @ self._noise, count)
        others = whitening @ (self._outputs @ true.rows) - rows @ self.common
        return _Outputs(rows, np.concatenate([others, rows], axis=2), whitening @ self._noise, count)

    def _errors_by(self, true_part: Array, own_part: Array) -> Array:
        """Return what takes (z, ε) to e where Φ moves the truth and Φ_f the estimate."""
        if self.own:
            return own_part
        others = self.common @ true_part - own_part @ self.common
        return np.concatenate([others, own_part], axis=1)

    def _onward(self, true: Stretch, own: Stretch) -> Array:
        """Return what takes (z, ε) from a panel to the next."""
        to_errors = self._errors_by(true.onward, own.onward)
        if self.own:
            return to_errors
        n_x, n_f = true.transition.shape[1], own.transition.shape[1]
        upper = np.concatenate([true.onward, np.zeros((n_x, n_f))], axis=1)
        return np.concatenate([upper, to_errors])


def matched(schedule: Schedule, t: Array) -> tuple[Counts, Flags]:
    """Return the samples nearest to instants, and whether they are at these instants but for rounding."""
    after = np.clip(np.searchsorted(schedule.t, t), 0, len(schedule.t) - 1)
    before = np.maximum(after - 1, 0)
    nearest: Counts = np.where(np.abs(schedule.t[after] - t) <= np.abs(schedule.t[before] - t), after, before)
    step = float(np.diff(schedule.t).min()) if len(schedule.t) > 1 else schedule.stop - schedule.start
    return nearest, np.abs(schedule.t[nearest] - t) <= _SAME * step


def _among(names: Sequence[str], others: Sequence[str]) -> Array:
    """Return the matrix of zeros and ones that takes what has the other names to what has these."""
    return np.array([[float(one == other) for other in others] for one in names])
