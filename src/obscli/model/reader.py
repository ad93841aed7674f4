"""Reading a model file: every problem at once, or a ``Model``."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import Final

from obscli.core.place import ModelError, Place, Problem
from obscli.model.claims import (
    ClaimDraft,
    Origin,
    about,
    about_experiment,
    about_segments,
    claims_of,
    read_claims,
)
from obscli.model.compose import compose
from obscli.model.covector import scope_of
from obscli.model.discrete import with_index
from obscli.model.draft import Draft, merged_nodes
from obscli.model.expected import Subjects
from obscli.model.experiment import Known, RunDraft, read_experiment, read_plan
from obscli.model.jumps import segments_of
from obscli.model.keys import Fields, choice_of, fields, text_of
from obscli.model.meter import MOST_WORK, Meter
from obscli.model.namespace import check_namespace
from obscli.model.nominal import check_linearize, read_linearize
from obscli.model.options import Options, fixes, freed, selected, set_values
from obscli.model.runs import Elaborated, experiment_of, requirements
from obscli.model.sections import SYSTEM_KEYS, read_draft
from obscli.model.segments import SegmentsDraft, read_segments
from obscli.model.signals import with_signals
from obscli.model.source import Source, checked, read_source
from obscli.model.stages import Variants, read_stages
from obscli.model.system import Claim, Model, Segments, System
from obscli.model.tree import Mapping as MappingNode
from obscli.model.tree import Node, Scalar
from obscli.model.trouble import Problems, shown


ORIGINS: Final[tuple[Origin, ...]] = ("claims", "expect")
#: Operations in which all runs of a file together have to be expanded.
RUNS_WORK: Final = 20 * MOST_WORK
_NOTHING: Final[Mapping[str, str]] = MappingProxyType({})
KEYS: Final = (
    "format", "name", "title", "description", "source", *SYSTEM_KEYS, "require", "stages", "experiment",
    "plan", "segments", "claims", "expect",
)  # fmt: skip


def load(
    path: str | Path,
    *,
    fix: Mapping[str, str] = _NOTHING,
    settings: Mapping[str, str] = _NOTHING,
    outputs: Sequence[str] = (),
    without: Sequence[str] = (),
    freed: Collection[str] = (),
) -> Model:
    """Read a model file.

    Parameters
    ----------
    path : the file
    fix : exact substitutions, name of a parameter or function → expression
    settings : nominal values, name of a parameter → expression
    outputs : the outputs kept (names of scalars or vectors); empty: all
    without : states left out
    freed : names that no stage fixes, whatever the file says

    Raises
    ------
    ModelError
        with every problem of the file
    """
    return _read(read_source(path), Options(fix, settings, outputs, without, freed))


def read_text(
    text: str,
    file: str,
    *,
    fix: Mapping[str, str] = _NOTHING,
    settings: Mapping[str, str] = _NOTHING,
    outputs: Sequence[str] = (),
    without: Sequence[str] = (),
) -> Model:
    """Read a model from a text; ``file`` is its name in messages. Otherwise as ``load``."""
    return _read(checked(text, file), Options(fix, settings, outputs, without))


def _read(source: Source, options: Options) -> Model:
    problems = Problems()
    root = compose(source, problems)
    if root is None or (isinstance(root, Scalar) and root.is_null):
        hint = "the smallest model is four lines: states, parameters, A, H"
        raise ModelError([Problem(Place(shown(source.file), 1, 1), "", "the file is empty", hint)])
    if not isinstance(root, MappingNode):
        problems.add(root.problem("", "a model is a mapping of keys (states, A, H, …) to values"))
        raise ModelError(problems)
    model = _model(root, source, options, problems)
    if model is None and not problems:
        problems.add(
            root.problem("", "no stage of this model is complete", "give `A` and `H` (or equations)")
        )
    problems.raise_any()
    assert model is not None
    return model


def _model(root: MappingNode, source: Source, options: Options, problems: Problems) -> Model | None:
    given = fields(root, "", KEYS, problems)
    draft = read_draft(root, "", KEYS, problems)
    stages = {
        name: freed(stage, options) for name, stage in read_stages(_node(given, "stages"), problems).items()
    }
    draft = with_index(draft, stages, given, problems)
    draft, stages = _with_signals(draft, stages, Path(source.file).parent, problems)
    _check_format(given, problems)
    check_namespace(draft, problems)
    draft = replace(draft, linearize=read_linearize(_node(given, "linearize"), problems))
    if draft.linearize is not None:
        check_linearize(draft, stages, given["linearize"][0], problems)
    claims = tuple(
        one for origin in ORIGINS for one in read_claims(_node(given, origin), origin, stages, problems)
    )
    model = _named(given, source, problems)
    known = _known(draft, stages)
    experiment = read_experiment(_node(given, "experiment"), known, problems)
    plan = read_plan(_node(given, "plan"), known, problems)
    segments = read_segments(_node(given, "segments"), known, problems)
    if not draft.states:
        if "states" not in given or not problems:
            problems.add(root.problem("", "`states` is missing: the names of the states, in order"))
        return None
    if options.fix:
        claims = ()  # about the system before the substitution, which some of them do not survive
    variants = Variants(draft, stages, set_values(options, draft, problems), fixes(options, problems), claims)
    systems = variants.elaborate(problems)
    if not systems:
        return None
    scope, states = scope_of(systems[0]), systems[0].states
    wanted = {name for one in states for name in (one.name, one.vector) if name} | draft.quantities.keys()
    chosen = tuple(selected(system, options, problems) for system in systems)
    elaborated = _elaborated(variants, options, chosen)
    found = experiment_of(experiment, plan, elaborated, problems)
    about_it = claims_of(about_experiment(claims, found, problems), scope, _subjects(systems[0]), problems)
    return replace(
        model,
        systems=chosen,
        experiment=found,
        require=requirements(_node(given, "require"), chosen[0], wanted, problems),
        claims=about_it,
        segments=_together(segments, claims, variants, options, systems, problems),
    )


def _named(given: Fields, source: Source, problems: Problems) -> Model:
    """Return the model with its names and texts, and nothing else yet."""
    return Model(
        name=text_of(given.get("name"), "name", problems) or Path(source.file).stem,
        file=Path(source.file),
        systems=(),
        title=text_of(given.get("title"), "title", problems),
        description=text_of(given.get("description"), "description", problems),
        source=text_of(given.get("source"), "source", problems),
    )


def _together(
    draft: SegmentsDraft | None,
    claims: tuple[ClaimDraft, ...],
    variants: Variants,
    options: Options,
    systems: Sequence[System],
    problems: Problems,
) -> Segments | None:
    """Return the segments with the claims about them; ``systems``: the whole ones of the stages."""
    whole = _elaborated(variants, replace(options, outputs=(), without=()), systems)
    found = segments_of(draft, whole, lambda one: selected(one, options, problems), problems)
    system = systems[0]
    about_them = about_segments(claims, problems, there=draft is not None)
    evaluated = claims_of(about_them, scope_of(system), _subjects(system), problems)
    return found and replace(found, claims=evaluated)


def _elaborated(variants: Variants, options: Options, stages: Sequence[System]) -> Elaborated:
    """Return what makes the system of a run, all changes made; its stage's own where it changes nothing."""
    meter = Meter(RUNS_WORK)
    known = {one.stage: one for one in stages if one.stage is not None}

    def of(run: RunDraft, problems: Problems) -> System | None:
        if run.changes_nothing and run.stage in known:
            return known[run.stage]
        system = variants.run(run, meter, problems)
        return None if system is None else selected(system, options, problems)

    return of


def _subjects(system: System) -> Subjects:
    """Return what claims may be about."""
    return Subjects(system.states, system.quantities)


def _node(given: Fields, key: str) -> Node | None:
    return given[key][1] if key in given else None


def _with_signals(
    draft: Draft, stages: Mapping[str, Draft], directory: Path, problems: Problems
) -> tuple[Draft, dict[str, Draft]]:
    """Return base and stages with the functions of their signals."""
    base = with_signals(draft, None, directory, problems)
    return base, {name: _sampled(name, one, base, directory, problems) for name, one in stages.items()}


def _sampled(name: str, stage: Draft, base: Draft, directory: Path, problems: Problems) -> Draft:
    """Return a stage with signals of its own where it replaces some of the base's."""
    if stage.signals is None:
        return stage
    signals = merged_nodes(base.signals, stage.signals)
    return with_signals(replace(stage, signals=signals), base, directory, problems, f"stages.{name}.signals")


def _check_format(given: Fields, problems: Problems) -> None:
    if "format" in given:
        choice_of(given["format"], "format", ("1",), problems)


def _known(draft: Draft, stages: Mapping[str, Draft]) -> Known:
    """Return the names that runs may use."""
    every = [one for where in (draft, *stages.values()) for one in where.functions]
    functions = [name for one in every for name in (one.declared.name, *one.declared.components)]
    return Known(
        stages=tuple(stages),
        states=[name for one in draft.states for name in (one.name, *one.components)],
        fixable=[*draft.parameters, *functions],
    )


def load_claims(model: Model, path: str | Path) -> Mapping[str | None, tuple[Claim, ...]]:
    """Read claims from a file of their own: a list, or a mapping with ``claims`` and ``expect``.

    Returns
    -------
    Mapping[str | None, tuple[Claim, ...]]
        by stage (None: the base); those about an experiment or about segments stand under None

    Raises
    ------
    ModelError
        with every problem of the file
    """
    problems = Problems()
    root = compose(read_source(path), problems)
    stages = [system.stage for system in model.systems if system.stage]
    nodes: dict[Origin, Node | None] = {"claims": root}
    if isinstance(root, MappingNode) and (root.get("claims") or root.get("expect")):
        given = fields(root, "", ORIGINS, problems)
        nodes = {origin: _node(given, origin) for origin in ORIGINS}
    drafts = tuple(
        one for origin, node in nodes.items() for one in read_claims(node, origin, stages, problems)
    )
    found: dict[str | None, tuple[Claim, ...]] = {}
    for system in model.systems:
        here = about(drafts, system.stage)
        found[system.stage] = claims_of(here, scope_of(system), _subjects(system), problems)
    together = about_segments(drafts, problems, there=model.segments is not None)
    rest = (*about_experiment(drafts, model.experiment, problems), *together)
    if rest:
        first = model.systems[0]
        found[None] = found.get(None, ()) + claims_of(rest, scope_of(first), _subjects(first), problems)
    problems.raise_any()
    return found
