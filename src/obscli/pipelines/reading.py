"""Reading a model with the user's changes, and choosing among its stages."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from obscli.model import reader
from obscli.model.dual import dual
from obscli.model.system import Claim, Model, System
from obscli.pipelines.request import Changes, RequestError


def load(
    path: str | Path,
    changes: Changes = Changes(),  # noqa: B008 - frozen and empty
    freed: tuple[str, ...] = (),
) -> Model:
    """Read a model file, no stage fixing what is ``freed``; raises ``ModelError`` with every problem."""
    return reader.load(
        Path(path),
        fix=changes.fix,
        settings=changes.settings,
        outputs=changes.outputs,
        without=changes.without,
        freed=freed,
    )


def with_claims(model: Model, path: str | Path) -> Model:
    """Return the model with the claims of a file in place of its own."""
    found = dict(reader.load_claims(model, path))
    later = tuple(claim for claims in found.values() for claim in claims if claim.experiment is not None)

    together = tuple(claim for claims in found.values() for claim in claims if claim.segments)

    def own(system: System) -> tuple[Claim, ...]:
        mine = found.get(system.stage, ())
        return tuple(claim for claim in mine if claim.experiment is None and not claim.segments)

    segments = model.segments and replace(model.segments, claims=together)
    systems = tuple(replace(one, claims=own(one)) for one in model.systems)
    return replace(model, systems=systems, claims=later, segments=segments)


def chosen_systems(model: Model, stages: tuple[str, ...]) -> tuple[System, ...]:
    """Return the systems of the named stages in the model's order, all where none is named."""
    known = [system.stage for system in model.systems if system.stage is not None]
    for stage in stages:
        if stage not in known:
            raise RequestError(unknown(f"{model.file}: no stage", stage, known))
    return tuple(system for system in model.systems if not stages or system.stage in stages)


def dual_model(model: Model, stages: tuple[str, ...]) -> Model:
    """Return the model with the duals of the named stages (none: all) in place of its systems.

    Raises
    ------
    RequestError
        where a stage is not there, or has neither inputs nor disturbances
    """
    systems = tuple(_dual(model, system) for system in chosen_systems(model, stages))
    return replace(model, systems=systems, experiment=None, require=(), claims=())


def _dual(model: Model, system: System) -> System:
    try:
        return dual(system)
    except ValueError:
        stage = f"stage {system.stage!r} has" if system.stage else "the model has"
        raise RequestError(
            f"{model.file}: {stage} nothing that acts on the states, so no dual: give `B` or `G`, or name "
            "`inputs` or `disturbances` and use them in `dynamics`"
        ) from None


def expanded_states(system: System, names: tuple[str, ...]) -> tuple[str, ...]:
    """Return state names with vector names replaced by their components."""
    expanded: list[str] = []
    for name in names:
        own = [state.name for state in system.states if name in (state.name, state.vector)]
        if not own:
            raise RequestError(unknown("no state", name, list(system.state_names)))
        expanded += own
    return tuple(dict.fromkeys(expanded))


def unknown(what: str, name: str, known: list[str]) -> str:
    """Return the message for a name that is not among those known."""
    import difflib  # noqa: PLC0415 - only an error pays for it

    near = difflib.get_close_matches(name, known, n=1)
    if near:
        return f"{what} {name!r}; did you mean {near[0]!r}?"
    listed = ", ".join(known[:20]) + (", …" if len(known) > 20 else "")
    return f"{what} {name!r}; there are: {listed}" if known else f"{what} {name!r}; the model has none"
