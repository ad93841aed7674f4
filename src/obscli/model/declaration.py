"""Declared scalars, vectors and matrices, and the names of their components.

psi: 3                                      psi1 psi2 psi3
M_g: [3, 3]                                 M_g11 M_g12 … M_g33, by rows
M_a: {shape: [3, 3], structure: lower}      M_a11 M_a21 M_a22 M_a31 M_a32 M_a33
phi: {components: [E, N, U]}                phi_E phi_N phi_U
M: [2, 12]                                  M_1_1 … M_2_12
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Final

from obscli.model.form import ZERO_FORM, Form
from obscli.model.keys import Fields, choice_of, fields, items_of, name_of, text_of, whole_of
from obscli.model.tensor import Tensor
from obscli.model.tokens import is_name
from obscli.model.tree import Broken, Mapping, Node, Scalar, Sequence
from obscli.model.trouble import Problems, shown


STRUCTURES: Final = ("lower", "upper", "diagonal", "symmetric")
SHAPE_KEYS: Final = ("shape", "structure", "components")
MOST_COMPONENTS: Final = 5000


@dataclass(frozen=True, slots=True, eq=False)
class Declared:
    """A name with a shape; ``cells`` names the component in each cell, None where it is zero."""

    name: str
    key: Scalar
    shape: tuple[int, ...]
    cells: tuple[str | None, ...]
    given: Fields
    unit: str = ""
    description: str = ""

    @property
    def components(self) -> tuple[str, ...]:
        """The scalar names, each once, by rows."""
        return tuple(dict.fromkeys(cell for cell in self.cells if cell is not None))

    @property
    def vector(self) -> str:
        """The name of the whole, empty for a scalar."""
        return self.name if self.shape else ""

    def tensor(self, value: Callable[[str], Form]) -> Tensor:
        """Return the tensor with a value for each component."""
        known = {name: value(name) for name in self.components}
        return Tensor(self.shape, tuple(ZERO_FORM if c is None else known[c] for c in self.cells))

    def aliases(self) -> Iterator[tuple[str, str]]:
        """Yield other spellings of components: x12 for x_12."""
        if len(self.shape) == 1 and self.shape[0] >= 10:
            for k, cell in enumerate(self.cells, start=1):
                if cell == f"{self.name}_{k}":
                    yield f"{self.name}{k}", cell


def declared(
    node: Node | None, path: str, further: tuple[str, ...], problems: Problems
) -> tuple[Declared, ...]:
    """Read a list of scalar names or a mapping of names to shapes.

    Parameters
    ----------
    further : keys allowed beside those of the shape
    """
    if node is None or isinstance(node, Broken):
        return ()
    if isinstance(node, Mapping):
        entries = [_entry(key, value, path, further, problems) for key, value in node.entries]
    else:
        entries = [_item(item, path, problems) for item in items_of(node, path, problems)]
    found = tuple(entry for entry in entries if entry is not None)
    if sum(len(entry.cells) for entry in found) > MOST_COMPONENTS:
        problems.add(node.problem(path, f"over {MOST_COMPONENTS} scalars are declared here"))
        return ()
    return found


def _item(item: Node, path: str, problems: Problems) -> Declared | None:
    if not isinstance(item, Scalar):
        if not isinstance(item, Broken):
            hint = "shapes are given in a mapping: {psi: 3, M: [3, 3]}"
            problems.add(item.problem(path, "the list holds names only", hint))
        return None
    name = name_of(item, path, problems)
    return None if name is None else Declared(name, item, (), (name,), {})


def _entry(
    key: Scalar, node: Node, path: str, further: tuple[str, ...], problems: Problems
) -> Declared | None:
    name = name_of(key, path, problems)
    path = f"{path}.{key.text}"
    given = fields(node, path, SHAPE_KEYS + further, problems) if isinstance(node, Mapping) else {}
    if name is None or isinstance(node, Broken):
        return None
    before = len(problems)
    shape_node = given["shape"][1] if "shape" in given else None if isinstance(node, Mapping) else node
    if "components" in given:
        suffixes = _suffixes(given["components"][1], f"{path}.components", problems)
        shape: tuple[int, ...] = (len(suffixes),)
        cells: tuple[str | None, ...] = tuple(f"{name}_{suffix}" for suffix in suffixes)
        if shape_node is not None and _shape(shape_node, f"{path}.shape", problems) not in {None, shape}:
            message = f"this shape does not fit the {len(suffixes)} names in `components`"
            problems.add(shape_node.problem(f"{path}.shape", message, "leave `shape` out"))
    else:
        shape = _shape(shape_node, path, problems) or ()
        cells = ()
        if _size(shape) <= MOST_COMPONENTS:
            cells = _cells(name, shape, given, path, problems)
        else:
            problems.add(key.problem(path, f"over {MOST_COMPONENTS} scalars are declared here"))
    if len(problems) > before:
        return Declared(name, key, shape, cells, given) if cells else None
    unit = text_of(given.get("unit"), f"{path}.unit", problems)
    description = text_of(given.get("description"), f"{path}.description", problems)
    return Declared(name, key, shape, cells, given, unit, description)


def _size(shape: tuple[int, ...]) -> int:
    return shape[0] * shape[1] if len(shape) == 2 else sum(shape)


def _shape(node: Node | None, path: str, problems: Problems) -> tuple[int, ...] | None:
    """Return the shape written as nothing, a number, [n] or [m, n]; None where it is wrong."""
    if node is None or (isinstance(node, Scalar) and node.is_null):
        return ()
    if isinstance(node, Sequence):
        sizes = [whole_of(item, path, problems) for item in node.items]
        if not 1 <= len(sizes) <= 2:
            problems.add(node.problem(path, "a shape is n, [n] or [m, n]"))
            return None
        return None if None in sizes else tuple(size for size in sizes if size is not None)
    size = whole_of(node, path, problems)
    return None if size is None else () if size == 1 else (size,)


def _suffixes(node: Node, path: str, problems: Problems) -> tuple[str, ...]:
    found: list[str] = []
    for item in items_of(node, path, problems):
        text = item.text if isinstance(item, Scalar) else ""
        if not is_name(f"x_{text}") or not text:
            problems.add(item.problem(path, f"'{shown(text)}' is no name of a component"))
        elif text in found:
            problems.add(item.problem(path, f"the component '{text}' is given twice"))
        else:
            found.append(text)
    if not found and isinstance(node, Sequence) and not node.items:
        problems.add(node.problem(path, "the list of components is empty"))
    return tuple(found)


def component_names(name: str, shape: tuple[int, ...]) -> tuple[str, ...]:
    """Return the names of all cells by rows; with a dimension of 10 or more they are separated."""
    gap = "_" if max(shape, default=0) >= 10 else ""
    match shape:
        case (n,):
            return tuple(f"{name}{gap}{i}" for i in range(1, n + 1))
        case (m, n):
            return tuple(f"{name}{gap}{i}{gap}{j}" for i in range(1, m + 1) for j in range(1, n + 1))
    return (name,)


def _cells(
    name: str, shape: tuple[int, ...], given: Fields, path: str, problems: Problems
) -> tuple[str | None, ...]:
    names = component_names(name, shape)
    structure = choice_of(given.get("structure"), f"{path}.structure", STRUCTURES, problems)
    if not structure:
        return names
    if len(shape) != 2 or shape[0] != shape[1]:
        node = given["structure"][1]
        problems.add(node.problem(f"{path}.structure", "only a square matrix has a structure"))
        return names
    n = shape[0]
    return tuple(_cell(names, structure, n, i, j) for i in range(n) for j in range(n))


def _cell(names: tuple[str, ...], structure: str, n: int, i: int, j: int) -> str | None:
    if structure == "symmetric":
        i, j = min(i, j), max(i, j)
    kept = {"lower": i >= j, "upper": i <= j, "diagonal": i == j, "symmetric": True}[structure]
    return names[i * n + j] if kept else None


def is_part_of(component: str, name: str) -> bool:
    """Whether a name is that of a component of the one named: ``e2`` of ``e``."""
    rest = component.removeprefix(name)
    return rest != component and rest.replace("_", "").isdigit()
