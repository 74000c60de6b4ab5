"""What may be quoted of a result: value, verdict and doubts at one load, for every kind of result and every reader.

The terminal, JSON, CSV and pages all take their answer from here. Nothing is computed but what compares: means and
intervals are those that `at_load` gives.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from inspect import signature
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from stiction.mechanics import friction
from stiction.mechanics.brackets import friction_bracket
from stiction.mechanics.closed_forms import gentle_friction
from stiction.studies.hardness import inputs_of
from stiction.studies.interfaces import interface_of
from stiction.surfaces.pairing import SIDES
from stiction.views.digits import percent, quoted, significant, with_unit
from stiction.views.doubts import MORE_CONTACTS, VERDICTS, doubts_of
from stiction.views.doubts import WIDE as WIDE
from stiction.views.doubts import Doubt as Doubt
from stiction.views.point import (
    CELLS,
    STATISTICS,
    RuleValue,
    adhesion_text,
    by_rule,
    contact_status_of,
    is_capped,
    is_unloaded,
    law_of,
    load_text,
    materials_text,
    modulus_of,
    pressure_of,
    rules_of,
    shape_coordinate,
    value_of,
)
from stiction.views.point import RULES as RULES
from stiction.views.point import over_text as over_text
from stiction.views.point import points as points
from stiction.views.resolution import plastic_adhesion
from stiction.views.sticking import Sticking, sticking_of

if TYPE_CHECKING:
    import xarray

    from stiction.studies.study import Study

READINGS_DIFFER = 0.01  # relative difference between the readings of a load from which on the answer says which it is
ORIGIN = "waves of unknown origin"  # as a part of the uncertainty
DECIDES = 0.1  # part of the width of an interval that an input has to take away, if it were known, to be named

OTHER_KAPPA = 0.2
"""Relative difference of A E* h'/F from the usual one, from which on the slopes alone say something else."""

KAPPA = float(signature(gentle_friction).parameters["kappa"].default)
"""Usual A E* h'/F: the one with which `at_load` calls `gentle_friction`."""


@dataclass(frozen=True)
class Left:
    """The interval that would be left if one input were known exactly, the mean width of it, and the input's name."""

    words: str
    lower: float
    upper: float
    width: float


@dataclass(frozen=True)
class Waited:
    """The coefficient after some time under load, and its 95 % interval of everything known."""

    seconds: float
    value: float
    lower: float
    upper: float


@dataclass(frozen=True)
class Answer:
    """What a result says at one load, for one mu0 and tau0: `rules` has the rule to quote first."""

    rules: tuple[RuleValue, ...]
    status: str  # "ok", or why there is no coefficient
    load: str  # with its unit, and over the nominal area where there is one
    inputs: str  # load, materials and resolution, in words
    note: str  # what was averaged, and which reading of the load it is
    assumptions: tuple[str, ...] = ()  # how the scans stand for surfaces, and the contact model
    assumed: tuple[str, ...] = ()  # all that the sentence names: these, mu0 and tau0, the contact model and filters
    doubts: tuple[Doubt, ...] = ()  # faults first
    at: dict[str, Any] = field(default_factory=dict)  # the cell, Hurst exponent, load (mN), mu0 and tau0 (GPa)
    # With a hardness, and a value to quote: between mu0 + tau0/H and the upper end of the interval at this scan, with
    # what few contacts leave open, every finer scan lies where all contacts rub.
    bracket: tuple[float, float] | None = None
    hardness: float | None = None  # at which the bracket holds, GPa
    from_roughness: float | None = None  # part of the value that the scans contribute, beyond the inputs
    budget: tuple[Left, ...] = ()  # what would be left of its interval if an input were known, the most important first
    parts: tuple[float, float, float] | None = None  # what holds the bodies: mu0, adhesion on the true area, and slopes
    waited: tuple[Waited, ...] = ()  # after each time that the study waits
    covered: bool = False  # whether it is one of two readings of a scan, and the interval of the other one covers it
    members: float = math.nan  # how many were averaged, and what they are
    averaged: str = ""
    scans: tuple[int, int] = (1, 1)  # places of the upper and of the lower part that were scanned
    sticking: Sticking | None = None  # of bodies that adhere
    contact_status: str = "ok"  # of the true area: "ok", "complete" or "above-nominal"
    grows: bool = False  # whether contacts that have yielded grow under shear
    unloaded: bool = False  # whether the load is negligible beside the pull-off force

    @property
    def value(self) -> float:
        """By the rule to quote."""
        return self.rules[0].value

    @property
    def lower(self) -> float:
        """Lower end of its 95 % interval."""
        return self.rules[0].lower

    @property
    def upper(self) -> float:
        """Upper end of its 95 % interval."""
        return self.rules[0].upper

    @property
    def most(self) -> Left | None:
        """The input that decides the width of the interval, if one does."""
        first, width = self.budget[:1], self.upper - self.lower
        return first[0] if first and first[0].width < (1 - DECIDES) * width else None

    @property
    def ageing(self) -> float:
        """Growth of the coefficient over that of the logarithm of the time, from 1 s to the last one; NaN of none."""
        last = self.waited[-1] if self.waited else Waited(1.0, self.value, self.lower, self.upper)
        return (last.value - self.value) / math.log(last.seconds) if last.seconds != 1 else math.nan

    @property
    def faults(self) -> tuple[Doubt, ...]:
        """Doubts for which it is not to be quoted."""
        return tuple(doubt for doubt in self.doubts if doubt.severity == "fault")

    @property
    def verdict(self) -> str:
        """Whether the value is to be quoted: "Quote it", "Quote with care" or "Do not quote"."""
        severities = {doubt.severity for doubt in self.doubts}
        return VERDICTS["fault" if "fault" in severities else "caution" if severities else ""]

    @property
    def finer(self) -> str:
        """Between which ends every finer scan lies, and at which hardness; empty without a bracket."""
        if self.bracket is None or self.hardness is None:
            return ""
        low, high = (f"{end:.3f}" for end in self.bracket)
        ends = f"{low} (μ0 + τ0/{'H′' if self.grows else 'H'})" + (f" to {high}" if low != high else "")
        return f"at H = {with_unit(self.hardness, 'GPa')} a finer scan would give {ends}"

    @property
    def sentence(self) -> str:
        """One sentence with its inputs: to quote, or why there is none to quote."""
        if self.unloaded and self.sticking is not None:
            parts = [f"{self.sticking.text.removesuffix('.')}, at {self.inputs}", self.note]
            return "; ".join([*parts, f"assumed: {', '.join(self.assumed)}"]) + "."
        if self.verdict == "Do not quote":
            faults = "; ".join(doubt.text for doubt in self.faults)
            return f"There is no coefficient to quote at {self.inputs}: {faults}."
        first, *others = self.rules
        words = f"μ_s = {quoted(first.value, first.lower, first.upper)} {RULES[first.rule]}"
        words += "".join(f", {quoted(one.value, one.lower, one.upper)} {RULES[one.rule]}" for one in others)
        parts = [f"{words}, at {self.inputs}", self.note]
        parts += [f"assumed: {', '.join(self.assumed)}"] if self.assumed else []
        parts += filter(None, [self.covers, self.roughness, self.finer])
        return "; ".join(parts) + "."

    @property
    def covers(self) -> str:
        """What the 95 % interval of the first rule covers; empty without an interval."""
        if math.isnan(self.upper - self.lower) or self.members < 2:
            return ""
        inputs = dict.fromkeys(left.words for left in self.budget) or [f"the mean over {self.averaged}"]
        return f"95 % interval of {', '.join(inputs)}"

    @property
    def roughness(self) -> str:
        """How much of the coefficient the scans contribute; empty where that is not known."""
        if self.from_roughness is None or not math.isfinite(self.value):
            return ""
        return f"roughness contributes {round(self.from_roughness, 3) + 0.0:.3f} of {self.value:.3f}"


def answers(at: xarray.Dataset, study: Study, *, beside: Sequence[Doubt] = ()) -> list[Answer]:
    """The answers of every cell, load, mu0 and tau0 of what `at_load` gives of a study, those to quote first.

    Doubts `beside` come from the bodies and not from the result, as `doubts_of_inputs` gives them.
    """
    found = [answer(point, study, beside=beside) for point in points(at)]
    return _with_both_readings(found) if study.surfaces.both_readings else found


def headlines(found: Sequence[Answer]) -> list[Answer]:
    """Those to print: without the readings that the interval of another one covers."""
    return [one for one in found if not one.covered]


def _with_both_readings(found: Sequence[Answer]) -> list[Answer]:
    """Answers at the cutoff to quote, whose intervals cover those at the other one, and then the others."""
    cut_off = found[0].at["cut_off"]  # the first one is that to quote
    others = {_place(one): one for one in found if one.at["cut_off"] != cut_off}
    own = [one for one in found if one.at["cut_off"] == cut_off]
    first = [_covering(one, others[_place(one)]) if _place(one) in others else one for one in own]
    return [*first, *(replace(one, covered=True) for one in others.values())]


def _place(one: Answer) -> tuple[tuple[str, float], ...]:
    """Load, mu0 and tau0 of an answer, and its cell without the cutoff."""
    return tuple(item for item in one.at.items() if item[0] != "cut_off")


def _covering(one: Answer, other: Answer) -> Answer:
    """An answer to quote whose intervals cover those of the other reading, with the doubts about both.

    Filtering does not improve an assessment: what forbids quoting the other reading forbids quoting this one.
    """
    rules = tuple(_over_both(*each) for each in zip(one.rules, other.rules, strict=True))
    both = {left.words: left for left in other.budget}
    known = math.isfinite(one.upper - one.lower)  # which one or two positions leave open
    budget = [Left(ORIGIN, one.lower, one.upper, one.upper - one.lower)] if known else []
    for left in one.budget:
        same = both.get(left.words, left)
        low, high = min(left.lower, same.lower), max(left.upper, same.upper)
        budget.append(Left(left.words, low, high, high - low))
    value = other.rules[0]
    is_measured = one.at["cut_off"] == 0
    words = f"; {'without' if is_measured else 'with'} them μ_s is {quoted(value.value, value.lower, value.upper)}"
    words = words if math.isfinite(value.value) else ""
    own = [replace(each, text=each.text + words) if each.has_readings else each for each in one.doubts]
    texts = {each.text for each in one.doubts}
    beyond = [
        replace(each, text=f"as measured: {each.text}")
        for each in other.faults
        if not (is_measured or each.has_readings or each.text in texts)
    ]
    doubts = sorted([*own, *beyond], key=lambda doubt: doubt.severity != "fault")
    order = tuple(sorted(budget, key=lambda left: left.width))
    bracket = None if any(each.severity == "fault" for each in doubts) else one.bracket
    return replace(one, rules=rules, budget=order, doubts=tuple(doubts), bracket=bracket)


def _over_both(one: RuleValue, other: RuleValue) -> RuleValue:
    """A value with intervals that cover those of another reading."""
    lower, upper = float(np.fmin(one.lower, other.lower)), float(np.fmax(one.upper, other.upper))
    (low, high), (other_low, other_high) = one.next_test, other.next_test
    next_test = float(np.fmin(low, other_low)), float(np.fmax(high, other_high))
    return replace(one, lower=lower, upper=upper, next_test=next_test)


def answer(point: xarray.Dataset, study: Study, *, beside: Sequence[Doubt] = ()) -> Answer:
    """The answer of one point of what `at_load` gives, one cell, load, mu0 and tau0, with doubts from the bodies."""
    rules = tuple(_rule_value(point, rule) for rule in rules_of(study))
    statuses = np.unique(by_rule(point["status"], rules[0].rule).values)
    bad = [str(status) for status in statuses if status != friction.STATUS_OK]
    # A direction without an answer leaves the mean over all of them without one.
    status = bad[0] if bad and math.isnan(rules[0].value) else friction.STATUS_OK
    cut_off = float(point["cut_off"]) if "cut_off" in point.coords else 0.0
    mean = replace(rules[0], lower=rules[0].positions[0], upper=rules[0].positions[1])
    # Only a cutoff that was asked for takes doubts away.
    kept = [each for each in beside if study.surfaces.both_readings or cut_off < each.cut_off]
    doubts = [*kept, *doubts_of(point, study, mean, status)]
    return Answer(
        rules=rules, status=status, load=load_text(point, study), inputs=_inputs(point, study),
        note=_note(point, study),
        doubts=tuple(sorted(doubts, key=lambda doubt: doubt.severity != "fault")),
        at=_place_of(point, study),
        bracket=None if any(_spoils_bracket(doubt) for doubt in doubts) else _bracket(point, study, mean),
        hardness=None if study.contact.hardness is None else float(study.contact.hardness),
        grows=bool(study.contact.junction_growth),
        budget=_budget(point, rules[0].rule), parts=_parts(point, rules[0]),
        from_roughness=_from_roughness(point, study, rules[0]),
        waited=_waited(point, rules[0].rule),
        scans=study.surfaces.scan_counts, members=value_of(point, "members"), averaged=_averaged(point, study),
        assumptions=assumptions_of(study), assumed=_assumed(point, study), sticking=sticking_of(point, rules[0].rule),
        contact_status=contact_status_of(point, study), unloaded=is_unloaded(point),
    )  # fmt: skip


# ---- Values ----------------------------------------------------------------------------------------------------------


def _rule_value(point: xarray.Dataset, rule: str) -> RuleValue:
    own = by_rule(point, rule)
    name = "friction_all_round" if "friction_all_round" in own else "friction_coefficient"
    value, lower, upper = (own[name].sel(statistic=each).item() for each in STATISTICS)
    ends = (max(lower, 0.0) if lower < 0 <= value else lower), upper
    lower, upper = _ends_of(own, "friction_known") or ends
    test = _ends_of(own, "friction_next_test") or (math.nan, math.nan)
    low, high, slopes = (value_of(own, each) for each in ("spread_low", "spread_high", "gentle_friction"))
    return RuleValue(rule, value, lower, upper, ends, test, low, high, slopes)


def _ends_of(own: xarray.Dataset, name: str) -> tuple[float, float] | None:
    lower, upper = (float(own[name].sel(statistic=each)) if name in own else math.nan for each in STATISTICS[1:])
    return (lower, upper) if math.isfinite(lower) and not math.isnan(upper) else None


def _budget(point: xarray.Dataset, rule: str) -> tuple[Left, ...]:
    """What would be left of the interval by a rule if each input were known, the narrowest first."""
    if "friction_if_known" not in point:
        return ()
    own, found = by_rule(point, rule), []
    for index, words in enumerate(own["input_words"].values.tolist()):
        if (ends := _ends_of(own.isel(input=index), "friction_if_known")) is not None:
            found.append(Left(words, *ends, float(own["width_if_known"][index])))
    return tuple(sorted(found, key=lambda left: left.width))


def _waited(point: xarray.Dataset, rule: str) -> tuple[Waited, ...]:
    if "friction_waited" not in point:
        return ()
    table = by_rule(point["friction_waited"], rule).transpose("wait", "statistic")
    rows = zip(point["wait"].values.tolist(), table.values.tolist(), strict=True)
    return tuple(Waited(seconds, *three) for seconds, three in rows)


def _parts(point: xarray.Dataset, rule: RuleValue) -> tuple[float, float, float] | None:
    """What holds the bodies where all contacts rub: mu0 on the load of the contacts, tau0 on their area, and slopes."""
    if rule.rule != "all" or not math.isfinite(rule.value):
        return None
    load = float(point["load"])
    area = "contact_area_at_onset" if "contact_area_at_onset" in point else "contact_area"
    mu0, adhesion = float(point["mu0"]), float(point["tau0"]) * value_of(point, area) / load
    if "contact_load" in point:
        mu0 *= value_of(point, "contact_load") / load
    return mu0, adhesion, rule.value - mu0 - adhesion


def _place_of(point: xarray.Dataset, study: Study) -> dict[str, float]:
    """Return the coordinates of a point; of self-affine surfaces the Hurst exponent too."""
    place = {name: float(point[name]) for name in (*CELLS, "load", "mu0", "tau0") if name in point.coords}
    if "fractal_dimension" in place and (shape := shape_coordinate(study, place["fractal_dimension"]))[0] == "H":
        place["hurst_exponent"] = shape[1]
    return place


def _from_roughness(point: xarray.Dataset, study: Study, rule: RuleValue) -> float | None:
    """Return what the scans contribute to the coefficient where friction acts at all contacts; None elsewhere.

    Inputs alone give mu0 on the load of the contacts and, of a hardness H, tau0/H: contacts that have all yielded.
    """
    parts = _parts(point, rule)
    if parts is None or not study.is_measured:
        return None
    return rule.value - parts[0] - (plastic_adhesion(point, study) or 0.0)


def _spoils_bracket(doubt: Doubt) -> bool:
    """Whether a caveat is a fault of more than the number of contacts, which the bracket allows for."""
    return doubt.severity == "fault" and doubt.cure != MORE_CONTACTS


def _bracket(point: xarray.Dataset, study: Study, all_rub: RuleValue) -> tuple[float, float] | None:
    """Between which ends every finer scan lies: to second order in slopes, so that they may meet.

    The upper one is that of the interval, and of the load that finer waves move between the contacts of all members.
    """
    hardness = study.contact.hardness
    measured = study.is_measured and study.by_half_space and not study.contact.adheres
    if hardness is None or not measured or all_rub.rule != "all" or not math.isfinite(all_rub.value):
        return None
    mu0, adhesion = float(point["mu0"]), plastic_adhesion(point, study)
    if adhesion is None or math.isnan(adhesion):
        return None
    upper = all_rub.upper if math.isfinite(all_rub.upper) else None
    contacts = value_of(point, "contact_count") * value_of(point, "members")
    return friction_bracket(all_rub.value, mu0, adhesion, contacts, upper)


# ---- Words -----------------------------------------------------------------------------------------------------------


def _inputs(point: xarray.Dataset, study: Study) -> str:
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
        words.append(f"waves below {with_unit(float(point['cut_off']), 'um')} taken off")
    return ", ".join(words)


def _asked(point: xarray.Dataset, study: Study, name: str) -> str:
    """The range of mu0 or tau0 as it was given, where the point is at the middle of it."""
    text = getattr(study.known, name)
    return f" ({text})" if text is not None and _is_asked(point, study, name) else ""


def _is_asked(point: xarray.Dataset, study: Study, name: str) -> bool:
    return math.isclose(float(point[name]), float(getattr(study.friction, name)[0]), rel_tol=1e-3)


def _interface_words(study: Study) -> str:
    """Name and kind of the interface of which mu0 and tau0 are, and what else a reader must know of it."""
    found, name = interface_of(study), Path(str(study.known.interface)).name
    if found is None:
        return f"interface {name}, which is not there, so that μ0 and τ0 are taken one by one"
    fit, words = found.fits[0], [found.about.get("kind", "measured"), found.about.get("motion", "")]
    words += [RULES[fit.sliding]] if fit.sliding != "all" else []
    words += ["its range is not known"] if np.ptp(fit.mu0) == np.ptp(fit.tau0) == 0 else []
    return f"interface {name} ({', '.join(filter(None, words))})"


def _range(study: Study) -> str:
    """What of the hardness is known, where that is no single number."""
    found = inputs_of(study).get("hardness")
    if found is None:
        return ""
    if study.known.hardness is not None:
        return f" ({study.known.hardness})"
    return f" ({with_unit(found.known.low, 'GPa')} to {with_unit(found.known.high, 'GPa')})"


_READINGS = {
    "mean": "the load is the mean normal load of all members",
    "elastic": "the load is that of the elastic contact, before friction on slopes adds to it",
    "normal": "the load is the normal load of each member",
}


def _note(point: xarray.Dataset, study: Study) -> str:
    words = []
    if study.surfaces.press == "lines" and point["direction"].size == 2:
        words.append("the mean over both directions")
    elif "direction" in point.coords and (study.is_measured or point["direction"].size > 1):
        words.append(over_text(np.atleast_1d(point["direction"].values)).removesuffix(" all round"))
    if value_of(point, "members") > 1:
        words = [f"{words[0]} and {_averaged(point, study)}"] if words else [f"the mean over {_averaged(point, study)}"]
    words += [_scans_text(study)] if study.is_measured else []
    difference = value_of(point, "reading_difference")
    if difference > READINGS_DIFFER:
        reading = _READINGS.get(str(point.attrs.get("reading")), "the load has one of three meanings")
        words.append(f"{reading}; by another reading μ_s differs by {percent(difference)}")
    return "; ".join(words)


def _averaged(point: xarray.Dataset, study: Study) -> str:
    """Return how many members were averaged, and of which kind."""
    kind = "pairs" if not study.is_measured else "positions"
    kind = "pairs of random surfaces with these spectra" if study.surfaces.press == "surrogates" else kind
    return f"{value_of(point, 'members'):.0f} {kind}"


STRIP = "a strip 1 µm wide"  # of the paper, which profiles stand for


def assumptions_of(study: Study) -> tuple[str, ...]:
    """Return what the result of a study takes for granted: lay and width of profiles, contact model, adhesion."""
    if not study.is_measured:
        return ()
    surfaces, contact, words = study.surfaces, study.contact, []
    if surfaces.press == "lines":
        is_plane = study.by_half_space or "cylinder" in law_of(study)
        words.append(f"{'parallel grooves across the scans' if is_plane else 'contacts of spheres'} on {STRIP}")
    elif surfaces.press == "surrogates":
        words.append("surfaces alike in all directions")
    words += [] if study.by_half_space else ["contacts that do not interact"]
    words += [] if contact.hardness is not None or "jackson" in law_of(study) else ["elastic contact"]
    words += ["no adhesion"] if contact.work_of_adhesion is None else []
    return tuple(words)


def _assumed(point: xarray.Dataset, study: Study) -> tuple[str, ...]:
    """Return all that the sentence for a report names as assumed."""
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
    """How many scans of each part there are, and which spread between places is not in an interval."""
    counts = study.surfaces.scan_counts
    if study.is_gap:
        return "one gap at its one position"
    if counts == (1, 1):
        return "one scan of each part"
    words = f"{counts[0]} × {counts[1]} scans of both parts"
    single = [side for side, count in zip(SIDES, counts, strict=True) if count == 1]
    return words + "".join(f", and one of the {side}: the spread between its places is not in it" for side in single)


def slopes_text(answer: Answer, point: xarray.Dataset, study: Study) -> str:
    """What the slopes alone predict, and what that leaves out; empty where the result has no such number."""
    known = [rule for rule in answer.rules if math.isfinite(rule.slopes)]
    if not known:
        return ""
    values = " and ".join(f"{quoted(rule.slopes)} {RULES[rule.rule]}" for rule in known)
    without = ", without regard to the hardness" if is_capped(study) else ""
    kappa = value_of(point, "rms_gradient") * modulus_of(point, study) / pressure_of(point)
    if float(point["tau0"]) > 0 and abs(kappa / KAPPA - 1) > OTHER_KAPPA:
        return (
            f"The slopes alone are no check of this pair: their A E* h'/F is {KAPPA:g} and that of the pair "
            f"{significant(kappa)}. They would predict {values}{without}."
        )
    return f"The slopes alone predict {values}{without}."
