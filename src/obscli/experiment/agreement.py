"""The exact side of an experiment held against its Gramians: the joint basis."""

from __future__ import annotations

from obscli.checks.agreement import verify_basis
from obscli.checks.witness import Witness
from obscli.core.verification import NotVerified, Verification
from obscli.exact.finding import Analysis, Undecided
from obscli.experiment.special import AtFile
from obscli.experiment.stacked import Stack
from obscli.experiment.witnessed import Witnessed
from obscli.model.system import Covector


def verify_together(stack: Stack, there: AtFile | None, seen: Witnessed) -> Verification | NotVerified:
    """Return what the joint Gramian says of the combinations that all runs determine at the file's values."""
    if isinstance(stack.finding, Undecided):
        return NotVerified(f"the exact side is undecided: {stack.finding.reason}")
    if there is None or there.stack is None or there.rank is None:
        return NotVerified(there.reason if there else "undecided")
    if seen.together is None:
        return NotVerified(seen.reason)
    witness = Witness(seen.together, there.rank)
    basis = _basis(stack.finding)
    if there.rank != stack.finding.rank or witness.vanishes(basis):
        assert isinstance(there.stack.finding, Analysis)
        basis = _basis(there.stack.finding)
    found = verify_basis(witness, basis)
    if found.verdict == "contradicted" and seen.dropped and (seen.together.rank or 0) > there.rank:
        return NotVerified(
            f"the Gramians show rank {seen.together.rank}, but a direction of the states that start anew was "
            "taken as not seen; if rounding hides it, the rank is lower"
        )
    return found


def _basis(finding: Analysis) -> tuple[Covector, ...]:
    return tuple(one.coefficients for one in finding.combinations)
