"""What slips first: over the contacts of a map, and about those that lie closest together."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from stiction._checks import Floats
from stiction.studies.contact_picture import AROUND_LARGEST, FEWEST_POINTS
from stiction.views.digits import with_unit
from stiction.views.figures.contacts import box_of, draw_heights, scale_bar
from stiction.views.style import MILLIMETRE, SLIP_MAP, WIDTH, friction_parameters_text, label

if TYPE_CHECKING:
    import xarray
    from matplotlib.axes import Axes
    from matplotlib.colors import BoundaryNorm
    from matplotlib.figure import Figure

_LARGEST = 60.0
"""Area (square points) of the mark of the largest contact."""


def has_slip_map(onset: xarray.Dataset) -> bool:
    """Whether an onset has what `slip_figure` shows: that of areas has."""
    return bool("slip" in onset or "contact_slip" in onset)


def slip_figure(onset: xarray.Dataset, *, title: str = "") -> Figure:
    """At which tangential load each point of the contacts begins to slip, over the heights; 80 mm wide.

    It is of what `onset_of_result` returns of areas. Of asperities each contact is a mark, at the load at which it
    slides as a whole.
    """
    import matplotlib as mpl
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import BoundaryNorm
    from matplotlib.figure import Figure

    of_points = "slip" in onset
    figure = Figure(figsize=(WIDTH, (144 if of_points else 86) * MILLIMETRE), layout="constrained")
    drawn = figure.subplots(2 if of_points else 1, 1, squeeze=False)[:, 0]
    colours = mpl.colormaps[SLIP_MAP]
    levels = BoundaryNorm([0.0, *onset["fraction"].values], colours.N)
    whole = box_of(onset, "slip")
    draw_heights(figure, drawn[0], onset["lower_height"].values, whole)
    scale_bar(drawn[0], whole)
    if of_points:
        _points(drawn[0], onset["slip"].values, whole, levels)
        _closer(drawn[1], onset, levels)
        left, right, bottom, top = _crop(onset)[1]
        for colour, width in (("white", 1.6), ("black", 0.6)):
            drawn[0].plot(
                [left, right, right, left, left], [bottom, bottom, top, top, bottom], color=colour, linewidth=width
            )
    else:
        _marks(drawn[0], onset, levels)
    bar = figure.colorbar(
        ScalarMappable(levels, colours), ax=drawn[-1], location="bottom", shrink=0.8, ticks=[0, 0.2, 0.4, 0.6, 0.8, 1]
    )
    bar.set_label(f"tangential over sliding load at which a {'point slips' if of_points else 'contact slides'}")
    attributes = onset.attrs
    said = friction_parameters_text(float(attributes["mu0"]), float(attributes["tau0_GPa"]))
    lines = [title, f"{said}, $F_N$ = {with_unit(float(attributes['load_mN']), 'mN')}"]
    drawn[0].set_title("\n".join(line for line in lines if line), loc="left", fontsize=6, pad=3)
    return figure


def _points(axes: Axes, slip: Floats, box: tuple[float, ...], levels: BoundaryNorm) -> None:
    kind: dict[str, Any] = {"origin": "lower", "interpolation": "nearest", "cmap": SLIP_MAP, "norm": levels}
    axes.imshow(slip, extent=(box[0], box[1], box[2], box[3]), **kind)


def _marks(axes: Axes, onset: xarray.Dataset, levels: BoundaryNorm) -> None:
    area = onset["contact_area"].values
    axes.scatter(
        onset["contact_x"], onset["contact_y"], s=np.maximum(_LARGEST * area / area.max(initial=1e-300), 4.0),
        c=onset["contact_slip"], cmap=SLIP_MAP, norm=levels, edgecolors="white", linewidths=0.4,
    )  # fmt: skip


def _crop(onset: xarray.Dataset) -> tuple[tuple[slice, slice], tuple[float, float, float, float]]:
    """The part of the map in which most touches: its rows and columns, and its box (µm)."""
    from scipy.ndimage import gaussian_filter

    touching = np.isfinite(onset["slip"].values)
    size = [min(max(n // AROUND_LARGEST, FEWEST_POINTS), n) for n in touching.shape]
    busy = gaussian_filter(touching.astype(np.float64), [each / 4 for each in size], mode="constant")
    middle = np.unravel_index(int(busy.argmax()), busy.shape)
    first = [
        int(np.clip(at - wide // 2, 0, n - wide)) for at, wide, n in zip(middle, size, touching.shape, strict=True)
    ]
    part = tuple(slice(begin, begin + wide) for begin, wide in zip(first, size, strict=True))
    return (part[0], part[1]), box_of(onset.isel(slip_y=part[0], slip_x=part[1]), "slip")


def _closer(axes: Axes, onset: xarray.Dataset, levels: BoundaryNorm) -> None:
    part, box = _crop(onset)
    axes.imshow(onset["lower_height"].values[part], extent=box, origin="lower", cmap="gray", alpha=0.6)
    _points(axes, onset["slip"].values[part], box, levels)
    axes.set_title("where most touches (framed above)", loc="left", fontsize=6, pad=3)
    axes.set_xlabel(label("x"))
    axes.set_ylabel(label("y"))
