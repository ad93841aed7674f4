"""The sections of a file, each read into its draft: keys and texts are checked, nothing is evaluated."""

from __future__ import annotations

from typing import Final

from obscli.model.declaration import Declared, declared
from obscli.model.draft import Draft, Entries, Entry, FunctionDraft, MatrixDraft, ParameterDraft, Sparse
from obscli.model.formula import Formula, formula
from obscli.model.keys import choice_of, fields, name_of, text_of
from obscli.model.sampling import read_outputs
from obscli.model.tree import Broken, Mapping, Node, Scalar, Sequence
from obscli.model.trouble import Problems


ASSUMPTIONS: Final = ("positive", "nonzero", "real")
STATE_KEYS: Final = ("unit", "description", "latex", "scale")
SYSTEM_KEYS: Final = (
    "time", "parameters", "functions", "signals", "states", "let", "A", "F", "H", "B", "G", "step",
    "dynamics", "measurements", "inputs", "disturbances", "outputs", "noise", "interval", "quantities",
    "linearize",
)  # fmt: skip
STAGE_KEYS: Final = (
    "let", "A", "F", "H", "B", "G", "dynamics", "measurements", "noise", "interval", "signals", "outputs",
    "parameters", "fix", "description",
)  # fmt: skip


def read_draft(root: Node, path: str, known: tuple[str, ...], problems: Problems) -> Draft:
    """Read the sections of a file (``known`` its keys) or of a stage."""
    given = fields(root, path, known, problems)

    def node(key: str) -> Node | None:
        return given[key][1] if key in given else None

    def under(key: str) -> str:
        return f"{path}.{key}" if path else key

    before = len(problems)
    states = declared(node("states"), "states", STATE_KEYS, problems)
    states_sound = len(problems) == before
    time = text_of(given.get("time"), "time", problems)
    time_key = node("time")
    if time and isinstance(time_key, Scalar) and name_of(time_key, "time", problems) is None:
        time = ""
    return Draft(
        node=root,
        time=time,
        time_key=time_key if isinstance(time_key, Scalar) else None,
        parameters=_parameters(node("parameters"), under("parameters"), problems),
        functions=_functions(node("functions"), problems),
        states=states,
        states_sound=states_sound,
        inputs=declared(node("inputs"), "inputs", ("unit", "description"), problems),
        disturbances=declared(node("disturbances"), "disturbances", ("unit", "description"), problems),
        let=entries(node("let"), under("let"), problems, named=True),
        fix=entries(node("fix"), under("fix"), problems),
        quantities=entries(node("quantities"), under("quantities"), problems, named=True),
        dynamics=_optional_entries(node("dynamics"), under("dynamics"), problems),
        measurements=_optional_entries(node("measurements"), under("measurements"), problems, named=True),
        matrices=_matrices({key: node(key) for key in "AFHBG"}, path, problems),
        outputs=read_outputs(node("outputs"), under("outputs"), problems),
        noise=node("noise"),
        interval=node("interval"),
        step=node("step"),
        signals=node("signals"),
    )


def _is_null(node: Node) -> bool:
    return isinstance(node, Scalar) and node.is_null


def entries(node: Node | None, path: str, problems: Problems, *, named: bool = False) -> Entries:
    """Read a mapping of names to expressions; ``named``: the keys give new names."""
    result = {}
    for name, (key, value) in fields(node, path, None, problems).items():
        if named and name_of(key, path, problems) is None:
            continue
        below = f"{path}.{name}"
        result[name] = Entry(key, None if _is_null(value) else formula(value, below, problems))
    return result


def _optional_entries(
    node: Node | None, path: str, problems: Problems, *, named: bool = False
) -> Entries | None:
    if node is None:
        return None
    result = entries(node, path, problems, named=named)
    for entry in result.values():
        if entry.formula is None:
            problems.add(entry.key.problem(f"{path}.{entry.key.text}", "an expression is missing here"))
    return result


def _parameters(node: Node | None, path: str, problems: Problems) -> dict[str, ParameterDraft]:
    result = {}
    for name, (key, value) in fields(node, path, None, problems).items():
        if name_of(key, path, problems) is not None:
            result[name] = parameter(key, value, f"{path}.{name}", problems)
    return result


def parameter(key: Scalar, node: Node, path: str, problems: Problems) -> ParameterDraft:
    """Read one parameter: a value, or a mapping with more."""
    if not isinstance(node, Mapping):
        return ParameterDraft(key, _value(node, path, problems))
    given = fields(node, path, ("value", "unit", "description", "assume"), problems)
    value = given["value"][1] if "value" in given else None
    return ParameterDraft(
        key,
        None if value is None else _value(value, f"{path}.value", problems),
        choice_of(given.get("assume"), f"{path}.assume", ASSUMPTIONS, problems),
        text_of(given.get("unit"), f"{path}.unit", problems),
        text_of(given.get("description"), f"{path}.description", problems),
    )


def _value(node: Node, path: str, problems: Problems) -> Formula | None:
    if _is_null(node):
        return None
    if isinstance(node, Sequence):
        hint = "a vector of constants goes under `let`"
        problems.add(node.problem(path, "a parameter is a scalar, not a list", hint))
        return Formula(path, node, (), sound=False)
    return formula(node, path, problems)


def _functions(node: Node | None, problems: Problems) -> tuple[FunctionDraft, ...]:
    further = ("derivative", "invariant", "unit", "description")
    return tuple(_function(one, problems) for one in declared(node, "functions", further, problems))


def _function(one: Declared, problems: Problems) -> FunctionDraft:
    path = f"functions.{one.name}"
    rule = one.given["derivative"][1] if "derivative" in one.given else None
    relation = one.given["invariant"][1] if "invariant" in one.given else None
    derivative = None if rule is None or _is_null(rule) else formula(rule, f"{path}.derivative", problems)
    if relation is None or _is_null(relation):
        return FunctionDraft(one, derivative)
    return FunctionDraft(one, derivative, (formula(relation, f"{path}.invariant", problems),))


def _matrices(nodes: dict[str, Node | None], path: str, problems: Problems) -> dict[str, MatrixDraft]:
    result: dict[str, MatrixDraft] = {}
    for name, node in nodes.items():
        below = f"{path}.{name}" if path else name
        if node is None or isinstance(node, Broken):
            continue
        if _is_null(node):
            problems.add(node.problem(below, "a matrix is missing here"))
        elif not isinstance(node, Mapping):
            result[name] = formula(node, below, problems)
        elif node.get("file") is not None:
            hint = "write the matrix as a list of rows"
            problems.add(node.problem(below, "matrices from files (`file`) are not supported yet", hint))
        else:
            result[name] = _sparse(node, below, problems)
    return result


def _sparse(node: Mapping, path: str, problems: Problems) -> Sparse:
    rows: dict[str, tuple[Scalar, Entries | Formula]] = {}
    for name, (key, row) in fields(node, path, None, problems).items():
        below = f"{path}.{name}"
        if isinstance(row, Mapping):
            rows[name] = (key, entries(row, below, problems))
        elif not isinstance(row, Broken):
            rows[name] = (key, formula(row, below, problems))
    return Sparse(node, path, rows)
