"""The bundled calibrations: what their descriptions say of rank, accuracy and plans."""

import re
from itertools import pairwise
from pathlib import Path

import pytest


MODELS = Path(__file__).parents[2] / "models"
FILES = sorted((MODELS / "calibration").glob("*.yaml"))


@pytest.mark.parametrize("file", FILES, ids=[file.stem for file in FILES])
def test_every_bundled_calibration_meets_what_it_requires(calibrated, model, file):
    found = calibrated(model(file.read_text(encoding="utf-8")))

    assert found.accuracy is not None, found.no_accuracy
    assert found.accuracy.required
    assert (found.failed, found.undecided) == (0, 0)
    assert {one.verdict for one in found.verifications} == {"verified"}
    for one, values in zip(found.accuracy.states, found.accuracy.history.values, strict=True):
        for earlier, later in pairwise(values):  # what was learned is not forgotten, and noise is not learned
            assert later <= earlier * (1 + 1e-9), one.name


def determined_only(name):
    """A bundled model without noise and requirements: which runs to make for the rank alone."""
    parts = re.split(
        r"^(?=\w+:)", (MODELS / "calibration" / name).read_text(encoding="utf-8"), flags=re.MULTILINE
    )
    left_out = ("noise", "require", "claims", "expect")
    return "".join(part for part in parts if part.split(":")[0] not in left_out)


@pytest.mark.parametrize(
    ("name", "candidates", "size", "count"),
    [("table_plan.yaml", 24, 3, 1168), ("two_axis_table.yaml", 12, 2, 20)],
)
def test_the_smallest_sets_are_as_many_as_the_file_says(planned, name, candidates, size, count):
    found = planned(determined_only(name))

    assert len(found.plan.runs) + len(found.plan.left_out) == candidates
    assert (found.plan.found.rank, found.plan.found.size) == (21, size)
    assert (len(found.plan.found.sets), found.plan.found.exhaustive) == (count, True)
    assert found.verification.verdict == "verified"
