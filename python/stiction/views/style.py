"""What all figures have in common: sizes, one colour for one meaning, one name for one quantity, and the file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from stiction._checks import Floats
from stiction._core import __version__
from stiction._files import replaced_file
from stiction.mechanics.quantities import QUANTITIES

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MILLIMETRE = 1 / 25.4
WIDTH = 80 * MILLIMETRE
"""One column of print; nothing on a figure is smaller than 6 pt at this width."""

FULL_WIDTH = 170 * MILLIMETRE
"""Both columns."""

STYLE: dict[Any, Any] = {
    "font.size": 7,
    "axes.titlesize": 7,
    "axes.titley": 1.0,  # where it is put; finding a free place takes as long as drawing
    "axes.labelsize": 7,
    "xtick.labelsize": 6,
    "ytick.labelsize": 6,
    "legend.fontsize": 6,
    "legend.title_fontsize": 6,
    "axes.linewidth": 0.5,
    "xtick.major.width": 0.5,
    "ytick.major.width": 0.5,
    "xtick.minor.width": 0.3,
    "ytick.minor.width": 0.3,
    "legend.frameon": False,
    "figure.dpi": 300,
    "hatch.linewidth": 0.3,
}

# Colours of Okabe and Ito (2008), which eyes of every kind tell apart.
OPPOSING = "#d55e00"
"""Contacts that oppose the motion."""
LEANING = "#0072b2"
"""Those that lean with it."""
FORCE = "#000000"
"""Elastic forces."""
FRICTION = "#cc79a7"
"""Friction forces."""
STRENGTHS = ("#444444", "#56b4e9", "#009e73")
"""Adhesive shear strengths, from the lowest to the highest that is drawn."""
DIRECTIONS = {"+x": "#332288", "-x": "#999933"}
"""Of the motion along a line (Tol 2021)."""
LOCKED = "#7a0019"
"""Where contacts lock themselves."""
FRICTION_MAP = "plasma"
"""Of friction coefficients; viridis is of fractal dimensions and cividis of heights."""

SYMBOLS = {
    "friction_coefficient": r"\mu_s",
    "contact_area": "A",
    "load": "F_N",
    "fractal_dimension": "D",
    "amplitude": "a",
    "approach": r"\delta",
    "mu0": r"\mu_0",
    "tau0": r"\tau_0",
}


def label(name: str) -> str:
    """What an axis says of a quantity: its words, its symbol and its unit."""
    unit, words = QUANTITIES[name]
    written = {"1": "", "um": " (µm)", "um^2": " (µm²)"}.get(unit, f" ({unit})")
    return f"{words} ${SYMBOLS[name]}${written}"


def dimension_colours(dimensions: ArrayLike) -> Floats:
    """Of curves of several fractal dimensions: viridis without its yellow, which is not to be seen on white."""
    from matplotlib import colormaps

    return np.asarray(colormaps["viridis"](np.linspace(0, 0.85, np.size(dimensions))))


def force_text(force: float) -> str:
    """A force (mN) in the unit in which it has the fewest zeros."""
    exponent = np.floor(np.log10(force))
    unit, factor = ("mN", 1.0) if exponent >= -2 else ("µN", 1e3) if exponent >= -5 else ("nN", 1e6)
    return f"{factor * force:.3g} {unit}"


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


def few_ticks(axes: Axes) -> None:
    """No small ticks on scales of many decades, which take most of the time of drawing, and plain powers of ten."""
    from matplotlib.ticker import LogLocator, NullLocator

    for axis in (axes.xaxis, axes.yaxis):
        if axis.get_scale() == "log":
            low, high = axis.get_view_interval()
            if high > 1e3 * low:
                axis.set_major_locator(LogLocator(numticks=8))
                axis.set_minor_locator(NullLocator())
                axis.set_major_formatter(_power_of_ten)


def _power_of_ten(value: float, _: object) -> str:
    """As plain text: setting a formula takes longer than the axis."""
    return "10" + str(round(np.log10(value))).translate(_SUPERSCRIPTS)


_SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def lay_out(figure: Figure) -> None:
    """Find the places of everything in this style, and once: drawing would do it again, which takes as long again."""
    figure.draw_without_rendering()
    figure.set_layout_engine("none")


def warm_up() -> None:
    """Load what the first picture loads: fonts, and what formulas are read and kept by."""
    import matplotlib as mpl
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(1, 1))
        axes = figure.add_axes((0, 0, 1, 1))
        for at, name in enumerate(SYMBOLS):
            axes.text(0, at, label(name))
        canvas: Any = FigureCanvasAgg(figure)
        canvas.draw()


def save_picture(figure: Figure, path: Path) -> None:
    """Write a figure as PNG, over no other picture than one of this package: instruments write PNGs beside their data.

    Raises
    ------
    ValueError
        If the name does not end in .png, another picture has it, or it cannot be written.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    if path.suffix.lower() != ".png":
        raise ValueError(f"{path}: cannot be written: its name must end in .png")
    with replaced_file(path, _MADE_BY, ValueError) as partial, partial.open("wb") as file:
        # Not figure.savefig, which draws everything twice.
        canvas: Any = FigureCanvasAgg(figure)
        canvas.print_png(
            file, metadata={"Software": f"stiction {__version__}"}, pil_kwargs={"compress_level": _COMPRESSION}
        )


_COMPRESSION = 3
"""Of a PNG: two thirds of the time of the usual 6 for a tenth more bytes."""

_MADE_BY = b"Software\0stiction"
"""In the PNG."""
