"""Tests of `stiction pair` with joined spectra instead of scans."""

import json

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
from stiction.studies.resolution import evaluate_cutoffs
from stiction.studies.store import open_stored
from stiction.surfaces.pairing import SpectrumPairs
from stiction.views.resolution import resolution_limits
from support.command import assert_rejected, call_stiction, check_stiction

SPACING, POINTS = 0.02, 256
MATERIAL = {"effective_modulus": "100 GPa", "hardness": "4 GPa", "mu0": 0.2, "tau0": "200 MPa", "load": "20 MPa"}
QUICK = {"direction": [0.0, 90.0], "onset": 0}
OPTIONS = [
    "--effective-modulus", "100 GPa", "--hardness", "4 GPa", "--mu0", "0.2", "--tau0", "200 MPa", "--load", "20 MPa",
    "--direction", "0,90", "--onset", "0",
]  # fmt: skip
SIDES = ("upper", "lower")


def whole(side):
    return self_affine_surface(
        11, hurst_exponent=0.8, rms=0.02, shape=(POINTS, POINTS), spacing=SPACING, side=side,
        longest_wavelength=1.28, shortest_wavelength=8 * SPACING,
    )  # fmt: skip


def seen(surface):
    """Scans by a microscope with large pixels, and of four pieces by a probe."""
    pixels = surface.heights.reshape(POINTS // 4, 4, POINTS // 4, 4).mean((1, 3))
    half = POINTS // 2
    pieces = [surface.heights[row : row + half, column : column + half] for row in (0, half) for column in (0, half)]
    return [Surface(pixels, spacing=4 * SPACING), *(Surface(piece, spacing=SPACING) for piece in pieces)]


@pytest.fixture(scope="module")
def surfaces():
    return [whole(side) for side in SIDES]


@pytest.fixture(scope="module")
def spectra(surfaces):
    return [joined_spectrum([levelled(scan, "plane") for scan in seen(surface)]) for surface in surfaces]


@pytest.fixture(scope="module")
def where(tmp_path_factory, surfaces, spectra):
    folder = tmp_path_factory.mktemp("spectra")
    for side, surface, spectrum in zip(SIDES, surfaces, spectra, strict=True):
        write_spectrum(spectrum, folder / f"{side}.csv")
        write_surface(surface, folder / f"{side}.npy")
    return folder


# ---- What is pressed ------------------------------------------------------------------------------------------------


def test_members_have_both_spectra_and_are_equal_over_cutoffs(spectra):
    pairs = SpectrumPairs(*spectra)
    assert pairs.spacing[0] == pytest.approx(min(item.shortest for item in spectra) / 4)
    assert pairs.shape[0] * 4 == pytest.approx(3 * pairs.side / pairs.spacing[0], abs=4)
    slopes = [
        [float(scale_dependent_roughness(body).gradient_at(0.3)) for body in pairs.surrogates(index)]
        for index in range(6)
    ]
    expected = [float(item.roughness().gradient_at(0.3)) for item in spectra]
    assert np.mean(slopes, axis=0) == pytest.approx(expected, rel=0.1)
    coarser = SpectrumPairs(*spectra, cut_off=(0.4, 0.4))
    assert coarser.spacing == pairs.spacing
    size = round(pairs.side / pairs.spacing[0])
    created = spectra[1].surface(2016, shape=(size, size), spacing=pairs.spacing, repetition=3)
    rows, columns = pairs.shape
    piece = Surface(cut_off(created, 0.4, periodic=True).heights[:rows, :columns], spacing=pairs.spacing)
    assert np.array_equal(coarser.surrogates(3)[1].heights, levelled(piece, "plane").heights)
    # With a cut-off that is the finest, points are further apart and the surface is larger.
    assert SpectrumPairs(*spectra, cut_off=(0.4, 0.4), finest=0.4).spacing[0] == pytest.approx(0.1)


def test_joined_spectrum_gives_friction_of_the_whole_surface(spectra, surfaces):
    elastic = {name: value for name, value in MATERIAL.items() if name != "hardness"} | {"load": "200 MPa"}
    message = pair(*spectra, surrogates=8, **elastic, **QUICK)
    known = pair(*surfaces, shifts=8, **elastic, **QUICK)
    coarse = pair(*(seen(surface)[0] for surface in surfaces), shifts=8, **elastic, **QUICK)
    for quantity in ("friction_all_round", "contact_area_fraction"):
        values = []
        for result in (message, known, coarse):
            one = result.at()[quantity].squeeze()
            one = one.sel(sliding="all") if "sliding" in one.dims else one
            values.append([float(one.sel(statistic=item)) for item in ("mean", "lower", "upper")])
        (mean, low, high), (truth, *_), (missed, *_) = values
        assert low < truth < high
    assert abs(missed - truth) > 2 * abs(mean - truth)  # of the area, which the fine waves decide


def test_pair_of_spectra_supports_all_commands(where):
    completed = check_stiction(
        "pair", "upper.csv", "lower.csv", *OPTIONS, "--surrogates", "2", "--json", cwd=where, without_figures=True
    )
    record = json.loads(completed.stdout)
    study = Study.from_toml(where / "pair" / "study.toml")
    assert study.surfaces.press == "surrogates"
    assert study.surfaces.upper.sha256 is not None
    assert study.ensemble.repetitions == 2
    check_stiction("at", "pair", "--load", "30 MPa", cwd=where)
    check_stiction("report", "pair", cwd=where, without_figures=True)
    at_cut_offs = evaluate_cutoffs(open_stored(where / "pair")).isel(load=0, mu0=0, tau0=0)
    closed = resolution_limits(at_cut_offs, study)["spectral"]  # what the picture over cut-offs draws beside
    assert float(closed.mean_pressure.max()) == pytest.approx(4.0)
    assert float(closed.wavelength.max()) > 1.0
    over = [item["cut_off"] for item in record["resolution"]["cut_offs"]]
    assert over[1] == pytest.approx(read_spectrum(where / "upper.csv").shortest, rel=1e-3)


def test_pair_accepts_spectrum_and_scan(where, surfaces, spectra):
    command = ["pair", "upper.csv", "lower.npy", *OPTIONS, "--surrogates", "2", "--output", "mixed"]
    check_stiction(*command, cwd=where, without_figures=True)
    changed = where / "changed"
    changed.mkdir()
    for name in ("upper.csv", "lower.csv"):
        (changed / name).write_bytes((where / name).read_bytes())
    command = ["pair", "upper.csv", "lower.csv", *OPTIONS, "--surrogates", "2"]
    check_stiction(*command, cwd=changed, without_figures=True)
    (changed / "upper.csv").write_bytes((where / "lower.csv").read_bytes())
    assert_rejected(call_stiction("run", "pair", "--set", "ensemble.repetitions=3", cwd=changed), "has changed since")


REFUSED = ["--output", "refused"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["pair", "upper.csv", "lower.csv", *OPTIONS, "--lines", "4", *REFUSED], "--lines"),
        (["pair", "upper.csv", "lower.csv", *OPTIONS, "--shifts", "4", *REFUSED], "--shifts"),
        (["pair", "upper.csv", "lower.csv", *OPTIONS, "--unit", "um", *REFUSED], "has no unit"),
        (["pair", "upper.csv", "lower.csv", *OPTIONS, "--cutoff", "3 um", *REFUSED], "rows and columns are required"),
        (["characterise", "upper.csv", "--output", "refused.html"], "is a spectrum of several scans"),
    ],
)
def test_pair_of_spectra_rejects_options_of_scans(where, arguments, message):
    assert_rejected(call_stiction(*arguments, cwd=where), message)


# ---- The file -------------------------------------------------------------------------------------------------------


def test_spectrum_file_preserves_every_bit(spectra, tmp_path):
    write_spectrum(spectra[0], tmp_path / "joined.csv")
    again = read_spectrum(tmp_path / "joined.csv")
    for name in ("wave_number", "density", "count", "contribution", "ratio"):
        assert np.array_equal(getattr(again, name), getattr(spectra[0], name), equal_nan=True)
    assert (again.bands, again.reasons, again.names) == (spectra[0].bands, spectra[0].reasons, spectra[0].names)
    assert again.history == spectra[0].history
    with pytest.raises(ValueError, match="exists already"):
        write_spectrum(again, tmp_path / "joined.csv")
    with pytest.raises(ValueError, match=r"must end in \.csv"):
        write_spectrum(again, tmp_path / "joined.txt")
    with pytest.raises(ValueError, match="must be a JoinedSpectrum"):
        write_spectrum("joined", tmp_path / "other.csv")


def test_pair_accepts_spectrum_without_scans(tmp_path):
    q = np.geomspace(1.0, 30.0, 8)
    rows = "".join(f"{each!r},{1e-4 * each**-3.6!r}\n" for each in q.tolist())
    (tmp_path / "table.csv").write_text("wave number (1/um),C2D (um4)\n" + rows)
    spectrum = read_spectrum(tmp_path / "table.csv")
    assert isinstance(spectrum, JoinedSpectrum)
    assert spectrum.disagreement.size == 0
    body = spectrum.surface(1, shape=(64, 64), spacing=0.06)
    assert "of waves" in body.history[0]
    elastic = MATERIAL | {"hardness": None, "mechanics": "asperities"}
    result = pair(spectrum, spectrum, **elastic, **QUICK, surrogates=2)
    assert result.verdict in ("Quote it", "Quote with care", "Do not quote")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("wave number (1/um),C2D (um4)\n1,1\n2,1\n3,1\n", "must rise in equal ratios"),
        ("wave number (1/um),C2D (um4)\n1,1\n", "must rise in equal ratios"),
        ("wave number (1/um),C2D (um4)\n1,1\n2,0\n", "must be above 0"),
        ("wave number (1/um),C2D (um4)\n1,a\n2,b\n", "other values than numbers"),
        ("wave number,C2D (um4)\n1,1\n2,1\n", "has no column 'wave number"),
        ("# scan: a, from 1 to 2 um, ended by pixels\nwave number (1/um),C2D (um4)\n1,1\n2,1\n", "has no column"),
        ("", "is not a table"),
    ],
)
def test_read_spectrum_rejects_bad_file(tmp_path, text, message):
    (tmp_path / "bad.csv").write_text(text)
    with pytest.raises(ValueError, match=message):
        read_spectrum(tmp_path / "bad.csv")
    with pytest.raises(ValueError, match="cannot be read"):
        read_spectrum(tmp_path / "none.csv")
