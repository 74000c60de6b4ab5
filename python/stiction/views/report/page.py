"""One page of a result for a browser: interactive, whole in itself, nothing fetched.

The page carries the means over the repetitions and the sums of every repetition, and `numbers.js` does with them what
`friction_map` and `area_map` do, so every mu0 and tau0 is at hand, with intervals. Markup and style stand beside this
file, and so do the three parts of the script: `numbers.js` computes, `plots.js` draws, and `page.js` holds the state of
the page, its controls and its words. Every constant that they share with the library is handed to them in `facts`.
"""

from __future__ import annotations

import base64
import html
import json
import re
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from importlib import metadata, resources
from pathlib import Path
from string import Template
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiction._checks import Floats
from stiction._core import __version__
from stiction._files import replaced_file
from stiction.mechanics import friction
from stiction.mechanics.contact import contacts
from stiction.mechanics.quantities import QUANTITIES, SUMS, VALIDITY
from stiction.studies.intervals import AROUND, CONFIDENCE
from stiction.studies.pairs import pair_of
from stiction.studies.study import Study, differences, study_of
from stiction.surfaces.profile import Profile
from stiction.views.figures import COLOUR_QUANTILES, LOAD_STEPS, SHARE_LIMIT, TICKS, reached_loads

if TYPE_CHECKING:
    import xarray

MARK = "<!doctype html>\n<!-- A report of stiction -->\n"
"""Every report begins so; no other file is written over."""

MOST_MEANS = 1_000_000
"""Pairs of surfaces times approaches, of which a page can make a map between two pictures."""

MOST_SUMS = 12_000_000
"""Sums of single repetitions in a page, of four bytes each when compressed; without them it has no intervals."""

PER_REPETITION = ("contact_area", *(name for name in SUMS if name.startswith(("normal_", "tangential_"))))

BYTES = {"means": 8, "sums": 5, "profiles": 3, "contacts": 3}
"""Leading bytes of a double that are kept: all of them, 2e-9 of a sum, and 1e-4 of what is only drawn."""

SCRIPTS = ("numbers.js", "plots.js", "page.js")

STATUSES = {
    friction.STATUS_OK: ("", ""),
    friction.STATUS_NOT_REACHED: ("load not reached", "no approach carries this load"),
    friction.STATUS_BELOW_RANGE: ("below the loads computed", "the smallest approach carries more than this load"),
    friction.STATUS_NO_CONTACT: ("no contact", "no pair touches within the approaches"),
    friction.STATUS_SELF_LOCKED: (
        "self-locked: no load is carried",
        "friction locks the contacts: at the largest approach the mean load is zero or below",
    ),
}
"""What the legend of the map, and a sentence, say of each status."""

MOST_OVERLAP = 0.1
"""Mean of overlap / radius above which the page warns; of the shares it is `SHARE_LIMIT`."""

MAP_LINES = {
    "share_beyond_hertz": "above: over half of the load on overlaps > radius / 10",
    "share_below_grid": "below: over half of the load on radii < grid spacing",
}
"""What the legend of the map says of the lines on it."""

WINDOW = 1500
"""Points of the example profiles, around where they first touch."""

MARGIN = 64
"""Points beyond the window, past which a spline does not look."""

MOST_EXAMPLES = 60
"""Fractal dimensions, amplitudes or approaches of the example profiles."""

MOST_CONTACTS = 60
"""Contacts drawn of the example profiles at an approach: those with the largest forces."""


class ReportError(ValueError):
    """A page that cannot be made or written."""


def save_report(dataset: xarray.Dataset, path: str | Path) -> None:
    """Write the page of a result; an older report of that name is replaced when the new one is whole.

    Parameters
    ----------
    dataset : xarray.Dataset
        What `run` returns.
    path : path

    Raises
    ------
    ReportError
        As `report_page`, and if the path holds something that is no report or cannot be written.
    """
    with replaced_file(Path(path), MARK.encode(), ReportError) as partial:
        partial.write_bytes(report_page(dataset).encode())


def report_page(dataset: xarray.Dataset) -> str:
    """The page of a result as HTML, which needs nothing else.

    Parameters
    ----------
    dataset : xarray.Dataset
        What `run` returns.

    Raises
    ------
    ReportError
        If plotly is not installed, the result is too large for a page or has no repetitions, or one of its numbers is
        not finite.
    """
    plotly = _plotly()
    study = study_of(dataset)
    if (
        study.surfaces.kind != "profile"
        or study.contact.mechanics != "asperities"
        or study.contact.sliding != "opposing"
    ):
        raise ReportError(
            "a page is of profiles that touch at asperities by the sliding rule 'opposing', and this study is not: "
            "`stiction plot` draws its figures"
        )
    data = _checked(dataset)
    has_intervals = data.sizes["repetition"] > 1 and data["normal_elastic"].size * len(PER_REPETITION) <= MOST_SUMS
    example = _Example.of(data, study)
    numbers = {
        "means": np.stack([data[name].values.mean(axis=2) for name in SUMS]),
        "sums": np.stack([data[name].values for name in PER_REPETITION]) if has_intervals else np.empty(0),
        "profiles": example.profiles,
        "contacts": example.contacts,
    }
    packed = {"plotly": _packed_bytes(plotly.encode())}
    packed |= {name: _packed(values, BYTES[name]) for name, values in numbers.items()}
    facts = _facts(data, study, has_intervals) | {"example": example.facts}
    folder = resources.files(__package__)
    return MARK + Template((folder / "page.html").read_text("utf-8")).substitute(
        style=(folder / "page.css").read_text("utf-8"),
        script="\n".join((folder / name).read_text("utf-8") for name in SCRIPTS),
        # No "<", so that nothing in it ends the element or begins another.
        facts=json.dumps(facts, allow_nan=False).replace("<", "\\u003c"),
        packed="\n".join(
            f'<script type="application/octet-stream" id="packed-{name}">{text}</script>'
            for name, text in packed.items()
        ),
        percent=f"{100 * CONFIDENCE:g} %",
        pairs=_pairs(data),
        unfinished=_unfinished(data, study),
        changes=_changes(study),
        study=html.escape(dataset.attrs["study"]),
        versions=html.escape(_versions(dataset)),
        plotly_licence=html.escape(_plotly_licence(plotly)),
        own_licence=html.escape(_own_licence()),
    )


def _plotly() -> str:
    try:
        from plotly.offline import get_plotlyjs
    except ImportError:
        raise ReportError("a report needs the package plotly: pip install 'stiction[report]'") from None
    return str(get_plotlyjs())


def _checked(dataset: xarray.Dataset) -> xarray.Dataset:
    """The result in the order of the page, if it is one that a page can hold."""
    missing = [name for name in _DIMS if not dataset.sizes.get(name)]
    if missing:
        raise ReportError(f"dataset has nothing along {missing[0]!r}; a page needs one repetition or more")
    data = dataset.transpose(*_DIMS)
    values = data.sizes["fractal_dimension"] * data.sizes["amplitude"] * data.sizes["approach"]
    if values > MOST_MEANS:
        raise ReportError(
            f"the result has {values} pairs times approaches, more than the {MOST_MEANS} that a page can hold; "
            "choose fewer fractal dimensions, amplitudes or approaches"
        )
    for name in (*SUMS, "fractal_dimension", "amplitude", "approach"):
        if name not in data.variables:
            raise ReportError(f"dataset has no {name}; a page is made of what `run` returns")
        if not np.isfinite(data[name].values).all():
            raise ReportError(f"dataset has a {name} that is not finite; a page needs numbers")
    return data


_DIMS = ("fractal_dimension", "amplitude", "repetition", "approach")


# ---- Numbers ---------------------------------------------------------------------------------------------------------


def _packed(values: ArrayLike, leading: int) -> str:
    """Doubles as text, rounded to some of their leading bytes: all first bytes, then all second ones, and so on.

    Bytes of the same place are alike, signs and exponents most, so this order takes the least room.
    """
    bits = np.ascontiguousarray(values, np.float64).ravel().view(np.uint64)
    dropped = 8 * (8 - leading)
    if dropped:
        bits = bits + np.uint64(1 << (dropped - 1))
    planes = bits.astype(">u8").view(np.uint8).reshape(-1, 8)[:, :leading].T
    return _packed_bytes(planes.tobytes())


def _packed_bytes(content: bytes) -> str:
    return base64.b64encode(zlib.compress(content, 9)).decode("ascii")


def _facts(data: xarray.Dataset, study: Study, has_intervals: bool) -> dict[str, Any]:
    """What the script knows besides the numbers: axes, ranges, words, limits, and where there are contacts at all."""
    counts: NDArray[np.bool_] = np.any(data["contact_count"].values, axis=2)  # (dimension, amplitude, approach)
    modulus = float(study.contact.effective_modulus)
    mu0, tau0 = study.friction.mu0, [1000 * float(value) for value in study.friction.tau0]
    return {
        "variables": SUMS,
        "perRepetition": PER_REPETITION,
        "dimensions": data["fractal_dimension"].values.tolist(),
        "convention": " (classical)" if study.surfaces.convention == "classical" else "",
        "amplitudes": data["amplitude"].values.tolist(),
        "measure": study.surfaces.amplitude_measure,
        "repetitions": data.sizes["repetition"],
        "approaches": data["approach"].values.tolist(),
        "hasIntervals": has_intervals,
        "confidence": CONFIDENCE,
        "stepsAround": AROUND,
        "statuses": {name: {"short": short, "why": why} for name, (short, why) in STATUSES.items()},
        "validity": {name: _figure_of_validity(name, QUANTITIES[name].words) for name in VALIDITY},
        "bytes": BYTES,
        "ticks": TICKS,
        "colourQuantiles": COLOUR_QUANTILES,
        "touched": counts.any(axis=2).tolist(),
        "touchedAtLast": counts[:, :, -1].tolist(),
        "loads": _loads(data),
        "loadSteps": LOAD_STEPS,
        "mu0": mu0,
        "tau0": tau0,
        "mu0Most": max(1.0, mu0[-1]),
        "tau0Most": max(tau0[-1], 20 * modulus),  # MPa: a fiftieth of the modulus
        "tau0Sane": 1000 * friction.SHEAR_STRENGTH_LIMIT * modulus,
        "shear": 1 if study.contact.ways() == ("+x",) else -1,
    }


def _figure_of_validity(name: str, words: str) -> dict[str, Any]:
    """What the page says of one of the figures of validity, and from where on it warns."""
    is_share = name.startswith("share_")
    return {
        "words": words[0].upper() + words[1:],
        "isShare": is_share,
        "limit": SHARE_LIMIT if is_share else MOST_OVERLAP,
        "onMap": MAP_LINES.get(name, ""),
    }


def _loads(data: xarray.Dataset) -> list[float]:
    """Lowest and highest load of the map, mN, in three digits; none where nothing touches."""
    if not data["contact_count"].values.any():
        return []
    return [float(f"{load:.3g}") for load in reached_loads(data, 2)]


# ---- Example profiles ------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Example:
    """The first pair around where it first touches, at some of the dimensions, amplitudes and approaches."""

    profiles: Floats  # (dimension, lower or upper, point) at the first amplitude, from the height of first touch, µm
    contacts: Floats  # (x, z, n_x, force) of each contact, all dimensions, amplitudes and approaches in a row
    facts: dict[str, Any]

    @classmethod
    def of(cls, data: xarray.Dataset, study: Study) -> _Example:
        shown = {
            name: np.unique(np.linspace(0, data.sizes[name] - 1, min(MOST_EXAMPLES, data.sizes[name])).round())
            for name in ("fractal_dimension", "amplitude", "approach")
        }
        some = data.isel({name: index.astype(np.intp) for name, index in shown.items()})
        amplitudes, approaches = some["amplitude"].values, some["approach"].values
        profiles, columns, counts, left_out, starts = [], [], [], [], []
        for lower, upper, start, crop, touch in _windows(study, some["fractal_dimension"].values, amplitudes[0]):
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


def _windows(study: Study, dimensions: Floats, amplitude: float) -> Iterator[tuple[Profile, Profile, int, int, float]]:
    """Yield for each dimension the two profiles, cut out, and where the cut lies.

    That is the first point of the window, the first point of what is cut out, and the height at which the two touch.
    Scaled to another amplitude they touch at the same point.
    """
    for dimension in dimensions:
        pair = pair_of(study, 0, fractal_dimension=dimension, amplitude=amplitude)
        upper, lower = cast("tuple[Profile, Profile]", pair)
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
    found = contacts(
        upper,
        lower,
        float(approach),
        model=study.contact.model(),
    )
    return {
        "index": found.index,
        "x": found.centre[:, 0].copy(),
        "z": found.centre[:, 2].copy(),
        "normal": found.normal[:, 0],
        "force": found.force,
    }


# ---- Words -----------------------------------------------------------------------------------------------------------


def _pairs(data: xarray.Dataset) -> str:
    """Say of how many pairs the page is."""
    parts = [
        _counted(data.sizes["repetition"], "pair of surfaces", "pairs of surfaces"),
        f"at {'each of ' if data.sizes['fractal_dimension'] > 1 else ''}"
        + _counted(data.sizes["fractal_dimension"], "fractal dimension"),
    ]
    if data.sizes["amplitude"] > 1:
        parts.append(f"and {_counted(data.sizes['amplitude'], 'amplitude')}")
    return f"{' '.join(parts)}, pressed together at {_counted(data.sizes['approach'], 'approach', 'approaches')}"


def _counted(count: int, one: str, many: str | None = None) -> str:
    return f"{count} {one if count == 1 else many or f'{one}s'}"


def _unfinished(data: xarray.Dataset, study: Study) -> str:
    done, total = data.sizes["repetition"], study.ensemble.repetitions
    return f'<p class="notice">Unfinished: {done} of {total} repetitions.</p>' if done < total else ""


def _changes(study: Study) -> str:
    changes = [f"{key} = {value}" for key, _, value in differences(Study(), study)]
    if not changes:
        return "<p>All values are the defaults.</p>"
    lines = "".join(f"<li><code>{html.escape(line)}</code></li>" for line in changes)
    return f"<p>The defaults, but</p><ul>{lines}</ul>"


def _versions(dataset: xarray.Dataset) -> str:
    from plotly.offline import get_plotlyjs_version

    computed = dataset.attrs.get("stiction_version", "unknown")
    return f"Computed by stiction {computed}; page by stiction {__version__} and plotly.js {get_plotlyjs_version()}."


def _plotly_licence(plotly: str) -> str:
    """The terms of plotly.js, and every notice in it of what it has taken in."""
    notices = [notice for notice in re.findall(r"/\*.*?\*/", plotly, re.DOTALL) if _NOTICE.search(notice)]
    # Quoted in a string of the library, a notice has its line breaks spelled out.
    lines = "\n\n".join(dict.fromkeys(notice.replace("\\n", "\n") for notice in notices))
    return f"{resources.files(__package__).joinpath('mit.txt').read_text('utf-8')}\n{lines}"


_NOTICE = re.compile("licen[sc]e|copyright", re.IGNORECASE)


def _own_licence() -> str:
    text = metadata.distribution("stiction").read_text("licenses/LICENSE")
    return text or "https://www.gnu.org/licenses/gpl-3.0.txt"
