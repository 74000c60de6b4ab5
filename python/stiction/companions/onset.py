"""Onset of sliding of a measured pair: tangential load against displacement, averaged over a few members.

The stored curve is computed for contacts whose pressure is limited by the hardness, without junction growth and without
the closed-form area of yielding contacts. Reported curves are therefore scaled to the sliding load μ_s F of the result.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from stiction._checks import Floats
from stiction._errors import NoSolutionError
from stiction._estimate import Estimate
from stiction.companions.contact_picture import MAX_PICTURE_SIDE_POINTS
from stiction.evaluate.member_means import MemberDependence
from stiction.evaluate.point import read_estimate
from stiction.mechanics.half_space import HalfSpaceCurve
from stiction.mechanics.half_space_problem import has_finite_approach
from stiction.mechanics.onset import DEFAULT_POISSON_RATIO
from stiction.mechanics.presliding import fit_iwan, fit_lugre
from stiction.mechanics.quantities import QUANTITIES, quantity_attributes
from stiction.solve.executors import wrap_to_use_idle_threads
from stiction.solve.member_solution import PressedPair, estimate_solution_time
from stiction.solve.store import ONSET_FILE, read_companion_file
from stiction.study.members import count_grid_points, read_measured_bodies
from stiction.study.stored_values import STORED_VALUE_BOUNDS, AttributeSpec, VariableSpec
from stiction.study.study import Study
from stiction.surfaces.surface import Surface

if TYPE_CHECKING:
    import xarray

    from stiction.mechanics.onset import Onset
    from stiction.solve.store import StoredResult

ONSET_TABLE_SIGNATURE = b"fraction of the sliding load,"
NUM_ONSET_MEMBERS, NUM_ONSET_MEMBERS_FOR_MAPS = 16, 4
"""Default numbers of members for the onset of sliding: 16 in general, and 4 for maps in the half-space model."""


ONSET_TO_SOLUTION_TIME_RATIO = 8

ONSET_LOAD_FRACTIONS = (0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 1.0)
"""Tangential loads of the onset curve, as fractions of the sliding load."""

# Relative tolerance of the tangential tractions; it causes a relative error of displacements of about 1e-7.
TRACTION_TOLERANCE = 1e-5
_CURVE_TITLES = {
    "tangential_load": "tangential load",
    "displacement": "displacement",
    "slipped_area": "slipped area",
    "slipped_load": "slipped load",
    "energy_lost": "energy lost",
}
"""Column titles in `ONSET_TABLE_FILE`, by quantity of the onset curve."""

_ONSET_SCALAR_NAMES = ("sliding_load", "displacement_at_sliding", "stiffness", "unloading_stiffness")
_STATISTIC_NAMES = ["mean", "lower", "upper"]


def import_fit_packages(study: Study) -> None:
    """Import the packages for fits of presliding models, so that a later fit does not wait for the import.

    Nothing is imported for a free half-plane, because an onset curve without displacements is not fitted.
    """
    contact: Any = study.contact
    num_dimensions = 2 if study.is_areal else 1
    if not study.uses_half_space or has_finite_approach(num_dimensions, periodic=contact.boundary == "periodic"):
        import scipy.optimize  # noqa: F401


def compute_onset(
    study: Study, executor: Executor, *, members: int | None = None, load: float | None = None
) -> xarray.Dataset | None:
    """Compute the onset of sliding of a measured pair at one normal load (mN), averaged over a few members.

    By default, the normal load is the first load of the study, and the members are the first 16 members (4 for maps in
    the half-space model). The dataset has the dimensions `fraction` (of the sliding load) and `statistic`. It also
    contains the slip map of the first member, and the parameters of Iwan and LuGre models of the mean curve. Returns
    None for generated bodies, for a pair without friction, or if the solver fails for all members.
    """
    indices = _find_onset_members(study, members)
    if not indices:
        return None
    mu0, tau0 = float(study.friction.mu0[0]), float(study.friction.tau0[0])
    load = float(study.friction.load[0]) if load is None else load
    surfaces: Any = study.surfaces
    compute_curve: Any = partial(
        compute_member_onset, study, load=load, mu0=mu0, tau0=tau0, cut_off=surfaces.reported_cut_off()
    )
    compute_curve = wrap_to_use_idle_threads(compute_curve, executor, len(indices), count_grid_points(study))
    curves = [curve for curve in executor.map(compute_curve, indices) if curve]
    if not curves:
        return None
    onset = _average_onset_curves(study, curves, {"load_mN": load, "mu0": mu0, "tau0_GPa": tau0})
    return onset.assign(curves[0]["map"])


def _find_onset_members(study: Study, count: int | None) -> range:
    """Return the indices of the members (pairs of bodies) for which the onset of sliding is computed.

    The range is empty for generated bodies, and for mu0 = tau0 = 0.
    """
    surfaces: Any = study.surfaces
    if not study.is_measured or float(study.friction.mu0[0]) == float(study.friction.tau0[0]) == 0:
        return range(0)
    first_index = surfaces.first_scan_member_index
    first_index = first_index if first_index < study.ensemble.repetitions else 0
    is_slow = surfaces.is_areal and study.uses_half_space
    num_members = (NUM_ONSET_MEMBERS_FOR_MAPS if is_slow else NUM_ONSET_MEMBERS) if count is None else count
    return range(first_index, min(first_index + num_members, study.ensemble.repetitions))


def estimate_onset_time(study: Study, members: int | None = None) -> float:
    """Estimate the computing time (s) of `compute_onset` on one core.

    The time is 0 in the asperity model.
    """
    if not study.uses_half_space:
        return 0.0
    return len(_find_onset_members(study, members)) * ONSET_TO_SOLUTION_TIME_RATIO * estimate_solution_time(study)


def compute_member_onset(
    study: Study, index: int, *, load: float, mu0: float, tau0: float, cut_off: float
) -> dict[str, Any] | None:
    """Compute onset curve and slip map of one member at a normal load (mN).

    Returns None if the solver fails.
    """
    member = read_measured_bodies(study).member(index, cut_off)
    poisson = study.contact.poisson or (DEFAULT_POISSON_RATIO, DEFAULT_POISSON_RATIO)
    try:
        pressed_pair = PressedPair.solve(study, member.pair, load)
        if pressed_pair is None:
            return None
        options: dict[str, Any] = (
            {"tolerance": TRACTION_TOLERANCE} if isinstance(pressed_pair.curve, HalfSpaceCurve) else {}
        )
        onset = pressed_pair.curve.onset(0, mu0=mu0, tau0=tau0, steps=ONSET_LOAD_FRACTIONS, poisson=poisson, **options)
    # The onset curve is missing if the solver failed, or if the contact law does not describe the onset of sliding.
    except (NoSolutionError, ValueError):
        return None
    curve: dict[str, Any] = {
        name: getattr(onset, name) for name in (*_CURVE_TITLES, *_ONSET_SCALAR_NAMES[:-1]) if name != "energy_lost"
    }  # fmt: skip
    curve["unloading_stiffness"] = float(np.ravel(getattr(pressed_pair.curve, "unloading_stiffness", np.nan))[0])
    return curve | {
        "energy_lost": onset.energy_lost(onset.tangential_load), "line": member.line, "x": member.x, "y": member.y,
        "repetition": index, "map": build_slip_map(pressed_pair, onset),
    }  # fmt: skip


# ---- Means over members ----------------------------------------------------------------------------------------------


def _average_onset_curves(study: Study, curves: Sequence[dict[str, Any]], attributes: dict[str, Any]) -> xarray.Dataset:
    import xarray

    member_dependence = MemberDependence.from_coordinates(
        study, {name: [curve[name] for curve in curves] for name in ("line", "x", "y", "repetition")}
    )
    variables: dict[str, Any] = {}
    for name in (*_CURVE_TITLES, *_ONSET_SCALAR_NAMES):
        dims = ("fraction", "statistic") if name in _CURVE_TITLES else ("statistic",)
        values = np.clip(
            member_dependence.mean_with_interval(np.array([curve[name] for curve in curves])), *QUANTITIES[name].bounds
        )
        variables[name] = (dims, values, quantity_attributes(name))
    # The usual `long_name` describes the sliding load only, but the curve also contains loads below the sliding load.
    variables["tangential_load"][2]["long_name"] = "tangential load"
    coordinates: dict[str, Any] = {
        "fraction": (
            "fraction",
            list(ONSET_LOAD_FRACTIONS),
            {"units": "1", "long_name": "ratio of tangential load to sliding load"},
        ),
        "statistic": _STATISTIC_NAMES,
    }
    poisson_ratios = study.contact.poisson
    attributes = attributes | {
        "members": len(curves), "mechanics": study.contact.mechanics,
        "poisson_ratio": np.array(poisson_ratios or (DEFAULT_POISSON_RATIO, DEFAULT_POISSON_RATIO)),
        "poisson_given": int(poisson_ratios is not None),
    }  # fmt: skip
    dataset = xarray.Dataset(variables, coordinates, {"title": "onset of sliding", **attributes})
    return dataset.assign_attrs(_fit_presliding_models(dataset))


PRESLIDING_PARAMETERS = {
    "iwan": ("sliding_load_mN", "stiffness_mN_per_um", "chi", "beta", "largest_residual"),
    "lugre": ("sigma0_mN_per_um", "largest_residual"),
}
"""Names of the fitted parameters of the Iwan and LuGre models, by model.

The dataset of the onset stores the parameters as attributes, such as "iwan_chi".
"""


def _fit_presliding_models(onset: xarray.Dataset) -> dict[str, float]:
    """Fit the Iwan and the LuGre model to the mean onset curve, and return their parameters by attribute name."""
    curve = onset.sel(statistic="mean")
    displacement, load = (np.asarray(curve[name].values) for name in ("displacement", "tangential_load"))
    sliding_load = float(curve["sliding_load"])
    try:
        iwan = fit_iwan(displacement, load, sliding_load=sliding_load, stiffness=float(curve["stiffness"]))
        lugre = fit_lugre(displacement, load, sliding_load=sliding_load)
    except ValueError:
        # On a half-plane that is not periodic, displacements are undefined, so no presliding model can be fitted.
        return {}
    # Adding 0.0 turns -0 into 0.
    chi = round(iwan.chi, 12) + 0.0
    parameters_by_model = {
        "iwan": (sliding_load, iwan.stiffness, chi, iwan.beta, float(np.abs(iwan.residual).max() / sliding_load)),
        "lugre": (lugre.stiffness, float(np.abs(lugre.residual).max() / sliding_load)),
    }
    return {
        f"{model}_{name}": value
        for model, names in PRESLIDING_PARAMETERS.items()
        for name, value in zip(names, parameters_by_model[model], strict=True)
    }


# ---- Values to report ------------------------------------------------------------------------------------------------

_MODEL_FORCE_PARAMETERS = ("iwan_sliding_load_mN",)
"""Parameters of the fitted presliding models that are proportional to the sliding load."""


def scale_onset(onset: xarray.Dataset, coefficient: Estimate) -> xarray.Dataset:
    """Scale a computed onset curve to the sliding load μ_s F, where μ_s is `coefficient` and F the normal load.

    The sliding load and its interval are the coefficient and its interval times F. The tangential loads of the curve
    are fractions of this sliding load. As in the solution of Cattaneo and Mindlin, the displacements at equal fractions
    are proportional to the sliding load: they, and the sliding load of the fitted models, are multiplied by the same
    factor as the mean sliding load, and energies by its square. Stiffnesses and slipping fractions are not changed.

    Parameters
    ----------
    onset : xarray.Dataset
        Dataset that `compute_onset` returned.
    coefficient : Estimate
        Coefficient of static friction at the load, mu0 and tau0 of the onset with friction at all contacts.
    """
    limits = [coefficient.value, coefficient.lower, coefficient.upper]
    sliding_load = onset["sliding_load"].copy(data=float(onset.attrs["load_mN"]) * np.array(limits))
    factor = coefficient.value * float(onset.attrs["load_mN"]) / float(onset["sliding_load"].sel(statistic="mean"))
    tangential_load = onset["tangential_load"].copy(data=np.outer(onset["fraction"].values, sliding_load.values))
    multiplied = {"displacement": factor, "displacement_at_sliding": factor, "energy_lost": factor**2}
    variables = {name: onset[name].copy(data=factor * onset[name].values) for name, factor in multiplied.items()}
    variables |= {"sliding_load": sliding_load, "tangential_load": tangential_load}
    scaled_onset = onset.assign(variables)
    forces = {name: factor * float(onset.attrs[name]) for name in _MODEL_FORCE_PARAMETERS if name in onset.attrs}
    return scaled_onset.assign_attrs({_LOAD_INTERVAL_KIND_ATTRIBUTE: coefficient.kind, **forces})


_LOAD_INTERVAL_KIND_ATTRIBUTE = "load_interval_kind"
"""Name of the dataset attribute that states the interval kind of the tangential loads in a scaled onset."""


@dataclass(frozen=True)
class OnsetCurvePoint:
    """Point of the mean onset curve: displacement, slip and dissipated energy at one tangential load."""

    tangential_load: Estimate  # mN
    displacement: Estimate  # µm
    slipped_area: Estimate
    slipped_load: Estimate
    energy_lost: Estimate  # mN µm, in a load cycle


@dataclass(frozen=True)
class OnsetSummary:
    """Onset of sliding at one normal load, mu0 and tau0: means over members with 95 % intervals.

    If the onset was scaled to the coefficient of static friction, tangential loads have the combined interval of this
    coefficient.
    """

    load: float  # normal load, mN
    mu0: float
    tau0: float  # GPa
    num_members: int
    poisson_ratio: tuple[float, ...]  # of both bodies
    is_poisson_ratio_given: bool
    sliding_load: Estimate  # tangential load, mN
    displacement_at_sliding: Estimate  # µm
    stiffness: Estimate  # mN/µm
    unloading_stiffness: Estimate  # mN/µm
    # Points of the onset curve, keyed by the ratio of the tangential load to the sliding load.
    curve: dict[float, OnsetCurvePoint]
    models: dict[str, dict[str, float]]


def read_onset_summary(onset: xarray.Dataset) -> OnsetSummary:
    """Read the mean onset of sliding, with intervals, from a dataset that `compute_onset` or `scale_onset` returned."""
    attributes = onset.attrs

    def read(table: xarray.DataArray) -> Estimate:
        estimate = read_estimate(table)
        is_load = table.name in ("sliding_load", "tangential_load")
        return (
            replace(estimate, kind=attributes.get(_LOAD_INTERVAL_KIND_ATTRIBUTE, estimate.kind))
            if is_load
            else estimate
        )

    curve = {}
    for fraction in onset["fraction"].values.tolist():
        curve_point = onset.sel(fraction=fraction)
        curve[fraction] = OnsetCurvePoint(**{name: read(curve_point[name]) for name in _CURVE_TITLES})
    models = {
        model: {name: float(attributes[f"{model}_{name}"]) for name in names if f"{model}_{name}" in attributes}
        for model, names in PRESLIDING_PARAMETERS.items()
    }
    return OnsetSummary(
        load=float(attributes["load_mN"]),
        mu0=float(attributes["mu0"]),
        tau0=float(attributes["tau0_GPa"]),
        num_members=int(attributes["members"]),
        poisson_ratio=tuple(np.ravel(attributes["poisson_ratio"]).astype(float).tolist()),
        is_poisson_ratio_given=bool(attributes.get("poisson_given", 1)),
        **{name: read(onset[name]) for name in _ONSET_SCALAR_NAMES},
        curve=curve,
        models=models,
    )


# ---- Files stored with a result -------------------------------------------------------------------------------------

_BOUNDS_THAT_INCLUDE_INFINITY = (-math.inf, math.inf)

_ONSET_VARIABLE_SPECS: dict[str, VariableSpec] = {
    "fraction": VariableSpec(dims=("fraction",)),
    "statistic": VariableSpec(dims=("statistic",), dtype=str),
    **{
        name: VariableSpec(
            dims=("statistic",),
            bounds=_BOUNDS_THAT_INCLUDE_INFINITY,
            may_be_nan=True,
            is_required=name != _ONSET_SCALAR_NAMES[-1],
        )
        for name in _ONSET_SCALAR_NAMES
    },
    **{
        name: VariableSpec(dims=("fraction", "statistic"), bounds=_BOUNDS_THAT_INCLUDE_INFINITY, may_be_nan=True)
        for name in _CURVE_TITLES
    },
    **{name: VariableSpec(dims=(name,), is_required=False, ascending_dim=name) for name in ("slip_y", "slip_x")},
    **{
        name: VariableSpec(dims=("slip_y", "slip_x"), may_be_nan=True, is_required=False)
        for name in ("lower_height", "slip")
    },
    **{
        f"contact_{name}": VariableSpec(dims=("contact",), may_be_nan=True, is_required=False)
        for name in ("slip", "x", "y", "area")
    },
}
"""Specifications of the variables in `ONSET_FILE`.

The variables of a slip map are optional, because profiles lack them.
"""

_ONSET_ATTRIBUTE_SPECS: dict[str, AttributeSpec] = {
    "load_mN": AttributeSpec(),
    "mu0": AttributeSpec(),
    "tau0_GPa": AttributeSpec(),
    "members": AttributeSpec(dtype=int, bounds=(1, STORED_VALUE_BOUNDS[1])),
    "poisson_ratio": AttributeSpec(sizes=(2,)),
    "poisson_given": AttributeSpec(dtype=int, is_required=False),
    **{
        f"{model}_{name}": AttributeSpec(is_required=False)
        for model, names in PRESLIDING_PARAMETERS.items()
        for name in names
    },
}


def load_stored_onset(result: StoredResult) -> xarray.Dataset | None:
    """Load the onset of sliding that is stored with a result.

    Returns None if no onset is stored, or if the normal load, mu0 or tau0 of the stored onset differ from the study.
    Raises a `StoreError` if the file is damaged.
    """
    if not result.study.is_measured:
        return None
    settings = result.study.friction
    onset = read_companion_file(Path(result.path) / ONSET_FILE, _ONSET_VARIABLE_SPECS, _ONSET_ATTRIBUTE_SPECS)
    if (
        onset is None
        or _ONSET_SCALAR_NAMES[-1] not in onset
        or onset["fraction"].values.tolist() != list(ONSET_LOAD_FRACTIONS)
        or onset["statistic"].values.tolist() != _STATISTIC_NAMES
    ):
        return None
    conditions = [float(onset.attrs[name]) for name in ("load_mN", "mu0", "tau0_GPa")]
    return (
        onset if conditions == [float(values[0]) for values in (settings.load, settings.mu0, settings.tau0)] else None
    )


def format_backbone_csv(onset: xarray.Dataset) -> str:
    """Return the mean onset curve as CSV text with units.

    The curve is the backbone curve of a Masing model.
    """
    import pandas

    columns: dict[str, Any] = {"fraction of the sliding load": [0.0, *onset["fraction"].values]}
    for name, quantity_title in _CURVE_TITLES.items():
        unit = QUANTITIES[name].unit
        title = quantity_title + ("" if unit == "1" else f" ({unit})")
        for statistic_name, suffix in (("mean", ""), ("lower", ": lower"), ("upper", ": upper")):
            columns[title + suffix] = [0.0, *onset[name].sel(statistic=statistic_name).values]
    text: str = pandas.DataFrame(columns).to_csv(index=False, float_format="%.9g")
    return text


# ---- Slip map --------------------------------------------------------------------------------------------------------


DatasetVariables = dict[str, tuple[Any, ...]]
_MICROMETRE_ATTRIBUTES = {"units": "um"}


def build_slip_map(pressed_pair: PressedPair, onset: Onset) -> DatasetVariables:
    """Return a map of the tangential load at which each grid point starts to slip, as a fraction of the sliding load.

    In the asperity model, each contact has such a load instead of each grid point. The variables include the heights of
    the lower body. In large maps, each block of neighbouring points is represented by the point that slips first. For
    profiles, the dictionary is empty.
    """
    lower = pressed_pair.lower
    if not isinstance(lower, Surface):
        return {}
    (rows, columns), (dy, dx) = lower.heights.shape, lower.spacing
    stride = -(-max(rows, columns) // MAX_PICTURE_SIDE_POINTS)
    variables: DatasetVariables = {
        "slip_y": ("slip_y", np.arange(0, rows, stride) * dy, _MICROMETRE_ATTRIBUTES),
        "slip_x": ("slip_x", np.arange(0, columns, stride) * dx, _MICROMETRE_ATTRIBUTES),
        "lower_height": (
            ("slip_y", "slip_x"),
            lower.heights[::stride, ::stride].astype(np.float32),
            _MICROMETRE_ATTRIBUTES,
        ),
    }
    slip_fraction = onset.slip_load() / onset.sliding_load
    if isinstance(pressed_pair.curve, HalfSpaceCurve):
        attributes = {"units": "1", "long_name": "ratio of tangential to sliding load at which a point slips"}
        slip_start = _find_block_minima(slip_fraction.reshape(rows, columns), stride)
        return variables | {"slip": (("slip_y", "slip_x"), slip_start.astype(np.float32), attributes)}
    table = pressed_pair.tabulate_contacts()
    contact_variables = {
        "slip": (slip_fraction, "1", "ratio of tangential to sliding load at which a contact slides as a whole"),
        "x": (table.x, "um", "middle of a contact along x"),
        "y": (table.y, "um", "middle of a contact along y"),
        "area": (table.area, "um^2", "area of a contact"),
    }
    return variables | {
        f"contact_{name}": ("contact", values, {"units": unit, "long_name": attributes})
        for name, (values, unit, attributes) in contact_variables.items()
    }


def _find_block_minima(values: Floats, block_size: int) -> Floats:
    """Return the minimum of each square block of a map, ignoring NaN in blocks that also contain numbers."""
    rows, columns = (-(-size // block_size) * block_size for size in values.shape)
    padded_map = np.full((rows, columns), np.inf)
    padded_map[: values.shape[0], : values.shape[1]] = np.where(np.isnan(values), np.inf, values)
    minima = padded_map.reshape(rows // block_size, block_size, columns // block_size, block_size).min(axis=(1, 3))
    return np.where(np.isinf(minima), np.nan, minima)
