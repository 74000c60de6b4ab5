"""The table and the figure of one profile: what they say is what the functions return, with units."""

import re

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.image import imread
from matplotlib.text import Text
from stiction import (
    Profile,
    Surface,
    cut_off,
    effective_modulus,
    estimate_hurst_exponent,
    filtered,
    gentle_friction,
    joined_spectrum,
    levelled,
    material,
    power_spectrum,
    roughness_parameters,
    section_parameters,
    self_affine,
    self_affine_surface,
    spectral_moments,
    spectral_resolution,
    surface_parameters,
    surface_spectrum,
)
from stiction.surfaces.spectrum import find_peak
from stiction.views.characterisation import NEGLIGIBLE_SLOPE_FRACTION, Characterisation, characterisation_text
from stiction.views.figures.roughness import characterisation_figure
from stiction.views.scans import joined_figure

NO_BAND = Profile(np.sin(np.arange(700) / 20), spacing=5.0)


@pytest.fixture(scope="module")
def profile():
    return self_affine(1, hurst_exponent=0.7, rms=0.05, points=6000, spacing=0.01, longest_wavelength=6.0)


def rows(text):
    return {line[:19].strip() or "paper": line[20:] for line in text.splitlines()}


class TestText:
    def test_text_equals_results_of_the_functions(self, profile):
        message, found = rows(characterisation_text(profile)), estimate_hurst_exponent(profile)
        parameters = roughness_parameters(profile)
        assert message["Pa"] == f"{1000 * parameters.Pa:.4g} nm"
        assert message["Pt"] == f"{1000 * parameters.Pt:.4g} nm"
        assert message["Pdq"].startswith(f"{parameters.Pdq:.4g} (seven points)")
        assert message["Hurst exponent H"] == f"{found.value:.3f} [{found.lower:.3f}, {found.upper:.3f}] (95 %)"
        assert message["fractal dimension D"] == f"{2 - found.value:.3f} (classical, 2 - H)"
        assert message["paper"] == f"{(4 - found.value) / 2:.3f} (paper, (4 - H)/2)"
        assert message["fitted band"].endswith(f"(automatic; {found.harmonics} harmonics)")
        assert message["m0"].endswith(" µm²")
        assert message["m4"].endswith(" 1/µm²")
        assert "Hann" in message["spectrum"]

    def test_text_reports_given_band_and_periodicity(self, profile):
        message = rows(characterisation_text(profile, band=(0.1, 2.0), periodic=True))
        assert "given" in message["fitted band"]
        assert "periodic" in message["spectrum"]

    def test_text_reports_missing_band_and_bad_profiles_are_rejected(self, profile):
        assert "none" in rows(characterisation_text(NO_BAND))["Hurst exponent H"]
        with pytest.raises(ValueError, match="band"):
            characterisation_text(profile, band=(1.0, 1.001))
        for heights, match in (([1.0] * 20, "flat"), ([0.0, 1.0, 0.0, 1.0], "7 points")):
            with pytest.raises(ValueError, match=match):
                characterisation_text(Profile(heights, spacing=1.0))

    @pytest.mark.parametrize(
        ("factor", "message"), [(1e-4, "5.2 pm"), (1e-3, "52 pm"), (1.0, "52 nm"), (1e3, "52 µm"), (1e5, "5.2 mm")]
    )
    def test_lengths_have_readable_units(self, profile, factor, message):
        heights = profile.with_amplitude(0.052 * factor, "Rq").heights
        assert rows(characterisation_text(Profile(heights, spacing=0.01)))["Pq"] == message


def test_negligible_untrusted_wavelengths_are_called_negligible(profile):
    noise = np.random.default_rng(1).normal(size=len(profile))
    smooth = cut_off(profile, 0.3).heights
    for rms, words in ((1e-5, "negligible, "), (1e-4, "unreliable below")):
        result = Characterisation(Profile(smooth + rms * noise, spacing=0.01))
        assert words in {row.label: row.texts[0] for row in result.rows}["instrument"]
        assert (result.limit.slope_fraction < NEGLIGIBLE_SLOPE_FRACTION) == (rms < 1e-4)


def test_spectrum_without_power_law_has_no_exponent(profile):
    steps = np.interp(power_spectrum(profile).wave_number, [0.1, 3.0, 3.01, 300], [1.0, 1.0, 0.02, 0.02])
    heights = np.fft.irfft(np.fft.rfft(profile.heights) * np.concatenate([[0.0], steps]), len(profile))
    result = Characterisation(Profile(heights, spacing=0.01), band=(0.1, 5.0))
    message = {row.label: row.texts[0] for row in result.rows}
    assert result.misfit > 1.5
    assert message["Hurst exponent H"].startswith("none: the spectrum is not a power law")
    values = {value["name"]: value for row in result.rows for value in row.values}
    assert (values["hurst_exponent"]["value"], values["hurst_exponent"]["status"]) == (None, "no-line")
    spectrum = next(ax for ax in characterisation_figure(result).axes if "density $C$" in ax.get_ylabel())
    assert [line for line in spectrum.lines if line.get_linestyle() == "--"] == []


class TestFigure:
    @pytest.mark.parametrize("periodic", [True, False])
    def test_figure_is_one_column_wide_with_units_and_fit(self, profile, periodic, tmp_path):
        figure = characterisation_figure(profile, periodic=periodic)
        labels = [ax.get_xlabel() for ax in figure.axes] + [ax.get_ylabel() for ax in figure.axes]
        assert {"position $x$ (µm)", "height (nm)", "density (1/nm)", "density $C$ (µm³)"} <= set(labels)
        legend = " ".join(text.get_text() for ax in figure.axes if ax.get_legend() for text in ax.get_legend().texts)
        found = estimate_hurst_exponent(profile, periodic=periodic)
        assert f"$H$ = {found.value:.2f}" in legend
        assert "(classical)" in legend
        assert "(paper)" in legend
        figure.savefig(tmp_path / "figure.png", dpi=300)
        assert imread(tmp_path / "figure.png").shape[1] == pytest.approx(80 / 25.4 * 300, abs=2)
        assert min(text.get_fontsize() for text in figure.findobj(Text) if text.get_text()) >= 6

    def test_fitted_line_equals_power_law(self, profile):
        figure = characterisation_figure(profile)
        result = estimate_hurst_exponent(profile)
        spectrum = next(ax for ax in figure.axes if "density $C$" in ax.get_ylabel())
        dashed = [line for line in spectrum.lines if line.get_linestyle() == "--"]
        q, density = dashed[0].get_data()
        assert np.allclose(density, result.density(q))
        assert q[[0, -1]] == pytest.approx(
            2 * np.pi / np.array([result.longest_wavelength, result.shortest_wavelength])
        )

    def test_figure_without_band_has_a_note(self):
        legend = [text.get_text() for ax in characterisation_figure(NO_BAND).axes if ax.get_legend()
                  for text in ax.get_legend().texts]  # fmt: skip
        assert "no self-affine band found" in legend


# ---- What speaks against an exponent --------------------------------------------------------------------------------


def test_exponent_above_1_is_a_caution():
    smooth = self_affine(1, hurst_exponent=1.5, rms=0.1, points=4000, spacing=0.01)
    text = characterisation_text(smooth, band=(0.1, 5.0))
    message = rows(text)
    assert message["fractal dimension D"] == "none: 2 - H is below 1"
    assert "paper" in text
    assert message["caution"].startswith("H above 1 indicates a smooth surface")
    rough = self_affine(1, hurst_exponent=0.7, rms=0.1, points=4000, spacing=0.01)
    assert "caution" not in characterisation_text(rough)


def test_band_that_begins_on_a_peak_is_reported():
    rough = self_affine(2, hurst_exponent=0.7, rms=0.05, points=8000, spacing=0.05, longest_wavelength=8.0)
    waves = 0.4 * np.sin(2 * np.pi * rough.x / 8.0)
    text = characterisation_text(Profile(rough.heights + waves, spacing=0.05), band=(0.2, 8.2))
    assert "the band starts on a peak at" in text
    assert "begins on a peak" not in characterisation_text(rough, band=(0.2, 8.2))  # a roll-off is none


def test_dominant_peak_is_reported_with_its_fraction():
    rough = self_affine(3, hurst_exponent=0.7, rms=0.05, points=8000, spacing=0.01, longest_wavelength=8.0)
    assert "peak" not in rows(characterisation_text(rough))
    line = 0.003 * np.sin(2 * np.pi * rough.x / 0.06)  # of an instrument
    message = rows(characterisation_text(Profile(rough.heights + line, spacing=0.01)))["peak"]
    result = re.match(r"at ([\d.]+) nm, with (\d+) % of m4", message)
    assert float(result[1]) == pytest.approx(60, rel=0.1)
    # The line's own m4 is known: a²/2 q⁴.
    own = 0.003**2 / 2 * (2 * np.pi / 0.06) ** 4
    whole = own + spectral_moments(rough).curvature
    assert float(result[2]) == pytest.approx(100 * own / whole, abs=5)
    assert find_peak(power_spectrum(rough)) is None or find_peak(power_spectrum(rough))[1] < 0.05


# ---- Surfaces -------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def surface():
    white = np.random.default_rng(4).normal(size=(256, 320))
    q = np.hypot(*np.meshgrid(np.fft.fftfreq(320), np.fft.fftfreq(256))) * 2 * np.pi
    q[0, 0] = np.inf
    heights = np.fft.ifft2(q**-1.7 * np.fft.fft2(white)).real[:128, :160]
    return levelled(Surface(0.02 * heights / heights.std(), spacing=0.1), "plane")


@pytest.fixture(scope="module")
def characterised(surface):
    return Characterisation(surface)


def test_surface_has_parameters_moments_dimension_and_figure(surface, characterised):
    text = characterisation_text(characterised)
    message, found, estimate = rows(text), surface_parameters(surface), estimate_hurst_exponent(surface)
    assert message["Sa"] == f"{1000 * found.Sa:.4g} nm"
    assert message["Sdr"] == f"{100 * found.Sdr:.4g} %"
    assert message["Str"] == f"{found.Str:.4g}"
    assert message["fractal dimension D"].startswith(f"{2 - estimate.value:.3f} (classical")
    assert f"(automatic; {estimate.harmonics} wavelengths)" in text
    moments = surface_spectrum(surface).moments(90)
    assert message["m4"].split()[2] == f"{moments.curvature:.4g}"
    assert message["misfit"].startswith("factor 1.")
    assert "band found in" not in message
    assert "band found in" not in characterisation_text(surface, band=(0.4, 4.0))
    figure = characterisation_figure(characterised)
    legends = [text.get_text() for ax in figure.findobj(Axes) if ax.get_legend() for text in ax.get_legend().texts]
    assert any("q^{-2-2H}" in text for text in legends)
    assert sum("q^{-1-2H}" in text for text in legends) == 2


def test_friction_by_slope_assumes_equal_roughness_of_both_surfaces():
    x = np.arange(4000) * 0.01
    slope = 0.2  # of a body; the gap has that of two
    heights = slope * np.sqrt(2) / (2 * np.pi) * np.sin(2 * np.pi * x)
    line = gentle_friction(0.4, rms_gradient=slope * np.sqrt(2), rms_slope=slope * np.sqrt(2))
    message = rows(characterisation_text(Profile(heights, spacing=0.01), periodic=True, band=(0.02, 20.0)))
    assert message["friction by slope"].startswith(f"{line:.3f}, for two such surfaces, small-slope estimate")
    # Of a surface along both axes.
    x, y = np.meshgrid(np.arange(64) * 0.1, np.arange(64) * 0.1)
    random = np.random.default_rng(1)
    heights = 0.03 * np.sin(2 * np.pi * x) + 0.01 * np.sin(2 * np.pi * y) + 1e-3 * random.normal(size=x.shape)
    surface = Surface(heights, spacing=(0.1, 0.1))
    message = rows(characterisation_text(surface))["friction by slope"]
    along_x, along_y = (float(value) for value in re.findall(r"(0\.\d+) along", message))
    assert along_x > along_y > 0.2


class TestJoined:
    def test_pressure_equals_closed_form_up_to_yield(self, tmp_path):
        fine = self_affine_surface(4, hurst_exponent=0.8, rms=0.05, shape=(256, 256), spacing=0.01)
        pieces = fine.heights.reshape(64, 4, 64, 4).mean((1, 3)), fine.heights[:128, :128]
        scans = [Surface(heights, spacing=step) for heights, step in zip(pieces, (0.04, 0.01), strict=True)]
        joined = joined_spectrum(scans, names=["microscope", "probe"])
        figure = joined_figure(joined)
        spectra, _, pressure = figure.axes
        assert [text.get_text() for text in spectra.get_legend().texts] == ["microscope", "probe", "joined"]
        own = joined.roughness()
        known = spectral_resolution(
            own, own, pressure=1e-4, hardness=None, mu0=0.2, tau0=0.1, effective_modulus=1.0
        )  # E* of 1, so that pressures are over it
        elastic = pressure.lines[0]
        assert elastic.get_ydata() == pytest.approx(known.mean_pressure.values)
        steel = material("bearing steel")
        young, ratio = steel.young_modulus, steel.poisson_ratio
        limit = steel.hardness / effective_modulus(young, ratio, young, ratio)
        line = next(item for item in pressure.lines[1:] if item.get_ydata()[0] == pytest.approx(limit))
        start = line.get_xdata()[0]
        assert float(np.sqrt(2) * own.gradient_at(start) / 2.2) == pytest.approx(limit, rel=1e-3)
        figure.savefig(tmp_path / "figure.png", dpi=300)
        assert imread(tmp_path / "figure.png").shape[1] == pytest.approx(170 / 25.4 * 300, abs=2)
        assert min(text.get_fontsize() for text in figure.findobj(Text) if text.get_text()) >= 6


class TestSectionParameters:
    TURNED = Profile(np.sin(2 * np.pi * np.arange(10_000) / 200), spacing=0.5)

    def test_section_parameter_rows_equal_the_function(self):
        result = Characterisation(self.TURNED)
        message = {row.label: row.texts[0] for row in result.rows}
        values = {value["name"]: value for row in result.rows for value in row.values}
        expected = section_parameters(self.TURNED)
        for name, value in expected.values.items():
            if np.isfinite(value):
                assert values[name]["value"] == value, name
                assert values[name]["status"] == "ok"
        assert values["lc"]["value"] == 800
        assert message["Ra"] == f"{1000 * expected.Ra:.4g} nm"
        assert message["Rmr"].endswith(" %")
        assert message["filters"].startswith("Gaussian, λc 800 µm, λs 2.5 µm (Sc3 of ISO 21920-3, for Ra 0.6363 µm and")
        assert message["filters"].endswith("5 sections of 800 µm")

    def test_short_profile_has_status_without_values(self):
        result = Characterisation(Profile(self.TURNED.heights[:100], spacing=0.5))
        message = {row.label: row.texts[0] for row in result.rows}
        values = {value["name"]: value for row in result.rows for value in row.values}
        assert message["R and W parameters"].startswith(
            "none: one section length is 80 µm, and the profile is 50 µm long"
        )
        assert (values["Ra"]["value"], values["Ra"]["status"]) == (None, "no-section")
        with pytest.raises(ValueError, match="one section length is 60 µm"):
            _ = Characterisation(Profile(self.TURNED.heights[:100], spacing=0.5), lc=60.0).rows

    def test_surface_parameters_apply_filters(self):
        surface = self_affine_surface(3, hurst_exponent=0.8, rms=0.02, shape=(64, 80), spacing=0.1)
        result = Characterisation(surface, lc=3.0, ls=0.3)
        limited = filtered(filtered(surface, cutoff=0.3), cutoff=3.0, kind="L")
        assert result.parameters.Sq == surface_parameters(limited).Sq
        text = {row.label: row.texts[0] for row in result.rows}
        assert text["filters"] == "S-filter (Gaussian, 0.3 µm), then L-filter (Gaussian, 3 µm)"
        for options, message in (
            ({"lc": 1.0, "ls": 2.0}, "ls must be below lc"),
            ({"robust": True}, "needs a cutoff lc"),
        ):
            with pytest.raises(ValueError, match=message):
                _ = Characterisation(surface, **options).rows
