"""Figures of a report: χ in time, singular values in time, coefficients with their identified forms."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from obscli.core.figure import Curve, Figure, Panel
from obscli.core.verification import Verification
from obscli.model.notation import decimal_text
from obscli.numeric.finding import CoefficientCurve, EchelonFinding, NumericFinding
from obscli.pipelines.stage_result import StageChecks, StageResult


#: Coefficients in one figure.
PANELS: Final = 4

#: Singular values so far below the tolerance are zeros of the arithmetic and not drawn.
FLOOR: Final = 1e-4


def analysis_figures(results: tuple[StageResult, ...]) -> Iterator[Figure]:
    """Yield the figures of an analysis: per stage χ, singular values, coefficients."""
    for result in results:
        time = result.system.time
        if isinstance(result.verification, Verification):
            yield from chi_figure(f"{result.title}-chi", result.title, result.verification, time)
        if isinstance(result.numeric, NumericFinding):
            yield _singular_values(result.title, result.numeric, time)
        if result.basis is not None:
            yield from _coefficients(result.title, result.basis, time)


def check_figures(results: tuple[StageChecks, ...]) -> Iterator[Figure]:
    """Yield the figures of a verification: χ of every claimed basis and of the analysis itself."""
    for result in results:
        time = result.system.time
        if isinstance(result.verification, Verification):
            yield from chi_figure(
                f"{result.title}-chi", f"{result.title}: the analysis", result.verification, time
            )
        claimed = [check.verification for check in result.checks if check.verification is not None]
        for k, one in enumerate(claimed, 1):
            yield from chi_figure(
                f"{result.title}-claim-{k}-chi", f"{result.title}: claimed basis {k}", one, time
            )


def chi_figure(name: str, title: str, found: Verification, time: str) -> Iterator[Figure]:
    """Yield χ against t with its bound (the paper's figs. 1, 2), where there is a kernel."""
    points = [(p.t, p.chi, p.bound) for p in found.points if p.chi is not None and p.bound is not None]
    if not points:
        return
    t, chi, bound = (tuple(column) for column in zip(*points, strict=True))
    curves = (
        Curve("χ, largest leak of a combination into the kernel", t, chi),
        Curve("what rounding may account for", t, bound, "limit"),
    )
    panel = Panel(f"{found.agree} of {len(found.points)} instants agree", "χ", curves, logarithmic=True)
    yield Figure(name, title, time, (panel,))


def _singular_values(title: str, found: NumericFinding, time: str) -> Figure:
    t = tuple(point.t for point in found.points)
    rank = found.rank or 0
    floor = min(point.tolerance for point in found.points) * FLOOR
    curves = []
    for k in range(found.system.n):
        values = tuple(point.singular_values[k] for point in found.points)
        if max(values) < floor:
            continue
        kept = k < rank
        label = {0: "counted as information", rank: "dropped"}.get(k, "")
        curves.append(Curve(label, t, values, "main" if kept else "one of many"))
    tolerance = tuple(point.tolerance for point in found.points)
    curves.append(Curve("tolerance of the rank", t, tolerance, "limit"))
    panel = Panel(
        f"rank {found.rank} of {found.system.n}", "singular values", tuple(curves), logarithmic=True
    )
    return Figure(f"{title}-singular-values", f"{title}: square root of the Gramian, scaled", time, (panel,))


def _coefficients(title: str, found: EchelonFinding, time: str) -> Iterator[Figure]:
    curves = found.curves
    for k in range(0, len(curves), PANELS):
        part = curves[k : k + PANELS]
        number = f"-{k // PANELS + 1}" if len(curves) > PANELS else ""
        panels = tuple(_coefficient(one) for one in part)
        yield Figure(
            f"{title}-coefficients{number}", f"{title}: coefficients of the combinations", time, panels
        )


def _coefficient(one: CoefficientCurve) -> Panel:
    curves = [Curve("from the Gramian", one.instants, one.values, marked=True)]
    if one.guess.expression is not None and one.fitted is not None:
        text = decimal_text(one.guess.expression)
        curves.append(Curve(f"{one.standing}: {text}", one.instants, one.fitted, "reference"))
    return Panel(f"coefficient of {one.free} beside {one.pivot}", "", tuple(curves))
