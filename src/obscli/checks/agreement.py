"""A basis of observable combinations held against the Gramian: χ, the rank check, and what they mean.

At every instant t_i, with r rows and q_i the dimension of the kernel of W(t_i, t0), χ_i has to stay below
its bound and r + q_i has to be n. Instants at which the Gramian does not show the whole rank yet cannot tell.

References
----------
V. M. Morozov, F. Yu. Baklanov (2018), verification of an analytic result, steps 4 and 5.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from obscli.checks.diagnosis import Seen, diagnose
from obscli.checks.witness import CERTAIN, Witness, counting_from
from obscli.core.verification import Agreement, CombinationCheck, Point, Verification
from obscli.model.notation import covector_text
from obscli.model.system import Covector
from obscli.numeric.leak import Leak
from obscli.numeric.program import Flags


def verify_basis(witness: Witness, basis: Sequence[Covector], texts: Sequence[str] = ()) -> Verification:
    """Return what the Gramian says of a basis.

    Parameters
    ----------
    witness : the Gramian, with the exact rank where it is known
    basis : the rows s_k as linear forms
    texts : how the rows are written; none: as obscli writes them
    """
    spaces = witness.numeric.spaces
    leak = witness.leak(basis)
    shown = witness.conclusive
    worst = leak.ratio.max(axis=1, initial=0.0)
    fits = len(basis) == spaces.rank
    refutes = shown & (~fits | (worst > CERTAIN))
    conclusive = refutes | (shown & leak.judged.all(axis=1))
    agrees = conclusive & fits & (worst <= 1)
    points = tuple(
        _point(witness, leak, i, conclusive=conclusive[i], agrees=agrees[i], refutes=refutes[i])
        for i in range(len(worst))
    )
    seen = Seen(
        count=len(points),
        conclusive=int(conclusive.sum()),
        leaking=int((worst[conclusive] > 1).sum()),
        surely=bool((worst[conclusive] > CERTAIN).any()),
        rows=len(basis),
        kernel=spaces.n - int(np.median(spaces.rank[conclusive])) if conclusive.any() else None,
        n=spaces.n,
        above=_above(witness),
        expected=witness.expected,
        excited=witness.numeric.rank if _is_below(witness) else None,
    )
    verdict, reason = _verdict(seen, int(agrees.sum()), shown=bool(shown.any()))
    top = witness.numeric.rank
    if verdict == "undecided" and _is_below(witness) and not shown.any():
        verdict, reason = "not excited", f"the recorded signals excite {top} of {seen.expected} directions"
    names = witness.numeric.system.system.state_names
    texts = texts or [covector_text(one, names) for one in basis]
    combinations = _combinations(texts, leak, shown)
    return Verification(verdict, reason, diagnose(seen), spaces.n, points, combinations)


def _above(witness: Witness) -> int | None:
    """Return a rank decided at some instant that is above the exact one, None where there is none."""
    spaces = witness.numeric.spaces
    ranks = spaces.rank[spaces.decided]
    if witness.expected is None or not ranks.size or ranks.max() <= witness.expected:
        return None
    return int(ranks.max())


def _is_below(witness: Witness) -> bool:
    """Whether signals are recorded, and show a rank that is clear and below that of generic ones."""
    rank, system = witness.numeric.rank, witness.numeric.system.system
    below = rank is not None and witness.expected is not None and rank < witness.expected
    return below and bool(system.sampled)


def _verdict(seen: Seen, agree: int, *, shown: bool) -> tuple[Agreement, str]:
    if seen.above is not None:
        return "contradicted", f"the Gramian shows rank {seen.above}, above the exact rank {seen.expected}"
    if not seen.conclusive and shown:
        return "undecided", "the error of the Gramian hides what may leak at every instant; others may tell"
    if not seen.conclusive:
        shows = "does not show the whole rank" if seen.expected is not None else "decides no rank"
        return "undecided", f"the Gramian {shows} at any instant; others may tell"
    if seen.surely or seen.kernel is None or seen.rows + seen.kernel != seen.n:
        return "contradicted", "χ or the rank check speaks against it"
    if seen.leaking:
        return "undecided", "χ exceeds its bound slightly at some instants"
    return "verified", f"the Gramian agrees at {agree} of {seen.count} instants"


def _point(witness: Witness, leak: Leak, i: int, *, conclusive: bool, agrees: bool, refutes: bool) -> Point:
    spaces = witness.numeric.spaces
    q = spaces.n - int(spaces.rank[i])
    known = np.isfinite(leak.chi[i])
    compared = q > 0 and known.any()
    k = int(np.argmax(np.where(known, leak.chi[i], -1.0))) if compared else 0
    gap = float(spaces.root_gap[i])
    return Point(
        t=float(spaces.instants[i]),
        r=leak.chi.shape[1],
        q=q,
        chi=float(leak.chi[i, k]) if compared else None,
        bound=float(leak.bound[i, k]) if compared else None,
        gap=None if np.isnan(gap) else gap,
        conclusive=bool(conclusive),
        agrees=bool(agrees),
        refutes=bool(refutes),
    )


def _combinations(texts: Sequence[str], leak: Leak, shown: Flags) -> tuple[CombinationCheck, ...]:
    found, ratio, judged = [], leak.ratio, leak.judged
    for k, text in enumerate(texts):
        where = np.flatnonzero(shown & judged[:, k])
        if not where.size:
            found.append(CombinationCheck(text, None, None, None))
            continue
        over = ratio[where, k]
        worst = over.max()
        i = where[np.where(over > counting_from(worst), leak.chi[where, k], -1.0).argmax()]
        holds = True if worst <= 1 else False if worst > CERTAIN else None
        found.append(CombinationCheck(text, float(leak.chi[i, k]), float(leak.bound[i, k]), holds))
    return tuple(found)
