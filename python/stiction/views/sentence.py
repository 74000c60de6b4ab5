"""Sentence to quote for a point of a summary, and its parts."""

from __future__ import annotations

import math
from inspect import signature
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from stiction._number_format import percent, quoted, significant, with_unit
from stiction.mechanics.closed_forms import gentle_friction
from stiction.studies.hardness import find_inputs
from stiction.studies.interfaces import find_interface
from stiction.studies.point import is_capped, law_of, modulus_of, pressure_of, shape_coordinate, value_of
from stiction.studies.summary import PointSummary
from stiction.surfaces.pairing import SIDES
from stiction.views.point import RULES, adhesion_text, load_text, materials_text, over_text
from stiction.views.pull_off import sticking_text

if TYPE_CHECKING:
    import xarray

    from stiction.studies.study import Study

READINGS_DIFFER = 0.01  # relative difference between the readings of a load from which on the answer says which it is
OTHER_KAPPA = 0.2
"""Relative difference of A E* h'/F from the usual value above which the small-slope estimate is no check."""

KAPPA = float(signature(gentle_friction).parameters["kappa"].default)
"""Usual A E* h'/F, with which `at_load` calls `gentle_friction`."""


def finer_text(one: PointSummary) -> str:
    """Return the ends between which every finer scan lies, with the hardness; empty without a bracket."""
    if one.bracket is None or one.hardness is None:
        return ""
    low, high = (f"{end:.3f}" for end in one.bracket)
    ends = f"{low} (μ0 + τ0/{'H′' if one.grows else 'H'})" + (f" to {high}" if low != high else "")
    return f"with H = {with_unit(one.hardness, 'GPa')} a finer scan would give {ends}"


def sentence_text(one: PointSummary) -> str:
    """Return the sentence to quote with its inputs, or why there is none."""
    assumed = assumed_of(one)
    if one.unloaded and one.sticking is not None:
        parts = [f"{sticking_text(one.sticking).removesuffix('.')}, at {inputs_text(one)}", note_text(one)]
        return "; ".join([*parts, f"assumed: {', '.join(assumed)}"]) + "."
    if one.verdict == "Do not quote":
        faults = "; ".join(doubt.text for doubt in one.faults)
        return f"There is no coefficient to quote at {inputs_text(one)}: {faults}."
    first, *others = one.rules
    words = f"μ_s = {quoted(first.value, first.lower, first.upper)} with {RULES[first.rule]}"
    words += "".join(f", {quoted(one.value, one.lower, one.upper)} with {RULES[one.rule]}" for one in others)
    parts = [f"{words}, at {inputs_text(one)}", note_text(one)]
    parts += [f"assumed: {', '.join(assumed)}"] if assumed else []
    parts += filter(None, [covers_text(one), roughness_text(one), finer_text(one)])
    return "; ".join(parts) + "."


def covers_text(one: PointSummary) -> str:
    """Return the contributions to the 95 % interval of the first rule; empty without an interval."""
    if math.isnan(one.upper - one.lower) or one.members < 2:
        return ""
    inputs = dict.fromkeys(left.words for left in one.budget) or [f"the mean over {_averaged(one)}"]
    return f"95 % interval of {', '.join(inputs)}"


def roughness_text(one: PointSummary) -> str:
    """Return the part of the coefficient that roughness contributes; empty if it is unknown."""
    if one.from_roughness is None or not math.isfinite(one.value):
        return ""
    return f"roughness contributes {round(one.from_roughness, 3) + 0.0:.3f} of {one.value:.3f}"


# ---- Conditions ------------------------------------------------------------------------------------------------------


def inputs_text(one: PointSummary) -> str:
    """Return load, materials and resolution in words."""
    point, study = one.values, one.study
    words = [load_text(point, study)]
    if "fractal_dimension" in point.coords:
        name, value = shape_coordinate(study, float(point["fractal_dimension"]))
        words.append(f"{name} = {value:.3g}")
    if "amplitude" in point.coords:
        words.append(f"amplitude {with_unit(float(point['amplitude']), 'um')}")
    words.append(f"μ0 = {float(point['mu0']):g}{_asked(point, study, 'mu0')}")
    adhesion = with_unit(float(point["tau0"]), "GPa") if float(point["tau0"]) else "0"
    words.append(f"τ0 = {adhesion}{_asked(point, study, 'tau0')}")
    if study.known.interface is not None and all(_is_asked(point, study, name) for name in ("mu0", "tau0")):
        words.append(_interface_words(study))
    if made_of := materials_text(study):
        words.append(made_of)
    words.append(f"E* = {with_unit(modulus_of(point, study), 'GPa')}")
    hardness = study.contact.hardness
    if hardness is not None:
        words.append(f"hardness {with_unit(float(hardness), 'GPa')}{_range(study)}")
        if growth := study.contact.junction_growth:
            words.append(f"α = {study.known.junction_growth or f'{growth:g}'}")
    elif study.is_measured:
        words.append("yielding by Jackson and Green" if "jackson" in law_of(study) else "elastic")
    if study.contact.adheres:
        words.append(adhesion_text(point, study))
    if "spacing_um" in point.attrs:
        steps = np.unique(np.atleast_1d(point.attrs["spacing_um"]).astype(float)).tolist()
        words.append(f"points {' and '.join(with_unit(step, 'um') for step in steps)} apart")
    if "cut_off" in point.coords and float(point["cut_off"]) > 0:
        words.append(f"low-pass filtered at {with_unit(float(point['cut_off']), 'um')}")
    return ", ".join(words)


def _asked(point: xarray.Dataset, study: Study, name: str) -> str:
    """Return the range of mu0 or tau0 as it was given, if the point is at its central value."""
    text = getattr(study.known, name)
    return f" ({text})" if text is not None and _is_asked(point, study, name) else ""


def _is_asked(point: xarray.Dataset, study: Study, name: str) -> bool:
    return math.isclose(float(point[name]), float(getattr(study.friction, name)[0]), rel_tol=1e-3)


def _interface_words(study: Study) -> str:
    """Return name, kind and conditions of the interface that mu0 and tau0 are from."""
    found, name = find_interface(study), Path(str(study.known.interface)).name
    if found is None:
        return f"interface {name}, which is missing, so μ0 and τ0 are independent"
    fit, words = found.fits[0], [found.about.get("kind", "measured"), found.about.get("motion", "")]
    words += [RULES[fit.sliding]] if fit.sliding != "all" else []
    words += ["its range is unknown"] if np.ptp(fit.mu0) == np.ptp(fit.tau0) == 0 else []
    return f"interface {name} ({', '.join(filter(None, words))})"


def _range(study: Study) -> str:
    """Return the range of the hardness; empty for a single number."""
    found = find_inputs(study).get("hardness")
    if found is None:
        return ""
    if study.known.hardness is not None:
        return f" ({study.known.hardness})"
    return f" ({with_unit(found.estimate.low, 'GPa')} to {with_unit(found.estimate.high, 'GPa')})"


_READINGS = {
    "mean": "the load is the mean normal load of all members",
    "elastic": "the load is that of the elastic contact, before friction on slopes adds to it",
    "normal": "the load is the normal load of each member",
}


def note_text(one: PointSummary) -> str:
    """Return what was averaged, and which reading of the load it is."""
    point, study = one.values, one.study
    words = []
    if study.surfaces.press == "lines" and point["direction"].size == 2:
        words.append("the mean over both directions")
    elif "direction" in point.coords and (study.is_measured or point["direction"].size > 1):
        words.append(over_text(np.atleast_1d(point["direction"].values)).removesuffix(" all round"))
    if value_of(point, "members") > 1:
        words = [f"{words[0]} and {_averaged(one)}"] if words else [f"the mean over {_averaged(one)}"]
    words += [_scans_text(study)] if study.is_measured else []
    difference = value_of(point, "reading_difference")
    if difference > READINGS_DIFFER:
        reading = _READINGS.get(str(point.attrs.get("reading")), "the load has one of three meanings")
        words.append(f"{reading}; with another meaning of the load μ_s differs by {percent(difference)}")
    return "; ".join(words)


def _averaged(one: PointSummary) -> str:
    """Return how many members were averaged, and of which kind."""
    study = one.study
    kind = "pairs" if not study.is_measured else "positions"
    kind = "pairs of random surfaces with these spectra" if study.surfaces.press == "surrogates" else kind
    return f"{one.members:.0f} {kind}"


STRIP = "a strip 1 µm wide"  # of the paper, which profiles stand for


def assumptions_of(study: Study) -> tuple[str, ...]:
    """Return the assumptions of a study: lay and width of profiles, contact model, adhesion."""
    if not study.is_measured:
        return ()
    surfaces, contact, words = study.surfaces, study.contact, []
    if surfaces.press == "lines":
        is_plane = study.by_half_space or "cylinder" in law_of(study)
        words.append(f"{'parallel grooves across the scans' if is_plane else 'contacts of spheres'} on {STRIP}")
    elif surfaces.press == "surrogates":
        words.append("isotropic surfaces")
    words += [] if study.by_half_space else ["contacts that do not interact"]
    words += [] if contact.hardness is not None or "jackson" in law_of(study) else ["elastic contact"]
    words += ["no adhesion"] if contact.work_of_adhesion is None else []
    return tuple(words)


def assumed_of(one: PointSummary) -> tuple[str, ...]:
    """Return all assumptions that the sentence names."""
    point, study = one.values, one.study
    if not study.is_measured:
        return ()
    words = [] if study.known.interface is not None else ["μ0 and τ0 as given"]
    if study.by_half_space:
        words.append("contact of half-spaces" if study.contact.hardness is None else "contact of yielding half-spaces")
    words += assumptions_of(study)
    cut_off = float(point["cut_off"]) if "cut_off" in point.coords else 0.0
    words.append(f"scans filtered at {with_unit(cut_off, 'um')}" if cut_off > 0 else "scans not filtered")
    return tuple(words)


def _scans_text(study: Study) -> str:
    """Return the number of scans of each part, and the part-to-part variability that is not in the interval."""
    counts = study.surfaces.scan_counts
    if study.is_gap:
        return "one gap at its one position"
    if counts == (1, 1):
        return "one scan of each part"
    words = f"{counts[0]} × {counts[1]} scans of both parts"
    single = [side for side, count in zip(SIDES, counts, strict=True) if count == 1]
    return words + "".join(
        f", but one of the {side}, so the spread between its places is not included" for side in single
    )


def slopes_text(one: PointSummary) -> str:
    """Return the small-slope estimate and its limits; empty if the result has none."""
    point, study = one.values, one.study
    known = [rule for rule in one.rules if math.isfinite(rule.slopes)]
    if not known:
        return ""
    values = " and ".join(f"{quoted(rule.slopes)} with {RULES[rule.rule]}" for rule in known)
    without = " (the hardness is not considered)" if is_capped(study) else ""
    kappa = value_of(point, "rms_gradient") * modulus_of(point, study) / pressure_of(point)
    if float(point["tau0"]) > 0 and abs(kappa / KAPPA - 1) > OTHER_KAPPA:
        return (
            f"The small-slope estimate does not apply: it assumes A E* h'/F = {KAPPA:g}, and this pair has "
            f"{significant(kappa)}. It would be {values}{without}."
        )
    return f"Small-slope estimate: {values}{without}."
