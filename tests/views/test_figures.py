import numpy as np
import pytest
from matplotlib.image import imread
from small import SMALL
from stiction.studies.dataset import empty_dataset
from stiction.studies.study import study_of
from stiction.views.figures import area_figure, friction_figure, reached_loads, save_figures


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


def test_friction_has_a_panel_for_each_strength_and_amplitude_and_a_legend_for_what_is_missing(result):
    for data, panels in ((result, 10), (result.isel(amplitude=[1]), 5)):
        figure = friction_figure(data, 0.4)
        drawn = [ax for ax in figure.axes if ax.get_label() != "<colorbar>" and ax.axison]
        assert len(drawn) == panels
        labels = [text.get_text() for text in figure.legends[0].get_texts()]
        assert labels[0] == "load not reached"
        assert drawn[0].get_ylabel() == "$F_N$ (mN)"
        assert any("fractal dimension" in ax.get_xlabel() for ax in drawn)
        bars = [ax.get_xlabel() for ax in figure.axes if ax.get_label() == "<colorbar>"]
        assert bars == [r"$\mu_s$ at $\mu_0$ = 0.4"]


def test_area_has_units_and_a_curve_for_each_dimension(result):
    figure = area_figure(result)
    left = figure.axes[0]
    assert len(left.lines) == 2 * 4  # as far as it is to be trusted, and beyond
    assert "µm²" in left.get_ylabel()
    assert any("mN" in ax.get_xlabel() for ax in figure.axes)


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
