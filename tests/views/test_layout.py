"""Tests of the layout: tables and lines fit the width of the terminal, and long lists are shortened."""

import pytest
from stiction.views.layout import (
    ShortenedList,
    Table,
    WrappedText,
    format_paragraph,
    format_paragraphs,
    format_table,
    wrap_text,
)


def test_table_wider_than_the_terminal_is_split_into_parts_with_fewer_columns():
    rows = [["name", "first column", "second column"], ["a", "1", "2"]]
    assert format_table(rows, 80).splitlines() == ["name  first column  second column", "a     1             2"]
    assert format_table(rows, 20).splitlines() == ["name  first column", "a     1", "name  second column", "a     2"]


def test_split_table_repeats_label_columns():
    rows = [["load", "μ0", "first column", "second column"], ["1 mN", "0.2", "1", "2"]]
    assert format_table(rows, 26, num_labels=2).splitlines() == [
        "load  μ0   first column", "1 mN  0.2  1", "load  μ0   second column", "1 mN  0.2  2",
    ]  # fmt: skip


def test_wrapped_text_keeps_each_number_and_its_unit_on_one_line():
    text = wrap_text("x" * 33 + " τ0 = 50 MPa and more words that fill the line up to its end", 40)
    assert "τ0 = 50 MPa" in text.splitlines()[1]


def test_formatted_paragraphs_are_separated_by_empty_lines(monkeypatch):
    monkeypatch.setenv("COLUMNS", "40")
    long_line = WrappedText("x" * 30 + " and more words", indent="  ", hanging_indent="    ")
    paragraphs = [["title", Table([["a", "1"], ["bc", "2"]])], [], ["", long_line]]
    assert format_paragraphs(paragraphs).splitlines() == [
        "title", "a   1", "bc  2", "", "  " + "x" * 30 + " and", "      more words"
    ]  # fmt: skip


def test_split_table_omits_rows_from_parts_in_which_these_rows_are_empty():
    rows = [["", "first", "second"], ["", "", "(unit)"], ["row", "1" * 12, "2" * 12]]
    assert format_table(rows, 20).splitlines() == [
        "     first", "row  " + "1" * 12, "     second", "     (unit)", "row  " + "2" * 12
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("min_shown", "max_shown", "max_height", "num_shown"),
    [(1, None, None, 4), (1, 3, None, 3), (1, None, 3, 2), (1, None, 1, 1), (2, None, 1, 2), (4, None, 0, 4)],
)
def test_shortened_list_states_the_number_of_omitted_lines(monkeypatch, min_shown, max_shown, max_height, num_shown):
    monkeypatch.setenv("COLUMNS", "40")
    lines = [WrappedText("- one"), WrappedText("- " + "two " * 15), WrappedText("- three"), WrappedText("- four")]
    text = format_paragraph([ShortenedList(lines, min_shown, max_shown, max_height, "line", "all()")])
    assert text.count("- ") == num_shown
    omission_line = f"  {4 - num_shown} more line{'s' * (num_shown < 3)}: all() shows all"
    assert text.splitlines()[-1] == omission_line if num_shown < 4 else "more" not in text
