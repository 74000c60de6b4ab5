"""How generated pairs begin to slide, over fractal dimension: creep, what slips before, and stiffness."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stiction._checks import Floats
from stiction.studies.at_load import at_load, reached_loads
from stiction.studies.contact_tables import Asperities
from stiction.studies.study import study_of
from stiction.views.digits import with_unit
from stiction.views.figures.ensemble import FRACTION_LIMIT, HEADLINE, dimension_axis, head, headlines, letter
from stiction.views.style import FULL_WIDTH, MILLIMETRE, friction_parameters_text

if TYPE_CHECKING:
    import xarray
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_PANELS = {
    "displacement_at_sliding": (1000.0, "creep before sliding (nm)", True),
    "fraction_slipped": (100.0, "slips at half of the load (%)", False),
    "tangential_stiffness": (1.0, "tangential stiffness (mN/µm)", True),
}
"""Factor, words and whether the axis has equal ratios, of each panel."""

PARTS = (0.25, 0.5, 0.75)
"""Loads of the curves, as fractions of the way in ratio from the lightest to the heaviest load."""

COLOURS = ("#56b4e9", "#0072b2", "#003a5d")
"""Colours of the curves, from light loads to heavy ones."""


def onset_loads(dataset: xarray.Dataset) -> Floats:
    """Three loads (mN) that most ensembles reach, in one digit."""
    ends = np.log(reached_loads(dataset, 2))
    return np.unique([float(f"{np.exp(ends[0] + part * (ends[1] - ends[0])):.0e}") for part in PARTS])


def dimension_onset_figure(dataset: xarray.Dataset) -> Figure:
    """Creep, what slips at half of the sliding load, and stiffness over fractal dimension; a row for each amplitude.

    With 95 % intervals; dotted where the model is beyond its validity.
    """
    from matplotlib.figure import Figure

    study = study_of(dataset)
    assert isinstance(study.contact, Asperities)
    asked = study.contact.onset
    assert asked is not None
    loads = onset_loads(dataset)
    at = at_load(dataset, loads, mu0=asked.mu0, tau0=float(asked.tau0)).isel(mu0=0, tau0=0)
    amplitudes = dataset["amplitude"].values
    lines = headlines(dataset, study)
    above, below, between, height = 6.0 + HEADLINE * len(lines), 15.0, 5.0, 42.0
    total = above + below + amplitudes.size * (height + between) - between
    figure = Figure(figsize=(FULL_WIDTH, total * MILLIMETRE))
    for row, amplitude in enumerate(amplitudes):
        bottom = below + (amplitudes.size - 1 - row) * (height + between)
        for number, name in enumerate(_PANELS):
            axes = figure.add_axes(((13 + 57 * number) / 170, bottom / total, 40 / 170, height / total))
            _curves(axes, at.isel(amplitude=row), name)
            dimension_axis(axes, dataset, last=row == amplitudes.size - 1)
            if row == 0:
                letter(axes, number)
            if amplitudes.size > 1 and number == 0:
                axes.set_title(f"$a$ = {1000 * amplitude:g} nm", loc="right", pad=2)
    head(figure, lines)
    handles, words = figure.axes[0].get_legend_handles_labels()
    figure.legend(handles, words, loc="lower left", ncols=len(handles), borderaxespad=0.3)
    figure.text(
        0.99, 1.5 / total, f"at {friction_parameters_text(asked.mu0, float(asked.tau0))}; bands: 95 %; dotted: model "
        "not valid", ha="right", va="bottom", fontsize=6,
    )  # fmt: skip
    return figure


def _curves(axes: Axes, at: xarray.Dataset, name: str) -> None:
    factor, words, in_ratios = _PANELS[name]
    dimension = at["fractal_dimension"].values
    for load, colour in zip(at["load"].values, COLOURS, strict=False):
        one = at.sel(load=load)
        mean, lower, upper = (factor * one[name].sel(statistic=each).values for each in ("mean", "lower", "upper"))
        trusted = ~(one["share_beyond_hertz"].values > FRACTION_LIMIT)
        axes.fill_between(dimension, lower, upper, color=colour, alpha=0.2, linewidth=0)
        marker = "o" if dimension.size == 1 else None
        axes.plot(dimension, mean, ":", color=colour, linewidth=1, marker=marker, markersize=2)
        axes.plot(
            dimension, np.where(trusted, mean, np.nan), color=colour, linewidth=1, marker=marker, markersize=2,
            label=f"$F_N$ = {with_unit(load, 'mN')}",
        )  # fmt: skip
    known = at[name].sel(statistic="mean").values
    known = factor * known[np.isfinite(known) & (known > 0)]
    if in_ratios and known.size:
        axes.set_yscale("log")
        axes.set_ylim(known.min() / 2, known.max() * 2)
    elif not in_ratios:
        axes.set_ylim(0, 50)
    axes.set_ylabel(words)
