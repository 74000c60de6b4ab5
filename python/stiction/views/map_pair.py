"""Two maps pressed at several relative positions: a table for the terminal, and figures for print."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from stiction.studies.map_pair import OF_SURROGATES, contacts_at, kind_of
from stiction.surfaces.profile import Profile
from stiction.surfaces.surface import Surface
from stiction.views.style import MILLIMETRE, STYLE, WIDTH, lay_out, save_picture
from stiction.views.traverse import HIGHEST_MU0, _cell, _count, _material, _materials, _then, advice

if TYPE_CHECKING:
    import xarray
    from matplotlib.figure import Figure

_OF_CONTACT: dict[str | tuple[str, float], tuple[str, float]] = {
    "contact_area_fraction": ("true area A/A0 (%)", 100.0),
    "contact_count": ("contacts", 1.0),
    ("patch_area", 0.5): ("  half of them are below (µm²)", 1.0),
    ("patch_area", 0.9): ("  nine tenths of them are below (µm²)", 1.0),
    ("pressure", 0.5): ("pressure on half of the true area below (GPa)", 1.0),
    ("pressure", 0.9): ("  pressure on nine tenths of it below (GPa)", 1.0),
    "normal_stiffness": ("normal stiffness (mN/µm)", 1.0),
    "approach": ("approach (nm)", 1000.0),
    "share_on_largest": ("load on the contact that carries most (%)", 100.0),
    "share_on_steepest_upper": ("load on the steepest tenth of the upper (%)", 100.0),
    "share_on_steepest_lower": ("load on the steepest tenth of the lower (%)", 100.0),
}
"""What the table says of each load, a quantile of some, and the factor to its unit."""

_RULES = {
    "opposing": "contacts that oppose the motion rub, the others do not (the paper's rule)",
    "all": "all contacts rub",
}

_AXES = {0.0: "+x", 90.0: "+y", 180.0: "-x", 270.0: "-y"}

FEW_CONTACTS = 20
"""Below it, on the mean, a coefficient is that of single contacts."""

MERGED = 0.3
"""Share of the area from which on contacts are few because they are one."""

HIGH_PRESSURE = 0.01
"""Of E*; metals yield at less."""

MOSTLY_ONE = 40.0
"""Percent of the load on one contact from which on a result is that of one place."""

OVERLAPPING = 0.1
"""Share of the load on overlapping ellipses from which on asperities are doubted."""

_COLOURS = {"opposing": "C0", "all": "C1"}
_LINES = {
    "half-space": "-", "asperities": "--", f"half-space{OF_SURROGATES}": "-.", f"asperities{OF_SURROGATES}": ":",
}  # fmt: skip


# ---- Text ------------------------------------------------------------------------------------------------------------


def map_pair_text(result: xarray.Dataset, mean: xarray.Dataset, loads: Any) -> str:
    """What was pressed and what it says at some of its loads, with 95 % intervals and units.

    Parameters
    ----------
    result, mean : xarray.Dataset
        What `pressed_maps` returns, with a dimension mechanics, and its `pressed_maps_mean` or `means_of_all`.
    loads : (l,) array_like of float, mN
        Of those of the result.
    """
    rows, columns = (int(points) for points in result.attrs["shape"])
    dy, dx = (float(step) for step in result.attrs["spacing_um"])
    area = float(result["nominal_area"])
    lines = [
        f"{'upper':<10} {_then(result.attrs['upper'])}",
        f"{'lower':<10} {_then(result.attrs['lower'])}",
        *_pieces(result, f"{rows} x {columns} points, {rows * dy:.4g} x {columns * dx:.4g} µm"),
        f"{'model':<10} E* = {float(result['effective_modulus']):g} GPa, {_material(result)}",
        *(f"{'':<10} {name}: {_MECHANICS[name]}" for name in _names(result)),
    ]
    if "hardness_GPa" in result.attrs:
        lines.append(f"{'':<10} pressures up to a hardness of {float(result.attrs['hardness_GPa']):g} GPa")
    last = ""
    for load in np.atleast_1d(loads):
        at = mean.sel(load=load, method="nearest")
        lines += [
            "",
            f"at {1000 * load / area:.4g} MPa, {load:.4g} mN on {area:.4g} µm²: means and 95 % intervals",
            *_table(at),
            *_doubts_of(_without_contacts(result).sel(load=load, method="nearest"), at),
        ]
        last = _in_one_sentence(at, float(load), area)
    lines += ["", *_READING, *_of_intervals(result), last]
    return "\n".join(lines) + "\n"


def _without_contacts(result: xarray.Dataset) -> xarray.Dataset:
    return result.drop_dims("contact") if "contact" in result.dims else result


def _kinds(result: xarray.Dataset) -> dict[bool, xarray.Dataset]:
    """Of a result, its shifts (False) and its pairs of surrogates (True)."""
    of = result["surrogate"].values if "surrogate" in result.coords else np.zeros(result.sizes["shift"], dtype=bool)
    return {surrogates: kind_of(result, surrogates) for surrogates in (False, True) if (of == surrogates).any()}


def _own(result: xarray.Dataset, name: str) -> xarray.Dataset:
    """What a column of the table is a mean of."""
    kinds = _kinds(result)
    kept = kinds[True] if name.endswith(OF_SURROGATES) or False not in kinds else kinds[False]
    return kept.sel(mechanics=name.removesuffix(OF_SURROGATES))


def _pieces(result: xarray.Dataset, size: str) -> list[str]:
    """What was pressed."""
    level = {"plane": "a plane", "quadratic": "a polynomial of second degree", "mean": "its mean"}
    how = f"each {size}, levelled by {level[str(result.attrs.get('level', 'plane'))]}"
    kinds, lines = _kinds(result), []
    if False in kinds:
        x, y = kinds[False]["x"].values, kinds[False]["y"].values
        lines += [
            f"{'overlap':<10} {_count(x.size, 'shift')}, {how}",
            f"{'':<10} the upper map moved by {_span(x)} µm along x and {_span(y)} µm along y",
        ]
    if True in kinds:
        of = "isotropic surfaces" if result.attrs.get("of_profiles") else "new phases"
        number, seed = _count(kinds[True].sizes["shift"], "pair"), int(result.attrs["seed"])
        where = ", of the same size" if lines else f", {how}"
        lines.append(f"{'surrogates':<10} {number} with the spectra of both, {of}, seed {seed}{where}")
    return lines


def _of_intervals(result: xarray.Dataset) -> list[str]:
    """What each interval is an interval of."""
    kinds, lines = _kinds(result), []
    if False in kinds:
        lines.append(
            f"Intervals are over {_count(kinds[False].sizes['shift'], 'shift')} of these two maps: how well the mean "
            "over all their relative positions\nis known. Other pieces of the surfaces may differ by more."
        )
    if True in kinds:
        own = kinds[True]["friction_coefficient"].isel(mechanics=0, mu0=0, tau0=0).sel(sliding="opposing")
        at = own.sel(load=np.atleast_1d(result.attrs.get("loads_mN", own["load"].values))[0], method="nearest")
        spread = np.sqrt(np.mean(at.var("shift", ddof=min(1, at.sizes["shift"] - 1)).values))
        lines.append(
            f"Those of surrogates are over {_count(kinds[True].sizes['shift'], 'independent pair')} of surfaces with "
            "these spectra: how well the mean over surfaces of\nthis kind is known. Of single pairs of this size mu_s "
            f"scatters by {float(spread):.2g} (standard deviation in one direction,\nopposing contacts)."
        )
    return lines


_MECHANICS = {
    "half-space": "the elastic half-space, free at its edges",
    "asperities": "elliptic Hertz contacts at the minima of the gap, which do not feel each other",
}

_READING = (
    "The load is the elastic one, before anything slides; mu_s = F_T/F_N with what friction on slopes adds to F_N.",
)


def _names(result: xarray.Dataset) -> list[str]:
    return [str(name) for name in result["mechanics"].values]


def _span(values: Any) -> str:
    low, high = float(values.min()), float(values.max())
    return f"{low:.3g}" if low == high else f"{low:.3g} to {high:.3g}"


def _picked(at: xarray.Dataset, key: str | tuple[str, float]) -> xarray.DataArray:
    """A variable, or a quantile of it; NaN where an older result has none."""
    name, quantile = key if isinstance(key, tuple) else (key, None)
    if name not in at:
        return at["contact_area"] * np.nan
    return at[name] if quantile is None else at[name].sel(quantile=quantile, method="nearest")


def _table(at: xarray.Dataset) -> list[str]:
    """The lines of one load, a column for each mechanics."""
    names = _names(at)
    table = [["", *names]]
    for key, (title, factor) in _OF_CONTACT.items():
        picked = _picked(at, key)
        if np.isfinite(picked).any() or key in ("contact_area_fraction", "contact_count"):
            table.append([title, *(_cell(factor * picked.sel(mechanics=each).values, title) for each in names)])
    shares = at["share_opposing"].isel(direction=0)
    table.append(
        [
            f"load that opposes, {_way(float(at['direction'][0]))} (%)",
            *(_cell(100 * shares.sel(mechanics=each).values, "share_opposing") for each in names),
        ]
    )
    materials = _materials(at)
    for material, place in materials:
        here = at.isel(place)
        for rule, words in _RULES.items():
            of = f", {material}" if len(materials) > 1 else ""
            table.append([f"{words}{of}"])
            rules = here.sel(sliding=rule)
            coefficients = {each: rules["friction_coefficient"].sel(mechanics=each) for each in names}
            for direction in _shown(at["direction"].values):
                values = [_cell(coefficients[each].sel(direction=direction).values, "mu_s") for each in names]
                table.append([f"  mu_s {_way(direction)}", *values])
            if at.sizes["direction"] > 2:
                for title, choose in (("largest", np.nanargmax), ("smallest", np.nanargmin)):
                    values = [_extreme(coefficients[each], choose) for each in names]
                    table.append([f"  {title} around the compass", *values])
            alone = rules["gentle_friction"].sel(statistic="mean").mean("direction")
            values = [f"{float(alone.sel(mechanics=each)):.3g}" for each in names]
            table.append(["  by its slope alone (gentle_friction)", *values])
    whole = [row for row in table if len(row) > 1]
    widths = [max(len(row[column]) for row in whole) + 2 for column in range(len(names) + 1)]
    return ["".join(cell.ljust(width) for cell, width in zip(row, widths, strict=False)).rstrip() for row in table]


def _shown(directions: Any) -> list[float]:
    """Along the axes where these are among many; all of a few."""
    listed = [float(each) for each in directions]
    if len(listed) <= 4:
        return listed
    return [each for each in (0.0, 90.0) if each in listed] or listed[:2]


def _way(direction: float) -> str:
    return f"to {_AXES[direction]}" if direction in _AXES else f"at {direction:g}°"


def _extreme(coefficients: xarray.DataArray, choose: Any) -> str:
    """The direction with the largest or smallest mean."""
    means = coefficients.sel(statistic="mean").values
    if np.isnan(means).all():
        return "none"
    place = int(choose(means))
    return f"{_cell(coefficients.isel(direction=place).values, 'mu_s')} at {float(coefficients['direction'][place]):g}°"


def _doubts_of(result: xarray.Dataset, at: xarray.Dataset) -> list[str]:
    """How far each mechanics is to be trusted at a load, in words."""
    lines = []
    gradient = at["rms_gradient"].isel(mechanics=0).values
    lines.append(f"gap: h' = {_cell(gradient, 'h')}, its root-mean-square gradient")
    for name in _names(at):
        own, mean = _own(result, name), at.sel(mechanics=name).sel(statistic="mean")
        kinds, numbers = np.unique(own["status"].isel(sliding=0, direction=0, mu0=0, tau0=0), return_counts=True)
        missing = [f"{number} {kind}" for kind, number in zip(kinds, numbers, strict=True) if kind != "ok"]
        if missing:
            lines.append(f"{name}: pieces without an answer: {', '.join(missing)} of {numbers.sum()}")
            lines += advice(kinds.tolist())
        if len(missing) == kinds.size:
            continue
        if name.startswith("half-space"):
            lines.append(f"{name}: solved to an error of {float(own['error'].max()):.1g} (of the gap's deviation)")
            largest, edge = (100 * float(mean[each]) for each in ("share_on_largest", "share_at_edge"))
            lines.append(
                f"{name}: one contact carries {largest:.0f} % of the load on the mean, and {edge:.0f} % is on "
                "contacts that the edge of the overlap cuts"
            )
            if largest > MOSTLY_ONE:
                lines.append(
                    f"{name}: so few places carry the load because the highest waves are as long as the maps; larger "
                    "maps, or more load, say more"
                )
            if "hardness_GPa" in result.attrs:
                share = 100 * float(mean["load_share_at_hardness"])
                lines.append(f"{name}: {share:.0f} % of the load is where the pressure is the hardness")
        else:
            overlapping = float(mean["share_overlapping"])
            doubt = ": there contacts would merge, and the true area is larger" if overlapping > OVERLAPPING else ""
            lines.append(f"{name}: {100 * overlapping:.0f} % of the load is on ellipses that overlap{doubt}")
            beyond = float(mean["share_beyond_hertz"])
            if beyond > OVERLAPPING:
                lines.append(f"{name}: {100 * beyond:.0f} % of the load is beyond Hertz (overlap > R/10)")
        pressure = float(at["load"]) / float(at["nominal_area"]) / float(mean["contact_area_fraction"])
        high = pressure > HIGH_PRESSURE * float(at["effective_modulus"]) and "hardness_GPa" not in result.attrs
        near = "" if not high else "; a hardness near that limits it (--hardness)"
        lines.append(f"{name}: the pressure in contact is {pressure:.2g} GPa on the mean{near}")
        count, fraction = float(mean["contact_count"]), float(mean["contact_area_fraction"])
        if count < FEW_CONTACTS and fraction < MERGED:
            lines.append(
                f"{name}: {count:.2g} contacts on the mean are few, so mu_s is that of single contacts; larger maps or "
                "more load would have more"
            )
    return lines


def _in_one_sentence(at: xarray.Dataset, load: float, area: float) -> str:
    """What may be quoted of the first mechanics and material."""
    first = at.isel({"mechanics": 0} | _materials(at)[0][1])
    if np.isnan(first["contact_area_fraction"].sel(statistic="mean")):
        return f"At {1000 * load / area:.4g} MPa there is no answer."
    around = first["friction_coefficient"].sel(statistic="mean").mean("direction")
    alone = first["gentle_friction"].sel(statistic="mean").mean("direction")
    ends = first["friction_coefficient"]
    lowest, highest = ends.sel(statistic="lower").min("direction"), ends.sel(statistic="upper").max("direction")

    def said(rule: str) -> str:
        words = f"{float(around.sel(sliding=rule)):.3g}"
        if np.isfinite(lowest.sel(sliding=rule)) and np.isfinite(highest.sel(sliding=rule)):
            words += (
                f" [{float(lowest.sel(sliding=rule)):.2g} to {float(highest.sel(sliding=rule)):.2g} in any direction]"
            )
        return f"{words}, by slope alone {float(alone.sel(sliding=rule)):.3g},"

    opposing, every = (said(rule) for rule in _RULES)
    percent = 100 * float(first["contact_area_fraction"].sel(statistic="mean"))
    return (
        f"In short: at {1000 * load / area:.4g} MPa {percent:.3g} % of the area touches; around the compass mu_s is\n"
        f"{opposing} if only opposing contacts rub, and\n"
        f"{every} if all rub, which is the rule for a mu0 that was measured on smooth faces."
    )


def map_pair_csv(mean: xarray.Dataset, loads: Any) -> str:
    """Means and intervals as CSV: a row for each load, mechanics, rule, mu0, tau0 and direction, units in the header.

    Parameters
    ----------
    mean : xarray.Dataset
        What `pressed_maps_mean` returns, with a dimension mechanics.
    loads : (l,) array_like of float, mN
        Of those of the result.
    """
    columns: dict[str | tuple[str, float], tuple[str, float]] = {
        "friction_coefficient": ("mu_s", 1.0),
        "normal_load": ("normal load with friction (mN)", 1.0),
        "gentle_friction": ("mu_s by slope alone", 1.0),
        "share_opposing": ("load that opposes (%)", 100.0),
        **_OF_CONTACT,
    }  # fmt: skip
    header = ["load (mN)", "mechanics", "rubbing contacts", "mu0", "tau0 (MPa)", "direction (degrees)", "shifts"]
    header += ["shifts with an answer"]
    for title, _ in columns.values():
        header += [title.strip(), f"{title.strip()}: lower", f"{title.strip()}: upper"]
    rows = [header]
    for load in np.atleast_1d(loads):
        for name in _names(mean):
            for rule in _RULES:
                for _, place in _materials(mean):
                    here = mean.isel(place).sel(load=load, method="nearest").sel(mechanics=name, sliding=rule)
                    for direction in mean["direction"].values:
                        at = here.sel(direction=direction)
                        numbers = [
                            factor * value for key, (_, factor) in columns.items() for value in _picked(at, key).values
                        ]
                        head = [
                            f"{load:.12g}", name, rule, f"{float(at['mu0']):.12g}", f"{1000 * float(at['tau0']):.12g}",
                            f"{direction:.12g}", str(int(at["shifts"])), str(int(at["ok"])),
                        ]  # fmt: skip
                        rows.append([*head, *("" if np.isnan(value) else f"{value:.9g}" for value in numbers)])
    return "".join(",".join(row) + "\n" for row in rows)


def map_doubts(
    bodies: dict[str, Surface | Profile], loads: Any, area: float, *, mu0: Any, effective_modulus: float
) -> list[str]:
    """A sentence on each thing that is seldom meant."""
    sentences = [
        f"{name}: heights span {np.ptp(body.heights):.3g} µm over {np.min(body.extent):.3g} µm; is their unit right?"
        for name, body in bodies.items()
        if np.ptp(body.heights) > np.min(body.extent) / 2
    ]
    if max(mu0) > HIGHEST_MU0:
        sentences.append(f"mu0 = {max(mu0):g} is more than any pair of materials has; is it in percent?")
    sentences += [
        f"{load:.4g} mN is {1000 * load / area:.3g} MPa on {area:.4g} µm², more than a tenth of E*; is it the load of "
        "a whole part?"
        for load in loads
        if load / area > 0.1 * effective_modulus
    ]
    return sentences


# ---- Figures ---------------------------------------------------------------------------------------------------------


def save_map_pair_figures(result: xarray.Dataset, mean: xarray.Dataset, loads: Any, directory: Path) -> list[Path]:
    """Draw a pair of maps into a directory and return the paths.

    ``compass.png``: `compass_figure` of the first load. ``friction.png``: `map_load_figure`. Further mu0 and tau0 have
    theirs, ``compass-2.png`` and so on. ``sizes.png``: `distribution_figure`. ``contacts.png``: `contacts_figure` of
    the shift that the result has heights of, if it has any.
    """
    load = float(np.atleast_1d(loads)[0])
    figures = {}
    for number, (_, place) in enumerate(_materials(mean), 1):
        of, own = "" if number == 1 else f"-{number}", mean.isel(place)
        figures[f"compass{of}.png"] = compass_figure(own, load)
        figures[f"friction{of}.png"] = map_load_figure(own, loads)
    if "patch_area" in mean and np.isfinite(mean["patch_area"]).any():
        figures["sizes.png"] = distribution_figure(mean, loads)
    if "pictured_shift" in result.attrs:
        figures["contacts.png"] = contacts_figure(result)
    paths = [directory / name for name in figures]
    for path, figure in zip(paths, figures.values(), strict=True):
        save_picture(figure, path)
    return paths


def typical_shift(result: xarray.Dataset, load: float) -> int | None:
    """The shift of which the number of contacts is in the middle, of the first mechanics; None if none has any."""
    counts = _without_contacts(result)["contact_count"].isel(mechanics=0).sel(load=load, method="nearest").values
    known = np.flatnonzero(np.isfinite(counts) & (counts > 0))
    if "surrogate" in result.coords and not result["surrogate"].values.all():
        known = known[~result["surrogate"].values[known]]
    return int(known[np.argsort(counts[known], kind="stable")[known.size // 2]]) if known.size else None


def _sign(words: str) -> str:
    """With the minus of numbers."""
    return words.replace("-", "\N{MINUS SIGN}")


def _head(mean: xarray.Dataset, load: float | None = None) -> str:
    """Whose figure it is."""
    files = str(mean.attrs.get("files", "two maps"))
    if load is None:
        return files
    pressure = 1000 * load / float(mean["nominal_area"])
    return f"{files}, {pressure:.4g} MPa ({load:.4g} mN)"


def _over(mean: xarray.Dataset) -> str:
    """What the first intervals are over."""
    return "pairs of surrogates" if mean.attrs.get("of_profiles") else "shifts"


def _material_title(mean: xarray.Dataset) -> str:
    return (
        rf"$E^*$ = {float(mean['effective_modulus']):g} GPa, $\mu_0$ = {float(mean['mu0']):g}, "
        rf"$\tau_0$ = {1000 * float(mean['tau0']):g} MPa"
    )


def compass_figure(mean: xarray.Dataset, load: float) -> Figure:
    """Friction coefficient against the direction of the upper body's motion, by both sliding rules; 80 mm wide."""
    import matplotlib as mpl
    from matplotlib.figure import Figure
    from matplotlib.ticker import MaxNLocator

    at = mean.sel(load=load, method="nearest").sortby("direction")
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 100 * MILLIMETRE), layout="constrained")
        axes: Any = figure.add_subplot(projection="polar")
        around = np.radians(np.append(at["direction"].values, at["direction"].values[0] + 360))
        closed = at.sizes["direction"] > 2
        for number, name in enumerate(_names(at)):
            for rule, colour in _COLOURS.items():
                values = at["friction_coefficient"].sel(mechanics=name, sliding=rule).transpose("statistic", ...).values
                rounded = np.concatenate([values, values[:, :1]], axis=1)
                label = f"{name}: {'opposing contacts rub' if rule == 'opposing' else 'all contacts rub'}"
                if closed:
                    axes.plot(around, rounded[0], _LINES[name], color=colour, linewidth=1, label=label)
                else:
                    axes.plot(around[:-1], values[0], "o" if number == 0 else "x", color=colour, label=label)
                if number == 0 and np.isfinite(values[1:]).all():
                    if closed:
                        axes.fill_between(around, rounded[1], rounded[2], color=colour, alpha=0.2, linewidth=0)
                    else:
                        axes.vlines(around[:-1], values[1], values[2], color=colour, linewidth=0.8)
        if closed:
            for rule in _COLOURS:
                alone = at["gentle_friction"].isel(mechanics=0).sel(sliding=rule, statistic="mean").values
                words = "by the slope of the gap alone" if rule == "opposing" else "_"  # once in the legend
                axes.plot(around, np.append(alone, alone[0]), ":", color="0.2", linewidth=0.8, label=words)
        axes.set_ylim(bottom=0)
        axes.grid(linewidth=0.3, color="0.8")
        axes.set_rlabel_position(22.5)
        axes.yaxis.set_major_locator(MaxNLocator(5))
        ways = ("+x", "45°", "+y", "135°", "-x", "225°", "-y", "315°")
        axes.set_xticks(np.radians(np.arange(0, 360, 45)), [_sign(way) for way in ways])
        figure.suptitle(f"{_head(mean, load)}\n" + rf"$\mu_s$; {_material_title(mean)}", fontsize=6)
        handles, labels = axes.get_legend_handles_labels()
        figure.legend(
            handles, labels, loc="outside lower center", ncols=1,
            title=f"upper body to; shaded: 95 % over the {_over(at)}",
        )  # fmt: skip
        lay_out(figure)
    return figure


def map_load_figure(mean: xarray.Dataset, loads: Any) -> Figure:
    """Friction coefficient in the first direction and share of the area against pressure; 80 mm wide."""
    import matplotlib as mpl
    from matplotlib.figure import Figure

    area = float(mean["nominal_area"])
    pressure = 1000 * mean["load"].values / area
    direction = float(mean["direction"][0])
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 92 * MILLIMETRE), layout="constrained")
        top, bottom = figure.subplots(2, 1, sharex=True, height_ratios=[1.2, 1])
        for name in _names(mean):
            style = {"linestyle": _LINES[name], "linewidth": 0.9, "marker": "o", "markersize": 2.5}
            for rule, colour in _COLOURS.items():
                at = mean["friction_coefficient"].sel(mechanics=name, sliding=rule, direction=direction)
                values = at.transpose("statistic", "load").values
                top.fill_between(pressure, values[1], values[2], color=colour, alpha=0.15, linewidth=0)
                label = f"{name}: {'opposing contacts rub' if rule == 'opposing' else 'all contacts rub'}"
                top.plot(pressure, values[0], color=colour, label=label, **style)
            values = 100 * mean["contact_area_fraction"].sel(mechanics=name).transpose("statistic", "load").values
            bottom.fill_between(pressure, values[1], values[2], color="C2", alpha=0.15, linewidth=0)
            bottom.plot(pressure, values[0], color="C2", **style)
        if np.nanmax(values, initial=0.0) > 0:
            bottom.set_yscale("log")
        for axes in (top, bottom):
            axes.set_xscale("log")
            _plain(axes.xaxis)
            for load in np.atleast_1d(loads):
                axes.axvline(1000 * load / area, color="0.5", linewidth=0.5, linestyle=":")
        if bottom.get_yscale() == "log":
            _plain(bottom.yaxis)
        top.set_ylim(bottom=0)
        top.set_ylabel(rf"$\mu_s$, upper body {_sign(_way(direction))}")
        bottom.set_ylabel("true area $A/A_0$ (%)")
        bottom.set_xlabel("load over the area of the overlap (MPa)")
        top.set_title(f"{_head(mean)}\n{_material_title(mean)}", loc="left", fontsize=6, pad=3)
        figure.legend(
            *top.get_legend_handles_labels(), title=f"shaded: 95 % over the {_over(mean)}", loc="outside lower center"
        )
        lay_out(figure)
    return figure


def _plain(axis: Any) -> None:
    """Numbers without powers of ten on a logarithmic axis of about a decade."""
    from matplotlib.ticker import LogLocator, NullLocator

    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axis.set_major_formatter(lambda value, _: f"{value:g}")
    axis.set_minor_locator(NullLocator())


def distribution_figure(mean: xarray.Dataset, loads: Any) -> Figure:
    """Share of the contacts against their area, and of the true area against pressure, at each load; 80 mm wide."""
    import matplotlib as mpl
    from matplotlib.figure import Figure

    area = float(mean["nominal_area"])
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 96 * MILLIMETRE), layout="constrained")
        top, bottom = figure.subplots(2, 1)
        share = 100 * mean["quantile"].values
        for number, load in enumerate(np.atleast_1d(loads)):
            for name in _names(mean):
                at = mean.sel(load=load, method="nearest").sel(mechanics=name)
                label = f"{1000 * load / area:.3g} MPa ({load:.3g} mN), {name}"
                for axes, key in ((top, "patch_area"), (bottom, "pressure")):
                    values = at[key].transpose("statistic", "quantile").values
                    axes.plot(values[0], share, _LINES[name], color=f"C{number}", linewidth=0.9, label=label)
                    if name == _names(mean)[0]:
                        axes.fill_betweenx(share, values[1], values[2], color=f"C{number}", alpha=0.2, linewidth=0)
        for axes in (top, bottom):
            axes.set_ylim(0, 100)
            axes.set_xscale("log")
            _plain(axes.xaxis)
        top.set_ylabel("share of the contacts\nthat is smaller (%)")
        top.set_xlabel("area of a contact (µm²)")
        bottom.set_ylabel("share of the true area\nunder less (%)")
        bottom.set_xlabel("pressure (GPa)")
        top.set_title(f"{_head(mean)}\n$E^*$ = {float(mean['effective_modulus']):g} GPa", loc="left", fontsize=6, pad=3)
        handles, labels = top.get_legend_handles_labels()
        figure.legend(handles, labels, title=f"shaded: 95 % over the {_over(mean)}", loc="outside lower center")
        lay_out(figure)
    return figure


def contacts_figure(result: xarray.Dataset) -> Figure:
    """Contacts over the heights that a result holds, and the pressure about the one that carries most; 80 mm wide.

    Parameters
    ----------
    result : xarray.Dataset
        A joined result `with_picture`. Of its directions the first is drawn.
    """
    import matplotlib as mpl
    from matplotlib.figure import Figure

    name, direction, shift = _names(result)[0], float(result["direction"][0]), int(result.attrs["pictured_shift"])
    load = float(result.attrs["pictured_load_mN"])
    found = contacts_at(result, shift, load, name)
    force = found["contact_force"].values
    radians = np.radians(direction)
    opposing = found["contact_slope_x"].values * np.cos(radians) + found["contact_slope_y"].values * np.sin(radians) > 0
    lower = result["lower_height"].values
    fine = np.ptp(lower) < _FINE
    zoomed = "zoom_pressure" in result and name == "half-space"
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, (142 if zoomed else 86) * MILLIMETRE), layout="constrained")
        drawn = figure.subplots(2 if zoomed else 1, 1, squeeze=False)[:, 0]
        axes = drawn[0]
        low, high = np.quantile(lower, [0.01, 0.99]) * (1000 if fine else 1)
        image = axes.imshow(
            lower * (1000 if fine else 1), extent=_box(result, "height"), origin="lower", cmap="gray", vmin=low,
            vmax=high,
        )  # fmt: skip
        figure.colorbar(image, ax=axes, label="lower body " + ("(nm)" if fine else "(µm)"), extend="both", shrink=0.8)
        sizes = 60 * force / force.max()
        for which, colour, words in ((opposing, "C3", "opposing the motion"), (~opposing, "C0", "not opposing it")):
            share = 100 * force[which].sum() / force.sum()
            axes.scatter(
                found["contact_x"].values[which], found["contact_y"].values[which], s=np.maximum(sizes[which], 1.0),
                facecolors="none", edgecolors=colour, linewidths=0.7,
                label=f"{_count(int(which.sum()), 'contact')} {words}, with {share:.0f} % of the load",
            )  # fmt: skip
        axes.set_title(
            f"{_head(result, load)}\n{name}, upper body {_sign(_way(direction))}, {_where(result, shift)}",
            loc="left", fontsize=6, pad=3,
        )  # fmt: skip
        axes.set_xlabel("$x$ (µm)")
        axes.set_ylabel("$y$ (µm)")
        if zoomed:
            _pressure_panel(figure, drawn[1], result)
        figure.legend(
            *axes.get_legend_handles_labels(), loc="outside lower center",
            title="circles grow with the load of a contact, and are larger than it",
        )  # fmt: skip
        lay_out(figure)
    return figure


def _where(result: xarray.Dataset, shift: int) -> str:
    """Which of the pairs of pieces it is."""
    if "surrogate" in result.coords and bool(result["surrogate"][shift]):
        first = int(np.flatnonzero(result["surrogate"].values)[0])
        return f"pair {shift - first + 1} of surrogates"
    x, y = float(result["x"][shift]), float(result["y"][shift])
    return _sign(f"moved by {x:.3g} µm, {y:.3g} µm")


def _box(result: xarray.Dataset, what: str) -> tuple[float, float, float, float]:
    """Where a picture lies: left, right, bottom, top."""
    ends = []
    for axis in ("x", "y"):
        values = result[f"{what}_{axis}"].values
        ends += [float(values[0]), float(2 * values[-1] - values[-2])]
    return ends[0], ends[1], ends[2], ends[3]


def _pressure_panel(figure: Figure, axes: Any, result: xarray.Dataset) -> None:
    """Pressure about the contact that carries most."""
    pressure = result["zoom_pressure"].values
    box = _box(result, "zoom")
    axes.imshow(result["zoom_height"].values, extent=box, origin="lower", cmap="gray", alpha=0.6)
    image = axes.imshow(np.where(pressure > 0, pressure, np.nan), extent=box, origin="lower", cmap="inferno", vmin=0)
    figure.colorbar(image, ax=axes, label="pressure (GPa)", shrink=0.8)
    axes.set_title("around the contact that carries most", loc="left", pad=3)
    axes.set_xlabel("$x$ (µm)")
    axes.set_ylabel("$y$ (µm)")


_FINE = 0.5
"""µm."""
