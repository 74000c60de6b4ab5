import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.image import imread
from stiction import Profile, Result
from stiction._number_format import quoted
from stiction.studies.contact_picture import contact_picture
from stiction.studies.evaluation import at_load, reached_loads
from stiction.studies.maps import friction_map
from stiction.studies.study import study_of
from stiction.views import style
from stiction.views.figures import draw_figures
from stiction.views.figures.contact import contact_figure, contact_map_figure, contacts_figure, find_opposing_contacts
from stiction.views.figures.ensemble import FADING, _compute_fading, _fade, area_figure, friction_figure
from stiction.views.figures.standard import figures_of
from stiction.views.report import report_page
from stiction.views.rows import summary_json, summary_table
from stiction.views.style import FORMATS, save_figure, spread_labels
from support.generated_studies import SMALL_STUDY, empty_dataset
from support.report_numbers import ReportNumbers
from support.studies_of_files import run_maps


@pytest.fixture(scope="module")
def maps(tmp_path_factory):
    return run_maps(tmp_path_factory.mktemp("maps"), cut_off='["0 um", "1 um"]')


# ---- Which figures ---------------------------------------------------------------------------------------------------


def names(result, picture=None):
    return [name for name, _ in figures_of(result, picture)]


def test_figures_are_those_of_the_study(result):
    assert names(result) == ["friction_mu0_0.1", "friction_mu0_0.4", "friction_mu0_1", "area"]
    expected = study_of(result).with_changes({"figures.draw": ["profiles", "length-scales"]})
    assert names(result.assign_attrs(study=expected.to_toml())) == ["profiles", "length_scales"]


def test_measured_surfaces_have_the_standard_figures(maps, lines):
    of_each = ("friction", "compass", "positions", "cut_off")
    of_materials = [f"{name}{of}" for of in ("", "-2", "-3", "-4") for name in of_each]
    assert names(maps, contact_picture(maps)) == [*of_materials, "closure", "budget", "sizes", "contacts"]
    assert {"friction", "positions", "contact", "friction-4"} <= set(names(lines))
    assert not {"compass", "contacts", "cut_off"} & set(names(lines))


def test_figures_have_the_combined_interval_of_the_headline(maps):
    study = study_of(maps).with_changes({"surfaces.both_readings": True})
    result = maps.assign_attrs(study=study.to_toml())
    summary, figures = Result.of(result).summary(), dict(figures_of(result))
    table = summary_table(summary)
    record = json.loads(summary_json("at", summary))
    shown = [value for value in record["values"] if value["name"] == "friction_combined"]
    assert record["values"][0] == shown[0]
    assert {value["interval"] for value in shown} == {"combined"}
    title = "coefficient of static friction"
    rows = table[table["upper body to (degree)"] == "all directions"].set_index(
        ["headline", "normal load (mN)", "mu0", "tau0 (MPa)", "sliding"]
    )
    report = ReportNumbers(report_page(result))
    rules, loads = report.facts["rules"], report.facts["loads"]["values"]
    computed = summary.headlines
    assert len(computed) == 8
    assert any(one.upper > one.rules[0].positions[1] for one in computed)
    for one, rule in [(item, rule) for item in computed for rule in item.rules]:
        ends = pytest.approx([rule.lower, rule.upper], rel=1e-12)
        place = one.at["load"], one.at["mu0"], 1000 * one.at["tau0"], rule.rule
        row = rows.loc[(True, *place)]
        assert [row[f"{title}: lower"], row[f"{title}: upper"]] == ends
        assert [row[f"{title}: sampling lower"], row[f"{title}: sampling upper"]] == list(rule.positions)
        value = next(item for item in shown if item["at"] == one.at | {"sliding": rule.rule})
        assert [value["lower"], value["upper"]] == ends
        place = {"rule": rules.index(rule.rule), "load": loads.index(one.at["load"])}
        point = report.point("friction", one.at["mu0"], one.at["tau0"], **place)
        assert point["text"] == quoted(rule.value, rule.lower, rule.upper)
        number = [0.3, 0.5].index(one.at["mu0"]) * 2 + (one.at["tau0"] > 0) + 1
        figure = figures["friction" if number == 1 else f"friction-{number}"]()
        bands = [path.vertices for collection in figure.axes[0].collections for path in collection.get_paths()]
        drawn_ends = [[band[band[:, 0] == one.at["load"], 1].min(), band[:, 1][band[:, 0] == one.at["load"]].max()]
                      for band in bands]  # fmt: skip
        assert any(end == ends for end in drawn_ends)


def test_figures_are_written_in_every_format(result, tmp_path):
    expected = study_of(result).with_changes({"figures.draw": ["profiles"], "surfaces.points": 2000})
    one = result.assign_attrs(study=expected.to_toml())
    paths = draw_figures(one, tmp_path, formats=FORMATS)
    assert [path.name for path in paths] == ["profiles.png", "profiles.pdf", "profiles.svg"]
    assert imread(paths[0]).std() > 0.03
    assert imread(paths[0]).shape[1] == pytest.approx(80 / 25.4 * 300, abs=2)
    before = [path.read_bytes() for path in paths]
    assert before[1].startswith(b"%PDF")
    assert before[2].startswith(b"<?xml")
    assert draw_figures(one, tmp_path, formats=FORMATS) == paths
    assert [path.read_bytes() for path in paths] == before  # equal figures are equal files


def test_foreign_files_are_not_replaced_and_empty_results_are_rejected(tmp_path):
    from matplotlib.figure import Figure

    for ending in FORMATS:
        other = tmp_path / f"other.{ending}"
        Figure().savefig(other)
        content = other.read_bytes()
        with pytest.raises(ValueError, match="exists already"):
            save_figure(Figure(), other)
        assert other.read_bytes() == content
    with pytest.raises(ValueError, match="formats"):
        draw_figures(empty_dataset(SMALL_STUDY), tmp_path, formats=["tiff"])
    with pytest.raises(ValueError, match="nothing to draw"):
        draw_figures(empty_dataset(SMALL_STUDY), Path())


# ---- Generated bodies ------------------------------------------------------------------------------------------------


def panels(figure):
    return [ax for ax in figure.axes if ax.get_label() != "<colorbar>"]


def test_friction_figure_has_maps_and_curves(result):
    for data, rows in ((result, 2), (result.isel(amplitude=[1]), 1)):
        figure = friction_figure(data, 0.4)
        computed = panels(figure)
        assert len(computed) == 3 * rows
        assert [ax.get_title() for ax in computed[:2]] == [rf"$\tau_0$ = {mpa} MPa" for mpa in (0, 200)]
        labels = [text.get_text() for text in figure.legends[0].get_texts()]
        assert "load not reached" in labels
        assert any("model not valid" in label for label in labels)
        assert computed[0].get_ylabel() == style.label("load")
        assert computed[3 * (rows // 2) + 2].get_ylabel() == style.label("friction_coefficient")
    assert not figure.get_suptitle()
    part = friction_figure(result.isel(repetition=[0, 1, 4]), 0.1)
    assert part.get_suptitle() == "unfinished: 3 of 12 repetitions"


def test_friction_curves_equal_the_map_at_a_common_load(result):
    one = result.isel(amplitude=[1])
    curves = panels(friction_figure(one, 0.4))[2]
    amount, unit = curves.get_title().removeprefix("at $F_N$ = ").split()
    load = float(amount) * {"mN": 1, "µN": 1e-3, "nN": 1e-6}[unit]
    expected = friction_map(one, [load], mu0=[0.4]).isel(amplitude=0, mu0=0, load=0)
    assert ((expected["status"] == "ok").sum("fractal_dimension") >= 3).all()  # of 4
    dotted = [line.get_ydata() for line in curves.lines if line.get_linestyle() == ":"]
    for values, tau0 in zip(dotted, (0, -1), strict=True):
        np.testing.assert_array_equal(values, expected["friction_coefficient"].isel(tau0=tau0).values)


@pytest.mark.parametrize("part", [{"fractal_dimension": [2]}, {"repetition": [3]}, {"approach": [7, 8, 9]}], ids=str)
def test_figures_of_small_results_are_drawn_without_warning(result, part, tmp_path):
    one = result.isel(amplitude=[0], **part)
    save_figure(friction_figure(one, 0.0), tmp_path / "friction.png")
    save_figure(area_figure(one), tmp_path / "area.png")


def test_cells_fade_to_equally_bright_grey_with_interval_width():
    cells = [(1.0, 0.9, 1.1), (1.0, 0.0, 1.0), (1.0, -3.0, 5.0), (1.0, np.nan, np.nan), (np.nan, np.nan, np.nan)]
    columns = zip(("friction_coefficient", "lower", "upper"), zip(*cells, strict=True), strict=True)
    sure, half, wide, unknown, nothing = _compute_fading(
        {name: SimpleNamespace(values=np.array(item)) for name, item in columns}
    )
    assert (sure, nothing) == (0, 0)
    assert wide == unknown == FADING[2]
    assert half == pytest.approx(FADING[2] * (1.0 - FADING[0]) / (FADING[1] - FADING[0]))
    purple, luminance = np.array([0.5, 0.1, 0.6]), np.array([0.2126, 0.7152, 0.0722])
    grey = _fade(purple, np.array(1.0))
    assert grey == pytest.approx([purple @ luminance] * 3)


def test_area_figure_has_a_labelled_curve_for_each_dimension(result):
    figure = area_figure(result)
    left = figure.axes[0]
    assert len(left.lines) == 2 * 4  # as far as it is to be trusted, and beyond
    assert any(text.get_text() == "$D$ = 1.00" for text in left.texts)
    assert left.get_ylabel() == style.label("contact_area")
    for ax in area_figure(result.isel(repetition=slice(2))).axes:
        values = np.concatenate([line.get_ydata() for line in ax.lines])
        assert ax.get_ylim()[1] <= 2.01 * np.nanmax(values)


def test_loads_are_within_the_range_of_the_ensembles(result):
    loads = reached_loads(result)
    mean = result["normal_elastic"].mean("repetition")
    assert loads[0] >= float(mean.isel(approach=0).max()) * (1 - 1e-12)
    assert loads[-1] == pytest.approx(float(mean.max()))
    assert np.all(np.diff(loads) > 0)


# ---- Measured bodies -------------------------------------------------------------------------------------------------


def figure_of(result, wanted, picture=None):
    return next(draw for name, draw in figures_of(result, picture) if name == wanted)()


def test_curves_over_load_equal_means_of_the_result(maps):
    figure = figure_of(maps, "friction")
    upper, lower = figure.axes
    reference = at_load(maps, maps["load"].values, mu0=[0.3], tau0=[0.0]).isel(cut_off=0, mu0=0, tau0=0)
    for line, rule in zip(upper.lines, style.RULE_COLOURS, strict=False):
        expected = reference["friction_all_round"].sel(sliding=rule, statistic="mean")
        np.testing.assert_allclose(line.get_ydata(), expected.values)
        assert line.get_color() == style.RULE_COLOURS[rule]
    np.testing.assert_allclose(
        lower.lines[0].get_ydata(), 100 * reference["contact_area_fraction"].sel(statistic="mean").values
    )
    assert (upper.get_ylabel(), lower.get_ylabel()) == tuple(
        map(style.label, ("friction_coefficient", "contact_area_fraction"))
    )
    marked = [line.get_xdata()[0] for line in lower.lines if line.get_linestyle() == "--"]
    assert marked == [0.1, 0.5]  # what was asked for


def test_colours_have_one_meaning(maps):
    for name in ("friction", "cut_off", "compass", "positions"):
        used = {line.get_color() for line in figure_of(maps, name).axes[0].lines}
        assert {style.ALL, style.OPPOSING} <= used <= {style.ALL, style.OPPOSING, "0.2", "0.5"}


def test_compass_passes_through_its_points_and_starts_at_zero(maps):
    axes = figure_of(maps, "compass").axes[0]
    reference = at_load(maps, [0.1], mu0=[0.3], tau0=[0.0]).isel(cut_off=0, load=0, mu0=0, tau0=0)
    points, curve = axes.lines[:2]
    expected = reference["friction_coefficient"].sel(sliding="all", statistic="mean").values
    np.testing.assert_allclose(points.get_ydata(), expected)
    np.testing.assert_allclose(curve.get_ydata()[[0, 90, 180, 270]], expected, rtol=1e-9)
    assert axes.get_ylim()[0] == 0
    assert 4 <= len(axes.get_yticks()) <= 6


def test_positions_are_drawn_at_their_offset(maps, lines):
    each = figure_of(maps, "positions").axes[0].lines[0]
    assert np.array_equal(each.get_xdata(), np.arange(1, 17))  # four members in four directions
    assert (np.diff(each.get_ydata()) >= 0).all()
    along = figure_of(lines, "positions").axes[0].lines[0]
    assert set(along.get_xdata()) == set(lines["x"].values)


def test_contacts_are_drawn_at_their_position_and_loads_add_up(maps):
    picture = contact_picture(maps)
    figure = contacts_figure(picture, direction=90.0)
    axes = figure.axes[0]
    marks = np.concatenate([collection.get_offsets() for collection in axes.collections[1::2]])
    assert {tuple(mark) for mark in marks} == set(
        zip(picture["contact_x"].values, picture["contact_y"].values, strict=True)
    )
    texts = [text.get_text() for text in figure.legends[0].get_texts()]
    assert sum(int(text.split()[0]) for text in texts) == picture.sizes["contact"]
    assert sum(int(text.split("with ")[1].split()[0]) for text in texts) == pytest.approx(100, abs=1)


def test_surfaces_touch_at_drawn_contacts(maps, lines):
    picture = contact_picture(maps)
    (axes,) = contact_map_figure(picture, direction=90.0).axes
    kind = np.ma.filled(axes.images[1].get_array(), np.nan)
    patch, climbs = picture["patch"].values, find_opposing_contacts(picture, 90.0)
    assert np.array_equal(np.isfinite(kind), patch > 0)
    assert np.array_equal(np.unique(patch[kind == 1]), 1 + np.flatnonzero(climbs))
    assert len(axes.collections) == bool((picture["contact_at_edge"].values > 0).any())
    picture = contact_picture(lines)
    whole, close = contact_map_figure(picture).axes
    assert len(whole.collections[2].get_offsets()) == picture.sizes["contact"]
    strongest = picture["contact_x"].values[picture["contact_force"].values.argmax()]
    low, high = close.get_xlim()
    assert low <= strongest <= high
    assert high - low < np.ptp(whole.get_xlim())


def test_force_arrows_stay_inside_their_frame(circular_arc, tmp_path):
    upper, lower = (circular_arc(2.0, 5.0, 0.01, 401, side) for side in ("upper", "lower"))
    figure = contact_figure(upper, lower, 0.02, mu0=0.3, load=0.1)
    large = figure.axes[1]
    figure.draw_without_rendering()
    frame = large.get_window_extent()
    for arrows in [collection for collection in large.collections if hasattr(collection, "U")]:
        start = large.transData.transform(arrows.get_offsets())
        length = np.hypot(arrows.U, arrows.V) / arrows.scale * figure.dpi
        assert (start[:, 1] + length <= frame.y1).all()
    assert "heights magnified" in large.get_title(loc="left")
    # And two flat bodies without a contact are drawn.
    flat = Profile(np.zeros(200), spacing=0.01)
    save_figure(contact_figure(flat, flat, 0.0, mu0=0.3), tmp_path / "contact.png")


# ---- Style -----------------------------------------------------------------------------------------------------------


def test_labels_are_separate_and_ordered():
    places = spread_labels([1.0, 1.01, 0.99, 3.0], 0.1)
    assert np.array_equal(np.argsort(places), [2, 0, 1, 3])
    assert np.diff(np.sort(places)).min() == pytest.approx(0.1)
    assert places[3] == 3.0
