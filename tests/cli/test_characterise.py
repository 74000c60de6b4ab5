"""Tests of `stiction characterise`; its output must equal the results of the library."""

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
from stiction.surfaces.lines import MAX_FITTED_LINES
from stiction.views.characterisation import characterisation_text
from support.command import assert_rejected, call_stiction, check_stiction

pytestmark = pytest.mark.usefixtures("few_fitted_lines")


@pytest.fixture(scope="module")
def profile():
    heights = self_affine(1, hurst_exponent=0.7, rms=0.05, points=3000, spacing=0.01).heights
    return Profile(heights + 1e-3 * np.arange(3000), spacing=0.01)


@pytest.fixture(scope="module")
def surface():
    return weierstrass_mandelbrot_surface(random_phases(2), 1.4, shape=(60, 90), extent=(3.0, 9.0)).with_amplitude(8.0)


@pytest.fixture
def scans_directory(tmp_path, profile, surface):
    write_profile(profile, tmp_path / "scan.csv")
    np.save(tmp_path / "heights.npy", profile.heights)
    np.save(tmp_path / "map.npy", surface.heights)
    return tmp_path


def run_characterise(*arguments, cwd):
    """Run the command, and return the history of the scan, all other rows of the table, and the path of the figure."""
    completed = check_stiction("characterise", *arguments, "--verbose", cwd=cwd, without_figures=True)
    assert completed.stderr == ""
    lines = completed.stdout.splitlines()
    assert lines.pop(0).startswith(f"{Path(arguments[0]).name}: ")
    table_start = next(index for index, line in enumerate(lines) if line.startswith("points"))
    assert lines[0].startswith("history")
    written_paths = [cwd / line[6:] for line in lines if line.startswith("wrote ")]
    assert [path.suffix for path in written_paths[:-1]] == [".html"]
    table_lines = lines[table_start : -len(written_paths)]
    return [line[20:] for line in lines[:table_start]], "\n".join([*table_lines, ""]), written_paths[-1]


def normalize_table(text):
    return normalize_whitespace(text[text.index("points") :])


def normalize_whitespace(text):
    """Return a text in which each line break or run of spaces is replaced by a single space."""
    return " ".join(text.split())


def test_characterise_command_and_library_give_equal_results_for_a_profile(scans_directory, profile):
    levelled_profile = levelled(profile, "line")
    history, output_table, figure = run_characterise("scan.csv", cwd=scans_directory)
    assert normalize_whitespace(output_table) == normalize_table(characterisation_text(levelled_profile))
    assert history == [
        "read from scan.csv",
        "spacing 0.01 µm (header and positions agree)",
        levelled_profile.history[-1],
    ]
    assert figure == scans_directory / "scan.png"
    assert imread(figure).shape[1] == pytest.approx(80 / 25.4 * 300, abs=2)
    history, output_table, figure = run_characterise(
        "heights.npy", "--unit", "um", "--spacing", "10 nm", cwd=scans_directory
    )
    assert normalize_whitespace(output_table) == normalize_table(characterisation_text(levelled_profile))
    assert history == ["read from heights.npy", levelled_profile.history[-1]]


@pytest.mark.parametrize("file_name", ["scan.csv", "map.npy"])
def test_characterise_command_prints_at_most_40_lines_without_verbose_option(scans_directory, file_name):
    options = ("--unit", "um", "--spacing", "50 nm,100 nm") if file_name == "map.npy" else ()
    short_lines, all_lines = (
        check_stiction(
            "characterise",
            file_name,
            *options,
            "-o",
            f"{name}.html",
            *verbosity,
            cwd=scans_directory,
            without_figures=True,
        ).stdout.splitlines()
        for name, verbosity in (("short", ()), ("all", ("--verbose",)))
    )
    assert len(short_lines) <= 40
    ending = " more lines: --verbose shows all"
    num_omitted = next(int(line.split()[0]) for line in short_lines if line.endswith(ending))
    assert num_omitted > 10
    names = {line.split()[0] for line in short_lines if line[:1] not in (" ", "")}
    assert {"points", "friction", "Hurst", *(("Sq", "Sdq") if file_name == "map.npy" else ("Pq", "Pdq"))} <= names
    assert set(short_lines) - {f"{num_omitted}{ending}", "wrote short.html, without a figure"} <= set(all_lines)


def test_characterise_command_applies_options_for_units_and_levelling_and_band_and_output(scans_directory, profile):
    profile_in_nm = Profile(profile.heights / 1000, spacing=0.01)
    history, output_table, figure = run_characterise(
        "heights.npy", "--unit", "um,nm", "--spacing", "0.01um", "--level", "quadratic", "--band", "0.1 um, 5000nm",
        "--output", "mine.PNG", cwd=scans_directory,
    )  # fmt: skip
    assert normalize_whitespace(output_table) == normalize_table(
        characterisation_text(levelled(profile_in_nm, "quadratic"), band=(0.1, 5.0))
    )
    assert history[-1] == "levelled by a parabola"
    assert figure == scans_directory / "mine.PNG"
    history, output_table, _ = run_characterise("scan.csv", "--level", "none", cwd=scans_directory)
    assert normalize_whitespace(output_table) == normalize_table(characterisation_text(profile))
    assert not any("levelled" in step for step in history)


def test_characterise_command_fills_or_masks_missing_points_and_selects_the_given_columns(scans_directory, profile):
    lines = (scans_directory / "scan.csv").read_text(encoding="utf-8").splitlines()
    lines[100] = lines[100].split(",")[0] + ",nan"
    (scans_directory / "gaps.csv").write_text("\n".join(lines), encoding="utf-8")
    assert_rejected(call_stiction("characterise", "gaps.csv", cwd=scans_directory), "1 of 3000 heights", "interpolate")
    for missing_option, history_word in (("interpolate", "interpolated"), ("mask", "masked")):
        history, output_table, _ = run_characterise("gaps.csv", "--missing", missing_option, cwd=scans_directory)
        assert any(
            f"1 missing points {history_word}, 0.033 % of all points" in step and "0.98 µm to 0.99 µm" in step
            for step in history
        )
        assert "outliers none" in normalize_whitespace(output_table)
    lines = (scans_directory / "scan.csv").read_text(encoding="utf-8").splitlines()
    header_index = lines.index("x (um),z (um)")
    data_lines = [f"{index},{line},7" for index, line in enumerate(lines[header_index + 1 :])]
    (scans_directory / "wide.csv").write_text("\n".join(["n,x (um),z (um),t (s)", *data_lines]), encoding="utf-8")
    history, output_table, _ = run_characterise("wide.csv", "--columns", "x,z", cwd=scans_directory)
    assert normalize_whitespace(output_table) == normalize_table(characterisation_text(levelled(profile, "line")))
    assert history[:2] == ["read from wide.csv", "columns 1 (x (um)), 2 (z (um))"]


def test_characterise_command_prints_the_roughness_of_a_map_and_of_its_profiles(scans_directory, surface):
    options = ["map.npy", "--unit", "um", "--spacing", "0.05 um,0.1 um"]
    history, output_table, figure = run_characterise(*options, cwd=scans_directory)
    assert normalize_whitespace(output_table) == normalize_table(characterisation_text(levelled(surface, "plane")))
    assert history == ["read from map.npy", "levelled by a plane"]
    assert imread(figure).shape[1] == pytest.approx(170 / 25.4 * 300, abs=2)
    rows = {profile[:19].strip(): profile[20:].rstrip() for profile in output_table.splitlines()}
    assert rows["points"] == "90 along x, 100 nm apart, over 9 µm"
    assert rows["number"].split() == ["60", "90"]
    assert float(rows["Sq"].split()[0]) == pytest.approx(np.std(levelled(surface, "plane").heights), rel=1e-3)
    for option, profile in (("--row", surface.row(7)), ("--column", surface.column(7))):
        history, output_table, _ = run_characterise(*options, option, 7, cwd=scans_directory)
        assert normalize_whitespace(output_table) == normalize_table(characterisation_text(levelled(profile, "line")))
        assert history == ["read from map.npy", f"{option[2:]} 7", "levelled by a line"]


def test_characterise_command_overwrites_only_its_own_figures(scans_directory):
    run_characterise("scan.csv", cwd=scans_directory)
    inode_before = (scans_directory / "scan.png").stat().st_ino
    run_characterise("scan.csv", "--band", "0.1 um,1 um", cwd=scans_directory)
    assert (scans_directory / "scan.png").stat().st_ino != inode_before
    photograph = b"\x89PNG\r\n\x1a\n of the instrument"
    (scans_directory / "scan.png").write_bytes(photograph)
    assert_rejected(call_stiction("characterise", "scan.csv", cwd=scans_directory), "scan.png: already exists")
    assert (scans_directory / "scan.png").read_bytes() == photograph


def test_command_line_shown_in_a_characterisation_report_omits_directories(scans_directory):
    options = ["--level", "quadratic", "--tip", "2 um"]
    completed = call_stiction(
        "characterise", scans_directory / "scan.csv", *options, cwd=scans_directory, without_figures=True
    )
    assert completed.stdout.endswith("wrote scan.html\nwrote scan.png\n")
    page = (scans_directory / "scan.html").read_text(encoding="utf-8")
    assert "stiction characterise scan.csv --tip &#x27;2 um&#x27; --level quadratic" in page
    assert str(scans_directory) not in page
    completed = call_stiction(
        "characterise", "scan.csv", "--json", "-o", "alone.html", cwd=scans_directory, without_figures=True
    )
    assert completed.stderr == "stiction: wrote alone.html, without a figure\n"
    (scans_directory / "alone.html").write_text("<p>of another program</p>", encoding="utf-8")
    completed = call_stiction("characterise", "scan.csv", "-o", "alone.html", cwd=scans_directory)
    assert_rejected(completed, "alone.html: already exists")


def test_characterise_command_writes_json_and_figure_in_one_run(scans_directory):
    completed = check_stiction("characterise", "scan.csv", "--json", "-o", "look.png", cwd=scans_directory)
    assert completed.stderr == "stiction: wrote look.html\nstiction: wrote look.png\n"
    assert imread(scans_directory / "look.png").std() > 0.05
    record = json.loads(completed.stdout)
    assert record["command"] == "characterise"
    assert record == json.loads(
        call_stiction("characterise", "scan.csv", "--json", cwd=scans_directory, without_figures=True).stdout
    )
    assert not (scans_directory / "scan.png").exists()
    for value in record["values"]:
        assert list(value) == ["name", "value", "unit", "lower", "upper", "kind", "at", "status"]
        assert value["at"] == {"file": "scan.csv"}


def test_characterise_command_summarises_several_files_in_one_table(scans_directory):
    files = ["scan.csv", "map.npy"]
    options = ["--unit", "um", "--spacing", "10 nm"]
    completed = check_stiction("characterise", *files, *options, "-o", "finishes.csv", cwd=scans_directory)
    assert [line.partition(":")[0] for line in completed.stdout.splitlines()] == [*files, "wrote finishes.csv, 2 files"]
    rows = list(csv.DictReader((scans_directory / "finishes.csv").read_text(encoding="utf-8").splitlines()))
    assert [row["type"] for row in rows] == ["profile", "surface"]
    assert [row["points"] for row in rows] == ["3000", "60 x 90"]
    record = json.loads(call_stiction("characterise", *files, *options, "--json", cwd=scans_directory).stdout)
    for row in rows:
        values = {value["name"]: value for value in record["values"] if value["at"]["file"] == row["file"]}
        for name, value in values.items():
            title = name if value["unit"] == "1" else f"{name} ({value['unit']})"
            assert row[title] == "" or float(row[title]) == pytest.approx(value["value"], rel=1e-8)
    assert rows[0]["Sq (um)"] == rows[1]["Pq (um)"] == ""
    completed = call_stiction("characterise", *files, *options, "-o", "finishes.csv", cwd=scans_directory)
    assert_rejected(completed, "finishes.csv: already exists")


@pytest.mark.parametrize(
    ("arguments", "expected_message"),
    [
        (["none.csv"], "none.csv: cannot be read: No such file or directory"),
        (["empty.csv"], "empty.csv: is empty"),
        (["scan.csv", "--columns", "x,z,q,r"], "columns must be one column (heights), two (positions and heights)"),
        (["heights.npy", "--spacing", "1 um"], "does not contain the unit of its heights; give the unit"),
        (["scan.csv", "--missing", "zero"], "missing must be one of 'error', 'interpolate', 'mask', got 'zero'"),
        (["scan.csv", "--level", "plane"], "--level must be one of 'none', 'mean', 'line',"),
        (["scan.csv", "--lc", "1 um", "--repeated"], "requires two scans of the same place"),
        (["scan.csv", "scan.csv", "--lc", "1 um", "--together"], "--lc must not be combined with --together"),
        (["scan.csv", "scan.csv", "--band", "1 um,2 um", "--together"], "--band must not be combined with --together"),
        (
            ["scan.csv", "scan.csv", "--texture", "turned", "--repeated"],
            "--texture must not be combined with --repeated",
        ),
        (["scan.csv", "scan.csv", "--tip", "2 um", "--repeated"], "--tip must not be combined with --repeated"),
        (["scan.csv", "--lc", "1 m"], "one section length is"),
        (
            ["map.npy", "--unit", "um", "--spacing", "1um", "--lc", "1 m"],
            "lc must be between 0.5 µm (half the spacing)",
        ),
        (["map.npy", "--unit", "um", "--spacing", "1um", "--form", "circle"], "'sphere', 'cylinder', got 'circle'"),
        (["scan.csv", "--row", "3"], "--row applies only to surfaces"),
        (["map.npy", "--unit", "um", "--spacing", "1um", "--level", "line"], "one of 'none', 'mean', 'plane'"),
        (["map.npy", "--unit", "um", "--spacing", "1um", "--row", "60"], "--row must be at most 59, got 60"),
        (
            ["map.npy", "--unit", "um", "--spacing", "1um", "--row", "6", "--column", "6"],
            "cannot be combined with --column",
        ),
        (["scan.csv", "--band", "1 um"], "--band must be two wavelengths"),
        (["scan.csv", "--band", "2 um,1 um"], "--band must start with the shorter wavelength"),
        (["scan.csv", "--band", "1 um,1.01 um"], "band must contain at least 8 harmonics"),
        (["scan.csv", "--output", "figure.bmp"], "--output must end in .html, .png, .pdf or .svg, got figure.bmp"),
        (["scan.csv", "--output", "none/a.png"], "cannot be written: No such file or directory"),
    ],
)
def test_characterise_command_rejects_invalid_input(scans_directory, arguments, expected_message):
    (scans_directory / "empty.csv").touch()
    completed = call_stiction("characterise", *arguments, cwd=scans_directory, without_figures=True)
    assert_rejected(completed, expected_message)
    assert len(completed.stderr.splitlines()) == 1
    assert completed.stderr.startswith("stiction: ")


def test_characterise_command_reads_a_stylus_profile(find_measured_file, tmp_path):
    history, output_table, _ = run_characterise(find_measured_file("dektak-1.csv"), cwd=tmp_path)
    assert "spacing 0.1562454 µm from its positions, declared as 0.156 µm" in history
    assert "Pq                  94.24 nm\n" in output_table
    assert "points              9600, 156.2 nm apart, over 1.5 mm\n" in output_table


def test_characterise_command_reads_an_atomic_force_microscope_map(find_measured_file, tmp_path, monkeypatch):
    pytest.importorskip("SurfaceTopography")
    # Fit all lines of the map, because a selection of twelve lines would give other Hurst exponents along x.
    monkeypatch.setattr("stiction.surfaces.lines.MAX_FITTED_LINES", MAX_FITTED_LINES)
    history, output_table, _ = run_characterise(find_measured_file("di-4.di"), cwd=tmp_path)
    assert history[1] == "channel 0 (ZSensor) of 0 (ZSensor), 1 (AmplitudeError), 2 (Phase)"
    rows = {line[:19].strip(): line[20:].split() for line in output_table[output_table.index("lines  ") :].splitlines()}
    rows["Sq"] = output_table[output_table.index("\nSq") :].split()[1:3]
    assert rows["Sq"] == ["79.42", "nm"]
    assert [float(number) for number in rows["Pq"][::2]] == pytest.approx([38.8, 62.0], abs=0.05)
    assert [float(number) for number in rows["Pdq, neighbours"]] == pytest.approx([0.109, 0.141], abs=5e-4)
    # Other methods give Hurst exponents of 0.87 to 0.90 for this map, and single profiles scatter by 0.2.
    assert rows["Hurst exponent H"][:3] == ["none,", "no", "line"]
    assert float(rows["Hurst exponent H"][3]) == pytest.approx(0.88, abs=0.06)


# ---- Scales ---------------------------------------------------------------------------------------------------------


def test_characterise_command_filters_a_scan_at_a_cutoff_and_reports_a_blunt_tip(scans_directory, profile):
    filtered_profile = cut_off(levelled(profile, "line"), 0.5)
    history, output_table, _ = run_characterise("scan.csv", "--cutoff", "500 nm", "--tip", "1 um", cwd=scans_directory)
    assert history[-1] == filtered_profile.history[-1]
    assert normalize_table(characterisation_text(filtered_profile, tip_radius=1.0)) == normalize_whitespace(
        output_table
    )
    _, table_of_blunt_tip, _ = run_characterise("scan.csv", "--tip", "100 um", cwd=scans_directory)
    assert "sharper tip" in table_of_blunt_tip
    assert "tip does not resolve wavelengths below" in normalize_whitespace(table_of_blunt_tip)
    assert_rejected(call_stiction("characterise", "scan.csv", "--cutoff", "20 um", cwd=scans_directory), "--cutoff")


def test_characterise_command_joins_spectra_of_several_scans(scans_directory):
    surface = self_affine_surface(2, hurst_exponent=0.8, rms=0.05, shape=(256, 256), spacing=0.02)
    fine_heights, coarse_heights = surface.heights[:128, :128], surface.heights[::4, ::4]
    write_surface(Surface(coarse_heights, spacing=0.08), scans_directory / "coarse.npy")
    write_surface(Surface(fine_heights, spacing=0.02), scans_directory / "fine.npy")
    arguments = ["fine.npy", "coarse.npy", "--together"]
    assert_rejected(call_stiction("characterise", "fine.npy", "--together", cwd=scans_directory), "--together")
    completed = check_stiction("characterise", *arguments, cwd=scans_directory)
    assert "wavelengths used" in completed.stdout
    assert (scans_directory / "joined.png").read_bytes().startswith(b"\x89PNG")
    check_stiction("characterise", *arguments, "--output", "spectra.svg", cwd=scans_directory, without_figures=True)
    assert (scans_directory / "spectra.svg").exists()
    assert_rejected(
        call_stiction("characterise", *arguments, "--output", "spectra.doc", cwd=scans_directory), "must end in"
    )
    spectrum = joined_spectrum(
        [
            levelled(Surface(heights, spacing=spacing), "plane")
            for heights, spacing in ((fine_heights, 0.02), (coarse_heights, 0.08))
        ]
    )
    with (scans_directory / "joined.csv").open() as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    np.testing.assert_allclose([float(row["C2D (um4)"]) for row in rows], spectrum.density, rtol=1e-6)
    record = json.loads(call_stiction("characterise", *arguments, "--json", cwd=scans_directory).stdout)
    assert [scan["file"] for scan in record["scans"]] == ["fine.npy", "coarse.npy"]
    np.testing.assert_allclose(record["spectrum"]["rms_gradient"], spectrum.roughness().gradient)


def test_characterise_command_writes_mean_and_noise_of_repeated_scans(tmp_path):
    profile = self_affine(3, hurst_exponent=0.8, rms=0.1, points=3000, spacing=0.01, shortest_wavelength=0.2)
    random = np.random.default_rng(1)
    for name, first_point in (("a.csv", 0), ("b.csv", 25)):
        heights = profile.heights[first_point : first_point + 2900] + 1e-3 * random.normal(size=2900)
        write_profile(Profile(heights, spacing=0.01), tmp_path / name)
    completed = check_stiction("characterise", "a.csv", "b.csv", "--repeated", cwd=tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == {
        "a.csv", "b.csv", "repeated.npy", "noise.csv", "noise.png",
    }  # fmt: skip
    comparison = compare_repeated_scans(
        *(levelled(read_profile(tmp_path / name), "line") for name in ("a.csv", "b.csv"))
    )
    assert comparison.shift[0] == pytest.approx(0.25, abs=0.003)
    assert f"starts at x = {1000 * comparison.shift[0]:.3g} nm of the first scan." in " ".join(completed.stdout.split())
    assert np.array_equal(read_profile(tmp_path / "repeated.npy").heights, comparison.scan.heights)
    assert f"--cutoff '{1000 * comparison.limit:g} nm'" in " ".join(completed.stdout.split())
    for options, expected_words in (
        ([], "repeated.npy: already exists"),
        (["--together"], "must not be combined with --together"),
    ):
        assert_rejected(
            call_stiction("characterise", "a.csv", "b.csv", "--repeated", *options, cwd=tmp_path), expected_words
        )
    completed = call_stiction("characterise", "a.csv", "b.csv", "--repeated", "--json", cwd=tmp_path)
    record = json.loads(completed.stdout)
    assert (record["limit_um"], record["noise_slope_fraction"]) == (comparison.limit, comparison.slope_fraction)


def test_characterise_command_names_the_scan_with_spikes_and_ignores_the_spikes(tmp_path):
    surface = self_affine_surface(
        2, hurst_exponent=0.8, rms=0.05, shape=(96, 96), spacing=0.02, shortest_wavelength=0.2
    )
    random = np.random.default_rng(1)
    heights = [surface.heights + 1e-4 * random.normal(size=(96, 96)) for _ in range(2)]
    spiky_heights = heights[1].copy()
    spiky_heights.flat[[1000, 5000]] += 10 * heights[1].std()
    for name, values in (("a.npy", heights[0]), ("b.npy", heights[1]), ("spiky.npy", spiky_heights)):
        write_surface(Surface(values, spacing=0.02), tmp_path / name)

    def read_record(*arguments):
        return json.loads(check_stiction("characterise", "a.npy", *arguments, "--json", cwd=tmp_path).stdout)

    clean_record, spiky_record = (read_record(name, "--together") for name in ("b.npy", "spiky.npy"))
    np.testing.assert_allclose(
        spiky_record["spectrum"]["rms_gradient"], clean_record["spectrum"]["rms_gradient"], rtol=0.01
    )
    assert [scan["shortest_um"] for scan in spiky_record["scans"]] == [
        scan["shortest_um"] for scan in clean_record["scans"]
    ]
    assert clean_record["caveats"] == []
    (caveat,) = spiky_record["caveats"]
    assert caveat["text"].startswith("spiky.npy: 2 points ")
    assert read_record("spiky.npy", "--together", "--outliers", "mask")["caveats"] == []
    clean_record, spiky_record = (read_record(name, "--repeated") for name in ("b.npy", "spiky.npy"))
    assert spiky_record["noise_um"] == pytest.approx(clean_record["noise_um"], rel=0.01)
    assert spiky_record["limit_um"] == clean_record["limit_um"]
    assert clean_record["caveats"] == []
    (caveat,) = spiky_record["caveats"]
    assert caveat["text"].startswith("spiky.npy: 2 points ")
    output = check_stiction("characterise", "a.npy", "spiky.npy", "--repeated", cwd=tmp_path).stdout
    assert f"{caveat['text']}; {caveat['remedy']}" in " ".join(output.split())


def test_dry_run_option_prints_layout_and_unit_and_number_of_points_of_each_file(scans_directory):
    completed = check_stiction(
        "characterise",
        "scan.csv",
        "heights.npy",
        "--unit",
        "um",
        "--spacing",
        "10 nm",
        "--dry-run",
        cwd=scans_directory,
    )
    first_line, second_line = completed.stdout.splitlines()
    assert first_line.startswith(
        "scan.csv: positions and heights; 3000 points; 10 nm apart; heights from column 1 (z (um)) in um"
    )
    assert second_line.startswith("heights.npy: NumPy array; 3000 points; 10 nm apart")
    assert not list(scans_directory.glob("*.png"))
    completed = check_stiction("characterise", "scan.csv", "--dry-run", "--json", cwd=scans_directory)
    (file_record,) = json.loads(completed.stdout)["files"]
    assert (file_record["layout"], file_record["points"], file_record["caveats"]) == (
        "positions and heights",
        [3000],
        [],
    )


def test_undeclared_code_for_missing_points_is_reported_as_a_caveat(scans_directory):
    heights = np.load(scans_directory / "heights.npy")
    heights[[5, 70]] = -9999
    np.save(scans_directory / "codes.npy", heights)
    arguments = ["codes.npy", "--unit", "um", "--spacing", "10 nm", "--missing", "interpolate", "--dry-run"]
    completed = check_stiction("characterise", *arguments, cwd=scans_directory)
    assert "--missing-value -9999 treats them as missing points (repeated-extreme)" in completed.stderr
    completed = check_stiction("characterise", *arguments, "--missing-value", "-9999", cwd=scans_directory)
    assert completed.stderr == ""
    assert "2 of 3000 missing" in completed.stdout
