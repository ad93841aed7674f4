"""The claims of models/calibration/*.yaml against calibration_rank.py: no obscli code, no obscli parser.

python tests/independent/calibration_claims.py
"""

from __future__ import annotations

import re
import sys
from fractions import Fraction
from pathlib import Path

import sympy
import yaml


HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

from calibration_rank import reduced, said, together  # noqa: E402
from calibration_runs import EXPERIMENTS, Point  # noqa: E402


MODELS = HERE.parents[1] / "models" / "calibration"
# Where only some of the runs of calibration_rank are the experiment of the file: which.
OWN = {"table_plan": r".*outer = pi/2", "modulus": "motor"}
FIXED = {  # in a stage, where no run says otherwise
    "table_plan": {"outer": "pi/2"},
    "two_axis_table": {"outer": "pi/2", "inner": "0"},
}
FIELDS = {"stage", "experiment", "runs", "at", "rank", "basis", "determined", "observable", "unobservable"}
FIELDS |= {"directions", "states"}


class Text:
    """Combinations and directions of a claim at one point."""

    def __init__(self, constants, p):
        self.constants = constants
        value = {"cos": p.phi[0], "sin": p.phi[1]}
        self.names = {c: sympy.Symbol(c) for c in (*constants, "phi")} | {
            k: sympy.Rational(v.numerator, v.denominator) for k, v in p.values.items()
        }
        self.names |= {f: lambda _, v=v: sympy.Rational(v.numerator, v.denominator) for f, v in value.items()}

    def number(self, x):
        return Fraction(int(x.p), int(x.q))

    def rows(self, text):
        """One row, or one a component for the name of a vector."""
        parts = [c for c in self.constants if re.fullmatch(re.escape(text) + r"\d+", c)]
        for part in parts or [text]:
            form = sympy.expand(sympy.sympify(part, locals=self.names))
            yield [self.number(form.coeff(self.names[c], 1)) for c in self.constants]

    def vector(self, mapping):
        assert set(mapping) <= set(self.constants), mapping
        return [self.number(sympy.sympify(mapping.get(c, "0"), locals=self.names)) for c in self.constants]


def disagreements(claim, constants, rows, pivots, p):
    text = Text(constants, p)
    yield from (f"field {key} is not checked here" for key in set(claim) - FIELDS)

    def inside(row):
        for base, pivot in zip(rows, pivots, strict=True):
            row = [x - row[pivot] * y for x, y in zip(row, base, strict=True)]
        return not any(row)

    for key, wanted in (("determined", True), ("observable", True), ("basis", True), ("unobservable", False)):
        found = [(one, row) for one in claim.get(key, []) for row in text.rows(one)]
        yield from (f"{key}: {one}" for one, row in found if inside(row) != wanted)
        if (
            key == "basis"
            and found
            and {len(found), len(reduced([row for _, row in found])[0])} != {len(rows)}
        ):
            yield "basis: not complete"
    for direction in claim.get("directions", []):
        v = text.vector(direction)
        if not any(v) or any(sum(a * b for a, b in zip(row, v, strict=True)) for row in rows):
            yield f"direction {direction}"
    for name, verdict in claim.get("states", {}).items():
        [unit] = text.rows(name)
        seen = "coupled" if any(row[unit.index(1)] for row in rows) else "unobservable"
        if verdict != ("observable" if inside(unit) else seen):
            yield f"{name}: {verdict}"


def check(folder=MODELS):
    """Compare every claim and expectation with what is computed; return disagreements and their count."""
    wrong, compared = [], 0
    for model in [m for m in EXPERIMENTS if "," not in m]:
        document = yaml.load((folder / f"{model}.yaml").read_text(encoding="utf-8"), Loader=yaml.BaseLoader)
        constants, _, runs = EXPERIMENTS[model]
        entries = [(k, i, claim) for k in ("claims", "expect") for i, claim in enumerate(document.get(k, []))]
        for kind, number, claim in entries:
            for seed in (0, 1):
                if "experiment" in claim:
                    labels = claim.get("runs") or [run for run in runs if re.match(OWN.get(model, ""), run)]
                    (rows, pivots), p = together(model, labels, seed), Point(seed, {})
                    rank = len(rows)
                else:
                    at = tuple((FIXED.get(model, {}) | claim.get("at", {})).items())
                    rank, rows, p = said(model, claim.get("stage"), at, seed)
                    rows, pivots = reduced(rows)
                head = f"{model} {kind}[{number}], point {seed}"
                if int(claim.get("rank", rank)) != rank:
                    wrong.append(f"{head}: rank {claim['rank']}, computed {rank}")
                problems = disagreements(claim, constants, rows, pivots, p)
                wrong += [f"{head}: {problem}" for problem in problems]
            compared += 1
    return wrong, compared


if __name__ == "__main__":
    found, number = check()
    sys.stdout.write(("\n".join(found) or f"all {number} entries agree") + "\n")
    sys.exit(bool(found))
