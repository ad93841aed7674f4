"""Models of any size whose rank is known by construction, as YAML text (standard library only)."""

from __future__ import annotations

import random


Row = dict[int, dict[str, int]]  # column -> symbol -> integer factor
SYMBOLS = ("a", "b", "t", "cos(omega*t)")


def imu_array_states(n: int) -> int:
    """The number of states of ``imu_array(n)``."""
    return 3 + 21 * n


def imu_array_rank(n: int) -> int:
    """The rank of ``imu_array(n)``: 16 for the first IMU, 6 + 9 for each further one."""
    return 16 + 15 * (n - 1)


def imu_array(n: int) -> str:
    """N IMUs on one platform, INS calibration stage 1 of Morozov & Baklanov 2018, (5) and (6).

    3 + 21 N states, 3 + 6 (N - 1) outputs: psi is driven by the first gyro triad, each accelerometer triad
    is measured as in (6), the gyro triads 2 ... N are compared with the first one in body axes.
    """
    states = ["  psi: 3"]
    measurements = []
    for k in range(1, n + 1):
        states += [
            f"  u{k}_b_g: 3",
            f"  u{k}_b_a: 3",
            f"  u{k}_M_g: [3, 3]",
            f"  u{k}_M_a: {{shape: [3, 3], structure: lower}}",
        ]
        measurements.append(f"  y_a{k}_: cross([0, 0, 1], psi) + R_nb @ (u{k}_b_a + u{k}_M_a @ f_b)/g")
    measurements += [
        f"  y_g{k}_: u{k}_b_g + u{k}_M_g @ w_ib - (u1_b_g + u1_M_g @ w_ib)" for k in range(2, n + 1)
    ]
    return "\n".join(
        [
            f"title: Array of {n} IMUs on a one-axis table, axis horizontal",
            "parameters: {omega: 0.1, omega_ie: 2*pi/86400, phi: 0.47, g: 9.81}",
            "states:",
            *states,
            "let:",
            "  c: cos(omega*t)",
            "  s: sin(omega*t)",
            "  R_nb: [[1, 0, 0], [0, c, -s], [0, s, c]]",
            "  w_ie: [0, omega_ie*cos(phi), omega_ie*sin(phi)]",
            "  w_ib: R_nb.T @ (w_ie + [omega, 0, 0])",
            "  f_b: R_nb.T @ [0, 0, g]",
            "dynamics:",
            "  psi: -cross(w_ie, psi) + R_nb @ (u1_b_g + u1_M_g @ w_ib)",
            "measurements:",
            *measurements,
            "",
        ]
    )


def integrator_chain(n: int) -> str:
    """x1' = x2, ..., xn' = 0, y = x1: rank n, reached only at L_(n-1)."""
    rows = [f"  x{i}: {{x{i + 1}: 1}}" for i in range(1, n)]
    return "\n".join(
        [
            f"title: Chain of {n} integrators",
            f"states: [{_names(n)}]",
            *(["A:", *rows] if rows else ["A: [[0]]"]),
            "H:",
            "  y: {x1: 1}",
            "",
        ]
    )


def random_sparse(n: int, observable: int, seed: int) -> str:
    """A random sparse time-varying system of ``n`` states whose rank is exactly ``observable``.

    In hidden coordinates z = (z1, z2): y = H1 z1, z1' = A11 z1, z2' = A21 z1 + A22 z2. z1 consists of chains:
    the derivative of element d has element d + 1 of its chain with a nonzero integer, and otherwise only
    elements of depth <= d of any chain, so that L_0 ... L_d spans exactly the elements of depth <= d; z2
    reaches no output. The states are x = P (I + N) z, P a permutation and N a sparse integer matrix with
    N^2 = 0, so that the inverse is (I - N) P'. Entries contain parameters, t and cos(omega*t).
    """
    if not 1 <= observable <= n:
        raise ValueError(f"observable must be in 1 ... {n}, got {observable}")
    draw = random.Random(seed)
    chains = _chains(observable)
    A, H = _hidden_dynamics(n, chains, draw), [{chain[0]: {"1": 1}} for chain in chains]
    into = _nilpotent(n, draw)
    place = draw.sample(range(n), n)
    A = [_times_inverse(row, into) for row in _rows_plus(A, into)]
    H = [_times_inverse(row, into) for row in H]
    named = {place[i]: row for i, row in enumerate(A)}
    return "\n".join(
        [
            f"title: Random sparse system, {n} states, rank {observable}, seed {seed}",
            "parameters: {a: 0.3, b: 1.7, omega: 0.2}",
            f"states: [{_names(n)}]",
            *_matrix("A", {f"x{i + 1}": named[i] for i in range(n)}, place),
            *_matrix("H", {f"y{i + 1}": row for i, row in enumerate(H)}, place),
            "",
        ]
    )


def _names(n: int) -> str:
    return ", ".join(f"x{i}" for i in range(1, n + 1))


def _chains(size: int, length: int = 8) -> list[list[int]]:
    return [list(range(start, min(start + length, size))) for start in range(0, size, length)]


def _hidden_dynamics(n: int, chains: list[list[int]], draw: random.Random) -> list[Row]:
    A: list[Row] = [{} for _ in range(n)]
    observable = sum(len(chain) for chain in chains)
    depth = {i: d for chain in chains for d, i in enumerate(chain)}
    for chain in chains:
        for i, following in zip(chain, [*chain[1:], None], strict=True):
            reached = [j for j in range(observable) if depth[j] <= depth[i]]
            _add(A[i], draw.choice(reached), draw.choice(SYMBOLS), draw.choice((-2, -1, 1, 2)))
            if following is not None:
                _add(A[i], following, "1", draw.choice((-3, -2, -1, 1, 2, 3)))
    for i in range(observable, n):
        for _ in range(2):
            _add(A[i], draw.randrange(n), draw.choice(("1", *SYMBOLS)), draw.choice((-2, -1, 1, 2)))
    return A


def _nilpotent(n: int, draw: random.Random) -> dict[int, dict[int, int]]:
    """N as target -> source -> factor, no source being a target: (I + N)(I - N) = I."""
    order = draw.sample(range(n), n)
    targets, sources = order[: n // 2], order[n // 2 :]
    return {i: {j: draw.choice((-1, 1)) for j in draw.sample(sources, min(2, len(sources)))} for i in targets}


def _rows_plus(A: list[Row], into: dict[int, dict[int, int]]) -> list[Row]:
    """(I + N) A."""
    result = [{j: dict(entry) for j, entry in row.items()} for row in A]
    for i, sources in into.items():
        for source, factor in sources.items():
            for j, entry in A[source].items():
                for symbol, number in entry.items():
                    _add(result[i], j, symbol, factor * number)
    return result


def _times_inverse(row: Row, into: dict[int, dict[int, int]]) -> Row:
    """row (I - N)."""
    result = {j: dict(entry) for j, entry in row.items()}
    for j, entry in row.items():
        for source, factor in into.get(j, {}).items():
            for symbol, number in entry.items():
                _add(result, source, symbol, -factor * number)
    return result


def _add(row: Row, column: int, symbol: str, number: int) -> None:
    entry = row.setdefault(column, {})
    entry[symbol] = entry.get(symbol, 0) + number
    if not entry[symbol]:
        del entry[symbol]
    if not entry:
        del row[column]


def _matrix(name: str, rows: dict[str, Row], place: list[int]) -> list[str]:
    lines = []
    for row_name, row in rows.items():
        entries = [f"x{place[j] + 1}: {_sum(entry)}" for j, entry in sorted(row.items())]
        if entries:
            lines.append(f"  {row_name}: {{{', '.join(entries)}}}")
    return [f"{name}:", *lines] if lines else [f"{name}: {{}}"]


def _sum(entry: dict[str, int]) -> str:
    terms = [_term(number, symbol) for symbol, number in entry.items()]
    return " + ".join(terms).replace("+ -", "- ")


def _term(number: int, symbol: str) -> str:
    if symbol == "1":
        return str(number)
    return {1: symbol, -1: f"-{symbol}"}.get(number, f"{number}*{symbol}")
