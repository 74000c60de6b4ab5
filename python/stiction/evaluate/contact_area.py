"""True contact area of a pair as a function of the load, the hardness, E* and the exponent of the yield model.

Elastic areas at all loads suffice for this: the area of contacts that yield follows from the elastic area at the same
load, and by similarity, the elastic area at (F, e E*) equals the area at (F/e, E*). The *capped area* is that of the
half-space solution, in which the pressure is limited to the hardness.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from stiction._checks import Floats
from stiction.mechanics.friction import FrictionLaw, OnsetState
from stiction.mechanics.hardness import (
    CENTRAL_SIZE_EFFECT_LENGTH,
    estimate_indentation_depth,
    size_effect_factor,
    yielded_area,
)
from stiction.mechanics.resolution import KAPPA_AT_SMALL_LOADS
from stiction.solve.layout import arrange_axes
from stiction.solve.member_sums import MemberSums
from stiction.study.inputs import Inputs

if TYPE_CHECKING:
    import xarray

FALLBACK_YIELD_EXPONENT = 1.15
"""Exponent m of `yielded_area` for results without elastic areas, in which it only scales stored areas."""

AREA_PROPORTIONAL_SUM_NAMES = ("contact_area", "normal_adhesive", "tangential_adhesive")
"""Names of the stored contact sums that are proportional to the true area."""


@dataclass(frozen=True, eq=False)
class AreaFunction:
    """True contact area of a pair at one cutoff, averaged over members, as a function of load and uncertain inputs.

    Attributes
    ----------
    loads : (l,) ndarray, mN
        Ascending loads.
    elastic_areas : (l,) ndarray, µm²
        True areas of elastic bodies at these loads, for the E* of the study.
    nominal_area : float, µm²
    hardness : float or None, GPa
        Hardness in the study; None for elastic bodies.
    yield_exponent : float
        Exponent m of `yielded_area`.
    attractions : (l,) ndarray, mN, optional
        Attraction of bodies that adhere, at these loads. The contacts carry the load and the attraction.
    indent : float, µm, optional
        Depth of the indentation that measured the hardness. Smaller contacts are harder.
    contact_depths : (l,) ndarray, µm, optional
        Depths of indentations that correspond to the contacts at these loads, if the indentation is known.
    """

    loads: Floats
    elastic_areas: Floats
    nominal_area: float
    hardness: float | None
    yield_exponent: float = FALLBACK_YIELD_EXPONENT
    attractions: Floats | None = None
    indent: float | None = None
    contact_depths: Floats | None = None

    def contact_hardness(
        self, load: ArrayLike, hardness: ArrayLike | None = None, size_effect: ArrayLike = CENTRAL_SIZE_EFFECT_LENGTH
    ) -> Any:
        """Return the hardness (GPa) of contacts at a load (mN): the measured hardness, corrected for a size effect.

        Returns None if the study has no hardness.

        `hardness` is the measured hardness, by default the hardness of the study. `size_effect` is the length h* (µm)
        of the indentation size effect, which has no effect if the depth of the indentation is unknown.
        """
        if self.hardness is None:
            return None
        measured_hardness: Any = self.hardness if hardness is None else hardness
        if self.indent is None or self.contact_depths is None:
            return measured_hardness
        depth = np.exp(np.interp(np.log(load), np.log(self.loads), np.log(self.contact_depths)))
        return measured_hardness * size_effect_factor(size_effect, depth, self.indent)

    def elastic_area(self, load: ArrayLike, modulus: ArrayLike = 1.0) -> Floats:
        """Return the true area (µm²) of elastic bodies at a load (mN), with E* multiplied by the factor `modulus`.

        Above and below the computed loads, the area is proportional to the load.
        """
        equivalent_load = self._compute_contact_load(load) / np.asarray(modulus)
        loads = self.loads if self.attractions is None else self.loads + self.attractions
        log_area_per_load = np.interp(np.log(equivalent_load), np.log(loads), np.log(self.elastic_areas / loads))
        return np.asarray(np.minimum(np.exp(log_area_per_load) * equivalent_load, self.nominal_area))

    def _compute_contact_load(self, load: ArrayLike) -> Floats:
        """Return the load (mN) that the contacts carry: the applied load plus the attraction."""
        loads = np.asarray(load, dtype=np.float64)
        if self.attractions is None:
            return loads
        return np.asarray(loads + np.interp(np.log(loads), np.log(self.loads), self.attractions))

    def __call__(
        self, load: ArrayLike, *, hardness: ArrayLike | None = None, modulus: ArrayLike = 1.0,
        yield_exponent: ArrayLike | None = None, elastic_area: Floats | None = None,
        size_effect: ArrayLike = CENTRAL_SIZE_EFFECT_LENGTH,
    ) -> Floats:  # fmt: skip
        """Return the true area (µm²) before shear at given loads (mN) and inputs.

        Hardness and yield exponent are by default those of the study.

        Parameters
        ----------
        load : array_like of float, mN
        hardness : array_like of float, GPa, optional
            Measured hardness. Ignored for elastic bodies.
        modulus : array_like of float
            Ratio of E* to the E* in the study.
        yield_exponent : array_like of float, optional
        elastic_area : array of float, µm², optional
            Result of `elastic_area` for this load and modulus, if it is known.
        size_effect : array_like of float, µm
            Length h* of the indentation size effect.
        """
        elastic_area = self.elastic_area(load, modulus) if elastic_area is None else elastic_area
        return self._compute_area_at_pressure(
            self.contact_hardness(load, hardness, size_effect), load, elastic_area, yield_exponent
        )

    def _compute_area_at_pressure(
        self, pressure: Floats | None, load: ArrayLike, elastic_area: Floats, yield_exponent: ArrayLike | None
    ) -> Floats:
        """Return the true area (µm²) of contacts that yield at `pressure` (GPa) or, if None, of elastic contacts."""
        if pressure is None:
            return elastic_area
        exponent = self.yield_exponent if yield_exponent is None else yield_exponent
        area = yielded_area(elastic_area, self._compute_contact_load(load), pressure, exponent)
        return np.minimum(area, self.nominal_area)

    def onset(
        self, law: FrictionLaw, load: ArrayLike, *, hardness: ArrayLike | None = None, modulus: ArrayLike = 1.0,
        yield_exponent: ArrayLike | None = None, elastic_area: Floats | None = None,
        size_effect: ArrayLike = CENTRAL_SIZE_EFFECT_LENGTH, yield_pressure: Floats | None = None,
    ) -> OnsetState:  # fmt: skip
        """Return the true area, the friction and other quantities of the contacts at the onset of sliding.

        `yield_pressure` is the pressure (GPa) of yielding contacts under this law at this load, if computed before. All
        other arguments are the same as for `__call__`.
        """
        elastic_area = self.elastic_area(load, modulus) if elastic_area is None else elastic_area

        def area_at_pressure(pressure: Floats | None) -> Floats:
            return self._compute_area_at_pressure(pressure, load, elastic_area, yield_exponent)

        hardness = self.contact_hardness(load, hardness, size_effect)
        return law.onset(load, hardness, self.nominal_area, area_at_pressure, yield_pressure)


@dataclass(frozen=True, eq=False)
class _SolvedAreas:
    """True contact areas (µm²) stored in a result, averaged over members, for each cutoff and each loading step."""

    all_members: Floats
    elastic_members: Floats
    # True areas (µm²) of elastic bodies that never yield, or NaN if the study needs no elastic areas.
    elastic: Floats


def _average_solved_areas(result: MemberSums) -> _SolvedAreas:
    """Average the stored true areas over members cut from scans, or over surrogates if no member is from a scan."""
    study = result.study
    has_elastic_areas = study.contact.yield_exponent is not None
    first_index = study.surfaces.first_scan_member_index
    first_index = first_index if (result.members >= first_index).any() else 0
    shape = 3, study.surfaces.cell_coordinates()["cut_off"].size, study.contact.loading_steps().size
    area_sums, member_counts = np.zeros(shape), np.zeros(shape)
    for piece in result.pieces(["contact_area", *(["elastic_area"] if has_elastic_areas else [])]):
        is_used = piece["repetition"].values >= first_index
        areas, elastic_areas = (
            np.asarray(arrange_axes(piece.variables[name], ("cut_off", "repetition", "load")), np.float64)[:, is_used]
            if name in piece
            else np.full((*shape[1:2], int(is_used.sum()), shape[2]), np.nan)
            for name in ("contact_area", "elastic_area")
        )
        is_solved, has_elastic = np.isfinite(areas), np.isfinite(areas) & np.isfinite(elastic_areas)
        for index, (values, mask) in enumerate(
            ((areas, is_solved), (areas, has_elastic), (elastic_areas, has_elastic))
        ):
            area_sums[index] += np.where(mask, values, 0.0).sum(axis=1)
            member_counts[index] += mask.sum(axis=1)
    with np.errstate(invalid="ignore", divide="ignore"):
        all_members, elastic_members, elastic = area_sums / member_counts
    # An unfinished result may contain no member with a stored elastic area, so elastic areas are estimated.
    lacks_elastic = ~np.isfinite(elastic).any(axis=1)
    if has_elastic_areas and lacks_elastic.any():
        elastic_members[lacks_elastic] = all_members[lacks_elastic]
        elastic[lacks_elastic] = _estimate_elastic_areas(result, all_members)[lacks_elastic]
    return _SolvedAreas(all_members, elastic_members, elastic)


def build_area_functions(result: MemberSums) -> list[AreaFunction]:
    """Return functions that compute the true area from load and inputs: one function for each cutoff of a result."""
    study, areas = result.study, result.compute_once(_average_solved_areas)
    contact, loads = study.contact, study.contact.loading_steps()
    nominal_area = float(result.head["nominal_area"])
    hardness = None if contact.hardness is None else float(contact.hardness)
    # Adhesive contacts are treated as elastic, because few contacts yield under the attraction alone.
    if hardness is None or contact.adheres:
        elastic_areas = areas.all_members
    elif contact.yield_exponent is not None:
        with np.errstate(invalid="ignore"):
            elastic_areas = areas.elastic * areas.all_members / areas.elastic_members
    else:
        elastic_areas = _estimate_elastic_areas(result, areas.all_members)
    exponent = FALLBACK_YIELD_EXPONENT if contact.yield_exponent is None else float(contact.yield_exponent)
    contact_loads = _average_contact_loads(result)
    indent, depths = (
        None if contact.indent is None else float(contact.indent),
        result.compute_once(_estimate_contact_depths),
    )
    functions = []
    for index, cell_areas in enumerate(elastic_areas):
        is_known = np.isfinite(cell_areas) & (cell_areas > 0)
        if is_known.any():
            attractions = None if contact_loads is None else np.maximum(contact_loads[index] - loads, 0.0)[is_known]
            known_points = loads[is_known], cell_areas[is_known]
            known_depths = None if depths is None else depths[index][is_known]
            functions.append(
                AreaFunction(*known_points, nominal_area, hardness, exponent, attractions, indent, known_depths)
            )
        else:
            # The area is unknown if the solver failed for every member.
            functions.append(AreaFunction(np.ones(1), np.full(1, np.nan), nominal_area, hardness, exponent))
    return functions


def compute_onset_area_and_friction_factors(
    result: MemberSums, loads: Floats, mu0: Floats, tau0: Floats
) -> tuple[Floats, Floats]:
    """Return the factors by which shear changes the true area and the friction force before sliding starts.

    The growth is the true area divided by the area before shear. The friction fraction is
    `OnsetState.friction_fraction`. Both arrays have the shape (cells, loads, mu0, tau0). The growth is infinite at
    seizure. The pressure at the onset is also applied to contacts that do not oppose the motion, so that the growth is
    an upper bound under the sliding rule "opposing".
    """
    law = Inputs.from_study(result.study).friction_law(mu0[:, np.newaxis], tau0)
    loads = loads[:, np.newaxis, np.newaxis]
    shape = loads.size, mu0.size, tau0.size
    ratios, fractions = [], []
    for area in result.compute_once(build_area_functions):
        onset = area.onset(law, loads)
        ratios.append(np.broadcast_to(onset.area / area(loads), shape))
        fractions.append(np.broadcast_to(onset.friction_fraction, shape))
    return np.stack(ratios), np.stack(fractions)


def _estimate_contact_depths(result: MemberSums) -> Floats | None:
    """Return the depth (µm) of an indentation that has the same strain gradient as the contacts.

    The depth is given for each cutoff and each loading step.

    Returns None if the depth of the indentation that measured the hardness is unknown. The contacts have the true area
    at the measured hardness.
    """
    contact: Any = result.study.contact
    if contact.indent is None:
        return None
    contact_counts = np.asarray(result.means(["contact_count"])["contact_count"].transpose("cut_off", "load").values)
    gradients = result.means(["rms_gradient"])["rms_gradient"].values.reshape(-1, 1)
    factors = _compute_yield_factors_at(result, np.asarray(float(contact.hardness)))
    areas = result.compute_once(_average_solved_areas).all_members * factors
    return estimate_indentation_depth(areas, contact_counts, gradients, are_lines=not result.study.is_areal)


def _average_contact_loads(result: MemberSums) -> Floats | None:
    """Average the load on the contacts (mN; external load plus attraction) over members, per cutoff and step."""
    if "contact_load" not in result.head.variables:
        return None
    return np.asarray(result.means(["contact_load"])["contact_load"].transpose("cut_off", "load").values)


def _estimate_elastic_areas(result: MemberSums, areas: Floats) -> Floats:
    """Estimate the true areas (µm²) that elastic bodies would have, for a result in which hardness limits the pressure.

    The estimate A = κ F/(E* h') holds for small loads. Surfaces that fit perfectly are in complete contact.
    """
    contact = result.study.contact
    gradients = result.means(["rms_gradient"])["rms_gradient"].values.reshape(-1, 1)
    with np.errstate(divide="ignore"):
        loads = _average_contact_loads(result)
        loads = contact.loading_steps() if loads is None else loads
        estimates = KAPPA_AT_SMALL_LOADS * loads / (float(contact.effective_modulus) * gradients)
    smaller_areas = np.minimum(np.fmin(estimates, float(result.head["nominal_area"])), areas)
    return np.where(np.isfinite(areas), smaller_areas, np.nan)


def compute_stiffness_exponents(result: MemberSums) -> Floats:
    """Return d ln(k)/d ln(F) at each computed load F, for the mean normal stiffness k in loading and in unloading.

    The array has the shape (2, loads).
    """
    means = result.means(["normal_stiffness", "unloading_stiffness"]).data_vars.values()
    steps = result.study.contact.loading_steps()
    return np.stack(
        [compute_exponents(steps, k.variable.mean([dim for dim in k.dims if dim != "load"]).values) for k in means]
    )


def compute_exponents(loads: Floats, values: Floats) -> Floats:
    """Return the exponent d ln(q)/d ln(F) at each load F, for a quantity with the values q at these loads.

    Returns 1 if fewer than two values of q are known.
    """
    is_known = np.isfinite(values) & (values > 0)
    if is_known.sum() < 2:
        return np.ones(loads.size)
    log_loads = np.log(loads)
    exponents = np.gradient(np.log(values[is_known]), log_loads[is_known])
    return np.asarray(np.interp(log_loads, log_loads[is_known], exponents))


def compute_yield_factors(result: MemberSums) -> Floats | None:
    """Return the ratio of the true area of yielding contacts to the stored area, for each cutoff and loading step.

    The stored area is that of contacts whose pressure is limited to the hardness. Returns None if both areas are equal,
    because the bodies are elastic or the result has no elastic areas.
    """
    if "elastic_area" not in result.head.variables:
        return None
    contact: Any = result.study.contact
    hardness, depths = np.asarray(float(contact.hardness)), result.compute_once(_estimate_contact_depths)
    if depths is not None:
        hardness = hardness * size_effect_factor(CENTRAL_SIZE_EFFECT_LENGTH, depths, float(contact.indent))
    return _compute_yield_factors_at(result, hardness)


def _compute_yield_factors_at(result: MemberSums, hardness: Floats) -> Floats:
    """Return the ratio of true to stored area for contacts with a given hardness (GPa), per cutoff and loading step."""
    contact: Any = result.study.contact
    areas, loads = result.compute_once(_average_solved_areas), contact.loading_steps()
    with np.errstate(invalid="ignore", divide="ignore"):
        true_areas = yielded_area(areas.elastic, loads, hardness, float(contact.yield_exponent))
        # In complete contact, round-off may raise the elastic area above the nominal area.
        largest_areas = np.maximum(areas.elastic, float(result.head["nominal_area"]))
        factors = np.minimum(true_areas, largest_areas) / areas.elastic_members
    for cell_factors in factors:
        is_known = np.isfinite(cell_factors)
        if is_known.any():
            log_loads = np.log(loads)
            cell_factors[~is_known] = np.interp(log_loads[~is_known], log_loads[is_known], cell_factors[is_known])
        else:
            cell_factors[:] = 1.0
    return factors


def iterate_pieces_with_true_areas(result: MemberSums, names: Iterable[str] | None = None) -> Iterator[xarray.Dataset]:
    """Yield groups of members in which the true area of yielding contacts replaces the stored contact area.

    The scaled sums are `AREA_PROPORTIONAL_SUM_NAMES`. All other sums are those of the half-space solution.
    """
    factors = result.compute_once(compute_yield_factors)
    for piece in result.pieces(names):
        yield piece if factors is None else _scale_area_sums(piece, factors)


def _scale_area_sums(piece: xarray.Dataset, factors: Floats) -> xarray.Dataset:
    import xarray

    scaled_piece, scale = piece.copy(), xarray.Variable(("cut_off", "load"), factors)
    for name in set(AREA_PROPORTIONAL_SUM_NAMES) & set(piece.variables):
        # Replacing the array of a copied variable takes less time than assigning a variable to the dataset.
        variable = scaled_piece.variables[name]
        variable.data = (variable * scale).transpose(*variable.dims).values
    return scaled_piece
