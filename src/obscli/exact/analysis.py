"""The analytic pipeline for one system: everything an engineer asks of exact algebra, as one finding."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Final, Literal, TypeAlias

from obscli.exact.advice import advise
from obscli.exact.basis import preferred_basis, sparse_basis
from obscli.exact.critical import search_candidates, search_critical_values
from obscli.exact.echelon import PolyRow
from obscli.exact.errors import JetOverflowError, UndecidedError, UndefinedError
from obscli.exact.exact_system import read_system
from obscli.exact.finding import Analysis, Combination, CriticalSearch, Neglect, Undecided
from obscli.exact.nominal import rank_at_values
from obscli.exact.nonzero import first_nonzero
from obscli.exact.origin import first_rows
from obscli.exact.prove import Proof, certificate, prove
from obscli.exact.relations import relations_of
from obscli.exact.relations_finding import Relations
from obscli.exact.rows import dot, rate_of
from obscli.exact.sample_window import is_window_needed, of_window, sample_window, static
from obscli.exact.saturation import saturate
from obscli.exact.structure import structure_of
from obscli.exact.verdicts import groups, quantity_verdict, state_verdicts
from obscli.model.expression import Expression
from obscli.model.notation import to_text
from obscli.model.system import Covector, Quantity, System


Progress: TypeAlias = Callable[[str], None]


#: Why critical values are not searched where the rank is proved without elimination.
TOO_LARGE: Final = (
    "critical values: the coefficients grew too large for the elimination that gives candidates"
)


@dataclass(frozen=True, slots=True, eq=False)
class Options:
    """What the user asked of the analysis.

    ``basis``: the form of the printed basis, or rows the user prefers; ``pivot_order``: states to be
    eliminated first, the rest following in the order of the model; ``critical``: search for parameter
    values at which the rank drops, or only for candidates; ``structure``: find how the unobservable subspace
    moves; ``relations``: find what the outputs are made of.
    """

    basis: Literal["echelon", "sparse"] | tuple[Quantity, ...] = "echelon"
    pivot_order: tuple[str, ...] = ()
    critical: bool | Literal["candidates"] = True
    certificate: bool = True
    structure: bool = True
    relations: bool = False


def analyze(
    system: System, options: Options | None = None, progress: Progress = lambda _: None
) -> Analysis | Undecided:
    """Find and prove the observable combinations of a system.

    Parameters
    ----------
    system : the stage to analyse
    options : form of the basis, pivot order, whether to search critical values
    progress : called with a short text before each longer step
    """
    options = options or Options()
    if is_window_needed(system):
        return _of_samples(system, options, progress)
    progress("observability matrix")
    jets = 4
    while True:
        try:
            proof = prove(system, _columns(system, options.pivot_order), _extra(system, options), jets)
            jets = 2 * proof.exact.interpreter.jets
            return _describe(proof, options, progress)
        except JetOverflowError:
            continue
        except (UndecidedError, UndefinedError) as error:
            return Undecided(system, str(error))


def _of_samples(system: System, options: Options, progress: Progress) -> Analysis | Undecided:
    """Analyse a discrete-time system that depends on the step by n of its samples."""
    try:
        found = analyze(sample_window(system), replace(options, structure=False, relations=False), progress)
        if isinstance(found, Undecided):
            return Undecided(system, found.reason)
        found = of_window(system, found)
    except (UndecidedError, UndefinedError) as error:
        return Undecided(system, str(error))
    return replace(found, advice=advise(found))


def _extra(system: System, options: Options) -> list[Expression]:
    preferred = options.basis if isinstance(options.basis, tuple) else ()
    return [e for q in (*system.quantities, *preferred) for e in q.coefficients.values()]


def _columns(system: System, pivot_order: tuple[str, ...]) -> list[int]:
    index = {name: j for j, name in enumerate(system.state_names)}
    first = [index[name] for name in pivot_order]
    return [*first, *(j for j in range(system.n) if j not in set(first))]


def _describe(proof: Proof, options: Options, progress: Progress) -> Analysis:
    exact, system = proof.exact, proof.exact.system
    names = system.state_names
    rows, notes = _basis(proof, options)
    components = groups(proof.flag.rows)
    critical = None
    if options.critical:
        progress("critical values")
        critical = _critical(proof, options, progress)
    progress("rank at the file's values")
    at_values = rank_at_values(proof, critical)
    structure = None
    if options.structure:
        progress("structure")
        structure = structure_of(proof, at_values, critical)
    analysis = Analysis(
        system=system,
        rank=proof.rank,
        order=proof.order,
        combinations=_combinations(proof, rows),
        unobservable=tuple(proof.directions.values()),
        states=state_verdicts(names, components),
        groups=tuple(tuple(names[j] for j in sorted(c)) for c in sorted(components, key=min) if len(c) > 1),
        quantities=tuple(
            quantity_verdict(q, exact, proof.kernel.columns, components) for q in system.quantities
        ),
        certificate=certificate(proof) if options.certificate else None,
        at_values=at_values,
        frozen_rank=_frozen_rank(proof),
        critical=critical,
        varying=_varying(proof),
        free=tuple(names[f] for f in proof.kernel.columns),
        notes=(*notes, *_notes(system)),
        structure=structure,
        relations=_relations(proof) if options.relations else None,
    )
    return replace(analysis, advice=advise(analysis))


def _relations(proof: Proof) -> Relations | None:
    try:
        return relations_of(proof)
    except UndecidedError:
        return None


def _critical(proof: Proof, options: Options, progress: Progress) -> CriticalSearch:
    if not proof.flag.eliminated:
        return CriticalSearch((), complete=False, not_searched=(TOO_LARGE,), instants=())
    search = search_candidates if options.critical == "candidates" else search_critical_values
    try:
        return search(proof, progress)
    except UndecidedError as error:
        return CriticalSearch((), complete=False, not_searched=(str(error),), instants=())


def _frozen_rank(proof: Proof) -> int | None:
    if not proof.exact.varies:
        return proof.rank
    try:
        return saturate(proof.exact, frozen=True).rank
    except UndecidedError:
        return None


def _basis(proof: Proof, options: Options) -> tuple[list[PolyRow], list[str]]:
    rows = proof.flag.rows
    if options.basis == "sparse":
        return sparse_basis(proof.exact, rows), []
    if options.basis == "echelon":
        place = {j: k for k, j in enumerate(_columns(proof.exact.system, options.pivot_order))}
        return [rows[p] for p in sorted(rows, key=place.__getitem__)], []
    return preferred_basis(proof.exact, rows, proof.kernel.columns, options.basis)


def _combinations(proof: Proof, rows: list[PolyRow]) -> tuple[Combination, ...]:
    outputs = proof.exact.system.outputs
    origins = first_rows(proof.exact, proof.saturation, rows)
    covectors = [proof.covector(row) for row in rows]
    return tuple(
        Combination(covector, _is_constant(proof, covector), outputs[output].name, order)
        for covector, (order, output) in zip(covectors, origins, strict=True)
    )


def _is_constant(proof: Proof, covector: Covector) -> bool:
    """Whether ξ' + ξA = 0, or ξF = ξ, so that the combination keeps its value along every solution."""
    row = proof.exact.row(covector)
    after = rate_of(proof.exact, row)
    return after == row if proof.exact.system.discrete else not after


def _varying(proof: Proof) -> tuple[str, ...]:
    """Name what varies in time: time itself, functions, angles and exponents."""
    exact = proof.exact
    entries = [e for row in (*exact.A, *exact.H) for e in row.values()]
    found = []
    for k, generator in enumerate(exact.field.generators):
        occurs = any(max(e.num.degrees()[k], e.den.degrees()[k]) > 0 for e in entries)
        if not occurs or not exact.field.varies(k):
            continue
        if generator.kind == "angle" and generator.argument is not None:
            argument = proof.restorer.element(exact.interpreter.read(generator.argument))
            found.append(f"sin, cos of {to_text(argument)}")
        else:
            found.append(to_text(generator.meaning).removeprefix("-"))  # a root of an invariant: f = -√…
    return tuple(found)


def _notes(system: System) -> tuple[str, ...]:
    """Say what the rank does not take into account: relations that are not stated, outages of outputs."""
    sampled = system.sampled
    free = ", ".join(f.name for f in system.functions if f.derivative is None and f.name not in sampled)
    notes = []
    if sampled:
        notes.append(
            f"The rank holds at generic values of the signals {', '.join(sampled)}: it is what generic "
            "motion makes observable; what the recorded one does is seen by the Gramian."
        )
    if free:
        notes.append(
            f"The rank holds for generic {free}; relations among them that the file does not state "
            "can lower it."
        )
    if system.interrupted:
        notes.append(
            f"Outages of {', '.join(system.interrupted)} are not taken into account here: rank and Gramian "
            "are those of outputs without outages; obscli simulate takes the samples as they come."
        )
    return tuple(notes)


def compare(before: Analysis, after: Analysis, substitution: str) -> Neglect:
    """Say what an exact substitution changes: combinations of one analysis that are not in the other."""
    return Neglect(
        substitution,
        before.rank,
        after.rank,
        lost=tuple(_outside(before, after)),
        gained=tuple(_outside(after, before)),
    )


def _outside(mine: Analysis, other: Analysis) -> list[Covector]:
    """Return combinations of ``mine`` that do not annihilate the unobservable directions of ``other``."""
    covectors = [c.coefficients for c in mine.combinations]
    return [c for c, inside in zip(covectors, contained(other, covectors), strict=True) if not inside]


def contained(analysis: Analysis, covectors: list[Covector]) -> list[bool]:
    """Whether each covector is an observable combination: c N = 0 exactly.

    Raises
    ------
    UndecidedError : zero cannot be decided for some coefficient
    """
    entries = [e for c in (*covectors, *analysis.unobservable) for e in c.values()]
    exact = read_system(static(analysis.system), entries)
    names = frozenset(analysis.system.state_names)
    rows = [exact.row({state: e for state, e in c.items() if state in names}) for c in covectors]
    columns = [exact.row(direction) for direction in analysis.unobservable]
    products = [[dot(exact.field, row, column) for column in columns] for row in rows]
    return [first_nonzero(exact.interpreter, product) is None for product in products]
