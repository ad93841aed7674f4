"""The Gramian as a witness: what it says of ranks, combinations and directions that somebody asserts.

It refutes with certainty what contradicts directions far above its tolerance, and confirms, but does not
prove, what agrees: a rank below what it shows, a combination that leaks into its kernel, a direction it sees.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final, Literal, TypeAlias

import numpy as np

from obscli.checks.detectability import is_followable
from obscli.checks.followed import followed
from obscli.core.check import Indicator
from obscli.core.number import counted, short
from obscli.exact.structure_finding import Structure
from obscli.model.system import Covector
from obscli.numeric.analysis import Numeric
from obscli.numeric.echelon import echelon_curves
from obscli.numeric.errors import NotComputableError
from obscli.numeric.leak import Leak, leak_of
from obscli.numeric.program import Flags


Word: TypeAlias = Literal["agrees", "denies", "silent"]

#: A leak of so many times its bound refutes; between once and so many times nothing is said.
CERTAIN: Final = 10.0


@dataclass(frozen=True, slots=True)
class Testimony:
    """What the Gramian says of one assertion, in a word and in words."""

    word: Word
    words: str
    indicator: Indicator | None = None


@dataclass(frozen=True, eq=False)
class Witness:
    """The Gramian of one system, read with the exact rank where that is known.

    ``expected``: the exact rank at the values the Gramian was computed for; None: not known.
    """

    numeric: Numeric
    expected: int | None = None

    @property
    def conclusive(self) -> Flags:
        """The instants at which the rank is decided and is the expected one (the reached one)."""
        spaces = self.numeric.spaces
        if self.expected is None:
            return self.numeric.conclusive
        found: Flags = spaces.decided & (spaces.rank == self.expected)
        return found

    def leak(self, covectors: Sequence[Covector]) -> Leak:
        """Return χ of combinations and its bound at every instant."""
        rows, errors = self.numeric.system.covectors(covectors, self.numeric.horizon.instants)
        return leak_of(self.numeric.spaces, rows, errors)

    def vanishes(self, covectors: Sequence[Covector]) -> bool:
        """Whether a combination is zero, or does not exist, at all instants."""
        rows, _ = self.numeric.system.covectors(covectors, self.numeric.horizon.instants)
        return bool((~np.isfinite(rows).all(axis=2) | ~rows.any(axis=2)).all(axis=0).any())

    def rank(self, asserted: int) -> Testimony:
        """Say whether the rank is the one asserted."""
        spaces = self.numeric.spaces
        ranks = spaces.rank[spaces.decided]
        count = len(spaces.rank)
        if not ranks.size:
            return Testimony("silent", "the Gramian decides the rank at no instant", Indicator(0, count))
        agree = Indicator(int((ranks == asserted).sum()), count)
        top = int(ranks.max())
        shown = counted(top, "direction")
        if top > asserted:
            return Testimony("denies", f"the Gramian shows {shown} far above its tolerance", agree)
        if top < asserted:
            return Testimony("silent", f"the Gramian shows only {shown} above its tolerance", agree)
        return Testimony("agrees", f"the Gramian agrees {at_instants(agree)}", agree)

    def observable(self, covectors: Sequence[Covector]) -> Testimony:
        """Say whether combinations are observable: whether none leaks into the kernel."""
        where = self.conclusive
        if not where.any():
            return Testimony("silent", self._inconclusive())
        return testimony_of(self.leak(covectors), where)

    def basis(self, covectors: Sequence[Covector]) -> Testimony:
        """Say whether combinations are a complete basis: none leaks, and r + q = n."""
        size, rows = self.rank(len(covectors)), self.observable(covectors)
        return rows if size.word == "agrees" or (size.word, rows.word) == ("silent", "denies") else size

    def unobservable(self, covector: Covector) -> Testimony:
        """Say whether a combination is not observable."""
        found = self.observable([covector])
        one = found.indicator
        if found.word == "agrees":
            return Testimony("silent", "the Gramian sees no leak of it into the kernel")
        if found.word == "silent" or one is None:
            return found
        indicator = Indicator(one.of - one.agree, one.of)
        return Testimony("agrees", f"the Gramian agrees {at_instants(indicator)}", indicator)

    def direction(self, direction: Covector) -> Testimony:
        """Say whether the outputs do not show a direction: M D⁻¹ d = 0 as far as M is known."""
        numeric, spaces = self.numeric, self.numeric.spaces
        rows, _ = numeric.system.covectors([direction], numeric.horizon.instants)
        vectors = rows[:, 0] / spaces.gramian.units
        seen = np.linalg.norm(np.einsum("ijk,ik->ij", spaces.gramian.matrices, vectors), axis=1)
        noise = np.array([spaces.noise_along(v[:, None], i)[0] for i, v in enumerate(vectors)])
        known = np.isfinite(seen) & spaces.decided & (np.linalg.norm(vectors, axis=1) > 0)
        if not known.any():
            return Testimony("silent", "the Gramian cannot judge this direction")
        ratio = np.where(known, seen / np.maximum(noise, 1e-300), 0.0)
        agree = Indicator(int((ratio[known] <= CERTAIN).sum()), int(known.sum()))
        if ratio.max() > CERTAIN * CERTAIN:
            words = f"the Gramian shows this direction {short(float(ratio.max()))} times above its noise"
            return Testimony("denies", words, agree)
        word: Word = "agrees" if agree.agree == agree.of else "silent"
        return Testimony(word, f"the Gramian agrees {at_instants(agree)}", agree)

    def state(self, name: str, verdict: str) -> Testimony:
        """Say whether a state is observable, coupled or unobservable."""
        found = self._states
        if found is None:
            return Testimony("silent", self._inconclusive())
        if found[name] == verdict:
            agree = Indicator(int(self.conclusive.sum()), len(self.conclusive))
            return Testimony("agrees", f"the Gramian agrees {at_instants(agree)}", agree)
        return Testimony("silent", f"the Gramian shows {name} as {found[name]}")

    def detectable(self, structure: Structure | None, *, asserted: bool) -> Testimony:
        """Say whether hidden errors die out, where algebra leaves it open; a window alone proves nothing."""
        if structure is None or not is_followable(structure):
            return Testimony("silent", "")
        try:
            found = followed(self.numeric.system.system, structure, self.numeric.horizon)
        except NotComputableError as error:
            return Testimony("silent", f"hidden errors cannot be followed: {error}")
        words = f"{found.verdict} {found.where}: {found.words}"
        if found.verdict == "undecided" or structure.period is None:
            return Testimony("silent", words)
        return Testimony("agrees" if asserted == (found.verdict == "detectable") else "denies", words)

    @cached_property
    def _states(self) -> Mapping[str, str] | None:
        """The verdict on every state as the Gramian sees it, None where it is not conclusive."""
        if self.expected is not None and self.numeric.rank != self.expected:
            return None
        curves = echelon_curves(self.numeric)
        return None if curves is None else curves.states

    def _inconclusive(self) -> str:
        top = self.numeric.rank
        if top is None:
            return "the Gramian decides the rank at no instant"
        if self.expected is not None and top < self.expected:
            return f"the Gramian shows only {top} of {self.expected} directions above its tolerance"
        return f"the Gramian shows rank {top}, the exact rank is {self.expected}"


def testimony_of(leak: Leak, where: Flags) -> Testimony:
    """Return what leaks say at the instants given."""
    chi, bound, ratio = (one[where] for one in (leak.chi, leak.bound, leak.ratio))
    known = leak.judged[where]
    judged = known.any(axis=1)
    if not judged.any():
        hidden = np.isfinite(chi).any()
        words = "its error hides what may leak" if hidden else "the combination does not exist there"
        return Testimony("silent", f"the Gramian tells at no instant: {words}")
    fine = (ratio <= 1).all(axis=1) & judged
    worst = float(ratio.max())
    shows = known & (ratio > counting_from(worst))
    i, j = np.unravel_index(int(np.where(shows, chi, -1.0).argmax()), chi.shape)
    indicator = Indicator(int(fine.sum()), int(judged.sum()), float(chi[i, j]), float(bound[i, j]))
    if worst > CERTAIN:
        words = (
            f"χ = {short(indicator.chi or 0.0)}, where rounding accounts for {short(indicator.bound or 0.0)}"
        )
        return Testimony("denies", f"the Gramian denies it: {words}", indicator)
    if worst > 1:
        words = (
            f"χ = {short(indicator.chi or 0.0)} is not far above its bound {short(indicator.bound or 0.0)}"
        )
        return Testimony("silent", f"the Gramian does not tell: {words}", indicator)
    leaking = f", worst leak {short(indicator.chi or 0.0)}" if indicator.chi else ""
    return Testimony("agrees", f"the Gramian agrees {at_instants(indicator)}{leaking}", indicator)


def counting_from(worst: float) -> float:
    """Return the χ over its bound above which a leak says what the worst one says."""
    return CERTAIN if worst > CERTAIN else 1.0 if worst > 1 else -1.0


def at_instants(indicator: Indicator) -> str:
    """Return ``at 150 of 150 instants``."""
    return f"at {indicator.agree} of {indicator.of} instants"
