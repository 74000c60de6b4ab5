"""First step of reading a text: its bytes as UTF-8, whatever the encoding, and the kind of each of its lines."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from stiction.surfaces.measured.raw import FormatError

MAX_LINES, MAX_CELLS = 25_000_000, 4_000_000
"""Lines of a text, and cells of a line."""

HEAD, HEAD_WIDTH = 200, 1000  # lines by which layouts are recognised, and characters of each
_SHOWN = 60  # characters of a line in a message

BLANK, NUMBERS, WORDS = 0, 1, 2
"""Kinds of lines: NUMBERS has digits or marks of missing points, and nothing that is no part of a number."""

_EIGHT_BIT = ("cp1252", "cp932", "gb18030", "euc-kr", "cp437", "latin-1")
"""Encodings of texts that are no UTF-8 and have no byte order mark, the likeliest first; the last cannot fail."""

_KNOWN = re.compile(
    "[µμ]m|[㎛㎚㎜]|単位|高さ|横|縦|位置|データ|幅|单位|高度|水平|垂直|校准|높이|단위|너비|\\bHöhe\\b|\\bÅ\\b|°"
)
"""Words by which the encoding of a text is known."""

MISSING_WORDS = (
    "nan", "-nan", "n/a", "#n/a", "#wert!", "#value!", "null", "none", "bad", "no data", "nodata", "invalid", "void",
    "inf", "-inf", "+inf", "infinity", "-infinity", "1.#qnan", "-1.#ind", "1.#inf", "-1.#inf", "nan(ind)", "-nan(ind)",
)  # fmt: skip
"""Words for missing points, in any case; so are empty cells, stars and two dashes or more."""


PARTS_OF_NUMBERS = b"0123456789+-.,;|*eE\"' \t\r\n"
_DIGIT, _MARK, _OTHER, _CONTROL = 1, 2, 4, 8
_BITS = np.full(256, _OTHER, np.uint8)
_BITS[list(PARTS_OF_NUMBERS)] = 0
_BITS[list(b"+-.*eE'")] = _MARK
_BITS[list(b"0123456789")] = _DIGIT
_BITS[[*range(9), *range(14, 32)]] = _CONTROL


_TABLE = _BITS.tobytes()


@dataclass(frozen=True)
class Text:
    """A text as UTF-8 with a line feed at the end of each line, minus signs in ASCII, and no thousands spaces."""

    data: bytes
    encoding: str
    words: tuple[str, ...] = ()  # further words for missing points

    @cached_property
    def starts(self) -> NDArray[np.int64]:
        """Offsets of all lines, and that behind the last."""
        ends = np.flatnonzero(np.frombuffer(self.data, np.uint8) == ord("\n"))
        return np.concatenate([[0], ends + 1])

    def has_words(self, lines: NDArray[np.int64]) -> bool:
        """Return whether lines have more than numbers, as words for missing points."""
        return bool((self.bits[lines] & _OTHER).any())

    def __len__(self) -> int:
        return self.starts.size - 1

    def raw(self, at: int) -> bytes:
        """Return a line, from 0 on, without its end."""
        return self.data[self.starts[at] : self.starts[at + 1] - 1]

    def line(self, at: int) -> str:
        """Return a line, from 0 on, without its end and blanks around it."""
        return self.raw(at).decode("utf-8", "replace").strip(" \r")

    def lines(self, first: int, end: int) -> list[str]:
        """Return the lines of a range that are not empty."""
        return [text for at in range(first, end) if (text := self.line(at)).strip("\t")]

    def shown(self, at: int) -> str:
        """Return the number and the beginning of a line, from 0 on, for a message."""
        text = " ".join(self.line(at).split())
        return f"line {at + 1} ({text if len(text) <= _SHOWN else text[:_SHOWN] + '...'!r})"

    @cached_property
    def head(self) -> tuple[str, ...]:
        """The first lines that are not empty."""
        lines = (
            self.data[start : start + HEAD_WIDTH].partition(b"\n")[0] for start in self.starts[:-1][:HEAD].tolist()
        )
        texts = (line.decode("utf-8", "replace").strip(" \r") for line in lines)
        return tuple(text for text in texts if text.strip("\t"))

    @cached_property
    def missing(self) -> re.Pattern[bytes]:
        """Pattern of words for missing points that stand as whole cells."""
        words = sorted({*MISSING_WORDS, *(word.casefold() for word in self.words)}, key=len, reverse=True)
        any_word = "|".join(re.escape(word).replace("\\ ", "[ _]?") for word in words)
        return re.compile(rf'(?i)(?<![^\s;,|"])(?:{any_word})(?![^\s;,|"])'.encode())

    @cached_property
    def bits(self) -> NDArray[np.uint8]:
        """Kinds of the characters of each line."""
        return np.bitwise_or.reduceat(np.frombuffer(self.data.translate(_TABLE), np.uint8), self.starts[:-1])

    @cached_property
    def kinds(self) -> NDArray[np.uint8]:
        """The kind of each line."""
        found = self.bits
        kinds = np.full(found.size, NUMBERS, np.uint8)
        kinds[found & (_DIGIT | _OTHER | _MARK) == 0] = BLANK
        kinds[(found & _DIGIT == 0) & (found & _MARK != 0)] = WORDS
        for at in np.flatnonzero(found & _OTHER).tolist():
            rest, marks = self.missing.subn(b"", self.raw(at))
            is_row = marks and not rest.translate(None, PARTS_OF_NUMBERS)
            kinds[at] = NUMBERS if is_row else WORDS
        # Rows of nothing but stars or dashes are rows where they stand between rows; else they are rules.
        filled = np.flatnonzero(kinds != BLANK)
        between = np.flatnonzero((kinds[filled][1:-1] == WORDS) & (found[filled][1:-1] & (_OTHER | _DIGIT) == 0)) + 1
        for place in between.tolist():
            if kinds[filled[place - 1]] == NUMBERS == kinds[filled[place + 1]]:
                kinds[filled[place]] = NUMBERS
        return kinds


def is_text(data: bytes) -> bool:
    """Return whether the beginning of a file is that of a text, in any encoding."""
    start = data[:4096]
    if start.startswith((b"\xff\xfe", b"\xfe\xff")) or _wide(start):
        return True
    return not start.translate(None, bytes(sorted({*range(256)} - {*range(9), *range(14, 26), *range(27, 32)})))


def decode(data: bytes, words: tuple[str, ...] = ()) -> Text:
    """Return the text of the bytes of a file; a `FormatError` if it is binary or empty."""
    encoding, text = _decoded(data)
    text = text.rstrip(b"\x1a")  # with which DOS ends a text
    if not text or text.isspace():
        raise FormatError("holds nothing but blanks")
    if b"\r" in text:
        text = text.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    if not text.isascii():
        for minus in ("\u2212", "\uff0d", "\ufe63"):
            text = text.replace(minus.encode(), b"-")
        space = b"(?:\xc2\xa0|\xe2\x80\xaf|\xe2\x80\x89)"  # hard, narrow and thin
        text = re.sub(rb"(?<=[0-9])" + space + rb"(?=[0-9]{3}(?![0-9]))", b"", text)
        text = re.sub(space, b" ", text)
    text = text if text.endswith(b"\n") else text + b"\n"
    decoded = Text(text, encoding, words)
    if len(decoded) > MAX_LINES:
        raise FormatError(f"has {len(decoded)} lines; at most {MAX_LINES} can be read as text: save it as .npy")
    if (control := int(np.count_nonzero(decoded.bits & _CONTROL))) > 0:
        raise FormatError(f"is binary, not text (control characters in {control} lines)")
    return decoded


def _decoded(data: bytes) -> tuple[str, bytes]:
    """Return the name of an encoding, and the text as UTF-8."""
    for mark, encoding in ((b"\xef\xbb\xbf", "utf-8-sig"), (b"\xff\xfe", "utf-16"), (b"\xfe\xff", "utf-16")):
        if data.startswith(mark):
            return encoding.removesuffix("-sig"), data.decode(encoding, "replace").encode()
    if (wide := _wide(data[:4096])) is not None:
        return wide, data.decode(wide, "replace").encode()
    if data.isascii():
        return "ascii", data
    try:
        data.decode("utf-8")
    except UnicodeDecodeError:
        pass
    else:
        return "utf-8", data
    start = data[:100_000]
    start = start[: start.rfind(b"\n") + 1] or start  # so that no character is cut
    known = []
    for encoding in _EIGHT_BIT:
        try:
            text = start.decode(encoding)
        except UnicodeDecodeError:
            continue
        known.append((len(_KNOWN.findall(text)), encoding))
    encoding = max(known, key=lambda each: each[0])[1]
    try:
        return encoding, data.decode(encoding).encode()
    except UnicodeDecodeError:
        return "latin-1", data.decode("latin-1").encode()


def _wide(start: bytes) -> str | None:
    """Return the encoding of two bytes a character of which every second is zero, as in UTF-16 without its mark."""
    half = len(start) // 2
    if half < 4:
        return None
    even, odd = start[::2].count(0), start[1::2].count(0)
    if odd > 0.6 * half and even < 0.05 * half:
        return "utf-16-le"
    return "utf-16-be" if even > 0.6 * half and odd < 0.05 * half else None
