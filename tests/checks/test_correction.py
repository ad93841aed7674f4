"""The printed correction put into the claim makes it true; no smaller change does; equal ones are all listed.

The smallest changes are found here by brute force: for every set of states, whether a change on it alone can
annihilate the directions that were built into the system, in floating point at one point.
"""

import math
import random
from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest

from obscli.checks.claims import check_claims
from obscli.core.place import Place
from obscli.exact.analysis import Options, analyze, contained
from obscli.model.covector import parse_covector
from obscli.model.expression import add
from obscli.model.notation import to_text
from obscli.model.reader import read_text
from obscli.model.system import Claim


HERE = Place("here", 1, 1)
FAST = Options(critical=False, certificate=False)
#: the point at which ``known.float_directions`` evaluates
POINT = {
    "w": 0.7310585, "v": 1.1234, "t": 0.4142135, "pi": math.pi,
    "sin": math.sin, "cos": math.cos, "exp": math.exp, "sqrt": math.sqrt,
}  # fmt: skip
COEFFICIENTS = ("1", "-2", "3/2", "t", "w", "cos(w*t)")
TILT = """\
parameters: {g: 9.81, w: 1/2}
states: [tilt, bias, drift, scale, heading]
dynamics: {tilt: drift + w*scale}
measurements: {y: g*tilt - bias}
claims:
  - observable: """


def _claimed(system, analysis, text):
    claim = Claim("claims", HERE, observable=(parse_covector(system, text, "claim"),))
    [result] = check_claims(replace(system, claims=(claim,)), analysis)
    return result


def _numbers(covector, names):
    values = dict(POINT)
    return np.array([float(eval(to_text(covector[s]), values)) if s in covector else 0.0 for s in names])


def _supports(row, directions, count):
    """Yield the sets of ``count`` states on which some change, nonzero in each, makes a row observable.

    The row must not be cancelled altogether: what it turns into is no combination then.
    """
    wanted = -directions @ row
    for support in combinations(range(len(row)), count):
        columns = directions[:, support]
        change, _, rank, _ = np.linalg.lstsq(columns, wanted, rcond=1e-10)
        fits = np.abs(columns @ change - wanted).max() < 1e-9
        if not fits or np.abs(change).min() < 1e-9:
            continue
        left = row.copy()
        left[list(support)] += change
        if rank == count and np.abs(left).max() > 1e-9:
            yield support


def _smallest(row, directions):
    """Return the supports of the smallest changes that bring in the fewest new states, none above three."""
    for count in (1, 2, 3):
        found = list(_supports(row, directions, count))
        if found:
            new = [sum(abs(row[j]) < 1e-12 for j in support) for support in found]
            return {support for support, more in zip(found, new, strict=True) if more == min(new)}
    return set()


def _claims(known, seed):
    """Yield a random system with hidden directions, those, and false claims about it."""
    built = known.build(seed, breakable=False)
    if not built.hidden:
        return
    system = read_text(built.text, "known.yaml").systems[0]
    analysis = analyze(system, FAST)
    directions = np.array(known.float_directions(built))
    source = random.Random(seed)
    for _ in range(4):
        states = source.sample(system.state_names, source.randint(1, min(4, system.n)))
        text = " + ".join(f"{source.choice(COEFFICIENTS)}*{s}" for s in states)
        row = parse_covector(system, text, "claim").coefficients
        if not contained(analysis, [row])[0]:
            yield system, analysis, directions, text, _numbers(row, system.state_names)


@pytest.mark.parametrize("seed", range(60))
def test_the_corrections_are_the_smallest_changes_and_all_of_them(known, seed):
    for system, analysis, directions, text, row in _claims(known, seed):
        listed = _claimed(system, analysis, text).corrections
        supports = [_support(system, one.change) for one in listed]
        assert len(set(supports)) == len(supports)
        assert set(supports) == _smallest(row, directions), text


def _support(system, change):
    names = system.state_names
    return tuple(sorted(names.index(s) for s in parse_covector(system, change, "change").coefficients))


@pytest.mark.parametrize("seed", range(60))
def test_the_corrected_claim_holds_and_is_the_claim_changed(known, seed):
    for system, analysis, _, text, row in _claims(known, seed):
        for one in _claimed(system, analysis, text).corrections:
            assert one.of == text
            corrected = _claimed(system, analysis, one.corrected)
            assert (corrected.verdict, corrected.corrections) == ("holds", ())
            parts = [
                parse_covector(system, part, "part").coefficients for part in (one.change, one.corrected)
            ]
            change, whole = (_numbers(part, system.state_names) for part in parts)
            assert np.allclose(row + change, whole, rtol=1e-12, atol=1e-12)


def test_of_the_random_claims_many_are_corrected_in_every_way(known):
    """The laws above are not empty: one, two and three changes, ties, and none."""
    counts, ties = set(), 0
    for seed in range(60):
        for _, _, directions, _, row in _claims(known, seed):
            found = _smallest(row, directions)
            counts.add(len(next(iter(found))) if found else 0)
            ties += len(found) > 1
    assert counts >= {0, 1, 2}
    assert ties > 10


@pytest.mark.parametrize(
    ("claim", "corrections"),
    [
        ("drift", [("drift + w*scale", "lacks + w*scale")]),
        ("scale", [("1/w*drift + scale", "lacks + 1/w*drift")]),
        ("g*tilt", [("g*tilt - bias", "lacks - bias")]),
        (
            "g*tilt + bias",
            [
                ("-g*tilt + bias", "has g where tilt needs -g"),
                ("g*tilt - bias", "has 1 where bias needs -1"),
            ],
        ),
        (
            "drift - w*scale",
            [
                ("-drift - w*scale", "has 1 where drift needs -1"),
                ("drift + w*scale", "has -w where scale needs w"),
            ],
        ),
        ("drift + w*scale + heading", [("drift + w*scale", "has a term in heading too much")]),
        ("drift + w*scale - 2*t*bias", [("drift + w*scale", "has a term in bias too much")]),
        ("drift + heading", [("drift + w*scale", "lacks + w*scale and has a term in heading too much")]),
    ],
)
def test_what_is_said_of_a_wrong_coefficient(checked, claim, corrections):
    [result] = checked(TILT + f"[{claim}]\n", gramian=False)

    assert [(one.corrected, one.words) for one in result.corrections] == corrections


def test_fewest_new_states_before_any(checked):
    """One change suffices either way: a term written there comes before a state brought in."""
    [result] = checked(TILT + "[drift + w*scale - bias]\n", gramian=False)

    assert [one.corrected for one in result.corrections] == ["drift + w*scale"]


def test_each_wrong_row_of_a_basis_has_its_own_corrections(checked):
    text = TILT.replace("observable", "basis") + "[g*tilt + bias, drift + 2*w*scale]\n"
    [result] = checked(text, gramian=False)

    assert [(one.of, one.corrected) for one in result.corrections] == [
        ("g*tilt + bias", "-g*tilt + bias"),
        ("g*tilt + bias", "g*tilt - bias"),
        ("drift + 2*w*scale", "2*drift + 2*w*scale"),
        ("drift + 2*w*scale", "drift + w*scale"),
    ]


def test_a_claim_at_values_is_corrected_with_these_values(checked):
    text = TILT.replace("- observable", "- at: {w: 3}\n    observable")
    [result] = checked(text + "[drift + 2*scale]\n", gramian=False)

    assert {one.corrected for one in result.corrections} == {"drift + 3*scale", "2/3*drift + 2*scale"}


def test_four_wrong_coefficients_are_too_many(checked):
    """Each of four pairs lacks its partner: no change of three coefficients can do."""
    states = ", ".join(f"a{k}, b{k}" for k in range(4))
    text = (
        f"states: [{states}]\nA: zeros(8, 8)\nH: ["
        + ", ".join("[" + ", ".join("1" if j // 2 == k else "0" for j in range(8)) + "]" for k in range(4))
        + "]\nclaims:\n  - observable: ["
    )
    [four] = checked(text + " + ".join(f"a{k}" for k in range(4)) + "]\n", gramian=False)
    [three] = checked(text + " + ".join(f"a{k}" for k in range(3)) + "]\n", gramian=False)

    assert (four.verdict, four.corrections) == ("fails", ())
    assert {one.corrected for one in three.corrections} == {"a0 + b0", "a1 + b1", "a2 + b2"}


@pytest.mark.parametrize("claim", ["heading", "2*heading"])
def test_changes_that_the_other_coefficients_do_not_determine_are_no_corrections(checked, claim):
    """From heading to a (g*tilt - bias), or to a (drift + w*scale), it takes three coefficients, for any a."""
    [result] = checked(TILT + f"[{claim}]\n", gramian=False)

    assert result.verdict == "fails"
    assert not result.corrections


def test_rows_may_be_added_to_a_correction(known):
    """What is observable stays observable: a claim plus a proved row has corrections as small."""
    for seed in (2, 5, 7):
        for system, analysis, directions, text, row in _claims(known, seed):
            least = _smallest(row, directions)
            if not least:
                continue
            proved = analysis.combinations[0].coefficients
            claimed = parse_covector(system, text, "claim")
            names = {*claimed.coefficients, *proved}
            both = {s: add(*(c[s] for c in (claimed.coefficients, proved) if s in c)) for s in names}
            one = Claim("claims", HERE, observable=(replace(claimed, coefficients=both),))
            [result] = check_claims(replace(system, claims=(one,)), analysis)
            assert result.verdict == "fails"
            sizes = {len(_support(system, change.change)) for change in result.corrections}
            assert not sizes or max(sizes) <= len(next(iter(least)))
