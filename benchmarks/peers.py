"""Side by side on INS calibration stage 1: obscli, symident, sympy; each in a fresh process.

    python benchmarks/peers.py [--only obscli "symident detect"] [--reduce-limit 150] [--answers]

Every peer gets the system written out by hand in its own form (no YAML), its constants as constants, and the
options under which it is strongest. CPU seconds include imports.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from pathlib import Path

from measure import OBSCLI, Run, fresh, median, peak, spread, table


MODEL = "models/ins_calibration/horizontal.yaml"
PSI = ["psi1", "psi2", "psi3"]
LOWER = ["11", "21", "22", "31", "32", "33"]
FULL = [f"{i}{j}" for i in (1, 2, 3) for j in (1, 2, 3)]
STATES = [
    *PSI,
    *(f"b_g{i}" for i in (1, 2, 3)),
    *(f"b_a{i}" for i in (1, 2, 3)),
    *(f"M_g{k}" for k in FULL),
    *(f"M_a{k}" for k in LOWER),
]
CONSTANTS = ["omega", "omega_ie", "g", "cphi", "sphi"]  # cphi = cos(phi), sphi = sin(phi)
ORDERS = 5  # L_0 ... L_5


def stage_1(c: str, s: str) -> tuple[dict[str, str], dict[str, str]]:
    """(5) and (6) written out: right-hand sides and outputs; ``c``, ``s``: cos and sin of omega*t."""
    w = ["omega", f"({c}*omega_ie*cphi + {s}*omega_ie*sphi)", f"({c}*omega_ie*sphi - {s}*omega_ie*cphi)"]
    e = [f"(b_g{i} + M_g{i}1*{w[0]} + M_g{i}2*{w[1]} + M_g{i}3*{w[2]})" for i in (1, 2, 3)]
    # f_b = (0, g sin, g cos): M_a11, M_a21, M_a31 reach no output
    a = ["b_a1/g", f"(b_a2/g + M_a22*{s})", f"(b_a3/g + M_a32*{s} + M_a33*{c})"]
    odes = dict.fromkeys(STATES, "0") | {
        "psi1": f"omega_ie*sphi*psi2 - omega_ie*cphi*psi3 + {e[0]}",
        "psi2": f"-omega_ie*sphi*psi1 + {c}*{e[1]} - {s}*{e[2]}",
        "psi3": f"omega_ie*cphi*psi1 + {s}*{e[1]} + {c}*{e[2]}",
    }
    return odes, {
        "y1": f"-psi2 + {a[0]}",
        "y2": f"psi1 + {c}*{a[1]} - {s}*{a[2]}",
        "y3": f"{s}*{a[1]} + {c}*{a[2]}",
    }


# ---------------------------------------------------------------- the peers, each in a process of its own


def symident_detect() -> dict:
    """Rank and directions; cos and sin of omega*t are two known states (faster for it than its ``time``)."""
    result = _detected()
    return {
        "rank": result.rank,
        "states": result.dim,
        "directions": len(result.symmetries),
        "answer": [str(one.generator) for one in result.symmetries],
    }


def symident_reduce() -> dict:
    """Combinations, states of either sign (``positive=False``), ``check=False``: its fastest way."""
    return _reduced(_detected(positive=False))


def symident_reduce_default() -> dict:
    """Combinations as its documentation shows: states taken as positive, a positive section searched for."""
    return _reduced(_detected())


def sympy_domainmatrix() -> dict:
    """L_0 ... L_5 over the field Q(tau, constants), tau = tan(omega*t/2); reduced echelon form."""
    start = time.process_time()
    import sympy
    from sympy.polys.matrices import DomainMatrix

    imported = time.process_time()
    tau = sympy.Symbol("tau")
    field = sympy.QQ.frac_field(tau, *sympy.symbols(CONSTANTS))
    A, H = (
        DomainMatrix.from_Matrix(matrix).convert_to(field).to_sparse()
        for matrix in _matrices((1 - tau**2) / (1 + tau**2), 2 * tau / (1 + tau**2))
    )
    t, omega = field.field.gens[:2]
    speed = omega * (1 + t**2) / 2
    L = [H]
    for _ in range(ORDERS):
        L.append(L[-1].applyfunc(lambda entry: entry.diff(t) * speed) + L[-1] * A)
    built = time.process_time()
    echelon, pivots = L[0].vstack(*L[1:]).rref()
    done = time.process_time()
    rows = echelon.to_Matrix()[: len(pivots), :]
    return {
        "rank": len(pivots),
        "combinations": len(pivots),
        "states": len(STATES),
        "remark": f"imports {imported - start:.2f}, L {built - imported:.2f}, rref {done - built:.2f} s",
        "answer": [str((rows[i, :] * sympy.Matrix(sympy.symbols(STATES)))[0]) for i in range(len(pivots))],
    }


def sympy_matrix() -> dict:
    """The same L with sin and cos as sympy writes them; ``Matrix.rref`` with its default simplification."""
    import sympy

    t, omega = sympy.symbols("t omega")
    A, H = _matrices(sympy.cos(omega * t), sympy.sin(omega * t))
    L = [H]
    for _ in range(ORDERS):
        L.append(L[-1].diff(t) + L[-1] * A)
    _, pivots = sympy.Matrix.vstack(*L).rref()
    return {"rank": len(pivots), "combinations": len(pivots), "states": len(STATES)}


def _detected(**options):
    import symident

    odes, outputs = stage_1("c", "s")
    odes |= {"c": "-omega*s", "s": "omega*c"}
    model = symident.Model(odes, outputs, fixed=[*CONSTANTS, "c", "s"])
    return symident.detect(model, reconstruct=True, **options)


def _reduced(result) -> dict:
    """Coordinates that no direction moves, and the invariants of the blocks that do move."""
    reduction = result.reduce(check=False)
    moved = {name for one in result.symmetries for name in one.support}
    invariants = [text for block in reduction.blocks for text in block.get("invariants") or []]
    still = [name for name in result.info["coordinates"] if name not in moved]
    return {
        "rank": result.rank,
        "combinations": len(still) + len(invariants),
        "states": result.dim,
        "remark": "; ".join(reduction.limits)[:60],
        "answer": still + invariants,
    }


def _matrices(cosine, sine):
    """A and H as sympy matrices."""
    import sympy

    odes, outputs = stage_1("c", "s")
    symbols = sympy.symbols(STATES)
    rates = {sympy.Symbol("c"): cosine, sympy.Symbol("s"): sine}

    def rows(texts):
        matrix = sympy.zeros(len(texts), len(symbols))
        for i, text in enumerate(texts):
            form = sympy.sympify(text)
            for j, symbol in enumerate(symbols):
                if symbol in form.free_symbols:
                    matrix[i, j] = form.diff(symbol).subs(rates)
        return matrix

    return rows(list(odes.values())), rows(list(outputs.values()))


PEERS = {
    "symident detect": symident_detect,
    "symident reduce": symident_reduce,
    "symident reduce, as default": symident_reduce_default,
    "sympy DomainMatrix.rref": sympy_domainmatrix,
    "sympy Matrix.rref": sympy_matrix,
}


# ---------------------------------------------------------------- the driver


def answer(name: str, run: Run, limit: int) -> dict:
    """What the process answered, or why it did not."""
    if run.code < 0:
        return {"remark": f"no answer in {limit} s"}
    if run.trouble:
        return {"remark": run.trouble}
    if name != "obscli":
        return json.loads(run.out.splitlines()[-1])
    found = json.loads(run.out)["results"][0]["analytic"]
    texts = [one["expression"] for one in found["combinations"]]
    critical = len(found.get("critical") or [])
    remark = f"with proof and {critical} critical values"
    return {
        "rank": found["rank"],
        "combinations": len(texts),
        "states": len(found["states"]),
        "directions": len(found["unobservable"]),
        "remark": remark,
        "answer": texts,
    }


def main() -> None:
    parser = argparse.ArgumentParser(description="obscli beside its peers on one system.")
    parser.add_argument("--child", choices=PEERS, help=argparse.SUPPRESS)
    parser.add_argument("--only", nargs="+", choices=["obscli", *PEERS], help="only these")
    parser.add_argument("--runs", type=int, default=3, help="runs of each that ends within 10 s")
    parser.add_argument("--limit", type=int, default=20, help="CPU seconds for each of the others")
    parser.add_argument(
        "--reduce-limit", type=int, default=150, help="CPU seconds for reduce as default; 0: skip"
    )
    parser.add_argument("--answers", action="store_true", help="print each answer in full")
    given = parser.parse_args()
    if given.child:
        print(json.dumps(PEERS[given.child]()))
        return
    commands = {
        "obscli": [OBSCLI, "analyze", MODEL, "--stage", "stage_1", "--only", "analytic", "--format", "json"]
    }
    commands |= {name: [sys.executable, str(Path(__file__).resolve()), "--child", name] for name in PEERS}
    limits = dict.fromkeys(commands, given.limit) | {"symident reduce, as default": given.reduce_limit}
    wanted = [name for name in commands if limits[name] and (not given.only or name in given.only)]
    for name in wanted:
        fresh(commands[name], 5)  # unmeasured: compiles modules edited or installed since, fills file caches
    runs = {name: [fresh(commands[name], limits[name])] for name in wanted}
    again = [name for name in wanted if runs[name][0].cpu < 10 and not runs[name][0].trouble]
    for _ in range(given.runs - 1):  # in turn: whatever else the machine does falls on all alike
        for name in again:
            runs[name].append(fresh(commands[name], limits[name]))
    answers = {name: answer(name, runs[name][-1], limits[name]) for name in wanted}
    print(_report(runs, answers))
    if given.answers:
        for name, found in answers.items():
            print(f"\n{name}:", *found.get("answer", ["no answer"]), sep="\n  ")


def _report(runs: dict[str, list[Run]], answers: dict[str, dict]) -> str:
    own = runs.get("obscli")
    base = median(own) if own and not own[0].trouble else None
    rows = []
    for name, found in answers.items():
        if runs[name][0].code > 0:
            rows.append([name, *["–"] * 8, found["remark"]])
            continue
        cpu = median(runs[name])
        more = "≥ " if runs[name][0].code < 0 else ""
        rows.append(
            [
                name,
                f"{more}{cpu:.2f}",
                spread([run.cpu for run in runs[name]]),
                f"{more}{cpu / base:.1f}" if base else "?",
                f"{peak(runs[name]):.0f}",
                *(str(found.get(key, "–")) for key in ("rank", "combinations", "directions")),
                f"{found['states']} of {len(STATES)}" if "states" in found else "–",
                found.get("remark", ""),
            ]
        )
    header = [
        "tool",
        "CPU s",
        "min–max",
        "ratio",
        "MB",
        "rank",
        "combinations",
        "directions",
        "states",
        "remark",
    ]
    return table(header, rows)


if __name__ == "__main__":
    main()
