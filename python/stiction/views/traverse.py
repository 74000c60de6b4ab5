"""Two measured bodies under load: a table for the terminal, and figures for print."""

from __future__ import annotations

import itertools
import textwrap
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from stiction.mechanics import friction
from stiction.mechanics.contact import contacts
from stiction.studies.traverse import of_each_mechanics
from stiction.surfaces.pairing import lower_piece
from stiction.surfaces.preparation import levelled
from stiction.surfaces.profile import Profile
from stiction.views.digits import with_interval
from stiction.views.style import DIRECTIONS, FORCE, FRICTION, MILLIMETRE, STYLE, WIDTH, label, lay_out, save_picture

if TYPE_CHECKING:
    import xarray
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

RESULT = "result.nc"
"""What a pair is kept in."""

TABLE = "result.csv"

_ROWS = {
    "friction_coefficient": ("friction coefficient", 1.0),
    "share_opposing": ("load that opposes", 1.0),
    "tangential_load": ("tangential load (mN)", 1.0),
    "contact_area": ("true contact area (µm²)", 1.0),
    "contact_count": ("contacts", 1.0),
    "normal_stiffness": ("normal stiffness (mN/µm)", 1.0),
    "approach": ("approach (nm)", 1000.0),
    "relative_overlap": ("overlap / radius", 1.0),
    "share_beyond_hertz": ("load on overlaps > R/10", 1.0),
    "share_below_grid": ("load on radii < spacing", 1.0),
    "share_crossed": ("contacts refused", 1.0),
}
"""What the table says of each load, and the factor to its unit."""

_OF_ASPERITIES = (
    "normal_stiffness", "approach", "relative_overlap", "share_beyond_hertz", "share_below_grid", "share_crossed",
)  # fmt: skip

_WITHOUT_INTERVAL = ("relative_overlap", "share_beyond_hertz", "share_below_grid", "share_crossed")

_RULE = """\
Contacts that do not oppose the motion rub nothing (the paper's rule). Without adhesion and steep slopes the coefficient
is mu0 times the share of the load that opposes: about half, so about mu0/2."""

_LEVEL = """\
No load opposes the motion: the contacts are level, as those of a rough body on a flat are, and by the paper's rule
level contacts carry no friction. What rubs on a flat is mu0 + tau0 A/F_N."""

HIGHEST_MU0 = 2.0
"""Above it a molecular friction coefficient is a slip: clean metals in vacuum come near."""

_SHOWN = 4.0
"""How many times the highest mean the axis of coefficients reaches at most."""

_ZOOM = 40
"""Spacings on both sides of the contact that is drawn large, at least."""


BOTH = "both"
"""In place of a direction: the mean over both, position by position."""


def means(result: xarray.Dataset) -> xarray.Dataset:
    """What `traverse_mean` gives, and the same of the mean over both directions, as a third one, "both".

    A position counts for both directions where it has an answer in each.
    """
    import xarray

    from stiction.studies.traverse import traverse_mean

    ok = (result["status"] == friction.STATUS_OK).all("shear")
    numeric = [name for name, table in result.items() if "shear" in table.dims and table.dtype.kind == "f"]
    both = result.drop_vars([name for name, table in result.items() if "shear" in table.dims])
    both = both.assign({name: result[name].mean("shear", skipna=False, keep_attrs=True) for name in numeric})
    both["status"] = result["status"].isel(shear=0).where(ok, _either(result["status"]))
    both = both.drop_vars("shear", errors="ignore").assign_coords(shear=BOTH)
    parts = [traverse_mean(each) for each in (both.expand_dims("shear"), result)]
    return xarray.concat(
        parts, "shear", data_vars="minimal", coords="minimal", compat="override", join="override",
        combine_attrs="override",
    )  # fmt: skip


NAMES = {"half-space": "half-planes", "asperities": "asperities"}
"""Of the mechanics of lines."""

_NO_APPROACH = """\
Half-planes have no approach and no stiffness: their far points have no limit. Their load is what the bodies press on
each other before anything slides; that of asperities includes what friction on slopes adds."""


def mechanics_of(result: xarray.Dataset) -> list[str]:
    """One, or several of a result that compares them."""
    if "mechanics" in result.dims:
        return [str(each) for each in result["mechanics"].values]
    return [str(result.attrs.get("mechanics", "asperities"))]


def _of_mechanics(result: xarray.Dataset) -> str:
    """What was assumed, in words."""
    words = []
    for each in mechanics_of(result):
        if each == "half-space":
            words.append("elastic half-planes")
        else:
            words.append(", ".join(str(result.attrs[name]) for name in ("law", "detection", "curvature")))
    return "; beside them ".join(words)


def traverse_text(result: xarray.Dataset, mean: xarray.Dataset, loads: Any) -> str:
    """What a traverse was and what it says at some of its loads, with 95 % intervals and units.

    Parameters
    ----------
    result, mean : xarray.Dataset
        What `traverse` and `means` return.
    loads : (l,) array_like of float, mN
        Of those of the result.
    """
    positions = int(mean["positions"].max())
    length, by = float(result["nominal_area"]), mechanics_of(result)
    # What is the same all along the third direction.
    cylinders = "half-space" in by or "cylinder" in result.attrs["law"].lower()
    offsets, pairs = result["offset"].values, result.sizes["line"]
    span = f"{offsets[0]:.4g} to {offsets[-1]:.4g} µm" if offsets.size > 1 else f"{offsets[0]:.4g} µm"
    first = "" if pairs == 1 else f", the first of {pairs} pairs"
    area = f", a nominal area of {length:.4g} µm²" if cylinders else ""
    lines = [
        f"{'upper':<12} {_then(result.attrs['upper'])}{first}",
        f"{'lower':<12} {_then(result.attrs['lower'])}{first}",
        f"{'positions':<12} {positions}: {_count(pairs, 'pair')} of lines, {_count(offsets.size, 'offset')} ({span})",
        f"{'slider':<12} {length:.4g} µm long, 1 µm thick{area}",
        f"{'model':<12} E* = {float(result['effective_modulus']):g} GPa, {_material(result)}, {_of_mechanics(result)}",
    ]
    told = False
    for load in np.atleast_1d(loads):
        at = mean.sel(load=load, method="nearest")
        there = result.sel(load=load, method="nearest")
        pressure = f" ({1000 * load / length:.4g} MPa of nominal pressure)" if cylinders else ""
        lines += ["", f"at F_N = {load:.4g} mN{pressure}, means and 95 % intervals"]
        if not (there["status"] == friction.STATUS_OK).any():
            kinds = [str(kind) for kind in np.unique(there["status"].values)]
            lines += [f"none of the positions has an answer: {', '.join(kinds)}", *advice(kinds)]
            continue
        lines += _table(there, at, positions)
        told = True
    if told and result.attrs["sliding"] == "opposing":
        lines += ["", _RULE if float(result["share_opposing"].max()) > 0 else _LEVEL]
    if told and BOTH in mean["shear"].values:
        where = _materials(mean)[0][1]
        said = [
            _in_short(its.isel(where), its_mean.isel(where), load, by=len(by) > 1)
            for load in np.atleast_1d(loads)
            for its, its_mean in zip(of_each_mechanics(result), of_each_mechanics(mean), strict=True)
        ]
        lines += ["", *(textwrap.fill(each, 118) for each in said)]
    if told and "half-space" in by:
        lines += ["", _NO_APPROACH]
    if remark := str(result.attrs.get("remark", "")):
        lines += ["", remark]
    return "\n".join(lines) + "\n"


HIGH_PRESSURE = 0.01
"""Of E*; metals yield at less."""


def _in_short(result: xarray.Dataset, mean: xarray.Dataset, load: float, *, by: bool) -> str:
    """One sentence on one load: the coefficient over both directions, and what keeps it from being quoted."""
    either_way = mean.sel(load=load, method="nearest")
    at = either_way.sel(shear=BOTH)
    head = f"In short{f', by {NAMES[mechanics_of(result)[0]]}' if by else ''}: at {load:.4g} mN"
    if 2 * int(at["ok"]) < int(at["positions"]):
        return f"{head} there is no mean: only {int(at['ok'])} of {int(at['positions'])} positions have an answer."
    value, lower, upper = (float(each) for each in at["friction_coefficient"].values)
    share = {name: float(at[name].sel(statistic="mean")) for name in ("share_beyond_hertz", "share_below_grid")}
    pressure = load / float(at["contact_area"].sel(statistic="mean"))
    faults = []
    if share["share_beyond_hertz"] > HALF:
        faults.append(f"{share['share_beyond_hertz']:.0%} of the load is beyond Hertz (overlap > R/10)")
    if share["share_below_grid"] > HALF:
        faults.append(
            f"{share['share_below_grid']:.0%} of the load is on radii below the spacing: a finer scan differs"
        )
    if np.isnan(lower):
        faults.append("there is no interval: that takes 8 positions or lines that differ")
    elif value > 0 and upper - lower > 2 * WIDE * value:
        faults.append(f"its interval is wider than {WIDE:.0%} to either side; more positions or lines narrow it")
    single = _spread(result.sel(load=load, method="nearest"))
    # What leans against one direction leans with the other, so their mean scatters less than either.
    either = " and ".join(
        f"{_cell(either_way['friction_coefficient'].sel(shear=shear).values, 'friction_coefficient')} to {shear}"
        for shear in map(str, mean["shear"].values)
        if shear != BOTH
    )
    words = (
        f"{head} mu_s = {_cell((value, lower, upper), 'friction_coefficient')}, the mean over both directions; "
        f"{either}; "
        f"four of five single positions, in one direction, lie between {single.replace(' to ', ' and ')}."
    )
    count = float(at["contact_count"].sel(statistic="mean"))
    if count < FEW_ON_A_LINE:
        words += f" {count:.2g} contacts on the mean are few, so mu_s is that of single contacts."
    if faults:
        words += f" Do not quote it: {'; '.join(faults)}."
    elastic = mechanics_of(mean) == ["half-space"] or "hertz" in str(mean.attrs["law"]).lower()
    if elastic and pressure > HIGH_PRESSURE * float(mean["effective_modulus"]):
        words += f" It holds if the softer body is harder than {_pressure(pressure)}, the mean pressure in contact."
    return words


FEW_ON_A_LINE = 10
"""Below which the mean is that of single contacts."""

WIDE = 0.5
"""Half the width of an interval over its value from which on a coefficient is not to be quoted."""

HALF = 0.5
"""Share of the load that is outside of what the model or the scan can say."""


def _pressure(value: float) -> str:
    return f"{value:.2g} GPa" if value >= 1 else f"{1000 * value:.2g} MPa"


def _table(result: xarray.Dataset, mean: xarray.Dataset, positions: int) -> list[str]:
    """The lines of one load: a column for each direction, or of several mechanics one for each of them."""
    by = mechanics_of(mean)
    shears = [str(shear) for shear in mean["shear"].values]
    single = [shear for shear in shears if shear != BOTH]
    columns = [(index, shear) for index in range(len(by)) for shear in shears]
    if len(by) > 1 and BOTH in shears:
        columns = [(index, BOTH) for index in range(len(by))]
    materials = _materials(mean)
    words = {shear: "both directions" if shear == BOTH else f"upper body to {shear}" for shear in shears}
    named = len(by) > 1
    table = [["", *(f"{NAMES[by[index]]}, {words[shear]}" if named else words[shear] for index, shear in columns)]]
    few = False
    for material, where in materials:
        means_by, all_by = of_each_mechanics(mean.isel(where)), of_each_mechanics(result.isel(where))

        def row(
            name: str, ways: Sequence[str | None], means_by: Sequence[xarray.Dataset] = means_by
        ) -> list[str]:  # fmt: skip
            """A cell for each column, in its own direction or in another."""
            cells = []
            for (index, own), way in zip(columns, ways, strict=True):
                at = means_by[index].sel(shear=way or own)
                enough = 2 * int(at["ok"]) >= positions
                cells.append(_cell(_ROWS[name][1] * at[name].values, name) if enough else "none")
            return cells

        few = few or any(2 * int(means_by[index]["ok"].sel(shear=shear)) < positions for index, shear in columns)
        if len(materials) > 1:
            table.append([material, *("" for _ in columns)])
        there = [_towards(all_by[index], shear) for index, shear in columns]
        for name in _ROWS if material == materials[0][0] else ("friction_coefficient",):
            if by == ["half-space"] and name in _OF_ASPERITIES:
                continue
            table.append([_ROWS[name][0], *row(name, [None] * len(columns))])
            if name == "friction_coefficient":
                if len(by) > 1 and BOTH in shears:
                    table += [[f"  {words[way]}", *row(name, [way] * len(columns))] for way in single]
                table.append(["  four of five positions", *map(_spread, there)])
        table.append(["positions with an answer", *map(_answers, there)])
    widths = [max(map(len, column)) + 2 for column in zip(*table, strict=True)]
    lines = ["".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in table]
    lines += advice(str(kind) for kind in np.unique(result["status"].values))
    if few:
        lines.append(f"no mean where fewer than half of the positions have an answer; {RESULT} holds all of them")
    return lines


def _towards(result: xarray.Dataset, shear: str) -> xarray.Dataset:
    """The positions of one direction, or their means over both."""
    if shear != BOTH:
        return result.sel(shear=shear)
    first = result.isel(shear=0)
    status = first["status"].where((result["status"] == friction.STATUS_OK).all("shear"), _either(result["status"]))
    return first.assign(friction_coefficient=result["friction_coefficient"].mean("shear", skipna=False), status=status)


def _either(status: xarray.DataArray) -> xarray.DataArray:
    """Why one of the directions has no answer."""
    return status.isel(shear=0).where(status.isel(shear=0) != friction.STATUS_OK, status.isel(shear=-1))


def _materials(result: xarray.Dataset) -> list[tuple[str, dict[str, int]]]:
    """Each mu0 with each tau0 of a result, in words, and where they are."""
    dims = [name for name in ("mu0", "tau0") if name in result.dims]
    places = [dict(zip(dims, place, strict=True)) for place in np.ndindex(*(result.sizes[name] for name in dims))]
    return [(_material(result.isel(place)), place) for place in places]


def _material(result: xarray.Dataset) -> str:
    mu0, tau0 = (np.atleast_1d(result[name].values) for name in ("mu0", "tau0"))
    return (
        f"mu0 = {', '.join(f'{value:g}' for value in mu0)}, "
        f"tau0 = {', '.join(f'{1000 * value:g}' for value in tau0)} MPa"
    )


def traverse_csv(mean: xarray.Dataset, loads: Any) -> str:
    """The means and intervals of the table as CSV: a row for each load, direction, mu0 and tau0, units in the header.

    Parameters
    ----------
    mean : xarray.Dataset
        What `traverse_mean` returns.
    loads : (l,) array_like of float, mN
        Of those of the result.
    """
    several = "mechanics" in mean.dims
    header = [
        *(["mechanics"] if several else []),
        "normal load (mN)",
        "upper body to",
        "mu0",
        "tau0 (MPa)",
        "positions",
        "positions with an answer",
    ]
    for title, _ in _ROWS.values():
        header += [title, f"{title}: lower", f"{title}: upper"]
    rows = [header]
    for its, load in itertools.product(of_each_mechanics(mean), np.atleast_1d(loads)):
        for _, where in _materials(its):
            for shear in its["shear"].values:
                at = its.isel(where).sel(load=load, method="nearest").sel(shear=shear)
                numbers = [value * factor for name, (_, factor) in _ROWS.items() for value in at[name].values]
                head = [
                    *([str(its.attrs["mechanics"])] if several else []),
                    f"{load:.12g}", str(shear), f"{float(at['mu0']):.12g}", f"{1000 * float(at['tau0']):.12g}",
                    str(int(at["positions"])), str(int(at["ok"])),
                ]  # fmt: skip
                rows.append([*head, *("" if np.isnan(value) else f"{value:.9g}" for value in numbers)])
    return "".join(",".join(row) + "\n" for row in rows)


def doubts(
    uppers: Sequence[Profile],
    lowers: Sequence[Profile],
    loads: Sequence[float],
    *,
    mu0: Sequence[float],
    **contact: Any,
) -> list[str]:
    """A sentence on each thing that is seldom meant: heights beyond the length, a huge mu0, a load of another body."""
    sentences = []
    for name, profiles in (("upper", uppers), ("lower", lowers)):
        height, extent = float(np.ptp(profiles[0].heights)), profiles[0].extent
        if height > extent / 2:
            sentences.append(
                f"{name}: heights span {height:.3g} µm over a length of {extent:.3g} µm; is their unit right?"
            )
        if len(profiles) == 1:
            sentences += _of_its_shape(name, profiles[0])
    if max(mu0) > HIGHEST_MU0:
        sentences.append(f"mu0 = {max(mu0):g} is more than any pair of materials has; is it in percent?")
    area = uppers[0].extent
    sentences += [
        f"F_N = {load:.4g} mN is {1000 * load / area:.3g} MPa on a slider of {area:.4g} µm by 1 µm, more than a tenth "
        "of E*; is it the load of a whole part?"
        for load in loads
        if load / area > 0.1 * contact["effective_modulus"]
    ]
    return sentences


FORM = 0.6
"""Share of the mean square height that a parabola takes, from which on it is form: of the longest waves it is half."""

SPIKE = 12.0
"""Of the usual second difference (median over 0.67), from which on a point stands out: by chance none does at 5."""


def _of_its_shape(name: str, profile: Profile) -> list[str]:
    """A sentence on form, and on spikes, that would carry the load in place of roughness."""
    level = levelled(profile, "line").heights
    sentences = []
    form = 1 - levelled(profile, "quadratic").heights.var() / level.var() if np.ptp(level) > 0 else 0.0
    if form > FORM:
        sentences.append(
            f"{name}: a parabola is {100 * form:.0f} % of its mean square height; that form carries the load, unless "
            "--level quadratic takes it off"
        )
    bends = np.abs(np.diff(profile.heights, 2))
    usual = float(np.median(bends)) / 0.6745
    spikes = int(np.count_nonzero(bends > SPIKE * usual)) if usual > 0 else 0
    if spikes:
        sentences.append(
            f"{name}: {_count(spikes, 'point')} bend more than {SPIKE:g} times as sharply as others do; spikes of the "
            "instrument would be the first contacts"
        )
    return sentences


def _then(history: str) -> str:
    return "; ".join(history.split("\n"))


def _count(number: int, what: str) -> str:
    return f"{number} {what}" + "s" * (number != 1)


def _cell(statistics: Any, name: str) -> str:
    """A mean with as many digits as its interval carries, two of half its width, but no more than six of its own."""
    mean, lower, upper = (float(value) for value in statistics)
    if np.isnan(mean):
        return "none"
    if name in _WITHOUT_INTERVAL:
        return f"{mean:.2g}"
    return with_interval(mean, lower, upper)


def _spread(at: xarray.Dataset) -> str:
    """Between which coefficients all but the lowest and the highest tenth of the positions are."""
    values = at["friction_coefficient"].values
    known = values[np.isfinite(values)]
    return f"{np.quantile(known, 0.1):.3g} to {np.quantile(known, 0.9):.3g}" if known.size else "none"


_ADVICE = {
    "not-reached": "even with all points in touch the load is not carried; give less load, or press areas of maps",
    "below-range": "the first points of the grid carry more than the load; give more load, or scan more finely",
    "not-solved": "the half-space did not reach its tolerance; try another load, or --mechanics asperities",
    "self-locked": "friction on such slopes holds at any tangential load; are mu0 and tau0 right?",
    "no-contact": "nothing touches where both bodies are convex; give more load, or --curvature signed for lines",
}


def advice(kinds: Iterable[str]) -> list[str]:
    """What to do about statuses other than "ok", a line for each."""
    return [f"  {kind}: {_ADVICE[kind]}" for kind in kinds if kind in _ADVICE]


def _answers(at: xarray.Dataset) -> str:
    """How many positions have an answer, and why the others have none."""
    kinds, numbers = np.unique(at["status"].values, return_counts=True)
    counts = dict(zip(kinds.tolist(), numbers.tolist(), strict=True))
    ok = counts.pop(friction.STATUS_OK, 0)
    rest = "".join(f", {number} {kind}" for kind, number in counts.items())
    return f"{ok} of {at['status'].size}{rest}"


# ---- Figures ---------------------------------------------------------------------------------------------------------


def save_traverse_figures(
    result: xarray.Dataset,
    mean: xarray.Dataset,
    loads: Any,
    directory: Path,
    *,
    bodies: tuple[Sequence[Profile], Sequence[Profile]] | None = None,
    **contact: Any,
) -> list[Path]:
    """Draw a traverse into a directory and return the paths.

    ``friction.png``: `load_figure`. ``positions.png``: `positions_figure` at the first of the loads. ``contact.png``:
    `contact_figure` of the first position that carries it, if there is one and the bodies are given. Further mu0 and
    tau0 have theirs, ``friction-2.png`` and so on. Where no position has an answer there are no positions to draw.
    Contacts are those of asperities. Of several mechanics each has a folder.
    """
    if "mechanics" in result.dims:
        paths = []
        for its, its_mean in zip(of_each_mechanics(result), of_each_mechanics(mean), strict=True):
            folder = directory / its.attrs["mechanics"]
            folder.mkdir(exist_ok=True)
            paths += save_traverse_figures(its, its_mean, loads, folder, bodies=bodies, **contact)
        return paths
    load = float(np.atleast_1d(loads)[0])
    figures = {}
    for number, (_, where) in enumerate(_materials(result), 1):
        of, own, its_mean = "" if number == 1 else f"-{number}", result.isel(where), mean.isel(where)
        figures[f"friction{of}.png"] = load_figure(its_mean, loads)
        if (own["status"].sel(load=load, method="nearest") == friction.STATUS_OK).any():
            figures[f"positions{of}.png"] = positions_figure(own, its_mean, load)
    result = result.isel(_materials(result)[0][1])
    at = result.sel(shear="+x").sel(load=load, method="nearest").transpose("line", "offset")
    answered = np.argwhere(at["status"].values == friction.STATUS_OK)
    if answered.size and bodies is not None and mechanics_of(result) == ["asperities"]:
        uppers, lowers = bodies
        line, place = (int(index) for index in answered[0])
        upper, lower = uppers[line], lowers[line]
        beneath = lower_piece(lower, float(at["offset"][place]), upper)
        figures["contact.png"] = contact_figure(
            upper, beneath, float(at["approach"][line, place]),
            mu0=float(result["mu0"]), tau0=float(result["tau0"]), load=load, offset=float(at["offset"][place]),
            **contact,
        )  # fmt: skip
    paths = [directory / name for name in figures]
    for path, figure in zip(paths, figures.values(), strict=True):
        save_picture(figure, path)
    return paths


def load_figure(mean: xarray.Dataset, loads: Any) -> Figure:
    """Friction coefficient and true contact area against load, in both directions, with intervals; 80 mm wide."""
    import matplotlib as mpl
    from matplotlib.figure import Figure

    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 98 * MILLIMETRE), layout="constrained")
        axes = figure.subplots(2, 1, sharex=True, height_ratios=[1.4, 1])
        some = (mean["ok"] < mean["positions"]) & (mean["ok"] > 0)
        for shear, colour in DIRECTIONS.items():
            at = mean.sel(shear=shear)
            for ax, name in zip(axes, ("friction_coefficient", "contact_area"), strict=True):
                values = at[name].transpose("load", "statistic").values
                ax.fill_between(at["load"].values, values[:, 1], values[:, 2], color=colour, alpha=0.2, linewidth=0)
                ax.plot(
                    at["load"].values, values[:, 0], color=colour, linewidth=0.9, label=f"upper body to {_sign(shear)}"
                )
                partly = some.sel(shear=shear).values
                ax.plot(at["load"].values[partly], values[partly, 0], "x", color=colour, markersize=3)
        if some.any():
            axes[0].plot([], [], "x", color="0.4", markersize=3, label="not all positions have an answer")
        for ax in axes:
            ax.set_xscale("log")
            for load in np.atleast_1d(loads):
                ax.axvline(load, color="0.5", linewidth=0.5, linestyle="--")
        if (mean["contact_area"].values > 0).any():
            axes[1].set_yscale("log")
        axes[0].set_ylim(bottom=0)
        if (highest := float(mean["friction_coefficient"].sel(statistic="mean").max())) > 0:
            # An interval of two or three positions may be wider than all that is worth looking at.
            axes[0].set_ylim(top=min(axes[0].get_ylim()[1], _SHOWN * highest))
        axes[0].set_ylabel(label("friction_coefficient"))
        axes[1].set_ylabel(label("contact_area"))
        axes[1].set_xlabel("normal load $F_N$ on the slider, 1 µm thick (mN)")
        axes[0].set_title(_choices(mean), loc="left", fontsize=6, pad=3)
        figure.legend(*axes[0].get_legend_handles_labels(), title="shaded: 95 %", loc="outside lower center", ncols=2)
        lay_out(figure)
    return figure


def _sign(shear: str) -> str:
    """A direction with the minus of numbers."""
    return shear.replace("-", "\N{MINUS SIGN}")


def _choices(result: xarray.Dataset) -> str:
    return (
        rf"$E^*$ = {float(result['effective_modulus']):g} GPa, $\mu_0$ = {float(result['mu0']):g}, "
        rf"$\tau_0$ = {1000 * float(result['tau0']):g} MPa, "
        + ("half-planes" if mechanics_of(result) == ["half-space"] else str(result.attrs["detection"]))
    )


def positions_figure(result: xarray.Dataset, mean: xarray.Dataset, load: float) -> Figure:
    """Friction coefficient of each position at a load, and how the positions are distributed; 80 mm wide."""
    import matplotlib as mpl
    from matplotlib.figure import Figure
    from matplotlib.ticker import MaxNLocator

    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 55 * MILLIMETRE), layout="constrained")
        places, distribution = figure.subplots(1, 2, sharey=True, width_ratios=[2.4, 1])
        at = result.sel(load=load, method="nearest")
        along = "offset" if result.sizes["offset"] > 1 else "line"
        values = at["friction_coefficient"].values
        highest = float(np.nanmax(values)) if np.isfinite(values).any() else 1.0
        bins = np.linspace(0, 1.05 * max(highest, 1e-3), 13)
        for shear, colour in DIRECTIONS.items():
            here = at.sel(shear=shear).transpose(along, ...)
            coefficients = here["friction_coefficient"].values.reshape(here.sizes[along], -1)
            places.plot(
                here[along].values, coefficients, "o", color=colour, markersize=2.5,
                markeredgewidth=0, alpha=0.8,
            )  # fmt: skip
            known = coefficients[np.isfinite(coefficients)]
            distribution.hist(known, bins=bins, orientation="horizontal", histtype="step", color=colour, linewidth=0.9)
            middle = mean["friction_coefficient"].sel(shear=shear).sel(load=load, method="nearest").values
            for ax in (places, distribution):
                ax.axhspan(middle[1], middle[2], color=colour, alpha=0.15, linewidth=0)
                ax.axhline(middle[0], color=colour, linewidth=0.6)
            places.plot([], [], "o", color=colour, markersize=3, label=f"upper body to {_sign(shear)}")
        places.set_ylim(bins[0] - 0.02 * bins[-1], bins[-1])
        places.set_ylabel(label("friction_coefficient"))
        places.set_title(f"at $F_N$ = {float(at['load']):.4g} mN", loc="left", pad=3)
        places.set_xlabel("offset of the upper body (µm)" if along == "offset" else "pair of lines")
        if along == "line":
            places.xaxis.set_major_locator(MaxNLocator(5, integer=True))
        distribution.set_xlabel("positions")
        distribution.xaxis.set_major_locator(MaxNLocator(3, integer=True))
        missing = int((at["status"] != friction.STATUS_OK).sum())
        note = f"; {missing} without an answer" if missing else ""
        figure.legend(
            *places.get_legend_handles_labels(), title=f"lines: means, shaded: their 95 %{note}",
            loc="outside lower center", ncols=2,
        )  # fmt: skip
        lay_out(figure)
    return figure


def contact_figure(
    upper: Profile,
    lower: Profile,
    approach: float,
    *,
    mu0: float,
    tau0: float = 0.0,
    load: float | None = None,
    offset: float | None = None,
    **contact: Any,
) -> Figure:
    """Two profiles in contact: all of them, and the contact that carries most with the forces on the upper body.

    Parameters
    ----------
    upper, lower : Profile
        On the same grid.
    approach : float, µm
    mu0 : float
    tau0 : float, GPa
    load : float, mN, optional
        What the title says that they carry.
    offset : float, µm, optional
        Where the title says that the upper profile lies on a longer one.
    **contact
        As for `contacts`.
    """
    import matplotlib as mpl
    from matplotlib.figure import Figure

    touching = contacts(upper, lower, approach, **contact)
    x = lower.x
    drop = float((upper.heights - lower.heights).min()) + approach
    bodies = upper.heights - drop, lower.heights
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 84 * MILLIMETRE), layout="constrained")
        whole, large = figure.subplots(2, 1, height_ratios=[1, 1.5])
        _bodies(whole, x, *bodies)
        whole.plot(*touching.centre[:, ::2].T, "o", color=FORCE, markersize=2, markeredgewidth=0)
        whole.set_title(
            f"{_count(len(touching), 'contact')} at an approach of {1000 * approach:.4g} nm"
            + ("" if load is None and offset is None else "\n")
            + ", ".join(
                ([] if load is None else [f"$F_N$ = {load:.4g} mN"])
                + ([] if offset is None else [f"upper profile moved by {offset:.4g} µm"])
            ),
            loc="left",
            pad=3,
        )
        if len(touching):
            largest = int(touching.force.argmax())
            half = max(_ZOOM * lower.spacing, 6 * float(np.sqrt(touching.radius[largest] * touching.overlap[largest])))
            centre = touching.centre[largest]
            shown = np.abs(x - centre[0]) <= half
            _bodies(large, x[shown], *(body[shown] for body in bodies))
            large.set_xlim(x[shown][0], x[shown][-1])
            whole.axvspan(centre[0] - half, centre[0] + half, color="0.5", alpha=0.25, linewidth=0)
            large.set_title("where most of the load is", loc="left", pad=3)
            arrows = np.abs(touching.centre[:, 0] - centre[0]) <= half
        whole.set_xlim(x[0], x[-1])
        for ax in (whole, large):
            _label_heights(ax)
        whole.set_xlabel("$x$ (µm)")
        large.set_xlabel("$x$ from the start of the upper profile (µm)")
        handles = _force_handles()
        figure.legend(handles=handles, title=_EXAGGERATED, loc="outside lower center", ncols=len(handles))
        lay_out(figure)
        if len(touching):
            _forces(large, touching, arrows, mu0, tau0)
    return figure


_EXAGGERATED = "heights drawn larger than lengths; arrows are normal\nand tangent to the surfaces as they are drawn"


def _label_heights(axes: Axes) -> None:
    """In nm where µm would have leading zeros."""
    low, high = axes.get_ylim()
    fine = high - low < _FINE
    if fine:
        axes.yaxis.set_major_formatter(lambda value, _: f"{1000 * value:g}".replace("-", "\N{MINUS SIGN}"))
    axes.set_ylabel("height $z$ (nm)" if fine else "height $z$ (µm)")


_FINE = 0.5
"""µm."""


def _bodies(axes: Axes, x: Any, upper: Any, lower: Any) -> None:
    top, bottom = max(float(upper.max()), float(lower.max())), min(float(upper.min()), float(lower.min()))
    margin = 0.05 * (top - bottom)
    axes.fill_between(x, upper, top + margin, color="0.82", linewidth=0)
    axes.fill_between(x, bottom - margin, lower, color="0.45", alpha=0.5, linewidth=0)
    axes.plot(x, upper, color="0.5", linewidth=0.5)
    axes.plot(x, lower, color="0.2", linewidth=0.5)
    axes.set_ylim(bottom - margin, top + margin)


def _force_handles() -> list[Any]:
    from matplotlib.lines import Line2D

    style: dict[str, Any] = {"linestyle": "none", "markersize": 5}
    return [
        Line2D([], [], color=FORCE, marker=r"$\uparrow$", label="elastic force on the upper body", **style),
        Line2D([], [], color=FRICTION, marker=r"$\leftarrow$", label="friction", **style),
    ]


def _forces(axes: Axes, touching: Any, shown: Any, mu0: float, tau0: float) -> None:
    """Elastic forces on the upper body and the friction of the opposing contacts, all to one scale.

    As the surface is drawn: where heights are drawn larger by a factor, so are the slopes that arrows stand on.
    """
    places, normals, tangents = (each[:, ::2] for each in (touching.centre, touching.normal, touching.tangent))  # x, z
    (right, _), (_, up), (x, z) = axes.transData.transform([(1.0, 0.0), (0.0, 1.0), (0.0, 0.0)])
    larger = (up - z) / (right - x)

    def drawn(vectors: Any, factors: Any) -> Any:
        bent = vectors * factors
        return bent / np.hypot(*bent.T)[:, np.newaxis]

    elastic = touching.force[:, np.newaxis] * drawn(normals, (larger, 1.0))
    size = np.where(touching.opposing, mu0 * touching.force + tau0 * touching.area, 0.0)
    resisting = size[:, np.newaxis] * drawn(tangents, (1.0, larger))
    longest = float(touching.force[shown].max())
    for force, colour in ((elastic, FORCE), (resisting, FRICTION)):
        there = shown & (np.hypot(*force.T) > 0)
        # In inches on the page, so that an arrow has the direction that is given whatever the axes are stretched by.
        axes.quiver(
            *places[there].T, *force[there].T, color=colour, angles="uv", scale=longest / 0.45,
            scale_units="inches", width=0.012, units="inches", zorder=3,
        )  # fmt: skip
    axes.plot(*places[shown].T, "o", color=FORCE, markersize=2.5, markeredgewidth=0, zorder=4)
