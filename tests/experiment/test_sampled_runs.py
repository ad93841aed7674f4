"""Runs whose outputs are sampled each at its own rate, and runs with outages."""

import numpy as np
import pytest


RUNS = """\
parameters: {{w: 0.1, f_s: 4}}
states: [b, c, x]
dynamics: {{x: b}}
measurements: {{y: x + c*sin(w*t), z: c}}
outputs: {outputs}
noise: {{R: {{y: {y}, z: {z}}}, P0_std: 1{step}}}
interval: {{start: 0, stop: 40}}
stages: {{slow: {{}}, fast: {{parameters: {{w: 0.3, f_s: 8}}}}}}
experiment: {{runs: [slow, fast]}}
"""


def runs(outputs="{}", y=2, z=3, step=""):
    return RUNS.format(outputs=outputs, y=y, z=z, step=step)


def information(found):
    return [one.roots[-1].T @ one.roots[-1] for one in found.runs]


def test_a_run_with_its_own_rate_tells_what_the_density_tells(told):
    """y every 1/4 s in one run and 1/8 s in the other, z every 5 s: the densities R·every."""
    sampled = told(runs("{y: {every: 1/f_s}, z: {every: 5}}"))
    for k, y in enumerate((2 / 4, 2 / 8)):
        dense = told(runs(y=y, z=15))
        np.testing.assert_allclose(information(sampled)[k], information(dense)[k], rtol=1e-12)


def test_a_rate_common_to_all_outputs_is_the_step(told):
    one, other = told(runs("{y: {every: 0.5}, z: {every: 0.5}}")), told(runs(step=", step: 0.5"))
    for mine, his in zip(one.runs, other.runs, strict=True):
        np.testing.assert_array_equal(mine.elapsed, his.elapsed)
        np.testing.assert_allclose(mine.roots, his.roots, rtol=1e-12)


@pytest.mark.parametrize(
    ("outputs", "first"),
    [
        ("{y: {every: 5}, z: {every: 3}}", 3),
        ("{y: {every: 5}}", 0),  # z is measured all the time
        ("{y: {every: 50}, z: {every: 60}}", 40),  # the end, before which nothing is known
    ],
)
def test_nothing_is_known_before_the_first_sample(told, outputs, first):
    for one in told(runs(outputs)).runs:
        assert one.elapsed[0] >= first
        assert one.elapsed[0] <= first + 1
        assert one.elapsed[-1] == 40


def test_outages_are_refused_with_the_name_of_the_run(calibrated):
    found = calibrated(runs("{z: {during: [[0, 10], [20, 40]]}}"))
    assert found.no_accuracy == (
        "run slow: outages of z (`during`) are not taken into account here: "
        "obscli simulate takes samples as they come; else delete the key"
    )
    assert found.accuracy is None
    assert found.together is not None  # what algebra and the Gramians say does not know of outages
