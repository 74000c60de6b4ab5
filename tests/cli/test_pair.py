"""`stiction pair`, from files to figures."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
import xarray
from command import assert_refused, stiction_command
from stiction import (
    Profile,
    Surface,
    cropped,
    effective_modulus,
    levelled,
    paired_lines,
    read_profile,
    self_affine,
    traverse,
    traverse_mean,
    turned_over,
    write_profile,
    write_surface,
)
from stiction.views.traverse import _cell, doubts, load_figure, means

MATERIAL = ["--effective-modulus", "10 GPa", "--mu0", "0.3", "--tau0", "100 MPa", "--load", "20 uN"]


def scan(side, repetition=0, points=2000):
    return self_affine(
        8, hurst_exponent=0.8, rms=0.03, points=points, spacing=0.01, shortest_wavelength=0.2, longest_wavelength=3.0,
        side=side, repetition=repetition,
    )  # fmt: skip


@pytest.fixture(scope="module")
def where(tmp_path_factory):
    folder = tmp_path_factory.mktemp("pair")
    write_profile(scan("upper"), folder / "upper.csv")
    write_profile(scan("lower"), folder / "lower.csv")
    write_profile(scan("lower"), folder / "lower.npy")
    lines = np.array([scan("lower", line, points=300).heights for line in range(6)])
    write_surface(Surface(lines, spacing=0.01), folder / "map.npy")
    (folder / "empty.csv").write_text("")
    (folder / "file").write_text("")
    return folder


@pytest.fixture(scope="module")
def paired(where):
    done = stiction_command("pair", "upper.csv", "lower.csv", *MATERIAL, "--load", "0.1 mN", cwd=where)
    assert done.returncode == 0, done.stderr
    return done


def row(text, title, load="0.02"):
    """Numbers of a row of the table at a load."""
    block = text.split(f"at F_N = {load} mN")[1].split("\n\n")[0]
    line = next(line for line in block.splitlines() if line.startswith(title))
    return [float(word.strip("[],")) for word in line.removeprefix(title).split()]


def test_the_table_is_that_of_the_library_on_the_profiles_in_memory(where, paired):
    upper, lower = (levelled(scan(side), "line") for side in ("upper", "lower"))
    slider = levelled(cropped(turned_over(upper), 0.0, 10.0), "line")
    result = traverse(
        slider, lower, [0.02, 0.1], mu0=0.3, tau0=0.1, effective_modulus=10.0, offsets=10.0 * np.arange(1, 65) / 64
    )
    mean = means(result)
    for load in ("0.02", "0.1"):
        for name, title, factor in (
            ("friction_coefficient", "friction coefficient", 1),
            ("contact_area", "true contact area (µm²)", 1),
            ("contact_count", "contacts", 1),
            ("normal_stiffness", "normal stiffness (mN/µm)", 1),
            ("approach", "approach (nm)", 1000),
        ):
            wanted = factor * mean[name].sel(load=float(load)).transpose("shear", "statistic").values
            printed = np.reshape(row(paired.stdout, title, load), wanted.shape)
            half_width = (wanted[:, 2] - wanted[:, 1]) / 2
            last = np.maximum(0.05001 * half_width, 5.001e-4 * np.abs(wanted[:, 0]))  # two digits of it, four at most
            assert (np.abs(printed - wanted) <= last[:, np.newaxis]).all()
    with xarray.open_dataset(where / "pair" / "result.nc", engine="h5netcdf") as stored:
        assert stored["load"].values[[0, -1]] == pytest.approx([0.02 / 30, 0.1 * 30])
        kept = stored.sel(load=[0.02, 0.1])
        for name in ("friction_coefficient", "contact_area", "approach", "status"):
            np.testing.assert_array_equal(kept[name].values, result[name].values, err_msg=name)


def test_it_says_what_was_paired_and_how(paired):
    text = paired.stdout
    for words in (
        "read from upper.csv",
        "turned over; cropped to 0 to 10 µm",
        "64 offsets (0.16 to 10 µm)",
        "slider       10 µm long, 1 µm thick",
        "E* = 10 GPa, mu0 = 0.3, tau0 = 100 MPa, hertz-sphere, gap-minimum, convex",
        "64 of 64",
        "load that opposes",
        "rub nothing (the paper's rule)",
    ):
        assert words in text, text
    assert text.splitlines()[-5:] == [
        f"wrote {Path('pair') / name}"
        for name in ("result.nc", "result.csv", "friction.png", "positions.png", "contact.png")
    ]


@pytest.mark.usefixtures("undrawn")
def test_numbers_from_npy_are_those_from_csv(where, paired):
    given = ["--unit", "um", "--spacing", "0.01 um"]
    done = stiction_command("pair", "upper.csv", "lower.npy", *MATERIAL, *given, "-o", "npy", cwd=where)
    assert done.returncode == 0, done.stderr
    for title in ("friction coefficient", "true contact area (µm²)"):
        assert row(done.stdout, title) == row(paired.stdout, title)


def test_options_reach_the_model(where):
    done = stiction_command(
        "pair", "map.npy", "upper.csv", *MATERIAL, "--unit", "um", "--spacing", "0.01 um", "--lines", 3, "--offsets", 2,
        "--travel", "1 um", "--level", "mean", "--law", "hertz-cylinder", "--detection", "cell",
        "--curvature", "signed", "--surrogates", "lower", "--seed", 4, "--output", "deep/er", cwd=where,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    for words in ("6: 3 pairs of lines, 2 offsets", "levelled by the mean", "hertz-cylinder, cell, signed", "seed 4"):
        assert words in done.stdout, done.stdout
    assert (where / "deep/er/contact.png").exists()


def test_an_endless_interval_does_not_hide_the_means():
    result = traverse([scan("upper")] * 2, [scan("lower")] * 2, [0.01, 0.1], mu0=0.3)
    mean = traverse_mean(result)
    mean["friction_coefficient"].loc[{"statistic": "upper"}] = 1e14
    mean["friction_coefficient"].loc[{"statistic": "lower"}] = 0.0
    highest = float(mean["friction_coefficient"].sel(statistic="mean").max())
    assert highest < load_figure(mean, [0.01]).axes[0].get_ylim()[1] <= 4 * highest


@pytest.mark.usefixtures("undrawn")
def test_lines_on_a_long_profile_lie_all_over_it(where):
    given = ["--unit", "um", "--unit", "um", "--spacing", "0.01 um"]
    done = stiction_command("pair", "map.npy", "lower.csv", *MATERIAL, *given, "-o", "long", cwd=where)
    assert done.returncode == 0, done.stderr
    assert "6: 6 pairs of lines, 1 offset (0 µm)" in done.stdout
    assert "no interval" in done.stdout  # of six


ADVICE = ("  below-range: ", "  not-reached: ", "  self-locked: ", "  no-contact: ")


def test_columns_stay_apart_and_most_positions_must_have_an_answer(where):
    given = ["--unit", "um", "--spacing", "0.01 um", "--load", "1e-6 nN", "--load", "1 N"]
    done = stiction_command("pair", "map.npy", "map.npy", "--lines", 6, *MATERIAL, *given, "-o", "light", cwd=where)
    assert done.returncode == 0, done.stderr
    for block in (block for block in done.stdout.split("\n\n") if block.startswith("at F_N")):
        rows = [line for line in block.splitlines()[2:] if not line.startswith(("wrote", "no mean", *ADVICE))]
        assert all(len(re.split(r" {2,}", row.strip())) == 4 for row in rows), block
        few = any(int(answer) < 3 for answer in re.findall(r"(\d) of 6", block))
        assert few == ("no mean where fewer" in block)
    assert done.stdout.count("no mean where fewer") >= 1


def test_the_spread_of_the_positions_is_told(where, paired):
    with xarray.open_dataset(where / "pair" / "result.nc", engine="h5netcdf") as stored:
        values = stored["friction_coefficient"].sel(load=0.02, shear="+x").values
    line = next(line for line in paired.stdout.splitlines() if line.startswith("  four of five positions"))
    lowest, _, highest = line.split("positions")[1].split()[3:6]  # of +x, after both
    np.testing.assert_allclose(
        [float(lowest), float(highest)], np.quantile(values, [0.1, 0.9]), rtol=5e-3
    )  # three digits


def test_lines_of_a_map_with_itself(where):
    done = stiction_command(
        "pair", "map.npy", "map.npy", "--lines", 6, *MATERIAL, "--unit", "um", "--spacing", "0.01 um", "--load", "1 N",
        "-o", "self", cwd=where,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "6: 6 pairs of lines, 1 offset (0 µm)" in done.stdout
    assert "none of the positions has an answer: not-reached" in done.stdout
    assert "is it the load of a whole part?" in done.stderr


def test_a_result_is_not_written_over(where, paired):
    assert_refused(
        stiction_command("pair", "upper.csv", "lower.csv", *MATERIAL, cwd=where),
        "result.nc: exists already",
        "--replace",
        "--output",
    )


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["none.csv", "lower.csv"], ["none.csv", "cannot be read"]),
        (["upper.csv", "empty.csv"], ["empty.csv"]),
        (["map.npy", "lower.csv"], ["map.npy", "unit"]),
        (["upper.csv", "lower.csv", "--unit", "mm"], ["upper.csv", "unit says mm"]),
        (["upper.csv", "lower.csv", "--unit", "um", "--unit", "nm"], ["lower.csv", "unit says nm"]),
        (["upper.csv", "lower.csv", "--unit", "um", "--unit", "um", "--unit", "um"], ["--unit", "got 3"]),
        (["upper.csv", "lower.csv", "--load", "3"], ["--load", "number unit"]),
        (["upper.csv", "lower.csv", "--output", "out.pdf"], ["out.pdf", "name of a file"]),
        (["upper.csv", "lower.csv", "--lines", "4"], ["--lines is for surfaces and surrogates"]),
        (["upper.csv", "lower.csv", "--along", "y"], ["--along is for surfaces"]),
        (["upper.csv", "lower.csv", "--seed", "3"], ["--seed is for --surrogates"]),
        (["upper.csv", "lower.csv", "--poisson", "0.3"], ["--poisson is for --young"]),
        (["upper.csv", "lower.csv", "--hardness", "3 GPa"], ["--hardness is for --law jackson-green"]),
        (["upper.csv", "lower.csv", "--young", "200 GPa"], ["--effective-modulus, or --young", "not both"]),
        (["upper.csv", "lower.csv", "--law", "jackson-green"], ["--yield-strength or --hardness"]),
        (["upper.csv", "lower.csv", "--law", "jackson-green", "--hardness", "3 GPa"], ["needs --poisson"]),
        (["upper.csv", "lower.csv", "--load", "-1 mN"], ["--load must be above 0"]),
        (["upper.csv", "lower.csv", "--effective-modulus", "10 mN"], ["--effective-modulus", "pressure"]),
        (["upper.csv", "lower.csv", "--tau0", "1"], ["--tau0"]),
        (["upper.csv", "lower.csv", "--mu0", "-1"], ["--mu0 must be at least 0"]),
        (["upper.csv", "lower.csv", "--mu0", "nan"], ["mu0 must be"]),
        (["upper.csv", "lower.csv", "--travel", "19 um"], ["travel must be from 0 to 10"]),
        (["upper.csv", "lower.csv", "--travel", "0 um", "--offsets", "3"], ["--offsets 3 needs a --travel"]),
        (["upper.csv", "lower.csv", "--offsets", "0"], ["--offsets"]),
        (["upper.csv", "lower.csv", "--offsets", "5000"], ["at least a spacing apart"]),
        (["upper.csv", "lower.csv", "--law", "hooke"], ["law must be"]),
        (["upper.csv", "lower.csv", "--detection", "eye"], ["detection must be"]),
        (["upper.csv", "lower.csv", "--level", "plane"], ["level must be"]),
        (["upper.csv", "lower.csv", "--output", "file"], ["file: cannot be written"]),
        (["upper.csv", "lower.csv", "--output", "file/deeper"], ["cannot be written"]),
    ],
)
def test_bad_input_is_one_message_and_status_2(where, arguments, words):
    done = stiction_command("pair", *MATERIAL, "--output", "bad", *arguments, cwd=where)
    assert_refused(done, *words)


def test_an_interruption_is_one_line_and_leaves_no_result(where, monkeypatch):
    def interrupted(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr("stiction.studies.traverse.crossing", interrupted)
    done = stiction_command("pair", "upper.csv", "lower.csv", *MATERIAL, "-o", "halfway", cwd=where)
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "stiction: interrupted\n")
    assert list((where / "halfway").iterdir()) == []


BODIES = ["pair", "upper.csv", "lower.csv", "--offsets", 9]


def test_moduli_pressures_and_several_materials(where):
    given = ["--young", "20 GPa,30 GPa", "--poisson", "0.3,0.2", "--mu0", "0.3,0.5", "--tau0", "0 MPa,50 MPa"]
    done = stiction_command(*BODIES, *given, "--load", "2 MPa", "-o", "several", cwd=where)
    assert done.returncode == 0, done.stderr
    modulus = effective_modulus(20.0, 0.3, 30.0, 0.2)
    assert f"E* = {modulus:g} GPa, mu0 = 0.3, 0.5, tau0 = 0, 50 MPa" in done.stdout
    assert "at F_N = 0.02 mN," in done.stdout  # of 10 µm²
    blocks = done.stdout.split("mu0 = 0.")[2:]
    assert len(blocks) == 4
    with xarray.open_dataset(where / "several" / "result.nc", engine="h5netcdf") as kept:
        mean = means(kept.load())
    rows = (where / "several" / "result.csv").read_text(encoding="utf-8").splitlines()
    header, *lines = (line.split(",") for line in rows)
    assert header[:4] == ["normal load (mN)", "upper body to", "mu0", "tau0 (MPa)"]
    assert [line[1:4] for line in lines[:4]] == [[way, "0.3", "0"] for way in ("both", "+x", "-x")] + [
        ["both", "0.3", "50"]
    ]
    for line in lines:
        at = mean.sel(shear=line[1], mu0=float(line[2]), load=0.02).sel(tau0=float(line[3]) / 1000, method="nearest")
        place = header.index("approach (nm)")
        np.testing.assert_allclose(np.array(line[place : place + 3], float), 1000 * at["approach"], rtol=1e-8)


@pytest.mark.usefixtures("undrawn")
def test_nominal_pressure_is_told_of_cylinders(where):
    given = [*MATERIAL, "--law", "hertz-cylinder", "-o", "cylinders"]
    done = stiction_command(*BODIES, *given, cwd=where)
    assert "a nominal area of 10 µm²" in done.stdout
    assert "(2 MPa of nominal pressure)" in done.stdout


@pytest.mark.usefixtures("undrawn")
def test_hardness_is_yield_strength_in_other_words(where):
    law = [*MATERIAL, "--law", "jackson-green", "--poisson", "0.3"]
    one = stiction_command(*BODIES, *law, "--hardness", "568 MPa", "-o", "hard", cwd=where)
    other = stiction_command(*BODIES, *law, "--yield-strength", "200 MPa", "-o", "yield", cwd=where)
    assert one.returncode == other.returncode == 0, one.stderr + other.stderr
    assert one.stdout.replace("hard/", "yield/").splitlines()[5:] == other.stdout.splitlines()[5:]
    elastic = stiction_command(*BODIES, *MATERIAL, "-o", "elastic", cwd=where)
    assert row(elastic.stdout, "true contact area (µm²)") < row(other.stdout, "true contact area (µm²)")


def test_what_is_seldom_meant_is_said_and_the_run_goes_on(where):
    steep = Profile(1000 * scan("upper").heights, spacing=0.01)
    write_profile(steep, where / "steep.csv")
    given = ["--effective-modulus", "10 GPa", "--mu0", "30", "--load", "20 uN", "-o", "doubts"]
    done = stiction_command("pair", "steep.csv", "lower.csv", "--offsets", 2, *given, cwd=where)
    assert done.returncode == 0, done.stderr
    assert "upper: heights span" in done.stderr
    assert "is their unit right?" in done.stderr
    assert "mu0 = 30 is more than any pair" in done.stderr


def test_a_result_is_replaced_on_demand_and_known_to_the_other_commands(where):
    given = [*MATERIAL, "-o", "again"]
    first = stiction_command(*BODIES, *given, cwd=where)
    again = stiction_command(*BODIES, *given, "--replace", cwd=where)
    assert (again.returncode, again.stdout) == (0, first.stdout), again.stderr
    shown = stiction_command("info", "again", cwd=where)
    assert shown.stdout == first.stdout[: first.stdout.index("wrote")]
    (where / "again" / "friction.png").unlink()
    drawn = stiction_command("plot", "again", cwd=where)
    assert drawn.returncode == 0, drawn.stderr
    assert (where / "again" / "friction.png").exists()
    assert stiction_command("export", "again", "copy.nc", cwd=where).returncode == 0
    with (
        xarray.open_dataset(where / "copy.nc", engine="h5netcdf") as copy,
        xarray.open_dataset(where / "again" / "result.nc", engine="h5netcdf") as kept,
    ):
        assert copy.equals(kept)


def test_digits_are_those_that_the_interval_carries():
    for statistics, text in (
        ([0.1614, 0.0731, 0.3419], "0.16 [0.07, 0.34]"),
        ([0.03136, 0.0279, 0.0348], "0.0314 [0.0279, 0.0348]"),
        ([1421.0, 905.0, 1960.0], "1420 [900, 1960]"),
        ([2.0, np.nan, np.nan], "2 no interval"),
        ([np.nan] * 3, "none"),
    ):
        assert _cell(np.array(statistics), "contact_area") == text


def test_what_is_needed_is_asked_for(where):
    assert_refused(
        stiction_command("pair", "upper.csv", "lower.csv", "--load", "1 mN", "--mu0", "0.3", cwd=where),
        "--effective-modulus",
    )


# ---- Measured data ---------------------------------------------------------------------------------------------------


def test_a_stylus_profile_shifted_along_itself(measured, tmp_path):
    file = measured("dektak-1.csv")
    shifted = ["--travel", "200 um", "--offsets", "1", "--load", "10 mN"]
    done = stiction_command("pair", file, file, *MATERIAL, *shifted, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "slider       1300 µm long" in done.stdout
    assert "1 offset (200" in done.stdout
    coefficient = row(done.stdout.replace("no interval", ""), "friction coefficient", "10")
    assert all(0.2 < value < 0.8 for value in coefficient)


def test_an_afm_map_and_a_surrogate(measured, tmp_path):
    pytest.importorskip("SurfaceTopography")
    file = measured("di-4.di")
    done = stiction_command(
        "pair", file, file, *MATERIAL, "--lines", 128, "--surrogates", "lower", "--along", "y", cwd=tmp_path
    )
    assert done.returncode == 0, done.stderr
    assert "128: 128 pairs of lines" in done.stdout
    assert "column 0" in done.stdout


def test_form_and_spikes_of_a_profile_are_said(measured):
    profile = self_affine(1, hurst_exponent=0.8, rms=0.05, points=4000, spacing=0.1, longest_wavelength=40.0)

    def said(body):
        return doubts([body], [profile], [0.1], mu0=[0.3], effective_modulus=10.0)

    assert said(profile) == []
    bowed = Profile(profile.heights + 1e-5 * (profile.x - 200) ** 2, spacing=0.1)
    assert len(said(bowed)) == 1
    assert "a parabola is" in said(bowed)[0]
    spiky = profile.heights.copy()
    spiky[1000] += 0.2
    assert "3 points bend more than 12 times" in said(Profile(spiky, spacing=0.1))[0]
    stylus = said(levelled(read_profile(measured("dektak-1.csv")), "line"))
    assert [words in one for words, one in zip(("a parabola is 83 %", "33 points"), stylus, strict=True)] == [
        True,
        True,
    ]


def test_half_planes_beside_asperities(where):
    given = [*BODIES, *MATERIAL, "--lay", "grooves"]
    done = stiction_command(*given, "--check", "-o", "checked", cwd=where)
    assert done.returncode == 0, done.stderr
    assert re.search(r"half-planes: 63 solutions of 1000 points, about .* s by the first position", done.stderr)
    assert "elastic half-planes; beside them hertz-cylinder" in done.stdout
    assert "half-planes, both directions  asperities, both directions" in done.stdout
    assert re.search(r"\napproach \(nm\) +none +\d", done.stdout)
    assert "Half-planes have no approach and no stiffness" in done.stdout
    assert "In short, by half-planes: at 0.02 mN mu_s" in done.stdout
    with xarray.open_dataset(where / "checked" / "result.nc", engine="h5netcdf") as kept:
        result = kept.load()
    for mechanics, law in (("half-space", {}), ("asperities", {"law": "hertz-cylinder"})):
        single = traverse(
            *(each[0] for each in lines_of(where)), result["load"].values, mu0=0.3, tau0=0.1, mechanics=mechanics,
            offsets=result["offset"].values, **law,
        )  # fmt: skip
        np.testing.assert_allclose(
            result["friction_coefficient"].sel(mechanics=mechanics), single["friction_coefficient"], rtol=1e-9
        )
    rows = (where / "checked" / "result.csv").read_text().splitlines()
    assert rows[0].startswith("mechanics,normal load (mN)")
    assert [row.split(",")[0] for row in rows[1:]] == ["half-space"] * 3 + ["asperities"] * 3
    for folder in ("half-space", "asperities"):
        assert (where / "checked" / folder / "friction.png").exists()
    assert stiction_command("info", "checked", cwd=where).stdout in done.stdout
    assert stiction_command("plot", "checked", cwd=where).returncode == 0
    told = json.loads(stiction_command("info", "checked", "--json", cwd=where).stdout)
    assert {value["at"]["mechanics"] for value in told["values"]} == {"half-space", "asperities"}
    assert stiction_command("report", "checked", "-o", "checked.html", cwd=where).returncode == 0


def test_half_planes_alone(where):
    given = [*BODIES, *MATERIAL, "--mechanics", "half-space"]
    done = stiction_command(*given, "-o", "planes", cwd=where)
    assert done.returncode == 0, done.stderr
    assert "elastic half-planes\n" in done.stdout
    assert "approach (nm)" not in done.stdout
    assert "Half-planes are the same all along their third direction" in done.stdout
    assert not (where / "planes" / "contact.png").exists()
    assert stiction_command("report", "planes", "-o", "planes.html", cwd=where).returncode == 0
    refused = stiction_command(*given, "--law", "hertz-cylinder", "-o", "bad", cwd=where)
    assert_refused(refused, "--law is for --mechanics asperities, of lines, got --law hertz-cylinder")
    refused = stiction_command(*BODIES, *MATERIAL, "--check", "--mechanics", "asperities", "-o", "bad", cwd=where)
    assert_refused(refused, "--check presses by both")


def lines_of(where):
    bodies = (read_profile(where / f"{side}.csv") for side in ("upper", "lower"))
    return paired_lines(*bodies, travel=None, level="line", lines=1, along="x", surrogates="none", seed=2016)
