"""Display of objects in a terminal or a notebook, as text, HTML and images."""

from __future__ import annotations

import base64
import html
import io
import math
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

NOTEBOOK_IMAGE_DPI = 110  # dots per inch
NOTEBOOK_IMAGE_SIZE = (4.6, 3.2)  # inches
# In a notebook, figures up to this width (inches) have a higher resolution than wider figures.
MAX_NARROW_FIGURE_WIDTH = 4.0
# Level 4 of zlib takes half the time of level 6, and makes images of maps 10 % larger.
PNG_COMPRESSION = 4

_NEXT_SMALLER_UNITS = {"µm": (1e-3, "nm"), "GPa": (1e-3, "MPa"), "mN": (1e-3, "µN")}
"""Next smaller unit of each unit, with the conversion factor. It is used for numbers below 0.1."""


class TextReprMixin:
    """Mixin that displays a dataclass as text: each number, and the shape and range of each array."""

    def __repr__(self) -> str:
        """Return the class name, followed by one line per field of the object: name, and value with unit."""
        rows = [(name, text) for name, text in _format_fields(self) if text]
        width = max((len(name) for name, _ in rows), default=0)
        return "\n".join([type(self).__name__, *(f"  {name:<{width}}  {text}" for name, text in rows)])


class PlotReprMixin(TextReprMixin):
    """Mixin for dataclasses that a notebook shows as text and as a plot (drawn by ``plot(ax=None)``)."""

    def _repr_html_(self) -> str:
        return f"<div>{preformatted_html(repr(self))}{plot_html(self.plot)}</div>"  # type: ignore[attr-defined]


class TableReprMixin(TextReprMixin):
    """Mixin for dataclasses that a notebook shows as a table of numbers with units."""

    def _repr_html_(self) -> str:
        units = field_units(type(self))
        rows = [
            (field.name, *format_number_and_unit(getattr(self, field.name), units.get(field.name, "")))
            for field in fields(self)  # type: ignore[arg-type]
        ]
        return table_html(("parameter", "value", "unit"), rows)


# ---- Text ------------------------------------------------------------------------------------------------------------


def field_units(cls: Any) -> dict[str, str]:
    """Return the units of dataclass fields, keyed by the names of the fields that have a unit."""
    return {field.name: field.metadata["unit"] for field in fields(cls) if "unit" in field.metadata}


def format_number_and_unit(value: float, unit: str) -> tuple[str, str]:
    """Return a number as text with four significant digits, followed by its unit.

    A nonzero number below 0.1 µm, 0.1 GPa or 0.1 mN is converted to nm, MPa or µN.
    """
    if unit in _NEXT_SMALLER_UNITS and 0 < abs(value) < 0.1:
        factor, unit = _NEXT_SMALLER_UNITS[unit]
        value = value / factor
    if isinstance(value, float) and math.isnan(value):
        return "none", ""
    return f"{value:.4g}" if isinstance(value, float) else str(value), unit


def format_with_unit(value: float, unit: str) -> str:
    """Format a number with four significant digits and a unit, which is a smaller unit for numbers below 0.1."""
    return " ".join(format_number_and_unit(float(value), unit)).strip()


def format_range(values: Any, unit: str = "") -> str:
    """Return as text the range of the finite numbers in an array, and the count of NaN and infinite numbers."""
    finite_values = values[np.isfinite(values)] if values.dtype.kind == "f" else values
    if not finite_values.size:
        return "none"
    low, high = finite_values.min(), finite_values.max()
    range_text = f"{low:.4g}" if low == high else f"{low:.4g} to {high:.4g}"
    num_missing = values.size - finite_values.size
    return " ".join([range_text, unit] if unit else [range_text]) + (
        f" ({num_missing} of {values.size} none)" if num_missing else ""
    )


def _format_fields(instance: Any) -> Iterator[tuple[str, str]]:
    units = field_units(type(instance))
    for name in [field.name for field in fields(instance) if not field.name.startswith("_")]:
        value, unit = getattr(instance, name), units.get(name, "")
        if isinstance(value, np.ndarray):
            yield name, _format_array(value, unit)
        elif isinstance(value, (bool, str)):
            yield name, str(value)
        elif isinstance(value, (int, float)):
            yield name, format_with_unit(value, unit) if isinstance(value, float) else f"{value} {unit}".strip()
        elif isinstance(value, tuple) and value and all(isinstance(item, str) for item in value):
            yield name, ", ".join(value)
        elif isinstance(value, tuple) and all(isinstance(item, (int, float)) for item in value) and value:
            yield name, ", ".join(format_with_unit(item, unit) for item in value)


def _format_array(values: Any, unit: str) -> str:
    if values.ndim == 0:
        return format_with_unit(values.item(), unit)
    if values.dtype.kind == "b":
        return f"{values.sum()} of {values.size}"
    if values.ndim == 1 and values.size <= 4 and values.dtype.kind in "iuf":
        return " ".join([", ".join(f"{item:.4g}" for item in values.tolist()), unit]).strip() or "none"
    shape = " × ".join(map(str, values.shape))
    return f"{shape}: {format_range(values, unit)}" if values.dtype.kind in "iuf" else shape


# ---- HTML ------------------------------------------------------------------------------------------------------------


def preformatted_html(text: str) -> str:
    """Return text as preformatted HTML, which can be scrolled with the keyboard."""
    style = "white-space:pre;overflow-x:auto;font-size:0.85em;line-height:1.35"
    return f'<pre tabindex="0" style="{style}">{html.escape(text)}</pre>'


def table_html(column_titles: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return an HTML table whose first column contains the row names."""
    head = "".join(f"<th>{html.escape(text)}</th>" for text in column_titles)
    body = "".join("<tr>" + "".join(f"<td>{html.escape(text)}</td>" for text in row) + "</tr>" for row in rows)
    return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"


def plot_html(draw: Callable[[Axes], object]) -> str:
    """Return a plot as an inline image in HTML or, if drawing fails, the error message."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=NOTEBOOK_IMAGE_SIZE, layout="constrained")
    try:
        draw(figure.subplots())
    except ValueError as error:
        return preformatted_html(str(error))
    return figure_html(figure)


def figure_html(figure: Any) -> str:
    """Return a Matplotlib figure as an inline image in HTML, with a description for screen readers."""
    encoded = base64.b64encode(render_png(figure)).decode("ascii")
    description = html.escape(describe_figure_axes(figure))
    return f'<img alt="{description}" style="max-width:100%" src="data:image/png;base64,{encoded}"/>'


def describe_figure_axes(figure: Any) -> str:
    """Return a description of a Matplotlib figure: the labels of its axes without mathematical markup."""
    labels = [(ax.get_ylabel(), ax.get_xlabel()) for ax in figure.axes]
    plots = "; ".join(f"{y} against {x}" for y, x in labels if y and x)
    return re.sub(r"\$|\\mathrm|[{}\\]", "", f"Plot of {plots}" if plots else "Plot")


def render_png(figure: Any) -> bytes:
    """Render a Matplotlib figure as PNG bytes, with 1.5 times the resolution if the figure is only one column wide."""
    buffer = io.BytesIO()
    is_narrow = figure.get_size_inches()[0] <= MAX_NARROW_FIGURE_WIDTH
    write_png(figure, buffer, dpi=1.5 * NOTEBOOK_IMAGE_DPI if is_narrow else NOTEBOOK_IMAGE_DPI)
    return buffer.getvalue()


def write_png(figure: Figure, file: Path | BinaryIO, *, dpi: float, metadata: dict[str, str] | None = None) -> None:
    """Write a Matplotlib figure as PNG in a given resolution.

    The figure is drawn only once, whereas `Figure.savefig` draws a figure with automatic layout twice.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    original_canvas_and_dpi = figure.canvas, figure.dpi
    try:
        figure.dpi = dpi
        canvas: Any = FigureCanvasAgg(figure)
        canvas.print_png(file, metadata=metadata, pil_kwargs={"compress_level": PNG_COMPRESSION})
    finally:
        figure.dpi = original_canvas_and_dpi[1]
        figure.set_canvas(original_canvas_and_dpi[0])


def axes_or_new_axes(ax: Axes | None) -> Axes:
    """Return the given axes or, if the argument is None, new axes that a notebook displays."""
    if ax is not None:
        return ax
    from matplotlib import pyplot

    return pyplot.subplots(figsize=NOTEBOOK_IMAGE_SIZE, layout="constrained")[1]
