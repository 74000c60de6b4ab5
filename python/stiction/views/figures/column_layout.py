"""Layout of figures whose axes form one column."""

from __future__ import annotations

import re
from typing import Any, Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.layout_engine import LayoutEngine

TITLE_FONT_SIZE = 6.0
TITLE_PAD = 3.0
"""Space below the left title of axes (points)."""

_PAD = 3.0
"""Space around texts, legends and axes (points)."""
_RIGHT_MARGIN = 9.0
"""Space to the right of axes (points), for half of the last tick label."""
_NUM_ITERATIONS = 5
_LINE_HEIGHT = 1.2
"""Height of a line of text relative to its font size, large enough for subscripts."""
_TICK_LABEL_LINE_HEIGHT = 1.4
"""Height of tick labels relative to their font size, large enough for powers of ten."""
_CHARACTER_WIDTH = 0.6
"""Width of a character relative to the font size, larger than the mean width in any label."""


class ColumnLayout(LayoutEngine):
    """Layout engine for axes in one column without colour bars, with a heading and a legend above or below the axes.

    The engine measures legends and the longest tick label of each y axis. The sizes of other texts are estimated,
    because Matplotlib would parse a formula once to measure it and again to draw it. Matplotlib's constrained layout
    measures all texts and tick labels, and takes a third of the time of a drawing.
    """

    _adjust_compatible = False
    _colorbar_gridspec = False

    def __init__(self, *, legend_at: Literal["top", "bottom"] = "bottom") -> None:
        """Store where the legend of the figure is."""
        super().__init__()
        self._params: dict[str, Any] = {"legend_at": legend_at}

    def execute(self, fig: Any) -> None:
        """Place the axes and the heading of a figure."""
        measure = _TextMeasure(fig)
        width, height = 72 * fig.get_size_inches()
        heading_height = sum(_estimate_thickness(text) + _PAD for text in fig.texts)
        for text in fig.texts:
            text.set(y=1 - _PAD / height, verticalalignment="top")
        legend_height = sum(measure.height(legend) + _PAD for legend in fig.legends)
        is_legend_at_top = self._params["legend_at"] == "top"
        column = fig.axes
        left = _PAD + max(measure.y_axis_width(axes) for axes in column)
        top = height - heading_height - (legend_height if is_legend_at_top else 0.0)
        bottom = 0.0 if is_legend_at_top else legend_height
        height_ratios = np.array(column[0].get_gridspec().get_height_ratios(), dtype=float)
        min_spaces = np.array([(measure.space_above(axes), measure.x_axis_height(axes)) for axes in column]) + _PAD
        spaces, axes_heights = min_spaces, (top - bottom - min_spaces.sum()) * height_ratios / height_ratios.sum()
        # The label of a y axis may be longer than the axis, whose height depends in turn on the spaces.
        label_heights = np.array(
            [
                measure.height(axes.yaxis.label) if _estimate_length(axes.yaxis.label) > axes_height else 0.0
                for axes, axes_height in zip(column, axes_heights, strict=True)
            ]
        )
        for _ in range(_NUM_ITERATIONS):
            spaces = np.maximum(min_spaces, (label_heights - axes_heights)[:, np.newaxis] / 2 + _PAD)
            axes_heights = (top - bottom - spaces.sum()) * height_ratios / height_ratios.sum()
        axes_width = width - left - _RIGHT_MARGIN
        for axes, (space_above, space_below), axes_height in zip(column, spaces, axes_heights, strict=True):
            axes_bottom = top - space_above - axes_height
            axes.set_position((left / width, axes_bottom / height, axes_width / width, axes_height / height))
            top = axes_bottom - space_below


class _TextMeasure:
    """Sizes (points) of parts of a figure, measured with one renderer, which remembers texts."""

    def __init__(self, figure: Any) -> None:
        self._renderer = figure._get_renderer()
        # The renderer of an SVG file sets the resolution of the figure.
        self._points_per_pixel = 72 / figure.dpi

    def height(self, artist: Any) -> float:
        """Return the height of a legend or a text."""
        return float(self._points_per_pixel * artist.get_window_extent(self._renderer).height)

    def space_above(self, axes: Axes) -> float:
        """Return the height of the left title and of secondary axes above axes."""
        title = axes.get_title(loc="left")
        title_height = _LINE_HEIGHT * TITLE_FONT_SIZE * len(title.splitlines()) + TITLE_PAD if title else 0.0
        return title_height + sum(
            self.x_axis_height(child_axes) for child_axes in axes.child_axes if child_axes.get_xlabel()
        )

    def x_axis_height(self, axes: Any) -> float:
        """Return the height of ticks, tick labels and label of an x axis."""
        axis, tick = axes.xaxis, axes.xaxis.get_major_ticks(1)[0]
        height = float(tick.get_tick_padding())
        if tick.label1.get_visible() or tick.label2.get_visible():
            height += tick.get_pad() + _TICK_LABEL_LINE_HEIGHT * tick.label1.get_fontsize()
        return height + (axis.labelpad + _estimate_thickness(axis.label) if axis.get_label_text() else 0.0)

    def y_axis_width(self, axes: Any) -> float:
        """Return the width of ticks, tick labels and label of a y axis."""
        axis, tick = axes.yaxis, axes.yaxis.get_major_ticks(1)[0]
        low, high = sorted(axis.get_view_interval())
        # On logarithmic axes shorter than a decade, the minor ticks have labels, too.
        labels = [
            label
            for locations, formatter in (
                (axis.get_majorticklocs(), axis.get_major_formatter()),
                (axis.get_minorticklocs(), axis.get_minor_formatter()),
            )
            for label in formatter.format_ticks([location for location in locations if low <= location <= high])
        ]
        # The first tick measures the longest tick label; its own label is set when the figure is drawn.
        tick.label1.set_text(max(labels, key=len, default=""))
        tick_label_width = self._points_per_pixel * tick.label1.get_window_extent(self._renderer).width
        width = float(tick.get_tick_padding() + tick.get_pad() + tick_label_width)
        return width + (axis.labelpad + _estimate_thickness(axis.label) if axis.get_label_text() else 0.0)


def _estimate_thickness(text: Any) -> float:
    """Return the extent of a text across its lines (points)."""
    return float(_LINE_HEIGHT * text.get_fontsize() * len(text.get_text().splitlines()))


def _estimate_length(text: Any) -> float:
    """Return an upper bound of the length of a text in one line (points)."""
    return float(_CHARACTER_WIDTH * text.get_fontsize() * len(re.sub(r"\\[a-z]+", "x", text.get_text())))
