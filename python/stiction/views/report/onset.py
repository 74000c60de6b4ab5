"""How a pair begins to slide, as a page shows it: its curve, and a map of what slips first."""

from __future__ import annotations

from typing import TYPE_CHECKING

import matplotlib as mpl

from stiction._shown import picture_of
from stiction.views.figures.onset import onset_figure
from stiction.views.figures.slip import has_slip_map, slip_figure
from stiction.views.style import STYLE

if TYPE_CHECKING:
    import xarray

_CURVE = (
    "How the bodies begin to slide",
    "Tangential load over the displacement of the upper body, with cycles, and what slips before all does.",
    "Below the load at which they slide, weak contacts slip already: the bodies creep, and each cycle takes energy. "
    "The load, μ0 and τ0 are those above the figure; moving the sliders does not change it.",
)
_MAP = (
    "What slips first",
    "Contacts over the heights of the lower body, coloured by the tangential load at which they slip.",
    "Of one of the pairs: light points slip first, dark ones last. Contacts slip from their edges inwards.",
)
_MARKS = (*_MAP[:2], "Of one of the pairs: light contacts slide first, dark ones last. All slip at their edges before.")
"""Title, what is seen, and caption."""


def onset_panels(onset: xarray.Dataset, title: str) -> str:
    """Panels of the curve and of the map, as markup; the map is of areas."""
    drawn = [(_CURVE, onset_figure)]
    if has_slip_map(onset):
        drawn.append((_MAP if "slip" in onset else _MARKS, slip_figure))
    panels = []
    for (name, seen, caption), draw in drawn:
        with mpl.rc_context(STYLE):
            picture = picture_of(draw(onset, title=title), seen)
        below = f'<p class="caption">{caption}</p>'
        panels.append(f'<section class="panel" aria-label="{name}"><h2>{name}</h2>{picture}{below}</section>')
    return "".join(panels)
