"""Systems in new variables: what the variables mean, their equations, the way back, and what was checked."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Final

from obscli.core.document import (
    Block,
    Cell,
    Column,
    Details,
    Document,
    Heading,
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
from obscli.exact.finding import Undecided
from obscli.model.expression import Expression, is_one, symbols
from obscli.model.notation import covector_latex, covector_text, latex_name, to_text
from obscli.model.system import Covector, Matrix, System
from obscli.model.variables import is_state
from obscli.pipelines.describe.checks import KINDS
from obscli.pipelines.describe.rounded import rounded
from obscli.pipelines.describe.stationary import not_reducible_blocks, stationary_blocks
from obscli.pipelines.describe.transform_parts import part_blocks
from obscli.pipelines.describe.words import names
from obscli.pipelines.latex_names import latex_names
from obscli.pipelines.transform_heading import back_forms, drop_words, kalman_words
from obscli.pipelines.transform_result import (
    NoStationaryForm,
    NothingLeft,
    StationaryForm,
    Transformed,
    TransformResult,
)


MEANING_COLUMNS: Final = (Column("state"), Column("is", breaks=True))
EQUATION_COLUMNS: Final = (Column(breaks=True),)
#: Names of states that one input enters, before they are only counted.
MOST_LISTED: Final = 4
ROUNDED: Final = "Numbers of many digits are rounded here; the model file and JSON have them exactly."


def transform_document(results: Iterable[TransformResult]) -> Document:
    """Return the report on the stages of one model."""
    results = tuple(results)
    return Document(tuple(b for one in results for b in _stage_blocks(one, first=one is results[0])))


def _stage_blocks(result: TransformResult, *, first: bool) -> Iterator[Block]:
    yield Heading(1, (Text(result.title),))
    if first and result.model.title:
        yield Paragraph((Text(result.model.title, "strong"),))
    match result.finding:
        case Undecided(_, reason):
            yield VerdictLine("open", plain(f"undecided: {reason}"))
        case StationaryForm() as found:
            yield from stationary_blocks(result, found)
        case NoStationaryForm() as found:
            yield from not_reducible_blocks(found)
        case NothingLeft(reason):
            yield VerdictLine("bad", plain(f"{reason}: no model is left"))
        case Transformed() as found:
            yield Paragraph(plain(_summary(result, found)))
            yield from _variable_blocks(result, found)
            if result.to == "kalman":
                yield from part_blocks(found)
            yield from _equation_blocks(found)
            yield from _back_blocks(result, found)
            yield from _check_blocks(found)


def _summary(result: TransformResult, found: Transformed) -> str:
    before, after = result.system.n, found.system.n
    match result.to:
        case "kalman":
            return kalman_words(found.sizes, found.by)
        case "drop" if found.left_out:
            words = drop_words(found.left_out, is_exact=bool(found.is_exact))
            return f"{before} → {counted(after, 'state')}. {words}"
    if before == after:
        return f"All {counted(before, 'state')} can be estimated: nothing is left out."
    return (
        f"{before} → {counted(after, 'state')}: z = S x, S the observable combinations. "
        f"{counted(before - after, 'direction')} left out, which no output shows."
    )


def _variable_blocks(result: TransformResult, found: Transformed) -> Iterator[Block]:
    """Yield what the states of the new model mean in those of the old one."""
    pairs = list(zip(found.system.state_names, found.forms, strict=True))
    kept = tuple(name for name, form in pairs if is_state(form))
    rows = [(name, form) for name, form in pairs if not is_state(form)]
    yield Heading(2, plain("What the states stand for" if result.to == "drop" else "New states"))
    if rows:
        yield Table(
            MEANING_COLUMNS,
            tuple((line(Text(name, "name")), line(_meaning(form, result.system))) for name, form in rows),
        )
    if kept:
        yield Paragraph((Text("as they were: ", "faint"), *names(kept)))
    if found.left_out:
        words = "dropped: " if result.to == "drop" else "free, any values of these fit: "
        yield Paragraph((Text(words, "faint"), *names(found.left_out)))
    if found.moved and not found.is_exact:
        text = "dropped states that others move, so that they do not stay zero: "
        yield Note("warning", plain(f"{text}{', '.join(found.moved)}"))


def _equation_blocks(found: Transformed) -> Iterator[Block]:
    """Yield z' = Ã z and y = H̃ z; where nothing is new, as details."""
    blocks = tuple(_equations(found))
    is_new = bool(found.left_out) or not all(map(is_state, found.forms))
    yield from blocks if is_new else (Details(blocks),)


def _equations(found: Transformed) -> Iterator[Block]:
    system = found.system
    A, H = rows_of(system.A, system.state_names), rows_of(system.H, system.state_names)
    pairs = list(zip(system.state_names, A, strict=True))
    still = tuple(name for name, row in pairs if _is_constant(name, row, system))
    moving = [(name, row) for name, row in pairs if name not in still]
    yield Heading(2, plain("Equations"))
    lines = [_equation(system, name, row, moves=True) for name, row in moving]
    outputs = zip(system.outputs, H, strict=True)
    lines += [_equation(system, output.name, row, moves=False) for output, row in outputs]
    yield Table(EQUATION_COLUMNS, tuple((line(one),) for one in lines))
    if still:
        yield Paragraph((Text("constant: ", "faint"), *names(still)))
    if system.B is not None or system.G is not None:
        driven = ", ".join(_driven(system))
        yield Paragraph((Text("driven by: ", "faint"), Text(driven)))
    if found.divides_by:
        yield Note("note", plain(_divisors(found.divides_by, system)))


def _is_constant(name: str, row: Mapping[str, Expression], system: System) -> bool:
    """Whether a state keeps its value: it has no derivative, or its next value is itself."""
    return row.keys() == {name} and is_one(row[name]) if system.discrete else not row


def rows_of(matrix: Matrix, columns: Sequence[str]) -> list[dict[str, Expression]]:
    """Return the rows of a matrix as linear forms."""
    rows: list[dict[str, Expression]] = [{} for _ in range(matrix.rows)]
    for (i, j), entry in sorted(matrix.entries.items()):
        rows[i][columns[j]] = entry
    return rows


def _meaning(form: Covector, system: System) -> Math:
    row, numerals = rounded(form)
    known = {**latex_names(system), **numerals}
    return Math(covector_text(row, system.state_names), covector_latex(row, system.state_names, known))


def _equation(system: System, name: str, form: Covector, *, moves: bool) -> Math:
    row, numerals = rounded(form)
    known = {**latex_names(system), **numerals}
    symbol = known.get(name) or latex_name(name)
    left = (name, symbol)
    if moves:
        after = f"{system.time}+1"
        left = (f"{name}'", rf"\dot{{{symbol}}}")
        if system.discrete:
            left = (f"{name}({after})", f"{symbol}({after})")
    text, latex = covector_text(row, system.state_names), covector_latex(row, system.state_names, known)
    return Math(f"{left[0]} = {text}", f"{left[1]} = {latex}")


def _driven(system: System) -> Iterator[str]:
    """Yield the inputs and disturbances with the states they enter."""
    for matrix, driving in ((system.B, system.inputs), (system.G, system.disturbances)):
        if matrix is None:
            continue
        for k, name in enumerate(driving):
            entered = [system.state_names[i] for i, j in sorted(matrix.entries) if j == k]
            listed = ", ".join(entered) if len(entered) <= MOST_LISTED else counted(len(entered), "state")
            yield f"{name} ({listed or 'nothing'})"


def _divisors(divisors: Sequence[Expression], system: System) -> str:
    """Say where the equations have no value."""
    moving = {system.time, *(function.name for function in system.functions)}
    fixed = [to_text(one) for one in divisors if not symbols(one) & moving]
    times = [to_text(one) for one in divisors if symbols(one) & moving]
    parts = [f"the equations divide by {', '.join(fixed)}"] if fixed else []
    parts += [f"they have no value at instants where {' or '.join(times)} is zero"] if times else []
    return "; ".join(parts).replace("they", "the equations", 0 if fixed else 1)


def _back_blocks(result: TransformResult, found: Transformed) -> Iterator[Block]:
    """Yield the old states in the new ones and the free ones."""
    forms = back_forms(found.system.state_names, found.back)
    rows = {state: form for state, form in forms.items() if tuple(form) != (state,) or not is_state(form)}
    if rows:
        yield Heading(2, plain("Back to the states"))
        known = {**latex_names(result.system), **latex_names(found.system)}
        yield Table(EQUATION_COLUMNS, tuple(_back_row(state, form, known) for state, form in rows.items()))


def _back_row(state: str, form: Covector, names_of: Mapping[str, str]) -> tuple[Cell, ...]:
    row, numerals = rounded(form)
    known, order = {**names_of, **numerals}, list(form)
    symbol = known.get(state) or latex_name(state)
    text, latex = covector_text(row, order), covector_latex(row, order, known)
    return (line(Math(f"{state} = {text}", f"{symbol} = {latex}")),)


def _is_rounded(found: Transformed) -> bool:
    names_of = found.system.state_names
    rows = [*rows_of(found.system.A, names_of), *rows_of(found.system.H, names_of)]
    return any(rounded(form)[1] for form in (*found.forms, *rows))


def _check_blocks(found: Transformed) -> Iterator[Block]:
    if _is_rounded(found):
        yield Note("note", plain(ROUNDED))
    yield Heading(2, plain("Checked on the model as its file reads"))
    for check in found.checks:
        prefix = "" if check.verdict == "holds" else f"{check.verdict}: "
        yield VerdictLine(
            KINDS[check.verdict], (Text(f"{prefix}{check.claim}"), Text(f" ({check.reason})", "faint"))
        )
    for note in found.notes:
        yield Note("note", plain(note))
