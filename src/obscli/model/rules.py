"""Derivative rules of functions: q' = ½ Ω(w) q, known as soon as the names they use are."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from obscli.model.draft import Draft
from obscli.model.evaluate import evaluate
from obscli.model.expression import Expression, TimeDerivative, symbols
from obscli.model.form import Impossible
from obscli.model.formula import Formula
from obscli.model.scope import Scope
from obscli.model.tensor import Tensor, named
from obscli.model.trouble import Incomplete, Problems


MOST_DERIVED: Final = 6_000


@dataclass(slots=True)
class _Pending:
    """A rule waiting for ``let`` names."""

    formula: Formula
    cells: tuple[str | None, ...]
    shape: tuple[int, ...]
    missing: set[str]


class Rules:
    """The rules of one stage; ``known`` grows while the entries of ``let`` are evaluated."""

    def __init__(self, draft: Draft, fixed: Mapping[str, Tensor]) -> None:
        self.known: dict[str, Expression] = {}
        self._pending: dict[str, _Pending] = {}
        self._users: dict[str, list[str]] = {}
        self._waiting: set[str] = set()
        plain: list[str] = []
        for one in draft.functions:
            cells = tuple(None if cell in fixed else cell for cell in one.declared.cells)
            if one.derivative is None:
                plain += [name for name in one.declared.components if name not in fixed]
            elif any(cells):
                missing = set(one.derivative.names & draft.let.keys())
                self._wait(one.declared.name, _Pending(one.derivative, cells, one.declared.shape, missing))
        self._derive = TimeDerivative(draft.time or "t", self.known, frozenset(plain), MOST_DERIVED)

    def _wait(self, name: str, rule: _Pending) -> None:
        self._pending[name] = rule
        self._waiting.update(cell for cell in rule.cells if cell)
        for used in rule.missing:
            self._users.setdefault(used, []).append(name)

    def derive(self, node: Expression) -> Expression:
        """Return d/dt of the node."""
        missing = sorted(symbols(node) & self._waiting) if self._waiting else []
        if missing:
            hint = "move this entry below those that the rule under `functions` uses"
            raise Impossible(f"the derivative of '{missing[0]}' uses names defined further down", hint)
        return self._derive(node)

    def begin(self, scope: Scope, problems: Problems) -> None:
        """Evaluate the rules that use no ``let`` name."""
        for name in [name for name, rule in self._pending.items() if not rule.missing]:
            self._settle(name, scope, problems)

    def learn(self, name: str, scope: Scope, problems: Problems) -> None:
        """Evaluate the rules that waited only for this ``let`` name."""
        for user in self._users.get(name, ()):
            rule = self._pending[user]
            rule.missing.discard(name)
            if not rule.missing:
                self._settle(user, scope, problems)

    def end(self, scope: Scope, problems: Problems) -> None:
        """Evaluate what remains, so that its troubles are reported."""
        for name in list(self._pending):
            self._settle(name, scope, problems)

    def _settle(self, name: str, scope: Scope, problems: Problems) -> None:
        rule = self._pending.pop(name)
        self._waiting.difference_update(cell for cell in rule.cells if cell)
        try:
            value = evaluate(rule.formula, scope, problems)
        except Incomplete:
            value = None
        if value is None:
            return
        if value.shape != rule.shape and not (value.is_scalar and not rule.shape):
            whole = named(rule.shape)
            message = f"the derivative of {whole} is {whole}, not {named(value.shape)}"
            problems.add(rule.formula.problem(message))
            return
        for cell, entry in zip(rule.cells, value.entries, strict=True):
            if cell:
                self.known[cell] = entry.constant
