"""Forces at each contact of two profiles in the asperity model, for a figure with force arrows."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from stiction._checks import Floats
from stiction.mechanics.contact import contacts
from stiction.mechanics.friction import FrictionLaw
from stiction.study.contact_settings import AsperityModelSettings
from stiction.study.members import generate_profile_pairs, read_measured_bodies
from stiction.surfaces.profile import Profile

if TYPE_CHECKING:
    import xarray

    from stiction.solve.member_sums import MemberSums


def compute_contact_forces(result: MemberSums) -> xarray.Dataset | None:
    """Compute the force at each contact of one typical pair of profiles, for a study with the asperity model.

    For measured profiles, the pair is the first member with contacts at the first load of the study. For generated
    profiles, it is the first pair at the middle fractal dimension and the first amplitude, at the median approach with
    contacts. mu0 and tau0 are the first values in the study.

    Returns
    -------
    xarray.Dataset or None
        As for `build_contact_forces`, with the coordinates of the cell. For measured profiles, the attributes also
        contain load_mN and x (µm, shift of the upper profile). Returns None for maps, for the half-space model, and if
        no pair has contacts.

    Raises
    ------
    ValueError
        If files of the study are missing.
    """
    study = result.study
    if study.is_areal or not isinstance(study.contact, AsperityModelSettings):
        return None
    pair = _find_first_touching_pair(result) if study.is_measured else _generate_middle_pair(result)
    if pair is None:
        return None
    upper, lower, approach, coordinates, attributes = pair
    forces = build_contact_forces(
        upper, lower, approach, mu0=float(study.friction.mu0[0]), tau0=float(study.friction.tau0[0]),
        model=study.contact.contact_model(),
    )  # fmt: skip
    return forces.assign_coords(coordinates).assign_attrs(attributes)


def build_contact_forces(
    upper: Profile, lower: Profile, approach: float, *, mu0: float, tau0: float = 0.0, **contact: Any
) -> xarray.Dataset:
    """Compute the force that each contact exerts on the upper of two profiles, at a given approach (µm).

    Parameters
    ----------
    upper, lower : Profile
        Profiles on the same grid.
    approach : float, µm
    mu0 : float
    tau0 : float, GPa
    **contact
        As for `contacts`.

    Returns
    -------
    xarray.Dataset
        Dataset with these variables, and the attributes approach_um and spacing_um:

        - upper_height, lower_height (height_x): heights at the approach (µm)
        - contact_radius (contact): radius of the contact patch (µm)
        - contact_force (contact): force along the normal (mN)
        - contact_friction (contact): friction along the tangent (mN); 0 at contacts that do not oppose the motion
        - contact_centre (contact, axis): position (µm); the coordinates of axis are "x" and "z"
        - contact_normal, contact_tangent (contact, axis): unit vectors
    """
    import xarray

    contact_table = contacts(upper, lower, approach, **contact)
    friction = np.where(
        contact_table.opposing, FrictionLaw(mu0, tau0).force(contact_table.force, contact_table.area), 0.0
    )
    upper_heights = upper.heights - (float((upper.heights - lower.heights).min()) + approach)
    variables: dict[str, Any] = {
        "upper_height": ("height_x", upper_heights, {"units": "um"}),
        "lower_height": ("height_x", lower.heights, {"units": "um"}),
        "contact_radius": ("contact", np.sqrt(contact_table.radius * contact_table.overlap), {"units": "um"}),
        "contact_force": ("contact", contact_table.force, {"units": "mN"}),
        "contact_friction": ("contact", friction, {"units": "mN"}),
    }
    for name, vectors, unit in (
        ("centre", contact_table.centre, "um"),
        ("normal", contact_table.normal, "1"),
        ("tangent", contact_table.tangent, "1"),
    ):
        variables[f"contact_{name}"] = (("contact", "axis"), vectors[:, ::2], {"units": unit})
    coordinates = {"height_x": ("height_x", lower.x, {"units": "um"}), "axis": ["x", "z"]}
    return xarray.Dataset(variables, coordinates, {"approach_um": approach, "spacing_um": lower.spacing})


_ProfilePairAtApproach = tuple[Profile, Profile, float, dict[str, float], dict[str, float]]
"""Upper and lower profile, approach (µm), and the coordinates and attributes that describe this pair in a dataset."""


def _find_first_touching_pair(result: MemberSums) -> _ProfilePairAtApproach | None:
    """Return the first pair of measured profiles that is in contact at the first load of the study.

    Returns None if no pair touches.
    """
    load = float(result.study.friction.load[0])
    for piece in result.pieces(["approach", "contact_count"]):
        members = piece.isel(cut_off=0).sel(load=load, method="nearest")
        is_touching = np.isfinite(members["approach"].values) & (members["contact_count"].values > 0)
        if is_touching.any():
            first_member = members.isel(repetition=int(is_touching.argmax()))
            cutoff_wavelength = float(first_member["cut_off"])
            member = read_measured_bodies(result.study).member(int(first_member["repetition"]), cutoff_wavelength)
            upper, lower = member.pair
            assert isinstance(upper, Profile) and isinstance(lower, Profile)  # noqa: PT018
            approach, attributes = float(first_member["approach"]), {"load_mN": load, "x": member.x}
            return upper, lower, approach, {"cut_off": cutoff_wavelength}, attributes
    return None


def _generate_middle_pair(result: MemberSums) -> _ProfilePairAtApproach | None:
    """Return the first pair generated with the middle fractal dimension, and the approach (µm) that figures show.

    The approach is the median of the approaches at which at least one pair touches. Returns None if no pair touches.
    """
    study, cells = result.study, result.study.surfaces.cell_coordinates()
    contact_counts = result.means(["contact_count"])["contact_count"].transpose("approach", ...).values
    approaches: Floats = result.head["approach"].values[
        (contact_counts > 0).any(axis=tuple(range(1, contact_counts.ndim)))
    ]
    if not approaches.size:
        return None
    dimensions, amplitude = cells["fractal_dimension"], float(cells["amplitude"][0])
    middle_dimension = dimensions[dimensions.size // 2 :][:1]
    upper, lower = next(generate_profile_pairs(study, 0, middle_dimension, amplitude))
    coordinates = {"fractal_dimension": float(middle_dimension[0]), "amplitude": amplitude}
    return upper, lower, float(approaches[approaches.size // 2]), coordinates, {}
