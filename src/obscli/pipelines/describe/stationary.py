"""A stationary form in words and formulas: functions of time, new variables, equations, agreement."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Final

from obscli.core.document import (
    Block,
    Column,
    Details,
    Heading,
    Inline,
    Listing,
    Math,
    Note,
    Paragraph,
    Table,
    Text,
    VerdictLine,
    line,
    plain,
)
from obscli.core.number import counted
from obscli.exact.lift_finding import Functions, Lift, Obstacle, Stationary
from obscli.model.expression import Expression
from obscli.model.notation import covector_latex, covector_text, latex_name, to_latex, to_text
from obscli.model.system import Covector
from obscli.model.variables import is_state
from obscli.numeric.finding import NotComputed
from obscli.pipelines.describe.checks import KINDS
from obscli.pipelines.describe.formulas import combination
from obscli.pipelines.describe.words import names
from obscli.pipelines.latex_names import latex_names
from obscli.pipelines.transform_result import NoStationaryForm, StationaryForm, TransformResult


VARIABLE_COLUMNS: Final = (Column("variable"), Column("is", breaks=True))
FORMULA_COLUMNS: Final = (Column(breaks=True),)

#: So many entries that stand in the way for the same reason are named.
MOST_ENTRIES: Final = 4


def stationary_blocks(result: TransformResult, form: StationaryForm) -> Iterator[Block]:
    """Yield the lifts with their sizes, the smallest one written out, and what was checked."""
    found = form.found
    yield Paragraph(plain(_summary(result, found)))
    yield from _sizes(found)
    if _varies(found.functions):
        yield from _functions(result, found.functions)
    yield from _variables(result, found.smallest)
    yield from _equations(result, found.smallest)
    yield from _same_order(result, found)
    yield from _combinations(result, found)
    yield from _checks(form)


def _same_order(result: TransformResult, found: Stationary) -> Iterator[Block]:
    """Yield the change of variables; as details where the smallest lift has fewer."""
    lift = found.same_order
    states = result.system.state_names
    if lift is None or _texts(lift, states) == _texts(found.smallest, states):
        return
    blocks = (
        Heading(2, plain(f"A stationary system of the same order ({lift.n})")),
        *_variables(result, lift, heading=""),
        *_equations(result, lift, heading=""),
    )
    yield from blocks if lift.n <= found.smallest.n else (Details(blocks),)


def _texts(lift: Lift, states: tuple[str, ...]) -> list[str]:
    return [covector_text(form, states) for form in lift.variables]


def _varies(functions: Functions) -> bool:
    """Whether anything depends on time: functions that are not constant."""
    return any(functions.S)


def not_reducible_blocks(form: NoStationaryForm) -> Iterator[Block]:
    """Yield what stands in the way; of a periodic system what Floquet and Lyapunov give in numbers."""
    yield VerdictLine("open", plain("not reducible in this way: no finite stationary system was found"))
    entries: dict[str, list[Obstacle]] = {}
    for one in form.found.obstacles:
        entries.setdefault(one.reason, []).append(one)
    yield Listing(tuple(_obstacle(reason, same) for reason, same in entries.items()))
    if form.floquet is None:
        return
    yield Heading(2, plain("Floquet and Lyapunov"))
    if isinstance(form.floquet, NotComputed):
        yield Note("note", plain(f"periodic, but no constant equivalent in numbers: {form.floquet.reason}"))
        return
    from obscli.pipelines.describe.floquet import floquet_blocks  # noqa: PLC0415 - floating point

    yield from floquet_blocks(form.floquet)


def _obstacle(reason: str, same: Sequence[Obstacle]) -> Inline:
    """Name the entries that the same thing is wrong with, and where the first of them stands."""
    named = ", ".join(one.entry for one in same[:MOST_ENTRIES])
    more = f" and {len(same) - MOST_ENTRIES} more" if len(same) > MOST_ENTRIES else ""
    place = f" ({same[0].place})" if same[0].place else ""
    return (Text(f"{reason}: "), Text(f"{named}{more}", "name"), Text(place, "faint"))


def _summary(result: TransformResult, found: Stationary) -> str:
    n = result.system.n
    if not _varies(found.functions):
        return f"The system is time-invariant as it stands: {counted(n, 'state')}."
    full = "" if found.full is None else f", where the full lift has {found.full.n}"
    return (
        f"{n} states that depend on time → {counted(found.smallest.n, 'time-invariant equation')} for "
        f"z = V(t) x{full}."
    )


def _sizes(found: Stationary) -> Iterator[Block]:
    """Say how large each stationary system is, and what of it the outputs show."""
    rows: list[tuple[str, str, str]] = []
    if found.full is not None:
        rows.append(
            ("full lift", str(found.full.n), f"(x1, f ⊗ x2), of which the outputs show {found.full.rank}")
        )
    rows.append(("smallest", str(found.smallest.n), f"of which the outputs show {found.rank}"))
    rows.append(("outputs alone", str(found.observable.n), "all observable"))
    order = "none found" if found.same_order is None else str(found.same_order.n)
    rows.append(("same order", order, "x = T(t) z" if found.same_order is not None else ""))
    yield Table(
        (Column("stationary system"), Column("states", "right"), Column(breaks=True)),
        tuple((line(Text(a)), line(Text(b)), line(Text(c, "faint"))) for a, b, c in rows),
    )


def _functions(result: TransformResult, functions: Functions) -> Iterator[Block]:
    known = latex_names(result.system)
    content: list[Text | Math] = [Text("Functions of time, f' = S f:"), Text(" ")]
    for k, one in enumerate(functions.f):
        content += [*([Text(", ")] if k else []), Math(to_text(one), to_latex(one, known))]
    yield Paragraph(tuple(content))
    rows = []
    for one, row in zip(functions.f, functions.S, strict=True):
        if row:
            right = " + ".join(_product(entry, functions.f[j]) for j, entry in sorted(row.items()))
            rows.append(plain(f"({to_text(one)})' = {right}"))
    if rows:
        yield Details((Listing(tuple(rows)),))


def _product(entry: Expression, function: Expression) -> str:
    return f"({to_text(entry)})*{to_text(function)}"


def _variables(result: TransformResult, lift: Lift, heading: str = "Variables") -> Iterator[Block]:
    """Yield the meaning of the variables that are no states."""
    pairs = list(zip(lift.names, lift.variables, strict=True))
    rows = [(name, form) for name, form in pairs if not is_state(form)]
    if heading:
        yield Heading(2, plain(heading))
    if rows:
        yield Table(
            VARIABLE_COLUMNS,
            tuple((line(Text(name, "name")), line(combination(form, result.system))) for name, form in rows),
        )
    kept = tuple(name for name, form in pairs if is_state(form))
    if kept:
        yield Paragraph((Text("as they were: ", "faint"), *names(kept)))


def _equations(result: TransformResult, lift: Lift, heading: str = "Stationary equations") -> Iterator[Block]:
    lines = [
        _equation(result, lift, name, row, prime="'")
        for name, row in zip(lift.names, lift.A, strict=True)
        if row
    ]
    outputs = zip(result.system.outputs, lift.H, strict=True)
    lines += [_equation(result, lift, output.name, row) for output, row in outputs]
    if heading:
        yield Heading(2, plain(heading))
    yield Table(FORMULA_COLUMNS, tuple((line(one),) for one in lines))
    still = tuple(name for name, row in zip(lift.names, lift.A, strict=True) if not row)
    if still:
        yield Paragraph((Text("constant: ", "faint"), *names(still)))


def _equation(
    result: TransformResult, lift: Lift, name: str, row: Mapping[int, Expression], prime: str = ""
) -> Math:
    form: Covector = {lift.names[j]: entry for j, entry in row.items()}
    known = latex_names(result.system)
    symbol = known.get(name) or latex_name(name)
    left = rf"\dot{{{symbol}}}" if prime else symbol
    text, latex = covector_text(form, lift.names), covector_latex(form, lift.names, known)
    return Math(f"{name}{prime} = {text}", f"{left} = {latex}")


def _combinations(result: TransformResult, found: Stationary) -> Iterator[Block]:
    """Yield the combinations that the stationary system gives, and the chains of every output as details."""
    proper = tuple(combination(one, result.system) for one in found.combinations if not is_state(one))
    single = tuple(next(iter(one)) for one in found.combinations if is_state(one))
    yield Heading(2, plain(f"Observable combinations, by the stationary system ({len(found.combinations)})"))
    if proper:
        yield Listing(tuple((one,) for one in proper))
    if single:
        yield Paragraph((Text("by themselves: ", "faint"), *names(single)))
    chains = tuple(block for chain in found.chains for block in _chain(result, chain.output, chain.forms))
    if chains:
        yield Details((Heading(2, plain("Chains: each output, one derivative after the other")), *chains))


def _chain(result: TransformResult, output: str, forms: Sequence[Covector]) -> Iterator[Block]:
    items: list[Inline] = [(combination(form, result.system),) for form in forms]
    if items:
        yield Paragraph((Text(output, "name"), Text(":")))
        yield Listing(tuple(items), numbered=True)


def _checks(form: StationaryForm) -> Iterator[Block]:
    yield Heading(2, plain("Checked on the model as its file reads"))
    for check in form.checks:
        prefix = "" if check.verdict == "holds" else f"{check.verdict}: "
        yield VerdictLine(
            KINDS[check.verdict], (Text(f"{prefix}{check.claim}"), Text(f" ({check.reason})", "faint"))
        )
    for note in form.notes:
        yield Note("note", plain(note))
