"""A certificate of rank checked again, by code that shares nothing with the elimination that made it.

Upper bound: H N = 0, N' - A N = N X (of a discrete-time system F N = N X) in exact arithmetic, N of full
column rank. Lower bound: the minor of
L at the point, by Taylor series in ball arithmetic. Order: a direction w with H w_k = 0 below it and not at
it, w_{k+1} = w_k' - A w_k (then L_k w = ± H w_k while the earlier ones vanish). Combinations: S N = 0, S of
full row rank.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from flint import arb

from obscli.core.check import CheckResult
from obscli.exact.ball import BallPoint, OutsideDomainError, precision, random_point
from obscli.exact.determinant import determinant
from obscli.exact.errors import JetOverflowError, UndecidedError, UndefinedError
from obscli.exact.exact_system import ExactSystem, Row, more_jets, read_system
from obscli.exact.few_rows import most_rows
from obscli.exact.field import Element
from obscli.exact.finding import Certificate
from obscli.exact.identity import fingerprint, independent_constants
from obscli.exact.lower import PRECISIONS, highest_derivative, minor, used_names
from obscli.exact.rows import dot, drift
from obscli.exact.sample_window import static
from obscli.model.expression import Expression
from obscli.model.system import Covector, System


class _RejectedError(Exception):
    """Something in the certificate does not hold; says what."""


def check_certificate(
    system: System, certificate: Certificate, combinations: Sequence[Covector] | None
) -> CheckResult:
    """Check a certificate (and the combinations printed beside it) against a system.

    Parameters
    ----------
    system : the system it is said to be about
    certificate : rank, order, lower and upper bound
    combinations : the basis of observable combinations, rows of S; None where only the rank is checked
    """
    claim = f"certificate: rank {certificate.rank}, saturated at order {certificate.order}"
    try:
        _check(static(system), certificate, combinations)
    except _RejectedError as rejected:
        return CheckResult(claim, "fails", str(rejected))
    except (UndecidedError, UndefinedError) as error:
        return CheckResult(claim, "undecided", str(error))
    grounds = f"minor at a rational point, {len(certificate.upper.kernel)} unobservable directions"
    return CheckResult(claim, "holds", f"checked again independently: {grounds}")


def _check(system: System, certificate: Certificate, combinations: Sequence[Covector] | None) -> None:
    _require(
        certificate.model == fingerprint(system), "it is about another system (digest of A, H and names)"
    )
    _check_shape(system, certificate)
    exact = _read(system, certificate, combinations)
    _require(
        certificate.assumes == independent_constants(read_system(system)),
        "its list of independent constants differs",
    )
    kernel = [_row(exact, direction) for direction in certificate.upper.kernel]
    while True:
        try:
            _check_identities(exact, certificate, kernel)
            break
        except JetOverflowError:
            exact = more_jets(exact, _expressions(certificate, combinations))
            kernel = [_row(exact, direction) for direction in certificate.upper.kernel]
    values = _point(system, exact, certificate)
    _check_minor(exact, certificate, values)
    _check_kernel_rank(exact, certificate, values)
    if combinations is not None:
        _check_combinations(exact, certificate, combinations, kernel, values)


# -- form


def _check_shape(system: System, certificate: Certificate) -> None:
    rank, lower = certificate.rank, certificate.lower
    names = system.state_names
    upper = certificate.upper
    _require(len(upper.kernel) == system.n - rank, "the number of directions is not n - rank")
    square = len(upper.multiplier) == len(upper.kernel) and all(
        len(column) == len(upper.kernel) for column in upper.multiplier
    )
    _require(square, "the multiplier X is not square, of the size of N")
    _require(len(lower.rows) == len(lower.columns) == rank, "the minor is not of the size of the rank")
    _require(len(set(lower.rows)) == rank and len(set(lower.columns)) == rank, "a row or column stands twice")
    _require(set(lower.columns) <= set(names), "a column of the minor is not a state")
    outputs = {output.name for output in system.outputs}
    _require(all(name in outputs for name, _ in lower.rows), "a row of the minor is not of an output")
    _require(
        max((order for _, order in lower.rows), default=0) == certificate.order,
        "the minor does not reach the order given",
    )
    _require(all(order >= 0 for _, order in lower.rows), "a row of the minor has a negative order")
    _require(certificate.order < max(system.n, 1), "the order is not below n")
    _require(lower.precision in PRECISIONS, "the precision is none of those used")


def _expressions(certificate: Certificate, combinations: Sequence[Covector] | None) -> list[Expression]:
    upper = certificate.upper
    covectors = [*upper.kernel, *(combinations or ()), *([upper.delay] if upper.delay else [])]
    entries = [e for covector in covectors for e in covector.values()]
    return [*entries, *(e for column in upper.multiplier for e in column)]


def _read(system: System, certificate: Certificate, combinations: Sequence[Covector] | None) -> ExactSystem:
    try:
        return read_system(system, _expressions(certificate, combinations))
    except UndefinedError as error:
        raise _RejectedError(f"an expression in it does not exist: {error}") from error


def _row(exact: ExactSystem, covector: Covector) -> dict[int, Element]:
    _require(set(covector) <= set(exact.system.state_names), "it names a state that the system does not have")
    return exact.row(covector)


# -- upper bound and order


def _check_identities(exact: ExactSystem, certificate: Certificate, kernel: Sequence[Row]) -> None:
    for k, column in enumerate(kernel):
        _require(not _seen(exact, column), f"H N = 0 fails for direction {k + 1}")
        rest = drift(exact, column)
        factors = [exact.interpreter.read(e) for e in certificate.upper.multiplier[k]]
        for factor, other in zip(factors, kernel, strict=True):
            for i, entry in other.items() if factor else ():
                rest[i] = rest.get(i, exact.field.zero) - factor * entry
        identity = "F N = N X" if exact.system.discrete else "N' - A N = N X"
        _require(not any(rest.values()), f"{identity} fails for direction {k + 1}")
    _check_order(exact, certificate)


def _check_order(exact: ExactSystem, certificate: Certificate) -> None:
    delay = certificate.upper.delay
    if certificate.order == 0:
        _require(delay is None, "order 0 needs no delayed direction")
        return
    if delay is None:
        few = most_rows(exact, certificate.order - 1) < certificate.rank
        _require(few, "the direction that shows the order is missing")
        return
    direction: Row = _row(exact, delay)
    for _ in range(certificate.order):
        _require(not _seen(exact, direction), "the direction that shows the order is seen earlier")
        direction = drift(exact, direction)
    _require(_seen(exact, direction), "the direction that shows the order is not seen at it")


def _seen(exact: ExactSystem, column: Row) -> bool:
    return any(dot(exact.field, row, column) for row in exact.H)


# -- lower bound and full rank


def _point(system: System, exact: ExactSystem, certificate: Certificate) -> dict[str, Fraction]:
    try:
        values = {name: Fraction(text) for name, text in certificate.lower.point.items()}
    except (ValueError, ZeroDivisionError) as error:
        raise _RejectedError(f"a value of the point is not a rational number: {error}") from error
    needed = used_names(system) - exact.interpreter.definitions.keys()
    depth = certificate.order + 1 + highest_derivative(system)
    expected = random_point(system, needed, depth, 0).keys()
    _require(values.keys() == expected, "the point does not give a value for each name, and no others")
    positive = {p.name for p in system.parameters if p.assume == "positive"}
    _require(all(v > 0 for name, v in values.items() if name in positive), "the point violates `assume`")
    return values


def _check_minor(exact: ExactSystem, certificate: Certificate, values: dict[str, Fraction]) -> None:
    system, lower = exact.system, certificate.lower
    outputs = {output.name: k for k, output in enumerate(system.outputs)}
    rows = [(order, outputs[name]) for name, order in lower.rows]
    columns = [system.state_names.index(name) for name in lower.columns]
    try:
        ball = minor(system, rows, columns, values, lower.precision, exact.interpreter.definitions)
    except OutsideDomainError as error:
        raise _RejectedError("the coefficients do not exist at the point") from error
    _require(not ball.contains(0), "the ball of the minor contains zero")
    with precision(lower.precision, 1):
        _require(_same_ball(ball, lower.midpoint, lower.radius), "the minor at the point is another number")


def _same_ball(ball: arb, midpoint: str, radius: str) -> bool:
    """Whether the printed midpoint (15 digits) and radius are those of the ball, up to rounding."""
    try:
        middle, spread = arb(midpoint), arb(radius)
    except ValueError:
        return False
    slack = abs(ball) * arb("1e-14") + spread + ball.rad()
    close = abs(middle - ball.mid()) <= slack
    mine = ball.rad()
    return bool(close) and bool(spread <= mine * 1024) and bool(mine <= spread * 1024)


def _check_kernel_rank(exact: ExactSystem, certificate: Certificate, values: dict[str, Fraction]) -> None:
    free = [name for name in exact.system.state_names if name not in set(certificate.lower.columns)]
    kernel = certificate.upper.kernel
    _require(
        _nonsingular(exact, certificate, values, [[column.get(name) for name in free] for column in kernel]),
        "the directions are not seen to be independent",
    )


def _check_combinations(
    exact: ExactSystem,
    certificate: Certificate,
    combinations: Sequence[Covector],
    kernel: Sequence[Row],
    values: dict[str, Fraction],
) -> None:
    _require(len(combinations) == certificate.rank, "the number of combinations is not the rank")
    for k, combination in enumerate(combinations):
        row = _row(exact, combination)
        _require(
            not any(dot(exact.field, row, column) for column in kernel),
            f"combination {k + 1} does not annihilate the unobservable directions",
        )
    pivots = certificate.lower.columns
    _require(
        _nonsingular(exact, certificate, values, [[c.get(name) for name in pivots] for c in combinations]),
        "the combinations are not seen to be independent",
    )


def _nonsingular(
    exact: ExactSystem,
    certificate: Certificate,
    values: dict[str, Fraction],
    entries: Sequence[Sequence[Expression | None]],
) -> bool:
    """Whether a square matrix of expressions has a determinant whose ball at the point excludes zero."""
    if not entries:
        return True
    bits = 4 * certificate.lower.precision
    length = 1 + max((name.count("'") for name in values), default=0)
    with precision(bits, length):
        try:
            point = BallPoint(exact.system, values, length, exact.interpreter.definitions)
            rows = [{j: point.value(e)[0] for j, e in enumerate(row) if e is not None} for row in entries]
            return not determinant(rows).contains(0)
        except (OutsideDomainError, KeyError):
            return False


def _require(condition: object, message: str) -> None:
    if not condition:
        raise _RejectedError(message)
