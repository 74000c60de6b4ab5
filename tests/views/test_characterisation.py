"""Tests of the table and the figure of one scan, which must show the results of the library with units."""

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
from stiction.summary.characterisation import Characterisation
from stiction.surfaces.spectrum import find_spectral_peak
from stiction.views.characterisation import NEGLIGIBLE_SLOPE_FRACTION, CharacterisationTable, characterisation_text
from stiction.views.figures.roughness import characterisation_figure
from stiction.views.scans import joined_spectrum_figure
from support.rough_surfaces import periodic_body

PROFILE_WITHOUT_BAND = Profile(np.sin(np.arange(700) / 20), spacing=5.0)

pytestmark = pytest.mark.usefixtures("few_fitted_lines")


@pytest.fixture(scope="module")
def profile():
    return self_affine(1, hurst_exponent=0.7, rms=0.05, points=6000, spacing=0.01, longest_wavelength=6.0)


def get_texts_by_label(text):
    return {line[:19].strip() or "paper": line[20:] for line in text.splitlines()}


class TestCharacterisationText:
    def test_characterisation_text_of_a_profile_agrees_with_library_results(self, profile):
        texts, estimate = get_texts_by_label(characterisation_text(profile)), estimate_hurst_exponent(profile)
        parameters = roughness_parameters(profile)
        assert texts["Pa"] == f"{1000 * parameters.Pa:.4g} nm"
        assert texts["Pt"] == f"{1000 * parameters.Pt:.4g} nm"
        assert texts["Pdq"].startswith(f"{parameters.Pdq:.4g} (seven points)")
        assert texts["Hurst exponent H"] == f"{estimate.value:.3f} [{estimate.lower:.3f}, {estimate.upper:.3f}] (95 %)"
        assert texts["fractal dimension D"] == f"{2 - estimate.value:.3f} (classical, 2 - H)"
        assert texts["paper"] == f"{(4 - estimate.value) / 2:.3f} (paper, (4 - H)/2)"
        assert texts["fitted band"].endswith(f"(automatic; {estimate.harmonics} harmonics)")
        assert texts["m0"].endswith(" µm²")
        assert texts["m4"].endswith(" 1/µm²")
        assert "Hann" in texts["spectrum"]

    def test_characterisation_text_of_a_profile_states_the_given_band_and_periodicity(self, profile):
        texts = get_texts_by_label(characterisation_text(profile, band=(0.1, 2.0), periodic=True))
        assert "given" in texts["fitted band"]
        assert "periodic" in texts["spectrum"]

    def test_characterisation_text_of_a_profile_without_self_affine_band_has_no_hurst_exponent(self):
        assert "none" in get_texts_by_label(characterisation_text(PROFILE_WITHOUT_BAND))["Hurst exponent H"]

    def test_characterisation_text_function_rejects_invalid_input(self, profile):
        with pytest.raises(ValueError, match="band"):
            characterisation_text(profile, band=(1.0, 1.001))
        for heights, expected_message in (([1.0] * 20, "flat"), ([0.0, 1.0, 0.0, 1.0], "7 points")):
            with pytest.raises(ValueError, match=expected_message):
                characterisation_text(Profile(heights, spacing=1.0))

    @pytest.mark.parametrize(
        ("factor", "expected_text"),
        [(1e-4, "5.2 pm"), (1e-3, "52 pm"), (1.0, "52 nm"), (1e3, "52 µm"), (1e5, "5.2 mm")],
    )
    def test_lengths_are_printed_in_units_that_suit_their_size(self, profile, factor, expected_text):
        heights = profile.with_amplitude(0.052 * factor, "Rq").heights
        assert get_texts_by_label(characterisation_text(Profile(heights, spacing=0.01)))["Pq"] == expected_text


def test_instrument_limit_is_called_negligible_if_shorter_wavelengths_contribute_little_slope(profile):
    noise = np.random.default_rng(1).normal(size=len(profile))
    smooth_heights = cut_off(profile, 0.3).heights
    for rms, expected_words in ((1e-5, "negligible, "), (1e-4, "unreliable below")):
        characterisation = Characterisation(Profile(smooth_heights + rms * noise, spacing=0.01))
        assert (
            expected_words
            in {row.label: row.texts[0] for row in CharacterisationTable(characterisation).rows}["instrument"]
        )
        assert (characterisation.instrument_limit.slope_fraction < NEGLIGIBLE_SLOPE_FRACTION) == (rms < 1e-4)


def test_tip_radius_adds_a_line_of_text_but_no_second_cutoff(profile):
    noise = np.random.default_rng(1).normal(size=len(profile))
    scans = {
        "rough": profile,
        "smooth": Profile(cut_off(profile, 0.3).heights, spacing=0.01),
        "noisy": Profile(cut_off(profile, 0.3).heights + 3e-4 * noise, spacing=0.01),
    }
    for name, radius, expected_words in (
        ("rough", 2.0, "does not resolve wavelengths below"),
        ("smooth", 1e-3, "resolves all wavelengths"),
        ("noisy", 0.05, "which are unreliable in any case"),
        ("noisy", 50.0, "does not resolve wavelengths below"),
    ):
        with_tip, without_tip = (
            Characterisation(scans[name], tip_radius=given_radius) for given_radius in (radius, None)
        )
        texts, texts_without_tip = (
            {row.label: row.texts[0] for row in CharacterisationTable(result).rows}
            for result in (with_tip, without_tip)
        )
        assert expected_words in texts["tip"]
        assert "cutoff" not in texts["tip"]
        assert texts["instrument"] == texts_without_tip["instrument"]
        suggested_cutoffs = {
            match
            for text in (texts["instrument"], *(caveat.remedy for caveat in with_tip.caveats))
            for match in re.findall("--cutoff '(.*?)'", text)
        }
        assert len(suggested_cutoffs) == (name == "noisy")
        assert "tip" not in texts_without_tip


@pytest.mark.parametrize("periodic", [True, False])
def test_caveats_and_table_of_noisy_body_suggest_the_same_cutoff(periodic):
    smooth_profile = periodic_body((1500,), hurst=0.7, longest=1, shortest=180)
    noise = 3e-5 * np.random.default_rng(1).normal(size=1500)
    noisy_profile = Profile(smooth_profile.heights + noise, spacing=smooth_profile.spacing)
    characterisation = Characterisation(noisy_profile, periodic=periodic)
    limit = characterisation.instrument_limit
    assert limit.matters
    assert [caveat.cut_off for caveat in characterisation.caveats if caveat.severity == "fault"] == [limit.cut_off]


def test_characterisation_of_a_spectrum_that_is_no_power_law_has_no_hurst_exponent(profile):
    filter_gain = np.interp(power_spectrum(profile).wave_number, [0.1, 3.0, 3.01, 300], [1.0, 1.0, 0.02, 0.02])
    heights = np.fft.irfft(np.fft.rfft(profile.heights) * np.concatenate([[0.0], filter_gain]), len(profile))
    characterisation = Characterisation(Profile(heights, spacing=0.01), band=(0.1, 5.0))
    texts = {row.label: row.texts[0] for row in CharacterisationTable(characterisation).rows}
    assert characterisation.power_law_misfit > 1.5
    assert texts["Hurst exponent H"].startswith("none: the spectrum is not a power law")
    values = {value.name: value for row in CharacterisationTable(characterisation).rows for value in row.values}
    assert values["hurst_exponent"].status == "no-line"
    assert np.isnan(values["hurst_exponent"].value)
    spectrum = next(ax for ax in characterisation_figure(characterisation).axes if "density $C$" in ax.get_ylabel())
    assert [line for line in spectrum.lines if line.get_linestyle() == "--"] == []


class TestCharacterisationFigure:
    @pytest.mark.parametrize("periodic", [True, False])
    def test_characterisation_figure_is_one_column_wide_and_shows_units_and_fitted_exponent(
        self, profile, periodic, tmp_path
    ):
        figure = characterisation_figure(profile, periodic=periodic)
        labels = [ax.get_xlabel() for ax in figure.axes] + [ax.get_ylabel() for ax in figure.axes]
        assert {"position $x$ (µm)", "height (nm)", "density (1/nm)", "density $C$ (µm³)"} <= set(labels)
        legend = " ".join(text.get_text() for ax in figure.axes if ax.get_legend() for text in ax.get_legend().texts)
        estimate = estimate_hurst_exponent(profile, periodic=periodic)
        assert f"$H$ = {estimate.value:.2f}" in legend
        assert "(classical)" in legend
        assert "(paper)" in legend
        figure.savefig(tmp_path / "figure.png", dpi=300)
        assert imread(tmp_path / "figure.png").shape[1] == pytest.approx(80 / 25.4 * 300, abs=2)
        assert min(text.get_fontsize() for text in figure.findobj(Text) if text.get_text()) >= 6

    def test_fitted_line_in_the_characterisation_figure_equals_the_estimated_power_law(self, profile):
        figure = characterisation_figure(profile)
        estimate = estimate_hurst_exponent(profile)
        spectrum = next(ax for ax in figure.axes if "density $C$" in ax.get_ylabel())
        dashed_lines = [line for line in spectrum.lines if line.get_linestyle() == "--"]
        wave_number, density = dashed_lines[0].get_data()
        assert np.allclose(density, estimate.density(wave_number))
        assert wave_number[[0, -1]] == pytest.approx(
            2 * np.pi / np.array([estimate.longest_wavelength, estimate.shortest_wavelength])
        )

    def test_range_of_heights_determines_the_height_unit_in_the_characterisation_figure(self, profile):
        for factor, unit in ((0.01, "nm"), (100.0, "µm")):
            scaled_profile = Profile(factor * profile.heights, spacing=factor * profile.spacing)
            labels = [ax.get_ylabel() for ax in characterisation_figure(scaled_profile).axes]
            assert {f"height ({unit})", f"density (1/{unit})"} <= set(labels)

    def test_characterisation_figure_states_that_no_self_affine_band_was_found(self):
        legend_texts = [
            text.get_text()
            for ax in characterisation_figure(PROFILE_WITHOUT_BAND).axes
            if ax.get_legend()
            for text in ax.get_legend().texts
        ]
        assert "no self-affine band found" in legend_texts


# ---- Cautions about the Hurst exponent ------------------------------------------------------------------------------


def test_hurst_exponent_above_1_adds_a_caution():
    smooth_profile = self_affine(1, hurst_exponent=1.5, rms=0.1, points=4000, spacing=0.01)
    text = characterisation_text(smooth_profile, band=(0.1, 5.0))
    texts = get_texts_by_label(text)
    assert texts["fractal dimension D"] == "none: 2 - H is below 1"
    assert "paper" in text
    assert texts["caution"].startswith("H above 1 indicates a smooth surface")
    rough_profile = self_affine(1, hurst_exponent=0.7, rms=0.1, points=4000, spacing=0.01)
    assert "caution" not in characterisation_text(rough_profile)


def test_fitted_band_that_starts_at_a_spectral_peak_is_reported():
    rough_profile = self_affine(2, hurst_exponent=0.7, rms=0.05, points=8000, spacing=0.05, longest_wavelength=8.0)
    sine_wave = 0.4 * np.sin(2 * np.pi * rough_profile.x / 8.0)
    text = characterisation_text(Profile(rough_profile.heights + sine_wave, spacing=0.05), band=(0.2, 8.2))
    assert "the band starts on a peak at" in text
    assert "begins on a peak" not in characterisation_text(rough_profile, band=(0.2, 8.2))


def test_spectrum_and_hurst_exponent_but_not_roughness_parameters_exclude_outliers(profile, surface):
    for body, height_name, moments_name in ((profile, "Pt", "m2"), (surface, "Sz", None)):
        heights = body.heights.copy()
        heights.flat[np.arange(331, heights.size, heights.size // 20)] += 10 * float(heights.std())
        results = [Characterisation(scan) for scan in (body, type(body)(heights, spacing=body.spacing))]
        clean_rows, spiky_rows = ({row.label: row for row in CharacterisationTable(result).rows} for result in results)
        assert results[1].power_law_fit.value == pytest.approx(results[0].power_law_fit.value, abs=0.02)
        assert results[1].roughness.gradient[-1] == pytest.approx(results[0].roughness.gradient[-1], rel=0.02)
        assert spiky_rows["instrument"].texts == clean_rows["instrument"].texts
        clean_height, spiky_height = (rows[height_name].values[0].value for rows in (clean_rows, spiky_rows))
        assert spiky_height > 1.5 * clean_height
        assert spiky_rows["outliers"].values[0].value == np.size(np.arange(331, heights.size, heights.size // 20))
        if moments_name:
            moments = [rows[moments_name].values[0].value for rows in (clean_rows, spiky_rows)]
            assert moments[1] == pytest.approx(moments[0], rel=0.02)
        else:
            exponents = [[line.hurst_exponents.mean() for line in result.line_roughnesses] for result in results]
            assert exponents[1] == pytest.approx(exponents[0], abs=0.05)


def test_dominant_spectral_peak_is_reported_with_its_fraction_of_the_mean_square():
    rough_profile = self_affine(3, hurst_exponent=0.7, rms=0.05, points=8000, spacing=0.01, longest_wavelength=8.0)
    assert "peak" not in get_texts_by_label(characterisation_text(rough_profile))
    sine_wave = 0.003 * np.sin(2 * np.pi * rough_profile.x / 0.06)
    peak_text = get_texts_by_label(characterisation_text(Profile(rough_profile.heights + sine_wave, spacing=0.01)))[
        "peak"
    ]
    match = re.match(r"at ([\d.]+) nm, with (\d+) % of m4", peak_text)
    assert float(match[1]) == pytest.approx(60, rel=0.1)
    # A sine of amplitude a and wave number q has m4 = a²/2 q⁴.
    moment_of_line = 0.003**2 / 2 * (2 * np.pi / 0.06) ** 4
    total_moment = moment_of_line + spectral_moments(rough_profile).curvature
    assert float(match[2]) == pytest.approx(100 * moment_of_line / total_moment, abs=5)
    assert (
        find_spectral_peak(power_spectrum(rough_profile)) is None
        or find_spectral_peak(power_spectrum(rough_profile))[1] < 0.05
    )


# ---- Surfaces -------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def surface():
    white_noise = np.random.default_rng(4).normal(size=(256, 320))
    wave_number = np.hypot(*np.meshgrid(np.fft.fftfreq(320), np.fft.fftfreq(256))) * 2 * np.pi
    wave_number[0, 0] = np.inf
    heights = np.fft.ifft2(wave_number**-1.7 * np.fft.fft2(white_noise)).real[:128, :160]
    return levelled(Surface(0.02 * heights / heights.std(), spacing=0.1), "plane")


@pytest.fixture(scope="module")
def surface_characterisation(surface):
    return Characterisation(surface)


def test_characterisation_text_and_figure_of_a_surface_agree_with_library_results(surface, surface_characterisation):
    text = characterisation_text(surface_characterisation)
    texts, parameters, estimate = (
        get_texts_by_label(text),
        surface_parameters(surface),
        estimate_hurst_exponent(surface),
    )
    assert texts["Sa"] == f"{1000 * parameters.Sa:.4g} nm"
    assert texts["Sdr"] == f"{100 * parameters.Sdr:.4g} %"
    assert texts["Str"] == f"{parameters.Str:.4g}"
    assert texts["fractal dimension D"].startswith(f"{2 - estimate.value:.3f} (classical")
    assert f"(automatic; {estimate.harmonics} wavelengths)" in text
    moments = surface_spectrum(surface).moments(90)
    assert texts["m4"].split()[2] == f"{moments.curvature:.4g}"
    assert texts["misfit"].startswith("factor 1.")
    assert "band found in" not in texts
    assert "band found in" not in characterisation_text(surface, band=(0.4, 4.0))
    figure = characterisation_figure(surface_characterisation)
    legend_texts = [text.get_text() for ax in figure.findobj(Axes) if ax.get_legend() for text in ax.get_legend().texts]
    assert any("q^{-2-2H}" in text for text in legend_texts)
    assert sum("q^{-1-2H}" in text for text in legend_texts) == 2


def test_small_slope_estimate_of_one_scan_assumes_two_equal_surfaces():
    x = np.arange(4000) * 0.01
    slope = 0.2  # slope of one surface; the slope of the gap is larger by √2
    heights = slope * np.sqrt(2) / (2 * np.pi) * np.sin(2 * np.pi * x)
    expected_friction = gentle_friction(0.4, rms_gradient=slope * np.sqrt(2), rms_slope=slope * np.sqrt(2))

    def format_friction_text(body, **options):
        rows = CharacterisationTable(Characterisation(body, **options)).rows
        (text,) = (row.texts[0] for row in rows if row.label == "friction by slope")
        return text

    friction_text = format_friction_text(Profile(heights, spacing=0.01), periodic=True, band=(0.02, 20.0))
    assert re.match(
        rf"friction at all contacts: μ0; friction at opposing contacts only: {expected_friction:.3f} if μ0 = 0.4",
        friction_text,
    )
    assert "small-slope estimates for two such surfaces" in friction_text
    x, y = np.meshgrid(np.arange(64) * 0.1, np.arange(64) * 0.1)
    random = np.random.default_rng(1)
    heights = 0.03 * np.sin(2 * np.pi * x) + 0.01 * np.sin(2 * np.pi * y) + 1e-3 * random.normal(size=x.shape)
    surface = Surface(heights, spacing=(0.1, 0.1))
    slope_x, slope_y = (float(value) for value in re.findall(r"(0\.\d+) along", format_friction_text(surface)))
    assert slope_x > slope_y > 0.2


class TestJoinedSpectrum:
    def test_pressure_panel_shows_the_spectral_estimate_up_to_the_hardness(self, tmp_path):
        fine_surface = self_affine_surface(4, hurst_exponent=0.8, rms=0.05, shape=(256, 256), spacing=0.01)
        height_maps = fine_surface.heights.reshape(64, 4, 64, 4).mean((1, 3)), fine_surface.heights[:128, :128]
        scans = [Surface(heights, spacing=spacing) for heights, spacing in zip(height_maps, (0.04, 0.01), strict=True)]
        spectrum = joined_spectrum(scans, names=["microscope", "probe"])
        figure = joined_spectrum_figure(spectrum)
        spectra, _, pressure = figure.axes
        assert [text.get_text() for text in spectra.get_legend().texts] == ["microscope", "probe", "joined"]
        roughness = spectrum.roughness()
        resolution = spectral_resolution(
            roughness, roughness, pressure=1e-4, hardness=None, mu0=0.2, tau0=0.1, effective_modulus=1.0
        )  # E* = 1 GPa, so that pressures are fractions of E*.
        elastic_line = pressure.lines[0]
        assert elastic_line.get_ydata() == pytest.approx(resolution.mean_pressure.values)
        steel = material("bearing steel")
        young, ratio = steel.young_modulus, steel.poisson_ratio
        limit = steel.hardness / effective_modulus(young, ratio, young, ratio)
        line = next(
            other_line for other_line in pressure.lines[1:] if other_line.get_ydata()[0] == pytest.approx(limit)
        )
        start = line.get_xdata()[0]
        assert float(np.sqrt(2) * roughness.gradient_at(start) / 2.2) == pytest.approx(limit, rel=1e-3)
        figure.savefig(tmp_path / "figure.png", dpi=300)
        assert imread(tmp_path / "figure.png").shape[1] == pytest.approx(170 / 25.4 * 300, abs=2)
        assert min(text.get_fontsize() for text in figure.findobj(Text) if text.get_text()) >= 6


class TestSectionParameters:
    TURNED_PROFILE = Profile(np.sin(2 * np.pi * np.arange(10_000) / 200), spacing=0.5)

    def test_rows_of_section_parameters_equal_library_values(self):
        characterisation = Characterisation(self.TURNED_PROFILE)
        texts = {row.label: row.texts[0] for row in CharacterisationTable(characterisation).rows}
        values = {value.name: value for row in CharacterisationTable(characterisation).rows for value in row.values}
        expected = section_parameters(self.TURNED_PROFILE)
        for name, value in expected.values.items():
            if np.isfinite(value):
                assert values[name].value == value, name
                assert values[name].status == "ok"
        assert values["lc"].value == 800
        assert texts["Ra"] == f"{1000 * expected.Ra:.4g} nm"
        assert texts["Rmr"].endswith(" %")
        assert texts["filters"].startswith("Gaussian, λc 800 µm, λs 2.5 µm (Sc3 of ISO 21920-3, for Ra 0.6363 µm and")
        assert texts["filters"].endswith("5 sections of 800 µm")

    def test_profile_shorter_than_one_section_has_a_status_instead_of_section_parameters(self):
        characterisation = Characterisation(Profile(self.TURNED_PROFILE.heights[:100], spacing=0.5))
        texts = {row.label: row.texts[0] for row in CharacterisationTable(characterisation).rows}
        values = {value.name: value for row in CharacterisationTable(characterisation).rows for value in row.values}
        assert texts["R and W parameters"].startswith(
            "none: one section length is 80 µm, and the profile is 50 µm long"
        )
        assert values["Ra"].status == "no-section"
        assert np.isnan(values["Ra"].value)
        with pytest.raises(ValueError, match="one section length is 60 µm"):
            _ = CharacterisationTable(
                Characterisation(Profile(self.TURNED_PROFILE.heights[:100], spacing=0.5), lc=60.0)
            ).rows

    def test_surface_parameters_are_computed_from_the_filtered_surface(self):
        surface = self_affine_surface(3, hurst_exponent=0.8, rms=0.02, shape=(64, 80), spacing=0.1)
        characterisation = Characterisation(surface, lc=3.0, ls=0.3)
        filtered_surface = filtered(filtered(surface, cutoff=0.3), cutoff=3.0, kind="L")
        assert characterisation.parameters.Sq == surface_parameters(filtered_surface).Sq
        texts = {row.label: row.texts[0] for row in CharacterisationTable(characterisation).rows}
        assert texts["filters"] == "S-filter (Gaussian, 0.3 µm), then L-filter (Gaussian, 3 µm)"
        for options, expected_message in (
            ({"lc": 1.0, "ls": 2.0}, "ls must be below lc"),
            ({"robust": True}, "lc must be given for the robust filter"),
        ):
            with pytest.raises(ValueError, match=expected_message):
                _ = CharacterisationTable(Characterisation(surface, **options)).rows
