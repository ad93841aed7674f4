"""Guessed forms of coefficients held against exact algebra: *proved* only where the two are the same."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from obscli.exact.errors import UndecidedError, UndefinedError
from obscli.exact.exact_system import ExactSystem, Row, read_system
from obscli.exact.finding import Analysis
from obscli.exact.sample_window import static
from obscli.numeric.finding import CoefficientCurve, EchelonFinding


def check_guesses(found: EchelonFinding, analysis: Analysis) -> EchelonFinding:
    """Return the guesses with their standing: proved, refuted, or still a guess where algebra cannot tell.

    Parameters
    ----------
    found : the basis in time with its guesses
    analysis : the exact analysis at generic values
    """
    forms = [one.guess.expression for one in found.curves if one.guess.expression is not None]
    entries = [e for one in analysis.combinations for e in one.coefficients.values()]
    try:
        exact = read_system(static(analysis.system), [*forms, *entries])
        rows = _rows(exact, analysis)
        return replace(found, curves=tuple(_checked(one, exact, rows) for one in found.curves))
    except (UndecidedError, UndefinedError):
        return found


def _rows(exact: ExactSystem, analysis: Analysis) -> dict[str, Row]:
    """Return the proved rows by the name of their pivot, as far as they are in reduced echelon form."""
    names = exact.system.state_names
    rows = [exact.row(one.coefficients) for one in analysis.combinations]
    pivots = [min(row) for row in rows]
    return {
        names[pivot]: row
        for pivot, row in zip(pivots, rows, strict=True)
        if not any(pivot in other for other in rows if other is not row)
    }


def _checked(one: CoefficientCurve, exact: ExactSystem, rows: Mapping[str, Row]) -> CoefficientCurve:
    expression = one.guess.expression
    if expression is None or one.pivot not in rows:
        return one
    names = exact.system.state_names
    row, pivot, free = rows[one.pivot], names.index(one.pivot), names.index(one.free)
    proved = row[free] / row[pivot] if free in row else exact.field.zero
    if exact.interpreter.read(expression) == proved:
        return replace(one, standing="proved")
    return one if one.guess.in_digits else replace(one, standing="refuted")
