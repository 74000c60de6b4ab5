"""Tests of the figures of results: their panels, labels, colours and files."""

import json
from dataclasses import replace
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
import xarray
from matplotlib.backends.backend_agg import FigureCanvasAgg, RendererAgg
from matplotlib.figure import Figure
from matplotlib.image import imread
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.patches import PathPatch
from stiction import Profile, Result, Surface, pair
from stiction._text import printable_text
from stiction.companions import resolution
from stiction.companions.contact_forces import build_contact_forces
from stiction.companions.contact_picture import contact_picture
from stiction.companions.resolution import find_resolution_limits
from stiction.evaluate.at_load import at_load
from stiction.evaluate.load_range import choose_loads_in_range
from stiction.evaluate.maps import friction_map
from stiction.study.members import read_measured_bodies
from stiction.study.study import parse_study_of_dataset
from stiction.summary.figure_values import (
    evaluate_area_over_load,
    evaluate_friction_over_dimension,
    find_opposing_contacts,
    generate_bodies_by_length_scale,
)
from stiction.summary.report_data import collect_report_data
from stiction.summary.summary import UncertaintyBudgetEntry, summarize
from stiction.views import style
from stiction.views.figures import draw_figures
from stiction.views.figures.budget import uncertainty_budget_figure
from stiction.views.figures.contact import contact_forces_figure, contact_map_figure, contacts_and_pressure_figure
from stiction.views.figures.ensemble import (
    FULLY_FADED_INTERVAL_WIDTH,
    MAX_FADING,
    MIN_FADED_INTERVAL_WIDTH,
    _compute_cell_fading,
    _fade_colours,
    area_figure,
    friction_figure,
    length_scales_figure,
)
from stiction.views.figures.loads import closure_figure, cut_off_figure, format_log_axis, friction_by_load_figure
from stiction.views.figures.onset import _densest_contact_window
from stiction.views.figures.roughness import characterisation_figure
from stiction.views.figures.standard import select_figures
from stiction.views.report import report_page
from stiction.views.report.pictures import inline_svg, list_panels
from stiction.views.rows import summary_json, summary_table
from stiction.views.style import FIGURE_FORMATS, SLIDING_RULE_LABELS, literal_text, save_figure, spread_label_positions
from support.generated_studies import SMALL_STUDY, empty_dataset
from support.images import find_pixel_centres
from support.report_numbers import ReportEvaluator
from support.studies_of_files import run_pair_of_maps
from support.synthetic_results import measured_result, measured_study


@pytest.mark.parametrize(("rows", "columns"), [((30, 34), (90, 93)), ((0, 2), (0, 1)), ((63, 64), (120, 128))])
def test_zoom_window_of_a_slip_map_contains_the_largest_group_of_contact_points(rows, columns):
    slip = np.full((64, 128), np.nan)
    slip[slice(*rows), slice(*columns)] = slip[10, 20] = 0.5
    coordinates = {"slip_y": 0.5 * np.arange(64), "slip_x": 0.5 * np.arange(128)}
    onset = xarray.Dataset({"slip": (("slip_y", "slip_x"), slip)}, coordinates)
    window, (left, right, bottom, top) = _densest_contact_window(onset)
    assert [part.stop - part.start for part in window] == [16, 16]
    for part, group, size in zip(window, (rows, columns), slip.shape, strict=True):
        centred_start = (group[0] + group[1]) / 2 - 8
        assert abs(part.start - np.clip(centred_start, 0, size - 16)) <= 1
    assert (top - bottom, right - left) == (8.0, 8.0)


@pytest.fixture(scope="module")
def maps_at_two_cutoffs(tmp_path_factory):
    return run_pair_of_maps(tmp_path_factory.mktemp("maps"), cut_off='["0 um", "1 um"]')


# ---- Selection of figures -------------------------------------------------------------------------------------------


def list_figure_names(dataset, picture=None):
    return [name for name, _ in select_figures(dataset, picture)]


def test_figure_settings_of_a_study_determine_which_figures_are_drawn(generated_dataset):
    assert list_figure_names(generated_dataset) == ["friction_mu0_0.1", "friction_mu0_0.4", "friction_mu0_1", "area"]
    study = parse_study_of_dataset(generated_dataset).with_changes({"figures.draw": ["profiles", "length-scales"]})
    assert list_figure_names(generated_dataset.assign_attrs(study=study.to_toml())) == ["profiles", "length_scales"]


def test_results_of_measured_surfaces_have_the_standard_figures_by_default(maps_at_two_cutoffs, profiles_dataset):
    repeated_names = ("friction", "compass", "positions", "cut_off")
    names_with_suffix = [f"{name}{suffix}" for suffix in ("", "-2", "-3", "-4") for name in repeated_names]
    assert list_figure_names(maps_at_two_cutoffs, contact_picture(maps_at_two_cutoffs)) == [
        *names_with_suffix,
        "closure",
        "budget",
        "sizes",
        "contacts",
    ]
    assert {"friction", "positions", "contact", "friction-4"} <= set(list_figure_names(profiles_dataset))
    assert not {"compass", "contacts", "cut_off"} & set(list_figure_names(profiles_dataset))


def test_closure_figure_names_the_kind_of_interval_that_the_json_record_names(maps_at_two_cutoffs):
    record = json.loads(summary_json("at", Result.of(maps_at_two_cutoffs).summary()))
    kinds = {value["kind"] for value in record["values"] if value["name"] in ("closure", "closure_stiffness")}
    assert kinds == {"combined"}
    figure = dict(select_figures(maps_at_two_cutoffs))["closure"]()
    assert figure.get_suptitle().endswith("bands: 95 %, combined intervals")


def test_figures_state_that_combined_intervals_include_errors_of_the_scans(maps_at_two_cutoffs):
    points = Result.of(maps_at_two_cutoffs).at_report_loads.isel(cut_off=0, mu0=0, tau0=0)
    points = points.assign_attrs(alternatives=["tip"])
    combined_text = "95 %, combined intervals with errors of the scans"
    assert closure_figure(points).get_suptitle() == f"bands: {combined_text}"
    assert friction_by_load_figure(points).legends[0].get_title().get_text().splitlines() == [
        f"light bands and area: {combined_text}", "dark bands: 95 %, intervals of the mean"
    ]  # fmt: skip


def test_figures_and_table_and_json_and_report_contain_equal_combined_intervals(maps_at_two_cutoffs):
    study = parse_study_of_dataset(maps_at_two_cutoffs).with_changes({"surfaces.both_readings": True})
    dataset = maps_at_two_cutoffs.assign_attrs(study=study.to_toml())
    summary, figures = Result.of(dataset).summary(), dict(select_figures(dataset))
    table = summary_table(summary)
    record = json.loads(summary_json("at", summary))
    combined_values = [value for value in record["values"] if value["name"] == "friction_combined"]
    assert record["values"][0] == combined_values[0]
    assert {value["kind"] for value in combined_values} == {"combined"}
    title = "coefficient of static friction"
    rows = table[table["upper body to (degree)"] == "all directions"].set_index(
        ["reported", "normal load (mN)", "mu0", "tau0 (MPa)", "sliding"]
    )
    report = ReportEvaluator(report_page(dataset))
    rules, loads = report.facts["rules"], report.facts["loads"]["values"]
    points = summary.reported_points
    assert len(points) == 8
    assert any(point.upper > point.rules[0].interval_of_mean[1] for point in points)
    for point, rule_result in [
        (result_point, rule_result) for result_point in points for rule_result in result_point.rules
    ]:
        interval = pytest.approx([rule_result.lower, rule_result.upper], rel=1e-12)
        conditions = point.at["load"], point.at["mu0"], 1000 * point.at["tau0"], rule_result.rule
        table_row = rows.loc[(True, *conditions)]
        assert [table_row[f"{title}: lower"], table_row[f"{title}: upper"]] == interval
        assert [table_row[f"{title}, interval of the mean: {end}"] for end in ("lower", "upper")] == list(
            rule_result.interval_of_mean
        )
        value = next(
            combined_value
            for combined_value in combined_values
            if combined_value["at"] == point.at | {"sliding": rule_result.rule}
        )
        assert [value["lower"], value["upper"]] == interval
        conditions = {"rule": rules.index(rule_result.rule), "load": loads.index(point.at["load"])}
        report_point = report.evaluate_quantity("friction", point.at["mu0"], point.at["tau0"], **conditions)
        assert report_point["text"] == str(rule_result)
        number = [0.3, 0.5].index(point.at["mu0"]) * 2 + (point.at["tau0"] > 0) + 1
        figure = figures["friction" if number == 1 else f"friction-{number}"]()
        bands = [path.vertices for collection in figure.axes[0].collections for path in collection.get_paths()]
        drawn_intervals = [
            [band[band[:, 0] == point.at["load"], 1].min(), band[:, 1][band[:, 0] == point.at["load"]].max()]
            for band in bands
        ]
        assert any(drawn_interval == interval for drawn_interval in drawn_intervals)


def test_figures_of_a_result_are_written_in_every_format(generated_dataset, tmp_path):
    study = parse_study_of_dataset(generated_dataset).with_changes(
        {"figures.draw": ["profiles"], "surfaces.points": 1000, "surfaces.fractal_dimension": [1.0]}
    )
    dataset = generated_dataset.isel(fractal_dimension=[0]).assign_attrs(study=study.to_toml())
    paths = draw_figures(dataset, tmp_path, formats=FIGURE_FORMATS)
    assert [path.name for path in paths] == ["profiles.png", "profiles.pdf", "profiles.svg"]
    assert imread(paths[0]).std() > 0.03
    assert imread(paths[0]).shape[1] == pytest.approx(80 / 25.4 * 300, abs=2)
    contents = [path.read_bytes() for path in paths]
    assert contents[1].startswith(b"%PDF")
    assert contents[2].startswith(b"<?xml")
    assert draw_figures(dataset, tmp_path, formats=FIGURE_FORMATS) == paths
    assert [path.read_bytes() for path in paths] == contents


def test_drawing_figures_rejects_empty_results_and_preserves_files_of_other_programs(tmp_path):
    from matplotlib.figure import Figure

    for ending in FIGURE_FORMATS:
        foreign_file = tmp_path / f"other.{ending}"
        Figure().savefig(foreign_file)
        content = foreign_file.read_bytes()
        with pytest.raises(ValueError, match="already exists"):
            save_figure(Figure(), foreign_file)
        assert foreign_file.read_bytes() == content
    with pytest.raises(ValueError, match="formats"):
        draw_figures(empty_dataset(SMALL_STUDY), tmp_path, formats=["tiff"])
    with pytest.raises(ValueError, match="nothing to draw"):
        draw_figures(empty_dataset(SMALL_STUDY), Path())


# ---- Generated profiles ---------------------------------------------------------------------------------------------


def list_axes_without_colorbars(figure):
    return [ax for ax in figure.axes if ax.get_label() != "<colorbar>"]


def test_friction_figure_has_friction_maps_and_curves_with_labels(generated_dataset):
    for dataset, num_rows in ((generated_dataset, 2), (generated_dataset.isel(amplitude=[1]), 1)):
        figure = friction_figure(*evaluate_friction_over_dimension(Result.of(dataset), [0.4]))
        axes = list_axes_without_colorbars(figure)
        assert len(axes) == 3 * num_rows
        assert [ax.get_title() for ax in axes[:2]] == [rf"$\tau_0$ = {megapascals} MPa" for megapascals in (0, 200)]
        labels = [text.get_text() for text in figure.legends[0].get_texts()]
        assert "load not reached" in labels
        assert any("model not valid" in label for label in labels)
        assert axes[0].get_ylabel() == style.axis_label("load")
        assert axes[3 * (num_rows // 2) + 2].get_ylabel() == style.axis_label("friction_coefficient")
    assert not figure.get_suptitle()
    partial_result = Result.of(generated_dataset.isel(repetition=[0, 1, 4]))
    figure_of_part = friction_figure(*evaluate_friction_over_dimension(partial_result, [0.1]))
    assert figure_of_part.get_suptitle() == "unfinished: 3 of 12 repetitions"


def test_friction_curves_fill_their_panel_and_are_not_covered_by_labels(generated_dataset):
    for mu0 in (0.1, 0.4, 2.0):
        values = evaluate_friction_over_dimension(Result.of(generated_dataset.isel(amplitude=[1])), [mu0])[0]
        axes = list_axes_without_colorbars(friction_figure(values))[2]
        curves = values.curve_points.isel(amplitude=0)
        mean, upper = (curves["friction_coefficient"].sel(statistic=name).values for name in ("mean", "upper"))
        shown_values = np.array([*upper[np.isfinite(upper)], *mean[np.isfinite(mean)], mu0])
        assert mu0 < axes.get_ylim()[1] <= 1.1 * shown_values.max() * (1 + 1e-9)
        assert all(text.get_bbox_patch() is None for text in axes.texts)
        legend_texts = [text.get_text() for text in axes.get_legend().get_texts()]
        assert legend_texts == [rf"$\tau_0$ = {megapascals} MPa" for megapascals in (0, 200)]


def test_hatching_of_invalid_cells_leaves_most_of_their_colours_visible(generated_dataset):
    dataset = generated_dataset.isel(amplitude=[1])
    figure = friction_figure(*evaluate_friction_over_dimension(Result.of(dataset), [0.4]))
    axes = list_axes_without_colorbars(figure)[0]
    hatched_artists = [artist for artist in axes.artists + axes.patches if isinstance(artist, PathPatch)]
    assert hatched_artists
    canvas = FigureCanvasAgg(figure)

    def render_panel():
        canvas.draw()
        box = axes.get_window_extent()
        rows, columns = (slice(int(start), int(stop)) for start, stop in ((box.y0, box.y1), (box.x0, box.x1)))
        return np.asarray(canvas.buffer_rgba())[::-1][rows, columns].astype(int)

    with_hatching = render_panel()
    for artist in hatched_artists:
        artist.set_visible(False)
    changed_fraction = (np.abs(render_panel() - with_hatching).max(axis=-1) > 10).mean()
    assert 0 < changed_fraction < 0.1  # thin hatching changes few pixels; dense hatching would change 0.18 of them


def test_friction_curves_equal_the_friction_map_at_their_load(generated_dataset):
    dataset = generated_dataset.isel(amplitude=[1])
    curves = list_axes_without_colorbars(friction_figure(*evaluate_friction_over_dimension(Result.of(dataset), [0.4])))[
        2
    ]
    number, unit = curves.get_title().removeprefix("at $F_N$ = ").split()
    load = float(number) * {"mN": 1, "µN": 1e-3, "nN": 1e-6}[unit]
    friction = friction_map(dataset, [load], mu0=[0.4]).isel(amplitude=0, mu0=0, load=0)
    assert ((friction["status"] == "ok").sum("fractal_dimension") >= 3).all()
    dotted_lines = [line.get_ydata() for line in curves.lines if line.get_linestyle() == ":"]
    for plotted_values, tau0 in zip(dotted_lines, (0, -1), strict=True):
        np.testing.assert_array_equal(plotted_values, friction["friction_coefficient"].isel(tau0=tau0).values)


@pytest.mark.parametrize(
    "selection", [{"fractal_dimension": [2]}, {"repetition": [3]}, {"approach": [7, 8, 9]}], ids=str
)
def test_drawing_figures_of_one_fractal_dimension_or_one_pair_or_three_approaches_causes_no_warning(
    generated_dataset, selection, tmp_path
):
    result = Result.of(generated_dataset.isel(amplitude=[0], **selection))
    save_figure(friction_figure(*evaluate_friction_over_dimension(result, [0.0])), tmp_path / "friction.png")
    save_figure(area_figure(evaluate_area_over_load(result), result.study), tmp_path / "area.png")


def test_friction_map_cells_with_wide_intervals_fade_to_grey_of_equal_luminance():
    cells = [(1.0, 0.9, 1.1), (1.0, 0.0, 1.0), (1.0, -3.0, 5.0), (1.0, np.nan, np.nan), (np.nan, np.nan, np.nan)]
    certain_colour, partly_faded, fully_faded, without_interval, without_value = _compute_cell_fading(np.array(cells))
    assert (certain_colour, without_value) == (0, 0)
    assert fully_faded == without_interval == MAX_FADING
    assert partly_faded == pytest.approx(
        MAX_FADING * (1.0 - MIN_FADED_INTERVAL_WIDTH) / (FULLY_FADED_INTERVAL_WIDTH - MIN_FADED_INTERVAL_WIDTH)
    )
    purple, luminance = np.array([0.5, 0.1, 0.6]), np.array([0.2126, 0.7152, 0.0722])
    grey = _fade_colours(purple, np.array(1.0))
    assert grey == pytest.approx([purple @ luminance] * 3)


def test_area_figure_has_a_labelled_curve_for_each_fractal_dimension(generated_dataset):
    figure = area_figure(evaluate_area_over_load(Result.of(generated_dataset)), SMALL_STUDY)
    area_axes = figure.axes[0]
    assert len(area_axes.lines) == 2 * 4  # Each curve has a line within the range of the model and a line beyond it.
    assert any(text.get_text() == "$D$ = 1.00" for text in area_axes.texts)
    assert area_axes.get_ylabel() == style.axis_label("contact_area")
    points = evaluate_area_over_load(Result.of(generated_dataset.isel(repetition=slice(2))))
    for ax in area_figure(points, SMALL_STUDY).axes:
        values = np.concatenate([line.get_ydata() for line in ax.lines])
        assert ax.get_ylim()[1] <= 2.01 * np.nanmax(values)


def test_loads_chosen_for_a_figure_are_reached_at_every_fractal_dimension(generated_dataset):
    loads = choose_loads_in_range(generated_dataset)
    mean_loads = generated_dataset["normal_elastic"].mean("repetition")
    assert loads[0] >= float(mean_loads.isel(approach=0).max()) * (1 - 1e-12)
    assert loads[-1] == pytest.approx(float(mean_loads.max()))
    assert np.all(np.diff(loads) > 0)


# ---- Measured surfaces ----------------------------------------------------------------------------------------------


def draw_figure(dataset, wanted_name, picture=None):
    return next(draw for name, draw in select_figures(dataset, picture) if name == wanted_name)()


@pytest.mark.parametrize(("ratio", "expected_labels"), [(100, {"1", "2", "5", "10"}), (1e5, {"10", "100"})])
def test_log_axis_over_many_decades_has_powers_of_ten(ratio, expected_labels):
    axes = Figure().subplots()
    axes.set(xscale="log", xlim=(1.0, ratio))
    secondary_axis = axes.secondary_xaxis("top", functions=(lambda x: 1000 * x, lambda x: x / 1000))
    format_log_axis(axes.xaxis)
    format_log_axis(secondary_axis.xaxis, axes.get_xlim())
    axes.get_figure().draw_without_rendering()
    for axis, factor in ((axes.xaxis, 1), (secondary_axis.xaxis, 1000)):
        ticks = axis.get_majorticklocs() / factor
        ticks = ticks[(ticks > 0.9) & (ticks < 1.1 * ratio)]
        assert expected_labels <= {f"{tick:g}" for tick in ticks}
        assert ticks.size <= 8
        assert ("$" in axis.get_major_formatter()(axis.get_majorticklocs()[2])) == (ratio > 1000)


def test_load_figure_shows_the_mean_values_of_the_result(maps_at_two_cutoffs):
    figure = draw_figure(maps_at_two_cutoffs, "friction")
    friction_axes, area_axes = figure.axes
    reference = at_load(maps_at_two_cutoffs, maps_at_two_cutoffs["load"].values, mu0=[0.3], tau0=[0.0]).isel(
        cut_off=0, mu0=0, tau0=0
    )
    for line, rule in zip(friction_axes.lines, style.SLIDING_RULE_COLOURS, strict=False):
        expected_values = reference["mean_friction"].sel(sliding=rule, statistic="mean")
        np.testing.assert_allclose(line.get_ydata(), expected_values.values)
        assert line.get_color() == style.SLIDING_RULE_COLOURS[rule]
    np.testing.assert_allclose(
        area_axes.lines[0].get_ydata(), 100 * reference["contact_area_fraction"].sel(statistic="mean").values
    )
    assert (friction_axes.get_ylabel(), area_axes.get_ylabel()) == tuple(
        map(style.axis_label, ("friction_coefficient", "contact_area_fraction"))
    )
    marked_loads = [line.get_xdata()[0] for line in area_axes.lines if line.get_linestyle() == "--"]
    assert marked_loads == [0.1, 0.5]


def test_figure_lines_are_drawn_only_in_grey_and_in_the_colours_of_the_sliding_rules(maps_at_two_cutoffs):
    for name in ("friction", "cut_off", "compass", "positions"):
        used_colours = {line.get_color() for line in draw_figure(maps_at_two_cutoffs, name).axes[0].lines}
        assert (
            {style.ALL_CONTACTS_COLOUR, style.OPPOSING_CONTACT_COLOUR}
            <= used_colours
            <= {style.ALL_CONTACTS_COLOUR, style.OPPOSING_CONTACT_COLOUR, "0.2", "0.5"}
        )


def test_compass_figure_shows_the_mean_in_each_direction_on_an_axis_that_starts_at_zero(maps_at_two_cutoffs):
    axes = draw_figure(maps_at_two_cutoffs, "compass").axes[0]
    reference = at_load(maps_at_two_cutoffs, [0.1], mu0=[0.3], tau0=[0.0]).isel(cut_off=0, load=0, mu0=0, tau0=0)
    points, curve = axes.lines[:2]
    expected = reference["friction_coefficient"].sel(sliding="all", statistic="mean").values
    np.testing.assert_allclose(points.get_ydata(), expected)
    np.testing.assert_allclose(curve.get_ydata()[[0, 90, 180, 270]], expected, rtol=1e-9)
    assert axes.get_ylim()[0] == 0
    assert 4 <= len(axes.get_yticks()) <= 6


def test_positions_figure_sorts_pairs_of_maps_by_value_and_pairs_of_profiles_by_position(
    maps_at_two_cutoffs, profiles_dataset
):
    line_of_maps = draw_figure(maps_at_two_cutoffs, "positions").axes[0].lines[0]
    assert np.array_equal(line_of_maps.get_xdata(), np.arange(1, 17))
    assert (np.diff(line_of_maps.get_ydata()) >= 0).all()
    line_of_profiles = draw_figure(profiles_dataset, "positions").axes[0].lines[0]
    assert set(line_of_profiles.get_xdata()) == set(profiles_dataset["x"].values)


def test_contacts_figure_marks_every_contact_with_load_percentages_that_add_up_to_100(maps_at_two_cutoffs):
    picture = contact_picture(maps_at_two_cutoffs)
    figure = contacts_and_pressure_figure(picture, direction=90.0)
    axes = figure.axes[0]
    marker_positions = np.concatenate([collection.get_offsets() for collection in axes.collections[1::2]])
    assert {tuple(marker_position) for marker_position in marker_positions} == set(
        zip(picture["contact_x"].values, picture["contact_y"].values, strict=True)
    )
    texts = [text.get_text() for text in figure.legends[0].get_texts()]
    assert sum(int(text.split()[0]) for text in texts) == picture.sizes["contact"]
    assert sum(int(text.split("with ")[1].split()[0]) for text in texts) == pytest.approx(100, abs=1)


def test_contacts_figure_of_a_map_longer_than_a_millimetre_is_labelled_in_millimetres(maps_at_two_cutoffs):
    picture = contact_picture(maps_at_two_cutoffs)
    axes_of_short_map = contacts_and_pressure_figure(picture).axes[0]
    assert "(µm)" in axes_of_short_map.get_xlabel()
    factor = 1e5
    names = [name for name in picture.variables if str(name).endswith(("_x", "_y")) and picture[name].ndim == 1]
    long_picture = picture.assign({name: factor * picture[name] for name in names})
    figure = contacts_and_pressure_figure(long_picture)
    figure.canvas.draw()
    axes = figure.axes[0]
    assert "(mm)" in axes.get_xlabel()
    assert "(mm)" in axes.get_ylabel()
    assert any(text.get_text().endswith(" mm") for text in axes.texts)
    longest_tick_in_micrometres = axes.get_xticks()[-1]
    assert float(axes.get_xticklabels()[-1].get_text()) == pytest.approx(longest_tick_in_micrometres / 1000)


def test_contacts_figure_frames_the_contact_with_the_largest_load_even_at_the_edge():
    x = np.linspace(-1, 1, 64)
    heights = 0.14 * np.exp(-((x[:, np.newaxis] + 0.98) ** 2 + (x + 0.98) ** 2) / 0.02)
    heights += 0.09 * np.exp(-(x[:, np.newaxis] ** 2 + x**2) / 0.02)
    lower = Surface(heights, spacing=0.1)
    flat = Surface(np.zeros((64, 64)), spacing=0.1)
    options = {"effective_modulus": "10 GPa", "mu0": 0.2, "level": "mean", "cutoff": "none", "onset": 0}
    result = pair(flat, lower, load="1 mN", positions=[(0, 0)], direction=[0, 180], **options)
    picture = contact_picture(result)
    strongest = int(picture["contact_force"].values.argmax())
    assert picture["contact_at_edge"].values[strongest] == 1
    for axis in ("x", "y"):
        lower_edge, upper_edge = picture[f"zoom_{axis}"].values[[0, -1]]
        assert lower_edge <= picture[f"contact_{axis}"].values[strongest] <= upper_edge
    pressure_axes = contacts_and_pressure_figure(picture).axes[1]
    assert "edge of the pressed area" in pressure_axes.get_title(loc="left")


def test_contact_map_draws_every_contact(maps_at_two_cutoffs, profiles_dataset):
    picture = contact_picture(maps_at_two_cutoffs)
    (axes,) = contact_map_figure(picture, direction=90.0).axes
    contact_kinds = np.ma.filled(axes.images[1].get_array(), np.nan)
    contact_numbers, is_opposing = picture["patch"].values, find_opposing_contacts(picture, 90.0)
    assert np.array_equal(np.isfinite(contact_kinds), contact_numbers > 0)
    assert np.array_equal(np.unique(contact_numbers[contact_kinds == 1]), 1 + np.flatnonzero(is_opposing))
    assert len(axes.collections) == bool((picture["contact_at_edge"].values > 0).any())
    picture = contact_picture(profiles_dataset)
    full_axes, zoomed_axes = contact_map_figure(picture).axes
    assert len(full_axes.collections[2].get_offsets()) == picture.sizes["contact"]
    position_of_largest_force = picture["contact_x"].values[picture["contact_force"].values.argmax()]
    lower_limit, upper_limit = zoomed_axes.get_xlim()
    assert lower_limit <= position_of_largest_force <= upper_limit
    assert upper_limit - lower_limit < np.ptp(full_axes.get_xlim())


def test_pixels_of_maps_are_centred_on_grid_points(maps_at_two_cutoffs):
    picture = contact_picture(maps_at_two_cutoffs)
    (contact_axes,) = contact_map_figure(picture).axes
    full_axes, zoom_axes = contacts_and_pressure_figure(picture).axes[:2]
    surface = Surface(np.arange(12.0).reshape(3, 4), spacing=(0.5, 2.0))
    lower = read_measured_bodies(Result.of(maps_at_two_cutoffs).study).member(0, 0.0).pair[1]
    lower_image = next(image for ax in characterisation_figure(lower).axes for image in ax.images)
    lower_y, lower_x = (step * np.arange(size) for step, size in zip(lower.spacing, lower.heights.shape, strict=True))
    for image, x, y in (
        *((image, picture["height_x"], picture["height_y"]) for image in (*contact_axes.images, *full_axes.images)),
        *((image, picture["zoom_x"], picture["zoom_y"]) for image in zoom_axes.images),
        (surface.plot(Figure().subplots()).images[0], [0.0, 2.0, 4.0, 6.0], [0.0, 0.5, 1.0]),
        (lower_image, lower_x, lower_y),
    ):
        for centres, positions in zip(find_pixel_centres(image), (x, y), strict=True):
            np.testing.assert_allclose(centres, positions, atol=1e-12)


def test_length_scales_figure_shows_whole_pixels_centred_on_grid_points():
    study = SMALL_STUDY.with_changes({"surfaces.points": 64})
    axes = length_scales_figure(generate_bodies_by_length_scale(study)).axes
    images = [(ax, image) for ax in axes for image in ax.images]
    assert len(images) == 3
    for ax, image in images:
        spacing = float(study.surfaces.extent) / 64
        np.testing.assert_allclose(find_pixel_centres(image)[0], spacing * np.arange(64), atol=1e-12)
        assert ax.get_xlim() == tuple(image.get_extent()[:2])


def test_labels_of_the_budget_figure_lie_inside_the_figure_and_start_without_article():
    point = summarize(measured_result(), measured_study()).first
    labels = ("the junction growth α", "the roughness that the tip of the instrument did not reach")
    budget = tuple(
        UncertaintyBudgetEntry(point.value, 0.205, 0.215, label=label, width=width)
        for label, width in zip(labels, (0.001, 0.002), strict=True)
    )
    with mpl.rc_context(style.MATPLOTLIB_STYLE):
        figure = uncertainty_budget_figure(replace(point, budget=budget))
        figure.draw_without_rendering()
    (axes,) = figure.axes
    for label in (axes.xaxis.label, *axes.get_yticklabels(), *figure.legends[0].get_texts()):
        frame = label.get_window_extent()
        assert figure.bbox.x0 <= frame.x0 < frame.x1 <= figure.bbox.x1, label.get_text()
    row_labels = [label.get_text().replace("\n", " ") for label in axes.get_yticklabels()]
    assert row_labels == ["contributions", "combined interval", *(label.removeprefix("the ") for label in labels)]


def test_force_arrows_stay_inside_the_frame_of_the_contact_figure(create_circular_arc, tmp_path):
    upper, lower = (create_circular_arc(2.0, 5.0, 0.01, 401, side) for side in ("upper", "lower"))
    figure = contact_forces_figure(build_contact_forces(upper, lower, 0.02, mu0=0.3).assign_attrs(load_mN=0.1))
    assert figure.axes[0].get_title(loc="left").endswith("at an approach of 20 nm\n$F_N$ = 0.1 mN")
    zoomed_axes = figure.axes[1]
    figure.draw_without_rendering()
    frame = zoomed_axes.get_window_extent()
    for arrows in [collection for collection in zoomed_axes.collections if hasattr(collection, "U")]:
        start_points = zoomed_axes.transData.transform(arrows.get_offsets())
        lengths = np.hypot(arrows.U, arrows.V) / arrows.scale * figure.dpi
        assert (start_points[:, 1] + lengths <= frame.y1).all()
    assert "heights magnified" in zoomed_axes.get_title(loc="left")
    flat_profile = Profile(np.zeros(200), spacing=0.01)
    forces = build_contact_forces(flat_profile, flat_profile, 0.0, mu0=0.3)
    save_figure(contact_forces_figure(forces), tmp_path / "contact.png")


@pytest.mark.parametrize("formats", [("png",), ("pdf", "svg"), FIGURE_FORMATS], ids=str)
def test_figure_files_of_several_formats_share_one_layout(monkeypatch, formats):
    execute, num_layouts = ConstrainedLayoutEngine.execute, 0

    def count_layouts(engine, figure):
        nonlocal num_layouts
        num_layouts += 1
        return execute(engine, figure)

    monkeypatch.setattr(ConstrainedLayoutEngine, "execute", count_layouts)
    figure = style.new_figure(40)
    figure.subplots().set(xlabel="x", ylabel="y")
    for file_format in formats:
        assert style.render_figure(figure, file_format)
    assert num_layouts == 1


def test_size_of_a_new_figure_is_in_millimetres():
    np.testing.assert_allclose(25.4 * style.new_figure(50, width=100).get_size_inches(), [100, 50])


@pytest.mark.parametrize("setting", ["figure.autolayout", "figure.constrained_layout.use"])
def test_layout_settings_of_the_user_do_not_affect_figure_files(setting, maps_at_two_cutoffs):
    def render_map_figure():
        figure = contact_map_figure(contact_picture(maps_at_two_cutoffs), direction=90.0)
        return [style.render_figure(figure, file_format) for file_format in ("svg", "png")]

    expected = render_map_figure()
    with mpl.rc_context({setting: True}):
        assert render_map_figure() == expected


def test_inline_svg_conversion_draws_a_constrained_layout_figure_only_once(monkeypatch):
    draw, num_draws = Figure.draw, 0

    def count_draws(figure, renderer):
        nonlocal num_draws
        num_draws += 1
        draw(figure, renderer)

    figure = Figure(layout="constrained")
    figure.add_subplot(xlabel="x", ylabel="y")
    monkeypatch.setattr(Figure, "draw", count_draws)
    assert "<svg" in inline_svg(figure, "Plot")
    assert num_draws == 1


def test_inline_svg_layout_measures_text_as_the_svg_file_draws_it(monkeypatch):
    figure = Figure(layout="constrained")
    axes = figure.add_subplot(xlabel=r"$\mu_0$", ylabel="y")
    monkeypatch.setattr(RendererAgg, "get_text_width_height_descent", None)
    inline_svg(figure, "Plot")
    left, bottom, *_ = axes.get_position().bounds
    assert 0 < left < 0.2
    assert 0 < bottom < 0.2


# ---- Style -----------------------------------------------------------------------------------------------------------


def test_curve_labels_do_not_overlap_and_have_the_order_of_the_curve_ends():
    label_positions = spread_label_positions([1.0, 1.01, 0.99, 3.0], 0.1)
    assert np.array_equal(np.argsort(label_positions), [2, 0, 1, 3])
    assert np.diff(np.sort(label_positions)).min() == pytest.approx(0.1)
    assert label_positions[3] == 3.0


def test_cutoff_figure_shows_unfiltered_scans_to_the_left_of_the_shortest_cutoff(maps_at_two_cutoffs):
    result = Result.of(maps_at_two_cutoffs)
    points = result.at().isel(load=0, mu0=0, tau0=0)
    assert points["cut_off"].values[0] == 0
    first_cutoff = float(points["cut_off"].values[1])
    limits = find_resolution_limits(points, result.study)
    assert limits.shortest == pytest.approx(2 * max(read_measured_bodies(result.study).member(0, 0.0).pair[0].spacings))
    for ratio in (0.7, 1 - 1e-12, 1.0, 2.0):
        shortest_wavelength = ratio * first_cutoff
        (axes, _) = cut_off_figure(replace(limits, shortest=shortest_wavelength)).axes
        position, *_ = axes.lines[0].get_xdata()
        assert position < first_cutoff / 1.01
        (unresolved,) = (patch for patch in axes.patches if patch.get_label() == "not resolved")
        assert unresolved.get_x() + unresolved.get_width() < position


def test_resolution_limits_of_a_result_with_several_cutoffs_have_combined_intervals(maps_at_two_cutoffs):
    limits = Result.of(maps_at_two_cutoffs).summary().find_resolution_limits()
    assert "friction_combined" in limits.points
    assert limits.points.sizes["cut_off"] == 2


def test_resolved_wavelengths_do_not_depend_on_whether_the_filtered_result_is_quoted(maps_at_two_cutoffs):
    study = parse_study_of_dataset(maps_at_two_cutoffs)
    points = Result.of(maps_at_two_cutoffs).at().isel(load=0, mu0=0, tau0=0)
    filtered_first = study.with_changes({"surfaces.cut_off": [cutoff.text for cutoff in study.surfaces.cut_off[::-1]]})
    shortest_wavelengths = [
        find_resolution_limits(dataset, matching_study).shortest
        for dataset, matching_study in ((points, study), (points.isel(cut_off=[1, 0]), filtered_first))
    ]
    assert shortest_wavelengths[0] == shortest_wavelengths[1] < float(points["cut_off"].max())


def test_listing_the_figures_of_a_result_does_not_compute_resolution_limits(maps_at_two_cutoffs, monkeypatch):
    def fail_on_computation(*_):
        pytest.fail("the limits are computed although the figure is not drawn")

    monkeypatch.setattr(resolution, "find_resolution_limits", fail_on_computation)
    assert "cut_off" in Result.of(maps_at_two_cutoffs).figures()


@pytest.mark.parametrize("name", ["friction", "positions"])
def test_figure_legend_starts_with_the_sliding_rule_of_the_interface(
    dataset_with_interface_for_opposing_contacts, maps_dataset, name
):
    labels = []
    for dataset in (dataset_with_interface_for_opposing_contacts, maps_dataset):
        figure = dict(select_figures(dataset))[name]()
        texts = [text.get_text() for text in figure.legends[0].get_texts()]
        labels.append([text for text in texts if text in SLIDING_RULE_LABELS.values()])
    assert labels[1] == [SLIDING_RULE_LABELS[rule] for rule in ("all", "opposing")]
    assert labels[0] == labels[1][::-1]


def test_report_and_plot_draw_the_same_figure_of_friction_against_cutoff(maps_at_two_cutoffs):
    result = Result.of(maps_at_two_cutoffs)
    panels = {panel.title: panel for panel in list_panels(collect_report_data(result))}
    figures = [panels["Cutoff wavelength"].draw_figure(), dict(select_figures(result))["cut_off"]()]
    drawn_lines = [
        [
            (line.get_label(), line.get_marker(), *line.get_xydata().ravel())
            for axes in figure.axes
            for line in axes.lines
        ]
        for figure in figures
    ]
    assert drawn_lines[0] == drawn_lines[1]
    legends = [[text.get_text() for text in figure.legends[0].get_texts()] for figure in figures]
    assert legends[0] == legends[1]
    assert all("combined" in figure.legends[0].get_title().get_text() for figure in figures)


@pytest.mark.parametrize(
    "name", [r"$\write18{id}$", "$a__b$", "_a", "a_b^2", r"\$x$", "$", "a\nb", "\u202eb", "$\\frac$ $"]
)
def test_file_names_are_drawn_in_figures_as_literal_text(name):
    figure = Figure()
    axes = figure.add_subplot()
    axes.set_title(f"{literal_text(name)}, $\\mu_0$ = 0.2")
    axes.plot([0, 1], label=literal_text(name))
    (label,) = axes.legend().get_texts()
    figure.canvas.draw()
    assert label.get_text().replace(r"\$", "$").strip() == printable_text(name)
