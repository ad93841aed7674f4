"""What would unfold without end is refused by construction: counted, not timed."""

import pytest

from obscli.core.place import ModelError
from obscli.model.reader import read_text


def model(let="", A="0", head=""):
    return f"{head}states: [x]\nparameters: {{p: 1}}\nlet:\n  a0: p + t\n{let}A: [['{A}']]\nH: [[1]]\n"


def chain(rule, count):
    return "".join(f"  a{k}: {rule.format(f'a{k - 1}')}\n" for k in range(1, count))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (model(chain("sin({0}) + {0}", 300)), "over 200 deep"),
        (model(chain("sin({0}) + {0}^2", 300)), "powers beyond 10000"),
        (model(A="(1 + t)^6000*(2 + t)^6000"), "powers beyond 10000"),
        (model("  b: 3\n" + "".join(f"  b{k}: {'b' if k == 1 else f'b{k - 1}'}^64\n" for k in range(1, 9))), "digits"),
        (model(A="t+" * 200_000 + "1"), "characters"),
        (model(A="(" * 3000), "nested over 100 deep"),
        (model(A="-" * 3000 + "1"), "nested over 100 deep"),
        (model(A="2^" * 3000 + "1"), "nested over 100 deep"),
        (model(A="deriv(" * 90 + "sin(t)*cos(t)*exp(sin(t))" + ")" * 90), "derive fewer times"),
        (model(A="(eye(500) @ eye(500))[1,1]"), "operations to expand"),
        (model(A="zeros(1000, 1000)[1,1]"), "too large"),
        (model(A="eye(10^9)[1,1]"), "whole numbers"),
        ("[" * 100_000, "nested over 100 deep"),
        ("{a: " * 100_000, "nested over 100 deep"),
        ("- " * 100_000, "nested over 100 deep"),
        ("a: [" + "x, " * 200_000 + "]", "over 100,000 values"),
        ("".join(f"k{k}: 1\n" for k in range(60_000)), "over 100,000 values"),
        ("".join(f"k{k}: 1\n" for k in range(5_000)), "reading stops here"),
        ("states: {x: 4000}\ndynamics: {x: 2*x" + "+x" * 1000 + "}\nmeasurements: {y: x}", "operations"),
        ("states: {x: 100000000000000000000}", "whole number"),
        ("states: {M: [5000, 5000]}", "over 5000 scalars"),
        (f"states: [x]\nA: [[{'1' * 100_000}]]\nH: [[1]]", "characters"),
    ],
)  # fmt: skip
def test_refused(text, message):
    with pytest.raises(ModelError, match=message) as caught:
        read_text(text, "bomb.yaml")
    assert len(str(caught.value)) < 100_000


@pytest.mark.parametrize("lets", [0, 2000])
def test_too_many_stages(lets):
    stages = "".join(f"  s{k}: {{fix: {{p: {k}}}}}\n" for k in range(499 if lets else 600))
    text = model("".join(f"  b{k}: t\n" for k in range(lets))) + "stages:\n" + stages
    with pytest.raises(ModelError, match="operations to expand" if lets else "at most 500 are read"):
        read_text(text, "stages.yaml")


def test_doubling_is_shared():
    """A name used twice at every step costs one node a step."""
    system = read_text(model(chain("{0} + {0}", 100), A="a99"), "doubling.yaml").systems[0]
    assert number_shared(system.A.entries[0, 0], {"p": 1.0, "t": 1.0}) == 2.0**100


def number_shared(root, values):
    from obscli.model.expression import Number, Product, Sum, Symbol, postorder

    found = {}
    for node in postorder(root):
        match node:
            case Number(value):
                found[id(node)] = float(value)
            case Symbol(name):
                found[id(node)] = values[name]
            case Sum(terms):
                found[id(node)] = sum(found[id(term)] for term in terms)
            case Product(factors):
                result = 1.0
                for factor in factors:
                    result *= found[id(factor)]
                found[id(node)] = result
    return found[id(root)]


def test_aliases_within_the_limit(dense):
    text = "states: [x, y]\nA: [&r [0, 1], *r]\nH: [*r]\n"
    system = read_text(text, "alias.yaml").systems[0]
    assert dense(system.A, {}) == [[0, 1], [0, 1]]
    assert dense(system.H, {}) == [[0, 1]]


def test_a_hundred_sections_of_stages():
    stages = "".join(f"  s{k}: {{fix: {{p: {k}}}}}\n" for k in range(100))
    assert len(read_text(model(A="p") + "stages:\n" + stages, "stages.yaml").systems) == 101
