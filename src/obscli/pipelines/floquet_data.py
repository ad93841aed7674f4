"""The Floquet–Lyapunov reduction as JSON values."""

from __future__ import annotations

from obscli.core.number import json_number
from obscli.numeric.finding import FloquetMode, NotComputed
from obscli.numeric.floquet_finding import Equivalent, Floquet


def floquet_data(found: Floquet) -> dict[str, object]:
    """Return ``{start, period, states, monodromy, monodromy_error, modes, equivalent, reason}``.

    ``equivalent`` is None where there is none that can be trusted; ``reason`` says why. Matrices are lists of
    rows, complex numbers pairs of real and imaginary part.
    """
    return {
        "start": found.start,
        "period": found.period,
        "states": list(found.states),
        "monodromy": found.monodromy.tolist(),
        "monodromy_error": json_number(found.monodromy_error.max(initial=0.0)),
        "modes": [_mode(one) for one in found.modes],
        **_equivalent(found.equivalent),
    }


def _mode(one: FloquetMode) -> dict[str, object]:
    return {
        "multiplier": [one.multiplier.real, one.multiplier.imag],
        "exponent": [one.exponent.real, one.exponent.imag],
        "kind": one.kind,
        "error": json_number(one.error),
        "direction": dict(one.direction),
    }


def _equivalent(found: Equivalent | NotComputed) -> dict[str, object]:
    if isinstance(found, NotComputed):
        return {"equivalent": None, "reason": found.reason}
    return {
        "equivalent": {
            "R": found.R.tolist(),
            "R_error": json_number(found.R_error.max(initial=0.0)),
            "doubled": found.doubled,
            "t": found.instants.tolist(),
            "P": found.P.tolist(),
            "HP": found.outputs.tolist(),
            "residual": json_number(found.residual),
            "condition": json_number(found.condition),
        },
        "reason": "",
    }
