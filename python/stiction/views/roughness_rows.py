"""Roughness of measured surfaces as rows: JSON and CSV of `stiction characterise`."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from stiction.surfaces.profile import Profile
from stiction.surfaces.surface import Surface
from stiction.views.rows import entry, record
from stiction.views.scale_rows import scale_values

Characterised = Sequence[tuple[str, Profile | Surface, list[dict[str, Any]]]]
"""Of each file its name, what it holds, and its values."""


def characterisation(
    body: Profile | Surface, band: tuple[float, float] | None = None, tip_radius: float | None = None
) -> list[dict[str, Any]]:
    """Roughness of one levelled profile or surface as values, for a probe of this radius (µm).

    The Hurst exponent is fitted to a band of wavelengths (µm), or to one that is found.
    """
    from stiction.surfaces.roughness import roughness_parameters, surface_parameters
    from stiction.surfaces.spectrum import spectral_moments

    if isinstance(body, Profile):
        parameters: Any = roughness_parameters(body)
        neighbours = roughness_parameters(body, derivative="neighbours").Pdq
        moments = spectral_moments(body)
        extra = [
            entry("Pdq_neighbours", neighbours), entry("m0", moments.height, "um2"), entry("m2", moments.slope),
            entry("m4", moments.curvature, "1/um2"), entry("nayak_parameter", moments.nayak_parameter),
        ]  # fmt: skip
    else:
        parameters = surface_parameters(body)
        extra = []
    names = [each.name for each in dataclasses.fields(parameters)]
    own = [entry(name, getattr(parameters, name), _unit(name)) for name in names]
    scales = [entry(name, *value) for name, value in scale_values(body, tip_radius=tip_radius).items()]
    return [*own, *extra, *scales, *_hurst(body, band)]


_LENGTHS = ("Pa", "Pq", "Pt", "Sq", "Sa", "Sz", "Sal", "Sk", "Spk", "Svk")


def _unit(name: str) -> str:
    return "um" if name in _LENGTHS else "degrees" if name == "Std" else "1"


def _hurst(body: Profile | Surface, band: tuple[float, float] | None) -> list[dict[str, Any]]:
    from stiction.surfaces.hurst import hurst_exponent_of

    units = {"hurst_exponent": "1", "shortest_wavelength": "um", "longest_wavelength": "um"}
    try:
        estimate = hurst_exponent_of(body, band=band)
    except ValueError:
        if band is not None:
            raise
        return [entry(name, math.nan, unit, status="no-band") for name, unit in units.items()]
    return [
        entry("hurst_exponent", estimate.value, lower=estimate.lower, upper=estimate.upper),
        entry("shortest_wavelength", estimate.shortest_wavelength, "um"),
        entry("longest_wavelength", estimate.longest_wavelength, "um"),
    ]


def characterisation_record(bodies: Characterised) -> str:
    """What `stiction characterise` says of files, as JSON."""
    values = [value | {"at": {"file": file}} for file, _, each in bodies for value in each]
    surfaces = [_surface(file, body) for file, body, _ in bodies]
    return record("characterise", values, kind="surface", surfaces=surfaces)


def _surface(file: str, body: Profile | Surface) -> dict[str, Any]:
    return {
        "file": file, "holds": "profile" if isinstance(body, Profile) else "surface",
        "points": list(np.shape(body.heights)), "spacing_um": np.atleast_1d(body.spacing).tolist(),
        "extent_um": np.atleast_1d(body.extent).tolist(), "history": list(body.history),
    }  # fmt: skip


def characterisation_csv(bodies: Characterised) -> str:
    """A row for each file, a column for each value with its unit; empty where a file has none."""
    import pandas

    rows = []
    for file, body, values in bodies:
        about = _surface(file, body)
        row: dict[str, Any] = {
            "file": file,
            "holds": about["holds"],
            "points": _joined(about["points"]),
            "spacing (um)": _joined(about["spacing_um"]),
        }
        for value in values:
            name = value["name"]
            row[name if value["unit"] == "1" else f"{name} ({value['unit']})"] = value["value"]
            if name == "hurst_exponent":
                row |= {f"{name} {end}": value[end] for end in ("lower", "upper")}
        rows.append(row)
    text: str = pandas.DataFrame(rows).to_csv(index=False, float_format="%.9g")
    return text


def _joined(numbers: Sequence[float]) -> str:
    return " x ".join(f"{number:.12g}" for number in numbers)
