"""Linear combinations of the states, as quantities and claims give them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from obscli.model.declaration import component_names
from obscli.model.draft import Draft
from obscli.model.evaluate import evaluate
from obscli.model.expression import ONE, ZERO, Expression, is_zero
from obscli.model.form import Form
from obscli.model.formula import Formula
from obscli.model.scope import Scope
from obscli.model.system import Covector, Quantity
from obscli.model.tensor import Tensor
from obscli.model.tokens import is_name
from obscli.model.trouble import Problems


def linear_values(
    draft: Draft, *, inputs: bool, nominal: Mapping[str, Expression] | None = None
) -> dict[str, Tensor]:
    """Return the states (and inputs, disturbances) as linear symbols.

    Parameters
    ----------
    nominal : the values to linearise about, by name; None: where everything has to be linear
    """
    held = None if nominal is None else frozenset(nominal)
    groups = [draft.states, draft.inputs, draft.disturbances] if inputs else [draft.states]
    values: dict[str, Tensor] = {}
    for one in (one for group in groups for one in group):
        parts = {name: Form((nominal or {}).get(name, ZERO), {name: ONE}, held) for name in one.components}
        values.update({name: Tensor((), (form,)) for name, form in parts.items()})
        for alias, name in one.aliases():
            values.setdefault(alias, values[name])
        values[one.name] = one.tensor(parts.__getitem__)
    return values


def quantity(name: str, formula: Formula, scope: Scope, problems: Problems) -> Iterator[Quantity]:
    """Yield the linear combination; for a vector, that of every component."""
    value = evaluate(formula, scope, problems)
    if value is None:
        return
    shape = () if value.is_scalar else value.shape
    names = component_names(name, shape) if is_name(name) else (name,) * len(value.entries)
    for one, form in zip(names, value.entries, strict=True):
        found = combination(one, form, formula, problems)
        if found is not None:
            yield found


def combination(name: str, form: Form, formula: Formula, problems: Problems) -> Quantity | None:
    """Return the form as a quantity; a constant term or an empty form is reported."""
    linear = _nonzero(form.linear)
    if not is_zero(form.constant):
        problems.add(
            formula.problem("a term without a state: a linear combination of the states is expected")
        )
    elif not linear:
        problems.add(formula.problem("this combination of the states is zero"))
    else:
        return Quantity(name, linear, formula.place, formula.text)
    return None


def _nonzero(linear: Covector) -> dict[str, Expression]:
    return {name: node for name, node in linear.items() if not is_zero(node)}
