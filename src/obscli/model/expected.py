"""``measures``, ``require``, ``stationary`` under ``expect``: what is to be found, which accuracy to be met.

A value stands for the system as a whole, or by the name of a state, a vector (for each of its components), a
quantity, or whatever else the measure speaks of. Which measures there are is not known here.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Final, cast
from unicodedata import normalize

from obscli.core.place import Place
from obscli.model.constant import unmoving
from obscli.model.declaration import is_part_of
from obscli.model.expression import Expression
from obscli.model.formula import Formula, formula
from obscli.model.keys import choice_of, fields, whole_of
from obscli.model.scope import Scope
from obscli.model.sign import sign
from obscli.model.system import ExpectedMeasure, ExpectedStationary, Lifted, Met, Quantity, State
from obscli.model.tokens import is_name
from obscli.model.tree import Broken, Node, Scalar, kind
from obscli.model.tree import Mapping as MappingNode
from obscli.model.trouble import Problems, nearest, shown


VALUE_KEYS: Final = ("value", "tolerance")
MET: Final = ("met", "missed")
LIFTED: Final = ("full", "smallest", "outputs", "same_order")


@dataclass(frozen=True, slots=True, eq=False)
class MeasureDraft:
    """One value: of a measure, and of one of its targets (None: of the system); no formula: infinite."""

    measure: Scalar
    target: Scalar | None
    place: Place
    value: Formula | None
    tolerance: Formula | None = None


@dataclass(frozen=True, slots=True, eq=False)
class RequiredDraft:
    """Whether what is required of a name (None: everything that is) is met."""

    name: Scalar | None
    word: Met
    place: Place


@dataclass(frozen=True, slots=True, eq=False)
class Subjects:
    """The states and quantities that a name may stand for."""

    states: Sequence[State]
    quantities: Sequence[Quantity]

    def named(self, key: Scalar, path: str, problems: Problems) -> list[str]:
        """Return the names that a name stands for: one, or the components of a vector; none is reported."""
        name, known = normalize("NFC", key.text), [one.name for one in self.quantities]
        found = [one.name for one in self.states if name and name in (one.name, one.vector)]
        found += [one for one in known if one == name or (name not in known and is_part_of(one, name))]
        if not found:
            spellings = [*known, *(word for one in self.states for word in (one.name, one.vector) if word)]
            message = f"'{shown(name)}' is no state and no quantity{nearest(name, spellings)}"
            problems.add(key.problem(path, message))
        return found


def read_measures(node: Node | None, path: str, problems: Problems) -> tuple[MeasureDraft, ...]:
    """Read the values of measures: each a value, or a mapping of names to values."""
    found: list[MeasureDraft] = []
    for name, (key, value) in fields(node, path, None, problems).items():
        below = f"{path}.{name}"
        if isinstance(value, MappingNode) and all(value.get(one) is None for one in VALUE_KEYS):
            for target, (target_key, one) in fields(value, below, None, problems).items():
                found += _read_value(key, target_key, one, f"{below}.{target}", problems)
        else:
            found += _read_value(key, None, value, below, problems)
    return tuple(found)


def _read_value(
    measure: Scalar, target: Scalar | None, node: Node, path: str, problems: Problems
) -> Iterator[MeasureDraft]:
    """Yield one value, written alone or with its tolerance."""
    if not isinstance(node, MappingNode):
        yield MeasureDraft(measure, target, node.place, _value(node, path, problems))
        return
    given = fields(node, path, VALUE_KEYS, problems)
    if "value" not in given:
        problems.add(node.problem(path, "`value` is missing here", "{value: 0.0225, tolerance: 1e-3}"))
        return
    value, tolerance = given["value"][1], given.get("tolerance")
    yield MeasureDraft(
        measure,
        target,
        value.place,
        _value(value, f"{path}.value", problems),
        None if tolerance is None else _parsed(tolerance[1], f"{path}.tolerance", problems),
    )


def _value(node: Node, path: str, problems: Problems) -> Formula | None:
    """Return the expression, None for infinity."""
    is_infinite = isinstance(node, Scalar) and node.text.strip() == "inf"
    return None if is_infinite else _parsed(node, path, problems)


def _parsed(node: Node, path: str, problems: Problems) -> Formula:
    """Return the expression; what is none is reported."""
    if isinstance(node, Scalar) and not node.is_null:
        return formula(node, path, problems)
    if not isinstance(node, Broken):
        is_missing = isinstance(node, Scalar)
        message = "a value is missing here" if is_missing else f"a value is expected here, not {kind(node)}"
        problems.add(node.problem(path, message, "a constant expression, or inf"))
    return Formula(path, node, (), sound=False)


def read_required(node: Node | None, path: str, problems: Problems) -> tuple[RequiredDraft, ...]:
    """Read whether requirements are met: one word for all, or by name."""
    if node is None or isinstance(node, Broken):
        return ()
    if not isinstance(node, MappingNode):
        return tuple(_read_word(None, node, path, problems))
    given = fields(node, path, None, problems)
    return tuple(
        one
        for name, (key, value) in given.items()
        for one in _read_word(key, value, f"{path}.{name}", problems)
    )


def read_stationary(node: Node | None, path: str, problems: Problems) -> ExpectedStationary | None:
    """Read the sizes of stationary systems, or `false` where there are none."""
    if node is None or isinstance(node, Broken):
        return None
    if isinstance(node, Scalar) and not node.is_null:
        choice_of((node, node), path, ("false",), problems)
        return ExpectedStationary(node.place, reducible=False)
    if not isinstance(node, MappingNode):
        sizes_of = "sizes such as {full: 108, smallest: 19}, or `false`, are expected here"
        problems.add(node.problem(path, sizes_of))
        return None
    sizes: dict[Lifted, tuple[int, Place]] = {}
    for name, (_, value) in fields(node, path, LIFTED, problems).items():
        size = whole_of(value, f"{path}.{name}", problems, least=0)
        if size is not None:
            sizes[cast("Lifted", name)] = (size, value.place)
    return ExpectedStationary(node.place, reducible=True, sizes=sizes)


def _read_word(name: Scalar | None, node: Node, path: str, problems: Problems) -> Iterator[RequiredDraft]:
    if isinstance(node, Scalar) and not node.is_null:
        word = choice_of((node, node), path, MET, problems)
        if word:
            yield RequiredDraft(name, cast("Met", word), node.place)
    elif not isinstance(node, Broken):
        found = "" if isinstance(node, Scalar) else f", not {kind(node)}"
        problems.add(node.problem(path, f"`met` or `missed` is expected here{found}"))


def expected_measures(
    drafts: Sequence[MeasureDraft], path: str, subjects: Subjects, scope: Scope, problems: Problems
) -> tuple[ExpectedMeasure, ...]:
    """Return the values expected of measures, in the names of a stage."""
    found: dict[tuple[str, str | None], ExpectedMeasure] = {}
    for draft in drafts:
        key, below = draft.measure.text, f"{path}.{draft.measure.text}"
        value = None if draft.value is None else unmoving(draft.value, scope, problems)
        tolerance = _tolerance(draft.tolerance, scope, problems)
        for target in _targets(draft, below, subjects, problems):
            if (key, target) in found and draft.target is not None:
                problems.add(draft.target.problem(below, f"'{shown(target or '')}' is given twice"))
            place = draft.place, draft.measure.place
            found[key, target] = ExpectedMeasure(key, target, value, tolerance, *place)
    return tuple(found.values())


def _targets(draft: MeasureDraft, path: str, subjects: Subjects, problems: Problems) -> Sequence[str | None]:
    """Return what a value is of; what is no name may be a combination, or a mode, and is kept as it is."""
    if draft.target is None:
        return (None,)
    if not is_name(draft.target.text):
        return (" ".join(draft.target.text.split()),)
    return subjects.named(draft.target, path, problems)


def _tolerance(draft: Formula | None, scope: Scope, problems: Problems) -> Expression | None:
    if draft is None:
        return None
    value = unmoving(draft, scope, problems)
    if value is not None and sign(value) in {0, -1}:
        problems.add(draft.problem("a positive number is expected here: how far off, relative to the value"))
    return value


def expected_requirements(
    drafts: Sequence[RequiredDraft], path: str, subjects: Subjects, problems: Problems
) -> Mapping[str, tuple[Met, Place]]:
    """Return whether requirements are to be met, by name; "" for all."""
    found: dict[str, tuple[Met, Place]] = {}
    for draft in drafts:
        for name in [""] if draft.name is None else subjects.named(draft.name, path, problems):
            if name in found and draft.name is not None:
                problems.add(draft.name.problem(path, f"'{shown(name)}' is given twice"))
            found[name] = (draft.word, draft.place)
    return found
