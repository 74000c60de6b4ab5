"""Second step of reading a text: the layout of an instrument, or else a table of any kind with words around it."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np

from stiction._text import printable
from stiction.surfaces.measured.decode import WORDS, Text, decode
from stiction.surfaces.measured.header import declared, heads_of, history_of
from stiction.surfaces.measured.layout import Layout
from stiction.surfaces.measured.raw import Channels, Content, FormatError, Raw, Source, Table
from stiction.surfaces.measured.shapes import counts_evenly
from stiction.surfaces.measured.split import Block, Dialect, cell_kind, dialect_of, numbers_of, runs_of

MAX_STEP, MAX_STEPS = 1000, 1000  # characters of a step of the history above the data, and steps of it
MAX_BELOW = 0.1  # lines with numbers below the data that are no data, as a fraction of the lines of data
MIN_BLOCK = 2  # rows of numbers above the data that are no size or count


def read_text(data: bytes, words: tuple[str, ...] = ()) -> Content:
    """Return the content of a text; words are further marks of missing points."""
    return content_of(decode(data, words))


def content_of(text: Text) -> Content:
    """Return the content of a text by the first layout that recognises it, or else as a table."""
    layout = layout_of(text)
    return table_of(text) if layout is None else with_source(layout.read(text), text, layout.name)


def layout_of(text: Text) -> Layout | None:
    """Return the layout of an instrument that recognises a text, or None."""
    from stiction.surfaces.measured.layouts import LAYOUTS

    return next((layout for layout in LAYOUTS if layout.recognise(text)), None)


def with_source(content: Content, text: Text, layout: str) -> Content:
    """Return content that knows its layout and its encoding."""
    if isinstance(content, Channels):
        read = content.read
        return replace(content, read=lambda at: with_source(read(at), text, layout))  # type: ignore[arg-type, return-value]
    return replace(content, source=replace(content.source, layout=layout, encoding=text.encoding))


def table_of(text: Text) -> Table | Channels:
    """Return the table in a text: its largest run of lines of numbers with the words above it, or several of them."""
    runs = runs_of(text)
    if not runs:
        raise FormatError(
            f"no numbers were found in {len(text)} lines, of which the first is {text.shown(0)}; numbers stand in "
            "columns, parted by tabs, semicolons, commas or blanks"
        )
    first, last = max(runs, key=lambda run: int(text.starts[run[1] + 1] - text.starts[run[0]]))
    dialect = dialect_of(text, first, last)
    labels = _with_label_row(text, first, last, dialect)
    if labels < first:  # the word in the corner is no number
        first, text = labels, replace(text, words=(*text.words, dialect.cells(text.line(labels))[0]))
    _refuse_unreadable(text, dialect, len(dialect.cells(text.line(last))), runs)
    block = numbers_of(text, first, last, dialect, ragged=True)
    if len(alike := _alike(text, runs, (first, last), dialect)) > 1:
        return _blocks(text, alike, dialect)
    end = int(block.lines[-1]) + 1
    below = int((text.kinds[end:] == 1).sum())
    if below > MAX_BELOW * block.lines.size + 2:
        place = end + int(np.argmax(text.kinds[end:] == 1))
        raise FormatError(
            f"{text.shown(place)} has numbers of another table than that of lines {first + 1} to {end}; "
            "leave one of them in the file"
        )
    return _table(text, block, 0)


def _table(text: Text, block: Block, begin: int) -> Table:
    """Return a block with the words above it, from a line on, and below it."""
    first, end = int(block.lines[0]), int(block.lines[-1]) + 1
    header, footer = text.lines(begin, first), text.lines(end, len(text)) if begin == 0 else []
    width = block.values.shape[1]
    heads = heads_of(header, width, block.dialect)
    facts = declared(text.lines(0, first) if begin else header, below=footer)
    if block.short is not None and not any(heads.names):
        raise FormatError(
            f"{text.shown(block.short)} has fewer cells than the lines above it, and columns have no names; "
            "all lines of a matrix need the same number"
        )
    return Table(
        block.values,
        names=heads.names,
        units=heads.units or (None,) * width,
        digits=block.digits,
        row_digits=block.row_digits,
        declared=facts if facts.unit is not None else replace(facts, unit=heads.height_unit),
        history=(
            *(printable(step, MAX_STEP) for step in history_of(header)[:MAX_STEPS]),
            *(f"{text.shown(at)} left out as a count or a size" for at in block.omitted[:MAX_STEPS]),
        ),
        source=source_of(block),
    )


def source_of(block: Block) -> Source:
    """Return where the rows of a block stand in its text."""
    text, first, end = block.text, int(block.lines[0]), int(block.lines[-1]) + 1
    point = "." if block.dialect.pairs else block.dialect.point
    return Source(
        encoding=text.encoding, separator=str(block.dialect), decimal_mark=point, lines=(first + 1, end),
        lines_above=len(text.lines(0, first)) if first < 10_000 else first,
        lines_below=int(np.count_nonzero(text.kinds[end:])),
    )  # fmt: skip


def _with_label_row(text: Text, first: int, last: int, dialect: Dialect) -> int:
    """Return the first line of a run, or that above it, which is a row of labels behind the word in its corner."""
    above = next((at for at in range(first - 1, -1, -1) if text.line(at).strip("\t")), -1)
    if above < 0 or dialect.separator is None:
        return first
    cells, below = dialect.cells(text.line(above)), dialect.cells(text.line(first))
    is_labels = len(cells) == len(below) and cell_kind(cells[0], dialect, text) is None and _are_labels(cells, dialect)
    return above if is_labels else first


def _refuse_unreadable(text: Text, dialect: Dialect, width: int, runs: list[tuple[int, int]]) -> None:
    """Refuse a line beside numbers that has as many cells as they, most of them numbers, and is no row of labels."""
    for at in sorted({at for first, last in runs for at in (first - 1, last + 1) if 0 <= at < len(text)}):
        if text.kinds[at] != WORDS or width == 1 or text.line(at).startswith(("#", "%", "!", "/")):
            continue
        cells = dialect.cells(text.line(at))
        kinds = [cell_kind(cell, dialect, text) for cell in cells]
        numbers = 2 * kinds.count("number") - (at < runs[0][0] and kinds[:1] == [None])  # a name and its value
        if len(cells) != width or numbers < width or None not in kinds or _are_labels(cells, dialect):
            continue
        _refuse_word(text, at, next(cell for cell, kind in zip(cells, kinds, strict=True) if kind is None))


def _refuse_word(text: Text, at: int, word: str) -> None:
    raise FormatError(
        f"{text.shown(at)} stands between numbers, and {word[:40]!r} is no number; "
        f"--missing-value {word[:40]} takes it for a missing point"
    )


def _are_labels(cells: list[str], dialect: Dialect) -> bool:
    """Return whether the cells behind the first are positions."""
    matches = [dialect.number.fullmatch(cell) for cell in cells[1:]]
    if len(cells) < 5 or not all(match and (match[2] or match[3]) for match in matches):
        return False
    labels = np.array([np.nan, *(float(cell.replace(dialect.point, ".")) for cell in cells[1:])])
    return counts_evenly(labels, 0.1 * abs(labels[2] - labels[1]))


def _alike(text: Text, runs: list[tuple[int, int]], main: tuple[int, int], dialect: Dialect) -> list[tuple[int, int]]:
    """Return the runs that are as wide as the largest; a line of one or two numbers above is a size or a count."""
    width = len(dialect.cells(text.line(main[0])))
    found: list[tuple[int, int]] = []
    for first, last in runs:
        as_wide = all(len(dialect.cells(text.line(at))) == width for at in (first, last))
        if (first, last) == main or (as_wide and (found or width > 2 or last - first + 1 >= MIN_BLOCK)):
            found.append((first, last))
    gaps = [(last + 1, first) for (_, last), (first, _) in itertools.pairwise(found)]
    if width == 1 and gaps and all(end - begin == 1 and len(text.line(begin).split()) == 1 for begin, end in gaps):
        _refuse_word(text, gaps[0][0], text.line(gaps[0][0]))
    return found


def _blocks(text: Text, runs: list[tuple[int, int]], dialect: Dialect) -> Channels:
    """Return blocks of as many columns, each below words of its own, as channels."""
    begins = [0, *(last + 1 for _, last in runs)]
    names = []
    for (first, last), begin in zip(runs, begins, strict=False):
        above = text.lines(begin, first)
        name = above[-1].lstrip("#%!/ \t") if above else ""
        names.append(printable(" ".join(name.split()) or f"lines {first + 1} to {last + 1}", 40))
    if len(set(names)) < len(names):
        names = [f"{name}, line {first + 1}" for name, (first, _) in zip(names, runs, strict=True)]

    def read(at: int) -> Raw | Table:
        table = _table(text, numbers_of(text, *runs[at], dialect, ragged=True), begins[at])
        return replace(table, source=replace(table.source, column=names[at]))

    return Channels(tuple(names), read, None)
