"""A certificate altered anywhere no longer holds.

Each field of several certificates is altered, one at a time, into something different; the check must not
say *holds*. Left out, because what they say is still true: scaling a direction as a whole (with its
multiplier), permuting directions together with multipliers, even permutations of the rows or columns of the
minor, adding an unobservable direction to the delayed one, and a midpoint or radius changed by less than
the rounding of its print.
"""

from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import pytest

from obscli.checks.certificate import check_certificate
from obscli.exact.analysis import Options, analyze
from obscli.exact.lower import PRECISIONS
from obscli.model.expression import Symbol, add, is_zero, multiply, number
from obscli.model.reader import load, read_text


MODELS = Path(__file__).parents[2] / "models"
ONE = number(1)


def _bundled(file, stage=None):
    return next(s for s in load(MODELS / file).systems if s.stage == stage)


CONSTANTS = """\
states: [x1, x2, x3]
A: [[0, pi, 0], [0, 0, 0], [0, 0, 0]]
H: [["1", "0", "0"], ["0", "0", "exp(1)*t"]]
"""
#: rank 0 and full rank: nothing to prove on one side
BLIND = "states: [x1, x2]\nA: [[0, 1], [0, 0]]\nH: [[0, 0]]\n"
#: as many rows below the order as the rank: that the order is no lower needs a proof
TWICE = "states: [x, v, a, b]\nA: [[0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 0], [0, 0, 0, 0]]\nH: [[1, 0, 0, 0], [2, 0, 0, 0]]\n"

SYSTEMS = {
    "ins stage 1": lambda: _bundled("ins_calibration/horizontal.yaml", "stage_1"),
    "quaternion": lambda: _bundled("textbook/attitude_quaternion.yaml", "one_axis"),
    "double integrator": lambda: _bundled("textbook/double_integrator.yaml", "position"),
    "velocity only": lambda: _bundled("textbook/double_integrator.yaml", "velocity"),
    "levelling": lambda: _bundled("textbook/levelling.yaml"),
    "mixed": lambda: _bundled("textbook/mixed_coefficients.yaml"),
    "velocity aiding": lambda: _bundled("textbook/ins_velocity_aiding.yaml", "constant_velocity"),
    "turning": lambda: _bundled("textbook/frozen_observable.yaml"),
    "constants": lambda: read_text(CONSTANTS, "constants.yaml").systems[0],
    "blind": lambda: read_text(BLIND, "blind.yaml").systems[0],
    "measured twice": lambda: read_text(TWICE, "twice.yaml").systems[0],
}


@pytest.fixture(scope="module", params=SYSTEMS)
def proved(request):
    """A system, its certificate and its combinations."""
    system = SYSTEMS[request.param]()
    found = analyze(system, Options(critical=False))
    return system, found.certificate, [c.coefficients for c in found.combinations]


def _verdict(system, certificate, combinations):
    return check_certificate(system, certificate, combinations).verdict


def _held(proved, altered):
    """Names of the alterations that the check lets pass, or stumbles over."""
    system, _, combinations = proved
    verdicts = {
        name: _verdict_or_crash(system, certificate, combinations) for name, certificate in altered.items()
    }
    return [
        f"{name}: {verdict}" for name, verdict in verdicts.items() if verdict not in {"fails", "undecided"}
    ]


def _verdict_or_crash(system, certificate, combinations):
    try:
        return _verdict(system, certificate, combinations)
    except Exception as error:  # noqa: BLE001 - a forged certificate must not break the check
        return f"crash, {error!r}"


def _lower(certificate, **changes):
    return replace(certificate, lower=replace(certificate.lower, **changes))


def _upper(certificate, **changes):
    return replace(certificate, upper=replace(certificate.upper, **changes))


def _swapped(items, i, j):
    items = list(items)
    items[i], items[j] = items[j], items[i]
    return tuple(items)


def _without(items, k):
    return (*items[:k], *items[k + 1 :])


def _put(items, k, item):
    return (*items[:k], item, *items[k + 1 :])


def test_the_certificate_itself_holds(proved):
    system, certificate, combinations = proved
    assert _verdict(system, certificate, combinations) == "holds"
    assert _verdict(system, certificate, None) == "holds"


def test_altered_headers_are_rejected(proved):
    _, c, _ = proved
    altered = {
        "rank + 1": replace(c, rank=c.rank + 1),
        "rank - 1": replace(c, rank=c.rank - 1),
        "rank -rank": replace(c, rank=-1 - c.rank),
        "order + 1": replace(c, order=c.order + 1),
        "order - 1": replace(c, order=c.order - 1),
        "digest empty": replace(c, model=""),
        "digest, one digit": replace(c, model=("0" if c.model[0] != "0" else "1") + c.model[1:]),
        "digest, cut": replace(c, model=c.model[:-1]),
        "assumes more": replace(c, assumes=(*c.assumes, "log(7)")),
        **{
            f"assumes without {a}": replace(c, assumes=_without(c.assumes, k))
            for k, a in enumerate(c.assumes)
        },
        **({"assumes reversed": replace(c, assumes=c.assumes[::-1])} if len(c.assumes) > 1 else {}),
    }
    assert not _held(proved, altered)


def test_an_altered_minor_is_rejected(proved):
    system, c, _ = proved
    low = c.lower
    altered = {"one row more": _lower(c, rows=(*low.rows, (system.outputs[0].name, c.order)))}
    for k, (output, order) in enumerate(low.rows):
        altered[f"row {k} dropped"] = _lower(c, rows=_without(low.rows, k))
        altered[f"row {k} of unknown output"] = _lower(c, rows=_put(low.rows, k, ("no_such_output", order)))
        altered[f"row {k} one order up"] = _lower(c, rows=_put(low.rows, k, (output, order + 1)))
        altered[f"row {k} order negative"] = _lower(c, rows=_put(low.rows, k, (output, -1)))
        if k:
            altered[f"row {k} twice"] = _lower(c, rows=_put(low.rows, k, low.rows[k - 1]))
            altered[f"rows {k - 1}, {k} swapped"] = _lower(c, rows=_swapped(low.rows, k - 1, k))
    names = system.state_names
    for k, column in enumerate(low.columns):
        altered[f"column {k} dropped"] = _lower(c, columns=_without(low.columns, k))
        altered[f"column {k} unknown"] = _lower(c, columns=_put(low.columns, k, column + "_"))
        if k:
            altered[f"column {k} twice"] = _lower(c, columns=_put(low.columns, k, low.columns[k - 1]))
            altered[f"columns {k - 1}, {k} swapped"] = _lower(c, columns=_swapped(low.columns, k - 1, k))
        for other in sorted(set(names) - set(low.columns))[k % 3 :: 3]:
            altered[f"column {k} is {other}"] = _lower(c, columns=_put(low.columns, k, other))
    assert not _held(proved, altered)


def test_an_altered_point_is_rejected(proved):
    """The minor is a number that depends on the point: where it does not (shown here), the value is idle."""
    system, c, combinations = proved
    low = c.lower
    altered, moved = {"a name more": _lower(c, point={**low.point, "no_such_name": "1"})}, {}
    for name, value in low.point.items():
        rest = {n: v for n, v in low.point.items() if n != name}
        moved[name] = _lower(c, point={**rest, name: str(Fraction(value) + Fraction(1, 7))})
        altered[f"{name} not a number"] = _lower(c, point={**rest, name: "one"})
        altered[f"{name} nan"] = _lower(c, point={**rest, name: "nan"})
        altered[f"{name} over zero"] = _lower(c, point={**rest, name: "1/0"})
        altered[f"{name} renamed"] = _lower(c, point={**rest, name + "_": value})
        altered[f"{name} dropped"] = _lower(c, point=rest)
    assert not _held(proved, altered)
    # a value that may be moved freely does not enter the minor: the certificate says nothing false with it
    verdicts = {
        name: _verdict_or_crash(system, certificate, combinations) for name, certificate in moved.items()
    }
    assert set(verdicts.values()) <= {"holds", "fails", "undecided"}
    for name in (n for n, verdict in verdicts.items() if verdict == "holds"):
        far = {**low.point, name: str(Fraction(low.point[name]) - Fraction(1, 23))}
        assert _verdict(system, _lower(c, point=far), combinations) == "holds", f"the minor depends on {name}"


def test_only_the_time_is_idle_in_stage_1():
    """Every parameter stands in the minor of stage 1; the time does not, so any time proves the same."""
    system = SYSTEMS["ins stage 1"]()
    c = analyze(system, Options(critical=False)).certificate
    assert set(c.lower.point) == {"t", "omega", "omega_ie", "phi", "g"}
    for name, value in c.lower.point.items():
        moved = {**c.lower.point, name: str(Fraction(value) + Fraction(1, 7))}
        assert _verdict(system, _lower(c, point=moved), None) == ("holds" if name == "t" else "fails"), name


def test_an_altered_ball_is_rejected(proved):
    _, c, _ = proved
    low = c.lower
    middle = Fraction(low.midpoint)
    altered = {
        "midpoint negated": _lower(c, midpoint=str(-float(middle))),
        "midpoint zero": _lower(c, midpoint="0"),
        "midpoint a little off": _lower(c, midpoint=f"{float(middle) * (1 + 1e-9):.15g}"),
        "midpoint doubled": _lower(c, midpoint=f"{float(middle) * 2:.15g}"),
        "midpoint not a number": _lower(c, midpoint="nan"),
        "midpoint empty": _lower(c, midpoint=""),
        "midpoint infinite": _lower(c, midpoint="inf"),
        "midpoint a ball": _lower(c, midpoint=f"{low.midpoint} +/- 1e9"),
        "radius huge": _lower(c, radius="1e300"),
        "radius negative": _lower(c, radius="-1"),
        "radius nan": _lower(c, radius="nan"),
        "radius empty": _lower(c, radius=""),
        "radius infinite": _lower(c, radius="inf"),
        "radius one": _lower(c, radius=str(1 + float(low.radius))),
        "radius of the midpoint": _lower(c, radius=str(2 * abs(float(middle)))),
        **{f"precision {p}": _lower(c, precision=p) for p in (0, -1, 1, 53, 127, 129, 10**9)},
    }
    if float(low.radius):
        altered["radius zero"] = _lower(c, radius="0")
        altered |= {f"precision {p}": _lower(c, precision=p) for p in set(PRECISIONS) - {low.precision}}
    assert not _held(proved, altered)


def test_an_altered_direction_is_rejected(proved):
    system, c, _ = proved
    up = c.upper
    altered = {"one direction more": _upper(c, kernel=(*up.kernel, {system.state_names[0]: ONE}))}
    for k, column in enumerate(up.kernel):
        altered[f"direction {k} dropped"] = _upper(c, kernel=_without(up.kernel, k))
        altered[f"direction {k} zero"] = _upper(c, kernel=_put(up.kernel, k, {}))
        altered[f"direction {k} of an unknown state"] = _upper(
            c, kernel=_put(up.kernel, k, {**column, "zz": ONE})
        )
        if k:
            altered[f"direction {k} twice"] = _upper(c, kernel=_put(up.kernel, k, up.kernel[k - 1]))
        for state, entry in column.items():
            rest = {s: e for s, e in column.items() if s != state}
            if rest or len(column) == 1:
                altered[f"direction {k} without {state}"] = _upper(c, kernel=_put(up.kernel, k, rest))
            if rest:
                for name, other in (("doubled", multiply(number(2), entry)), ("plus one", add(entry, ONE)),
                                    ("negated", multiply(number(-1), entry))):  # fmt: skip
                    changed = {**rest, state: other}
                    altered[f"direction {k}, {state} {name}"] = _upper(c, kernel=_put(up.kernel, k, changed))
        for state in sorted(set(system.state_names) - column.keys() - _alone(up.kernel))[:4]:
            changed = {**column, state: ONE}
            altered[f"direction {k} with {state}"] = _upper(c, kernel=_put(up.kernel, k, changed))
    assert not _held(proved, altered)


def _alone(kernel):
    """States that are a direction by themselves: adding one to another direction keeps the space."""
    return {state for column in kernel if len(column) == 1 for state in column}


def test_an_altered_multiplier_is_rejected(proved):
    _, c, _ = proved
    up = c.upper
    altered = {"one column more": _upper(c, multiplier=(*up.multiplier, (ONE,)))}
    for k, column in enumerate(up.multiplier):
        altered[f"column {k} dropped"] = _upper(c, multiplier=_without(up.multiplier, k))
        altered[f"column {k} short"] = _upper(c, multiplier=_put(up.multiplier, k, column[:-1]))
        altered[f"column {k} long"] = _upper(c, multiplier=_put(up.multiplier, k, (*column, ONE)))
        for j, entry in enumerate(column):
            others = {"plus one": add(entry, ONE), "unknown name": Symbol("no_such_name")}
            if not is_zero(entry):
                others |= {"negated": multiply(number(-1), entry), "zero": number(0)}
            for name, other in others.items():
                altered[f"X[{j}, {k}] {name}"] = _upper(
                    c, multiplier=_put(up.multiplier, k, _put(column, j, other))
                )
    assert not _held(proved, altered)


def _needs_delay(system, certificate):
    """Whether there are as many rows below the order as the rank: with fewer the order is clear without it."""
    return certificate.order * system.m >= certificate.rank


def test_only_too_few_rows_below_the_order_need_no_delay(proved):
    system, c, combinations = proved
    if c.order:
        expected = "fails" if _needs_delay(system, c) else "holds"
        assert _verdict(system, _upper(c, delay=None), combinations) == expected


def test_both_kinds_of_order_are_tampered_with():
    systems = {name: make() for name, make in SYSTEMS.items()}
    found = {n: analyze(s, Options(critical=False)).certificate for n, s in systems.items()}
    needs = {name: _needs_delay(systems[name], c) for name, c in found.items() if c.order}
    assert set(needs.values()) == {True, False}


def test_an_altered_delay_is_rejected(proved):
    system, c, _ = proved
    delay = c.upper.delay
    if delay is None:
        added = _upper(c, delay={system.state_names[0]: ONE})
        assert not _held(proved, {"added": added})
        return
    altered = {
        **({"none": _upper(c, delay=None)} if _needs_delay(system, c) else {}),
        "zero": _upper(c, delay={}),
        "unknown state": _upper(c, delay={**delay, "zz": ONE}),
        **{f"direction {k}": _upper(c, delay=column) for k, column in enumerate(c.upper.kernel)},
    }
    # measured states are seen at order 0: they cannot stand in a delayed direction
    for output in range(system.m):
        row = [j for i, j in system.H.entries if i == output]
        if len(row) == 1 and c.order:
            state = system.state_names[row[0]]
            altered[f"with {state}"] = _upper(
                c, delay={**delay, state: add(delay.get(state, number(0)), ONE)}
            )
    assert not _held(proved, altered)


def test_altered_combinations_are_rejected(proved):
    system, c, combinations = proved
    kernel_states = {s for column in c.upper.kernel for s in column}
    held = []
    for k, row in enumerate(combinations):
        versions = {
            "dropped": [*combinations[:k], *combinations[k + 1 :]],
            "zero": [*combinations[:k], {}, *combinations[k + 1 :]],
            "added twice": [*combinations, row],
            "unknown state": [*combinations[:k], {**row, "zz": ONE}, *combinations[k + 1 :]],
        }
        if k:
            versions["doubled"] = [*combinations[:k], combinations[k - 1], *combinations[k + 1 :]]
        for state in set(row) & kernel_states:
            for name, other in (
                ("plus one", add(row[state], ONE)),
                ("negated", multiply(number(-1), row[state])),
            ):
                versions[f"{state} {name}"] = [
                    *combinations[:k],
                    {**row, state: other},
                    *combinations[k + 1 :],
                ]
        for state in sorted(kernel_states - set(row))[:3]:
            versions[f"with {state}"] = [*combinations[:k], {**row, state: ONE}, *combinations[k + 1 :]]
        verdicts = {n: _verdict_or_crash(system, c, version) for n, version in versions.items()}
        held += [(k, n, v) for n, v in verdicts.items() if v not in {"fails", "undecided"}]
    assert not held


def test_a_certificate_of_another_system_is_rejected():
    systems = {name: make() for name, make in SYSTEMS.items()}
    certificates = {n: analyze(s, Options(critical=False)).certificate for n, s in systems.items()}
    for name, system in systems.items():
        for other, certificate in certificates.items():
            if other != name:
                assert _verdict(system, certificate, None) == "fails", (name, other)
                forged = replace(certificate, model=certificates[name].model)
                assert _verdict(system, forged, None) != "holds", (name, other)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("omega_ie*cos(phi)", "omega_ie*sin(phi)"),
        ("g: {value: 9.81", "g: {value: 9.80"),
        ("psi: -cross", "psi: cross"),
        ("/g", "/g^2"),
    ],
)
def test_a_certificate_knows_whether_its_model_has_changed(old, new):
    text = (MODELS / "ins_calibration/horizontal.yaml").read_text()
    text = text[: text.index("claims:")]
    system = next(s for s in read_text(text, "before.yaml").systems if s.stage == "stage_1")
    assert old in text
    changed = next(s for s in read_text(text.replace(old, new), "after.yaml").systems if s.stage == "stage_1")
    certificate = analyze(system, Options(critical=False)).certificate
    # a nominal value is no part of the generic statement; everything else is
    assert _verdict(changed, certificate, None) == ("holds" if "9.81" in old else "fails")


def test_a_certificate_knows_the_assumptions_and_the_time_of_its_model():
    """sqrt(a^2) = a only with a > 0; cos(s) varies only where s is the time."""
    plain = "parameters: {{a: {{assume: {how}}}, s: null}}\ntime: {time}\nstates: [x, z]\nA: zeros(2, 2)\nH: [[cos(s), a]]\n"
    one = read_text(plain.format(how="positive", time="t"), "one.yaml").systems[0]
    certificate = analyze(one, Options(critical=False)).certificate
    other = read_text(
        "parameters: {a: {assume: positive}, t: null}\ntime: s\nstates: [x, z]\nA: zeros(2, 2)\nH: [[cos(s), a]]\n",
        "two.yaml",
    ).systems[0]
    assert _verdict(one, certificate, None) == "holds"
    assert _verdict(other, certificate, None) != "holds"


def test_a_lower_rank_cannot_be_certified_by_dropping_rows_and_adding_directions():
    """The forger keeps everything consistent: rank 1 of the double integrator with a second 'direction'."""
    system = SYSTEMS["double integrator"]()
    c = analyze(system, Options(critical=False)).certificate
    forged = replace(
        c,
        rank=1,
        order=0,
        lower=replace(
            c.lower,
            rows=c.lower.rows[:1],
            columns=c.lower.columns[:1],
            midpoint="1.00000000000000",
            radius="0",
        ),
        upper=replace(c.upper, kernel=({"v": ONE},), multiplier=((number(0),),), delay=None),
    )
    assert _verdict(system, forged, None) == "fails"


def test_a_higher_rank_cannot_be_certified_by_dropping_directions():
    system = SYSTEMS["velocity only"]()
    c = analyze(system, Options(critical=False)).certificate
    forged = replace(
        c,
        rank=2,
        order=1,
        lower=replace(
            c.lower,
            rows=(*c.lower.rows, (c.lower.rows[0][0], 1)),
            columns=("x", "v"),
            midpoint="1.0",
            radius="0",
        ),
        upper=replace(c.upper, kernel=(), multiplier=(), delay={"x": ONE}),
    )
    assert _verdict(system, forged, None) == "fails"


def test_an_order_too_high_cannot_be_certified():
    """Rows taken later than they first appear: the rank is right, the order is not."""
    system = read_text("states: [x, z]\nA: [[0, 1], [0, 0]]\nH: [[1, 0], [0, 1]]\n", "two.yaml").systems[0]
    c = analyze(system, Options(critical=False)).certificate
    assert (c.rank, c.order) == (2, 0)
    late = replace(
        c,
        order=1,
        lower=replace(c.lower, rows=((c.lower.rows[0][0], 0), (c.lower.rows[0][0], 1))),
        upper=replace(c.upper, delay={"z": ONE}),
    )
    assert _verdict(system, late, None) == "fails"
