"""The terminal report, word for word, at two widths; the other formats once.

After an intended change: ``OBSCLI_WRITE_GOLDEN=1 pytest tests/render/test_golden.py``, then read the diff.
"""

import os
from pathlib import Path

import pytest

from obscli.render.format import Surface
from obscli.render.formats import format_named


GOLDEN = Path(__file__).with_name("golden")


@pytest.mark.parametrize(
    ("name", "form", "surface"),
    [
        ("terminal_80.txt", "terminal", Surface(width=80, details=True)),
        ("terminal_120.txt", "terminal", Surface(width=120)),
        ("report.md", "markdown", Surface(details=True)),
        ("report.tex", "latex", Surface(details=True)),
        ("report.html", "html", Surface(details=True)),
        ("report.json", "json", Surface()),
    ],
)
def test_report_is_as_agreed(report, name, form, surface):
    text = format_named(form).render(report, surface)
    if os.environ.get("OBSCLI_WRITE_GOLDEN"):
        (GOLDEN / name).write_text(text, encoding="utf-8")

    expected = (GOLDEN / name).read_text(encoding="utf-8")

    assert text == expected


@pytest.mark.parametrize("kind", ["compared", "checked"])
@pytest.mark.parametrize(
    ("suffix", "form", "surface"),
    [
        ("80.txt", "terminal", Surface(width=80, details=True)),
        ("120.txt", "terminal", Surface(width=120)),
        ("md", "markdown", Surface(details=True)),
        ("tex", "latex", Surface(details=True)),
        ("html", "html", Surface(details=True)),
        ("json", "json", Surface()),
    ],
)
def test_the_two_sides_compared_are_as_agreed(request, kind, suffix, form, surface):
    test_report_is_as_agreed(request.getfixturevalue(kind), f"{kind}.{suffix}", form, surface)
