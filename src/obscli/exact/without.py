"""Observable combinations that do not need certain states: the rows of L's row space that are zero on them.

With these states first among the columns, the rows of the reduced echelon form whose pivot comes after them
span all such combinations.
"""

from __future__ import annotations

from collections.abc import Sequence

from obscli.exact.errors import UndecidedError, UndefinedError
from obscli.exact.finding import Undecided
from obscli.exact.prove import prove
from obscli.model.system import Covector, System


def rows_without(system: System, states: Sequence[str]) -> tuple[Covector, ...] | Undecided:
    """Return a reduced basis of the observable combinations without some states, proved complete."""
    left_out = set(states)
    order = sorted(range(system.n), key=lambda j: system.state_names[j] not in left_out)
    try:
        proof = prove(system, order)
    except (UndecidedError, UndefinedError) as error:
        return Undecided(system, str(error))
    return tuple(row for row in proof.echelon if left_out.isdisjoint(row))
