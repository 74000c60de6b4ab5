"""Tests of `stiction pair` with joined spectra instead of scans."""

import json
from dataclasses import replace

import numpy as np
import pytest
from stiction import (
    JoinedSpectrum,
    Study,
    Surface,
    cut_off,
    joined_spectrum,
    levelled,
    pair,
    read_spectrum,
    scale_dependent_roughness,
    self_affine_surface,
    write_spectrum,
    write_surface,
)
from stiction.companions.resolution import evaluate_at_cutoffs, find_resolution_limits
from stiction.solve.store import open_stored_result
from stiction.study.measured_bodies import MeasuredBodySettings
from stiction.surfaces.measured.spectrum_file import is_spectrum_file
from stiction.surfaces.pairing import SurfacePairsFromSpectra
from support.command import assert_rejected, call_stiction, check_stiction

SPACING, NUM_POINTS = 0.02, 256
MATERIAL_OPTIONS = {
    "effective_modulus": "100 GPa",
    "hardness": "4 GPa",
    "mu0": 0.2,
    "tau0": "200 MPa",
    "load": "20 MPa",
}
TWO_DIRECTION_OPTIONS = {"direction": [0.0, 90.0], "onset": 0}
COMMAND_OPTIONS = [
    "--effective-modulus", "100 GPa", "--hardness", "4 GPa", "--mu0", "0.2", "--tau0", "200 MPa", "--load", "20 MPa",
    "--direction", "0,90", "--onset", "0",
]  # fmt: skip
SIDES = ("upper", "lower")


def create_surface(side):
    return self_affine_surface(
        11, hurst_exponent=0.8, rms=0.02, shape=(NUM_POINTS, NUM_POINTS), spacing=SPACING, side=side,
        longest_wavelength=1.28, shortest_wavelength=8 * SPACING,
    )  # fmt: skip


def create_scans(surface):
    """Return five scans of a surface: one with large pixels, and four of quarters with small pixels."""
    pixel_heights = surface.heights.reshape(NUM_POINTS // 4, 4, NUM_POINTS // 4, 4).mean((1, 3))
    half_size = NUM_POINTS // 2
    pieces = [
        surface.heights[row : row + half_size, column : column + half_size]
        for row in (0, half_size)
        for column in (0, half_size)
    ]
    return [Surface(pixel_heights, spacing=4 * SPACING), *(Surface(piece, spacing=SPACING) for piece in pieces)]


@pytest.fixture(scope="module")
def surfaces():
    return [create_surface(side) for side in SIDES]


@pytest.fixture(scope="module")
def spectra(surfaces):
    return [
        joined_spectrum([levelled(scan, "plane") for scan in create_scans(true_surface)]) for true_surface in surfaces
    ]


@pytest.fixture(scope="module")
def spectra_directory(tmp_path_factory, surfaces, spectra):
    directory = tmp_path_factory.mktemp("spectra")
    for side, surface, spectrum in zip(SIDES, surfaces, spectra, strict=True):
        write_spectrum(spectrum, directory / f"{side}.csv")
        write_surface(surface, directory / f"{side}.npy")
    return directory


# ---- Computed pairs ------------------------------------------------------------------------------------------------


def test_surrogates_generated_from_spectra_have_these_spectra_and_the_same_phases_at_every_cutoff(spectra):
    pairs = SurfacePairsFromSpectra(*spectra)
    assert pairs.spacing[0] == pytest.approx(min(spectrum.shortest for spectrum in spectra) / 4)
    assert pairs.shape[0] * 4 == pytest.approx(3 * pairs.side_length / pairs.spacing[0], abs=4)
    gradients = [
        [float(scale_dependent_roughness(body).gradient_at(0.3)) for body in pairs.surrogates(index)]
        for index in range(6)
    ]
    expected_gradients = [float(spectrum.roughness().gradient_at(0.3)) for spectrum in spectra]
    assert np.mean(gradients, axis=0) == pytest.approx(expected_gradients, rel=0.1)
    filtered_pairs = SurfacePairsFromSpectra(*spectra, cut_off=(0.4, 0.4))
    assert filtered_pairs.spacing == pairs.spacing
    num_points = round(pairs.side_length / pairs.spacing[0])
    surrogate = spectra[1].surface(2016, shape=(num_points, num_points), spacing=pairs.spacing, repetition=3)
    rows, columns = pairs.shape
    cropped_surrogate = Surface(cut_off(surrogate, 0.4, periodic=True).heights[:rows, :columns], spacing=pairs.spacing)
    assert np.array_equal(filtered_pairs.surrogates(3)[1].heights, levelled(cropped_surrogate, "plane").heights)
    # The spacing of the surrogates follows from the shortest cutoff if all results are filtered.
    assert SurfacePairsFromSpectra(*spectra, cut_off=(0.4, 0.4), shortest_cutoff=0.4).spacing[0] == pytest.approx(0.1)


def test_friction_interval_from_joined_spectra_contains_the_friction_of_the_complete_surfaces(spectra, surfaces):
    elastic_options = {name: value for name, value in MATERIAL_OPTIONS.items() if name != "hardness"} | {
        "load": "200 MPa"
    }
    result_of_spectra = pair(*spectra, surrogates=8, **elastic_options, **TWO_DIRECTION_OPTIONS)
    result_of_surfaces = pair(*surfaces, shifts=8, **elastic_options, **TWO_DIRECTION_OPTIONS)
    result_of_coarse_scans = pair(
        *(create_scans(surface)[0] for surface in surfaces), shifts=8, **elastic_options, **TWO_DIRECTION_OPTIONS
    )
    for quantity in ("mean_friction", "contact_area_fraction"):
        estimates = []
        for result in (result_of_spectra, result_of_surfaces, result_of_coarse_scans):
            estimate = result.at()[quantity].squeeze()
            estimate = estimate.sel(sliding="all") if "sliding" in estimate.dims else estimate
            estimates.append([float(estimate.sel(statistic=statistic)) for statistic in ("mean", "lower", "upper")])
        (mean, lower, upper), (true_value, *_), (coarse_mean, *_) = estimates
        assert lower < true_value < upper
    assert abs(coarse_mean - true_value) > 2 * abs(mean - true_value)


def test_at_command_and_report_command_accept_the_result_of_a_pair_of_spectra(spectra_directory):
    completed = check_stiction(
        "pair",
        "upper.csv",
        "lower.csv",
        *COMMAND_OPTIONS,
        "--surrogates",
        "2",
        "--json",
        cwd=spectra_directory,
        without_figures=True,
        without_report=True,
    )
    record = json.loads(completed.stdout)
    study = Study.from_toml(spectra_directory / "pair" / "study.toml")
    assert study.surfaces.press == "surrogates"
    assert study.surfaces.upper.sha256 is not None
    assert study.ensemble.repetitions == 2
    check_stiction("at", "pair", "--load", "30 MPa", cwd=spectra_directory)
    check_stiction("report", "pair", cwd=spectra_directory, without_figures=True)
    dataset = evaluate_at_cutoffs(open_stored_result(spectra_directory / "pair")).isel(load=0, mu0=0, tau0=0)
    spectral_estimate = find_resolution_limits(dataset, study).spectral
    assert float(spectral_estimate.mean_pressure.max()) == pytest.approx(4.0)
    assert float(spectral_estimate.wavelength.max()) > 1.0
    cutoffs = [entry["cut_off"] for entry in record["resolution"]["cutoffs"]]
    assert cutoffs[1] == pytest.approx(read_spectrum(spectra_directory / "upper.csv").shortest, rel=1e-3)


def test_pair_command_accepts_a_spectrum_paired_with_a_scan_and_detects_changed_spectra(
    spectra_directory, surfaces, spectra
):
    command = ["pair", "upper.csv", "lower.npy", *COMMAND_OPTIONS, "--surrogates", "2", "--output", "mixed"]
    check_stiction(*command, cwd=spectra_directory, without_figures=True, without_report=True)
    changed_directory = spectra_directory / "changed"
    changed_directory.mkdir()
    for name in ("upper.csv", "lower.csv"):
        (changed_directory / name).write_bytes((spectra_directory / name).read_bytes())
    command = ["pair", "upper.csv", "lower.csv", *COMMAND_OPTIONS, "--surrogates", "2"]
    check_stiction(*command, cwd=changed_directory, without_figures=True, without_report=True)
    (changed_directory / "upper.csv").write_bytes((spectra_directory / "lower.csv").read_bytes())
    assert_rejected(
        call_stiction("run", "pair", "--set", "ensemble.repetitions=3", cwd=changed_directory), "has changed since"
    )


REJECTED_OUTPUT_OPTION = ["--output", "rejected"]


@pytest.mark.parametrize(
    ("arguments", "expected_words"),
    [
        (["pair", "upper.csv", "lower.csv", *COMMAND_OPTIONS, "--lines", "4", *REJECTED_OUTPUT_OPTION], "--lines"),
        (["pair", "upper.csv", "lower.csv", *COMMAND_OPTIONS, "--shifts", "4", *REJECTED_OUTPUT_OPTION], "--shifts"),
        (["pair", "upper.csv", "lower.csv", *COMMAND_OPTIONS, "--unit", "um", *REJECTED_OUTPUT_OPTION], "has no unit"),
        (
            ["pair", "upper.csv", "lower.csv", *COMMAND_OPTIONS, "--cutoff", "3 um", *REJECTED_OUTPUT_OPTION],
            "rows and columns",
        ),
        (["characterise", "upper.csv", "--output", "rejected.html"], "spectrum"),
    ],
)
def test_commands_that_accept_only_scans_reject_spectra(spectra_directory, arguments, expected_words):
    assert_rejected(call_stiction(*arguments, cwd=spectra_directory), expected_words)


# ---- Spectrum files -------------------------------------------------------------------------------------------------


def test_spectrum_file_preserves_all_digits(spectra, tmp_path):
    write_spectrum(spectra[0], tmp_path / "joined.csv")
    spectrum_read = read_spectrum(tmp_path / "joined.csv")
    for name in ("wave_number", "density", "count", "contribution", "ratio"):
        assert np.array_equal(getattr(spectrum_read, name), getattr(spectra[0], name), equal_nan=True)
    assert (spectrum_read.bands, spectrum_read.reasons, spectrum_read.names) == (
        spectra[0].bands,
        spectra[0].reasons,
        spectra[0].names,
    )
    assert spectrum_read.history == spectra[0].history
    with pytest.raises(ValueError, match="already exists"):
        write_spectrum(spectrum_read, tmp_path / "joined.csv")
    with pytest.raises(ValueError, match=r"must end in \.csv"):
        write_spectrum(spectrum_read, tmp_path / "joined.txt")
    with pytest.raises(ValueError, match="must be a JoinedSpectrum"):
        write_spectrum("joined", tmp_path / "other.csv")


@pytest.mark.parametrize(
    "name", ["a#1.csv", "#1", "a,b", '"a"', 'a"b', "a\r\n#b", " a  b ", "", "\udcff", "\u2028z", "=1+1", "a\0b",
             "a, from 1 to 2 um, ended by b", "C2D (um4)"]
)  # fmt: skip
def test_spectrum_file_preserves_scan_names_with_special_characters(spectra, tmp_path, name):
    names = (name, *spectra[0].names[1:])
    write_spectrum(replace(spectra[0], names=names), tmp_path / "joined.csv")
    spectrum_read = read_spectrum(tmp_path / "joined.csv")
    assert spectrum_read.names == names
    assert np.array_equal(spectrum_read.contribution, spectra[0].contribution, equal_nan=True)
    assert is_spectrum_file(tmp_path / "joined.csv")


def test_spectrum_file_of_scans_with_number_signs_in_their_names_is_read(tmp_path):
    for side in ("upper", "lower"):
        scan = self_affine_surface(1, hurst_exponent=0.8, rms=0.1, shape=(64, 64), spacing=0.01, side=side)
        write_surface(scan, tmp_path / f"{side}#1, new.csv")
    files = ("upper#1, new.csv", "lower#1, new.csv")
    check_stiction("characterise", *files, "--together", "-o", "j.csv", cwd=tmp_path)
    assert read_spectrum(tmp_path / "j.csv").names == files


def test_checksum_of_a_spectrum_depends_on_all_digits_of_its_wave_numbers(spectra):
    other_spectrum = replace(spectra[0], wave_number=spectra[0].wave_number * (1 + 1e-12))
    assert other_spectrum.history == spectra[0].history
    checksums = {MeasuredBodySettings.from_body(spectrum, "first").sha256 for spectrum in (spectra[0], other_spectrum)}
    assert len(checksums) == 2


def test_pair_command_accepts_a_spectrum_from_a_table_without_metadata(tmp_path):
    wave_numbers = np.geomspace(1.0, 30.0, 8)
    rows = "".join(f"{wave_number!r},{1e-4 * wave_number**-3.6!r}\n" for wave_number in wave_numbers.tolist())
    (tmp_path / "table.csv").write_text("wave number (1/um),C2D (um4)\n" + rows)
    spectrum = read_spectrum(tmp_path / "table.csv")
    assert isinstance(spectrum, JoinedSpectrum)
    assert spectrum.disagreement.size == 0
    body = spectrum.surface(1, shape=(64, 64), spacing=0.06)
    assert body.history[0].startswith("power spectrum at wavelengths of ")
    elastic_options = MATERIAL_OPTIONS | {"hardness": None, "mechanics": "asperities"}
    result = pair(spectrum, spectrum, **elastic_options, **TWO_DIRECTION_OPTIONS, surrogates=2)
    assert result.assessment in ("Quote it", "Quote with care", "Do not quote")


@pytest.mark.parametrize(
    ("text", "expected_message"),
    [
        ("wave number (1/um),C2D (um4)\n1,1\n2,1\n3,1\n", "is not an increasing geometric sequence"),
        ("wave number (1/um),C2D (um4)\n1,1\n", "is not an increasing geometric sequence"),
        ("wave number (1/um),C2D (um4)\n1,1\n2,0\n", "is not above 0"),
        ("wave number (1/um),C2D (um4)\n1,a\n2,b\n", "values that are not numbers"),
        ("wave number,C2D (um4)\n1,1\n2,1\n", "has no column 'wave number"),
        ("# scan: a, from 1 to 2 um, ended by pixels\nwave number (1/um),C2D (um4)\n1,1\n2,1\n", "has no column"),
        ("", "is not a table"),
    ],
)
def test_invalid_spectrum_files_are_rejected(tmp_path, text, expected_message):
    (tmp_path / "bad.csv").write_text(text)
    with pytest.raises(ValueError, match=expected_message):
        read_spectrum(tmp_path / "bad.csv")
    with pytest.raises(ValueError, match="cannot be read"):
        read_spectrum(tmp_path / "none.csv")
