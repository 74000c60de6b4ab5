"""How results show themselves: a few lines in a terminal, and a picture or a table in a notebook."""

from __future__ import annotations

import base64
import html
import io
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

DPI = 110  # dots to an inch of a picture in a notebook
SIZE = (4.6, 3.2)  # width and height of a picture in a notebook, inches
SMALL = 4.0  # width of a figure below which a picture has more dots, inches
COMPRESSION = 4  # level of PNG: half of the time of 6, the usual, for a tenth more bytes of maps

_PREFIXES = {"µm": (1e-3, "nm"), "GPa": (1e-3, "MPa"), "mN": (1e-3, "µN")}
"""The next smaller unit of each, which serves below a tenth."""


class Readable:
    """A result that says in a few lines what it holds: each number, and of each array its shape and its range."""

    def __repr__(self) -> str:
        """Show a line for each quantity, with its unit."""
        said = [(name, text) for name, text in _said(self) if text]
        width = max((len(name) for name, _ in said), default=0)
        return "\n".join([type(self).__name__, *(f"  {name:<{width}}  {text}" for name, text in said)])


class Shown(Readable):
    """What a notebook shows as a picture below the words of the terminal. Has a method ``plot(ax=None)``."""

    def _repr_html_(self) -> str:
        return f"<div>{words(repr(self))}{picture(self.plot)}</div>"  # type: ignore[attr-defined]


class Tabled(Readable):
    """What a notebook shows as a table of values with units."""

    def _repr_html_(self) -> str:
        units = units_of(type(self))
        rows = [(each.name, *in_unit(getattr(self, each.name), units.get(each.name, ""))) for each in fields(self)]  # type: ignore[arg-type]
        return table(("parameter", "value", "unit"), rows)


# ---- Words -----------------------------------------------------------------------------------------------------------


def units_of(cls: Any) -> dict[str, str]:
    """The unit of each attribute of a class that has one."""
    return {each.name: each.metadata["unit"] for each in fields(cls) if "unit" in each.metadata}


def in_unit(value: float, unit: str) -> tuple[str, str]:
    """A number by four digits, and the unit in which it has few zeros."""
    if unit in _PREFIXES and 0 < abs(value) < 0.1:
        factor, unit = _PREFIXES[unit]
        value = value / factor
    if isinstance(value, float) and math.isnan(value):
        return "none", ""
    return f"{value:.4g}" if isinstance(value, float) else str(value), unit


def with_unit(value: float, unit: str) -> str:
    """A number by four digits with its unit."""
    return " ".join(in_unit(float(value), unit)).strip()


def range_of(values: Any, unit: str = "") -> str:
    """Between which numbers an array lies."""
    known = values[np.isfinite(values)] if values.dtype.kind == "f" else values
    if not known.size:
        return "none"
    low, high = known.min(), known.max()
    ends = f"{low:.4g}" if low == high else f"{low:.4g} to {high:.4g}"
    gone = values.size - known.size
    return " ".join([ends, unit] if unit else [ends]) + (f" ({gone} of {values.size} none)" if gone else "")


def _said(shown: Any) -> Iterator[tuple[str, str]]:
    units = units_of(type(shown))
    for name in [each.name for each in fields(shown) if not each.name.startswith("_")]:
        value, unit = getattr(shown, name), units.get(name, "")
        if isinstance(value, np.ndarray):
            yield name, _of_array(value, unit)
        elif isinstance(value, (bool, str)):
            yield name, str(value)
        elif isinstance(value, (int, float)):
            yield name, with_unit(value, unit) if isinstance(value, float) else f"{value} {unit}".strip()
        elif isinstance(value, tuple) and value and all(isinstance(each, str) for each in value):
            yield name, ", ".join(value)
        elif isinstance(value, tuple) and all(isinstance(each, (int, float)) for each in value) and value:
            yield name, ", ".join(with_unit(each, unit) for each in value)


def _of_array(values: Any, unit: str) -> str:
    if values.ndim == 0:
        return with_unit(values.item(), unit)
    if values.dtype.kind == "b":
        return f"{values.sum()} of {values.size}"
    if values.ndim == 1 and values.size <= 4 and values.dtype.kind in "iuf":
        return " ".join([", ".join(f"{each:.4g}" for each in values.tolist()), unit]).strip() or "none"
    shape = " × ".join(map(str, values.shape))
    return f"{shape}: {range_of(values, unit)}" if values.dtype.kind in "iuf" else shape


# ---- HTML ------------------------------------------------------------------------------------------------------------


def words(text: str) -> str:
    """Text as the terminal has it."""
    style = "white-space:pre;overflow-x:auto;font-size:0.85em;line-height:1.35"
    return f'<pre style="{style}">{html.escape(text)}</pre>'


def table(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table whose first column names its rows."""
    head = "".join(f"<th>{html.escape(each)}</th>" for each in heads)
    body = "".join("<tr>" + "".join(f"<td>{html.escape(each)}</td>" for each in row) + "</tr>" for row in rows)
    return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"


def picture(draw: Callable[[Axes], object]) -> str:
    """What a function draws into axes as a picture that needs no file; nothing where there is nothing to draw."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=SIZE, layout="constrained")
    try:
        draw(figure.subplots())
    except ValueError as error:
        return words(str(error))
    return picture_of(figure)


def picture_of(figure: Any) -> str:
    """A figure of matplotlib as a picture that needs no file, with a text for screen readers."""
    coded = base64.b64encode(png_of(figure)).decode("ascii")
    return f'<img alt="picture" style="max-width:100%" src="data:image/png;base64,{coded}"/>'


def png_of(figure: Any) -> bytes:
    """A figure of matplotlib as PNG; those that are as small as a column of print by more points."""
    buffer = io.BytesIO()
    write_png(figure, buffer, dpi=DPI if figure.get_size_inches()[0] > SMALL else 1.5 * DPI)
    return buffer.getvalue()


def write_png(figure: Figure, file: Path | BinaryIO, *, dpi: float, metadata: dict[str, str] | None = None) -> None:
    """Write a figure of matplotlib as PNG, of so many points an inch.

    It is drawn once, where `Figure.savefig` draws one that lays itself out twice.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    before = figure.canvas, figure.dpi
    try:
        figure.dpi = dpi
        canvas: Any = FigureCanvasAgg(figure)
        canvas.print_png(file, metadata=metadata, pil_kwargs={"compress_level": COMPRESSION})
    finally:
        figure.dpi = before[1]
        figure.set_canvas(before[0])


def axes_for(ax: Axes | None) -> Axes:
    """The axes that were given, or new ones of pyplot, which a notebook shows."""
    if ax is not None:
        return ax
    from matplotlib import pyplot

    return pyplot.subplots(figsize=SIZE, layout="constrained")[1]
