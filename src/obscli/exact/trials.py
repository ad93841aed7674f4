"""Single changes of a system, tried: after which of them a linear form is observable.

c is observable after a change iff c adds nothing to the rank of the changed system:

    rank of (A, [H; c]) = rank of (A, H)

Both ranks are found at a random point modulo a prime, which costs no elimination; where they agree, the
verdict is proved. A state that no unobservable direction touches is observable already: to measure it as well
changes nothing.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final, Literal, TypeAlias

from obscli.exact.errors import UndecidedError, UndefinedError
from obscli.exact.exact_system import read_system
from obscli.exact.prove import Proof, prove
from obscli.exact.saturation import rank_modulo_a_prime
from obscli.exact.verdicts import groups, quantity_verdict
from obscli.model.expression import ONE
from obscli.model.measured import with_output
from obscli.model.system import Quantity, System


if TYPE_CHECKING:
    from obscli.exact.finding import LinearFormVerdict


#: One more measured state, a substitution undone, another stage of the file.
ChangeKind: TypeAlias = Literal["output", "fix", "stage"]

#: Of states that would show it if they were measured, so many are proved.
_MOST_PROVED: Final = 8


@dataclass(frozen=True, slots=True)
class Trial:
    """A change of a system, what a linear form becomes, and the rank then; None: it could not be found.

    ``proved``: exactly; otherwise only tried modulo a prime, or undecided.
    """

    change: str
    kind: ChangeKind
    becomes: LinearFormVerdict
    rank: int | None
    proved: bool


def try_measured(proof: Proof, target: Quantity) -> Iterator[Trial]:
    """Yield a trial for every state that, measured as well, makes a linear form observable."""
    system = proof.exact.system
    touched = sorted({j for column in proof.kernel.columns.values() for j in column})
    left = _MOST_PROVED
    for name in (system.state_names[j] for j in touched):
        found = try_change(name, "output", with_output(system, {name: ONE}), target, prove_it=left > 0)
        if found.becomes in {"observable", "undecided"}:
            left -= 1
            yield found


def try_change(
    change: str, kind: ChangeKind, system: System, target: Quantity, *, prove_it: bool = True
) -> Trial:
    """Return what a linear form is in a changed system.

    Parameters
    ----------
    change, kind : the change in words
    system : with the change made
    prove_it : prove the verdict where it is ``observable``
    """
    try:
        rank = rank_modulo_a_prime(read_system(system))
        if rank_modulo_a_prime(read_system(with_output(system, target.coefficients))) > rank:
            return Trial(change, kind, "coupled", rank, proved=False)
    except (UndecidedError, UndefinedError):
        return Trial(change, kind, "undecided", None, proved=False)
    tried = Trial(change, kind, "observable", rank, proved=False)
    if not prove_it:
        return tried
    try:
        verdict, rank = verdict_in(system, target)
    except (UndecidedError, UndefinedError):
        return tried
    return replace(tried, becomes=verdict, rank=rank, proved=verdict != "undecided")


def verdict_in(system: System, target: Quantity) -> tuple[LinearFormVerdict, int]:
    """Return the proved verdict on a linear form in a system, and its rank.

    Raises
    ------
    UndecidedError, UndefinedError : where the rank cannot be proved
    """
    proof = prove(system, range(system.n), target.coefficients.values())
    found = quantity_verdict(target, proof.exact, proof.kernel.columns, groups(proof.flag.rows))
    return found.verdict, proof.rank
