"""Random systems whose rank, saturation, hidden directions and critical values are known by construction."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest

from obscli.checks.certificate import check_certificate
from obscli.exact.analysis import Options, analyze, contained
from obscli.exact.finding import Analysis
from obscli.exact.interpreter import Interpreter
from obscli.model.covector import parse_scalar
from obscli.model.expression import add, multiply


_spec = importlib.util.spec_from_file_location("known", Path(__file__).with_name("known.py"))
known = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(known)

SYSTEMS = 220
WITH_CRITICAL = 60


def _analysis(system, built, **options):
    given = system(built.text)
    found = analyze(given, Options(**options))
    assert isinstance(found, Analysis), getattr(found, "reason", "")
    return given, found


def _annihilates(given, found, built):
    """Whether every combination is exactly zero along every hidden direction."""
    hidden = [{s: parse_scalar(given, e, "known") for s, e in d.items()} for d in built.hidden]
    products = [
        add(*(multiply(c.coefficients[s], d[s]) for s in d if s in c.coefficients))
        for c in found.combinations
        for d in hidden
    ]
    interpreter = Interpreter(given, products)
    return not any(interpreter.read(p) for p in products)


def _expected_verdicts(built):
    """Observable: no hidden direction moves the state; unobservable: it alone spans a hidden direction."""
    names = [f"x{k + 1}" for k in range(built.n)]
    rows = np.array(known.float_directions(built)).reshape(len(built.hidden), built.n)
    verdicts = {}
    for k, name in enumerate(names):
        unit = np.eye(built.n)[k]
        alone = len(rows) > 0 and np.linalg.matrix_rank(np.vstack([rows, unit]), 1e-9) == len(rows)
        still = not np.any(np.abs(rows[:, k]) > 1e-12)
        verdicts[name] = "observable" if still else "unobservable" if alone else "coupled"
    return verdicts


@pytest.mark.parametrize("seed", range(SYSTEMS))
def test_rank_order_directions_and_verdicts_are_those_built_in(system, seed):
    built = known.build(seed, breakable=seed % 2 == 0)
    given, found = _analysis(system, built, critical=False)
    assert (found.rank, found.order) == (built.rank, built.order)
    assert len(found.combinations) == built.rank
    assert len(found.unobservable) == built.n - built.rank
    assert _annihilates(given, found, built)
    assert dict(found.states) == _expected_verdicts(built)
    covectors = [c.coefficients for c in found.combinations]
    assert all(contained(found, covectors))
    checked = check_certificate(given, found.certificate, covectors)
    assert checked.verdict == "holds", checked.reason
    assert all(built.order >= c.order for c in found.combinations)


@pytest.mark.parametrize("seed", range(1000, 1000 + WITH_CRITICAL))
def test_critical_values_are_exactly_those_built_in(system, seed):
    built = known.build(seed, breakable=True, shears=2)
    _, found = _analysis(system, built)
    assert found.rank == built.rank
    assert found.critical.complete
    assert not [v.condition for v in found.critical.values if v.kind != "confirmed"]
    assert {v.condition: v.rank for v in found.critical.values} == {
        f"{c} = 0": r for c, r in built.critical.items()
    }
    for value in found.critical.values:
        assert found.rank - value.rank <= len(value.lost) <= found.rank


@pytest.mark.parametrize("seed", range(1000, 1000 + WITH_CRITICAL, 4))
def test_the_rank_at_a_critical_value_is_the_one_built_in(system, seed):
    built = known.build(seed, breakable=True, shears=2)
    for name, rank in built.critical.items():
        special = built.text.replace(f"{name}: null", f"{name}: 0")
        for other in [*built.critical, *built.rates]:
            special = special.replace(f"{other}: null", f"{other}: 3/7")
        found = analyze(system(special), Options(critical=False))
        assert found.at_values.rank == rank
        assert found.rank == built.rank
        assert found.at_values.because == (f"{name} = 0",)
