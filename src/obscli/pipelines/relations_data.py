"""The relations of the method of unobservable states as JSON values."""

from __future__ import annotations

from obscli.exact.relations_finding import Canonical, Relation, Relations
from obscli.model.notation import covector_text, to_text
from obscli.model.system import System
from obscli.pipelines.certificate_data import covector_to_data


def relations_data(relations: Relations, system: System) -> dict[str, object]:
    """Return ``{exact, instant, relations, situations, differing, functions, notes}``.

    Each relation is ``function`` times the linear form ``coefficients`` in x0, part of ``output``;
    ``expression`` is the form up to a factor. ``functions`` explains names that occur in ``function``.
    """
    return {
        "exact": relations.exact,
        "instant": None if relations.instant is None else to_text(relations.instant),
        "relations": [_relation(one, system) for one in relations.relations],
        "situations": dict(relations.situations),
        "differing": list(relations.differing),
        "functions": [_canonical(one) for one in relations.canonical],
        "notes": list(relations.notes),
    }


def _relation(one: Relation, system: System) -> dict[str, object]:
    return {
        "function": to_text(one.function),
        "expression": covector_text(one.combination, system.state_names),
        "coefficients": covector_to_data(one.coefficients),
        "output": one.output,
        "independent": one.independent,
    }


def _canonical(one: Canonical) -> dict[str, object]:
    return {"names": list(one.names), "polynomial": [to_text(c) for c in one.polynomial]}
