"""The table and the figure of one profile: what they say is what the functions return, with units."""

import numpy as np
import pytest
from matplotlib.image import imread
from matplotlib.text import Text
from stiction import Profile, hurst_exponent_of, roughness_parameters, self_affine
from stiction.views.characterisation import characterisation_figure, characterisation_text

NO_BAND = Profile(np.sin(np.arange(700) / 20), spacing=5.0)


@pytest.fixture(scope="module")
def profile():
    return self_affine(1, hurst_exponent=0.7, rms=0.05, points=6000, spacing=0.01, longest_wavelength=6.0)


def rows(text):
    return {line[:19].strip() or "paper": line[20:] for line in text.splitlines()}


class TestText:
    def test_says_what_the_functions_return(self, profile):
        said, found = rows(characterisation_text(profile)), hurst_exponent_of(profile)
        parameters = roughness_parameters(profile)
        assert said["Pa"] == f"{1000 * parameters.Pa:.4g} nm"
        assert said["Pt"] == f"{1000 * parameters.Pt:.4g} nm"
        assert said["Pdq"].startswith(f"{parameters.Pdq:.4g} (seven points)")
        assert said["Hurst exponent H"] == f"{found.value:.3f} [{found.lower:.3f}, {found.upper:.3f}] (95 %)"
        assert said["fractal dimension D"] == f"{2 - found.value:.3f} (classical, 2 - H)"
        assert said["paper"] == f"{(4 - found.value) / 2:.3f} (paper, (4 - H)/2)"
        assert said["fitted band"].endswith(f"(found; {found.harmonics} harmonics)")
        assert said["m0"].endswith(" µm²")
        assert said["m4"].endswith(" 1/µm²")
        assert "Hann" in said["spectrum"]

    def test_says_whether_the_band_was_given_and_the_profile_periodic(self, profile):
        said = rows(characterisation_text(profile, band=(0.1, 2.0), periodic=True))
        assert "given" in said["fitted band"]
        assert "periodic" in said["spectrum"]

    def test_says_where_there_is_no_band_and_refuses_a_given_one_that_is_empty(self, profile):
        assert "none" in rows(characterisation_text(NO_BAND))["Hurst exponent H"]
        with pytest.raises(ValueError, match="band"):
            characterisation_text(profile, band=(1.0, 1.001))

    @pytest.mark.parametrize(
        ("factor", "said"), [(1e-4, "5.2 pm"), (1e-3, "52 pm"), (1.0, "52 nm"), (1e3, "52 µm"), (1e5, "5.2 mm")]
    )
    def test_lengths_have_a_unit_that_suits_them(self, profile, factor, said):
        heights = profile.with_amplitude(0.052 * factor, "Rq").heights
        assert rows(characterisation_text(Profile(heights, spacing=0.01)))["Pq"] == said

    def test_flat_and_short_profiles_are_refused(self):
        for heights, match in (([1.0] * 20, "flat"), ([0.0, 1.0, 0.0, 1.0], "7 points")):
            with pytest.raises(ValueError, match=match):
                characterisation_text(Profile(heights, spacing=1.0))


class TestFigure:
    @pytest.mark.parametrize("periodic", [True, False])
    def test_is_one_column_wide_with_units_and_the_fit(self, profile, periodic, tmp_path):
        figure = characterisation_figure(profile, periodic=periodic)
        labels = [ax.get_xlabel() for ax in figure.axes] + [ax.get_ylabel() for ax in figure.axes]
        assert {"$x$ (µm)", "height (nm)", "density (1/nm)", "$C^{1D}$ (µm³)"} <= set(labels)
        legend = " ".join(text.get_text() for ax in figure.axes if ax.get_legend() for text in ax.get_legend().texts)
        found = hurst_exponent_of(profile, periodic=periodic)
        assert f"$H$ = {found.value:.2f}" in legend
        assert "(classical)" in legend
        assert "(paper)" in legend
        figure.savefig(tmp_path / "figure.png", dpi=300)
        assert imread(tmp_path / "figure.png").shape[1] == pytest.approx(80 / 25.4 * 300, abs=2)
        assert min(text.get_fontsize() for text in figure.findobj(Text) if text.get_text()) >= 6

    def test_fitted_line_is_the_spectrums(self, profile):
        figure = characterisation_figure(profile)
        found = hurst_exponent_of(profile)
        dashed = [line for ax in figure.axes for line in ax.lines if line.get_linestyle() == "--"]
        q, density = dashed[0].get_data()
        assert np.allclose(density, found.density(q))
        assert q == pytest.approx(2 * np.pi / np.array([found.longest_wavelength, found.shortest_wavelength]))

    def test_without_a_band_it_says_so(self):
        legend = [text.get_text() for ax in characterisation_figure(NO_BAND).axes if ax.get_legend()
                  for text in ax.get_legend().texts]  # fmt: skip
        assert "no self-affine band found" in legend
