"""Results without units: divided by powers of a length and the effective modulus."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from stiction._checks import number

if TYPE_CHECKING:
    import xarray

_SCALES = {
    "mN": (1, 2, "(E* L²)"),
    "mN/um": (1, 1, "(E* L)"),
    "mN/GPa": (0, 2, "L²"),
    "GPa": (1, 0, "E*"),
    "um^2": (0, 2, "L²"),
    "um": (0, 1, "L"),
}
"""Powers of E* and L that a quantity of each unit is divided by, and how that is written."""


def nondimensional(
    result: xarray.Dataset, *, length: float | None = None, effective_modulus: float | None = None
) -> xarray.Dataset:
    """Loads as F/(E* L²), shear strengths as tau0/E*, areas as A/L², and so on: everything that has a unit, without.

    Parameters
    ----------
    result : xarray.Dataset
        Of `run`, `friction_map`, `area_map`, `stiffness_map`, `traverse` or `traverse_mean`.
    length : float, µm, optional
        L; by default the length scale of the result's study, or the longest wavelength of self-affine surfaces. A
        traverse has none, so it must be given.
    effective_modulus : float, GPa, optional
        E*; by default that of the result.

    Returns
    -------
    xarray.Dataset
        The same values divided by powers of E* and L, which their `long_name` says; units are "1".

    Raises
    ------
    ValueError
        If length or modulus are not above 0, are needed and not given, or something has an unknown unit.

    Notes
    -----
    With spheres (not with cylinders, whose width is a length of its own) loads, areas and friction of surfaces that are
    scaled by a factor in all lengths are the same numbers: the coefficient depends on tau0/E* alone.

    Examples
    --------
    >>> from stiction import Study, friction_map, nondimensional, run
    >>> study = Study.named("quick").with_changes({"ensemble.repetitions": 1, "surfaces.points": 4000})
    >>> friction = nondimensional(friction_map(run(study), [0.001]))  # mN, with E* = 10 GPa and L = 1 µm
    >>> float(friction["load"][0]), friction["load"].attrs["long_name"]
    (0.0001, 'normal load / (E* L²)')
    """
    import xarray

    if "study" in result.attrs:
        from stiction.studies.generated_surfaces import Generated
        from stiction.studies.study import study_of

        study = study_of(result)
        if length is None and isinstance(study.surfaces, Generated):
            length = study.surfaces.longest()
        own_modulus: Any = float(study.contact.effective_modulus)
    else:
        own_modulus = float(result["effective_modulus"]) if "effective_modulus" in result.coords else None
    effective_modulus = own_modulus if effective_modulus is None else effective_modulus
    if length is None:
        raise ValueError("length must be given: the result has no length scale of its own")
    if effective_modulus is None:
        raise ValueError("effective_modulus must be given: the result has none")
    length = number("length", length, unit="µm", above=0)
    modulus = number("effective_modulus", effective_modulus, unit="GPa", above=0)

    def scaled(name: str, variable: xarray.Variable) -> xarray.Variable:
        units = variable.attrs.get("units", "1")
        if units in ("1", "degree"):
            return variable
        if units not in _SCALES:
            raise ValueError(f"{name} has the unit {units!r}, which no result has")
        of_modulus, of_length, by = _SCALES[units]
        attributes = {**variable.attrs, "units": "1", "long_name": f"{variable.attrs.get('long_name', name)} / {by}"}
        return xarray.Variable(variable.dims, variable.values / (modulus**of_modulus * length**of_length), attributes)

    return xarray.Dataset(
        {str(name): scaled(str(name), each.variable) for name, each in result.data_vars.items()},
        {str(name): scaled(str(name), each.variable) for name, each in result.coords.items()},
        # Without the study, whose numbers have units.
        {name: value for name, value in result.attrs.items() if name != "study"}
        | {"length_um": length, "effective_modulus_GPa": modulus},
    )
