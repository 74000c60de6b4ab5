"""One page of a result for a browser: interactive, whole in itself, nothing fetched.

The page carries the means over the repetitions and the sums of every repetition, and `report.js` does with them what
`studies.ensemble` does: so every mu0 and tau0 is at hand, with intervals. Markup, style and script stand beside this
file, as what they are.
"""

from __future__ import annotations

import base64
import html
import json
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from string import Template
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiction._checks import Floats
from stiction._core import __version__
from stiction._files import replaced_file
from stiction.mechanics.contact import contacts
from stiction.mechanics.friction import SHEAR_STRENGTH_LIMIT
from stiction.mechanics.quantities import SUMS
from stiction.studies.study import Study, differences, study_of
from stiction.surfaces.fractal import random_phases, weierstrass_mandelbrot_family
from stiction.surfaces.profile import Profile
from stiction.views.figures import LOAD_STEPS, reached_loads

if TYPE_CHECKING:
    import xarray

MARK = "<!doctype html>\n<!-- A report of stiction -->\n"
"""How a report begins; no other file is written over."""

MOST_MEANS = 1_000_000
"""Pairs of surfaces times approaches, of which a page can make a map between two pictures."""

MOST_SUMS = 12_000_000
"""Sums of single repetitions in a page, of four bytes each when compressed; without them it has no intervals."""

PER_REPETITION = ("contact_area", *(name for name in SUMS if name.startswith(("normal_", "tangential_"))))

SUM_BYTES = 5
"""Leading bytes of a double that are kept of the sums of a repetition: 2e-9 of the number."""

PICTURE_BYTES = 3
"""The same of what is only drawn: 1e-4 of the number."""

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
        If plotly is not installed, the result is too large for a page, the path holds something that is no report, or
        it cannot be written.
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
        If plotly is not installed, or the result is too large for a page.
    """
    plotly = _plotly()
    study = study_of(dataset)
    data = dataset.transpose("fractal_dimension", "amplitude", "repetition", "approach")
    values = data["normal_elastic"].size // data.sizes["repetition"]
    if values > MOST_MEANS:
        raise ReportError(
            f"the result has {values} pairs times approaches, more than the {MOST_MEANS} that a page can hold; "
            "choose fewer fractal dimensions, amplitudes or approaches"
        )
    has_intervals = data.sizes["repetition"] > 1 and data["normal_elastic"].size * len(PER_REPETITION) <= MOST_SUMS
    example = _Example.of(data, study)
    packed = {
        "plotly": _packed_bytes(plotly.encode()),
        "means": _packed(np.stack([data[name].values.mean(axis=2) for name in SUMS]), 8),
        "sums": _packed(np.stack([data[name].values for name in PER_REPETITION]) if has_intervals else [], SUM_BYTES),
        "profiles": _packed(example.profiles, PICTURE_BYTES),
        "contacts": _packed(example.contacts, PICTURE_BYTES),
    }
    facts = _facts(data, study, has_intervals) | {"example": example.facts}
    folder = resources.files("stiction.views")
    style, script, markup = ((folder / f"report.{kind}").read_text("utf-8") for kind in ("css", "js", "html"))
    return MARK + Template(markup).substitute(
        style=style,
        script=script,
        # No "<", so that nothing in it ends the element or begins another.
        facts=json.dumps(facts, allow_nan=False).replace("<", "\\u003c"),
        packed="\n".join(
            f'<script type="application/octet-stream" id="packed-{name}">{text}</script>'
            for name, text in packed.items()
        ),
        pairs=_pairs(data),
        unfinished=_unfinished(data, study),
        changes=_changes(study),
        study=html.escape(dataset.attrs["study"]),
        versions=html.escape(_versions(dataset)),
    )


def _plotly() -> str:
    try:
        from plotly.offline import get_plotlyjs
    except ImportError:
        raise ReportError("a report needs the package plotly: pip install 'stiction[report]'") from None
    return str(get_plotlyjs())


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
    """What the script knows besides the numbers: axes, ranges, and where there are contacts at all."""
    counts: NDArray[np.bool_] = np.any(data["contact_count"].values, axis=2)  # (dimension, amplitude, approach)
    modulus = float(study.contact.effective_modulus)
    mu0, tau0 = study.friction.mu0, [1000 * float(value) for value in study.friction.tau0]
    return {
        "variables": SUMS,
        "perRepetition": PER_REPETITION,
        "dimensions": data["fractal_dimension"].values.tolist(),
        "classical": study.surfaces.convention == "classical",
        "amplitudes": data["amplitude"].values.tolist(),
        "measure": study.surfaces.amplitude_measure,
        "repetitions": data.sizes["repetition"],
        "approaches": data["approach"].values.tolist(),
        "hasIntervals": has_intervals,
        "touched": counts.any(axis=2).tolist(),
        "touchedAtLast": counts[:, :, -1].tolist(),
        "loads": _loads(data),
        "loadSteps": LOAD_STEPS,
        "mu0": mu0,
        "tau0": tau0,
        "mu0Most": max(1.0, mu0[-1]),
        "tau0Most": max(tau0[-1], 20 * modulus),  # MPa: a fiftieth of the modulus
        "tau0Sane": 1000 * SHEAR_STRENGTH_LIMIT * modulus,
        "shear": 1 if study.contact.shear == "+x" else -1,
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
    """Of each dimension: the two profiles, cut out; first point of the window and of what is cut out; where they touch.

    Scaled to another amplitude they touch at the same point.
    """
    surfaces = study.surfaces
    for dimension in dimensions:
        bodies = []
        for side in ("lower", "upper"):
            phases = random_phases(
                study.ensemble.seed, side=side, directions=surfaces.directions, frequencies=surfaces.frequencies
            )
            heights = weierstrass_mandelbrot_family(
                phases,
                [dimension],
                length_scale=float(surfaces.length_scale),
                gamma=surfaces.gamma,
                extent=float(surfaces.extent),
                points=surfaces.points,
                convention=surfaces.convention,
                band_limit=None if surfaces.band_limit == "none" else surfaces.band_limit,
            )[0]
            spacing = float(surfaces.extent) / surfaces.points
            bodies.append(Profile(heights, spacing=spacing).with_amplitude(amplitude, surfaces.amplitude_measure))
        lower, upper = bodies
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
    """How many pairs the page is of."""
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
