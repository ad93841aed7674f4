"""Claims of the bundled models hold; one thing altered in a claim makes it fail.

A claim is altered so that it says something false: a rank one off, a verdict exchanged, a row or a term of a
basis changed, a direction bent. Scaling a row or a direction as a whole would leave it true and is no
alteration; neither is a state verdict that is not given.
"""

from dataclasses import replace
from functools import cache
from pathlib import Path

import pytest

from obscli.api import calibrate, verify
from obscli.checks.claims import check_claims
from obscli.exact.analysis import Options, analyze
from obscli.model.expression import add, multiply, number
from obscli.model.reader import load, read_text
from obscli.model.system import Quantity
from obscli.numeric.analysis import analyze as gramian
from obscli.numeric.settings import Settings
from obscli.pipelines.request import CalibrateRequest, NumericRequest
from obscli.pipelines.verify_segments import verify_segments


MODELS = Path(__file__).parents[2] / "models"
FILES = sorted(MODELS.glob("**/*.yaml"))
EXPERIMENTS = [pytest.param(file, id=file.stem) for file in FILES if load(file).claims]
SEGMENTS = [pytest.param(file, id=file.stem) for file in FILES if load(file).segments]
FAST = Options(critical=False, certificate=False)
ONE, TWO = number(1), number(2)
OTHERS = {"observable": ("coupled", "unobservable"), "coupled": ("observable", "unobservable"),
          "unobservable": ("observable", "coupled")}  # fmt: skip


def _systems():
    return [pytest.param(s, id=f"{f.stem}-{s.stage or 'base'}") for f in FILES for s in load(f).systems]


def _verdicts(system, claims, analysis=None):
    system = replace(system, claims=tuple(claims))
    return [r.verdict for r in check_claims(system, analysis or analyze(system, FAST))]


def _of_experiment(model, claims):
    """The results of claims about the experiment of a model, by both sides, in order."""
    systems = tuple(replace(system, claims=()) for system in model.systems)
    report = verify(replace(model, systems=systems, claims=tuple(claims), segments=None))
    return [check for check in report.results[-1].checks if check.place is not None]


def _of_segments(model, claims):
    """The results of claims about the segments of a model, in order."""
    whole = replace(model, segments=replace(model.segments, claims=tuple(claims)))
    found = verify_segments(whole, NumericRequest(), lambda _: None)
    return [check for check in found.checks if check.place is not None]


def _say_what_is_true(results):
    assert results
    assert [f"{r.claim}: {r.reason}" for r in results if r.verdict != "holds"] == []
    assert all(r.place is not None for r in results)


@pytest.mark.parametrize("system", _systems())
def test_the_claims_of_every_bundled_model_hold(system):
    """By algebra alone; what it leaves open, since hidden errors move with time, by their multipliers."""
    results = check_claims(system, analyze(system, FAST))
    if [r for r in results if r.verdict == "undecided" and "depends on time" in r.reason]:
        results = check_claims(system, analyze(system, FAST), look=lambda s: gramian(s, Settings()))
    _say_what_is_true(results)


@pytest.mark.parametrize("file", EXPERIMENTS)
def test_the_claims_about_every_bundled_experiment_hold(file):
    model = load(file)
    _say_what_is_true(_of_experiment(model, model.claims))


@pytest.mark.parametrize("file", SEGMENTS)
def test_the_claims_about_segments_hold(file):
    model = load(file)
    _say_what_is_true(_of_segments(model, model.segments.claims))


@pytest.mark.parametrize("file", SEGMENTS)
def test_a_claim_about_segments_altered_in_one_thing_fails(file):
    model = load(file)
    verdicts = dict.fromkeys(model.systems[0].state_names, "observable")
    for claim in model.segments.claims:
        assert claim.everything is not None
        versions = list(_altered(claim, set(), verdicts))
        assert len(versions) == 2 + 2 * len(verdicts)
        found = _of_segments(model, [version for _, version in versions])
        assert [one.verdict for one in found] == ["fails"] * len(versions)


def _bent(quantity, state, factor):
    coefficients = {**quantity.coefficients, state: multiply(factor, quantity.coefficients[state])}
    return replace(quantity, coefficients=coefficients)


def _put(items, k, item):
    return (*items[:k], item, *items[k + 1 :])


def _bare(claim, rank=None):
    """A claim that says nothing, or a rank."""
    return replace(
        claim, rank=rank, basis=None, observable=(), unobservable=(), directions=(), states={},
        everything=None, measures=(), requirements={}, stationary=None,
    )  # fmt: skip


def _altered(claim, hidden, verdicts):
    """Yield false versions of a claim, each with one thing altered.

    ``hidden``: states that are not observable by themselves, ``verdicts`` those of the states, at the claim's values.
    """
    alone = _bare(claim)
    if claim.rank is not None:
        yield "rank + 1", replace(alone, rank=claim.rank + 1)
        yield "rank - 1", replace(alone, rank=claim.rank - 1)
    yield from _altered_basis(claim, alone, hidden)
    for k, q in enumerate(claim.observable):
        yield f"observable {k} claimed unobservable", replace(alone, unobservable=(q,))
        for state in _bendable(q, hidden):
            yield f"observable {k}, {state} bent", replace(alone, observable=(_bent(q, state, TWO),))
    for k, q in enumerate(claim.unobservable):
        yield f"unobservable {k} claimed observable", replace(alone, observable=(q,))
    for k, q in enumerate(claim.directions):
        bendable = [s for s in q.coefficients if len(q.coefficients) > 1 and verdicts[s] != "unobservable"]
        for state in bendable:
            yield f"direction {k}, {state} doubled", replace(alone, directions=(_bent(q, state, TWO),))
            yield f"direction {k}, {state} negated", replace(alone, directions=(_bent(q, state, number(-1)),))
        yield f"direction {k} empty", replace(alone, directions=(replace(q, coefficients={}),))
        for state in (s for s, v in verdicts.items() if v == "observable"):
            more = replace(q, coefficients={**q.coefficients, state: ONE})
            yield f"direction {k} with {state}", replace(alone, directions=(more,))
    everyone = {} if claim.everything is None else dict.fromkeys(verdicts, ("observable", claim.everything))
    for state, (verdict, place) in {**everyone, **claim.states}.items():
        for other in OTHERS[verdict]:
            yield f"{state} {other}", replace(alone, states={state: (other, place)})


def _bendable(quantity, hidden):
    """States of a combination that alone would not be observable: changing their coefficient breaks it."""
    return [s for s in quantity.coefficients if s in hidden]


def _altered_basis(claim, alone, hidden):
    basis = claim.basis or ()
    for k, q in enumerate(basis):
        yield f"row {k} left out", replace(alone, basis=(*basis[:k], *basis[k + 1 :]))
        yield f"row {k} zero", replace(alone, basis=_put(basis, k, replace(q, coefficients={})))
        if k:
            yield f"row {k} twice", replace(alone, basis=_put(basis, k, basis[k - 1]))
            both = {s: add(*(b.coefficients[s] for b in (q, basis[k - 1]) if s in b.coefficients))
                    for s in q.coefficients.keys() | basis[k - 1].coefficients.keys()}  # fmt: skip
            yield f"row {k} superfluous", replace(alone, basis=(*basis, replace(q, coefficients=both)))
        for state in _bendable(q, hidden):
            yield f"row {k}, {state} doubled", replace(alone, basis=_put(basis, k, _bent(q, state, TWO)))
            yield (
                f"row {k}, {state} negated",
                replace(alone, basis=_put(basis, k, _bent(q, state, number(-1)))),
            )
            rest = {s: e for s, e in q.coefficients.items() if s != state}
            yield (
                f"row {k} without {state}",
                replace(alone, basis=_put(basis, k, replace(q, coefficients=rest))),
            )
        for state in hidden - q.coefficients.keys():
            more = replace(q, coefficients={**q.coefficients, state: ONE})
            yield f"row {k} with {state}", replace(alone, basis=_put(basis, k, more))


def _analysis_at(system, claim):
    from obscli.model.specialise import Specialisation, at_nominal

    if claim.at is None:
        return analyze(system, FAST)
    special = at_nominal(system) if claim.at == "nominal" else Specialisation(system, claim.at)
    return analyze(special.system(), FAST)


@pytest.mark.parametrize("system", _systems())
def test_a_claim_altered_in_one_thing_fails(system):
    analysis = analyze(system, FAST)
    tried, passed = 0, []
    for number_, claim in enumerate(system.claims):
        if claim.measures or claim.stationary is not None:
            continue  # tests/measures/test_expected.py, tests/pipelines/test_stationary.py
        found = _analysis_at(system, claim)
        hidden = {s for s, v in found.states.items() if v != "observable"}
        versions = list(_altered(claim, hidden, found.states))
        assert versions, f"claim {number_} says nothing that could be false"
        tried += len(versions)
        # all versions of one claim in one go: one field, one analysis for its values
        for name, version in versions:
            if "fails" not in _verdicts(system, [version], analysis):
                passed.append((number_, name))
    assert tried
    assert not passed


def _states_of(model, claim, known):
    """The verdicts on the shared states by the runs of a claim, all where none is named."""
    names = tuple(name for name, _ in claim.runs)
    if names not in known:
        request = CalibrateRequest(names, critical=False, only="analytic")
        known[names] = calibrate(model, request=request).results[0].exact.stack.finding.states
    return known[names]


@pytest.mark.parametrize("file", EXPERIMENTS)
def test_a_claim_about_an_experiment_altered_in_one_thing_fails(file):
    model, known, versions = load(file), {}, []
    for k, claim in enumerate(model.claims):
        assert claim.at is None
        verdicts = _states_of(model, claim, known)
        hidden = {s for s, v in verdicts.items() if v != "observable"}
        own = [(k, name, version) for name, version in _altered(claim, hidden, verdicts)]
        assert own, f"claim {k} says nothing that could be false"
        versions += own
    found = _of_experiment(model, [version for _, _, version in versions])
    passed = [
        (k, name) for (k, name, _), result in zip(versions, found, strict=True) if result.verdict != "fails"
    ]
    assert passed == []


def _number_altered(text, start):
    """Yield the text with one rank under ``claims``/``expect`` altered, for each of them."""
    position = text.index("rank:", start) if "rank:" in text[start:] else -1
    while position >= 0:
        end = next((k for k in range(position + 6, len(text)) if not text[k].isdigit()), len(text))
        yield text[: position + 6] + str(int(text[position + 6 : end]) + 1) + text[end:]
        position = text.find("rank:", end)


def _start(text):
    """Where the claims begin."""
    return min(text.index(key) for key in ("\nclaims:", "\nexpect:") if key in text)


@cache
def _analyses(file):
    """The analyses of the unaltered file by stage: claims are no part of the system."""
    return {s.stage: analyze(s, FAST) for s in load(file).systems}


def _rank_changed(claims, before):
    return tuple(claim for claim, old in zip(claims, before, strict=True) if claim.rank != old.rank)


@pytest.mark.parametrize("file", FILES, ids=[f.stem for f in FILES])
def test_one_number_altered_in_the_file_makes_verification_fail(file):
    """Only the claims whose number is altered are checked: the others are as they were."""
    text, before, analyses = file.read_text(), load(file), _analyses(file)
    found, of_experiment = [], []
    for altered in _number_altered(text, _start(text)):
        model = read_text(altered, str(file))
        of_stages = []
        for system, old in zip(model.systems, before.systems, strict=True):
            changed = replace(system, claims=_rank_changed(system.claims, old.claims))
            of_stages += check_claims(changed, analyses[system.stage])
        together = _rank_changed(model.claims, before.claims)
        if model.segments:
            whole = _of_segments(model, _rank_changed(model.segments.claims, before.segments.claims))
            of_stages += [one for one in whole if one.claim.startswith("rank")]
        assert of_stages or together
        found += [of_stages] if of_stages else []
        of_experiment += [_bare(claim, rank=claim.rank) for claim in together]
    found += [[result] for result in _of_experiment(before, of_experiment)] if of_experiment else []
    assert found
    for results in found:
        broken = [r for r in results if r.verdict == "fails"]
        assert broken
        assert all(r.place.file == str(file) and r.place.line for r in broken)


# One term, sign or value altered by hand in each bundled file, under claims or expect.
CORRUPTED = {
    "two_axis_jumps": ("stands, rank: 6", "stands, rank: 7"),
    "two_axis_turns": ("inner_turns, rank: 12", "inner_turns, rank: 16"),
    "accelerometer": ("basis: [dv, g*alpha - da]", "basis: [dv, g*alpha + da]"),
    "gyro": ("directions: [{dv: -R, domega: 1}]", "directions: [{dv: R, domega: 1}]"),
    "observers": (
        "accelerometer_as_printed, rank: 0, detectable: false",
        "accelerometer_as_printed, rank: 0, detectable: true",
    ),
    "horizontal_channel": ("[{alpha: 1/g, da: 1}]", "[{alpha: 1/R, da: 1}]"),
    "equator": ("- b_g2 + omega*M_g21", "- b_g2 - omega*M_g21"),
    "horizontal": ("- b_g1 + omega*M_g12 - omega*M_a21", "- b_g1 - omega*M_a21"),
    "pole": ("rank: 15", "rank: 16"),
    "stage_1_sparse": ("omega_ie*sin(phi)/g*b_a1", "omega_ie*cos(phi)/g*b_a1"),
    "vertical": ("rank: 12", "rank: 13"),
    "modulus": ("M_a21, M_a22]", "M_a21, M_a33]"),
    "six_position": ("{M_a12: 1, M_a21: -1}", "{M_a12: 1, M_a21: 1}"),
    "table_errors": ("b_a1 - g*tau1", "b_a1 + g*tau1"),
    "table_plan": ("rank: 15", "rank: 16"),
    "twenty_four_positions": ("  - rank: 6", "  - rank: 7"),
    "two_axis_table": ("{b_a3: -g, M_a33: 1}", "{b_a3: g, M_a33: 1}"),
    "accelerometer_only": ("at: {alpha_w: 0}", "at: {alpha_w: 1}"),
    "gyro_only": ("dOm: observable", "dOm: coupled"),
    "single_channel": ("dOm: -alpha_omega/g", "dOm: alpha_omega/g"),
    "sixteen_states": ("dOm_y: 1", "dOm_y: -1"),
    "sixteen_states_case_1": ("with_heading, rank: 16", "with_heading, rank: 15"),
    "sixteen_states_case_2": ("velocity_position, rank: 16", "velocity_position, rank: 14"),
    "sixteen_states_case_3": ("dL3: observable", "dL3: coupled"),
    "three_states": ("basis: [alpha, V, R]", "basis: [alpha, V, V + 2*alpha]"),
    "flights_enu": ("yaw, rank: 15", "yaw, rank: 12"),
    "flights_quasi_body": ("pitch, rank: 15", "pitch, rank: 12"),
    "ins_gnss_enu": ("straight, rank: 15", "straight, rank: 12"),
    "ins_gnss_quasi_body": ("axes_held, rank: 15", "axes_held, rank: 12"),
    "attitude_quaternion": ("d2: -2*(q3*q4 - q1*q2)", "d2: -2*(q3*q4 + q1*q2)"),
    "cardioid": ("at: {phi: pi}", "at: {phi: pi/2}"),
    "sampled_double_integrator": ("directions: [{x: 1}]", "directions: [{v: 1}]"),
    "sampled_oscillator": ("directions: [{v: 1}]", "directions: [{p: 1}]"),
    "shift_register": ("directions: [{c2: 1}, {c3: 1}]", "directions: [{c2: 1}, {c1: 1}]"),
    "double_integrator": ("directions: [{x: 1}]", "directions: [{v: 1}]"),
    "frozen_observable": ("basis: [cos(omega*t)*x1 + sin", "basis: [cos(omega*t)*x1 - sin"),
    "frozen_unobservable": ("at: {omega: 0}", "at: {omega: 1e-9}"),
    "ins_velocity_aiding": ("b_E: omega_ie*cos(L)", "b_E: omega_ie*sin(L)"),
    "levelling": ("unobservable: [tilt, b_a]", "unobservable: [tilt, b_g]"),
    "mixed_coefficients": ("basis: [x1, x2, x3 - x4]", "basis: [x1, x2, x3 - 2*x4]"),
    "oscillator_frequency": ("at: {a: 0}", "at: {a: 1/10}"),
    "rotating_pair": ("basis: [x1]", "basis: [x2]"),
    "stationary_alignment": ("nabla_N: -g, eps_N", "nabla_N: g, eps_N"),
    "two_tones": ("at: {a: -b}", "at: {a: 2*b}"),
    "markus_yamabe": ("h1: unobservable", "h1: coupled"),
    "wu": ("h2: unobservable", "h2: observable"),
}


@pytest.mark.parametrize("file", FILES, ids=[f.stem for f in FILES])
def test_one_term_altered_in_the_file_makes_verification_fail(file):
    old, new = CORRUPTED[file.stem]
    text = file.read_text()
    where = text.index(old, _start(text))
    model = read_text(text[:where] + new + text[where + len(old) :], str(file))
    analyses = _analyses(file)
    results = [r for s in model.systems for r in check_claims(s, analyses[s.stage])]
    line = text.count("\n", 0, where) + 1
    last = [claim for claim in model.claims if claim.place.line <= line][-1:]  # the one altered, if any is
    results += _of_experiment(model, last) if last else []
    assert "fails" in [r.verdict for r in results]
    assert "holds" in [r.verdict for r in results]


# -- what a failing claim says


SHIFT = """\
parameters: {g: {value: 10, assume: positive}}
states: [v, tilt, b_a]
dynamics: {v: g*tilt + b_a}
measurements: {y: v}
claims:
"""


def _results(claims):
    system = read_text(SHIFT + claims, "shift.yaml").systems[0]
    return check_claims(system, analyze(system, FAST))


@pytest.mark.parametrize(
    ("claims", "reason"),
    [
        ("  - rank: 3\n", "the rank is 2"),
        ("  - basis: [v]\n", "1 forgotten"),
        ("  - basis: [v, g*tilt + b_a, 2*v]\n", "superfluous"),
        ("  - basis: [v, tilt]\n", "not observable"),
        ("  - basis: [v, g*tilt + b_a, tilt]\n", "tilt"),
        ("  - observable: [b_a]\n", "unobservable direction"),
        ("  - unobservable: [2*g*tilt + 2*b_a]\n", "it is an observable combination"),
        ("  - directions: [{tilt: 1, b_a: g}]\n", "observable combination"),
        ("  - directions: [{tilt: 0}]\n", "zero"),
        ("  - states: {tilt: observable}\n", "coupled"),
        ("  - at: {g: 1}\n    observable: [tilt - b_a]\n", "not observable"),
        ("  - at: nominal\n    observable: [9*tilt + b_a]\n", "not observable"),
    ],
)
def test_a_false_claim_fails_with_its_reason_and_place(claims, reason):
    results = _results(claims)
    assert [r.verdict for r in results] == ["fails"]
    assert reason in results[0].reason
    assert results[0].place.line >= 6


@pytest.mark.parametrize(
    "claims",
    [
        "  - rank: 2\n",
        "  - basis: [7*v, tilt + b_a/g]\n",
        "  - basis: [v + g*tilt + b_a, v]\n",
        "  - observable: [sin(t)*v, sqrt(g^2)*tilt + b_a]\n",
        "  - directions: [{tilt: t, b_a: -t*g}]\n",
        "  - unobservable: [tilt, b_a, g*tilt - b_a]\n",
        "  - at: nominal\n    observable: [10*tilt + b_a]\n",
        "  - at: {g: sqrt(2)}\n    observable: [2*tilt + sqrt(2)*b_a]\n    unobservable: [tilt]\n",
    ],
)
def test_a_true_claim_in_other_words_holds(claims):
    assert {r.verdict for r in _results(claims)} == {"holds"}


def test_a_claim_that_cannot_be_decided_is_neither_true_nor_false():
    results = _results("  - observable: [sqrt(t^2)*tilt]\n  - rank: 2\n")
    assert [r.verdict for r in results] == ["undecided", "holds"]
    assert "sign" in results[0].reason


def test_claims_at_values_where_the_system_does_not_exist_are_undecided():
    system = read_text(
        "parameters: {R: 1}\nstates: [x]\nA: [[1/R]]\nH: [[1]]\nclaims:\n  - at: {R: 0}\n    rank: 1\n",
        "nowhere.yaml",
    ).systems[0]
    results = check_claims(system, analyze(system, FAST))
    assert [r.verdict for r in results] == ["undecided"]
    assert results[0].reason


@pytest.mark.parametrize(
    ("rate", "word", "verdict", "reason"),
    [
        ("-1/tau", "true", "holds", "proved exactly: every hidden error dies out by itself"),
        (
            "-1/tau",
            "false",
            "fails",
            "every hidden error dies out by itself, the slowest with time constant 5",
        ),
        ("0", "true", "fails", "1 hidden direction stays as it is (eigenvalue 0), and no output shows it"),
        ("0", "false", "holds", "proved exactly: 1 hidden direction stays as it is"),
        ("a", "true", "fails", "1 hidden direction grows by itself (eigenvalue 1/1000)"),
        ("cos(t)*a*t", "true", "undecided", "depends on time"),
    ],
)
def test_detectable_says_that_what_is_hidden_dies_out(rate, word, verdict, reason):
    system = read_text(
        "parameters: {tau: {value: 5, assume: positive}, a: 0.001}\nstates: [x, h]\n"
        f"dynamics: {{x: -x, h: ({rate})*h}}\nmeasurements: {{y: x}}\nclaims: {{detectable: {word}}}\n",
        "hidden.yaml",
    ).systems[0]
    [result] = check_claims(system, analyze(system, FAST))
    assert (result.claim, result.verdict) == (
        "detectable" if word == "true" else "not detectable", verdict,
    )  # fmt: skip
    assert reason in result.reason


def test_detectability_is_claimed_where_the_claim_says():
    text = (
        "parameters: {p: -0.1, q: -0.1}\nstates: [x, a, b]\n"
        "dynamics: {x: a + b, a: p*a, b: q*b}\nmeasurements: {y: x}\nclaims:\n"
        "  - {detectable: true}\n  - {at: {q: p}, detectable: true}\n  - {at: {p: 0.2, q: 0.2}, detectable: true}\n"
    )
    system = read_text(text, "hidden.yaml").systems[0]
    assert [r.verdict for r in check_claims(system, analyze(system, FAST))] == ["holds", "holds", "fails"]


@pytest.mark.parametrize(("determined", "verdict"), [("[v]", "holds"), ("[tilt]", "fails"), ("all", "fails")])
def test_determined_says_that_states_are_observable(determined, verdict):
    results = _results(f"  - determined: {determined}\n")
    assert {r.claim for r in results} >= {f"{determined.strip('[]').replace('all', 'b_a')} is observable"}
    assert verdict in {r.verdict for r in results} <= {"holds", verdict}


def test_a_quantity_of_no_states_is_observable_and_never_a_row_of_a_basis():
    system = read_text(SHIFT + "  - rank: 2\n", "shift.yaml").systems[0]
    claim = system.claims[0]
    nothing = Quantity("nothing", {}, claim.place)
    assert _verdicts(system, [replace(claim, rank=None, observable=(nothing,))]) == ["holds"]
    assert _verdicts(system, [replace(claim, rank=None, basis=(nothing, nothing))]) == ["fails"]
