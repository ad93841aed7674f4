"""The numerical side of a command: its options read in the names of a system, its Gramian found.

Importing this costs the floating-point libraries; the pipelines do so only where the Gramian is asked for.
"""

from __future__ import annotations

from dataclasses import replace

from obscli.checks.agreement import verify_basis
from obscli.checks.detectability import Detectability
from obscli.checks.followed import followed
from obscli.checks.guesses import check_guesses
from obscli.checks.witness import Witness
from obscli.core.verification import NotVerified, Verification
from obscli.exact import analysis as exact_engine
from obscli.exact.finding import Analysis, Undecided
from obscli.exact.stationary_form import lift_of
from obscli.model.covector import parse_scalar
from obscli.model.expression import Expression
from obscli.model.specialise import at_nominal
from obscli.model.system import Covector, Model, System
from obscli.numeric import analysis as engine
from obscli.numeric.analysis import Numeric
from obscli.numeric.echelon import echelon_curves
from obscli.numeric.errors import NotComputableError, UnfitRequestError
from obscli.numeric.finding import CrossCheck, EchelonFinding, Knowledge, NotComputed
from obscli.numeric.horizon import Wanted, horizon_of
from obscli.numeric.identify import identified
from obscli.numeric.partners import knowledge
from obscli.numeric.riccati import cross_check
from obscli.numeric.settings import Settings
from obscli.pipelines.request import NumericRequest, Progress, RequestError, silent


def settings_of(system: System, request: NumericRequest) -> Settings:
    """Return the options as the numerical side takes them.

    Raises
    ------
    ModelError
        where an instant is no expression in the names of the system
    """

    def read(text: str | None, option: str) -> Expression | None:
        return None if text is None else parse_scalar(system, text, option)

    wanted = Wanted(
        start=read(request.start, "--from"),
        stop=read(request.stop, "--to"),
        samples=request.samples,
        times=tuple(parse_scalar(system, text, "--times") for text in request.times),
    )
    return Settings(wanted, request.method, request.rtol, request.scaling)


def numeric_of(
    model: Model, system: System, request: NumericRequest, progress: Progress = silent
) -> Numeric | NotComputed:
    """Return the Gramian of a system of a model, or why there is none.

    Raises
    ------
    ModelError
        where an instant is no expression in the names of the system
    RequestError
        where what was asked for does not fit the system
    """
    try:
        return engine.analyze(system, _with_lift(model, system, request), progress)
    except UnfitRequestError as error:
        raise RequestError(f"{model.file}: {error}") from error
    except NotComputableError as error:
        return NotComputed(str(error))


def _with_lift(model: Model, system: System, request: NumericRequest) -> Settings:
    """Return the options, with the stationary system that the method goes through, where it does."""
    settings = settings_of(system, request)
    if request.method != "lift":
        return settings
    lift = lift_of(system)
    if isinstance(lift, str):
        name = system.stage or model.name
        raise RequestError(f"{model.file}: {name} has no stationary system for --gramian lift: {lift}")
    return replace(settings, lift=lift)


class Looks:
    """Finds the Gramian of systems of a model, of each once.

    Parameters
    ----------
    model : whose systems they are
    request : how it is to be found
    progress : told what is being done
    """

    def __init__(self, model: Model, request: NumericRequest, progress: Progress = silent) -> None:
        self._model = model
        self._request = request
        self._progress = progress
        self._found: list[tuple[System, Numeric | NotComputed]] = []

    def numeric(self, system: System) -> Numeric | NotComputed:
        """Return the Gramian, or why there is none."""
        for known, found in self._found:
            if known is system:
                return found
        name = system.stage or self._model.name
        numeric = numeric_of(
            self._model, system, self._request, lambda step: self._progress(f"{name}: {step}")
        )
        self._found.append((system, numeric))
        return self._found[-1][1]

    def __call__(self, system: System) -> Numeric:
        """Return the Gramian.

        Raises
        ------
        NotComputableError
            where there is none
        """
        found = self.numeric(system)
        if isinstance(found, NotComputed):
            raise NotComputableError(found.reason)
        return found


def looked_at(
    system: System, found: Detectability, request: NumericRequest, progress: Progress = silent
) -> Detectability:
    """Return, for a verdict that algebra left open, what the motion over a period or window says.

    Raises
    ------
    ModelError
        where an instant is no expression in the names of the system
    """
    progress("how hidden errors move")
    try:
        return followed(system, found.of, horizon_of(system, settings_of(system, request).wanted))
    except NotComputableError as error:
        return replace(found, words=f"{found.words}, and it cannot be followed: {error}")


def cross_checked(
    system: System, request: NumericRequest, progress: Progress = silent
) -> CrossCheck | NotComputed:
    """Return the Riccati equation solved from two priors along the interval, or why it cannot be.

    Raises
    ------
    ModelError
        where an instant is no expression in the names of the system
    """
    progress("Riccati equation from two priors")
    try:
        horizon = horizon_of(system, settings_of(system, request).wanted)
        return cross_check(system, horizon.start, horizon.stop)
    except NotComputableError as error:
        return NotComputed(str(error))


def known(model: Model, system: System, target: Covector, request: NumericRequest) -> Knowledge | NotComputed:
    """Return how well a linear form in the states is known at the end of the interval, or why not.

    Raises
    ------
    ModelError
        where an instant is no expression in the names of the system
    RequestError
        where what was asked for does not fit the system
    """
    try:
        horizon = horizon_of(system, settings_of(system, request).wanted)
        return knowledge(system, target, horizon.start, horizon.stop)
    except UnfitRequestError as error:
        raise RequestError(f"{model.file}: {error}") from error
    except NotComputableError as error:
        return NotComputed(str(error))


def basis_in_time(numeric: Numeric, finding: Analysis | Undecided | None) -> EchelonFinding | None:
    """Return the basis in time with guesses, proved where algebra agrees; None where it is not clear."""
    curves = echelon_curves(numeric)
    if curves is None:
        return None
    found = identified(curves, numeric.system)
    comparable = isinstance(finding, Analysis) and finding.rank == finding.at_values.rank == numeric.rank
    return check_guesses(found, finding) if comparable and isinstance(finding, Analysis) else found


def verify_analysis(
    finding: Analysis | Undecided, numeric: Numeric | NotComputed
) -> Verification | NotVerified:
    """Return what the Gramian says of the proved combinations, at the file's values."""
    if isinstance(finding, Undecided):
        return NotVerified(f"the exact side is undecided: {finding.reason}")
    if isinstance(numeric, NotComputed):
        return NotVerified(numeric.reason)
    rank = finding.at_values.rank
    if rank is None:
        return NotVerified(finding.at_values.reason)
    witness = Witness(numeric, rank)
    basis = tuple(one.coefficients for one in finding.combinations)
    if rank != finding.rank or witness.vanishes(basis):
        there = _basis_at_values(finding)
        if isinstance(there, NotVerified):
            return there
        basis = there
    jumping = numeric.system.jumping([entry for row in basis for entry in row.values()])
    if jumping and witness.conclusive.any() and rank < numeric.system.n:
        name, order = jumping[0]
        what = f"the derivative of order {order} of the signal {name}" if order else f"the signal {name}"
        return NotVerified(
            f"the combinations name {what}, which jumps from sample to sample as it is interpolated; "
            f"the Gramian shows rank {numeric.rank} of {rank}"
        )
    return verify_basis(witness, basis)


def _basis_at_values(finding: Analysis) -> tuple[Covector, ...] | NotVerified:
    options = exact_engine.Options(critical=False, certificate=False, structure=False)
    there = exact_engine.analyze(at_nominal(finding.system).system(), options)
    if isinstance(there, Undecided):
        return NotVerified(f"the combinations at the file's values are undecided: {there.reason}")
    return tuple(one.coefficients for one in there.combinations)
