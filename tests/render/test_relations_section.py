"""The method of unobservable states in a report: for those who ask for details, in every format."""

import json

import pytest

from obscli.core.document import Details, Document
from obscli.exact.prove import prove
from obscli.exact.relations import relations_of
from obscli.model.reader import read_text
from obscli.pipelines.describe.relations import relation_blocks
from obscli.pipelines.relations_data import relations_data
from obscli.render import html, latex, markdown, terminal
from obscli.render.format import Surface


TEXTS = {
    "oscillator": "parameters: {g: 9.8, R: 6378137}\nstates: [dv, alpha, da]\nA: [[0, -g, 1], [1/R, 0, 0], [0, 0, 0]]\nH: [[1, 0, 0]]\n",
    "canonical": "states: [a, b, c]\nA: [[0, 1, 0], [0, 0, 1], [-2, -2, -2]]\nH: [[1, 0, 0]]\n",
    "in time": "states: [x1, x2]\nA: [[0, -1], [0, 0]]\nH: [[1, t]]\n",
}


class Shown:
    """A report that consists of some blocks."""

    failed = undecided = 0

    def __init__(self, blocks):
        self._blocks = blocks

    def document(self):
        return Document(tuple(self._blocks))

    def figures(self):
        return ()

    def data(self):
        return {}


def shown(name):
    system = read_text(TEXTS[name], "test.yaml").systems[0]
    relations = relations_of(prove(system, range(system.n)))
    return system, relations, tuple(relation_blocks(relations, system))


@pytest.mark.parametrize("name", TEXTS)
@pytest.mark.parametrize("form", [html, latex, markdown, terminal])
def test_every_format_shows_them_where_details_are_asked_for(name, form):
    _, _, blocks = shown(name)
    assert all(isinstance(block, Details) for block in blocks)
    assert "unobservable states" in form.render(Shown(blocks), Surface(details=True))


@pytest.mark.parametrize(
    ("name", "words"),
    [
        (
            "oscillator",
            ["sin(sqrt(g/R)*t)/sqrt(g/R)", "g*alpha - da", "tied to others by relations  2  alpha da"],
        ),
        (
            "canonical",
            ["phi_0, phi_1, phi_2: the solutions of q(d/dt) f = 0, q(s) = 2 + s**3 + 2*s**2 + 2*s"],
        ),
        (
            "in time",
            [
                "x0 the state at t = 0",
                "certain at generic instants only",
                "the situation of x1, x2 is another",
            ],
        ),
    ],
)
def test_a_reader_is_told_functions_situations_and_limits(name, words):
    _, _, blocks = shown(name)
    text = " ".join(terminal.render(Shown(blocks), Surface(details=True, width=200)).split())
    for one in words:
        assert " ".join(one.split()) in text


@pytest.mark.parametrize("name", TEXTS)
def test_the_data_hold_every_relation(name):
    system, relations, _ = shown(name)
    data = json.loads(json.dumps(relations_data(relations, system)))
    assert len(data["relations"]) == len(relations.relations)
    assert data["situations"] == relations.situations
    assert all(one["coefficients"] and one["function"] for one in data["relations"])
