"""Tests of `stiction characterise`: its output equals that of the library."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest
from matplotlib.image import imread
from stiction import (
    Profile,
    Surface,
    compare_repeated_scans,
    cut_off,
    joined_spectrum,
    levelled,
    random_phases,
    read_profile,
    self_affine,
    self_affine_surface,
    weierstrass_mandelbrot_surface,
    write_profile,
    write_surface,
)
from stiction.views.characterisation import characterisation_text
from support.command import assert_rejected, call_stiction, check_stiction


@pytest.fixture(scope="module")
def profile():
    heights = self_affine(1, hurst_exponent=0.7, rms=0.05, points=3000, spacing=0.01).heights
    return Profile(heights + 1e-3 * np.arange(3000), spacing=0.01)


@pytest.fixture(scope="module")
def surface():
    return weierstrass_mandelbrot_surface(random_phases(2), 1.4, shape=(60, 90), extent=(3.0, 9.0)).with_amplitude(8.0)


@pytest.fixture
def folder(tmp_path, profile, surface):
    write_profile(profile, tmp_path / "scan.csv")
    np.save(tmp_path / "heights.npy", profile.heights)
    np.save(tmp_path / "map.npy", surface.heights)
    return tmp_path


def characterise(*arguments, cwd):
    """Run the command; return history, rest of the table, and figure."""
    completed = check_stiction("characterise", *arguments, "--verbose", cwd=cwd, without_figures=True)
    assert completed.stderr == ""
    lines = completed.stdout.splitlines()
    assert lines.pop(0).startswith(f"{Path(arguments[0]).name}: ")
    table = next(at for at, line in enumerate(lines) if line.startswith("points"))
    assert lines[0].startswith("history")
    written = [cwd / line[6:] for line in lines if line.startswith("wrote ")]
    assert [path.suffix for path in written[:-1]] == [".html"]
    rest = lines[table : -len(written)]
    return [line[20:] for line in lines[:table]], "\n".join([*rest, ""]), written[-1]


def table(text):
    return words(text[text.index("points") :])


def words(text):
    """Return the words of a text, independent of line breaks."""
    return " ".join(text.split())


def test_characterise_file_equals_profile_in_memory(folder, profile):
    level = levelled(profile, "line")
    history, message, figure = characterise("scan.csv", cwd=folder)
    assert words(message) == table(characterisation_text(level))
    assert history == ["read from scan.csv", "spacing 0.01 µm (header and positions agree)", level.history[-1]]
    assert figure == folder / "scan.png"
    assert imread(figure).shape[1] == pytest.approx(80 / 25.4 * 300, abs=2)
    history, message, figure = characterise("heights.npy", "--unit", "um", "--spacing", "10 nm", cwd=folder)
    assert words(message) == table(characterisation_text(level))
    assert history == ["read from heights.npy", level.history[-1]]


@pytest.mark.parametrize("file", ["scan.csv", "map.npy"])
def test_characterise_prints_one_screen_without_verbose(folder, file):
    options = ("--unit", "um", "--spacing", "50 nm,100 nm") if file == "map.npy" else ()
    short, complete = (
        check_stiction("characterise", file, *options, "-o", f"{name}.html", *more, cwd=folder).stdout.splitlines()
        for name, more in (("short", ()), ("all", ("--verbose",)))
    )
    assert len(short) <= 40
    omitted = next(int(line.split()[0]) for line in short if line.endswith(" more lines: --verbose shows all"))
    assert omitted > 10
    names = {line.split()[0] for line in short if line[:1] not in (" ", "")}
    assert {"points", "friction", "Hurst", *(("Sq", "Sdq") if file == "map.npy" else ("Pq", "Pdq"))} <= names
    assert set(short) - {f"{omitted} more lines: --verbose shows all", "wrote short.html, without a figure"} <= set(
        complete
    )


def test_characterise_uses_unit_trend_band_and_output_options(folder, profile):
    in_nm = Profile(profile.heights / 1000, spacing=0.01)
    history, message, figure = characterise(
        "heights.npy", "--unit", "um,nm", "--spacing", "0.01um", "--level", "quadratic", "--band", "0.1 um, 5000nm",
        "--output", "mine.PNG", cwd=folder,
    )  # fmt: skip
    assert words(message) == table(characterisation_text(levelled(in_nm, "quadratic"), band=(0.1, 5.0)))
    assert history[-1] == "levelled by a parabola"
    assert figure == folder / "mine.PNG"
    history, message, _ = characterise("scan.csv", "--level", "none", cwd=folder)
    assert words(message) == table(characterisation_text(profile))
    assert not any("levelled" in step for step in history)


def test_characterise_interpolates_missing_points_and_selects_columns(folder, profile):
    lines = (folder / "scan.csv").read_text(encoding="utf-8").splitlines()
    lines[100] = lines[100].split(",")[0] + ",nan"
    (folder / "gaps.csv").write_text("\n".join(lines), encoding="utf-8")
    assert_rejected(call_stiction("characterise", "gaps.csv", cwd=folder), "1 of 3000 points", "interpolate")
    for missing, done in (("interpolate", "interpolated"), ("mask", "masked")):
        history, message, _ = characterise("gaps.csv", "--missing", missing, cwd=folder)
        assert (
            f"1 missing points {done}, 0.033 % of all points; the largest gap has 1 point, at x 0.98 µm to 0.99 µm"
            in history
        )
        assert "outliers none" in words(message)
    # And columns are those asked for.
    lines = (folder / "scan.csv").read_text(encoding="utf-8").splitlines()
    at = lines.index("x (um),z (um)")
    wide = [f"{index},{line},7" for index, line in enumerate(lines[at + 1 :])]
    (folder / "wide.csv").write_text("\n".join(["n,x (um),z (um),t (s)", *wide]), encoding="utf-8")
    history, message, _ = characterise("wide.csv", "--columns", "x,z", cwd=folder)
    assert words(message) == table(characterisation_text(levelled(profile, "line")))
    assert history[:2] == ["read from wide.csv", "columns 1 (x (um)), 2 (z (um))"]


def test_characterise_of_map_gives_roughness_of_its_lines(folder, surface):
    options = ["map.npy", "--unit", "um", "--spacing", "0.05 um,0.1 um"]
    history, message, figure = characterise(*options, cwd=folder)
    assert words(message) == table(characterisation_text(levelled(surface, "plane")))
    assert history == ["read from map.npy", "levelled by a plane"]
    assert imread(figure).shape[1] == pytest.approx(170 / 25.4 * 300, abs=2)
    rows = {line[:19].strip(): line[20:].rstrip() for line in message.splitlines()}
    assert rows["points"] == "90 along x, 100 nm apart, over 9 µm"
    assert rows["number"].split() == ["60", "90"]
    assert float(rows["Sq"].split()[0]) == pytest.approx(np.std(levelled(surface, "plane").heights), rel=1e-3)
    for option, line in (("--row", surface.row(7)), ("--column", surface.column(7))):
        history, message, _ = characterise(*options, option, 7, cwd=folder)
        assert words(message) == table(characterisation_text(levelled(line, "line")))
        assert history == ["read from map.npy", f"{option[2:]} 7", "levelled by a line"]


def test_characterise_replaces_its_own_figure_only(folder):
    characterise("scan.csv", cwd=folder)
    before = (folder / "scan.png").stat().st_ino
    characterise("scan.csv", "--band", "0.1 um,1 um", cwd=folder)
    assert (folder / "scan.png").stat().st_ino != before
    photograph = b"\x89PNG\r\n\x1a\n of the instrument"
    (folder / "scan.png").write_bytes(photograph)
    assert_rejected(call_stiction("characterise", "scan.csv", cwd=folder), "scan.png: exists already")
    assert (folder / "scan.png").read_bytes() == photograph


def test_characterise_report_has_command_without_directories(folder):
    options = ["--level", "quadratic", "--tip", "2 um"]
    completed = call_stiction("characterise", folder / "scan.csv", *options, cwd=folder, without_figures=True)
    assert completed.stdout.endswith("wrote scan.html\nwrote scan.png\n")
    page = (folder / "scan.html").read_text(encoding="utf-8")
    assert "stiction characterise scan.csv --tip &#x27;2 um&#x27; --level quadratic" in page
    assert str(folder) not in page
    completed = call_stiction(
        "characterise", "scan.csv", "--json", "-o", "alone.html", cwd=folder, without_figures=True
    )
    assert completed.stderr == "stiction: wrote alone.html, without a figure\n"
    (folder / "alone.html").write_text("<p>of somebody else</p>", encoding="utf-8")
    completed = call_stiction("characterise", "scan.csv", "-o", "alone.html", cwd=folder)
    assert_rejected(completed, "alone.html: exists already")


def test_characterise_writes_json_and_figure_together(folder):
    completed = check_stiction("characterise", "scan.csv", "--json", "-o", "look.png", cwd=folder)
    assert completed.stderr == "stiction: wrote look.html\nstiction: wrote look.png\n"
    assert imread(folder / "look.png").std() > 0.05
    record = json.loads(completed.stdout)
    assert record["command"] == "characterise"
    assert record == json.loads(call_stiction("characterise", "scan.csv", "--json", cwd=folder).stdout)
    assert not (folder / "scan.png").exists()
    for value in record["values"]:
        assert list(value) == ["name", "value", "unit", "lower", "upper", "at", "status"]
        assert value["at"] == {"file": "scan.csv"}


def test_characterise_of_several_files_prints_one_table(folder):
    files = ["scan.csv", "map.npy"]
    options = ["--unit", "um", "--spacing", "10 nm"]
    completed = check_stiction("characterise", *files, *options, "-o", "finishes.csv", cwd=folder)
    assert [line.partition(":")[0] for line in completed.stdout.splitlines()] == [*files, "wrote finishes.csv, 2 files"]
    rows = list(csv.DictReader((folder / "finishes.csv").read_text(encoding="utf-8").splitlines()))
    assert [row["holds"] for row in rows] == ["profile", "surface"]
    assert [row["points"] for row in rows] == ["3000", "60 x 90"]
    record = json.loads(call_stiction("characterise", *files, *options, "--json", cwd=folder).stdout)
    for row in rows:
        values = {value["name"]: value for value in record["values"] if value["at"]["file"] == row["file"]}
        for name, value in values.items():
            title = name if value["unit"] == "1" else f"{name} ({value['unit']})"
            assert row[title] == "" or float(row[title]) == pytest.approx(value["value"], rel=1e-8)
    assert rows[0]["Sq (um)"] == rows[1]["Pq (um)"] == ""
    completed = call_stiction("characterise", *files, *options, "-o", "finishes.csv", cwd=folder)
    assert_rejected(completed, "finishes.csv: exists already")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["none.csv"], "none.csv: cannot be read: No such file or directory"),
        (["empty.csv"], "empty.csv: is empty"),
        (["scan.csv", "--columns", "x,z,q,r"], "columns must be one for heights, two for positions and heights"),
        (["heights.npy", "--spacing", "1 um"], "does not contain the unit of its heights; give the unit"),
        (["scan.csv", "--missing", "zero"], "missing must be one of 'error', 'interpolate', 'mask', got 'zero'"),
        (["scan.csv", "--level", "plane"], "--level must be one of 'none', 'mean', 'line',"),
        (["scan.csv", "--lc", "1 um", "--repeated"], "--repeated needs two scans"),
        (["scan.csv", "scan.csv", "--lc", "1 um", "--together"], "--lc, --ls and --robust cannot be combined with"),
        (["scan.csv", "--lc", "1 m"], "one section length is"),
        (["map.npy", "--unit", "um", "--spacing", "1um", "--lc", "1 m"], "lc must be from half a point"),
        (["map.npy", "--unit", "um", "--spacing", "1um", "--form", "circle"], "'sphere', 'cylinder', got 'circle'"),
        (["scan.csv", "--row", "3"], "--row is for surfaces"),
        (["map.npy", "--unit", "um", "--spacing", "1um", "--level", "line"], "one of 'none', 'mean', 'plane'"),
        (["map.npy", "--unit", "um", "--spacing", "1um", "--row", "60"], "--row must be at most 59, got 60"),
        (
            ["map.npy", "--unit", "um", "--spacing", "1um", "--row", "6", "--column", "6"],
            "cannot be combined with --column",
        ),
        (["scan.csv", "--band", "1 um"], "--band must be two wavelengths"),
        (["scan.csv", "--band", "2 um,1 um"], "--band must give the shortest wavelength before"),
        (["scan.csv", "--band", "1 um,1.01 um"], "band must hold at least 8 harmonics"),
        (["scan.csv", "--output", "figure.bmp"], "--output must end in .html, .png, .pdf or .svg, got figure.bmp"),
        (["scan.csv", "--output", "none/a.png"], "cannot be written: No such file or directory"),
    ],
)
def test_characterise_rejects_bad_input(folder, arguments, message):
    (folder / "empty.csv").touch()
    completed = call_stiction("characterise", *arguments, cwd=folder)
    assert_rejected(completed, message)
    assert len(completed.stderr.splitlines()) == 1
    assert completed.stderr.startswith("stiction: ")


def test_characterise_reads_stylus_profile(measured, tmp_path):
    history, message, _ = characterise(measured("dektak-1.csv"), cwd=tmp_path)
    assert "spacing 0.1562454 µm from its positions, declared as 0.156 µm" in history
    assert "Pq                  94.24 nm\n" in message
    assert "points              9600, 156.2 nm apart, over 1.5 mm\n" in message


def test_characterise_reads_map_of_atomic_force_microscope(measured, tmp_path):
    pytest.importorskip("SurfaceTopography")
    history, message, _ = characterise(measured("di-4.di"), cwd=tmp_path)
    assert history[1] == "channel 0 (ZSensor) of 0 (ZSensor), 1 (AmplitudeError), 2 (Phase)"
    rows = {line[:19].strip(): line[20:].split() for line in message[message.index("lines  ") :].splitlines()}
    rows["Sq"] = message[message.index("\nSq") :].split()[1:3]
    assert rows["Sq"] == ["79.42", "nm"]
    assert [float(number) for number in rows["Pq"][::2]] == pytest.approx([38.8, 62.0], abs=0.05)
    assert [float(number) for number in rows["Pdq, neighbours"]] == pytest.approx([0.109, 0.141], abs=5e-4)
    # 0.87 to 0.90 by other means; single lines scatter by 0.2. The spectrum along x is off any line.
    assert rows["Hurst exponent H"][:3] == ["none,", "no", "line"]
    assert float(rows["Hurst exponent H"][3]) == pytest.approx(0.88, abs=0.06)


# ---- Scales ---------------------------------------------------------------------------------------------------------


def test_characterise_applies_cutoff_and_checks_tip(folder, profile):
    level = cut_off(levelled(profile, "line"), 0.5)
    history, message, _ = characterise("scan.csv", "--cutoff", "500 nm", "--tip", "1 um", cwd=folder)
    assert history[-1] == level.history[-1]
    assert table(characterisation_text(level, tip_radius=1.0)) == words(message)
    _, blunt, _ = characterise("scan.csv", "--tip", "100 um", cwd=folder)
    assert "use a sharper tip" in blunt
    assert "sharper than the tip resolves" in blunt
    assert_rejected(call_stiction("characterise", "scan.csv", "--cutoff", "20 um", cwd=folder), "--cutoff")


def test_characterise_joins_spectra_of_several_scans(folder):
    surfaces = self_affine_surface(2, hurst_exponent=0.8, rms=0.05, shape=(256, 256), spacing=0.02)
    fine, coarse = surfaces.heights[:128, :128], surfaces.heights[::4, ::4]
    write_surface(Surface(coarse, spacing=0.08), folder / "coarse.npy")
    write_surface(Surface(fine, spacing=0.02), folder / "fine.npy")
    arguments = ["fine.npy", "coarse.npy", "--together"]
    assert_rejected(call_stiction("characterise", "fine.npy", "--together", cwd=folder), "--together")
    completed = check_stiction("characterise", *arguments, cwd=folder)
    assert "wavelengths used" in completed.stdout
    assert (folder / "joined.png").read_bytes().startswith(b"\x89PNG")
    check_stiction("characterise", *arguments, "--output", "spectra.svg", cwd=folder)
    assert (folder / "spectra.svg").exists()
    assert_rejected(call_stiction("characterise", *arguments, "--output", "spectra.doc", cwd=folder), "must end in")
    joined = joined_spectrum(
        [levelled(Surface(item, spacing=step), "plane") for item, step in ((fine, 0.02), (coarse, 0.08))]
    )
    with (folder / "joined.csv").open() as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    np.testing.assert_allclose([float(row["C2D (um4)"]) for row in rows], joined.density, rtol=1e-6)
    record = json.loads(call_stiction("characterise", *arguments, "--json", cwd=folder).stdout)
    assert [scan["file"] for scan in record["scans"]] == ["fine.npy", "coarse.npy"]
    np.testing.assert_allclose(record["spectrum"]["rms_gradient"], joined.roughness().gradient)


def test_characterise_repeated_gives_mean_and_noise(tmp_path):
    place = self_affine(3, hurst_exponent=0.8, rms=0.1, points=3000, spacing=0.01, shortest_wavelength=0.2)
    random = np.random.default_rng(1)
    for name, first in (("a.csv", 0), ("b.csv", 25)):
        heights = place.heights[first : first + 2900] + 1e-3 * random.normal(size=2900)
        write_profile(Profile(heights, spacing=0.01), tmp_path / name)
    completed = check_stiction("characterise", "a.csv", "b.csv", "--repeated", cwd=tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == {
        "a.csv", "b.csv", "repeated.npy", "noise.csv", "noise.png",
    }  # fmt: skip
    found = compare_repeated_scans(*(levelled(read_profile(tmp_path / name), "line") for name in ("a.csv", "b.csv")))
    assert found.shift[0] == pytest.approx(0.25, abs=0.003)
    assert f"starts at x = {1000 * found.shift[0]:.3g} nm of the first one." in " ".join(completed.stdout.split())
    assert np.array_equal(read_profile(tmp_path / "repeated.npy").heights, found.scan.heights)
    assert f"--cutoff '{1000 * found.limit:g} nm'" in " ".join(completed.stdout.split())
    for more, why in (([], "repeated.npy: exists already"), (["--together"], "excludes --together")):
        assert_rejected(call_stiction("characterise", "a.csv", "b.csv", "--repeated", *more, cwd=tmp_path), why)
    reported = call_stiction("characterise", "a.csv", "b.csv", "--repeated", "--json", cwd=tmp_path)
    assert json.loads(reported.stdout)["limit_um"] == found.limit


def test_dry_run_shows_how_files_are_read(folder):
    completed = check_stiction(
        "characterise", "scan.csv", "heights.npy", "--unit", "um", "--spacing", "10 nm", "--dry-run", cwd=folder
    )
    first, second = completed.stdout.splitlines()
    assert first.startswith(
        "scan.csv: positions and heights; 3000 points; 10 nm apart; heights from column 1 (z (um)) in um"
    )
    assert second.startswith("heights.npy: NumPy array; 3000 points; 10 nm apart")
    assert not list(folder.glob("*.png"))
    completed = check_stiction("characterise", "scan.csv", "--dry-run", "--json", cwd=folder)
    (file,) = json.loads(completed.stdout)["files"]
    assert (file["layout"], file["points"], file["caveats"]) == ("positions and heights", [3000], [])


def test_undeclared_missing_codes_are_caveats(folder):
    heights = np.load(folder / "heights.npy")
    heights[[5, 70]] = -9999
    np.save(folder / "codes.npy", heights)
    arguments = ["codes.npy", "--unit", "um", "--spacing", "10 nm", "--missing", "interpolate", "--dry-run"]
    completed = check_stiction("characterise", *arguments, cwd=folder)
    assert "--missing-value -9999 treats them as missing points (repeated-extreme)" in completed.stderr
    completed = check_stiction("characterise", *arguments, "--missing-value", "-9999", cwd=folder)
    assert completed.stderr == ""
    assert "2 of 3000 missing" in completed.stdout
