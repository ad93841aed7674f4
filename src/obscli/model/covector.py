"""Expressions given after the file was read: on the command line, in certificates, in files of their own."""

from __future__ import annotations

from pathlib import Path

from obscli.model.compose import compose
from obscli.model.constant import constant
from obscli.model.expression import ONE, Expression, Symbol, TimeDerivative
from obscli.model.form import Form
from obscli.model.formula import Formula, formula
from obscli.model.keys import items_of
from obscli.model.linear import quantity
from obscli.model.meter import Meter
from obscli.model.scope import Scope
from obscli.model.source import checked, read_source
from obscli.model.system import Quantity, System
from obscli.model.tensor import Tensor, scalar
from obscli.model.tree import Scalar
from obscli.model.trouble import Problems


def scope_of(system: System) -> Scope:
    """Return the names of the system: those of its file, or those the system itself has."""
    if system.scope is not None:
        return system.scope
    names = [system.time, *(one.name for one in system.parameters), *(one.name for one in system.functions)]
    values = {name: scalar(Symbol(name)) for name in names}
    values.update({name: Tensor((), (Form(linear={name: ONE}),)) for name in system.state_names})
    rules = {one.name: one.derivative for one in system.functions if one.derivative is not None}
    plain = frozenset(one.name for one in system.functions) - rules.keys()
    return Scope(values, TimeDerivative(system.time, rules, plain), Meter())


def _formula(text: str, origin: str, problems: Problems) -> Formula:
    source = checked(text, origin)
    return formula(Scalar(source, 1, 1, text, text), "", problems)


def parse_scalar(system: System, text: str, origin: str) -> Expression:
    """Return the expression a text stands for, free of states.

    Parameters
    ----------
    origin : what messages call the text: an option, a file

    Raises
    ------
    ModelError
        where the text is no scalar of the system's names
    """
    problems = Problems()
    value = constant(_formula(text, origin, problems), scope_of(system), problems)
    problems.raise_any()
    assert value is not None
    return value


def parse_covector(system: System, text: str, origin: str) -> Quantity:
    """Return the linear combination of states a text stands for; otherwise as ``parse_scalar``."""
    problems = Problems()
    whole = _formula(text, origin, problems)
    found = list(quantity(text.strip(), whole, scope_of(system), problems))
    if len(found) > 1:
        problems.add(whole.problem(f"one linear combination is expected here, not a vector of {len(found)}"))
    problems.raise_any()
    return found[0]


def parse_covectors_file(system: System, path: str | Path) -> tuple[Quantity, ...]:
    """Return the linear combinations listed in a YAML file."""
    problems = Problems()
    root = compose(read_source(path), problems)
    found: list[Quantity] = []
    if isinstance(root, Scalar) and not root.is_null:
        hint = "one combination a line, each behind a dash: - b_g2 + omega*M_g21"
        problems.add(root.problem("", "a list of combinations is expected here, not a text", hint))
        problems.raise_any()
    for k, item in enumerate(() if root is None else items_of(root, "", problems), start=1):
        one = formula(item, f"[{k}]", problems)
        found += quantity(one.text or f"[{k}]", one, scope_of(system), problems)
    problems.raise_any()
    return tuple(found)
