"""A system read into its differential field: sparse A and H of field elements.

x' = A x,  y = H x;   A[i] = {j: a_ij},  H[k] = {j: h_kj}
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

from obscli.core.place import Place
from obscli.exact.errors import JetOverflowError, UndecidedError, UndefinedError
from obscli.exact.field import Element, Field
from obscli.exact.interpreter import Interpreter
from obscli.model.discrete import varying_entry
from obscli.model.expression import Expression
from obscli.model.system import Covector, Matrix, System


#: A sparse row of field elements by column.
Row: TypeAlias = Mapping[int, Element]

#: More derivatives of an unspecified function than this are not tried.
MOST_JETS = 64


@dataclass(frozen=True, eq=False)
class ExactSystem:
    """A (n, n) and H (m, n) as sparse rows over one differential field."""

    system: System
    interpreter: Interpreter
    A: tuple[Row, ...]
    H: tuple[Row, ...]

    @property
    def field(self) -> Field:
        """The differential field of the coefficients."""
        return self.interpreter.field

    @property
    def n(self) -> int:
        """The number of states."""
        return self.system.n

    @cached_property
    def _place(self) -> dict[str, int]:
        return {name: j for j, name in enumerate(self.system.state_names)}

    def row(self, covector: Covector) -> dict[int, Element]:
        """Return a linear form in the states as field elements by column, without zeros."""
        elements = {self._place[name]: self.interpreter.read(entry) for name, entry in covector.items()}
        return {j: element for j, element in elements.items() if element}

    @cached_property
    def varies(self) -> bool:
        """Whether any coefficient depends on time."""
        return any(
            degree > 0 and self.field.varies(k)
            for row in (*self.A, *self.H)
            for element in row.values()
            for polynomial in (element.num, element.den)
            for k, degree in enumerate(polynomial.degrees())
        )


def read_system(system: System, extra: Iterable[Expression] = (), jets: int = 4) -> ExactSystem:
    """Read the matrices of a system (and whatever ``extra`` expressions will be asked for).

    Raises
    ------
    UndecidedError : zero cannot be decided for some coefficient; the text names its place
    UndefinedError : a coefficient does not exist (zero denominator); the text names its place
    """
    if jets > MOST_JETS:
        raise UndecidedError(f"more than {MOST_JETS} derivatives of a function would be needed")
    _require_constant_if_discrete(system)
    extra = tuple(extra)
    roots = [*system.A.entries.values(), *system.H.entries.values(), *extra]
    try:
        interpreter = Interpreter(system, roots, jets)
    except JetOverflowError:
        return read_system(system, extra, 2 * jets)
    except (UndecidedError, UndefinedError) as error:
        raise _located(system, error) from error
    A = _rows(system.A, interpreter)
    H = _rows(system.H, interpreter)
    return ExactSystem(system, interpreter, A, H)


def _require_constant_if_discrete(system: System) -> None:
    """Refuse coefficients of a discrete-time system that depend on the step: the derivation here is d/dt."""
    where = varying_entry(system) if system.discrete else None
    if where is not None:
        raise UndecidedError(
            f"{where} depends on {system.time}: this is for constant F and H of discrete-time models yet "
            "(obscli analyze takes it, by samples)"
        )


def more_jets(exact: ExactSystem, extra: Iterable[Expression] = ()) -> ExactSystem:
    """Read the system again with twice as many derivatives of its functions."""
    return read_system(exact.system, extra, 2 * exact.interpreter.jets)


def _rows(matrix: Matrix, interpreter: Interpreter) -> tuple[Row, ...]:
    rows: list[dict[int, Element]] = [{} for _ in range(matrix.rows)]
    for (i, j), expression in matrix.entries.items():
        element = interpreter.read(expression)
        if element:
            rows[i][j] = element
    return tuple(rows)


def _located(system: System, error: Exception) -> Exception:
    """Find the entry that cannot be read and put its place in front of the reason."""
    for name, matrix in ((system.dynamics_name, system.A), ("H", system.H)):
        for (i, j), expression in matrix.entries.items():
            try:
                Interpreter(system, [expression])
            except type(error):
                return type(error)(_where(system, name, i, j, matrix.places.get((i, j))) + _why(error))
            except (JetOverflowError, UndecidedError, UndefinedError):
                continue
    return type(error)(_why(error))


def _where(system: System, name: str, i: int, j: int, place: Place | None) -> str:
    row = (tuple(o.name for o in system.outputs) if name == "H" else system.state_names)[i]
    prefix = f"{place}: " if place else ""
    return f"{prefix}{name}[{row}, {system.state_names[j]}]: "


def _why(error: Exception) -> str:
    return str(error) or "the denominator is identically zero"
