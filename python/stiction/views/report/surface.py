"""The page of one measured profile or surface: what it means for friction, its heights, spectra and roughness."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from stiction._checks import Floats
from stiction._core import __version__
from stiction.studies.intervals import CONFIDENCE
from stiction.surfaces.hurst import HurstEstimate
from stiction.surfaces.lines import LineRoughness
from stiction.surfaces.profile import Profile
from stiction.surfaces.spectrum import power_spectrum, surface_spectrum
from stiction.surfaces.surface import Surface
from stiction.views.characterisation import (
    PAPERS_MU0,
    RADIAL_BINS,
    Rows,
    characterisation_rows,
    estimate_of,
    friction_by_slope,
    surface_characterisation_rows,
)
from stiction.views.digits import percent, with_unit
from stiction.views.inputs import doubts_of_scan
from stiction.views.report.page import Page, deflated, escaped, listed
from stiction.views.report.picture import grey
from stiction.views.scale_rows import scale_values

MOST_POINTS = 1500
"""Of a profile that are drawn; of more, means of neighbours."""

BINS = 40
"""Of heights."""

MUCH = 0.1
"""Fraction of the mean square slope in the shortest octave from which on a finer scan would find much more."""

WAVES = "wave number _q_ (1/µm)"


def surface_page(
    body: Profile | Surface,
    along: Sequence[LineRoughness] = (),
    *,
    name: str,
    command: str,
    band: tuple[float, float] | None = None,
    tip_radius: float | None = None,
) -> Page:
    """The page of a profile or a surface.

    Parameters
    ----------
    body : Profile or Surface
        Levelled.
    along : two LineRoughness
        Of a surface, along x and y.
    name : str
        What it is called.
    command : str
        That makes the same page.
    band : (float, float), µm, optional
        Wavelengths to fit the Hurst exponent to.
    tip_radius : float, µm, optional
        Of the stylus or the probe.

    Raises
    ------
    ValueError
        As `characterisation_text`.
    """
    facts: dict[str, Any] = {"confidence": CONFIDENCE, "map": None}
    numbers = {}
    estimate = estimate_of(body, band, False)
    if isinstance(body, Profile):
        rows = characterisation_rows(body, band=band, tip_radius=tip_radius)
        plots = [_along(body), _spectrum(power_spectrum(body).in_bins(), estimate, "density _C_ (µm³)")]
    else:
        rows = surface_characterisation_rows(body, along[0], along[1], band=band, tip_radius=tip_radius)
        facts["map"], numbers["levels"] = _map(body)
        binned = [line.spectrum.in_bins() for line in along]
        lines = [
            _series(f"along {axis}", each.wave_number, each.density) for axis, each in zip("xy", binned, strict=True)
        ]
        plots = [
            _spectrum(surface_spectrum(body).radial(RADIAL_BINS), estimate, "density _C_ (µm⁴)"),
            _plot("lines", "Spectra of lines", lines, (WAVES, "density _C_ (µm³)"), log=True),
        ]
    facts["plots"] = [*plots, _distribution(body.heights)]
    titles = {"heights": "Heights"} | {plot["id"]: plot["name"] for plot in facts["plots"]}
    return Page(
        name=name, head=list(body.history), kind="surface", facts=facts, numbers=numbers,
        versions=f"Characterised by stiction {__version__}",
        words={
            "meaning": _meaning(body, tip_radius), "command": escaped(command), "table": _table(rows),
            "plots": "".join(_panel(*each) for each in titles.items()),
        },
    )  # fmt: skip


# ---- Words -----------------------------------------------------------------------------------------------------------


def _meaning(body: Profile | Surface, tip_radius: float | None) -> str:
    """What the slopes say of friction, how much of it a finer scan would change, and what is doubtful, as markup."""
    values = [f"{value:.2f}" for value in friction_by_slope(body)]
    axes = " along x and y" if len(values) == 2 else ""
    scales = scale_values(body, tip_radius=tip_radius)
    pixels, part = scales["shortest_wave"][0], scales["slope_in_shortest_octave"][0]
    change = "finds steeper slopes, more friction and less true area" if part > MUCH else "would change little"
    said = [
        f"Two bodies like this one begin to slide at μₛ = {' and '.join(values)}{axes}, by their slopes alone: "
        f"elastic, without adhesion, and where μ0 is {PAPERS_MU0:g}." if values else "It has no slopes.",
        f"Waves below {with_unit(2 * pixels, 'um')}, which is four points, have {percent(part)} of the mean square "
        f"slope: a finer scan {change}.",
        "For friction at a load, press two surfaces on each other: stiction pair --help has examples.",
    ]  # fmt: skip
    doubts = "".join(
        f"<li>{escaped(f'{each.text[0].upper()}{each.text[1:]}; {each.cure}.')}</li>" for each in doubts_of_scan(body)
    )
    return "".join(f"<p>{escaped(line)}</p>" for line in said) + (f'<ul class="doubts">{doubts}</ul>' if doubts else "")


def _table(rows: Rows) -> str:
    """Rows as markup; those without a name go on with the one before."""
    lines: list[tuple[str, list[str]]] = []
    for name, *values in rows:
        cells = [escaped(value) for value in values]
        if name or len(lines[-1][1]) > 1:
            lines.append((f'<th scope="row">{escaped(name.strip())}</th>' if name else "<td></td>", cells))
        else:
            lines[-1][1][0] += f"<br>{cells[0]}"
    wide = {1: " colspan=2", 2: ""}
    return "".join(
        f"<tr>{head}{''.join(f'<td{wide[len(cells)]}>{cell}</td>' for cell in cells)}</tr>" for head, cells in lines
    )


def _panel(name: str, title: str) -> str:
    return (
        f'<section class="panel" aria-labelledby="{name}-title"><h2 id="{name}-title">{title}</h2>'
        f'<div id="{name}" class="plot" role="application" tabindex="0" '
        f'aria-label="{title}; plus and minus look closer, 0 shows all"></div></section>'
    )


# ---- Curves ----------------------------------------------------------------------------------------------------------


def _series(name: str, x: Floats, value: Floats, **more: Any) -> dict[str, Any]:
    return {"name": name, "x": listed(x), "value": listed(value), **more}


def _plot(
    name: str, title: str, series: list[dict[str, Any]], titles: tuple[str, str], *, log: bool = False
) -> dict[str, Any]:
    """Curves over an axis that all of them fill."""
    ends = [each["x"][end] for each in series for end in (0, -1)]
    x, y = titles
    return {
        "id": name, "name": title, "series": series,
        "x": {"low": min(ends), "high": max(ends), "isLog": log, "title": x}, "y": {"isLog": log, "title": y},
    }  # fmt: skip


def _along(profile: Profile) -> dict[str, Any]:
    """Heights along a profile; of a long one means of neighbours between their lowest and their highest."""
    every = -(-len(profile) // MOST_POINTS)
    heights = 1000 * (profile.heights - profile.heights.min())
    groups = np.pad(heights, (0, -len(profile) % every), mode="edge").reshape(-1, every)
    band = {"lower": listed(groups.min(axis=1)), "upper": listed(groups.max(axis=1))} if every > 1 else {}
    x = np.asarray(profile.spacing * (every * np.arange(len(groups)) + (every - 1) / 2), dtype=float)
    return _plot(
        "heights", "Heights", [_series("", x, groups.mean(axis=1), **band)],
        ("position _x_ (µm)", "height above the lowest point (nm)"),
    )  # fmt: skip


def _spectrum(spectrum: Any, estimate: HurstEstimate | None, title: str) -> dict[str, Any]:
    """Means of a spectrum, and the power law that was fitted to it."""
    series = [_series("measured", spectrum.wave_number, spectrum.density)]
    if estimate is not None:
        first, last = (2 * math.pi / end for end in (estimate.longest_wavelength, estimate.shortest_wavelength))
        q = np.geomspace(first, last, BINS)
        series.append(_series(f"H = {estimate.value:.2f}", q, estimate.density(q), dash="7 4"))
    return _plot("spectrum", "Spectrum", series, (WAVES, title), log=True)


def _distribution(heights: Floats) -> dict[str, Any]:
    """How heights are distributed, beside normally distributed ones."""
    about = 1000 * (heights - heights.mean()).ravel()
    rms = float(about.std())
    density, edges = np.histogram(about, BINS, density=True)
    x = (edges[1:] + edges[:-1]) / 2
    normal = np.exp(-((x / rms) ** 2) / 2) / (rms * math.sqrt(2 * math.pi))
    series = [_series("measured", x, density), _series("Gaussian of the same rms", x, normal, dash="7 4")]
    return _plot("distribution", "Distribution of heights", series, ("height about the mean (nm)", "density (1/nm)"))


def _map(surface: Surface) -> tuple[dict[str, Any], str]:
    """Facts and packed heights of a map."""
    levels, range_, extent = grey(surface.heights, surface.spacing)
    rows, columns = levels.shape
    return {"rows": rows, "columns": columns, "extent": extent, "range": range_}, deflated(levels.tobytes())
