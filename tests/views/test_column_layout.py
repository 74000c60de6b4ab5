"""Layout of figures with one column of axes."""

import itertools

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure
from stiction.views.figures.column_layout import ColumnLayout
from stiction.views.style import new_figure, place_axes


def draw_linear_axes(figure: Figure) -> None:
    for axes in figure.subplots(2, 1, sharex=True, height_ratios=[1.25, 1]):
        axes.plot([0, 1], [-0.00025, 0.00025])
        axes.set(xlabel="$x$ (µm)", ylabel="tangential load $F_T$ (mN)")


def draw_log_axes_below_a_secondary_axis(figure: Figure) -> None:
    upper, lower = figure.subplots(2, 1)
    for axes in (upper, lower):
        axes.loglog([1e-3, 1e5], [1e-12, 1e3])
        axes.set(xlabel="$q$ (1/µm)", ylabel="$C$ (µm³)")
    upper.secondary_xaxis("top", functions=(lambda x: 5 * x, lambda x: x / 5)).set_xlabel("$p$ (MPa)")


def draw_y_axes_shorter_than_a_decade(figure: Figure) -> None:
    for axes in figure.subplots(2, 1):
        axes.loglog([0.1, 10.0], [2.1e-5, 2.9e-5])
        axes.set(xlabel="$p$ (MPa)", ylabel="contact area")


def draw_a_low_panel_with_a_long_label(figure: Figure) -> None:
    for axes in figure.subplots(2, 1, height_ratios=[1, 6]):
        axes.set(ylabel="a very long height $z$ (nm)")
        axes.set_title("first line\nsecond line", loc="left", fontsize=6, pad=3)


@pytest.mark.parametrize("legend_at", ["top", "bottom"])
@pytest.mark.parametrize("canvas_type", [FigureCanvasAgg, FigureCanvasSVG])
@pytest.mark.parametrize(
    "draw",
    [
        draw_linear_axes,
        draw_log_axes_below_a_secondary_axis,
        draw_y_axes_shorter_than_a_decade,
        draw_a_low_panel_with_a_long_label,
    ],
)
def test_column_layout_places_texts_inside_the_figure_and_without_overlap(draw, canvas_type, legend_at):
    figure = new_figure(114, layout=ColumnLayout(legend_at=legend_at))
    draw(figure)
    if legend_at == "bottom":
        figure.suptitle("first line\nsecond line: $\\mu_0$", fontsize=6)
    handles = figure.axes[0].plot([0.5], [0.5])
    figure.legend(handles, ["legend"], loc=f"outside {'lower' if legend_at == 'bottom' else 'upper'} center")
    canvas_type(figure)
    place_axes(figure)
    renderer = figure._get_renderer()
    boxes = [artist.get_tightbbox(renderer) for artist in (*figure.axes, *figure.legends, *figure.texts)]
    for box in boxes:
        assert np.all(box.min >= 0)
        assert np.all(box.max <= figure.bbox.max)
    for one, other in itertools.combinations(boxes, 2):
        assert min(one.y1, other.y1) <= max(one.y0, other.y0)


def test_column_layout_keeps_height_ratios():
    figure = new_figure(100, layout=ColumnLayout())
    upper, lower = figure.subplots(2, 1, height_ratios=[2, 1])
    place_axes(figure)
    assert upper.get_position().height == pytest.approx(2 * lower.get_position().height)
