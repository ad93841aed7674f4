"""What is said of a periodic system, and written of it."""

import json
from pathlib import Path

import numpy as np
import pytest

from obscli.core.document import Note, Table, VerdictLine
from obscli.model.reader import load, read_text
from obscli.numeric.floquet import floquet
from obscli.pipelines.describe.floquet import floquet_blocks
from obscli.pipelines.floquet_data import floquet_data


MODELS = Path(__file__).parents[2] / "models"
HALF_AND_QUARTER = "[[0, -1/2, 0, 0], [1/2, 0, 0, 0], [0, 0, 0, -1/4], [0, 0, 1/4, 0]]"


@pytest.fixture
def wu():
    return floquet(load(MODELS / "textbook/wu.yaml").systems[0], 0.0, np.pi / 6, samples=4)


@pytest.fixture
def unresolved():
    text = f"states: [a, b, c, d]\nA: {HALF_AND_QUARTER}\nH: [[1, 0, 1, 0]]\n"
    return floquet(read_text(text, "test.yaml").systems[0], 0.0, 2 * np.pi, samples=4)


def test_the_reduction_is_said_with_its_figures(wu):
    multipliers, verdict, equivalent = floquet_blocks(wu)
    expected = [f"{sign}{np.exp(-k * np.pi / 6):.6g}" for sign, k in [("", 1), ("-", 1), ("-", 10)]]
    assert [row[0][0][0].text for row in multipliers.rows] == expected
    assert verdict.kind == "good"
    said = verdict.content[0].text
    assert (
        "P(t) of period 1.0472 (two periods of A: a multiplier is on the negative real axis, or near)" in said
    )
    assert "z' = R z; residual over the next period" in said
    # entries that are only rounding are 0
    assert [cell[0][0].text for cell in equivalent.rows[0]] == ["z_x'", "-1", "0", "0"]


def test_where_there_is_no_equivalent_the_reason_is_said_and_written(unresolved):
    [multipliers, verdict] = floquet_blocks(unresolved)
    assert isinstance(multipliers, Table)
    assert isinstance(verdict, VerdictLine)
    assert verdict.kind == "open"
    data = floquet_data(unresolved)
    assert data["equivalent"] is None
    assert data["reason"] in verdict.content[0].text
    assert len(data["modes"]) == 4


def test_a_large_equivalent_is_left_to_the_data():
    A = [[-1.0 - (i == 0) if i == j else 0 for j in range(9)] for i in range(9)]
    text = f"states: {{x: 9}}\nA: {A}\nH: [[1, 1, 1, 1, 1, 1, 1, 1, 1]]\n"
    found = floquet(read_text(text, "test.yaml").systems[0], 0.0, 1.0, samples=2)
    assert isinstance([*floquet_blocks(found)][-1], Note)


def test_the_data_are_json_and_all_of_it(wu):
    data = json.loads(json.dumps(floquet_data(wu), allow_nan=False))
    equivalent = data["equivalent"]
    np.testing.assert_array_equal(equivalent["R"], wu.equivalent.R)
    np.testing.assert_array_equal(equivalent["P"], wu.equivalent.P)
    assert np.shape(equivalent["HP"]) == (9, 1, 3)
    assert [complex(*one["multiplier"]) for one in data["modes"]] == list(wu.multipliers)
    assert data["reason"] == ""
