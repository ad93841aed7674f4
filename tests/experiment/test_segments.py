"""Segments together: laws that hold for any of them, and ranks of random systems by matrix exponentials."""

from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest
from flint import arb, arb_mat
from scipy.linalg import expm

from obscli.checks.certified_segments import certified_segments
from obscli.checks.turned_between import turned_between
from obscli.exact.ball import precision
from obscli.exact.ball_transition import BallSegment, TooManyBallStepsError
from obscli.exact.finding import Analysis
from obscli.experiment.hidden_throughout import hidden_there, hidden_throughout
from obscli.experiment.outputs_from_start import outputs_from_start
from obscli.model.notation import covector_text
from obscli.model.reader import read_text
from obscli.numeric.errors import NotComputableError
from obscli.numeric.kalman import covariance_history
from obscli.numeric.linear_forms import forms_of
from obscli.numeric.mean_response import mean_response
from obscli.numeric.monte_carlo import monte_carlo
from obscli.numeric.recorded_errors import recorded_errors
from obscli.numeric.schedule import schedule_of
from obscli.numeric.segment_errors import segment_errors
from obscli.numeric.segment_filter import assumed_step_of, schedules_of, segment_history
from obscli.numeric.segment_gramian import pieces_of, segment_numeric
from obscli.numeric.settings import Settings
from obscli.pipelines.request import NumericRequest
from obscli.pipelines.segments import segments_result


def silent(_):
    pass


def result(text, **options):
    return segments_result(read_text(text, "m.yaml", **options), NumericRequest())


def matrix_text(matrix):
    return "[" + ", ".join("[" + ", ".join(str(v) for v in row) + "]" for row in matrix) + "]"


def piecewise(parts, jumps):
    """A model of constant segments (A, H, duration) with jump matrices between them."""
    n = len(parts[0][0])
    names = [f"x{i}" for i in range(1, n + 1)]
    lines = [f"states: [{', '.join(names)}]", "stages:"]
    lines += [f"  s{k}: {{A: {matrix_text(A)}, H: {matrix_text(H)}}}" for k, (A, H, _) in enumerate(parts)]
    lines.append("segments:")
    for k, (_, _, duration) in enumerate(parts):
        jump = ""
        if k < len(jumps) and jumps[k] is not None:
            rows = {
                name: " + ".join(f"({v})*{other}" for v, other in zip(row, names, strict=True))
                for name, row in zip(names, jumps[k], strict=True)
            }
            jump = ", jump: {" + ", ".join(f'{name}: "{row}"' for name, row in rows.items()) + "}"
        lines.append(f"  - {{stage: s{k}, duration: {duration}{jump}}}")
    return "\n".join(lines) + "\n"


def rows_by_exponentials(parts, jumps):
    """The total observability matrix: [H; HA; …] of every segment times the transitions before it."""
    carried, found = np.eye(len(parts[0][0])), []
    for k, (A, H, duration) in enumerate(parts):
        rate, power = np.array(A, float), np.eye(len(A))
        for _ in range(len(A)):
            found.append(np.array(H, float) @ power @ carried)
            power = power @ rate
        carried = expm(rate * float(duration)) @ carried
        if k < len(jumps) and jumps[k] is not None:
            carried = np.array(jumps[k], float) @ carried
    return np.vstack(found)


def random_segments(seed, n=5, count=3):
    """Sparse segments with hidden parts, as integers."""
    source = np.random.default_rng(seed)
    parts = []
    for _ in range(count):
        A = np.where(source.random((n, n)) < 0.25, source.integers(-2, 3, (n, n)), 0)
        H = np.zeros((1, n), int)
        H[0, source.integers(n)] = 1
        parts.append((A.tolist(), H.tolist(), Fraction(int(source.integers(1, 5)), 4)))
    jump = np.eye(n, dtype=int)
    jump[source.integers(n), source.integers(n)] += 1
    return parts, [jump.tolist(), None]


@pytest.mark.parametrize("seed", range(6))
def test_random_constant_segments_have_the_rank_of_the_total_observability_matrix(seed):
    parts, jumps = random_segments(seed)
    expected = np.linalg.matrix_rank(rows_by_exponentials(parts, jumps), tol=1e-8)
    found = result(piecewise(parts, jumps))
    assert found.least == found.seen == expected
    assert found.most >= expected
    assert found.rank in (expected, None)


@pytest.mark.parametrize("seed", range(2))
def test_the_kernel_at_the_end_is_that_of_the_rows_carried_there(seed):
    parts, jumps = random_segments(seed)
    model = read_text(piecewise(parts, jumps), "m.yaml")
    numeric, _, last = segment_numeric(model.segments, Settings())
    carried = np.eye(5)
    for k, (A, _, duration) in enumerate(parts):
        carried = expm(np.array(A, float) * float(duration)) @ carried
        carried = np.array(jumps[k], float) @ carried if k < len(jumps) and jumps[k] else carried
    rows = rows_by_exponentials(parts, jumps) @ np.linalg.inv(carried)
    spaces = numeric.spaces
    kernel = spaces.gramian.units[last[-1]][:, None] * spaces.kernel(int(last[-1]))
    size = np.abs(rows).max() * max(np.abs(kernel).max(initial=0), 1)
    np.testing.assert_allclose(rows @ kernel, 0, atol=1e-8 * size)


TURNING = """\
states: [a, b, c]
parameters: {w: 0.7}
dynamics: {a: cos(w*t)*c, b: sin(w*t)*a}
measurements: {y: a + t*b}
interval: {start: 1, stop: 4}
noise: {R: 1e-2, step: 0.25, Q: {a: 1e-3}, P0_std: {a: 1, b: 2, c: 3}}
"""
WHOLE = TURNING + "segments:\n  - {duration: 3}\n"
SPLIT = TURNING + "segments:\n  - {duration: 1}\n  - {duration: 0.5}\n  - {duration: 1.5}\n"
UNIT_JUMPS = SPLIT.replace("duration: 1}", "duration: 1, jump: {a: a, b: b}}")


@pytest.mark.parametrize("text", [SPLIT, UNIT_JUMPS])
def test_a_stage_split_in_segments_is_that_stage(text):
    whole, split = read_text(WHOLE, "m.yaml"), read_text(text, "m.yaml")
    one, _, end = segment_numeric(whole.segments, Settings(scaling="none"))
    other, _, ends = segment_numeric(split.segments, Settings(scaling="none"))
    first, second = (found.spaces.gramian.matrices[k] for found, k in ((one, end[-1]), (other, ends[-1])))
    np.testing.assert_allclose(first.T @ first, second.T @ second, rtol=1e-11)
    assert result(text).rank == result(WHOLE).rank == 3


@pytest.mark.parametrize("text", [SPLIT, UNIT_JUMPS])
def test_the_filter_over_segments_of_one_stage_is_the_filter_of_the_stage(text):
    model = read_text(text, "m.yaml")
    system = model.systems[0]
    expected = covariance_history(system, schedule_of(system, 1.0, 4.0), forms_of(system))
    pieces = pieces_of(model.segments)
    found = segment_history(pieces, schedules_of(pieces), forms_of(system))
    np.testing.assert_allclose(found.deviations[-1], expected.deviations[-1], rtol=1e-9)
    np.testing.assert_allclose(found.open_loop[-1], expected.open_loop[-1], rtol=1e-9)
    assert found.samples == expected.samples


def test_a_jump_moves_the_covariance():
    text = TURNING + 'segments:\n  - {duration: 1, jump: {c: "c + 2*a"}}\n  - {duration: 2}\n'
    pieces = pieces_of(read_text(text, "m.yaml").segments)
    np.testing.assert_array_equal(pieces[0].jump, [[1, 0, 0], [0, 1, 0], [2, 0, 1]])
    system = pieces[0].system
    found = segment_history(pieces, schedules_of(pieces), forms_of(system))
    at = np.flatnonzero(found.t == 2.0)
    assert len(at) == 2
    before, after = found.open_loop[at]
    assert after[:2] == pytest.approx(before[:2])
    assert after[2] > before[2]


@pytest.mark.parametrize("text", [SPLIT, UNIT_JUMPS])
def test_errors_over_segments_of_one_stage_are_those_of_the_stage(text):
    model = read_text(text, "m.yaml")
    system = model.systems[0]
    forms = forms_of(system)
    whole = recorded_errors(system, schedule_of(system, 1.0, 4.0), forms)
    pieces = pieces_of(model.segments)
    parts = segment_errors(pieces, schedules_of(pieces), forms)
    error = np.array([0.5, np.nan, -2.0])
    one, other = (mean_response(run, error) for run in (whole, parts))
    np.testing.assert_allclose(other.before, one.before)
    np.testing.assert_allclose(other.mean[-1], one.mean[-1], rtol=1e-8)
    found = monte_carlo(parts, 2000, 3)
    claimed = segment_history(pieces, schedules_of(pieces), forms)
    np.testing.assert_allclose(found.t, claimed.t)
    np.testing.assert_allclose(found.claimed, claimed.deviations, rtol=1e-9)
    assert (np.abs(found.rms / found.claimed - 1) < 5 / np.sqrt(4000)).all()
    assert 0.8 < found.nees.inside <= 1


JUMPING = """\
states: [x, v]
stages:
  a: {F: [[1, 1], [0, 1]], H: [[1, 0]]}
  b: {F: [[1, 0.5], [0, 0.9]], H: [[1, 1]]}
noise: {R: 1, P0_std: [1, 2], Q: [0.1, 0.2]}
segments: [{stage: a, duration: 4, jump: {v: v + 2*x}}, {stage: b, duration: 5}]
"""


def test_a_filter_in_discrete_time_over_segments_is_that_of_its_recursion():
    """The sample at the end of a segment is taken before the jump; the next step is by the next segment's F."""
    pieces = pieces_of(read_text(JUMPING, "m.yaml").segments)
    forms = forms_of(pieces[0].system)
    run = segment_errors(pieces, schedules_of(pieces), forms)
    response = mean_response(run, np.array([1.0, -1.0]))
    claimed = segment_history(pieces, schedules_of(pieces), forms)
    F = [np.array([[1, 1], [0, 1]]), np.array([[1, 0.5], [0, 0.9]])]
    H, J = [np.array([[1.0, 0]]), np.array([[1.0, 1]])], np.array([[1.0, 0], [2, 1]])
    P, e, expected = np.diag([1.0, 4.0]), np.array([1.0, -1.0]), []
    for k in range(10):
        part = 0 if k <= 4 else 1
        if k:
            P, e = F[part] @ P @ F[part].T + np.diag([0.1, 0.2]), F[part] @ e
        gain = P @ H[part].T / (H[part] @ P @ H[part].T + 1)
        P, e = P - gain @ H[part] @ P, e - (gain @ H[part] @ e)
        expected.append((k, np.sqrt(np.diag(P)), e))
        if k == 4:
            P, e = J @ P @ J.T, J @ e
            expected.append((k, np.sqrt(np.diag(P)), e))
    np.testing.assert_allclose(claimed.t, [k for k, _, _ in expected])
    np.testing.assert_allclose(claimed.deviations, [sigma for _, sigma, _ in expected], rtol=1e-10)
    np.testing.assert_allclose(response.mean, [error for _, _, error in expected], rtol=1e-10)


def test_the_gramian_in_discrete_time_is_that_of_the_outputs_so_far():
    """W(k) of x(k): rows H(j) Φ⁻¹(k, j) of all samples so far, one at an instant of a jump before it."""
    numeric, pieces, ends = segment_numeric(read_text(JUMPING, "m.yaml").segments, Settings(scaling="none"))
    F = [np.array([[1, 1], [0, 1]]), np.array([[1, 0.5], [0, 0.9]])]
    H, J = [np.array([[1.0, 0]]), np.array([[1.0, 1]])], np.array([[1.0, 0], [2, 1]])
    rows, expected = np.zeros((0, 2)), {}
    for k in range(10):
        part = 0 if k <= 4 else 1
        rows = np.concatenate([rows @ np.linalg.inv(F[part]), H[part]]) if k else H[0]
        expected[k] = rows.T @ rows
        if k == 4:
            rows = rows @ np.linalg.inv(J)
    gramian = numeric.spaces.gramian
    for k, root, units in zip(gramian.instants, gramian.matrices, gramian.units, strict=True):
        np.testing.assert_allclose((root / units).T @ (root / units), expected[int(k)], rtol=1e-12)
    assert [float(gramian.instants[k]) for k in ends] == [piece.stop for piece in pieces] == [4.0, 9.0]
    found = result(JUMPING)
    assert (found.rank, found.numeric.rank, found.numeric.points[-1].t) == (2, 2, 9.0)


def test_steps_of_segments_in_discrete_time_are_whole_and_can_be_undone():
    with pytest.raises(
        NotComputableError, match=r"the end of segment a is 3\.5: a discrete-time model counts"
    ):
        pieces_of(read_text(JUMPING.replace("duration: 4", "duration: 3.5"), "m.yaml").segments)
    singular = read_text(JUMPING.replace("[[1, 0.5], [0, 0.9]]", "[[1, k - 6], [0, k - 6]]"), "m.yaml")
    with pytest.raises(NotComputableError, match="F at step 6 cannot be undone"):
        segment_numeric(singular.segments, Settings())


def test_an_error_that_is_given_is_the_same_in_all_runs():
    """The mean of the runs is then the mean response, and what it leaves to chance is drawn as before."""
    pieces = pieces_of(read_text(JUMPING, "m.yaml").segments)
    run = segment_errors(pieces, schedules_of(pieces), forms_of(pieces[0].system))
    error = np.array([3.0, np.nan])
    found, mean = monte_carlo(run, 4000, 5, initial=error), mean_response(run, error)
    spread = np.sqrt(found.rms**2 - found.mean**2)
    assert found.inserted
    assert (np.abs(found.mean - mean.mean) < 5 * spread / np.sqrt(4000)).all()
    assert (spread <= found.claimed * (1 + 5 / np.sqrt(8000))).all()
    assert not monte_carlo(run, 5, 5).inserted


def test_a_step_is_assumed_only_where_the_segment_gives_none():
    """It is the same in all segments that give none, whichever comes first."""
    text = (
        "states: [x]\nA: [[0]]\nH: [[1]]\nstages:\n  dense: {noise: {R: 1, P0_std: 1}}\n"
        "  given: {noise: {R: 1, P0_std: 1, step: 0.5}}\nsegments: [{stage: %s, duration: 2}, {stage: %s, duration: 2}]\n"
    )
    for order in (("dense", "given"), ("given", "dense")):
        found = dict(
            zip(order, schedules_of(pieces_of(read_text(text % order, "m.yaml").segments)), strict=True)
        )
        assert found["dense"].assumed_step == pytest.approx(0.01)
        assert found["given"].assumed_step is None
        assert np.diff(found["dense"].t) == pytest.approx(0.01)
        assert np.diff(found["given"].t) == pytest.approx(0.5)
        assert assumed_step_of(tuple(found.values())) == pytest.approx(0.01)


RULER = """\
states: [p, v, b]
dynamics: {p: v, v: b}
stages:
  seen: {measurements: {y: p}}
  blind: {measurements: {y: v - v}}
segments:
  - {stage: seen, duration: 1}
"""


def test_order_matters():
    """Position, then velocity without a change of it: an offset of p is seen once, in the first segment."""
    text = """\
states: [p, q]
stages:
  moves: {dynamics: {p: q}, measurements: {y: 0*p}}
  looks: {dynamics: {p: 0*p}, measurements: {y: p}}
segments: [%s]
"""
    moves, looks = "{stage: moves, duration: 1}", "{stage: looks, duration: 1}"
    ranks = {
        (moves, looks): 1,  # p + q at the end of the motion
        (looks, moves): 1,
        (looks, moves, looks): 2,
    }
    for order, rank in ranks.items():
        found = result(text % ", ".join(order))
        assert (found.rank, found.seen) == (rank, rank)
    found = result(text % f"{moves}, {looks}")
    assert found.is_at_start
    assert [covector_text(one.coefficients, ("p", "q")) for one in found.proved.combinations] == ["p + q"]


def test_what_is_hidden_all_the_way_is_found_for_any_duration():
    text = """\
parameters: {w: 0.3, T: 2}
states: [a, b, c, d]
dynamics: {a: w*b, b: -w*a}
stages:
  one: {measurements: {y: a + cos(t)*(c + d)}}
  two: {measurements: {y: a - b}}
segments: [{stage: one, duration: T}, {stage: two, duration: 1}]
"""
    found = result(text)
    assert (found.rank, found.seen, found.is_generic) == (3, 3, True)
    assert [dict(one) for one in map(_numbers, found.proved.unobservable)] in (
        [{"c": 1, "d": -1}],
        [{"c": -1, "d": 1}],
    )
    assert found.proved.states == {"a": "observable", "b": "observable", "c": "coupled", "d": "coupled"}


def _numbers(covector):
    return {name: int(entry.value) for name, entry in covector.items()}


def test_a_value_that_hides_more_is_seen_at_the_values():
    text = """\
parameters: {k: 0}
states: [a, b]
dynamics: {a: cos(t)*a + k*b}
measurements: {y: a}
segments: [{duration: 1}, {duration: 1}]
"""
    found = result(text)
    assert (found.rank, found.seen, found.is_generic) == (1, 1, False)
    assert result(text.replace("k: 0", "k: 1")).is_generic


def test_a_parameter_with_two_values_is_two_symbols():
    """k is 1 and 2: two rates, so that both products are told apart."""
    text = """\
parameters: {k: 1}
states: [a, b]
dynamics: {}
stages:
  one: {measurements: {y: a + k*b}}
  two: {parameters: {k: 2}}
segments: [{stage: one, duration: k}, {stage: two, duration: k, %s}]
"""
    text = (
        text.replace("dynamics: {}", "A: [[0, 0], [0, 0]]")
        .replace("  one: {measurements: {y: a + k*b}}", "  one: {}")
        .replace("stages:", "measurements: {y: a + k*b}\nstages:")
    )
    found = result(text % "name: second")
    assert (found.rank, found.is_generic) == (2, True)
    assert [one.stop for one in found.ends] == [1.0, 3.0]


def test_undecided_is_never_called_proved():
    """A turn nobody sees, then one look: rank 1, but 2 would be seen for other durations or orders."""
    text = """\
states: [a, b]
stages:
  turns: {A: [[0, -1], [1, 0]], H: [[0, 0]]}
  looks: {A: [[0, 0], [0, 0]], H: [[1, 0]]}
segments: [{stage: turns, duration: 1}, {stage: looks, duration: 1}]
"""
    found = result(text)
    assert (found.rank, found.least, found.most, found.seen) == (None, 1, 2, 1)
    assert found.is_undecided
    assert not found.is_contradicted


def test_functions_left_open_are_not_certified():
    text = """\
functions: [f]
states: [a, b]
dynamics: {a: f*b}
measurements: {y: a}
segments: [{duration: 1}, {duration: 2}]
"""
    found = result(text)
    assert found.rank is None
    assert (found.least, found.most, found.seen) == (0, 2, 2)
    assert "f is left open, and a proof at the file's values needs an expression" in found.certified.reason


def test_a_jump_that_loses_a_state_is_refused_by_name():
    text = """\
states: [a, b]
A: [[0, 1], [0, 0]]
H: [[1, 0]]
segments: [{duration: 1, name: first, jump: {a: b}}, {duration: 1}]
"""
    with pytest.raises(NotComputableError, match="jump after segment first cannot be undone"):
        pieces_of(read_text(text, "m.yaml").segments)
    assert "cannot be undone" in result(text).numeric.reason


TABLE = """\
parameters: {a: 0, w: 0.1}
states: [tilt, bias, rest]
let: {R: rotz(a)}
dynamics: {tilt: "R[1,1]*bias"}
measurements: {y: "R[1,2]*tilt + rest"}
stages: {stands: {}, turns: {let: {R: rotz(a + w*t)}}}
segments:
"""
DWELL = "  - {stage: stands, duration: 1, fix: {a: 0}%s}\n  - {stage: stands, duration: 1, fix: {a: pi/2}}\n"


def test_orientation_that_turns_in_no_time_is_told():
    (turn,) = turned_between(read_text(TABLE + DWELL % "", "m.yaml").segments)
    assert (turn.name, turn.t) == ("R", 1.0)
    assert turn.degrees == pytest.approx(90)
    assert turn.moving == ("tilt",)


@pytest.mark.parametrize(
    "segments",
    [
        DWELL % ', jump: {tilt: "tilt + bias"}',
        DWELL.replace("pi/2", "2*pi") % "",
        "  - {stage: turns, duration: pi/2/w, fix: {a: 0}}\n  - {stage: stands, duration: 1, fix: {a: pi/2}}\n",
    ],
)
def test_orientation_that_is_carried_by_a_motion_is_not(segments):
    assert turned_between(read_text(TABLE + segments, "m.yaml").segments) == ()


def test_nothing_is_missed_where_nothing_moves():
    text = TABLE.replace('{tilt: "R[1,1]*bias"}', "{}") + DWELL % ""
    assert (
        turned_between(read_text(text.replace("dynamics: {}", "A: [[0,0,0],[0,0,0],[0,0,0]]"), "m").segments)
        == ()
    )


def test_ball_transitions_hold_the_true_ones():
    """x' = t x and x' = A x: e^((b² − a²)/2), and the matrix exponential of balls."""
    growing = read_text("states: [x]\nA: [[t]]\nH: [[1]]\n", "m.yaml").systems[0]
    A = [[0, 1, 0], [-2, 0, 1], [0, 0, 0]]
    constant = read_text(f"states: [x, v, u]\nA: {matrix_text(A)}\nH: [[1, 0, 0]]\n", "m.yaml").systems[0]
    with precision(128, 50):
        tolerance = arb(2) ** -96
        found = BallSegment(growing, 42).transition(arb(1), arb(3), tolerance)[0, 0]
        assert found.overlaps((arb(15) / 2).exp())
        assert found.rel_accuracy_bits() > 80
        ours = BallSegment(constant, 42).transition(arb(0), arb.pi(), tolerance)
        true = (arb_mat(A) * arb.pi()).exp()
        assert all(
            a.overlaps(b) and a.rad() < 1e-25 for a, b in zip(ours.entries(), true.entries(), strict=True)
        )


def test_a_pole_on_the_way_is_no_transition():
    system = read_text("states: [x]\nA: [[1/(t - 2)]]\nH: [[1]]\n", "m.yaml").systems[0]
    with precision(128, 50), pytest.raises(TooManyBallStepsError):
        BallSegment(system, 42).transition(arb(1), arb(3), arb(2) ** -96)


def test_bounds_are_ordered_whatever_the_segments():
    for seed in range(3):
        parts, jumps = random_segments(seed, n=4)
        model = read_text(piecewise(parts, jumps), "m.yaml")
        generic = hidden_throughout(model.segments, model.systems[0], silent)
        there = hidden_there(model.segments, model.systems[0], silent)
        assert isinstance(generic, Analysis)
        assert certified_segments(model.segments, 4).rank <= there.rank == generic.rank


def test_outputs_from_start_need_a_closed_form():
    closed = read_text(RULER, "m.yaml")
    found = outputs_from_start(closed.segments, closed.systems[0], silent)
    assert found.rank == 3
    waves = read_text(
        "states: [a, b]\nA: [[0, 1], [-1, 0]]\nH: [[1, 0]]\nsegments: [{duration: 1}]\n", "m.yaml"
    )
    assert outputs_from_start(waves.segments, waves.systems[0], silent) is None


def test_no_more_coefficients_are_taken_than_the_series_have():
    """A chain of 50 integrators: 42 terms at first, then enough of them; never more than there is to see."""
    names = [f"x{k}" for k in range(50)]
    rows = ", ".join(f"{a}: {b}" for a, b in pairwise(names))
    chain = f"states: [{', '.join(names)}]\ndynamics: {{{rows}}}\nmeasurements: {{y: x0}}\nsegments: [{{duration: 1}}]\n"
    segments = read_text(chain, "m.yaml").segments
    assert certified_segments(segments, 50, attempts=(128,)).rank == 42
    assert certified_segments(segments, 50).rank == 50
    blind = chain.replace("y: x0", "y: x20")
    assert certified_segments(read_text(blind, "m.yaml").segments, 50).rank == 30


def test_a_state_left_out_leaves_its_jump():
    text = TURNING + 'segments:\n  - {duration: 1, jump: {c: "c + 2*a", b: "b - c"}}\n  - {duration: 2}\n'
    segments = read_text(text, "m.yaml", without=["c"], outputs=["y"]).segments
    assert segments.parts[0].system.state_names == ("a", "b")
    np.testing.assert_array_equal(pieces_of(segments)[0].jump, np.eye(2))
