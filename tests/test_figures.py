import numpy as np
import pytest
from matplotlib.image import imread
from stiction import Study, run
from stiction.studies.dataset import empty_dataset
from stiction.views.figures import area_figure, friction_figure, reached_loads, save_figures

SMALL = Study.named("quick").with_changes(
    {
        "surfaces.fractal_dimension.count": 3,
        "surfaces.amplitude": ["50 nm", "100 nm"],
        "surfaces.points": 20_000,
        "surfaces.extent": "5 um",
        "contact.approach.count": 8,
        "ensemble.repetitions": 6,
    }
)


@pytest.fixture(scope="module")
def result():
    return run(SMALL)


def test_figures_are_files_with_something_in_them(result, tmp_path):
    paths = save_figures(result, tmp_path)
    assert [p.name for p in paths] == ["friction_amplitude_50nm.png", "friction_amplitude_100nm.png", "area.png"]
    for path in paths:
        assert imread(path).std() > 0.05


def test_friction_has_a_panel_for_each_pair_of_parameters_and_a_legend_for_what_is_missing(result):
    figure = friction_figure(result, 0.1)
    panels = [axes for axes in figure.axes if axes.get_label() != "<colorbar>"]
    assert len(panels) == 15
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert labels[0] == "load not reached"
    assert any(axes.get_ylabel() == "$F_N$ (mN)" for axes in panels)
    bars = [axes.get_ylabel() for axes in figure.axes if axes.get_label() == "<colorbar>"]
    assert bars == [rf"$\mu_s$ at $\mu_0$ = {mu0:g}" for mu0 in (0.1, 0.4, 1.0)]


def test_area_has_units_and_a_curve_for_each_dimension(result):
    figure = area_figure(result)
    left = figure.axes[0]
    assert len(left.lines) == 2 * 3  # as far as it is to be trusted, and beyond
    assert "µm²" in left.get_ylabel()
    assert "mN" in figure.axes[-1].get_xlabel()


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
        assert figure.get_suptitle() == "unfinished: 3 of 6 repetitions"
    assert not area_figure(result).get_suptitle()
