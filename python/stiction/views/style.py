"""What all figures have in common: sizes, one colour for one meaning, one name for one quantity, and the file."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiction._checks import Floats
from stiction._core import __version__
from stiction._files import replaced_file
from stiction._repr import write_png
from stiction.mechanics.quantities import QUANTITIES

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MILLIMETRE = 1 / 25.4
WIDTH = 80 * MILLIMETRE  # one column of print; nothing on a figure is smaller than 6 pt at this width
FULL_WIDTH = 170 * MILLIMETRE  # both columns

STYLE: dict[Any, Any] = {
    **dict.fromkeys(("font.size", "axes.titlesize", "axes.labelsize"), 7),
    **dict.fromkeys(("xtick.labelsize", "ytick.labelsize", "legend.fontsize", "legend.title_fontsize"), 6),
    **dict.fromkeys(("axes.linewidth", "xtick.major.width", "ytick.major.width"), 0.5),
    **dict.fromkeys(("xtick.minor.width", "ytick.minor.width"), 0.3),
    "axes.titley": 1.0,
    "legend.frameon": False,
    "figure.dpi": 300,
    "hatch.linewidth": 0.4,
    "pdf.fonttype": 42,  # text stays text, which journals ask for
    "svg.fonttype": "path",
    "svg.hashsalt": "stiction",  # equal figures are equal files
    "axes.unicode_minus": True,
}

# Colours of Okabe and Ito (2008) and of Tol (2021), which eyes of every kind tell apart.
OPPOSING = "#d55e00"  # contacts that oppose the motion, and the rule of friction at these contacts only
LEANING = "#0072b2"  # contacts that lean with the motion
ALL = "#332288"  # the rule of friction at all contacts
RULES = {"all": ALL, "opposing": OPPOSING}  # colour of each sliding rule, in the order in which they are named
AREA = "#009e73"  # true contact area
FORCE = "#000000"  # elastic forces
FRICTION = "#cc79a7"  # friction forces
UPPER = "#c6d9e7"  # the upper body
LOWER = "#e3d5bb"  # the lower body
STRENGTHS = ("#444444", "#aa4499")  # the lowest and the highest adhesive shear strength that are drawn
AXES = {"x": "#0072b2", "y": "#d55e00"}  # of what is measured along an axis of a map
LOCKED = "#7a0019"  # where contacts lock themselves
FRICTION_MAP = "plasma"
"""Colour map of friction coefficients; viridis is of fractal dimensions, grey of heights, inferno of pressures."""
SLIP_MAP = "YlOrRd"  # colours of the tangential load at which a point slips: light first, dark last

RULE_WORDS = {"all": "friction at all contacts", "opposing": "at opposing contacts only"}
"""What a legend says of a sliding rule."""

_LABELS = {
    "contact_area_fraction": "true contact area $A/A_0$ (%)",
    "nominal_pressure": "nominal pressure $F_N/A_0$ (MPa)",
    "area_over_load": "area over load $A/F_N$ (µm²/mN)",
    "patch_area": "area of a contact (µm²)",
    "pressure": "pressure in contact (GPa)",
    "cut_off": "cut-off wavelength (µm)",
    "rms_gradient": "rms gradient of the gap",
    "height_scale": "factor of the heights",
    "closure": "closure (µm)",
    "closure_stiffness": "stiffness of closure (MPa/mm)",
    "x": "$x$ (µm)",
    "y": "$y$ (µm)",
    "height": "height $z$ (µm)",
    "height_nm": "height $z$ (nm)",
}
"""Labels of axes that are no quantities of results, or are drawn in another unit."""


def new_figure(height: float, *, width: float = WIDTH, layout: Any = "constrained") -> Figure:
    """An empty figure, its height in millimetres and its width in inches."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height * MILLIMETRE), layout=layout)


def label(name: str) -> str:
    """What an axis says of a quantity: its words, its symbol and its unit."""
    if name in _LABELS:
        return _LABELS[name]
    quantity = QUANTITIES[name]
    unit = {"1": "", "um": " (µm)", "um^2": " (µm²)"}.get(quantity.unit, f" ({quantity.unit})")
    return f"{quantity.words} ${quantity.symbol}${unit}"


def dimension_colours(dimensions: ArrayLike) -> Floats:
    """Colours of curves of several fractal dimensions: viridis without its yellow, which is not to be seen on white."""
    from matplotlib import colormaps

    return np.asarray(colormaps["viridis"](np.linspace(0, 0.8, np.size(dimensions))))


def direction_text(degrees: float) -> str:
    """Where the upper body moves to, in degrees from +x towards +y, as words."""
    axes = {0.0: "$+x$", 90.0: "$+y$", 180.0: "$-x$", 270.0: "$-y$"}
    return axes.get(float(degrees) % 360, f"{degrees:g}° from $+x$")


def friction_parameters_text(mu0: float, tau0: float, effective_modulus: float | None = None) -> str:
    """The friction of the contacts, and the modulus, as the head of a figure says them; tau0 in GPa."""
    modulus = "" if effective_modulus is None else rf"$E^*$ = {effective_modulus:.4g} GPa, "
    return rf"{modulus}$\mu_0$ = {mu0:g}, $\tau_0$ = {1000 * tau0:.9g} MPa"


def spread_out(places: ArrayLike, least: float) -> Floats:
    """Places of labels in the order of what they label, moved until neighbours are so far apart."""
    wanted = np.asarray(places, dtype=np.float64)
    order = np.argsort(wanted)
    moved = wanted[order].copy()
    for _ in range(200):
        short = least - np.diff(moved)
        if not (short > 1e-9 * least).any():
            break
        push = np.maximum(short, 0) / 2
        moved[:-1] -= push
        moved[1:] += push
    result = np.empty_like(moved)
    result[order] = moved
    return result


def evenly_spread(count: int, most: int) -> NDArray[np.intp]:
    """At most so many indices out of `count`, evenly spread, both ends included."""
    return np.unique(np.linspace(0, count - 1, min(most, count)).round().astype(np.intp))


# ---- The file --------------------------------------------------------------------------------------------------------

FORMATS = ("png", "pdf", "svg")  # what a figure can be written as

MARKS = {".png": b"Software\0stiction", ".pdf": b"(stiction ", ".svg": b"<dc:title>stiction "}
"""Metadata by which a figure of this package is recognised, by the ending of its name."""


def checked_formats(formats: Sequence[str]) -> tuple[str, ...]:
    """Formats of figures, each once; a `ValueError` if there is none, or one is not of `FORMATS`."""
    found = tuple(dict.fromkeys(str(each).lower().removeprefix(".") for each in formats))
    if not found or not set(found) <= set(FORMATS):
        raise ValueError(f"formats must be some of {', '.join(FORMATS)}, got {', '.join(map(str, formats)) or 'none'}")
    return found


def save_picture(figure: Figure, path: Path) -> None:
    """Write a figure as PNG, PDF or SVG, over no other file than one of this package.

    Instruments write PNGs beside their data, so a picture of another origin is never replaced. Raises a `ValueError` if
    another file has the name, or it cannot be written.
    """
    import matplotlib as mpl

    suffix = path.suffix.lower()
    maker = f"stiction {__version__}"
    metadata: dict[str, dict[str, Any]] = {
        ".png": {"Software": maker},
        ".pdf": {"Creator": maker, "CreationDate": None},
        ".svg": {"Title": maker, "Date": None},
    }
    with mpl.rc_context(STYLE), replaced_file(path, MARKS[suffix], ValueError) as partial:
        if suffix == ".png":
            write_png(figure, partial, dpi=figure.dpi, metadata=metadata[suffix])
        else:
            figure.savefig(partial, format=suffix[1:], metadata=metadata[suffix])
