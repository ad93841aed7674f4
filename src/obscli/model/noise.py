"""``noise`` evaluated: densities, covariances and priors as sparse matrices over names of the stage."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Final

from obscli.model.constant import constant
from obscli.model.evaluate import evaluate
from obscli.model.expression import Expression, is_zero, power
from obscli.model.form import Form
from obscli.model.formula import formula
from obscli.model.keys import Fields, fields
from obscli.model.scope import Scope
from obscli.model.sign import sign
from obscli.model.system import Matrix, Noise
from obscli.model.tensor import Tensor, named
from obscli.model.tree import Broken, Mapping, Node, Scalar
from obscli.model.trouble import Problems, nearest, shown


NOISE_KEYS: Final = ("Q", "R", "P0", "P0_std", "step", "signals")

#: A scalar with the vector it belongs to ("" for none).
Named = tuple[str, str]


@dataclass(frozen=True, slots=True, eq=False)
class Targets:
    """The scalars that noise may be given for, each with the vector it was declared under."""

    states: tuple[Named, ...]
    disturbances: tuple[Named, ...]
    outputs: tuple[Named, ...]
    signals: tuple[Named, ...] = ()


def noise_of(node: Node | None, targets: Targets, scope: Scope, problems: Problems) -> Noise | None:
    """Return ``noise`` in the names of its stage; None where there is none."""
    if node is None or isinstance(node, Broken):
        return None
    given = fields(node, "noise", NOISE_KEYS, problems)
    if "P0" in given and "P0_std" in given:
        message = "`P0` and `P0_std` are both given; one of the two"
        problems.add(given["P0_std"][0].problem("noise", message))
    reading = _Reading(scope, problems)

    def matrix(key: str, names: tuple[Named, ...]) -> Matrix | None:
        return reading.matrix(given[key][1], f"noise.{key}", names) if key in given else None

    prior, deviations = matrix("P0", targets.states), matrix("P0_std", targets.states)
    step = reading.scalar(given["step"][1], "noise.step") if "step" in given else None
    return Noise(
        place=node.place,
        Q=matrix("Q", targets.disturbances or targets.states),
        driven="disturbances" if targets.disturbances else "states",
        R=matrix("R", targets.outputs),
        P0=prior if deviations is None else _squared(deviations, problems, given["P0_std"][1]),
        step=step,
        signals=_of_signals(matrix("signals", targets.signals), targets, problems, given),
    )


def _of_signals(
    found: Matrix | None, targets: Targets, problems: Problems, given: Fields
) -> dict[str, Expression]:
    """Return the standard deviations of signals by name."""
    if found is None:
        return {}
    if not targets.signals:
        problems.add(given["signals"][0].problem("noise", "there are no `signals` in this stage"))
    if any(i != j for i, j in found.entries):
        message = "standard deviations are a scalar, a list or a mapping of names to them"
        problems.add(given["signals"][1].problem("noise.signals", message))
    return {targets.signals[i][0]: entry for (i, _), entry in found.entries.items()}


class _Reading:
    """Evaluates values of ``noise`` in one scope."""

    def __init__(self, scope: Scope, problems: Problems) -> None:
        self._scope = scope
        self._problems = problems

    def matrix(self, node: Node, path: str, names: tuple[Named, ...]) -> Matrix:
        """Return a value for all, a list of diagonal entries, a square matrix, or a mapping by name."""
        return Matrix(len(names), len(names), dict(self._entries(node, path, names)))

    def scalar(self, node: Node, path: str) -> Expression | None:
        """Return a constant."""
        if self._is_missing(node, path):
            return None
        found = constant(formula(node, path, self._problems), self._scope, self._problems)
        if found is not None and sign(found) in {0, -1}:
            self._problems.add(node.problem(path, "a positive time is expected here"))
        return found

    def _entries(
        self, node: Node, path: str, names: tuple[Named, ...]
    ) -> Iterator[tuple[tuple[int, int], Expression]]:
        if not isinstance(node, Mapping):
            yield from self._spread(node, path, list(range(len(names))))
            return
        spellings = [spelling for one in names for spelling in one if spelling]
        for name, (key, value) in fields(node, path, None, self._problems).items():
            places = [k for k, one in enumerate(names) if name in one]
            if not places:
                message = f"'{shown(name)}' is none of the names expected here{nearest(name, spellings)}"
                self._problems.add(key.problem(path, message))
            yield from self._spread(value, f"{path}.{name}", places)

    def _spread(
        self, node: Node, path: str, places: list[int]
    ) -> Iterator[tuple[tuple[int, int], Expression]]:
        """Yield the entries of one value over some rows and columns; zeros are entries too."""
        if self._is_missing(node, path):
            return
        value = evaluate(formula(node, path, self._problems), self._scope, self._problems)
        if value is None or not places:
            return
        size = len(places)
        if not (value.is_scalar or value.shape in {(size,), (size, size)}):
            wanted = f"a scalar, a list of {size} (the diagonal) or a {size}×{size} matrix is expected here"
            self._problems.add(node.problem(path, f"{wanted}, not {named(value.shape)}"))
        elif value.shape == (size, size) and not value.is_scalar:
            yield from self._square(value, places)
            diagonal = [value.row(k)[k] for k in range(size)]
            self._check_sign(node, path, diagonal)
        else:
            forms = value.entries * (size if value.is_scalar else 1)
            self._check_sign(node, path, forms)
            for place, form in zip(places, forms, strict=True):
                yield (place, place), form.constant

    @staticmethod
    def _square(value: Tensor, places: list[int]) -> Iterator[tuple[tuple[int, int], Expression]]:
        for k, i in enumerate(places):
            for j, form in zip(places, value.row(k), strict=True):
                if i == j or not is_zero(form.constant):
                    yield (i, j), form.constant

    def _check_sign(self, node: Node, path: str, diagonal: Iterable[Form]) -> None:
        for form in diagonal:
            if sign(form.constant) == -1:
                deviation = path.startswith(("noise.P0_std", "noise.signals"))
                what = "a standard deviation" if deviation else "a variance"
                self._problems.add(node.problem(path, f"{what} cannot be negative"))
                return

    def _is_missing(self, node: Node, path: str) -> bool:
        """Whether nothing stands where an expression should (which is reported)."""
        missing = isinstance(node, Scalar) and node.is_null
        if missing:
            self._problems.add(node.problem(path, "an expression is missing here"))
        return missing


def _squared(deviations: Matrix, problems: Problems, node: Node) -> Matrix:
    """Return the covariance of independent standard deviations."""
    if any(i != j for i, j in deviations.entries):
        message = "standard deviations are a scalar, a list or a mapping; a full covariance goes under `P0`"
        problems.add(node.problem("noise.P0_std", message))
    entries = {place: power(entry, 2) for place, entry in deviations.entries.items()}
    return Matrix(deviations.rows, deviations.columns, entries)
