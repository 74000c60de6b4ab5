"""The page of one study, or of two side by side.

It carries the means over the repetitions and the sums of every repetition, and `numbers.js` does with them what
`friction_map`, `area_map` and `stiffness_map` do, so every mu0 and tau0 is at hand, with intervals.
"""

from __future__ import annotations

import html
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import NDArray

from stiction._checks import Floats
from stiction.mechanics import friction
from stiction.mechanics.contact import contacts
from stiction.mechanics.quantities import AREAL_VALIDITY, DIRECTED, QUANTITIES, VALIDITY
from stiction.studies.intervals import AROUND, CONFIDENCE
from stiction.studies.pairs import pairs_of
from stiction.studies.streams import means, pieces
from stiction.studies.study import Study, differences, step_of, study_names, study_of
from stiction.surfaces.profile import Profile
from stiction.views.figures import COLOUR_QUANTILES, LOAD_STEPS, SHARE_LIMIT, TICKS, reached_loads
from stiction.views.report.page import Page, ReportError, counted, escaped, packed

if TYPE_CHECKING:
    import xarray

MOST_RESULTS = 2
"""On one page."""

MOST_MEANS = 1_000_000
"""Pairs of surfaces times steps times motions, of which a page can make a map between two pictures."""

MOST_SUMS = 12_000_000
"""Sums of single repetitions in a page, of four bytes each when compressed; without them it has no intervals."""

PER_REPETITION = (
    "contact_area", "normal_elastic", "normal_frictional", "normal_adhesive", "tangential_elastic",
    "tangential_frictional", "tangential_adhesive",
)  # fmt: skip

BYTES = {"means": 8, "sums": 5, "profiles": 3, "contacts": 3}
"""Leading bytes of a double that are kept: all of them, 2e-9 of a sum, and 1e-4 of what is only drawn."""

STATUSES = {
    friction.STATUS_OK: ("", ""),
    friction.STATUS_NOT_REACHED: ("load not reached", "no computed approach or load carries it"),
    friction.STATUS_BELOW_RANGE: ("below the loads computed", "the first computed approach or load carries more"),
    friction.STATUS_NO_CONTACT: ("no contact", "no pair touches within the approaches"),
    friction.STATUS_SELF_LOCKED: (
        "self-locked: no load is carried",
        "friction locks the contacts: at the largest approach the mean load is zero or below",
    ),
}
"""What the legend of the map, and a sentence, say of each status."""

RATIOS = {
    "relative_overlap": ("overlap_load", ("normal_elastic",)),
    "share_beyond_hertz": ("load_beyond_hertz", ("normal_elastic",)),
    "share_below_grid": ("load_below_grid", ("normal_elastic",)),
    "share_crossed": ("crossed_count", ("crossed_count", "contact_count")),
    "share_overlapping": ("load_overlapping", ("normal_elastic",)),
    "share_unanswered": ("unanswered_count", ("grid_minimum_count",)),
    "load_share_at_hardness": ("load_share_at_hardness", ()),
    "area_share_at_hardness": ("area_share_at_hardness", ()),
}
"""Of what sum over which each figure of validity is made."""

MOST_OVERLAP = 0.1
"""Mean of overlap / radius above which the page warns; of the shares it is `SHARE_LIMIT`."""

DRAWN = ("share_beyond_hertz", "share_below_grid")
"""Figures of validity that veil the map and dot the curves."""

WINDOW = 1500
"""Points of the example profiles, around where they first touch."""

MARGIN = 64
"""Points beyond the window, past which a spline does not look."""

MOST_PAIRS = 3
"""Repetitions of which example profiles are shown."""

MOST_EXAMPLES = {"fractal_dimension": 20, "amplitude": 20, "step": 60}
"""Of the example profiles."""

MOST_CONTACTS = 60
"""Contacts drawn of the example profiles at an approach: those with the largest forces."""

_DIMS = ("fractal_dimension", "amplitude", "repetition")
_MOTIONS = ("sliding", "direction")


def study_page(datasets: Sequence[xarray.Dataset], names: Sequence[str]) -> Page:
    """The page of results of `run`, each called by a name, or by that of its study where this is empty.

    Raises
    ------
    ReportError
        If a result is too large for a page or has no repetitions, or one of its numbers is not finite.
    """
    results = [_Result.of(dataset, name) for dataset, name in zip(datasets, names, strict=True)]
    first = results[0]
    facts = {
        "confidence": CONFIDENCE,
        "stepsAround": AROUND,
        "statuses": {name: {"short": short, "why": why} for name, (short, why) in STATUSES.items()},
        "bytes": BYTES,
        "ticks": TICKS,
        "colourQuantiles": COLOUR_QUANTILES,
        "loadSteps": LOAD_STEPS,
        "mu0": first.study.friction.mu0,
        "tau0": [1000 * float(value) for value in first.study.friction.tau0],
        "mu0Most": max(1.0, *(result.study.friction.mu0[-1] for result in results)),
        "tau0Most": max(max(1000 * float(r.study.friction.tau0[-1]), 20 * r.modulus) for r in results),  # MPa
        "tau0Sane": 1000 * friction.SHEAR_STRENGTH_LIMIT * min(result.modulus for result in results),
        "results": [result.facts for result in results],
    }
    versions = sorted({str(data.attrs.get("stiction_version", "unknown")) for data in datasets})
    return Page(
        kind="study",
        name=" and ".join(result.name for result in results),
        head=[
            f"{f'{result.name}: ' if len(results) > 1 else ''}{line}" for result in results for line in result.head()
        ],
        words={
            "percent": f"{100 * CONFIDENCE:g} %",
            "pairs": " and ".join(result.pairs() for result in results),
            "unfinished": "".join(result.unfinished() for result in results),
            "studies": "".join(result.described(len(results) > 1) for result in results),
        },
        facts=facts,
        numbers={
            f"{name}-{r}": packed(values, BYTES[name])
            for r, result in enumerate(results)
            for name, values in result.numbers.items()
        },
        versions=f"Computed by stiction {', '.join(versions)}",
    )


# ---- One result ------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class _Result:
    study: Study
    text: str
    name: str
    sizes: dict[str, int]
    facts: dict[str, Any]
    numbers: dict[str, NDArray[Any]]

    @property
    def modulus(self) -> float:
        return float(self.study.contact.effective_modulus)

    @classmethod
    def of(cls, dataset: xarray.Dataset, name: str) -> _Result:
        study = study_of(dataset)
        step = step_of(dataset)
        data = _checked(dataset, step)
        averages = _averages(data, study, step)
        name = name or _name_of(study)
        motions = _motions(study, data)
        steps = data[step].values
        has_intervals = (
            data.sizes["repetition"] > 1 and len(motions) * data["contact_area"].size * len(PER_REPETITION) <= MOST_SUMS
        )
        numbers, facts = _numbers(data, step, motions, has_intervals)
        facts["hasIntervals"] = has_intervals
        example = None
        if study.surfaces.kind == "profile" and study.contact.mechanics == "asperities":
            example = _Example.of(data, study)
            numbers |= {"profiles": example.profiles, "contacts": example.contacts}
        counts: NDArray[np.bool_] = averages["contact_count"].values > 0  # (dimension, amplitude, step)
        facts |= {
            "name": name,
            "dimensions": data["fractal_dimension"].values.tolist(),
            "convention": " (classical)" if study.surfaces.convention == "classical" else "",
            "amplitudes": data["amplitude"].values.tolist(),
            "measure": study.surfaces.amplitude_measure,
            "repetitions": data.sizes["repetition"],
            "steps": steps.tolist(),
            "motions": motions,
            "validity": _validity(averages),
            "touched": counts.any(axis=2).tolist(),
            "touchedAtLast": counts[:, :, -1].tolist(),
            "loads": _loads(data) if counts.any() else [],
            "example": None if example is None else example.facts,
        }
        return cls(study, str(dataset.attrs["study"]), name, {str(k): v for k, v in data.sizes.items()}, facts, numbers)

    def head(self) -> list[str]:
        surfaces, contact = self.study.surfaces, self.study.contact
        made = "profiles" if surfaces.kind == "profile" else "areas"
        lengths = (float(cast("float", surfaces.extent)),) if surfaces.kind == "profile" else surfaces.extents()
        how = "the elastic half-space" if contact.mechanics == "half-space" else "asperities"
        law = "" if contact.mechanics == "half-space" else f", law {contact.model(contact.rules()[0]).law}"
        rules = " and ".join(contact.rules())
        ways = ", ".join(_way(float(angle)) for angle in contact.degrees())
        generator = surfaces.generator.replace("weierstrass-mandelbrot", "Weierstrass-Mandelbrot")
        return [
            f"{generator} {made}, {' x '.join(f'{length:g}' for length in lengths)} µm, pressed by {how}{law}.",
            f"E* = {self.modulus:g} GPa. Contacts that rub: {rules}. The upper body moves to {ways}.",
        ]  # fmt: skip

    def pairs(self) -> str:
        """Say of how many pairs the page is."""
        dimensions = self.sizes["fractal_dimension"]
        parts = [
            counted(self.sizes["repetition"], "pair of surfaces", "pairs of surfaces"),
            f"at {'each of ' if dimensions > 1 else ''}" + counted(dimensions, "fractal dimension"),
        ]
        if self.sizes["amplitude"] > 1:
            parts.append(f"and {counted(self.sizes['amplitude'], 'amplitude')}")
        steps = len(self.facts["steps"])
        loads = self.study.contact.mechanics == "half-space"
        how = counted(steps, "load") if loads else counted(steps, "approach", "approaches")
        return f"{' '.join(parts)}, pressed together at {how}"

    def unfinished(self) -> str:
        done, total = self.sizes["repetition"], self.study.ensemble.repetitions
        if done >= total:
            return ""
        return f'<p class="notice">{escaped(self.name)} is unfinished: {done} of {total} repetitions.</p>'

    def described(self, several: bool) -> str:
        """The study as differences from the defaults, and whole."""
        changes = [f"{key} = {value}" for key, _, value in differences(Study(), self.study)]
        lines = "".join(f"<li><code>{escaped(line)}</code></li>" for line in changes)
        of = f" {escaped(self.name)}" if several else ""
        return (
            f"<h2>The study{of}</h2>"
            + (f"<p>The defaults, but</p><ul>{lines}</ul>" if changes else "<p>All values are the defaults.</p>")
            + "<details><summary>The whole study file (TOML)</summary>"
            + f'<pre tabindex="0">{html.escape(self.text)}</pre></details>'
        )


def _name_of(study: Study) -> str:
    """That of the built-in study that it is, but for the number of repetitions; else what it is of."""
    for name in study_names():
        if Study.named(name).with_changes({"ensemble.repetitions": study.ensemble.repetitions}) == study:
            return name
    return "study"


def _way(angle: float) -> str:
    return {0.0: "+x", 90.0: "+y", 180.0: "-x", 270.0: "-y"}.get(angle, f"{angle:g}° from +x")


def _checked(dataset: xarray.Dataset, step: str) -> xarray.Dataset:
    """The result, if it is one that a page can hold."""
    missing = [name for name in (*_DIMS, step) if not dataset.sizes.get(name)]
    if missing:
        raise ReportError(f"dataset has nothing along {missing[0]!r}; a page needs one repetition or more")
    motions = [dim for dim in _MOTIONS if dim in dataset.dims]
    values = int(np.prod([dataset.sizes[dim] for dim in (*motions, "fractal_dimension", "amplitude", step)]))
    if values > MOST_MEANS:
        raise ReportError(
            f"the result has {values} pairs times {'approaches' if step == 'approach' else 'loads'}, more than the "
            f"{MOST_MEANS} that a page can hold; choose fewer fractal dimensions, amplitudes, directions or steps"
        )
    for name in ("fractal_dimension", "amplitude", step):
        if name not in dataset.variables:
            raise ReportError(f"dataset has no {name}; a page is made of what `run` returns")
        _check_finite(name, dataset[name].values)
    if not (np.diff(dataset[step].values) > 0).all():
        raise ReportError(f"dataset has a {step} that does not rise; a page is made of what `run` returns")
    return dataset


def _averages(data: xarray.Dataset, study: Study, step: str) -> xarray.Dataset:
    """Means over the repetitions (..., dimension, amplitude, step), which are finite only if every number is."""
    for name in study.sums():
        if name not in data.variables:
            raise ReportError(f"dataset has no {name}; a page is made of what `run` returns")
    averages = means(data).transpose(..., "fractal_dimension", "amplitude", step)
    free = study.contact.mechanics == "half-space"  # of free half-planes no approach is known
    for name in study.sums():
        if not (free and name == "approach"):
            _check_finite(name, averages[name].values)
    return averages


def _check_finite(name: str, values: NDArray[Any]) -> None:
    if not np.isfinite(values).all():
        raise ReportError(f"dataset has a {name} that is not finite; a page needs numbers")


def _motions(study: Study, data: xarray.Dataset) -> list[dict[str, Any]]:
    """Each sliding rule and direction, in the order of the sums."""
    rules = [str(rule) for rule in data["sliding"].values] if "sliding" in data.dims else list(study.contact.rules())
    angles = data["direction"].values if "direction" in data.dims else study.contact.degrees()
    return [
        {
            "sliding": rule,
            "direction": float(angle),
            "words": f"{'Opposing' if rule == 'opposing' else 'All'} contacts rub, to {_way(float(angle))}",
            "shear": 1 if float(angle) < 90 else -1,
        }
        for rule in rules
        for angle in angles
    ]


def _numbers(
    data: xarray.Dataset, step: str, motions: list[dict[str, Any]], has_sums: bool
) -> tuple[dict[str, NDArray[Any]], dict[str, Any]]:
    """Means over the repetitions, and their sums if they are to be there, of pieces of which one is in memory."""
    total: Any = 0.0
    sums = []
    for piece in pieces(data):
        ordered = piece.transpose(*(dim for dim in _MOTIONS if dim in data.dims), *_DIMS, step)
        numbers, facts = _numbers_of(ordered, data[step].values, motions)
        total = total + numbers["means"] * (piece.sizes["repetition"] / data.sizes["repetition"])
        if has_sums:
            sums.append(numbers["sums"])
    return {"means": total, "sums": np.concatenate(sums, axis=3) if sums else np.empty(0)}, facts


def _numbers_of(
    data: xarray.Dataset, steps: Floats, motions: list[dict[str, Any]]
) -> tuple[dict[str, NDArray[Any]], dict[str, Any]]:
    """Means and sums, those that have nothing to do with the motion once, and the others for each."""
    has_stiffness = steps.size >= 3
    columns = {str(name): values.values for name, values in data.data_vars.items() if values.dtype.kind in "fi"}
    compliance = None
    if has_stiffness and "approach" in columns:
        has_stiffness = bool(np.isfinite(columns["approach"]).all())
        if has_stiffness:
            compliance = np.gradient(columns["approach"], steps, axis=-1, edge_order=2)
    figures = [name for name, (of, over) in RATIOS.items() if {of, *over} <= set(columns)]
    needed = {part for name in figures for part in (RATIOS[name][0], *RATIOS[name][1])}
    plain = sorted({"contact_area", "normal_elastic", "contact_count"} | needed)
    directed = [name for name in PER_REPETITION if name in DIRECTED]

    def of_motion(name: str, m: int) -> NDArray[Any]:
        values = columns[name]
        return np.asarray(values.reshape(len(motions), *values.shape[-4:])[m])

    def stiffness(name: str, m: int) -> NDArray[Any]:
        values = np.gradient(of_motion(name, m) if name in directed else columns[name], steps, axis=-1, edge_order=2)
        return np.asarray(values if compliance is None else values / compliance)

    averages = [columns[name].mean(axis=2) for name in plain]
    sums = [columns[name] for name in ("contact_area", "normal_elastic")]
    of_sums: dict[str, list[str]] = {"plain": ["contact_area", "normal_elastic"], "directed": directed}
    of_means: dict[str, list[str]] = {"plain": list(plain), "directed": list(directed)}
    parts = ("frictional", "adhesive")
    if has_stiffness:
        of_means["plain"].append("stiffness_elastic")
        averages.append(stiffness("normal_elastic", 0).mean(axis=2))
        of_means["directed"] += [f"stiffness_{part}" for part in parts]
        if compliance is not None:
            of_sums["plain"].append("compliance")
            sums.append(compliance)
    for m in range(len(motions)):
        averages += [of_motion(name, m).mean(axis=2) for name in directed]
        if has_stiffness:
            averages += [stiffness(f"normal_{part}", m).mean(axis=2) for part in parts]
        sums += [of_motion(name, m) for name in directed]
    facts = {"variables": of_means, "perRepetition": of_sums, "hasStiffness": has_stiffness}
    return {"means": np.stack(averages), "sums": np.stack(sums)}, facts


def _validity(data: xarray.Dataset) -> dict[str, dict[str, Any]]:
    """What the page says of each figure of validity, and from where on it warns."""
    figures = {}
    for name in (*VALIDITY, *AREAL_VALIDITY, "load_share_at_hardness", "area_share_at_hardness"):
        of, over = RATIOS[name]
        if not {of, *over} <= set(data.data_vars) or (not over and not data[of].values.any()):
            continue
        words = QUANTITIES[name].words
        figures[name] = {
            "words": words[0].upper() + words[1:],
            "isShare": "share" in name,
            "limit": SHARE_LIMIT if "share" in name else MOST_OVERLAP,
            "isDrawn": name in DRAWN,
            "of": of,
            "over": over,
        }
    return figures


def _loads(data: xarray.Dataset) -> list[float]:
    """Lowest and highest load of the map, mN, in three digits; none where none is carried."""
    try:
        return [float(f"{load:.3g}") for load in reached_loads(data, 2)]
    except ValueError:
        return []


# ---- Example profiles ------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Example:
    """Some pairs around where they first touch, at some of the dimensions, amplitudes and approaches."""

    profiles: Floats  # (pair, dimension, lower or upper, point) at the first amplitude, from first touch, µm
    contacts: Floats  # (x, z, n_x, force) of each contact, all pairs, dimensions, amplitudes and approaches in a row
    facts: dict[str, Any]

    @classmethod
    def of(cls, data: xarray.Dataset, study: Study) -> _Example:
        shown = {
            name: np.unique(np.linspace(0, data.sizes[name] - 1, min(most, data.sizes[name])).round()).astype(np.intp)
            for name, most in zip(("fractal_dimension", "amplitude", "approach"), MOST_EXAMPLES.values(), strict=True)
        }
        some = data.isel(shown)
        pairs = min(MOST_PAIRS, data.sizes["repetition"])
        amplitudes, approaches = some["amplitude"].values, some["approach"].values
        profiles, columns, counts, left_out, starts = [], [], [], [], []
        for lower, upper, start, crop, touch in (
            window
            for repetition in data["repetition"].values[:pairs]
            for window in _windows(study, int(repetition), some["fractal_dimension"].values, amplitudes[0])
        ):
            inside = slice(start - crop, start - crop + WINDOW)
            profiles.append([body.heights[inside] - touch for body in (lower, upper)])
            starts.append(start * lower.spacing)
            for amplitude, approach in ((a, d) for a in amplitudes for d in approaches):
                factor = amplitude / amplitudes[0]
                table = _contacts(study, lower, upper, factor, approach)
                at = table["index"] + crop - start
                table["x"] -= (start - crop) * lower.spacing
                table["z"] -= factor * touch
                seen = np.flatnonzero((at >= 0) & (at < WINDOW))
                drawn = np.sort(seen[np.argsort(-table["force"][seen], kind="stable")[:MOST_CONTACTS]])
                columns.append(np.stack([table[name][drawn] for name in ("x", "z", "normal", "force")]))
                counts.append(drawn.size)
                left_out.append(seen.size - drawn.size)
        facts = {
            "pairs": pairs,
            "dimensions": shown["fractal_dimension"].tolist(),
            "amplitudes": shown["amplitude"].tolist(),
            "approaches": shown["approach"].tolist(),
            "counts": counts,
            "leftOut": left_out,
            "starts": starts,
            "spacing": lower.spacing,
            "points": len(profiles[0][0]),
        }
        return cls(np.array(profiles), np.concatenate(columns, axis=1), facts)


def _windows(
    study: Study, repetition: int, dimensions: Floats, amplitude: float
) -> Iterator[tuple[Profile, Profile, int, int, float]]:
    """Yield for each dimension the two profiles, cut out, and where the cut lies.

    That is the first point of the window, the first point of what is cut out, and the height at which the two touch.
    Scaled to another amplitude they touch at the same point.
    """
    for upper, lower in pairs_of(study, repetition, dimensions, amplitude):
        touch = int(np.argmin(upper.heights - lower.heights))
        start = max(0, min(touch - WINDOW // 2, len(lower) - WINDOW))
        crop = max(0, start - MARGIN)
        cut = slice(crop, start + WINDOW + MARGIN)
        height = float(lower.heights[touch])
        raised = upper.heights[cut] - (upper.heights[touch] - height)  # until the two touch
        yield (
            Profile(lower.heights[cut], spacing=lower.spacing), Profile(raised, spacing=lower.spacing),
            start, crop, height,
        )  # fmt: skip


def _contacts(study: Study, lower: Profile, upper: Profile, factor: float, approach: float) -> dict[str, NDArray[Any]]:
    """Index, position (µm), x component of the normal and force (mN) of every contact."""
    upper, lower = (Profile(factor * body.heights, spacing=body.spacing) for body in (upper, lower))
    found = contacts(upper, lower, float(approach), model=study.contact.model(study.contact.rules()[0]))
    return {
        "index": found.index,
        "x": found.centre[:, 0].copy(),
        "z": found.centre[:, 2].copy(),
        "normal": found.normal[:, 0],
        "force": found.force,
    }
