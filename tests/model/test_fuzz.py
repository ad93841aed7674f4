"""Whatever the bytes and whatever the tree, the reader answers with a model or with the model error."""

import string

import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from obscli.core.place import ModelError
from obscli.model.reader import KEYS, load, read_text
from obscli.model.sections import STAGE_KEYS


WORDS = st.sampled_from(
    [*KEYS, *STAGE_KEYS, "x", "y", "psi", "psi1", "g", "f", "t", "value", "shape", "structure", "lower", "components",
     "derivative", "invariant", "rank", "basis", "directions", "nominal", "Q", "R", "P0", "file", "scale", "latex",
     "<<", "~", "null", "-1", "0", "1", "3", "2*x", "sin(t)", "deriv(f)", "x + g", "[1, 2]", "psi @ psi", "1/0", "t^t",
     "runs", "stage", "grid", "repeat", "constant", "fresh", "candidates", "forbidden", "setup_time",
     "P0_std", "cross(psi, psi)", "(", "a(b", "quat_matrix(f)", "block([[1, x], [2, 3]])", "norm(psi)", "psi[2]", "eye(3)"]
)  # fmt: skip
TEXTS = WORDS | st.text(max_size=12) | st.text(alphabet="xtg123+-*/^@()[],. ", max_size=20)
TREES = st.recursive(
    TEXTS,
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(TEXTS, inner, max_size=5),
    max_leaves=25,
)
FILES = st.fixed_dictionaries(
    {"states": TREES},
    optional={key: TREES for key in (*KEYS, "signals", "linearize", "F", "segments") if key != "states"},
)
SOUND = {"states": {"psi": "3", "x": "1"}, "parameters": {"g": "9.8"}, "functions": ["f"], "dynamics": {"x": "g*psi1"},
         "measurements": {"y": "psi"}}  # fmt: skip


def answers(read, *arguments, **options):
    """Whether the reader gave a model, or a model error that says something."""
    try:
        return bool(read(*arguments, **options).systems)
    except ModelError as error:
        return bool(error.problems) and bool(str(error))


@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.binary(max_size=400))
def test_random_bytes(tmp_path, data):
    path = tmp_path / "fuzz.yaml"
    path.write_bytes(data)
    assert answers(load, path)


@settings(max_examples=150, deadline=None)
@given(text=st.text(alphabet=string.printable + "é𝜔\u202e\x85\ud800", max_size=300))
def test_random_text(text):
    assert answers(read_text, text, "fuzz.yaml")


@settings(max_examples=150, deadline=None)
@given(tree=FILES)
def test_random_trees(tree):
    assert answers(read_text, yaml.safe_dump(tree, allow_unicode=True), "fuzz.yaml")


@settings(max_examples=150, deadline=None)
@given(tree=FILES)
def test_random_sections_in_a_sound_file(tree):
    assert answers(
        read_text, yaml.safe_dump({**tree, **SOUND}, allow_unicode=True, default_flow_style=None), "fuzz.yaml"
    )


@settings(max_examples=100, deadline=None)
@given(key=st.sampled_from(KEYS), tree=TREES)
def test_one_random_section(key, tree):
    assert answers(read_text, yaml.safe_dump({**SOUND, key: tree}, allow_unicode=True), "fuzz.yaml")


@settings(max_examples=100, deadline=None)
@given(name=TEXTS, text=TEXTS)
def test_random_options(name, text):
    sound = yaml.safe_dump(SOUND)
    for options in (
        {"fix": {name: text}},
        {"settings": {name: text}},
        {"outputs": [name]},
        {"without": [text]},
    ):
        assert answers(read_text, sound, "fuzz.yaml", **options)
