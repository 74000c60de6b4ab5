"""Style of all figures: sizes, colours, labels and files."""

from __future__ import annotations

import io
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from stiction._checks import Floats
from stiction._core import __version__
from stiction._files import replace_file_atomically
from stiction._repr import write_png
from stiction._text import printable_text
from stiction.mechanics.quantities import QUANTITIES

if TYPE_CHECKING:
    import xarray
    from matplotlib.figure import Figure

INCHES_PER_MILLIMETRE = 1 / 25.4
# Widths (mm) of figures for one column and for the full page. In one column, the smallest text has 6 pt.
COLUMN_WIDTH = 80.0
PAGE_WIDTH = 170.0
MIN_LENGTH_IN_MILLIMETRES = 1000.0  # µm
MAX_LITERAL_TEXT_LENGTH = 300  # characters

MATPLOTLIB_STYLE: dict[Any, Any] = {
    **dict.fromkeys(("font.size", "axes.titlesize", "axes.labelsize"), 7),
    **dict.fromkeys(("xtick.labelsize", "ytick.labelsize", "legend.fontsize", "legend.title_fontsize"), 6),
    **dict.fromkeys(("axes.linewidth", "xtick.major.width", "ytick.major.width"), 0.5),
    **dict.fromkeys(("xtick.minor.width", "ytick.minor.width"), 0.3),
    "axes.titley": 1.0,
    "legend.frameon": False,
    "figure.dpi": 300,
    "hatch.linewidth": 0.4,
    # Font type 42 embeds fonts, as journals require.
    "pdf.fonttype": 42,
    "svg.fonttype": "path",
    # A constant salt for the hashes in SVG files makes the files of equal figures identical.
    "svg.hashsalt": "stiction",
    "axes.unicode_minus": True,
    # Without these settings, `Figure.set_layout_engine(None)` would create the layout engine of a user's own settings.
    "figure.autolayout": False,
    "figure.constrained_layout.use": False,
}

# Colours for people with colour vision deficiencies, from Okabe and Ito (2008) and Tol (2021).
OPPOSING_CONTACT_COLOUR = "#d55e00"
NOT_OPPOSING_CONTACT_COLOUR = "#0072b2"
ALL_CONTACTS_COLOUR = "#332288"
SLIDING_RULE_COLOURS = {"all": ALL_CONTACTS_COLOUR, "opposing": OPPOSING_CONTACT_COLOUR}
AREA_COLOUR = "#009e73"
FORCE_COLOUR = "#000000"
FRICTION_COLOUR = "#cc79a7"
UPPER_BODY_COLOUR = "#c6d9e7"
LOWER_BODY_COLOUR = "#e3d5bb"
SHEAR_STRENGTH_COLOURS = ("#444444", "#aa4499")
MAP_AXIS_COLOURS = {"x": "#0072b2", "y": "#d55e00"}
SELF_LOCKED_COLOUR = "#7a0019"
FRICTION_COLOUR_MAP = "plasma"
"""Colour map of friction coefficients. Other colour maps: viridis for D, grey for heights, inferno for pressures."""
COLOUR_RANGE_QUANTILES = (0.01, 0.95)
"""Quantiles of the friction coefficients at the ends of a colour scale, which exclude a few very high coefficients."""
COLOUR_BAR_TICKS = (
    0.01, 0.02, 0.03, 0.05, 0.07, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.7, 1, 1.5, 2, 3, 5, 7, 10, 20, 30, 50, 100,
)  # fmt: skip
"""Friction coefficients, all of them round numbers, from which the ticks of a colour bar are chosen."""
SLIP_COLOUR_MAP = "YlOrRd"

SLIDING_RULE_LABELS = {"all": "friction at all contacts", "opposing": "at opposing contacts only"}
"""Legend labels of the sliding rules."""

_AXIS_LABELS = {
    "contact_area_fraction": "true contact area $A/A_0$ (%)",
    "nominal_pressure": "nominal pressure $F_N/A_0$ (MPa)",
    "area_over_load": "area over load $A/F_N$ (µm²/mN)",
    "patch_area": "area of a contact (µm²)",
    "pressure": "pressure in contact (GPa)",
    "cut_off": "cutoff wavelength (µm)",
    "rms_gradient": "rms gradient of the gap",
    "height_scale": "factor of the heights",
    "closure": "closure (µm)",
    "closure_stiffness": "stiffness of closure (MPa/mm)",
    "x": "$x$ (µm)",
    "y": "$y$ (µm)",
    "height": "height $z$ (µm)",
    "height_nm": "height $z$ (nm)",
}
"""Axis labels of quantities that are not stored in results, or that figures show in another unit."""


def new_figure(height: float, *, width: float = COLUMN_WIDTH, layout: Any = "constrained") -> Figure:
    """Return an empty figure with a given height and width (mm)."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width * INCHES_PER_MILLIMETRE, height * INCHES_PER_MILLIMETRE), layout=layout)


def place_axes(figure: Figure) -> None:
    """Place the axes of a figure with its layout engine, and then remove this engine from the figure.

    Every drawing of a figure repeats the layout of an engine. With an engine, even the placeholder "none", `savefig`
    would also draw the figure twice.
    """
    if figure.axes and (layout_engine := figure.get_layout_engine()) is not None:
        layout_engine.execute(figure)
        figure.set_layout_engine(None)


def axis_label(name: str) -> str:
    """Return the axis label of a quantity: words, symbol and unit."""
    if name in _AXIS_LABELS:
        return _AXIS_LABELS[name]
    quantity = QUANTITIES[name]
    unit = {"1": "", "um": " (µm)", "um^2": " (µm²)"}.get(quantity.unit, f" ({quantity.unit})")
    return f"{quantity.words} ${quantity.symbol}${unit}"


def literal_text(text: str) -> str:
    """Escape a text from a file or from the user, so that the figure shows its "$" and its leading "_" unchanged."""
    escaped_text = printable_text(text, MAX_LITERAL_TEXT_LENGTH).replace("$", r"\$")
    # Matplotlib omits labels that start with "_" from legends.
    return f" {escaped_text}" if escaped_text.startswith("_") else escaped_text


def fractal_dimension_colours(dimensions: ArrayLike) -> Floats:
    """Return one colour per fractal dimension, from the colour map viridis except its yellow end."""
    from matplotlib import colormaps

    return np.asarray(colormaps["viridis"](np.linspace(0, 0.8, np.size(dimensions))))


def direction_text(degrees: float) -> str:
    """Return a direction of motion of the upper body (degrees) as text for a figure."""
    axis_names = {0.0: "$+x$", 90.0: "$+y$", 180.0: "$-x$", 270.0: "$-y$"}
    return axis_names.get(float(degrees) % 360, f"{degrees:g}° from $+x$")


def friction_parameters_text(mu0: float, tau0: float, effective_modulus: float | None = None) -> str:
    """Return E*, mu0 and tau0 (GPa) as text for the heading of a figure."""
    modulus = "" if effective_modulus is None else rf"$E^*$ = {effective_modulus:.4g} GPa, "
    return rf"{modulus}$\mu_0$ = {mu0:g}, $\tau_0$ = {1000 * tau0:.9g} MPa"


def interval_bands_text(points: xarray.Dataset, *, combined: bool = False, bands: str = "bands") -> str:
    """Return the text on the meaning of bands in a figure: 95 % combined intervals, or 95 % intervals of the mean.

    `combined` is true for combined intervals, and false for intervals of the mean.
    """
    if not combined:
        return f"{bands}: 95 %, intervals of the mean"
    scans_text = " with errors of the scans" if points.attrs.get("alternatives") else ""
    return f"{bands}: 95 %, combined intervals{scans_text}"


def spread_label_positions(label_positions: ArrayLike, min_distance: float) -> Floats:
    """Move label positions apart to a minimum distance between neighbours, and keep their order."""
    target_positions = np.asarray(label_positions, dtype=np.float64)
    ascending_order = np.argsort(target_positions)
    spread_positions = target_positions[ascending_order].copy()
    for _ in range(200):
        missing_distances = min_distance - np.diff(spread_positions)
        if not (missing_distances > 1e-9 * min_distance).any():
            break
        shifts = np.maximum(missing_distances, 0) / 2
        spread_positions[:-1] -= shifts
        spread_positions[1:] += shifts
    final_positions = np.empty_like(spread_positions)
    final_positions[ascending_order] = spread_positions
    return final_positions


# ---- Figure files ----------------------------------------------------------------------------------------------------

FIGURE_FORMATS = ("png", "pdf", "svg")

FIGURE_FILE_SIGNATURES = {".png": b"Software\0stiction", ".pdf": b"(stiction ", ".svg": b"<dc:title>stiction "}
"""Bytes by which a figure file that stiction wrote is recognized, by file name extension."""


def parse_formats(formats: Sequence[str]) -> tuple[str, ...]:
    """Return the file formats in which figures are written, each format only once.

    Raises a `ValueError` if a format is unknown.
    """
    file_formats = tuple(dict.fromkeys(str(item).lower().removeprefix(".") for item in formats))
    if not file_formats or not set(file_formats) <= set(FIGURE_FORMATS):
        raise ValueError(
            f"formats must be among {', '.join(FIGURE_FORMATS)}, got {', '.join(map(str, formats)) or 'none'}"
        )
    return file_formats


def save_figure(figure: Figure, path: Path) -> None:
    """Write a figure as PNG, PDF or SVG. Existing files are replaced only if stiction wrote them.

    Raises a `ValueError` as `write_figure_file` does.
    """
    write_figure_file(render_figure(figure, path.suffix.lower().removeprefix(".")), path)


def render_figure(figure: Figure, file_format: str) -> bytes:
    """Return a figure as the bytes of a PNG, PDF or SVG file."""
    import matplotlib as mpl

    producer, content = f"stiction {__version__}", io.BytesIO()
    metadata: dict[str, dict[str, Any]] = {
        "png": {"Software": producer},
        "pdf": {"Creator": producer, "CreationDate": None},
        "svg": {"Title": producer, "Date": None},
    }
    with mpl.rc_context(MATPLOTLIB_STYLE):
        if file_format == "png":
            write_png(figure, content, dpi=figure.dpi, metadata=metadata[file_format])
            # Without a layout engine, the axes keep their positions when the figure is drawn again.
            figure.set_layout_engine(None)
        else:
            place_axes(figure)
            figure.savefig(content, format=file_format, metadata=metadata[file_format])
    return content.getvalue()


def write_figure_file(content: bytes, path: Path) -> None:
    """Write the bytes of a figure to a file.

    Instruments store PNG files next to their data, so other images must never be replaced. Raises a `ValueError` if
    another file has the name, or if the file cannot be written.
    """
    with replace_file_atomically(path, FIGURE_FILE_SIGNATURES[path.suffix.lower()], ValueError) as partial_path:
        partial_path.write_bytes(content)
