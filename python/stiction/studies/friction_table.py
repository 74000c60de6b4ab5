"""Tables for contact laws of other codes: friction, true area and stiffness of self-affine surfaces."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiction._checks import Floats
from stiction.mechanics import friction
from stiction.mechanics.quantities import attributes_of
from stiction.studies import intervals
from stiction.studies.member_values import SIX, loads_of
from stiction.studies.store import pieces
from stiction.studies.study import Study, study_of

if TYPE_CHECKING:
    import xarray

TITLE = "stiction table"
"""`title` attribute of a friction table."""

FEWEST_PRESSURES = 3
"""Fewest pressures that give a stiffness."""

DIRECTIONS = (0.0, 90.0, 180.0, 270.0)
"""Degrees; the surfaces are isotropic, and a coefficient is that of all four together."""

LIGHT = 0.1
"""True share of the area up to which the laws are fitted."""

STRAIGHT = 0.1
"""Relative deviation above which a fitted law is doubted."""


def table_study(
    *,
    hurst_exponents: Sequence[float] = (0.5, 0.7, 0.9),
    rms: Sequence[float] = (0.01, 0.03, 0.1),
    pressures: Sequence[float] = (0.001, 0.003, 0.01, 0.03, 0.1),
    mu0: Sequence[float] = (0.2, 0.4, 0.6),
    tau0: Sequence[float] = (0.0,),
    effective_modulus: float = 10.0,
    extent: float = 10.0,
    points: int = 256,
    longest_wavelength: float = 2.5,
    shortest_wavelength: float = 0.3125,
    repetitions: int = 12,
    seed: int = 2016,
) -> Study:
    """The study that a table is made of: pairs of self-affine surfaces as periodic half-spaces.

    Parameters
    ----------
    hurst_exponents : sequence of float
        From just above 0 to 1.
    rms : sequence of float, µm
        Sq of each of the two surfaces.
    pressures : sequence of float, GPa
        Loads over the nominal area.
    mu0 : sequence of float
    tau0 : sequence of float, GPa
    effective_modulus : float, GPa
    extent : float, µm
        Side of the square that is pressed, and period of the surfaces.
    points : int
        Along each side.
    longest_wavelength, shortest_wavelength : float, µm
        Roll-off and cut-off. With at least four of the longest waves along the side a table hardly depends on it.
    repetitions : int
        Pairs of surfaces.
    seed : int

    Raises
    ------
    StudyError
        If the study cannot be computed.

    Examples
    --------
    >>> from stiction import table_study
    >>> table_study(rms=[0.02]).surfaces.amplitudes()
    array([0.02])
    """
    area = extent**2
    return Study.model_validate(
        {
            "surfaces": {
                "kind": "surface",
                "generator": "self-affine",
                "fractal_dimension": sorted(2 - float(each) for each in hurst_exponents),
                "amplitude": [_exact(each, "um") for each in rms],
                "amplitude_measure": "Sq",
                "longest_wavelength": _exact(longest_wavelength, "um"),
                "shortest_wavelength": _exact(shortest_wavelength, "um"),
                "shape": [points, points],
                "extent": [_exact(extent, "um")] * 2,
            },
            "contact": {
                "mechanics": "half-space",
                "boundary": "periodic",
                "effective_modulus": _exact(effective_modulus, "GPa"),
                "direction": list(DIRECTIONS),
                "sliding": ["opposing", "all"],
                "load": [_exact(each * area, "mN") for each in sorted(pressures)],
            },
            "friction": {"mu0": list(mu0), "tau0": [_exact(each, "GPa") for each in tau0]},
            "ensemble": {"repetitions": repetitions, "seed": seed},
        }
    )


def _exact(value: float, unit: str) -> str:
    return f"{float(value)!r} {unit}"


def friction_table(
    dataset: xarray.Dataset, *, mu0: ArrayLike | None = None, tau0: ArrayLike | None = None
) -> xarray.Dataset:
    r"""Friction, true area and stiffness against pressure, and fitted laws, of a study by the half-space.

    Parameters
    ----------
    dataset : xarray.Dataset
        What `run` returns of `table_study`, or of any study of surfaces with mechanics "half-space".
    mu0 : (m,) array_like of float, optional
    tau0 : (t,) array_like of float, GPa, optional
        Those of the study by default.

    Returns
    -------
    xarray.Dataset
        With statistic ("mean", "lower", "upper": 95 % over the pairs): friction_coefficient over sliding,
        hurst_exponent, rms (µm), pressure (GPa), mu0 and tau0 (GPa); contact_area_fraction, normal_stiffness (GPa/µm,
        of each nominal area) and approach (µm) over hurst_exponent, rms and pressure. Of the laws over hurst_exponent
        and rms: area_factor (1/GPa) a, stiffness_factor b and stiffness_exponent c, and area_deviation and
        stiffness_deviation, the largest relative difference of a mean from its law.

    Raises
    ------
    ValueError
        If the dataset is of approaches or of profiles, or mu0 or tau0 is negative.

    Notes
    -----
    .. math:: A/A_0 = a\,p, \qquad k/A_0 = b\,p^c

    with p in GPa and k/A0 in GPa/µm, fitted in logarithms to the pressures at which A/A0 is at most 0.1, or to all
    where fewer than two are. The stiffness of a pair is p over the derivative of its approach with respect to ln p, by
    parabolas through neighbouring pressures, of which there must be three at least, or it is NaN. The load is the
    elastic one, before anything slides, so that area and stiffness do not depend on mu0 and tau0. The coefficient is
    mean(F_T) / mean(F_N) over pairs and directions, with the interval of a jackknife over pairs; it is NaN where
    mean(F_N) is not above 0, which is self-locking.

    Examples
    --------
    >>> from stiction import friction_table, run, table_study
    >>> study = table_study(hurst_exponents=[0.8], rms=[0.02], points=32, shortest_wavelength=0.625, repetitions=3)
    >>> friction_table(run(study))["friction_coefficient"].sizes["pressure"]
    5
    """
    import xarray

    study = study_of(dataset)
    if "load" not in dataset.dims or study.surfaces.kind != "surface":
        raise ValueError("dataset must be of a study of surfaces by the half-space, with loads")
    material = [
        np.atleast_1d(friction.friction_parameter(name, given if given is not None else own))
        for name, given, own in (
            ("mu0", mu0, [float(each) for each in study.friction.mu0]),
            ("tau0", tau0, [float(each) for each in study.friction.tau0]),
        )
    ]
    area = float(np.prod(study.surfaces.extents()))
    pressure = dataset["load"].values / area
    cells = (dataset.sizes["fractal_dimension"], dataset.sizes["amplitude"])
    # Two passes over the pairs: intervals are of what each is beside the means, and laws of where these are light.
    samples = {name: intervals.Sample((*cells, pressure.size)) for name in _OF_PAIRS}
    loads = np.zeros(())
    for piece in pieces(dataset, _NEEDED):
        loads = loads + _loads(piece, *material).sum(axis=2)
        for name, values in _of_pairs(piece, pressure, area).items():
            samples[name].add(values)
    means = {name: np.stack(sample.interval(), axis=-1) for name, sample in samples.items()}
    light = _light(means["contact_area_fraction"][..., 0])
    laws = {name: intervals.Sample(cells) for name in _LAWS}
    solved = np.ones(cells, np.bool_)
    coefficient = np.where(loads[0] > 0, _ratio(loads), np.nan)
    left_out = intervals.Powers(coefficient.shape)
    for piece in pieces(dataset, _NEEDED):
        others = _ratio(loads[:, :, np.newaxis] - _loads(piece, *material))
        left_out.add(np.moveaxis(others - coefficient[:, np.newaxis], 1, -1))
        found = _fitted(pressure, light, _of_pairs(piece, pressure, area))
        solved &= np.isfinite(found["stiffness_exponent"]).all(axis=0)
        for name, values in found.items():
            laws[name].add(values)
    half = left_out.half_width() if dataset.sizes["repetition"] >= intervals.FEWEST_OF_SAMPLE else np.nan
    ends = [coefficient, np.maximum(coefficient - half, 0.0), coefficient + half]
    statistics = ("hurst_exponent", "rms", "pressure", "statistic")
    variables: dict[str, Any] = {
        **{name: (statistics, means[name], attributes) for name, attributes in _OF_PAIRS.items()},
        "friction_coefficient": (
            ("sliding", "hurst_exponent", "rms", "pressure", "mu0", "tau0", "statistic"),
            np.stack(ends, axis=-1), attributes_of("friction_coefficient"),
        ),
    }  # fmt: skip
    fitted = {name: np.stack(sample.interval(), axis=-1) for name, sample in laws.items()}
    for name in ("stiffness_factor", "stiffness_exponent"):
        fitted[name][~solved] = np.nan
    variables |= _laws(pressure, light, means, fitted)
    return xarray.Dataset(
        variables,
        {
            "sliding": ("sliding", list(study.contact.rules()), attributes_of("sliding")),
            "hurst_exponent": ("hurst_exponent", 2 - dataset["fractal_dimension"].values, {"units": "1"}),
            "rms": ("rms", dataset["amplitude"].values, {"units": "um", "long_name": "Sq of each surface"}),
            "pressure": ("pressure", pressure, {"units": "GPa", "long_name": "normal load over nominal area"}),
            "mu0": ("mu0", material[0], attributes_of("mu0")),
            "tau0": ("tau0", material[1], attributes_of("tau0")),
            "statistic": ["mean", "lower", "upper"],
        },
        {"title": TITLE, "study": dataset.attrs["study"], "stiction_version": dataset.attrs["stiction_version"]},
    ).sortby("hurst_exponent")  # fmt: skip


_NEEDED = ("contact_area", "approach", *SIX)

_OF_PAIRS = {
    "contact_area_fraction": {"units": "1", "long_name": "true over nominal contact area"},
    "normal_stiffness": {"units": "GPa/um", "long_name": "normal stiffness of each nominal area"},
    "approach": attributes_of("approach"),
}
"""What each pair has of its own."""

_LAWS = ("area_factor", "stiffness_factor", "stiffness_exponent")


def _of_pairs(data: xarray.Dataset, pressure: Floats, area: float) -> dict[str, Floats]:
    """Each (r, fractal dimension, amplitude, load)."""
    order = ("repetition", "fractal_dimension", "amplitude", "load")
    approach = data["approach"].transpose(*order).values
    stiffness = np.full(approach.shape, np.nan)
    if pressure.size >= FEWEST_PRESSURES:
        # The approach is nearly straight over the logarithm of the load.
        stiffness = pressure / np.gradient(approach, np.log(pressure), axis=-1, edge_order=2)
    fraction = data["contact_area"].transpose(*order).values / area
    return {"contact_area_fraction": fraction, "normal_stiffness": stiffness, "approach": approach}


def _loads(data: xarray.Dataset, mu0: Floats, tau0: Floats) -> Floats:
    """Normal and tangential (2, sliding, r, fractal dimension, amplitude, load, mu0, tau0), means over directions."""
    order = ("sliding", "repetition", "fractal_dimension", "amplitude", "load")
    sums = {}
    for name in SIX:
        part = data[name]
        part = part.mean("direction") if "direction" in part.dims else part
        part = part if "sliding" in part.dims else part.expand_dims(sliding=max(1, data.sizes.get("sliding", 1)))
        sums[name] = part.transpose(*order).values
    return np.stack(loads_of(sums, mu0, tau0))


def _ratio(loads: Floats) -> Floats:
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(loads[1] / loads[0])


def _light(fraction: Floats) -> NDArray[np.bool_]:
    """Pressures that laws are fitted to, of mean shares of the area over pressure."""
    light = fraction <= LIGHT
    light[light.sum(axis=-1) < 2] = True
    return light


def _fitted(pressure: Floats, light: NDArray[np.bool_], pairs: dict[str, Floats]) -> dict[str, Floats]:
    """A of A/A0 = a p, b and c of k/A0 = b p^c, of each pair (r, fractal dimension, amplitude), NaN if none."""
    found = {name: np.full(pairs["approach"].shape[:-1], np.nan) for name in _LAWS}
    for cell in np.ndindex(*light.shape[:2]):
        place = (slice(None), *cell)
        p = pressure[light[cell]]
        shares, stiff = (pairs[name][place][:, light[cell]] for name in ("contact_area_fraction", "normal_stiffness"))
        with np.errstate(divide="ignore", invalid="ignore"):
            found["area_factor"][place] = np.exp(np.mean(np.log(shares / p), axis=1))
            logarithms = np.log(np.where(stiff > 0, stiff, np.nan))
        if p.size >= 2:
            offset = np.log(p) - np.log(p).mean()
            exponent = logarithms @ offset / (offset @ offset)
            found["stiffness_exponent"][place] = exponent
            found["stiffness_factor"][place] = np.exp(logarithms.mean(axis=1) - exponent * np.log(p).mean())
    return found


def _laws(
    pressure: Floats, light: NDArray[np.bool_], means: dict[str, Floats], values: dict[str, Floats]
) -> dict[str, Any]:
    """The laws as variables, and how far the means are off them."""
    of = {name: each[..., :1] for name, each in values.items()}
    laws = {
        "area": (of["area_factor"] * pressure, "contact_area_fraction"),
        "stiffness": (of["stiffness_factor"] * pressure ** of["stiffness_exponent"], "normal_stiffness"),
    }
    off = {
        f"{name}_deviation": np.where(light, np.abs(means[of_pairs][..., 0] / law - 1), 0.0).max(axis=-1)
        for name, (law, of_pairs) in laws.items()
    }
    words = {
        "area_factor": ("1/GPa", "a of A/A0 = a p"),
        "stiffness_factor": ("GPa/um/GPa^c", "b of k/A0 = b p^c"),
        "stiffness_exponent": ("1", "c of k/A0 = b p^c"),
        "area_deviation": ("1", "largest relative difference from A/A0 = a p"),
        "stiffness_deviation": ("1", "largest relative difference from k/A0 = b p^c"),
    }
    return {
        name: (
            ("hurst_exponent", "rms", "statistic") if array.ndim == 3 else ("hurst_exponent", "rms"),
            array,
            {"units": words[name][0], "long_name": words[name][1]},
        )
        for name, array in (values | off).items()
    }
