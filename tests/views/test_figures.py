from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.image import imread
from small import SMALL
from stiction.studies.dataset import empty_dataset
from stiction.studies.maps import friction_map
from stiction.studies.study import study_of
from stiction.views.figures import FADE, _fading, area_figure, friction_figure, reached_loads, save_figures
from stiction.views.style import force_text, save_picture, spread_out


@pytest.fixture(scope="module")
def result(small_result):
    return small_result


def test_figures_are_files_with_something_in_them(result, tmp_path):
    paths = save_figures(result.isel(amplitude=[0]), tmp_path)
    assert [p.name for p in paths] == [
        "friction_mu0_0.1.png",
        "friction_mu0_0.4.png",
        "friction_mu0_1.png",
        "area.png",
    ]
    for path in paths:
        assert imread(path).std() > 0.05


def test_surfaces_are_drawn_where_a_study_asks_for_them(result, tmp_path):
    wanted = study_of(result).with_changes({"figures.draw": ["profiles", "length-scales"]})
    paths = save_figures(result.assign_attrs(study=wanted.to_toml()), tmp_path)
    assert [p.name for p in paths] == ["profiles.png", "length_scales.png"]
    for path in paths:
        assert imread(path).std() > 0.05
        assert imread(path).shape[1] == pytest.approx(80 / 25.4 * 300, abs=2)


def test_friction_has_maps_of_three_strengths_and_curves_for_each_amplitude_and_says_what_is_missing(result):
    for data, rows in ((result, 2), (result.isel(amplitude=[1]), 1)):
        figure = friction_figure(data, 0.4)
        drawn = [ax for ax in figure.axes if ax.get_label() != "<colorbar>"]
        assert len(drawn) == 4 * rows
        assert [ax.get_title() for ax in drawn[:3]] == [rf"$\tau_0$ = {mpa} MPa" for mpa in (0, 100, 200)]
        labels = [text.get_text() for text in figure.legends[0].get_texts()]
        assert "load not reached" in labels
        assert drawn[0].get_ylabel() == "normal load $F_N$ (mN)"
        middle = drawn[4 * (rows // 2) + 3]
        assert middle.get_ylabel() == r"coefficient of static friction $\mu_s$"
        assert any("fractal dimension" in ax.get_xlabel() for ax in drawn)
        bars = [ax.get_xlabel() for ax in figure.axes if ax.get_label() == "<colorbar>"]
        assert bars == [r"coefficient of static friction $\mu_s$, at $\mu_0$ = 0.4"]


def test_friction_curves_are_those_of_the_map_at_a_load_that_most_dimensions_reach(result):
    one = result.isel(amplitude=[1])
    figure = friction_figure(one, 0.4)
    curves = [ax for ax in figure.axes if ax.get_label() != "<colorbar>"][3]
    amount, unit = curves.get_title().removeprefix("at $F_N$ = ").split()
    load = float(amount) * {"mN": 1, "µN": 1e-3, "nN": 1e-6}[unit]
    expected = friction_map(one, [load], mu0=[0.4]).isel(amplitude=0, mu0=0, load=0)
    assert ((expected["status"] == "ok").sum("fractal_dimension") >= 3).all()  # of 4
    dotted = [line.get_ydata() for line in curves.lines if line.get_linestyle() == ":"]
    for values, tau0 in zip(dotted, (0, -1), strict=True):
        np.testing.assert_array_equal(values, expected["friction_coefficient"].isel(tau0=tau0).values)


@pytest.mark.parametrize("part", [{"fractal_dimension": [2]}, {"repetition": [3]}, {"approach": [7, 8, 9]}], ids=str)
def test_figures_of_little_are_drawn_without_a_warning(result, part, tmp_path):
    one = result.isel(amplitude=[0], **part)
    for mu0 in (0.0, 0.4):
        save_picture(friction_figure(one, mu0), tmp_path / "friction.png")
    save_picture(area_figure(one), tmp_path / "area.png")


def test_cells_fade_with_the_width_of_their_interval():
    cells = [(1.0, 0.9, 1.1), (1.0, 0.0, 1.0), (1.0, -3.0, 5.0), (1.0, np.nan, np.nan), (np.nan, np.nan, np.nan)]
    names = ("friction_coefficient", "lower", "upper")
    maps = {
        name: SimpleNamespace(values=np.array(each)) for name, each in zip(names, zip(*cells, strict=True), strict=True)
    }
    sure, half, wide, unknown, nothing = _fading(maps)
    assert (sure, nothing) == (0, 0)
    assert wide == unknown == FADE[2]
    assert half == pytest.approx(FADE[2] * (1.0 - FADE[0]) / (FADE[1] - FADE[0]))


def test_labels_are_apart_and_in_their_order():
    places = spread_out([1.0, 1.01, 0.99, 3.0], 0.1)
    assert np.array_equal(np.argsort(places), [2, 0, 1, 3])
    assert np.diff(np.sort(places)).min() == pytest.approx(0.1)
    assert places[3] == 3.0


def test_a_force_has_the_unit_of_its_size():
    assert [force_text(force) for force in (1e-6, 1e-4, 0.05, 2.0)] == ["1 nN", "0.1 µN", "0.05 mN", "2 mN"]


def test_area_has_units_and_a_named_curve_for_each_dimension(result):
    figure = area_figure(result)
    left = figure.axes[0]
    assert len(left.lines) == 2 * 4  # as far as it is to be trusted, and beyond
    assert left.texts[0].get_text() == "$D$ = 1.00"
    assert "µm²" in left.get_ylabel()
    assert any("mN" in ax.get_xlabel() for ax in figure.axes)


def test_no_band_takes_the_axis_of_areas(result):
    for ax in area_figure(result.isel(repetition=slice(2))).axes:
        values = np.concatenate([line.get_ydata() for line in ax.lines])
        assert ax.get_ylim()[1] <= 2.01 * np.nanmax(values)


def test_loads_are_those_that_every_ensemble_starts_below_and_some_reach(result):
    loads = reached_loads(result)
    mean = result["normal_elastic"].mean("repetition")
    assert loads[0] >= float(mean.isel(approach=0).max()) * (1 - 1e-12)
    assert loads[-1] == pytest.approx(float(mean.max()))
    assert np.all(np.diff(loads) > 0)


def test_nothing_to_draw_is_said_so():
    with pytest.raises(ValueError, match="nothing to draw"):
        save_figures(empty_dataset(SMALL), ".")


def test_figures_of_an_unfinished_study_say_so(result):
    part = result.isel(repetition=[0, 1, 4])
    for figure in (friction_figure(part, 0.1), area_figure(part)):
        assert figure.get_suptitle() == "unfinished: 3 of 12 repetitions"
    assert not area_figure(result).get_suptitle()
