"""What a certificate is about: a digest of the system, and the numbers taken as independent."""

from __future__ import annotations

import hashlib
from typing import TYPE_CHECKING

from obscli.model.notation import to_text


if TYPE_CHECKING:
    from obscli.exact.exact_system import ExactSystem
    from obscli.model.system import System


def fingerprint(system: System) -> str:
    """Return a digest of states, outputs, A, H and relations, so that a certificate names its system."""
    lines = [system.time, *system.state_names, *(output.name for output in system.outputs)]
    lines += [f"{p.name}: {p.assume}" for p in system.parameters]
    for label, matrix in ((system.dynamics_name, system.A), ("H", system.H)):
        lines += [f"{label}{i},{j}={to_text(e)}" for (i, j), e in sorted(matrix.entries.items())]
    lines += [f"{f.name}'={to_text(f.derivative)}" for f in system.functions if f.derivative is not None]
    lines += [f"0={to_text(invariant.expression)}" for invariant in system.invariants]
    return hashlib.sha256("\n".join(lines).encode()).hexdigest()


def independent_constants(exact: ExactSystem) -> tuple[str, ...]:
    """Return the numbers taken as algebraically independent, where there are two or more."""
    numbers = [to_text(g.meaning) for g in exact.field.generators if g.numeric and g.kind != "root"]
    return tuple(numbers) if len(numbers) > 1 else ()
