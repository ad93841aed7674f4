"""Noise in a log looks like motion: what is told apart, and what is left of the rank.

Straight level flight with position fixes, attitude errors and a lever arm: H Φ has rank 8 of 12 in truth. Noise
of the accelerometers turns f and shows heading (9), noise of the attitude shows the lever arm as well (12).
"""

from dataclasses import replace

import numpy as np
import pytest

from obscli.model.reader import load
from obscli.numeric.analysis import analyze
from obscli.numeric.errors import NotComputableError
from obscli.numeric.excitation import Pair, deviations_of, excitation
from obscli.numeric.horizon import Wanted
from obscli.numeric.numeric_system import NumericSystem
from obscli.numeric.scaling import scaled
from obscli.numeric.settings import Effort, Settings
from obscli.numeric.signal_noise import noisier
from obscli.numeric.square_root import square_root_gramian
from obscli.numeric.subspace import subspaces


LEVEL = """\
states: {phi: {components: [E, N, U]}, dv: {components: [E, N, U]}, dp: {components: [E, N, U]}, l: 3}
signals:
  file: flight.csv
  time: t
  columns: {f: [fE, fN, fU], roll: roll, pitch: pitch, yaw: yaw}
let: {C: rotz(yaw) @ rotx(pitch) @ roty(roll)}
dynamics: {phi: [0, 0, 0], dv: "cross(f, phi)", dp: dv}
measurements: {y: dp + C @ l}
"""
TRUTH = ("dp_E", "dp_N", "dp_U", "l1", "l2", "l3")


@pytest.fixture
def flight(tmp_path):
    """Return the system on a record of 60 s with noise of some size, told (or not) to the model."""

    def build(force=0.0, attitude=0.0, told=None, motion=lambda t: np.zeros((len(t), 6)), seed=3):
        t, rng = np.arange(0, 60.01, 0.4), np.random.default_rng(seed)
        record = np.tile([0, 0, 9.81, 0.02, 0.05, 0.7], (len(t), 1)) + motion(t)
        record += np.repeat([force, attitude], 3) * rng.standard_normal((len(t), 6))
        header = "t,fE,fN,fU,roll,pitch,yaw"
        np.savetxt(
            tmp_path / "flight.csv",
            np.column_stack([t, record]),
            delimiter=",",
            header=header,
            comments="",
            fmt="%.15g",
        )
        noise = (
            ""
            if told is None
            else "noise: {{signals: {{f: {0}, roll: {1}, pitch: {1}, yaw: {1}}}}}\n".format(*told)
        )
        (tmp_path / "m.yaml").write_text(LEVEL + noise)
        return analyze(load(tmp_path / "m.yaml").systems[0], Settings(Wanted(samples=3)))

    return build


@pytest.mark.parametrize(("force", "attitude", "shown"), [(0.0, 0.0, 8), (0.05, 0.0, 9), (0.05, 2e-4, 12)])
def test_level_flight_excites_eight_directions(flight, force, attitude, shown):
    numeric = flight(force, attitude, told=(0.05, 2e-4))
    assert numeric.rank == shown
    found = excitation(numeric)
    assert (found.excited, found.calm, len(found.ratios)) == (8, 8, shown)
    assert set(found.not_excited) == {"phi_U", *TRUTH}


@pytest.mark.parametrize("seed", [*range(6), 39])
def test_the_verdict_does_not_hang_on_the_draw(flight, seed):
    found = excitation(flight(0.05, 2e-4, told=(0.05, 2e-4), seed=10 + seed))
    assert found.excited == 8
    assert set(found.not_excited) == {"phi_U", *TRUTH}


@pytest.mark.parametrize(("seed", "clear"), [(8, 9), (3, 8)])
def test_noise_that_is_not_white_is_no_motion_either(flight, seed, clear):
    """A slow drift of the size stated for noise may stand far above white noise; a calm flight explains it."""

    def drifting(t):
        drift = np.cumsum(np.random.default_rng(seed).standard_normal((len(t), 3)), axis=0)
        return np.hstack([0.05 * (drift - drift.mean(axis=0)) / drift.std(axis=0), np.zeros((len(t), 3))])

    found = excitation(flight(told=(0.05, 2e-4), motion=drifting))
    assert (found.clear, found.calm, found.excited) == (clear, 8, 8)
    assert set(found.not_excited) == {"phi_U", *TRUTH}
    assert excitation(flight(told=(0.005, 2e-4), motion=drifting)).excited == 9


STILL = """\
states: {phi: {components: [N, E, D]}, dv: {components: [N, E, D]}, b_g: {components: [x, y, z]}}
signals: {file: still.csv, time: t, columns: {f: [f1, f2, f3], roll: r1, pitch: r2, yaw: r3}}
let: {C: rotz(yaw) @ roty(pitch) @ rotx(roll)}
dynamics: {phi: -C @ b_g, dv: "cross(C @ f, phi)"}
measurements: {v: dv}
noise: {signals: {f: 0.03, roll: 2e-4, pitch: 2e-4, yaw: 4e-4}}
"""


@pytest.mark.parametrize("noisy", [False, True])
def test_what_is_measured_is_excited_whatever_noise_would_hide(tmp_path, noisy):
    """Standing still heading is hidden; noise may hide more, but never the velocity that is measured."""
    t, rng = np.arange(0, 30.01, 0.1), np.random.default_rng(2)
    still = np.tile([0, 0, -9.81, 0.01, 0.02, 1], (len(t), 1))
    still += noisy * np.repeat([0.03, 2e-4], 3) * rng.standard_normal((len(t), 6))
    header = "t,f1,f2,f3,r1,r2,r3"
    np.savetxt(
        tmp_path / "still.csv",
        np.column_stack([t, still]),
        delimiter=",",
        header=header,
        comments="",
        fmt="%.15g",
    )
    (tmp_path / "m.yaml").write_text(STILL)
    found = excitation(analyze(load(tmp_path / "m.yaml").systems[0], Settings(Wanted(samples=3))))
    assert "phi_D" in found.not_excited
    assert not {"dv_N", "dv_E", "dv_D"} & set(found.not_excited)


BESIDE = """\
states: [z, c1, c2, a, b]
signals: {file: two.csv, time: t, interpolation: linear, columns: {f1: f1, f2: f2}}
dynamics: {z: c2 + b*f2}
measurements: {y: c1 + a*f1, w: z}
"""


@pytest.mark.parametrize(
    ("noise", "excited", "hidden"),
    [
        ("{f1: 0.05}", 4, {"c1", "a"}),
        ("{f2: 0.05}", 4, {"c2", "b"}),
        ("{f1: 0.05, f2: 0.05}", 3, {"c1", "c2", "a", "b"}),
    ],
)
def test_what_either_noise_hides_stays_hidden_beside_the_other(tmp_path, noise, excited, hidden):
    """White noise would show f1 as well; the wave of f2 is integrated, and a calm record explains it."""
    t, rng = np.arange(400) * 0.05, np.random.default_rng(5)
    f1 = 2 + 0.1 * np.sin(0.5 * t) + 0.05 * rng.standard_normal(400)
    rows = np.column_stack([t, f1, 3 + 0.065 * np.sin(0.5 * t)])
    np.savetxt(tmp_path / "two.csv", rows, delimiter=",", header="t,f1,f2", comments="", fmt="%.15g")
    (tmp_path / "m.yaml").write_text(f"{BESIDE}noise: {{signals: {noise}}}\n")
    found = excitation(analyze(load(tmp_path / "m.yaml").systems[0], Settings(Wanted(samples=3))))
    assert (found.excited, set(found.not_excited)) == (excited, hidden)


def test_without_a_stated_noise_nothing_is_tested(flight):
    numeric = flight(0.05)
    assert numeric.rank == 9
    assert excitation(numeric) is None


def test_motion_well_above_noise_counts(flight):
    """Horizontal acceleration shows heading: 9 directions; turns show the lever arm as well."""

    def accelerating(t):
        found = np.zeros((len(t), 6))
        found[:, 0] = 2 * np.sin(t / 5)
        return found

    def turning(t):
        found = accelerating(t)
        found[:, 3:] = 0.5 * np.sin(np.outer(t, [0.2, 0.3, 0.1]))
        return found

    told = (0.05, 2e-4)
    found = excitation(flight(*told, told, accelerating))
    assert (found.excited, set(found.not_excited)) == (9, set(TRUTH))
    found = excitation(flight(*told, told, turning))
    assert (found.excited, found.not_excited) == (12, ())


def test_less_noise_than_there_is_hides_nothing(flight):
    """The test knows what the file says: noise ten times what it states counts as motion."""
    assert excitation(flight(0.5, told=(0.05, 0))).excited == 9


def test_only_samples_of_the_window_are_counted(flight, monkeypatch):
    """Windows are shorter than the interval where that would take too many steps."""
    whole = flight(0.05, told=(0.05, 2e-4))
    instant = np.array([60.0])
    found = square_root_gramian(whole.system, 50.0, instant, whole.rates, Effort(1e-14, 20_000))
    late = replace(whole, spaces=subspaces(scaled(found, whole.system.system, whole.scaling)))
    late = replace(late, horizon=replace(whole.horizon, instants=instant))
    monkeypatch.setattr("obscli.numeric.excitation._MOST_SAMPLES", 30)
    assert excitation(late) is not None
    with pytest.raises(NotComputableError, match="149 instants with samples, 30 at the most"):
        excitation(whole)


def test_the_pair_is_two_systems_side_by_side(flight):
    numeric = flight(0.05, 2e-4, told=(0.05, 2e-4))
    one, n = numeric.system, numeric.system.n
    other = NumericSystem(one.system, 0, 60, noisier(deviations_of(one.system), 1))
    instant = np.array([60.0])
    effort = numeric.settings.step_error

    def gram(system):
        found = square_root_gramian(system, 0.0, instant, numeric.rates, Effort(effort, 20_000))
        root = found.matrices[0] / found.units[0]
        return root.T @ root

    both, mine, theirs = gram(Pair(one, other)), gram(one), gram(other)
    assert np.allclose(both[:n, :n], mine, rtol=1e-9, atol=1e-9 * mine.max())
    assert np.allclose(both[n:, n:], theirs, rtol=1e-9, atol=1e-9 * theirs.max())
    assert not np.allclose(mine, theirs, rtol=1e-9)
