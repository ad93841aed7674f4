"""``linearize``: the nominal trajectory about which right-hand sides and outputs are taken to first order.

x = x̄ + δx, u = ū + δu, w = δw:

    δx' = ∂f/∂x δx + ∂f/∂u δu + ∂f/∂w δw,    δy = ∂h/∂x δx,    all at x̄(t), ū(t), w = 0
"""

from __future__ import annotations

from collections.abc import Mapping

from obscli.model.declaration import Declared
from obscli.model.draft import Draft, Entries, Entry
from obscli.model.dynamics import columns_of, names_of
from obscli.model.evaluate import evaluate
from obscli.model.expression import ZERO, Expression, Symbol, is_zero
from obscli.model.fixing import spread
from obscli.model.keys import fields
from obscli.model.scope import Scope
from obscli.model.sections import entries
from obscli.model.tensor import Tensor, named
from obscli.model.tree import Broken, Node
from obscli.model.trouble import Problems, nearest, shown


PATH = "linearize.trajectory"


def read_linearize(node: Node | None, problems: Problems) -> Entries | None:
    """Return the trajectory as written, by state or input; None where nothing is to be linearised."""
    if node is None:
        return None
    before = len(problems)
    given = fields(node, "linearize", ("trajectory",), problems)
    if "trajectory" not in given:
        if len(problems) == before and not isinstance(node, Broken):
            hint = "linearize: {trajectory: {state: value, …}}"
            problems.add(node.problem("linearize", "`trajectory` is missing: the nominal values", hint))
        return {}
    return entries(given["trajectory"][1], PATH, problems)


def check_linearize(draft: Draft, stages: Mapping[str, Draft], key: Node, problems: Problems) -> None:
    """Report a trajectory beside matrices, which have nothing to be linearised."""
    if all(one.dynamics is None and one.measurements is None for one in (draft, *stages.values())):
        message = "nothing is linearised: `A` and `H` are given as matrices"
        problems.add(key.problem("", message, "give `dynamics` and `measurements`, or delete `linearize`"))


def nominal_values(draft: Draft, scope: Scope, problems: Problems) -> dict[str, Expression]:
    """Return the value of every scalar that has one; a disturbance without one is zero.

    Parameters
    ----------
    scope : the names of the stage, states excepted

    Raises
    ------
    Incomplete
        where a value needs a name that only the stages define
    """
    if draft.linearize is None:
        return {}
    group = (*draft.states, *draft.inputs, *draft.disturbances)
    wholes = {one.name: one for one in group}
    scalars = {name: names_of(group)[j] for name, j in columns_of(group).items()}
    found: dict[str, Expression] = {}
    for name, entry in draft.linearize.items():
        if name not in wholes and name not in scalars:
            message = f"'{shown(name)}' is no state or input{nearest(name, (*wholes, *scalars))}"
            problems.add(entry.key.problem(PATH, message))
            continue
        own = wholes[name].components if name in wholes else (scalars[name],)
        if found.keys() & set(own):
            message = f"the value of '{shown(name)}' is given twice, with the whole and with a component"
            problems.add(entry.key.problem(PATH, message))
        found.update(dict.fromkeys(own, Symbol(name)))  # stands in for a value that is reported as wrong
        found.update(_value(name, wholes.get(name), own, entry, scope, problems))
    return {**dict.fromkeys(names_of(draft.disturbances), ZERO), **found}


def _value(
    name: str,
    whole: Declared | None,
    own: tuple[str, ...],
    entry: Entry,
    scope: Scope,
    problems: Problems,
) -> dict[str, Expression]:
    """Return the values of the components that one entry gives; none where it is wrong."""
    if entry.formula is None:
        problems.add(entry.key.problem(f"{PATH}.{name}", "an expression is missing here"))
        return {}
    value = evaluate(entry.formula, scope, problems)
    if value is None:
        return {}
    if whole is not None and whole.shape:
        _check_structure(whole, entry, value, problems)
        parts = spread(whole, entry, value, problems)
        return {cell: part.entries[0].constant for cell, part in parts.items()}
    if not value.is_scalar:
        problems.add(entry.formula.problem(f"'{name}' is a scalar; the value is {named(value.shape)}"))
        return {}
    return {own[0]: value.entries[0].constant}


def _check_structure(whole: Declared, entry: Entry, value: Tensor, problems: Problems) -> None:
    assert entry.formula is not None
    if value.shape != whole.shape:
        return
    pairs = zip(whole.cells, value.entries, strict=True)
    if any(cell is None and not is_zero(form.constant) for cell, form in pairs):
        message = "an entry that the structure of the matrix makes zero is not zero"
        problems.add(entry.formula.problem(message))
