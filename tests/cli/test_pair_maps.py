"""`stiction pair` of two maps."""

import re

import numpy as np
import pytest
import xarray
from command import assert_refused, stiction_command
from matplotlib.testing.compare import compare_images
from stiction import (
    Profile,
    levelled,
    pressed_maps,
    pressed_maps_mean,
    self_affine_surface,
    turned_over,
    write_profile,
    write_surface,
)
from stiction.studies.map_pair import overlap_area

MAPS = ["upper.npy", "lower.npy", "--unit", "um", "--spacing", "0.1 um"]
MATERIAL = ["--effective-modulus", "10 GPa", "--mu0", "0.3", "--tau0", "50 MPa", "--load", "10 MPa"]
FAST = ["--shifts", "3", "--mechanics", "asperities"]


def scan(side, points=64):
    return self_affine_surface(
        3, hurst_exponent=0.8, rms=0.02, shape=(points, points), spacing=0.1, longest_wavelength=3.2,
        shortest_wavelength=0.4, side=side,
    )  # fmt: skip


@pytest.fixture(scope="module")
def where(tmp_path_factory):
    folder = tmp_path_factory.mktemp("maps")
    for side in ("upper", "lower"):
        write_surface(scan(side), folder / f"{side}.npy")
    write_profile(Profile(scan("upper").heights[0], spacing=0.1), folder / "line.csv")
    return folder


@pytest.fixture(scope="module")
def checked(where):
    done = stiction_command("pair", *MAPS, *MATERIAL, "--check", "--shifts", 4, cwd=where)
    assert done.returncode == 0, done.stderr
    return done


def numbers(text, title):
    """Of the first row with a title."""
    line = next(line for line in text.splitlines() if line.startswith(title))
    return [float(word) for word in re.findall(r"-?\d+\.?\d*(?:e[+-]?\d+)?", line.removeprefix(title).split(" at ")[0])]


def test_the_table_is_that_of_the_library(where, checked):
    upper, lower = turned_over(levelled(scan("upper"), "plane")), levelled(scan("lower"), "plane")
    load = 0.01 * overlap_area(upper, lower)
    for column, mechanics in enumerate(("half-space", "asperities")):
        chosen = {"mu0": 0.3, "tau0": 0.05, "shifts": 4, "mechanics": mechanics}
        result = pressed_maps(upper, lower, [load], **chosen)
        mean = pressed_maps_mean(result).isel(load=0, mu0=0, tau0=0)
        rows = {
            "true area A/A0 (%)": 100 * mean["contact_area_fraction"],
            "contacts  ": mean["contact_count"],
            "normal stiffness (mN/µm)": mean["normal_stiffness"],
            "approach (nm)": 1000 * mean["approach"],
            "  mu_s to +x": mean["friction_coefficient"].sel(sliding="opposing", direction=0.0),
            "  mu_s to +y": mean["friction_coefficient"].sel(sliding="opposing", direction=90.0),
        }
        for title, wanted in rows.items():
            printed = numbers(checked.stdout, title)[3 * column : 3 * column + 3]
            half_width = float(wanted[2] - wanted[1]) / 2
            # Two digits of half the interval are printed; solutions at several loads begin differently.
            assert np.abs(printed - wanted.values).max() <= 0.0502 * half_width + 1e-4 * abs(wanted[0]), title
        with xarray.open_dataset(where / "pair" / "result.nc", engine="h5netcdf") as stored:
            kept = stored.sel(mechanics=mechanics).sel(load=[load], method="nearest")
            for name in ("friction_coefficient", "contact_area", "gentle_friction"):
                np.testing.assert_allclose(kept[name].values, result[name].values, rtol=1e-4, err_msg=name)


def test_it_says_what_was_pressed_and_how_far_to_trust_it(checked):
    text = checked.stdout
    for words in (
        "4 shifts, each 48 x 48 points, 4.8 x 4.8 µm",
        "at 10 MPa, 0.2304 mN on 23.04 µm²",
        "half-space: the elastic half-space, free at its edges",
        "the others do not (the paper's rule)",
        "all contacts rub",
        "largest around the compass",
        "by its slope alone (gentle_friction)",
        "half-space: solved to an error of",
        "of the load is on ellipses that overlap",
        "Intervals are over 4 shifts of these two maps",
        "In short: at 10 MPa",
    ):
        assert words in text, text
    assert [line.split("/")[-1] for line in text.splitlines()[-5:]] == [
        "result.csv", "compass.png", "friction.png", "sizes.png", "contacts.png",
    ]  # fmt: skip
    assert re.search(r"half-space: 12 solutions of 48 x 48 points, about .* s by the first", checked.stderr)


def test_the_csv_has_a_row_for_each_direction_and_rule(where, checked):
    rows = [line.split(",") for line in (where / "pair" / "result.csv").read_text().splitlines()]
    assert len(rows) == 1 + 2 * 2 * 12
    assert len({len(row) for row in rows}) == 1
    assert rows[1][:7] == ["0.2304", "half-space", "opposing", "0.3", "50", "0", "4"]


def test_it_is_shown_and_drawn_again(where, checked):
    shown = stiction_command("info", "pair", cwd=where)
    assert shown.returncode == 0, shown.stderr
    assert numbers(shown.stdout, "  mu_s to +x") == numbers(checked.stdout, "  mu_s to +x")
    drawn = stiction_command("plot", "pair", "-o", "again", cwd=where)
    assert drawn.returncode == 0, drawn.stderr
    names = {path.name for path in (where / "again").iterdir()}
    assert names == {"compass.png", "friction.png", "sizes.png", "contacts.png"}
    for name in names:
        assert compare_images(where / "pair" / name, where / "again" / name, tol=0) is None


def test_options_reach_the_pressing(where):
    done = stiction_command(
        "pair", *MAPS, *MATERIAL, "--mu0", "0.3,0.4", "--direction", "45,225", "--rotate", "20", "--level", "quadratic",
        *FAST, "-o", "options", cwd=where,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    for words in (
        "rotated by 20 degrees", "polynomial of second degree", "mu_s at 45°", "mu_s at 225°",
        "mu0 = 0.4, tau0 = 50 MPa", "cropped to its first",
    ):  # fmt: skip
        assert words in done.stdout, done.stdout
    assert "compass" not in done.stdout.split("wrote")[0].split("In short")[0]


def test_a_hardness_caps_the_pressure(where):
    done = stiction_command(
        "pair", *MAPS, *MATERIAL, "--hardness", "200 MPa", "--shifts", "2", "--direction", "0", "-o", "hard", cwd=where
    )
    assert done.returncode == 0, done.stderr
    assert "pressures up to a hardness of 0.2 GPa" in done.stdout
    assert "% of the load is where the pressure is the hardness" in done.stdout
    assert "no interval" in done.stdout


@pytest.mark.usefixtures("undrawn")
def test_maps_of_two_spacings_are_brought_to_one(where):
    write_surface(scan("lower", points=48), where / "short.npy")
    done = stiction_command("pair", "upper.npy", "short.npy", *MAPS[2:], *MATERIAL, *FAST, "-o", "short", cwd=where)
    assert done.returncode == 0, done.stderr
    assert "cropped to its first 48 rows of 48 points" in done.stdout
    assert "36 x 36 points" in done.stdout


def test_surrogates_stand_beside_the_shifts(where):
    done = stiction_command("pair", *MAPS, *MATERIAL, *FAST, "--surrogates", "4", "-o", "kind", cwd=where)
    assert done.returncode == 0, done.stderr
    for words in (
        "asperities (surrogates)", "Intervals are over 3 shifts of these two maps",
        "Those of surrogates are over 4 independent pairs of surfaces with these spectra",
        "surrogates 4 pairs with the spectra of both, new phases, seed 2016, of the same size",
    ):  # fmt: skip
        assert words in done.stdout, done.stdout
    rows = (where / "kind" / "result.csv").read_text().splitlines()
    assert len(rows) == 1 + 2 * 2 * 12


def test_profiles_of_isotropic_surfaces_are_pressed_as_areas(where):
    line = ["line.csv", "line.csv", *MATERIAL]
    done = stiction_command(
        "pair", *line, "--lay", "isotropic", "--mechanics", "asperities", "--surrogates", "3", "-o", "iso", cwd=where
    )
    assert done.returncode == 0, done.stderr
    assert "surrogates 3 pairs with the spectra of both, isotropic surfaces, seed 2016, each 48 x 48" in done.stdout
    assert "shifts of these two maps" not in done.stdout
    assert (where / "iso" / "contacts.png").exists()
    grooves = stiction_command("pair", *line, "--lay", "grooves", "--offsets", "8", "-o", "grooves", cwd=where)
    assert grooves.returncode == 0, grooves.stderr
    assert "hertz-cylinder" in grooves.stdout
    assert "MPa of nominal pressure" in grooves.stdout
    assert "Spheres on a strip" not in grooves.stdout
    plain = stiction_command("pair", *line, "--offsets", "8", "-o", "plain", cwd=where)
    assert plain.stdout.count("Spheres on a strip 1 µm thick") == 1
    assert "nominal" not in plain.stdout


def test_each_material_has_its_figures(where):
    done = stiction_command("pair", *MAPS, *MATERIAL, "--mu0", "0.3,0.4", *FAST, "-o", "two", cwd=where)
    assert done.returncode == 0, done.stderr
    names = {path.name for path in (where / "two").glob("*.png")}
    assert {"compass.png", "compass-2.png", "friction.png", "friction-2.png"} <= names


@pytest.mark.usefixtures("undrawn")
def test_lines_of_maps_are_pressed_when_asked_for(where):
    done = stiction_command("pair", *MAPS, *MATERIAL, "--lines", "3", "-o", "lines", cwd=where)
    assert done.returncode == 0, done.stderr
    assert "3: 3 pairs of lines" in done.stdout


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ([*MAPS, "--along", "y"], ["--along is for lines; give --lines as well"]),
        ([*MAPS, "--surrogates", "lower"], ["--surrogates of areas must be a number of pairs"]),
        ([*MAPS, "--lay", "isotropic"], ["--lay is for two profiles"]),
        (["line.csv", "line.csv", "--lay", "round"], ["--lay must be grooves or isotropic"]),
        (["line.csv", "line.csv", "--lay", "isotropic", "--shifts", "3"], ["--shifts is for maps"]),
        (["line.csv", "line.csv", "--lay", "isotropic", "--offsets", "3"], ["--offsets is for --lay grooves"]),
        (["line.csv", "line.csv", "--lay", "grooves", "--law", "hertz-sphere"], ["--lay grooves presses cylinders"]),
        ([*MAPS, "--law", "hertz-cylinder"], ["--law is for lines"]),
        ([*MAPS, "--offsets", "3"], ["--offsets is for lines"]),
        ([*MAPS, "--curvature", "convex"], ["--curvature is for lines"]),
        ([*MAPS, "--lines", "3", "--check", "--shifts", "2"], ["--shifts is for the areas of two maps"]),
        ([*MAPS, "--lines", "3", "--mechanics", "exact"], ["--mechanics must be half-space or asperities"]),
        (["line.csv", "line.csv", "--shifts", "3"], ["--shifts is for the areas of two maps"]),
        (["line.csv", "line.csv", "--direction", "3"], ["--direction is for the areas of two maps"]),
        ([*MAPS, "--mechanics", "springs"], ["--mechanics must be half-space or asperities"]),
        ([*MAPS, "--check", "--mechanics", "asperities"], ["--check presses by both"]),
        ([*MAPS, "--check", "--hardness", "1 GPa"], ["--hardness is for the half-space alone"]),
        ([*MAPS, "--hardness", "5 MPa"], ["--load must be below the hardness times the area"]),
        ([*MAPS, "--level", "line"], ["--level of maps must be plane or quadratic"]),
        ([*MAPS, "--direction", "north"], ["--direction must be a number or several"]),
        ([*MAPS, "--direction", "0,360"], ["directions must be one or several different angles"]),
        ([*MAPS, "--shifts", "100000"], ["shifts must be fewer"]),
    ],
)
def test_bad_options(where, arguments, words):
    done = stiction_command("pair", *arguments, *MATERIAL, "-o", "bad", cwd=where)
    assert_refused(done, *words)
    assert not (where / "bad" / "result.nc").exists()
