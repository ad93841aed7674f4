"""One stage of a file, all replacements made: from draft to ``System``."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from obscli.model.claims import ClaimDraft, about, claims_of
from obscli.model.constant import constant
from obscli.model.declaration import Declared
from obscli.model.discrete import check_noise, step_of
from obscli.model.draft import Draft, Entries
from obscli.model.dynamics import motion
from obscli.model.environment import Environment, environment
from obscli.model.expected import Subjects
from obscli.model.experiment import RunDraft
from obscli.model.expression import Expression
from obscli.model.formula import formula
from obscli.model.interval import kept_interval
from obscli.model.keys import text_of
from obscli.model.latex import checked_latex
from obscli.model.linear import linear_values, quantity
from obscli.model.meter import Meter
from obscli.model.noise import Targets, noise_of
from obscli.model.nominal import nominal_values
from obscli.model.observation import observation
from obscli.model.prior import prior_deviations
from obscli.model.sampling import sampled
from obscli.model.scope import Scope
from obscli.model.signals import signal_files
from obscli.model.system import Quantity, State, System
from obscli.model.trouble import Incomplete, Problems


@dataclass(frozen=True, slots=True, eq=False)
class Setting:
    """What a stage is elaborated with: its name, fixes from outside, claims, what other stages define.

    ``run``: the run, where it is one: its fixes come last.
    ``sound``: nothing was wrong in reading the sections, so that what is missing is missing in the file.
    """

    stage: str | None
    base: bool
    sound: bool
    fix: Entries
    elsewhere: Mapping[str, str]
    claims: tuple[ClaimDraft, ...]
    meter: Meter
    run: RunDraft | None = None


def elaborate(draft: Draft, setting: Setting, problems: Problems) -> System | None:
    """Return the system of one stage; None where it is wrong (reported) or incomplete by itself."""
    try:
        return _elaborate(draft, setting, problems)
    except Incomplete:
        return None


def _elaborate(draft: Draft, setting: Setting, problems: Problems) -> System | None:
    known = _known(draft, setting, problems)
    states = _states(draft, known, problems)
    if not draft.states_sound:
        return None
    _require_files(draft, setting, problems)
    nominal = nominal_values(draft, known.scope, problems)
    moving = known.scope.with_values(linear_values(draft, inputs=True, nominal=nominal))
    seen = known.scope.with_values(linear_values(draft, inputs=False, nominal=nominal))
    still = known.scope.with_values(linear_values(draft, inputs=False))
    step = step_of(draft, known, problems)
    dynamics = motion(draft, known.scope, moving, problems)
    measured = observation(draft, known.scope, seen, problems)
    if dynamics is None or measured is None:
        _report_missing(draft, setting, problems)
        return None
    H, outputs = measured[0], sampled(measured[1], draft, known, problems)
    targets = Targets(
        tuple((state.name, state.vector) for state in states),
        _disturbances(draft, dynamics.disturbances),
        tuple((output.name, output.vector) for output in outputs),
        _sampled(draft),
    )
    quantities = _quantities(draft, still, problems)
    noise = noise_of(draft.noise, targets, known.scope, problems)
    check_noise(draft, noise, problems)
    return System(
        stage=setting.stage,
        time=draft.time or "t",
        parameters=known.parameters,
        functions=known.functions,
        invariants=known.invariants,
        states=states,
        outputs=outputs,
        A=dynamics.A,
        H=H,
        B=dynamics.B,
        G=dynamics.G,
        inputs=dynamics.inputs,
        disturbances=dynamics.disturbances,
        quantities=quantities,
        claims=claims_of(about(setting.claims, setting.stage), still, Subjects(states, quantities), problems),
        noise=noise,
        prior=prior_deviations(noise, states),
        interval=kept_interval(draft.interval, "interval", known.scope, problems),
        scope=still,
        discrete=draft.is_discrete,
        step=step,
        fixed=tuple(draft.fix),
        signals=signal_files(draft, {one.name for one in known.functions}),
    )


def _require_files(draft: Draft, setting: Setting, problems: Problems) -> None:
    """Report signals without a file; the base may wait for its stages."""
    for one in draft.sampled or ():
        if one.file is None and setting.base:
            raise Incomplete("file")
        if one.file is None and setting.sound:
            problems.add(one.node.problem("signals", "`file` is missing: the file with the samples"))


def _sampled(draft: Draft) -> tuple[tuple[str, str], ...]:
    """Return the scalar functions that are signals, fixed or not, each with the name of its vector."""
    names = {one.name for file in draft.sampled or () for one in file.signals}
    return tuple(
        (cell, one.declared.vector)
        for one in draft.functions
        if one.declared.name in names
        for cell in one.declared.components
    )


def _known(draft: Draft, setting: Setting, problems: Problems) -> Environment:
    """Return what the names of the stage stand for."""
    return environment(
        draft,
        setting.fix,
        setting.run.fix if setting.run else {},
        setting.elsewhere,
        setting.meter,
        problems,
        base=setting.base,
    )


def _disturbances(draft: Draft, names: tuple[str, ...]) -> tuple[tuple[str, str], ...]:
    """Return the scalar disturbances, each with the name it was declared under."""
    whole = {part: one.name for one in draft.disturbances for part in one.components}
    return tuple((name, whole.get(name, "")) for name in names)


def _report_missing(draft: Draft, setting: Setting, problems: Problems) -> None:
    """Report that a matrix is missing altogether, unless the base only waits for its stages."""
    pairs = (("A", "dynamics", draft.dynamics), ("H", "measurements", draft.measurements))
    for matrix, sides, given in pairs:
        if (
            matrix not in draft.matrices
            and given is None
            and not (matrix == "A" and draft.is_discrete)
            and not setting.base
            and setting.sound
            and not problems
        ):
            what = "run" if setting.run else "stage"
            where = f"{what} '{setting.stage}'" if setting.stage else "the model"
            problems.add(draft.node.problem("", f"{where} has neither `{matrix}` nor `{sides}`"))


def _quantities(draft: Draft, scope: Scope, problems: Problems) -> tuple[Quantity, ...]:
    found: list[Quantity] = []
    for name, entry in draft.quantities.items():
        if entry.formula is None:
            problems.add(entry.key.problem(f"quantities.{name}", "an expression is missing here"))
        else:
            found += quantity(name, entry.formula, scope, problems)
    return tuple(found)


def _states(draft: Draft, known: Environment, problems: Problems) -> tuple[State, ...]:
    return tuple(state for one in draft.states for state in _components(one, known, problems))


def _components(one: Declared, known: Environment, problems: Problems) -> list[State]:
    path = f"states.{one.name}"
    latex = text_of(one.given.get("latex"), f"{path}.latex", problems)
    if latex and "latex" in one.given:
        checked_latex(latex, one.given["latex"][1], f"{path}.latex", problems)
    scale: Expression | None = None
    if "scale" in one.given:
        scale = constant(formula(one.given["scale"][1], f"{path}.scale", problems), known.scope, problems)
    return [
        State(name, one.key.place, one.vector, one.unit, one.description, _latex(one, name, latex), scale)
        for name in one.components
    ]


def _latex(one: Declared, name: str, latex: str) -> str:
    """Return the LaTeX of a component: that of the whole with the index below."""
    suffix = name[len(one.name) :].strip("_").replace("_", ",")
    return f"{{{latex}}}_{{{suffix}}}" if latex and suffix else latex
