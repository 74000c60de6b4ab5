"""What results are made of: the name of each quantity, its unit, and the words in which tables and figures say it."""

from __future__ import annotations

from typing import NamedTuple

import stiction._core


class Quantity(NamedTuple):
    """How a result speaks of a number: its unit, a phrase for axes and datasets, and a few words for tables."""

    unit: str
    words: str
    brief: str = ""

    @property
    def short(self) -> str:
        """What tables say."""
        return self.brief or self.words


_OF_THE_CORE = {name: Quantity(unit, words) for name, unit, words in stiction._core.quantities()}
_OF_AREAS = {name: Quantity(unit, words) for name, unit, words in stiction._core.areal_quantities()}

SUMS: tuple[str, ...] = tuple(_OF_THE_CORE)
"""What a LoadCurve holds at each approach, and a result of each pair: the members of `Sums`, in the core's order."""

AREAL_SUMS: tuple[str, ...] = tuple(_OF_AREAS)  # what a SurfaceLoadCurve holds besides

DIRECTED: frozenset[str] = frozenset(
    f"{load}_{part}" for load in ("tangential", "lateral") for part in ("elastic", "frictional", "adhesive")
) | {"normal_frictional", "normal_adhesive"}
"""Sums that depend on the direction and on the sliding rule."""

HALF_SPACE_SUMS: tuple[str, ...] = (
    *(name for name in SUMS if name not in ("overlap_load", "load_beyond_hertz", "load_below_grid", "crossed_count")),
    "approach",
    "load_share_at_hardness",
    "area_share_at_hardness",
)
"""What a result by the half-space holds of each pair at each load."""

UNLOADED: tuple[str, ...] = ("unloaded_elastic", "unloaded_frictional", "unloaded_adhesive")
"""The tangential load that starts the sliding at no load, by parts, as `load_of` puts them together."""

PULL_OFF: tuple[str, ...] = ("pull_off", "pull_off_is_bound")
"""Pull-off force of a member, and 1 if the bodies hold at least that, else 0."""

ADHESION: tuple[str, ...] = ("contact_load", *PULL_OFF, *UNLOADED)
"""What it holds besides of bodies that adhere; all but the first are of no load."""

HELD: tuple[str, ...] = ("pull_off", "pull_off_pressure", "friction_at_no_load")
"""What is said of bodies that adhere, whatever the load."""

AREAL_VALIDITY: tuple[str, ...] = ("share_overlapping", "share_at_edge", "share_unanswered")
"""The members that `SurfaceValidity` has besides those of `Validity`."""

ONSET: tuple[str, ...] = ("tangential_stiffness", "displacement_at_sliding", "fraction_slipped")
"""What a result of generated bodies holds of how each pair begins to slide, where its study asks for it."""

DISTRIBUTIONS: tuple[str, ...] = ("patch_area", "pressure")
"""What a result of measured bodies holds quantiles of, of each member at each load."""

GAP: tuple[str, ...] = ("rms_gradient", "rms_slope")
"""What it holds of the gap of each member, whatever the load; the second along each direction."""

VALIDITY: tuple[str, ...] = ("relative_overlap", "share_beyond_hertz", "share_below_grid", "share_crossed")
"""The members of `Validity`."""

_OF_RESULTS: dict[str, tuple[str, ...]] = {
    "friction_coefficient": ("1", "coefficient of static friction"),
    "tangential_load": ("mN", "tangential load that starts the sliding"),
    "normal_load": ("mN", "normal load while sliding starts, friction on slopes included"),
    "contact_load": ("mN", "load of the contacts, of the normal load and the attraction", "contact load"),
    "pull_off": ("mN", "pull-off force"),
    "pull_off_pressure": ("GPa", "pull-off force over the nominal area", "pull-off pressure"),
    "friction_at_no_load": ("mN", "tangential load that starts the sliding at no load", "friction at no load"),
    "pull_off_is_bound": ("1", "1 where the pull-off force is at least the value, 0 where it is the value"),
    "share_of_pull_off_bounds": ("1", "fraction of the members whose pull-off force is a lower bound or missing"),
    **{
        f"unloaded_{part}": (unit, f"{part} part of the tangential load at no normal load")
        for part, unit in (("elastic", "mN"), ("frictional", "mN"), ("adhesive", "mN/GPa"))
    },
    "normal_stiffness": ("mN/um", "normal stiffness"),
    "closure": ("um", "closure, the mean gap lost since first touch", "closure"),
    "closure_stiffness": ("MPa/mm", "nominal pressure over closure, incremental", "stiffness of closure"),
    "tangential_stiffness": ("mN/um", "tangential stiffness at rest"),
    "displacement_at_sliding": ("um", "displacement of the upper body before it slides", "creep before sliding"),
    "fraction_slipped": (
        "1",
        "fraction of the normal load on what slips at half of the sliding load",
        "load that slips at half of sliding",
    ),
    "sliding_load": ("mN", "tangential load at which all slips"),
    "displacement": ("um", "displacement of the upper body since the tangential load was 0"),
    "stiffness": ("mN/um", "tangential stiffness at rest"),
    "unloading_stiffness": ("mN/um", "normal stiffness, unloading or by ultrasound"),
    "nominal_pressure": ("GPa", "normal load over nominal area", "pressure on the nominal area"),
    "stiffness_per_area": ("GPa/mm", "normal stiffness per area while loading"),
    "unloading_stiffness_per_area": ("GPa/mm", "normal stiffness per area while unloading (ultrasonic)"),
    "slipped_area": ("1", "fraction of the true contact area that slips"),
    "slipped_load": ("1", "fraction of the normal load on what slips"),
    "energy_lost": ("mN um", "energy that a cycle between plus and minus this load takes"),
    "contact_area_fraction": ("1", "true over nominal contact area", "true area A/A0"),
    "mean_pressure": ("GPa", "mean pressure in contact"),
    "share_opposing": ("1", "fraction of the load on contacts that oppose the motion", "load that opposes"),
    "error": ("1", "error of the half-space, in deviations of the gap", "error of the solution"),
    "share_at_edge": (
        "1",
        "fraction of the load on contacts that reach the edge of the overlap",
        "load on contacts at the edge",
    ),
    "share_on_largest": ("1", "fraction of the load on the contact that carries most", "load on the largest contact"),
    "fraction_on_small": (
        "1",
        "fraction of the load on contacts of at most four grid cells",
        "load on contacts of 4 points or fewer",
    ),
    **{
        f"share_on_steepest_{side}": (
            "1",
            f"fraction of the load on the steepest tenth of the {side} body",
            f"load on the {side}'s steepest tenth",
        )
        for side in ("upper", "lower")
    },
    "patch_area": ("um^2", "areas of contacts on the ground plan", "area of a contact"),
    "pressure": ("GPa", "pressures over the true area", "pressure"),
    "rms_gradient": ("1", "root-mean-square gradient of the gap", "rms gradient of the gap"),
    "rms_slope": ("1", "root-mean-square slope of the gap along the motion", "rms slope of the gap"),
    "gentle_friction": ("1", "friction coefficient by the slope of the gap alone", "by the slopes alone"),
    "cut_off": ("um", "wavelength below which waves are taken off; 0 is the scan itself", "cut-off"),
    "fraction_below": ("1", "fraction that is smaller"),
    "axis": ("degree", "axis of the motion, both senses together, from +x towards +y"),
    "x": ("um", "how far the upper body is moved along +x"),
    "y": ("um", "how far the upper body is moved along +y"),
    "line": ("1", "pair of lines"),
    "surrogate": ("", "whether the member is a pair of surrogates"),
    "nominal_area": ("um^2", "nominal area of a member"),
    "relative_overlap": ("1", "load-weighted mean of overlap / radius"),
    "share_beyond_hertz": ("1", "fraction of the load on contacts with an overlap above a tenth of their radius"),
    "share_below_grid": ("1", "fraction of the load on contacts with a radius below the grid spacing"),
    "share_crossed": ("1", "fraction of would-be contacts refused because their sphere centres had crossed"),
    "share_overlapping": ("1", "fraction of the load on contacts whose ellipse overlaps another one"),
    "share_unanswered": ("1", "fraction of the grid's minima beside which the spline has none"),
    "load_share_at_hardness": ("1", "fraction of the load where the pressure is the hardness"),
    "area_share_at_hardness": ("1", "fraction of the points under pressure where that is the hardness"),
    "lateral_load": ("mN", "lateral load that keeps the upper body on its way"),
    "direction": ("degree", "where the upper body is about to move, from +x towards +y"),
    "sliding": ("", "which contacts rub and push: those that oppose the motion, or all", "rubbing contacts"),
    "fractal_dimension": ("1", "fractal dimension"),
    "amplitude": ("um", "amplitude"),
    "repetition": ("1", "repetition"),
    "approach": ("um", "approach since first touch"),
    "load": ("mN", "normal load"),
    "mu0": ("1", "molecular friction coefficient", "mu0"),
    "tau0": ("GPa", "adhesive shear strength", "tau0"),
    "hurst_exponent": ("1", "Hurst exponent", "H"),
    "rms": ("um", "Sq of each surface", "Sq"),
    "area_factor": ("1/GPa", "a of A/A0 = a p"),
    "stiffness_factor": ("GPa/um/GPa^c", "b of k/A0 = b p^c"),
    "stiffness_exponent": ("1", "c of k/A0 = b p^c"),
    "area_deviation": ("1", "largest relative difference from A/A0 = a p", "largest deviation of A/A0"),
    "stiffness_deviation": ("1", "largest relative difference from k/A0 = b p^c", "largest deviation of k/A0"),
    "effective_modulus": ("GPa", "effective modulus"),
    "status": ("", "whether the value exists, or why not"),
}

QUANTITIES = _OF_THE_CORE | _OF_AREAS | {name: Quantity(*each) for name, each in _OF_RESULTS.items()}
"""Words and units of all quantities, coordinates included."""


def attributes_of(name: str) -> dict[str, str]:
    """The attributes of a variable of that name in a dataset."""
    unit, words = QUANTITIES[name][:2]
    return {"units": unit, "long_name": words} if unit else {"long_name": words}


def column_of(name: str) -> tuple[str, float]:
    """The title of a column for spreadsheets, with its unit, and the factor to that: places in GPa are told in MPa."""
    quantity = QUANTITIES[name]
    unit, factor = ("MPa", 1000.0) if name in ("tau0", "pressure") else (quantity.unit, 1.0)
    return quantity.short + (f" ({unit})" if unit not in ("", "1") else ""), factor
