"""Uncertain inputs of a measured pair, and its true area over ranges of hardness and E*.

A few members of the pair are solved at a few other hardnesses and moduli.
"""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import Executor
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np

from stiction._checks import Floats
from stiction.mechanics.half_space import HalfSpaceCurve, half_space, solve_separately
from stiction.mechanics.hardness import area_per_load
from stiction.mechanics.materials import Material, material, softer_material
from stiction.mechanics.resolution import KAPPA
from stiction.studies.contact_tables import HalfSpaceContactTable
from stiction.studies.input_uncertainty import UncertainInput, parse_input, parse_study_input
from stiction.studies.members import count_points, load_bodies
from stiction.studies.moduli import Moduli, find_material_hardness, find_material_moduli
from stiction.studies.store import StoredResult, read_companion
from stiction.studies.study import Study
from stiction.surfaces.pairing import SIDES

if TYPE_CHECKING:
    import xarray

    from stiction.studies.result import Result

AREAS_FILE = "hardness.nc"
"""File in the folder of a result with the true areas of its first members at the nodes."""

NUM_MAP_MEMBERS, NUM_LARGE_MAP_MEMBERS, NUM_PROFILE_MEMBERS = 4, 2, 16
"""Numbers of members that are solved at other hardnesses: of maps, of large maps, and of profiles."""

MIN_LARGE_MAP_POINTS = 2**19
"""Points of a large map. Members of 384² points differ by 0.1 % if all contacts yield, and by 2 % if some do."""

MIN_ERROR_MEMBERS = 2  # members from whose scatter the error of the area over hardness is estimated

NODE_POSITIONS = {1: (0.0, 0.15, 0.35, 0.65, 0.85, 1.0), 3: (0.0, 0.1, 0.25, 0.4, 0.6, 0.75, 0.9, 1.0)}
"""Positions of nodes in the range of ln H, by the number of moduli; the study's own and elastic bodies are added."""

MAX_NARROW_HALF_RANGE = 0.2
"""Half of the range of ln E* below which the growth of the area with the load replaces solutions at other moduli."""

SHEAR_NODE_STEP, NUM_SHEAR_NODES = 0.6, 3
"""Step of ln H between the nodes that junction growth adds below the range of the hardness, and their number.

Below the last node contacts are taken as plastic: their area is proportional to 1/H."""

NODE_QUANTILES = (0.005, 0.995)
"""Quantiles of a range between which nodes lie."""
_MODULUS_LABELS = {"young": "Young's modulus", "poisson": "Poisson's ratio"}
THREE_DIGIT_ERROR = 0.006  # largest relative error of a number in three digits


@dataclass(frozen=True)
class LabelledInput:
    """An uncertain input of a study and its label."""

    label: str
    estimate: UncertainInput


def find_inputs(study: Study) -> dict[str, LabelledInput]:
    """Return the uncertain inputs of a study of measured bodies by their names."""
    if not study.is_measured:
        return {}
    table, contact = study.known, study.contact
    bodies = find_materials(study)
    found: dict[str, LabelledInput] = {}
    for name, words, kind in (("mu0", "μ0", ""), ("tau0", "τ0", "pressure")):
        if (text := getattr(table, name)) is not None:
            found[name] = LabelledInput(words, parse_input(name, text, kind))  # type: ignore[arg-type]
    moduli = find_moduli(study).inputs
    if "effective_modulus" in moduli:
        found["effective_modulus"] = LabelledInput("E*", moduli.pop("effective_modulus"))
    if contact.hardness is not None:
        softer = softer_material(*bodies)
        words = f"the hardness of the {softer.name}" if softer else "the hardness"
        if table.hardness is not None:
            found["hardness"] = LabelledInput(words, parse_input("hardness", table.hardness, "hardness"))
        elif softer and softer.hardness and abs(float(contact.hardness) / softer.hardness - 1) < THREE_DIGIT_ERROR:
            found["hardness"] = LabelledInput(words, find_material_hardness(softer.hardness))
    if (growth := find_junction_growth(study)) is not None:
        found["junction_growth"] = LabelledInput("the junction growth α", growth)
    for key, value in moduli.items():
        name, _, side = key.partition("_")
        words = f"{_MODULUS_LABELS[name]} of the {bodies[SIDES.index(side)].name if bodies else f'{side} body'}"
        found[key] = LabelledInput(words, value)
    return {name: each for name, each in found.items() if not each.estimate.is_exact}


def find_junction_growth(study: Study) -> UncertainInput | None:
    """Return α of junction growth, whose middle is the study's own; None if contacts do not grow."""
    own = study.contact.junction_growth
    return replace(parse_input("junction_growth", study.known.junction_growth or own), value=own) if own else None


def find_creep(study: Study) -> UncertainInput | None:
    """Return the exponent of indentation creep; None if the study has no dwell time."""
    return parse_input("creep", study.known.creep) if study.friction.wait and study.known.creep else None


def find_moduli(study: Study) -> Moduli:
    """Return the moduli of a study with their uncertainty."""
    table, materials, middle = study.known, find_materials(study), float(study.contact.effective_modulus)
    if table.effective_modulus is not None:
        return Moduli(middle, parse_input("effective_modulus", table.effective_modulus, "modulus"))
    if table.young is not None and table.poisson is not None:
        given = [(table.young[i % len(table.young)], table.poisson[i % len(table.poisson)]) for i in range(2)]
        bodies = [
            {"young": parse_input("young", e, "modulus"), "poisson": parse_study_input("poisson", nu)}
            for e, nu in given
        ]
        return Moduli(middle, bodies=tuple(bodies))
    bodies = [find_material_moduli(each) for each in materials]
    return Moduli(middle, bodies=tuple(bodies), is_one_material=bool(materials) and materials[0] == materials[1])


def find_materials(study: Study) -> tuple[Material, ...]:
    """Return the materials of both bodies from the table of materials; empty if a name is not in the table."""
    try:
        return tuple(material(name) for name in study.contact.materials or ())
    except ValueError:
        return ()


def compute_relative_modulus(study: Study, drawn: Mapping[str, Floats]) -> Floats | float:
    """Return E* over that of the study, from samples of its inputs by their names."""
    return find_moduli(study).relative(drawn)


# ---- Areas over hardness ---------------------------------------------------------------------------------------------


def choose_area_nodes(study: Study) -> tuple[Floats, Floats]:
    """Return hardnesses over relative moduli (GPa), and relative moduli (E* over that of the study), to solve.

    The last hardness is infinity, for elastic bodies. There are no hardnesses if hardness and E* are numbers or narrow
    ranges, and the study has neither dwell times nor junction growth.
    """
    inputs, creep, own = find_inputs(study), find_creep(study), study.contact.hardness
    # Relative range of E*: contributions of its inputs, each at its ends, added in quadrature.
    steps = [
        np.ptp(np.log(compute_relative_modulus(study, {name: each.estimate.quantile(NODE_QUANTILES)}))) / 2
        for name, each in inputs.items()
        if name not in ("mu0", "tau0", "hardness", "junction_growth")
    ]
    wide = float(np.hypot.reduce([0.0, *steps]))
    moduli = np.exp([-wide, 0.0, wide]) if wide > MAX_NARROW_HALF_RANGE else np.ones(1)
    if own is None:
        return np.array([np.inf] if moduli.size > 1 else []), moduli
    if "hardness" not in inputs and creep is None and moduli.size == 1 and find_junction_growth(study) is None:
        return np.zeros(0), moduli
    ends = inputs["hardness"].estimate.quantile(NODE_QUANTILES) if "hardness" in inputs else np.repeat(float(own), 2)
    if creep is not None:
        falls = np.power.outer([1.0, *study.friction.wait], -creep.quantile(NODE_QUANTILES))
        ends = ends * [falls.min(), falls.max()]
    half = np.hypot(np.ptp(np.log(ends)) / 2, np.log(moduli[-1]))
    parts = np.exp(half * (2 * np.array(NODE_POSITIONS[moduli.size]) - 1)) if half > 0 else np.ones(0)
    nodes = np.unique([*np.sqrt(ends.prod()) * parts, float(own), np.inf])
    return np.unique([*_choose_shear_nodes(study, float(nodes[0])), *nodes]), moduli


def _choose_shear_nodes(study: Study, softest: float) -> Floats:
    """Return the nodes below a hardness (GPa) for junction growth, which serve all mu0 and tau0."""
    if find_junction_growth(study) is None:
        return np.zeros(0)
    return np.asarray(softest * np.exp(-SHEAR_NODE_STEP * np.arange(1, NUM_SHEAR_NODES + 1)))


def compute_areas_over_hardness(study: Study, executor: Executor) -> xarray.Dataset | None:
    """Compute true areas (µm²) of the first members over hardness (GPa), E* and loads; None if no input has a range."""
    import xarray

    hardnesses, moduli = choose_area_nodes(study)
    if not hardnesses.size:
        return None
    loads = np.array([float(load) for load in study.friction.load])
    members = _count_members(study)
    tasks = list(product(range(members), moduli.tolist(), hardnesses.tolist()))
    found = np.array(list(executor.map(partial(_solve_member_areas, study, loads), tasks)))
    areas = found.reshape(members, moduli.size, hardnesses.size, -1, loads.size)
    dims = ("repetition", "relative_modulus", "hardness", "load")
    return xarray.Dataset(
        {name: (dims, areas[..., index, :], {"units": "um^2"}) for index, name in enumerate(_list_area_names(study))},
        {
            "hardness": ("hardness", hardnesses, {"units": "GPa", "long_name": "hardness over the relative modulus"}),
            "relative_modulus": ("relative_modulus", moduli, {"units": "1"}),
            "load": ("load", loads, {"units": "mN"}),
        },
        {"title": "true area over hardness and E*"},
    )  # fmt: skip


def count_solutions(study: Study) -> int:
    """Return the number of solutions that `compute_areas_over_hardness` needs."""
    hardnesses, moduli = choose_area_nodes(study)
    return hardnesses.size * moduli.size * _count_members(study) * len(study.friction.load) if hardnesses.size else 0


def _count_members(study: Study) -> int:
    few = NUM_LARGE_MAP_MEMBERS if count_points(study) >= MIN_LARGE_MAP_POINTS else NUM_MAP_MEMBERS
    return min(few if study.is_areal else NUM_PROFILE_MEMBERS, study.ensemble.repetitions)


def _list_area_names(study: Study) -> tuple[str, ...]:
    """Return the names of the areas that are solved over hardness."""
    return ("contact_area", "opposing_area") if find_junction_growth(study) is not None else ("contact_area",)


def _solve_member_areas(study: Study, loads: Floats, task: tuple[int, float, float]) -> Floats:
    """Return true areas (µm²), (areas, loads), of a member at a relative E* and a hardness over it.

    With junction growth the second area is that of the contacts that oppose the motion, times their slope factors, as a
    mean over directions. Areas are NaN at loads that the member does not bear.
    """
    index, modulus, ratio = task
    bodies, contact, hardness = load_bodies(study), study.contact, modulus * ratio
    surfaces: Any = study.surfaces
    upper, lower = bodies.member(index, surfaces.quoted_cut_off()).pair
    assert isinstance(contact, HalfSpaceContactTable), "the mechanics must be half-space"
    modulus *= float(contact.effective_modulus)
    solid = contact.solid() | {"hardness": hardness if np.isfinite(hardness) else None, "effective_modulus": modulus}
    can = np.flatnonzero(loads < hardness * float(bodies.attributes().nominal_area or 0.0))
    areas = np.full((len(_list_area_names(study)), loads.size), np.nan)
    solid |= {"direction": contact.degrees().tolist()} if study.is_areal and len(areas) > 1 else {}
    for at, curve in (
        solve_separately(partial(half_space, upper, lower, **solid, sliding="all"), loads[can]) if can.size else ()
    ):
        areas[0, can[at]] = curve.contact_area
        if len(areas) > 1:
            areas[1, can[at]] = _compute_opposing_area(curve, is_areal=study.is_areal)
    return areas


def _compute_opposing_area(curve: HalfSpaceCurve, *, is_areal: bool) -> Floats:
    """Return the tangential load per shear strength (µm²) of the contacts that oppose the motion, over the loads."""
    opposing = curve.with_sliding("opposing")
    ways = [opposing] if is_areal else [opposing, opposing.with_direction("-x")]
    sums = np.mean([each.tangential_adhesive for each in ways], axis=0)
    return np.asarray(sums.reshape(-1, sums.shape[-1]).mean(axis=0))


def load_areas_over_hardness(result: StoredResult) -> xarray.Dataset | None:
    """Return the stored areas of a result; None if there are none for its nodes and loads."""
    study = result.study
    hardnesses, moduli = choose_area_nodes(study) if study.is_measured else (np.zeros(0), np.ones(1))
    wanted = hardnesses, moduli, np.array([float(load) for load in study.friction.load])
    names = ("hardness", "relative_modulus", "load")
    found = read_companion(result.path / AREAS_FILE, (*names, *_list_area_names(study))) if hardnesses.size else None
    if found is None:
        return None
    there = [found[name].values for name in names]
    same = all(
        one.shape == other.shape and np.allclose(one, other, rtol=1e-9)
        for one, other in zip(there, wanted, strict=True)
    )
    return found if same else None


@dataclass(frozen=True)
class AreaInterpolator:
    """True area at each load over hardness and E*.

    A solution at (F, E*, H) equals that at (F/e, E*/e, H/e), which has the study's E* and another load and hardness.
    """

    hardness: float | None  # GPa, of the study
    nodes: Floats  # (n,) H/e, GPa
    at_nodes: Floats  # (loads, m, n) e A/F, 1/GPa
    elastic: Floats  # (loads, m) e A/F of elastic bodies
    moduli: Floats  # (m,) e, E* over that of the study
    growth: Floats  # (loads,) d ln(A/F) / d ln F
    errors: Floats  # (loads, n) relative standard error of A at the nodes over that of the study
    pressures: Floats  # (loads,) over the nominal area, GPa
    opposing: Floats | None = None  # (loads, n) e A/F of opposing contacts at the study's E*
    kept: dict[Any, Any] = field(default_factory=dict)  # samples that several points share

    @classmethod
    def of(
        cls, loads: Floats, ratio: Floats, gradient: float, growth: Floats, study: Study, result: Result
    ) -> AreaInterpolator:
        """Return the areas of a result.

        Parameters
        ----------
        loads : (l,) array of float, mN
        ratio : (l,) array of float, 1/GPa
            Mean true area over the load.
        gradient : float
            Rms gradient of the gap.
        growth : (l,) array of float
            d ln(A/F) / d ln F.
        study : Study
        result : Result
        """
        own = None if study.contact.hardness is None else float(study.contact.hardness)
        pressures = loads / float(result.head["nominal_area"])
        solved = result.alongside(load_areas_over_hardness)
        # The value itself depends on the areas of junction growth, at every load.
        grows = bool(study.contact.junction_growth)
        if solved is not None and (grows or set(loads.tolist()) <= set(solved["load"].values.tolist())):
            means = solved.mean("repetition")
            over = (means * means["relative_modulus"] / means["load"]).transpose("load", "relative_modulus", "hardness")
            over = _interpolate_loads(over, loads)
            areas, nodes, moduli = over["contact_area"], over["hardness"].values, over["relative_modulus"].values
            borne = np.isfinite(areas.values).all(axis=(0, 1))
            if borne[-1] and (own is None or borne.sum() > 1):
                finite = borne & np.isfinite(nodes)
                table = nodes[finite], areas.values[..., finite], areas.values[..., -1]
                growth = growth if moduli.size == 1 else np.zeros(loads.size)
                errors = _estimate_node_errors(solved.sel(load=loads, method="nearest"), own)[:, finite]
                opposing = (
                    over["opposing_area"].values[:, moduli.size // 2, finite] if "opposing_area" in over else None
                )
                return cls(own, *table, moduli, growth, errors, pressures, opposing)
        column = ratio[:, np.newaxis]
        if own is None:
            none = np.zeros((loads.size, 0))
            return cls(None, np.zeros(0), none[:, np.newaxis], column, np.ones(1), growth, none, pressures)
        # Without solutions at other hardnesses the area follows `area_per_load` through that of the study.
        elastic = np.full((loads.size, 1), KAPPA / (float(study.contact.effective_modulus) * gradient))
        none = np.zeros((loads.size, 1))
        return cls(own, np.array([own]), column[..., np.newaxis], elastic, np.ones(1), growth, none, pressures)

    def factor(self, load: int, hardness: Floats | None, modulus: Floats | float) -> Floats:
        """Return the true area over that of the study, for hardnesses (GPa) and E* over that of the study."""
        if hardness is None or self.hardness is None:
            now, own = self.elastic[load][:, np.newaxis], self.elastic[load][:, np.newaxis]
        else:
            known = self.nodes, self.at_nodes[load], self.elastic[load]
            ratio = np.asarray(hardness / modulus)
            now, own = (area_per_load(np.ravel(each), *known) for each in (ratio, self.hardness))
            now = now.reshape(-1, *(ratio.shape or (1,)))
        scale = np.power(modulus, -(1.0 + self.growth[load]))
        return np.asarray(scale * _interpolate_moduli(now, self.moduli, modulus) / own[self.moduli.size // 2])

    def error(self, load: int, hardness: Floats) -> Floats:
        """Return the relative standard error of `factor` at hardnesses over the relative modulus (GPa)."""
        return np.asarray(np.interp(np.log(hardness), np.log(self.nodes), self.errors[load]))

    def grown(
        self, load: int, rule: str, hardness: Floats, under_shear: Floats, modulus: Floats | float = 1.0
    ) -> Floats:
        """Return the true area of sheared contacts at the onset of sliding over that before shear.

        Parameters
        ----------
        load : int
            Index of the load.
        rule : {"all", "opposing"}
            With "opposing" only opposing contacts are sheared. Their area is an upper bound, because it is that of a
            pair in which the other contacts have H' too.
        hardness, under_shear : array of float, GPa
            H and H' of `hardness_under_shear`; NaN of H' is seizure.
        modulus : array_like of float
            E* over that of the study.

        Returns
        -------
        array of float
            Infinite at seizure: H' is NaN, or the nominal area does not carry the load at H'.
        """
        known = under_shear > self.pressures[load]
        pressure = np.where(known, under_shear, hardness)
        ratio = self._sheared_area(load, rule, pressure, modulus) / self._area_before(load, rule, hardness, modulus)
        return np.where(known, np.where(pressure == hardness, 1.0, ratio), np.inf)

    def _sheared_area(self, load: int, rule: str, hardness: Floats, modulus: Floats | float) -> Floats:
        """Return the true area of sheared contacts up to a factor."""
        if rule == "all" or self.opposing is None:
            return self.factor(load, hardness, modulus)
        ratio = np.asarray(hardness / modulus)
        return area_per_load(ratio.ravel(), self.nodes, *self.sheared(load, rule)).reshape(ratio.shape)

    def _area_before(self, load: int, rule: str, hardness: Floats, modulus: Floats | float) -> Floats:
        """Return `_sheared_area` before shear, cached because many mu0 and tau0 share the hardnesses."""
        key = "before", load, rule
        kept = self.kept.get(key)
        if kept is None or kept[0] is not hardness or kept[1] is not modulus:
            kept = hardness, modulus, self._sheared_area(load, rule, hardness, modulus)
            if hardness.size > 1:  # of samples
                self.kept[key] = kept
        return np.asarray(kept[2])

    def sheared(self, load: int, rule: str) -> tuple[Floats, float]:
        """Return A/F (1/GPa) of the sheared contacts at the nodes and of elastic bodies, at the study's own E*."""
        middle = self.moduli.size // 2
        areas, elastic = self.at_nodes[load, middle], float(self.elastic[load, middle])
        if rule == "all" or self.opposing is None:
            return areas, elastic
        return self.opposing[load], elastic * float(self.opposing[load, -1] / areas[-1])


def _interpolate_loads(areas: xarray.Dataset, loads: Floats) -> xarray.Dataset:
    """Return areas at loads, interpolated as powers of the load and constant beyond the loads of the dataset."""
    import xarray

    there = areas["load"].values
    place = np.interp(np.log(loads), np.log(there), np.arange(there.size))
    below = np.floor(place).astype(int)
    lower, upper = (areas.isel(load=each).drop_vars("load") for each in (below, np.ceil(place).astype(int)))
    part = xarray.DataArray(place - below, dims="load")
    return lower ** (1 - part) * upper**part  # exact at loads of the dataset, even if the neighbor is NaN


def _estimate_node_errors(solved: xarray.Dataset, own: float | None) -> Floats:
    """Return (loads, n) relative standard errors of the area at the nodes over that at the study's hardness."""
    area = solved["contact_area"].sel(relative_modulus=1.0, method="nearest")
    area = area.transpose("load", "hardness", "repetition")
    count = area.sizes["repetition"]
    if own is None or count < MIN_ERROR_MEMBERS:
        return np.zeros(area.shape[:2])
    relative = np.log((area / area.sel(hardness=own, method="nearest")).values)
    return np.asarray(relative.std(axis=-1, ddof=1) / np.sqrt(count))


def _interpolate_moduli(values: Floats, moduli: Floats, wanted: Floats | float) -> Floats:
    """Interpolate positive values over moduli e^(-w), 1, e^w by a parabola of their logarithms in ln E*."""
    if moduli.size == 1:
        return np.asarray(values[0])
    softer, own, stiffer = np.log(values)
    part = np.log(wanted) / np.log(moduli[-1])
    return np.asarray(np.exp(own + part * (stiffer - softer) / 2 + part**2 * (stiffer + softer - 2 * own) / 2))
