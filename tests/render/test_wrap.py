"""Lines never exceed the width, lose nothing, and break formulas where a reader would."""

from hypothesis import example, given
from hypothesis import strategies as st

from obscli.core.document import Math, Text
from obscli.core.visible import visible
from obscli.render.columns import GAP, column_widths
from obscli.render.line import cell_width, line_text, line_width
from obscli.render.wrap import wrap


FORMULA = "omega_ie*cos(phi)*psi3 - b_g1 - omega_ie*sin(phi)/g*b_a1 - (omega + nu)*M_g11"


def lines(content, width, hang=2):
    return [line_text(line) for line in wrap(content, width, hang)]


def test_a_formula_that_fits_stays_whole():
    assert lines((Math("g*psi2 - b_a1", ""),), 40) == ["g*psi2 - b_a1"]


def test_a_formula_breaks_before_outer_signs_and_hangs():
    expected = [
        "omega_ie*cos(phi)*psi3 - b_g1",
        "  - omega_ie*sin(phi)/g*b_a1",
        "  - (omega + nu)*M_g11",
    ]

    assert lines((Math(FORMULA, ""),), 32) == expected


def test_a_term_too_long_breaks_inside():
    assert lines((Math("a*(bbbbbb + cccccc)*d", ""),), 14) == ["a*(bbbbbb", "  + cccccc)*d"]


def test_a_direction_breaks_after_commas():
    assert lines((Math("psi2: 1, b_a1: g, psi3: omega", ""),), 18) == ["psi2: 1, b_a1: g,", "  psi3: omega"]


def test_words_break_at_blanks_and_names_too_long_are_cut():
    assert lines((Text("a long "), Text("x" * 12, "name"), Text(" end")), 8, hang=0) == [
        "a long",
        "xxxxxxxx",
        "xxxx end",
    ]


def test_wide_characters_count_double():
    assert cell_width("状態") == 4
    assert lines((Text("状態状態状態"),), 8) == ["状態状態", "状態"]


@given(
    st.lists(st.one_of(st.builds(Text, st.text()), st.builds(Math, st.text(), st.just(""))), max_size=4),
    st.integers(4, 60),
)
def test_no_line_is_too_wide_and_nothing_is_lost(content, width):
    wrapped = wrap(tuple(content), width)

    assert all(line_width(line) <= width for line in wrapped)
    shown = "".join("".join(text for text, _ in line) for line in wrapped)
    assert "".join(shown.split()) == "".join("".join(visible(part.text) for part in content).split())


@example([(0, False), (69, True)], 70)
@given(st.lists(st.tuples(st.integers(0, 200), st.booleans()), min_size=1, max_size=8), st.integers(70, 200))
def test_columns_fit_where_they_can(columns, width):
    natural, breaks = [own for own, _ in columns], [free for _, free in columns]

    widths = column_widths(natural, breaks, width)

    assert all(0 <= own <= max(need, 1) for own, need in zip(widths, natural, strict=True))
    assert sum(widths) + GAP * (len(widths) - 1) <= width or sum(natural) > width
