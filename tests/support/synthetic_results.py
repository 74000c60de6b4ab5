"""Datasets with the structure of `at_load` datasets, and numbers that a test chooses."""

import numpy as np
import xarray
from stiction.mechanics.friction import STATUS_DTYPE
from stiction.study.study import Study

RESULT_STATISTICS = ("mean", "lower", "upper")
SLIDING_RULES = ("all", "opposing")


def value_and_ends(mean, half_width_ratio=0.05):
    """Return [mean, lower limit, upper limit] for a half width that is a given fraction of the mean."""
    return [mean, mean - half_width_ratio * abs(mean), mean + half_width_ratio * abs(mean)]


def measured_study(
    *, mechanics="half-space", press="areas", hardness=None, law="hertz-sphere", mu0=(0.2,), adhesion="0 mJ/m^2"
):
    """Return a study of two scan files that do not exist."""
    contact = {"mechanics": mechanics, "effective_modulus": "100 GPa"}
    if mechanics == "asperities":
        law_with_strength = {"name": law, "yield_strength": "1 GPa", "poisson_ratio": 0.3}
        contact["law"] = law_with_strength if law == "jackson-green" else law
    else:
        contact |= {} if hardness is None else {"hardness": f"{hardness} GPa", "yield_exponent": 1.15}
        contact |= {} if adhesion is None else {"work_of_adhesion": adhesion}
    files = {side: {"file": f"nowhere/{side}.npy"} for side in ("upper", "lower")}
    friction = {"mu0": sorted(mu0), "tau0": ["50 MPa"], "load": ["10 mN"]}
    return Study.model_validate(
        {"surfaces": {"kind": "measured", "press": press, **files}, "contact": contact, "friction": friction}
    )


def generated_study():
    """Return a study of generated profiles at one mu0 and tau0."""
    return Study.model_validate({"friction": {"mu0": [0.4], "tau0": ["0 MPa"]}})


QUANTITIES_AT_LOAD = {
    "contact_area_fraction": 0.01, "contact_area": 100.0, "contact_count": 300.0, "mean_pressure": 0.5,
    "normal_stiffness": 800.0, "approach": 0.05, "share_on_largest": 0.1, "share_at_edge": 0.05,
    "fraction_on_small": 0.05, "share_opposing": 0.5, "load_share_at_hardness": 0.0, "error": 1e-7,
}  # fmt: skip
"""Values of quantities at a load that cause no caveat."""


def measured_result(
    *, loads=(10.0,), mu0=(0.2,), tau0=(0.05,), directions=(0.0, 90.0, 180.0, 270.0), cut_offs=(0.0,),
    half_width_ratio=0.05, all_contacts=0.21, opposing=0.11, by_axis=None, status="ok", members=16, ok=16, **changes,
):  # fmt: skip
    """Return a result of measured surfaces with the same numbers at every load, mu0 and tau0.

    `changes` replace numbers.
    """
    axes = sorted({direction % 180 for direction in directions})
    sizes = {
        "cut_off": len(cut_offs), "sliding": 2, "direction": len(directions), "axis": len(axes), "load": len(loads),
        "mu0": len(mu0), "tau0": len(tau0), "fraction_below": 2, "statistic": 3,
    }  # fmt: skip
    friction = np.array([value_and_ends(all_contacts, half_width_ratio), value_and_ends(opposing, half_width_ratio)])

    def fill_dimensions(values, *dims):
        """Return dimensions, and an array that repeats `values` along the leading dimensions."""
        return dims, np.broadcast_to(values, [sizes[dim] for dim in dims]).copy()

    condition_dims, statistic_dim = ("load", "mu0", "tau0"), "statistic"
    friction_by_rule = friction[:, None, None, None, None, None, :]
    friction_along_axes = friction_by_rule if by_axis is None else np.array(by_axis)[None, None, :, None, None, None, :]
    variables = {
        "friction_coefficient": fill_dimensions(
            friction_by_rule, "sliding", "cut_off", "direction", *condition_dims, statistic_dim
        ),
        "friction_by_axis": fill_dimensions(
            friction_along_axes, "sliding", "cut_off", "axis", *condition_dims, statistic_dim
        ),
        "mean_friction": fill_dimensions(
            friction_by_rule[:, :, 0], "sliding", "cut_off", *condition_dims, statistic_dim
        ),
        "status": fill_dimensions(np.array(status, STATUS_DTYPE), "sliding", "cut_off", "direction", *condition_dims),
        "spread_low": fill_dimensions(0.04, "cut_off", "sliding", *condition_dims),
        "spread_high": fill_dimensions(0.19, "cut_off", "sliding", *condition_dims),
        "gentle_friction": fill_dimensions(
            friction_by_rule[:, :, :, 0, ..., 0], "sliding", "cut_off", "direction", "mu0", "tau0"
        ),
        "load_definition_effect": fill_dimensions(changes.pop("load_definition_effect", 0.001), "cut_off", "load"),
        "rms_gradient": fill_dimensions(value_and_ends(changes.pop("rms_gradient", 0.2)), "cut_off", statistic_dim),
        "rms_slope": fill_dimensions(value_and_ends(0.14), "cut_off", "direction", statistic_dim),
        "patch_area": fill_dimensions(value_and_ends(0.2), "cut_off", "load", "fraction_below", statistic_dim),
        "pressure": fill_dimensions(value_and_ends(0.4), "cut_off", "load", "fraction_below", statistic_dim),
        "members": fill_dimensions(members),
        "ok": fill_dimensions(ok, "cut_off", "sliding", "direction", *condition_dims),
    }  # fmt: skip
    for name, value in (QUANTITIES_AT_LOAD | changes).items():
        if value is not None:
            variables[name] = fill_dimensions(value_and_ends(value), "cut_off", "load", statistic_dim)
    coordinates = {
        "cut_off": list(cut_offs), "sliding": list(SLIDING_RULES), "direction": list(directions), "axis": axes,
        "load": list(loads), "mu0": list(mu0), "tau0": list(tau0), "fraction_below": [0.5, 0.9],
        "statistic": list(RESULT_STATISTICS), "nominal_area": 10_000.0, "effective_modulus": 100.0,
    }  # fmt: skip
    attributes = {
        "upper": "read from a.di\nlevelled by a plane", "lower": "read from b.di", "spacing_um": [0.1, 0.1],
        "load_definition": "elastic",
    }  # fmt: skip
    return xarray.Dataset(variables, coordinates, attributes)


def generated_result(
    *, loads=(0.001, 0.01), dimensions=(1.1, 1.4), friction=0.25, status="ok", half_width_ratio=0.05, **changes
):
    """Return a result of generated profiles for one direction and the sliding rule of the paper."""
    sizes = {"fractal_dimension": len(dimensions), "amplitude": 1, "load": len(loads), "mu0": 1, "tau0": 2}
    cell_dimensions = ("fractal_dimension", "amplitude", "load", "mu0", "tau0")

    def fill_dimensions(values, dims):
        shape = [sizes[dim] for dim in dims]
        return (*dims, "statistic"), np.broadcast_to(value_and_ends(values, half_width_ratio), [*shape, 3]).copy()

    loaded = {"contact_area": 1.0, "contact_count": 30.0, "normal_stiffness": 0.2, "mean_pressure": 0.05,
              "share_beyond_hertz": 0.1, "share_below_grid": 0.1} | changes  # fmt: skip
    shape = [sizes[dim] for dim in cell_dimensions]
    return xarray.Dataset(
        {
            "friction_coefficient": fill_dimensions(friction, cell_dimensions),
            "mean_friction": fill_dimensions(friction, cell_dimensions),
            "status": (cell_dimensions, np.full(shape, status, STATUS_DTYPE)),
            "members": ((), 100),
            "load_definition_effect": (cell_dimensions[:3], np.full(shape[:3], 0.02)),
            **{name: fill_dimensions(value, cell_dimensions[:3]) for name, value in loaded.items()},
        },
        {
            "fractal_dimension": list(dimensions), "amplitude": [0.1], "load": list(loads), "mu0": [0.4],
            "tau0": [0.0, 0.1], "statistic": list(RESULT_STATISTICS), "sliding": "opposing", "direction": 0.0,
        },
        {"load_definition": "mean"},
    )  # fmt: skip
