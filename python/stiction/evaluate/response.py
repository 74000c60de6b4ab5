"""Dependence of friction and contact on uncertain inputs: E*, hardness, μ0, τ0, and the inputs of the yield model.

One solution at the inputs of the study gives the quantities at all other inputs. Forces are linear in μ0 and τ0, and
the true area is an `AreaFunction`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from stiction._checks import Floats
from stiction.evaluate.contact_area import AreaFunction, compute_exponents
from stiction.mechanics.friction import FrictionLaw, OnsetState
from stiction.mechanics.hardness import CENTRAL_SIZE_EFFECT_LENGTH
from stiction.solve.member_sums import MemberSums

UNLOADING_STIFFNESS_EXPONENT, LOADING_STIFFNESS_EXPONENT = 0.55, -0.4
"""Exponents of unloading and loading stiffness, as powers of the factor by which yielding changes the true area.

The exponents were fitted to solutions at other hardnesses. The exponent of the loading stiffness is multiplied by the
yielded fraction of the area. For hardnesses from half to double and E* within 25 %, the unloading stiffness is within
10 % of these solutions, the loading stiffness within 20 %.
"""


@dataclass(frozen=True, kw_only=True)
class InputValues:
    """Hardness, mu0, tau0 and the other inputs on which friction and contact area depend, as numbers or samples.

    Each is a number or an array of samples.

    Attributes
    ----------
    mu0 : float or array
    tau0 : float or array, GPa
    hardness : float or array, GPa
        NaN for elastic bodies.
    modulus : float or array
        Ratio of E* to the E* in the study.
    height_factor : float or array
        Factor of all heights. It changes the true area like a factor of E*, and the stiffness is divided by it.
    yield_exponent : float or array
        Exponent of the yielding area.
    junction_growth : float or array
        α of junction growth, or with slip lines the ratio of hardness to shear strength; 0 if contacts do not grow.
    uses_slip_lines : bool
    area_loss : float or array
        Fraction of their true area that elastic contacts lose before they slide.
    size_effect : float or array, µm
        Length h* of the indentation size effect. Without effect if the depth of the indentation is unknown.
    area_ratio : float or array
        Factor of the sliding area, which is the error of its mean over positions.
    """

    mu0: Any
    tau0: Any
    hardness: Any = np.nan
    modulus: Any = 1.0
    height_factor: Any = 1.0
    yield_exponent: Any = np.nan
    junction_growth: Any = 0.0
    uses_slip_lines: bool = False
    area_loss: Any = 0.0
    size_effect: Any = CENTRAL_SIZE_EFFECT_LENGTH
    area_ratio: Any = 1.0

    @property
    def law(self) -> FrictionLaw:
        """Friction law with these inputs: mu0, tau0, junction growth and area loss."""
        return FrictionLaw(self.mu0, self.tau0, self.junction_growth, self.uses_slip_lines, self.area_loss)


def _get_area_inputs(inputs: InputValues) -> dict[str, Any]:
    return {name: getattr(inputs, name) for name in ("hardness", "yield_exponent", "size_effect")}


@dataclass(frozen=True, eq=False)
class ClosureCurve:
    """Closure (µm) of a pair's gap at each computed load, averaged over members, for interpolation at other loads.

    Attributes
    ----------
    loads : (l,) ndarray, mN
        Ascending loads.
    closures : (l,) ndarray, µm
        Increasing closures at these loads.
    stiffness_exponents : (2, l) ndarray
        Logarithmic derivatives of the closure stiffness while loading and while unloading with respect to the load, at
        these loads.
    """

    loads: Floats
    closures: Floats
    stiffness_exponents: Floats

    def exponents_at(self, load: float) -> tuple[float, float]:
        """Return the exponents d ln(k)/d ln(F) of the closure stiffness k for loading and unloading, at a load (mN)."""
        log_load, log_loads = np.log(load), np.log(self.loads)
        loading, unloading = (
            float(np.interp(log_load, log_loads, exponents)) for exponents in self.stiffness_exponents
        )
        return loading, unloading

    def scale_stiffness(self, ratios: Floats) -> Floats:
        """Return the closures (µm) that result if the closure stiffness at each load is multiplied by `ratios`.

        The arrays have the shape (l, ...). The closure is the integral of 1/stiffness over the load.
        """
        compliances = 1 / ratios
        means = (compliances[1:] + compliances[:-1]) / 2
        steps = np.diff(self.closures).reshape(-1, *[1] * (ratios.ndim - 1)) * means
        return np.cumsum(np.concatenate([self.closures[:1] * compliances[:1], steps]), axis=0)

    def interpolate(self, closures: Floats, load: Floats) -> Floats:
        """Interpolate closures at loads (mN) with power laws, and extrapolate them beyond the computed loads."""
        log_loads, logs = np.log(self.loads), np.log(closures)
        index = np.clip(np.searchsorted(self.loads, load), 1, self.loads.size - 1)
        below, above = (
            np.take_along_axis(logs, step_index[np.newaxis], axis=0)[0] for step_index in (index - 1, index)
        )
        position = (np.log(load) - log_loads[index - 1]) / (log_loads[index] - log_loads[index - 1])
        return np.asarray(np.exp(below + position * (above - below)))


def build_closure_curves(result: MemberSums) -> list[ClosureCurve | None]:
    """Return one curve of the gap's closure against load for each cutoff of a result.

    A curve is None if fewer than two closures are known.
    """
    num_cells = result.study.surfaces.cell_coordinates()["cut_off"].size
    names = ["closure", "closure_stiffness", "unloading_closure_stiffness"]
    if any(name not in result.head.variables for name in names):
        return [None] * num_cells
    means, loads = result.means(names), result.study.contact.loading_steps()
    curves: list[ClosureCurve | None] = []
    for closures, stiffnesses, unloading_stiffnesses in zip(
        *(np.asarray(means[name].transpose("cut_off", "load").values, float) for name in names), strict=True
    ):
        with np.errstate(invalid="ignore"):
            is_known = (closures > 0) & (stiffnesses > 0) & np.isfinite(closures) & np.isfinite(stiffnesses)
        is_known[is_known] &= np.diff(closures[is_known], prepend=0.0) > 0
        if is_known.sum() < 2:
            curves.append(None)
            continue
        known_loads = loads[is_known]
        exponents = np.stack(
            [compute_exponents(known_loads, stiffness[is_known]) for stiffness in (stiffnesses, unloading_stiffnesses)]
        )
        curves.append(ClosureCurve(known_loads, closures[is_known], exponents))
    return curves


class AreasBeforeShear(NamedTuple):
    """True contact areas (µm²) before shear: `elastic` without yielding, and `true` with yielding."""

    elastic: Floats
    true: Floats


@dataclass(frozen=True, kw_only=True)
class ResponseValues:
    """Quantities of a contact computed for given inputs, as arrays of equal shape.

    Attributes
    ----------
    friction_coefficient : array
        Infinite at seizure. A lower limit if the softer body shears.
    has_no_upper_limit : array of bool
        True at seizure, and if the softer body shears.
    area : array, µm²
        True area before shear.
    area_at_onset : array, µm²
        True area at the onset of sliding; infinite at seizure.
    plastic_friction : array
        Friction coefficient if all contacts yield. NaN for elastic bodies, and at seizure.
    """

    friction_coefficient: Floats
    has_no_upper_limit: NDArray[np.bool_]
    area: Floats
    area_at_onset: Floats
    plastic_friction: Floats

    def select_sample(self, *indices: int) -> ResponseValues:
        """Return the friction coefficient and the areas for a single sample of the inputs, given its array indices."""
        shape = np.shape(self.friction_coefficient)
        return ResponseValues(**{name: np.broadcast_to(array, shape)[indices] for name, array in vars(self).items()})


@dataclass(frozen=True, eq=False)
class ContactResponseToInputs:
    """Model of the effect of input changes on friction and contact quantities of a pair, at one load and sliding rule.

    Attributes
    ----------
    load : float, mN
    sums : mapping of str to float
        Contact sums, divided by the elastic load, at the central inputs and before contacts grow.
    area : AreaFunction
    central : InputValues
        Central values of all inputs.
    stiffness_exponents : pair of float
        Logarithmic derivatives of the normal stiffness while loading and while unloading with respect to the load.
    sums_at_no_load : mapping of str to float, optional
        Contact sums of adhesive bodies without an external load.
    closure_curve : ClosureCurve, optional
    """

    load: float
    sums: Mapping[str, float]
    area: AreaFunction
    central: InputValues
    stiffness_exponents: tuple[float, float] = (1.0, 1.0)
    sums_at_no_load: Mapping[str, float] | None = None
    closure_curve: ClosureCurve | None = None

    def areas_before_shear(self, inputs: InputValues) -> AreasBeforeShear:
        """Return two true areas (µm²) before shear for given inputs: without yielding and with yielding."""
        elastic_area = self.area.elastic_area(self.load, inputs.modulus * inputs.height_factor)
        return AreasBeforeShear(
            elastic_area, self.area(self.load, elastic_area=elastic_area, **_get_area_inputs(inputs))
        )

    def yield_pressure(self, inputs: InputValues) -> Any:
        """Return the pressure (GPa) on yielding contacts at the onset of sliding.

        Returns None if the study has no hardness.

        The pressure does not depend on the load, unless the depth of the indentation is known.
        """
        hardness = self.area.contact_hardness(self.load, inputs.hardness, inputs.size_effect)
        return None if hardness is None else inputs.law.yield_pressure(hardness)

    def evaluate(
        self, inputs: InputValues, known_areas: AreasBeforeShear | None = None, known_pressure: Any = None
    ) -> ResponseValues:
        """Return all quantities of the contact for given inputs.

        `known_areas` and `known_pressure` are the areas before shear and the yield pressure, if computed before.
        """
        elastic_area, area = self.areas_before_shear(inputs) if known_areas is None else known_areas
        central_area = self.area(self.load)
        law = inputs.law
        if self.area.hardness is None or np.any(inputs.junction_growth):
            known_values = {"elastic_area": elastic_area, "yield_pressure": known_pressure}
            onset = self.area.onset(law, self.load, **known_values, **_get_area_inputs(inputs))
        else:
            hardness = self.area.contact_hardness(self.load, inputs.hardness, inputs.size_effect)
            onset = OnsetState(law.plastic_coefficient(np.asarray(hardness)), area, np.ones(()))
        # Contacts with tau0 = 0 cannot seize, because their friction does not depend on the area.
        is_infinite = np.isinf(onset.area)
        is_seized = is_infinite & (np.asarray(inputs.tau0) > 0)
        sliding_area = np.where(is_infinite, area, onset.area)
        area_ratio = inputs.area_ratio * sliding_area / central_area
        coefficient = law.coefficient(self.sums, area_ratio, onset.friction_fraction)
        return ResponseValues(
            friction_coefficient=np.where(is_seized, np.inf, coefficient),
            has_no_upper_limit=is_seized | (onset.friction_fraction < 1),
            area=area,
            area_at_onset=onset.area,
            plastic_friction=onset.plastic_coefficient,
        )

    def stiffness_ratios(self, inputs: InputValues, area_before_shear: Floats) -> tuple[Floats, ...]:
        """Return normal and closure stiffness, in loading and unloading, divided by their values at the central inputs.

        The two normal stiffnesses come first.

        If E*, heights and hardness change by a common factor, the stiffness follows by similarity from the stiffness at
        the load divided by this factor. Any other change of the hardness acts through the true area. The stiffness
        keeps the measured hardness even if the depth of the indentation is known. Without a closure curve, the closure
        stiffnesses have the ratios of the others.
        """
        if self.area.indent is not None:
            response = replace(self, area=replace(self.area, indent=None))
            return response.stiffness_ratios(inputs, response.areas_before_shear(inputs).true)
        factor = np.asarray(inputs.modulus * inputs.height_factor)
        yielding_ratio = area_before_shear / self.area(self.load / factor)
        yielded_fraction = 1.0 - float(self.area.elastic_area(self.load) / self.area(self.load))
        area_exponents = LOADING_STIFFNESS_EXPONENT * yielded_fraction, UNLOADING_STIFFNESS_EXPONENT
        area_factors = [yielding_ratio**exponent for exponent in area_exponents]
        curve = self.closure_curve
        closure_exponents = self.stiffness_exponents if curve is None else curve.exponents_at(self.load)
        return tuple(
            factor ** (1.0 - exponent) / inputs.height_factor * area_factor
            for exponents in (self.stiffness_exponents, closure_exponents)
            for exponent, area_factor in zip(exponents, area_factors, strict=True)
        )

    def friction_at_no_load_ratio(self, inputs: InputValues) -> Floats:
        """Return the friction at zero load for given inputs, divided by the friction for the central inputs.

        The attraction is computed with the central inputs. The area changes as at the smallest computed load.
        """
        if self.sums_at_no_load is None:
            return np.full((), np.nan)
        smallest_load = replace(self, load=float(self.area.loads[0]))
        true_area = smallest_load.areas_before_shear(inputs).true
        area_ratio = true_area / smallest_load.areas_before_shear(self.central).true
        central_force = self.central.law.load("unloaded", self.sums_at_no_load, 1 - self.central.area_loss)
        force = inputs.law.load("unloaded", self.sums_at_no_load, area_ratio * (1 - inputs.area_loss))
        return force / central_force if central_force != 0 else np.ones_like(area_ratio)

    def closures_at_computed_loads(self, inputs: InputValues) -> Floats:
        """Return the closure (µm) of the gap at each computed load, for given inputs.

        E* and the heights are those of the study. The hardness is divided by their changes instead.
        """
        assert self.closure_curve is not None, "the closure is known"
        hardness = np.asarray(inputs.hardness / (inputs.modulus * inputs.height_factor))
        inputs = replace(inputs, hardness=hardness, modulus=1.0, height_factor=1.0)
        ratios = []
        for load in self.closure_curve.loads.tolist():
            response = replace(self, load=load)
            area = response.areas_before_shear(inputs).true
            ratio, *_ = response.stiffness_ratios(inputs, area)
            ratios.append(np.broadcast_to(ratio, np.broadcast_shapes(np.shape(area), hardness.shape)))
        return self.closure_curve.scale_stiffness(np.stack(ratios))

    def gap_closure_ratio(self, inputs: InputValues, closures: Floats) -> Floats:
        """Return the closure of the gap for given inputs, divided by its closure for the central inputs.

        By similarity, the closure is the height factor times the closure at the load divided by the change of E* and
        heights. `closures` comes from `closures_at_computed_loads`.
        """
        curve = self.closure_curve
        assert curve is not None, "the closure is known"
        loads = np.broadcast_to(self.load / (inputs.modulus * inputs.height_factor), closures.shape[1:])
        closure, central_closure = (
            curve.interpolate(closures, loads),
            curve.interpolate(curve.closures, np.asarray(self.load)),
        )
        return np.asarray(inputs.height_factor * closure / central_closure)

    def at_central_inputs(self, **changes: Any) -> ResponseValues:
        """Return all quantities of the contact at the central inputs, except for the inputs given in `changes`."""
        return self.evaluate(replace(self.central, **changes))
