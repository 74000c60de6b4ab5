"""Panels of a report that contain figures as inline SVG."""

from __future__ import annotations

import html
import io
import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import xarray
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure

from stiction._number_format import format_percent, format_with_unit
from stiction.companions.resolution import ResolutionLimits
from stiction.study.study import Study
from stiction.summary.report_data import ReportDataOfGeneratedSurfaces, ReportDataOfMeasuredSurfaces
from stiction.views.figures.contact import contact_forces_figure, contact_map_figure
from stiction.views.figures.distributions import friction_by_position_figure
from stiction.views.figures.height_scale import height_scale_figure
from stiction.views.figures.loads import adhesion_figure, cut_off_figure
from stiction.views.figures.onset import contains_slip_map, onset_by_dimension_figure, onset_figure, slip_figure
from stiction.views.figures.standard import format_title_for_print
from stiction.views.height_scale import HEIGHT_SCALE_NOTE, NAMES_OF_SCALED_SURFACES
from stiction.views.point import motion_direction_text
from stiction.views.report.page import format_count
from stiction.views.style import MATPLOTLIB_STYLE, place_axes

if TYPE_CHECKING:
    from stiction.companions.height_scale import ScaledBodies


@dataclass(frozen=True, eq=False)
class FigurePanel:
    """Panel of a report with a figure that is drawn only when the page is rendered.

    `description` is for screen readers, and `caption` is markup. A main panel is shown next to the result, and other
    panels among the details.
    """

    title: str
    description: str
    caption: str
    draw_figure: Callable[[], Figure]
    is_wide: bool = False
    is_main: bool = False

    def markup(self) -> str:
        """Draw the figure, and return the panel with figure and caption as HTML."""
        with mpl.rc_context(MATPLOTLIB_STYLE):
            svg = inline_svg(self.draw_figure(), self.description)
        css_class = "panel wide" if self.is_wide else "panel"
        caption_html = f'<p class="caption">{self.caption}</p>'
        return (
            f'<section class="{css_class}" aria-label="{self.title}"><h2>{self.title}</h2>{svg}{caption_html}</section>'
        )


# ---- Generated surfaces ----------------------------------------------------------------------------------------------


def draw_panels(data: ReportDataOfMeasuredSurfaces | ReportDataOfGeneratedSurfaces) -> dict[bool, str]:
    """Draw the figures of a report; return the HTML of its main panels and of its other panels.

    The key True stands for the main panels, and the key False for all other panels.
    """
    panels = list_panels(data)
    return {
        is_main: "".join(panel.markup() for panel in panels if panel.is_main == is_main) for is_main in (True, False)
    }


def list_panels(data: ReportDataOfMeasuredSurfaces | ReportDataOfGeneratedSurfaces) -> list[FigurePanel]:
    """Return one panel for each figure that can be drawn from the data of a report."""
    return (
        _list_measured_panels(data) if isinstance(data, ReportDataOfMeasuredSurfaces) else _list_generated_panels(data)
    )


def _list_generated_panels(data: ReportDataOfGeneratedSurfaces) -> list[FigurePanel]:
    panels = []
    if data.contact_forces is not None:
        panels.append(_contact_forces_panel(data.contact_forces))
    if data.onset is not None:
        panels.append(_onset_by_dimension_panel(data.onset, data.study))
    return panels


def _contact_forces_panel(forces: xarray.Dataset) -> FigurePanel:
    """Return the panel with the forces between two generated profiles in contact."""
    dimension, amplitude = (float(forces[name]) for name in ("fractal_dimension", "amplitude"))
    title = f"$D$ = {dimension:.3g}, amplitude {format_with_unit(amplitude, 'um')}"
    return FigurePanel(
        "Two of the profiles in contact",
        "Two profiles, and the contact with the largest load with the forces on the upper body.",
        "The first pair of profiles, at the middle fractal dimension and approach of the study.",
        partial(contact_forces_figure, forces, title=title),
    )


def _onset_by_dimension_panel(points: xarray.Dataset, study: Study) -> FigurePanel:
    """Return the panel that shows the onset of sliding of generated pairs against the fractal dimension."""
    return FigurePanel(
        "Onset of sliding against fractal dimension",
        "Pre-sliding displacement, fraction slipped at half of the sliding load, and tangential stiffness against "
        "fractal dimension.",
        "At three loads and the strengths of the study; the sliders do not change this figure. Means with 95 % "
        "intervals; except for the stiffness, repetitions are weighted by their loads. Dotted: more than half of the "
        "load is beyond Hertz.",
        partial(onset_by_dimension_figure, points, study),
        is_wide=True,
    )


# ---- Measured surfaces -----------------------------------------------------------------------------------------------


def _list_measured_panels(data: ReportDataOfMeasuredSurfaces) -> list[FigurePanel]:
    title, panels = format_title_for_print(data.description.name), []
    if data.contact_picture is not None:
        panels.append(_contact_panel(data.contact_picture, data.directions[0], data.num_opposing_contacts))
    if data.positions is not None:
        panels.append(_members_panel(data.positions, data.study, title))
    if (limits := data.summary.find_resolution_limits()) is not None:
        panels.append(_cutoff_panel(limits, title))
    if data.summary.onset is not None:
        panels += _onset_panels(data.summary.onset, data.study, title)
    panels += [_height_factors_panel(points, scaled, title) for scaled, points in data.height_factors.items()]
    if data.loading_cycle is not None:
        panels.append(_adhesion_panel(data.loading_cycle, title))
    return panels


def _contact_panel(picture: xarray.Dataset, direction: float, num_opposing: int) -> FigurePanel:
    """Return the panel that shows all contacts of a typical surface pair, for one direction of motion (degrees)."""
    force, is_cut = picture["contact_force"].values, picture["contact_at_edge"].values > 0
    text = (
        f"The position whose true area is nearest to the mean: {format_count(force.size, 'contact')} at "
        f"{format_with_unit(float(picture.attrs['load_mN']), 'mN')}; pushed {motion_direction_text(direction)}, "
        f"{num_opposing} of them {'opposes' if num_opposing == 1 else 'oppose'} the motion."
    )
    if is_cut.any():
        cut_load_text = format_percent(float(force[is_cut].sum() / force.sum()))
        text += f" Contacts cut by the edge of the scans carry {cut_load_text} of the load."
    offset = " and ".join(f"{float(picture.attrs[axis]):.3g}" for axis in "xy").replace("-", "\N{MINUS SIGN}")
    position_text = "profile is shown in the pressed position" if "gap" in picture else f"map is moved by {offset} µm"
    description, caption = "The two bodies with their true contacts.", f"{text} The upper {position_text}."
    return FigurePanel(
        "Contacts", description, caption, partial(contact_map_figure, picture, direction=direction), is_main=True
    )


def _members_panel(point: xarray.Dataset, study: Study, title: str) -> FigurePanel:
    """Return the panel with the friction of each surface pair in each direction of motion."""
    singular, plural = study.member_names
    return FigurePanel(
        f"Single {plural}",
        f"Friction coefficient for each {singular} and direction.",
        "At the first load, μ0 and τ0 of the study; the sliders do not change this figure.",
        partial(friction_by_position_figure, point, title=title),
    )


def _cutoff_panel(limits: ResolutionLimits, title: str) -> FigurePanel:
    """Return the panel that shows friction and true area against the cutoff wavelength."""
    return FigurePanel(
        "Cutoff wavelength",
        "Friction coefficient and true contact area over the cutoff wavelength of the low-pass filter.",
        "At the first load, μ0 and τ0 of the study; the sliders do not change this figure.",
        partial(cut_off_figure, limits, title=title),
    )


def _onset_panels(onset: xarray.Dataset, study: Study, title: str) -> list[FigurePanel]:
    """Return the panel of the onset curve and, for maps, also the panel of the slip map."""
    curve_panel = FigurePanel(
        "Onset of sliding",
        "Tangential load against displacement of the upper body, with load cycles, and the slipping fraction.",
        "Weak contacts slip below the sliding load, so that the upper body moves before it slides, and each load "
        "cycle dissipates energy. The load, μ0 and τ0 are given above the figure; the sliders do not change this "
        "figure.",
        partial(onset_figure, onset, title=title),
    )
    if not contains_slip_map(onset):
        return [curve_panel]
    points_text = "light points slip first and dark points last. Contacts slip from their edges inwards."
    contacts_text = (
        "light contacts slide first and dark contacts last. Each contact slips at its edge before it slides."
    )
    slip_panel = FigurePanel(
        "Order of slip",
        "Contacts on a map of the lower body, coloured by the tangential load at which they slip.",
        f"For one {study.member_names.singular}: {points_text if 'slip' in onset else contacts_text}",
        partial(slip_figure, onset, title=title),
    )
    return [curve_panel, slip_panel]


def _height_factors_panel(points: xarray.Dataset, scaled_bodies: ScaledBodies, title: str) -> FigurePanel:
    """Return the panel that shows how multiplied heights affect friction, at the study's first load, mu0 and tau0."""
    surfaces_text, factors = NAMES_OF_SCALED_SURFACES[scaled_bodies], points["height_scale"].values
    return FigurePanel(
        f"Another finish of {surfaces_text}",
        "Friction coefficient and true contact area over the rms gradient of the gap.",
        f"Heights of {surfaces_text} times {factors[0]:g} to {factors[-1]:g}, each solved again; dashed: as measured. "
        f"{HEIGHT_SCALE_NOTE} The load, μ0 and τ0 are the first values of the study; the sliders do not change this "
        "figure.",
        partial(height_scale_figure, points, title=title),
    )


def _adhesion_panel(loading_cycle: xarray.Dataset, title: str) -> FigurePanel:
    """Return the panel that shows load against approach and true area of adhesive bodies, in loading and unloading."""
    return FigurePanel(
        "Loading and unloading",
        "Load against approach and true area of a typical pair, pressed together and pulled apart.",
        "Bodies that adhere are in contact without a load, have a contact load above the applied load, and separate "
        "at the pull-off force.",
        partial(adhesion_figure, loading_cycle, title=title),
    )


# ---- Inline SVG ------------------------------------------------------------------------------------------------------


# A figure element with more vertices than this number is drawn as pixels.
MAX_SVG_VERTICES = 1000
RASTER_DPI = 200  # dots per inch

_CSS_COLOURS = {
    **dict.fromkeys(("#000000", "#262626", "#333333", "#404040", "#444444"), "var(--ink)"),
    "#ffffff": "var(--paper)",
    "#e6e6e6": "var(--line)",
    "#c6d9e7": "var(--upper)",
    "#e3d5bb": "var(--lower)",
    **{
        dark_colour: f"var(--light, {dark_colour})"
        for dark_colour in ("#332288", "#440154", "#481d6f", "#453781", "#7a0019")
    },
}
"""Style sheet variables that replace the colours of a figure, so that the figure suits light and dark mode."""


def inline_svg(figure: Figure, description: str) -> str:
    """Return a figure as inline SVG, with a description for screen readers."""
    for axes in figure.axes:
        artists: list[Any] = [*axes.collections, *axes.lines]
        for artist in artists:
            paths = artist.get_paths() if hasattr(artist, "get_paths") else [artist.get_path()]
            artist.set_rasterized(sum(len(path.vertices) for path in paths) > MAX_SVG_VERTICES)
    # This canvas measures text as the SVG file draws it.
    FigureCanvasSVG(figure)
    place_axes(figure)
    text = io.StringIO()
    figure.savefig(text, format="svg", dpi=RASTER_DPI, transparent=True, metadata={"Date": None, "Creator": None})
    svg_text = text.getvalue()
    svg_text = re.sub(r"<metadata>.*?</metadata>", "", svg_text[svg_text.index("<svg") :], flags=re.DOTALL)
    svg_text = re.sub("|".join(_CSS_COLOURS), lambda match: _CSS_COLOURS[match[0]], svg_text)
    svg_text = re.sub(r'\bd="[^"]*"', lambda match: re.sub(r"(\.\d)\d+", r"\1", match[0]), svg_text)
    opening_tag = f'<svg role="img" aria-label="{html.escape(description)}" fill="var(--ink)" '
    return f'<div class="figure">{svg_text.replace("<svg ", opening_tag, 1)}</div>'
