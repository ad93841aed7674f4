"""Advice states true things: measuring the free states completes the rank, one by one."""

from dataclasses import replace
from pathlib import Path

import pytest

from obscli.exact.analysis import Options, analyze
from obscli.model.expression import ONE
from obscli.model.reader import load
from obscli.model.system import Matrix, Output


MODELS = Path(__file__).parents[2] / "models"
FILES = [
    "bagmut/horizontal_channel.yaml",
    "ins_calibration/stage_1_sparse.yaml",
    "textbook/mixed_coefficients.yaml",
    "textbook/levelling.yaml",
]


@pytest.mark.parametrize("file", FILES)
@pytest.mark.parametrize("backwards", [False, True])
def test_measuring_the_free_states_makes_the_state_observable(file, backwards):
    for system in load(MODELS / file).systems:
        order = system.state_names[::-1] if backwards else ()
        options = Options(critical=False, certificate=False, pivot_order=order)
        found = analyze(system, options)

        assert len(found.free) == system.n - found.rank
        assert analyze(_measured(system, found.free), options).rank == system.n


def _measured(system, states):
    """The system with these states as further outputs."""
    index = {name: j for j, name in enumerate(system.state_names)}
    place = system.outputs[0].place
    entries = dict(system.H.entries) | {(system.m + k, index[s]): ONE for k, s in enumerate(states)}
    outputs = (*system.outputs, *(Output(f"extra_{s}", place) for s in states))
    return replace(system, outputs=outputs, H=Matrix(system.m + len(states), system.n, entries))
