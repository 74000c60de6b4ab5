"""Friction tables for other programs: friction, true area and stiffness of self-affine surfaces."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiction._checks import Floats, float_array, validate_number
from stiction._units import VALID_QUANTITY_RANGES, exact_quantity, short_repr
from stiction.evaluate import intervals
from stiction.evaluate.ensemble_means import compute_ensemble_friction
from stiction.evaluate.maps import choose_mu0_and_tau0
from stiction.mechanics.friction import validate_friction_parameter
from stiction.mechanics.quantities import STIFFNESS_PER_AREA_FACTOR, STIFFNESS_PER_AREA_UNIT, quantity_attributes
from stiction.study.study import Study
from stiction.study.values import validate_section
from stiction.summary.evaluation import Evaluation
from stiction.summary.summary import assess_coefficients

if TYPE_CHECKING:
    import xarray

FRICTION_TABLE_TITLE = "stiction table"
MIN_NUM_PRESSURES_FOR_STIFFNESS = 3
AVERAGED_DIRECTIONS = (0.0, 90.0, 180.0, 270.0)  # degrees
MAX_FITTED_AREA_FRACTION = 0.1
MAX_DEVIATION_FROM_FITTED_LAW = 0.1
_DIMENSION_ORDER = ("repetition", "fractal_dimension", "amplitude", "load")


def table_study(
    *,
    hurst_exponents: Sequence[float] = (0.5, 0.7, 0.9),
    rms: Sequence[float] = (0.01, 0.03, 0.1),
    pressures: Sequence[float] = (0.001, 0.003, 0.01, 0.03, 0.1),
    mu0: Sequence[float] = (0.2, 0.4, 0.6),
    tau0: Sequence[float] = (0.0,),
    effective_modulus: float = 10.0,
    hardness: str | float | None = None,
    extent: float = 10.0,
    points: int = 256,
    longest_wavelength: float = 2.5,
    shortest_wavelength: float = 0.3125,
    repetitions: int = 12,
    seed: int = 2016,
) -> Study:
    """Create the study for a friction table: self-affine surfaces in periodic contact, with the half-space model.

    Parameters
    ----------
    hurst_exponents : (h,) sequence of float
        Hurst exponents, above 0 and at most 1.
    rms : (r,) sequence of float, µm
        Root-mean-square height Sq of each of the two surfaces.
    pressures : (p,) sequence of float, GPa
        Loads divided by the nominal area.
    mu0 : (m,) sequence of float
        Molecular friction coefficients.
    tau0 : (t,) sequence of float, GPa
        Adhesive shear strengths.
    effective_modulus : float, GPa
        E*; see `effective_modulus`.
    hardness : str or float, GPa, optional
        Hardness of the softer body, which limits the pressure. By default, the bodies are elastic.
    extent : float, µm
        Side of the square nominal area, and period of the surfaces.
    points : int
        Number of grid points along each side.
    longest_wavelength, shortest_wavelength : float, µm
        Roll-off and cutoff wavelength. If a side has at least four times the roll-off wavelength, the table does not
        depend much on the side.
    repetitions : int
        Number of pairs of surfaces.
    seed : int
        Seed of the random surfaces.

    Returns
    -------
    study : Study
        Study for `run`, whose result is the argument of `friction_table`.

    Raises
    ------
    ValueError
        If an argument has an impossible value; `StudyError` if the study cannot be computed.

    See Also
    --------
    friction_table : Table of the result.

    Examples
    --------
    >>> from stiction import table_study
    >>> table_study(rms=[0.02]).surfaces.amplitudes()
    array([0.02])
    """
    exponents = _require_positive_values("hurst_exponents", hurst_exponents)
    if not all(exponent <= 1 for exponent in exponents):
        raise ValueError(f"hurst_exponents must be above 0 and at most 1, got {short_repr(hurst_exponents)}")
    max_length = VALID_QUANTITY_RANGES["length"][1]
    lengths = {"extent": extent, "longest_wavelength": longest_wavelength, "shortest_wavelength": shortest_wavelength}
    extent, longest_wavelength, shortest_wavelength = (
        validate_number(name, value, unit="µm", above=0, below=max_length) for name, value in lengths.items()
    )
    effective_modulus = validate_number("effective_modulus", effective_modulus, unit="GPa", above=0)
    area = extent**2
    return validate_section(
        Study,
        {
            "surfaces": {
                "kind": "surface", "generator": "self-affine",
                "fractal_dimension": sorted(2 - exponent for exponent in exponents),
                "amplitude": [exact_quantity(height, "um") for height in _require_positive_values("rms", rms)],
                "amplitude_measure": "Sq",
                "longest_wavelength": exact_quantity(longest_wavelength, "um"),
                "shortest_wavelength": exact_quantity(shortest_wavelength, "um"), "shape": [points, points],
                "extent": [exact_quantity(extent, "um")] * 2,
            },
            "contact": {
                "mechanics": "half-space", "boundary": "periodic",
                "effective_modulus": exact_quantity(effective_modulus, "GPa"),
                **({} if hardness is None else {"hardness": _to_hardness_entry(hardness)}),
                "direction": list(AVERAGED_DIRECTIONS), "sliding": ["opposing", "all"],
                "load": [
                    exact_quantity(pressure * area, "mN")
                    for pressure in sorted(_require_positive_values("pressures", pressures))
                ],
            },
            "friction": {
                "mu0": validate_friction_parameter("mu0", mu0).reshape(-1).tolist(),
                "tau0": [
                    exact_quantity(value, "GPa") for value in validate_friction_parameter("tau0", tau0).reshape(-1)
                ],
            },
            "ensemble": {"repetitions": repetitions, "seed": seed},
        },
        "table_study",
    )  # fmt: skip


def _to_hardness_entry(hardness: str | float) -> Any:
    if isinstance(hardness, str):
        return hardness
    return exact_quantity(validate_number("hardness", hardness, unit="GPa", above=0), "GPa")


def _require_positive_values(name: str, values: ArrayLike) -> list[float]:
    """Convert an argument to a list of numbers; raise a `ValueError` if a number is 0, negative or NaN."""
    array = np.atleast_1d(float_array(name, values))
    if array.ndim != 1 or not array.size or not (array > 0).all():
        raise ValueError(f"{name} must be numbers above 0, got {short_repr(values)}")
    return [float(value) for value in array]


def friction_table(
    result: Evaluation | xarray.Dataset, *, mu0: ArrayLike | None = None, tau0: ArrayLike | None = None
) -> xarray.Dataset:
    r"""Compute friction, true area and stiffness as functions of pressure, and fit laws to true area and stiffness.

    Parameters
    ----------
    result : Result, or xarray.Dataset of member sums
        Result of a study of `table_study`, or of any study of generated surfaces with the half-space model.
    mu0 : (m,) array_like of float, optional
    tau0 : (t,) array_like of float, GPa, optional
        By default the values in the study.

    Returns
    -------
    xarray.Dataset
        friction_coefficient has the dimensions sliding, hurst_exponent, rms (µm), pressure (GPa), mu0 and tau0 (GPa).
        contact_area_fraction, normal_stiffness (MPa/mm, per nominal area) and approach (µm) have the dimensions
        hurst_exponent, rms and pressure. The parameters of the laws have the dimensions hurst_exponent and rms:
        area_factor a (1/GPa), stiffness_factor b, stiffness_exponent c, and the largest relative differences of means
        from the laws, area_deviation and stiffness_deviation. All have the dimension statistic ("mean", "lower",
        "upper"), with 95 % intervals over the pairs. assessment has the dimensions of friction_coefficient and states
        whether a coefficient may be quoted: "Quote it", "Quote with care" or "Do not quote".

    Raises
    ------
    ValueError
        If the result has approaches instead of loads, or profiles, or if mu0 or tau0 is negative.

    Notes
    -----
    .. math:: A/A_0 = a\,p, \qquad k/A_0 = b\,p^c

    with p in GPa and k/A0 in MPa/mm. The laws are fitted to logarithms at pressures with A/A0 of at most 0.1, or at all
    pressures if there are fewer than two of these. The stiffness of a pair is p divided by the derivative of its
    approach with respect to ln p, from parabolas through neighbouring pressures; it is NaN for fewer than three
    pressures. The load is the elastic load before sliding, so that area and stiffness do not depend on mu0 and tau0.
    The coefficient is mean(F_T) / mean(F_N) over pairs and directions, with a jackknife interval over pairs. It is NaN
    if mean(F_N) is not above 0, which is self-locking.

    Examples
    --------
    >>> from stiction import friction_table, run, table_study
    >>> study = table_study(hurst_exponents=[0.8], rms=[0.02], points=32, shortest_wavelength=0.625, repetitions=3)
    >>> friction_table(run(study))["friction_coefficient"].sizes["pressure"]
    5
    """
    import xarray

    evaluation = Evaluation.of(result)
    dataset, study = evaluation.dataset, evaluation.study
    if "load" not in dataset.dims or study.surfaces.kind != "surface":
        raise ValueError("result must be from a study of generated height maps with the half-space model")
    strengths = choose_mu0_and_tau0(evaluation, mu0, tau0)
    area = evaluation.nominal_area
    assert area is not None
    pressure_steps = dataset["load"].values / area
    approach, touching_area = (
        dataset[name].transpose(*_DIMENSION_ORDER).values for name in ("approach", "contact_area")
    )
    stiffness = np.full(approach.shape, np.nan)
    if pressure_steps.size >= MIN_NUM_PRESSURES_FOR_STIFFNESS:
        # The approach is nearly linear in ln(load), so it is differentiated with respect to ln(load).
        approach_derivative = np.gradient(approach, np.log(pressure_steps), axis=-1, edge_order=2)
        stiffness = STIFFNESS_PER_AREA_FACTOR * pressure_steps / approach_derivative
    requested_loads = [float(load) for load in study.friction.load] or dataset["load"].values
    indices = np.flatnonzero(np.isin(dataset["load"].values, requested_loads))
    dataset, pressure = dataset.isel(load=indices), pressure_steps[indices]
    approach, touching_area, stiffness = (values[..., indices] for values in (approach, touching_area, stiffness))
    values_of_pairs = {
        "contact_area_fraction": touching_area / area,
        "normal_stiffness": stiffness,
        "approach": approach,
    }
    means = {
        name: np.stack(intervals.average_independent_values(values), axis=-1)
        for name, values in values_of_pairs.items()
    }
    is_light_load = means["contact_area_fraction"][..., 0] <= MAX_FITTED_AREA_FRACTION
    is_light_load[is_light_load.sum(axis=-1) < 2] = True
    coefficient = compute_ensemble_friction(dataset, dataset["load"].values, *strengths)
    at = evaluation.at(dataset["load"].values, mu0=strengths[0], tau0=strengths[1], load_definition="elastic")
    assessment = assess_coefficients(at, study).transpose("sliding", *_DIMENSION_ORDER[1:], "mu0", "tau0")
    law_parameters = _fit_area_and_stiffness_laws(pressure, is_light_load, values_of_pairs)
    area_factor, stiffness_factor, exponent = (values[..., :1] for values in law_parameters.values())
    fitted_laws = {
        "area": (area_factor * pressure, "contact_area_fraction"),
        "stiffness": (stiffness_factor * pressure**exponent, "normal_stiffness"),
    }
    coordinate_names = ("hurst_exponent", "rms")
    variables: dict[str, Any] = {
        **{
            name: ((*coordinate_names, "pressure", "statistic"), values, quantity_attributes(name))
            for name, values in means.items()
        },
        "friction_coefficient": (
            ("sliding", *coordinate_names, "pressure", "mu0", "tau0", "statistic"),
            coefficient.transpose("sliding", *_DIMENSION_ORDER[1:], "mu0", "tau0", "statistic").values,
            coefficient.attrs,
        ),
        "assessment": (
            ("sliding", *coordinate_names, "pressure", "mu0", "tau0"),
            assessment.values,
            {"long_name": "assessment of the friction coefficient"},
        ),
        **{
            name: ((*coordinate_names, "statistic"), values, quantity_attributes(name))
            for name, values in law_parameters.items()
        },
    }  # fmt: skip
    for name, (law, variable) in fitted_laws.items():
        deviation = np.where(is_light_load, np.abs(means[variable][..., 0] / law - 1), 0.0).max(axis=-1)
        variables[f"{name}_deviation"] = (coordinate_names, deviation, quantity_attributes(f"{name}_deviation"))
    coordinate_values = {
        "sliding": list(study.contact.sliding_rules()), "hurst_exponent": 2 - dataset["fractal_dimension"].values,
        "rms": dataset["amplitude"].values, "pressure": pressure, "mu0": strengths[0], "tau0": strengths[1],
    }  # fmt: skip
    coordinates = {name: (name, values, quantity_attributes(name)) for name, values in coordinate_values.items()}
    attributes = {
        "title": FRICTION_TABLE_TITLE,
        **{name: dataset.attrs[name] for name in ("study", "stiction_version")},
    }
    table = xarray.Dataset(variables, coordinates | {"statistic": ["mean", "lower", "upper"]}, attributes)
    table["pressure"].attrs["long_name"] = "normal load over nominal area"
    table["normal_stiffness"].attrs = {
        "units": STIFFNESS_PER_AREA_UNIT, "long_name": "normal stiffness per nominal area",
    }  # fmt: skip
    return table.sortby("hurst_exponent")


def _fit_area_and_stiffness_laws(
    pressure: Floats, is_light_load: NDArray[np.bool_], values_of_pairs: dict[str, Floats]
) -> dict[str, Floats]:
    """Fit the laws A/A0 = a p (true area) and k/A0 = b p^c (stiffness); return a, b and c with 95 % intervals.

    Each parameter has the shape (fractal dimension, amplitude, 3). The parameters are NaN if a pair of surfaces has no
    area or no stiffness.
    """
    names = ("area_factor", "stiffness_factor", "stiffness_exponent")
    parameters = {name: np.full(values_of_pairs["approach"].shape[:-1], np.nan) for name in names}
    for cell in np.ndindex(*is_light_load.shape[:2]):
        cell_index = (slice(None), *cell)
        p = pressure[is_light_load[cell]]
        area_fractions, stiffnesses = (
            values_of_pairs[name][cell_index][:, is_light_load[cell]]
            for name in ("contact_area_fraction", "normal_stiffness")
        )
        with np.errstate(divide="ignore", invalid="ignore"):
            parameters["area_factor"][cell_index] = np.exp(np.mean(np.log(area_fractions / p), axis=1))
            log_stiffness = np.log(np.where(stiffnesses > 0, stiffnesses, np.nan))
        if p.size >= 2:
            centred_logarithms = np.log(p) - np.log(p).mean()
            exponent = log_stiffness @ centred_logarithms / (centred_logarithms @ centred_logarithms)
            parameters["stiffness_exponent"][cell_index] = exponent
            parameters["stiffness_factor"][cell_index] = np.exp(
                log_stiffness.mean(axis=1) - exponent * np.log(p).mean()
            )
    fitted_laws = {
        name: np.stack(intervals.average_independent_values(values), axis=-1) for name, values in parameters.items()
    }
    for name in names[1:]:
        fitted_laws[name][~np.isfinite(parameters["stiffness_exponent"]).all(axis=0)] = np.nan
    return fitted_laws
