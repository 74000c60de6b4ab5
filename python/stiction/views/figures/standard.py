"""Selection of the figures of a result: figures that the study lists, or standard figures for measured surfaces."""

from __future__ import annotations

import contextlib
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np
import xarray
from matplotlib.figure import Figure

from stiction.evaluate.point import sort_sliding_rules
from stiction.solve.executors import evaluate_in_copy
from stiction.study.study import Study
from stiction.study.study_description import get_pair_name
from stiction.summary.evaluation import Evaluation
from stiction.summary.figure_values import (
    FrictionOverDimension,
    evaluate_area_over_load,
    evaluate_friction_over_dimension,
    evaluate_height_factors,
    evaluate_onset_over_dimension,
    evaluate_positions,
    generate_bodies_by_length_scale,
    generate_profiles,
    iterate_motions,
    remove_undefined_nominal_area,
)
from stiction.views.figures.budget import dwell_time_figure, uncertainty_budget_figure
from stiction.views.figures.contact import contact_forces_figure, contacts_and_pressure_figure
from stiction.views.figures.distributions import (
    MIN_COMPASS_DIRECTIONS,
    contact_sizes_figure,
    friction_by_direction_figure,
    friction_by_position_figure,
)
from stiction.views.figures.ensemble import area_figure, friction_figure, length_scales_figure, profiles_figure
from stiction.views.figures.height_scale import height_scale_figure
from stiction.views.figures.loads import adhesion_figure, closure_figure, cut_off_figure, friction_by_load_figure
from stiction.views.figures.onset import contains_slip_map, onset_by_dimension_figure, onset_figure, slip_figure
from stiction.views.style import MATPLOTLIB_STYLE, literal_text, parse_formats, render_figure, write_figure_file

if TYPE_CHECKING:
    from stiction.companions.height_scale import ScaledBodies


def draw_figures(
    result: Evaluation | xarray.Dataset, directory: str | Path, *, formats: Sequence[str] = ("png",),
    picture: xarray.Dataset | None = None, first: bool = False,
) -> list[Path]:  # fmt: skip
    """Draw the figures of a result, save them as files, and return the paths of the files.

    A copy of this process draws every second figure, if the process can be copied.

    Generated surfaces have the figures that the section [figures] of the study lists: ``profiles``, ``length_scales``,
    ``friction_mu0_*`` (one for each mu0), ``area`` and ``onset``. File names contain the sliding rule and direction if
    there are several, as in ``friction_mu0_0.4_all_90.png``. Measured surfaces have ``friction`` (against load),
    ``compass``, ``positions``, ``closure`` (maps), ``budget``, ``waiting``, ``adhesion``, ``sizes``, ``cut_off``,
    ``onset``, ``slip``, ``contact`` (profiles), ``contacts`` (maps) and ``height_scale``, if the result contains the
    data. Names for further values of mu0 and tau0 end in a number: ``friction-2.png``.

    Parameters
    ----------
    result : Result, or xarray.Dataset of member sums
    directory : path
    formats : sequence of {"png", "pdf", "svg"}
        File formats; every figure is written in all of them.
    picture : xarray.Dataset, optional
        Result of `contact_picture`; by default the picture stored with the result.
    first : bool
        True to draw only the first figure, and figures whose files already exist.

    Raises
    ------
    ValueError
        If a format is unknown, there is nothing to draw, or a file cannot be written.
    """
    file_extensions = parse_formats(formats)
    paths: dict[str, list[Path]] = {}
    figures = []
    for name, draw_figure in select_figures(result, picture):
        figure_paths = [Path(directory) / f"{name}.{file_extension}" for file_extension in file_extensions]
        if not first or not paths or any(path.exists() for path in figure_paths):
            paths[name] = figure_paths
            figures.append((name, draw_figure))

    own_figures, other_figures = figures[::2], figures[1::2]
    render_others = partial(
        _render_figures_to_files, [draw_figure for _, draw_figure in other_figures], file_extensions
    )
    with evaluate_in_copy(render_others) if other_figures else contextlib.nullcontext(list) as get_other_files:
        for name, draw_figure in own_figures:
            _write_files(paths[name], _render_figure_to_files(draw_figure, file_extensions))
        for (name, _), contents in zip(other_figures, get_other_files(), strict=True):
            _write_files(paths[name], contents)
    return [path for figure_paths in paths.values() for path in figure_paths]


def _render_figures_to_files(
    drawing_functions: Iterable[Callable[[], Figure]], file_extensions: Sequence[str]
) -> list[list[bytes]]:
    return [_render_figure_to_files(draw_figure, file_extensions) for draw_figure in drawing_functions]


def _render_figure_to_files(draw_figure: Callable[[], Figure], file_extensions: Sequence[str]) -> list[bytes]:
    """Draw a figure and return it as bytes in each file format, such as PNG."""
    with mpl.rc_context(MATPLOTLIB_STYLE):
        figure = draw_figure()
        return [render_figure(figure, file_extension) for file_extension in file_extensions]


def _write_files(paths: Iterable[Path], contents: Iterable[bytes]) -> None:
    for path, content in zip(paths, contents, strict=True):
        write_figure_file(content, path)


def select_figures(
    result: Evaluation | xarray.Dataset, picture: xarray.Dataset | None = None
) -> Iterator[tuple[str, Callable[[], Figure]]]:
    """Yield the name of each figure of a result, with the function that draws the figure."""
    result = Evaluation.of(result)
    if not result.study.is_measured:
        yield from _generated_surface_figures(result, result.study)
        return
    yield from _measured_surface_figures(result, result.study, result.contact_picture if picture is None else picture)


def format_title_for_print(pair_name: str) -> str:
    """Return the name of a pair for print: file names without extensions, with spaces instead of underscores."""
    return literal_text(re.sub(r"\.\w+(?= on |$)", "", pair_name).replace("_", " "))


# ---- Figures of generated surfaces -----------------------------------------------------------------------------------


def _generated_surface_figures(result: Evaluation, study: Study) -> Iterator[tuple[str, Callable[[], Figure]]]:
    for name in study.figures.draw:
        match name:
            case "profiles":
                yield "profiles", lambda: profiles_figure(generate_profiles(study), study)
            case "length-scales":
                yield "length_scales", lambda: length_scales_figure(generate_bodies_by_length_scale(study))
            case "friction":
                for suffix, motion_result in iterate_motions(result):
                    evaluate_once = cache(partial(evaluate_friction_over_dimension, motion_result, study.friction.mu0))
                    for index, mu0 in enumerate(study.friction.mu0):
                        yield f"friction_mu0_{mu0:.12g}{suffix}", partial(_friction_figure, evaluate_once, index)
            case "area":
                for suffix, motion_result in iterate_motions(result):
                    yield f"area{suffix}", partial(_area_figure, motion_result)
            # The onset of sliding is stored only for studies with one direction and friction at all contacts.
            case "onset":
                yield "onset", partial(_onset_figure, next(iterate_motions(result))[1])


def _friction_figure(evaluate: Callable[[], list[FrictionOverDimension]], index: int) -> Figure:
    return friction_figure(evaluate()[index])


def _area_figure(result: Evaluation) -> Figure:
    return area_figure(evaluate_area_over_load(result), result.study)


def _onset_figure(result: Evaluation) -> Figure:
    points = evaluate_onset_over_dimension(result)
    assert points is not None, "the figure is drawn only if the study contains the onset"
    return onset_by_dimension_figure(points, result.study)


# ---- Figures of measured surfaces ------------------------------------------------------------------------------------


def _measured_surface_figures(
    result: Evaluation, study: Study, picture: xarray.Dataset | None
) -> Iterator[tuple[str, Callable[[], Figure]]]:
    study_loads = [float(load) for load in study.friction.load]
    points = sort_sliding_rules(result.at_report_loads, study)
    unfiltered_points, title, hardness = (
        points.isel(cut_off=0),
        format_title_for_print(get_pair_name(study)),
        study.contact.hardness,
    )
    first_load, onset = study_loads[0], result.onset
    has_several_cutoffs = points.sizes["cut_off"] > 1 or result.values_at_cutoffs is not None
    for number, (mu0_index, tau0_index) in enumerate(np.ndindex(points.sizes["mu0"], points.sizes["tau0"]), 1):
        suffix = "" if number == 1 else f"-{number}"
        selection = unfiltered_points.isel(mu0=mu0_index, tau0=tau0_index)
        dataset = selection.sel(load=first_load, method="nearest")
        points_over_load = remove_undefined_nominal_area(selection, study)
        yield f"friction{suffix}", partial(friction_by_load_figure, points_over_load, study_loads, title=title)
        if points.sizes.get("direction", 1) >= MIN_COMPASS_DIRECTIONS:
            yield f"compass{suffix}", partial(friction_by_direction_figure, dataset, title=title)
        yield f"positions{suffix}", partial(_positions_figure, result, dataset, title=title)
        if has_several_cutoffs:
            yield f"cut_off{suffix}", partial(_cut_off_figure, result, mu0_index, tau0_index, title=title)
    for scaled_bodies in result.height_factors:
        name = "height_scale" if scaled_bodies == "both" else f"height_scale_{scaled_bodies}"
        for number, indices in enumerate(np.ndindex(points.sizes["mu0"], points.sizes["tau0"]), 1):
            suffix = "" if number == 1 else f"-{number}"
            yield name + suffix, partial(_height_factor_figure, result, scaled_bodies, indices, title=title)
    if study.is_areal:
        yield "closure", partial(closure_figure, unfiltered_points.sel(load=slice(max(study_loads))), title=title)
    yield "budget", lambda: uncertainty_budget_figure(result.summary().first, title=title)
    if study.friction.wait:
        yield "waiting", lambda: dwell_time_figure(result.summary().first, title=title)
    if onset is not None:
        yield "onset", partial(onset_figure, onset, title=title)
        if contains_slip_map(onset):
            yield "slip", partial(slip_figure, onset, title=title)
    if study.contact.adheres and (loading_cycle := result.loading_cycle) is not None:
        yield "adhesion", partial(adhesion_figure, loading_cycle, title=title)
    if "patch_area" in points and np.isfinite(points["patch_area"].values).any():
        dataset = unfiltered_points.isel(mu0=0, tau0=0).sel(load=study_loads, method="nearest")
        yield "sizes", partial(_contact_sizes_figure, result, dataset, hardness=hardness, title=title)
    if picture is not None and study.is_areal:
        direction = float(np.atleast_1d(points["direction"].values)[0])
        yield (
            "contacts",
            partial(contacts_and_pressure_figure, picture, direction=direction, hardness=hardness, title=title),
        )
    elif (contact_forces := result.contact_forces) is not None:
        yield "contact", partial(contact_forces_figure, contact_forces, title=title)


def _cut_off_figure(result: Evaluation, mu0_index: int, tau0_index: int, *, title: str) -> Figure:
    limits = result.summary().find_resolution_limits(mu0_index, tau0_index)
    assert limits is not None, "the figure is drawn only if there are several cutoffs"
    return cut_off_figure(limits, title=title)


def _positions_figure(result: Evaluation, point: xarray.Dataset, *, title: str) -> Figure:
    return friction_by_position_figure(evaluate_positions(result, point), title=title)


def _height_factor_figure(
    result: Evaluation, scaled_bodies: ScaledBodies, indices: tuple[int, ...], *, title: str
) -> Figure:
    return height_scale_figure(evaluate_height_factors(result, scaled_bodies, *indices), title=title)


def _contact_sizes_figure(result: Evaluation, dataset: xarray.Dataset, **options: Any) -> Figure:
    return contact_sizes_figure(result.dataset[["patch_area", "pressure"]].isel(cut_off=0), dataset, **options)
