import contextlib
import pickle
import re
import tomllib

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from stiction import HertzCylinder, JacksonGreen, Study, Surface, friction_map, run, study_names
from stiction._units import exact_quantity_text, quantity
from stiction.mechanics.quantities import AREAL_SUM_QUANTITIES, HALF_SPACE_SUM_QUANTITIES, SUM_QUANTITIES
from stiction.study.measured_bodies import MeasuredBodySettings
from stiction.study.study import find_section_differences, parse_study
from stiction.study.values import StudyError
from stiction.views.study_keys import list_key_tables, study_keys_markdown, study_keys_text


class TestQuantityConversion:
    """Test the conversion of quantities with units to the units of the core."""

    @pytest.mark.parametrize(
        ("text", "kind", "value"),
        [
            ("0.1 um", "length", 0.1),
            ("100 nm", "length", 0.1),
            ("0.1 µm", "length", 0.1),
            ("100_000 pm", "length", 0.1),
            ("200 MPa", "pressure", 0.2),
            (".5 uN", "force", 5e-4),
        ],
    )
    def test_quantity_strings_are_converted_exactly_to_core_units(self, text, kind, value):
        assert quantity(text, kind) == value

    @pytest.mark.parametrize(
        ("text", "kind"),
        [
            ("200 parrots", "pressure"),
            (200, "pressure"),
            ("200 mPa", "pressure"),
            ("1 um", "pressure"),
            ("10**10**10 nm", "length"),
        ],
    )
    def test_invalid_quantity_string_is_rejected_with_a_short_message(self, text, kind):
        with pytest.raises(ValueError, match=kind) as error_info:
            quantity(text, kind)
        assert len(str(error_info.value)) < 200

    @pytest.mark.parametrize("text", ["nan nm", "inf nm", "1e999 nm", "1e300 um", "1" * 10_000 + " nm"])
    def test_out_of_range_quantity_is_rejected_with_a_short_message(self, text):
        with pytest.raises(ValueError, match=r"must be from 1e-06 to 1e\+06 um, got '") as error_info:
            quantity(text, "length")
        assert len(str(error_info.value)) < 200

    @given(st.floats(1e-12, 1e12))
    def test_exact_text_of_a_quantity_is_parsed_to_the_same_number(self, value):
        assert quantity(exact_quantity_text(value, "mN"), "force") == value

    @given(st.text(max_size=30))
    def test_random_quantity_string_is_parsed_to_a_finite_value_or_rejected(self, text):
        with contextlib.suppress(ValueError):
            assert np.isfinite(quantity(text, "length"))


class TestBuiltInStudies:
    """Test the built-in studies."""

    def test_built_in_studies_include_one_for_each_figure_of_the_paper(self):
        paper_names = ["figure2", "figure3", "figure5", "figure6", "figure7", "figure8", "quick"]
        other_names = ["figure6-areal", "figure6-half-plane"]
        assert study_names() == sorted([*paper_names, *other_names, "presliding"])
        figures_by_study = {name: Study.named(name).figures.draw for name in paper_names}
        assert figures_by_study["figure2"] == ("profiles",)
        assert figures_by_study["figure3"] == ("length-scales",)
        assert figures_by_study["figure5"] == figures_by_study["figure8"] == ("area",)
        assert figures_by_study["figure7"] == ("friction",)
        assert figures_by_study["figure6"] == figures_by_study["quick"] == ("friction", "area")
        for name in ("figure7", "figure8"):
            assert Study.named(name).surfaces.amplitudes().tolist() == [0.05, 0.1, 0.2]
        friction = Study.named("figure5").friction
        assert (friction.mu0, [float(tau0) for tau0 in friction.tau0]) == ((0.4,), [0.01])

    def test_study_rejects_unknown_and_repeated_figures(self):
        with pytest.raises(StudyError, match=r"figures.draw"):
            Study().with_changes({"figures.draw": ["heights"]})
        with pytest.raises(StudyError, match=r"figures.draw: must list each figure at most once"):
            Study().with_changes({"figures.draw": ["area", "area"]})

    def test_default_study_is_the_study_of_figure_6_in_the_paper(self):
        assert Study.named("figure6") == Study()
        surfaces, contact = Study().surfaces, Study().contact
        assert (surfaces.fractal_dimensions().size, surfaces.points, Study().ensemble.repetitions) == (50, 150_000, 100)
        assert contact.loading_steps()[[0, -1]].tolist() == pytest.approx([1e-4, 0.04])

    @pytest.mark.parametrize("name", study_names())
    def test_study_is_unchanged_by_writing_and_parsing_its_toml_text(self, name, tmp_path):
        study = Study.named(name)
        file = tmp_path / "study.toml"
        file.write_text(study.to_toml(), encoding="utf-8")
        assert Study.from_toml(file) == study
        assert pickle.loads(pickle.dumps(study)).to_toml() == study.to_toml()
        assert set(tomllib.loads(study.to_toml())) == {"surfaces", "contact", "friction", "ensemble", "figures"}

    def test_error_about_unknown_study_name_lists_the_built_in_names(self):
        with pytest.raises(StudyError, match=r"no built-in study 'figure66'; the studies are figure2, figure3"):
            Study.named("figure66")


class TestStudyChanges:
    """Test `Study.with_changes`."""

    def test_changing_a_study_by_dotted_keys_replaces_only_values_of_these_keys(self):
        study = Study().with_changes(
            {
                "ensemble.repetitions": 3, "surfaces.fractal_dimension": [1.2, 1.5], "contact.approach.count": 7,
                "contact.effective_modulus": "70 GPa",
            }
        )  # fmt: skip
        assert study.ensemble.repetitions == 3
        assert study.surfaces.fractal_dimensions().tolist() == [1.2, 1.5]
        assert study.contact.loading_steps().size == 7
        assert study.contact.effective_modulus == 70
        assert Study().ensemble.repetitions == 100

    def test_contact_law_of_a_study_accepts_a_table_of_parameters(self):
        assert PLASTIC_STUDY.contact.contact_model().law == JacksonGreen(yield_strength=0.2, poisson_ratio=0.3)
        cylinder = Study().with_changes({"contact.law": {"name": "hertz-cylinder", "width": "2 um"}})
        assert cylinder.contact.contact_model().law == HertzCylinder(width=2.0)
        assert Study().with_changes({"contact.law": "hertz-cylinder"}).contact.contact_model().law == "hertz-cylinder"

    def test_studies_with_equal_quantities_in_different_units_are_equal(self):
        changed_study = Study().with_changes({"surfaces.amplitude": ["100 nm"]})
        assert changed_study == Study()

    @pytest.mark.parametrize(
        ("study_key", "value", "message"),
        [
            ("ensemble.repetitons", 3, r"ensemble\.repetitons: unknown key; is it 'repetitions'\?"),
            ("ensembel.repetitions", 3, r"ensembel: unknown key; is it 'ensemble'\?"),
            ("ensemble.repetitions.more", 3, r"ensemble\.repetitions\.more: unknown key"),
            ("contact.approach.step", "1 nm", r"contact\.approach\.step: unknown key"),
            ("ensemble.repetitions", 0, r"ensemble\.repetitions: .*must be at least 1, got 0"),
            ("ensemble", 3, r"ensemble: must be a section"),
            ("surfaces.fractal_dimension", [1.0, 2.0], r"surfaces\.fractal_dimension\[1\]: .*must be below 2, got 2"),
            ("surfaces.fractal_dimension", 1.5, r"surfaces\.fractal_dimension: must be a list, or a section"),
            ("surfaces.fractal_dimension", [float("nan")], r"surfaces\.fractal_dimension\[0\]: .*finite"),
            (
                "surfaces.fractal_dimension.stop",
                1.0,
                r"surfaces\.fractal_dimension: must be a range whose stop is above its start",
            ),
            ("surfaces.fractal_dimension.count", 1, r"surfaces\.fractal_dimension: a range with count = 1"),
            ("surfaces.amplitude", ["200 parrots"], r"surfaces\.amplitude\[0\]: has the unit 'parrots'"),
            ("surfaces.amplitude", "0.1 um", r"surfaces\.amplitude: must be a list"),
            ("surfaces.convention", "textbook", r"surfaces\.convention: .*'paper' or 'classical'"),
            ("contact.approach.start", "0 nm", r"contact\.approach: a geometric range cannot start at 0"),
            ("contact.approach", ["2 nm", "1 nm"], r"contact\.approach: must increase, but 2 nm is followed by 1 nm"),
            ("contact.effective_modulus", "-10 GPa", r"contact\.effective_modulus: must be above 0"),
            ("contact.law", {"name": "jackson-green"}, r"contact\.law\.yield_strength: must be given"),
            ("contact.law", {"name": "jkr"}, r"contact\.law: must be"),
            ("friction.tau0", ["-1 MPa"], r"friction\.tau0\[0\]: must be at least 0"),
        ],
    )
    def test_error_about_changing_a_study_names_the_invalid_key(self, study_key, value, message):
        with pytest.raises(StudyError, match=message):
            Study().with_changes({study_key: value})


class TestStudyFiles:
    """Test the reading of study files and its error messages."""

    @pytest.mark.parametrize(
        ("content", "message"),
        [
            (b"\x89PNG\r\n\x1a\n\x00\x00\xff\xfe", "not a text file"),
            (b"\x00\x01\x02", "not valid TOML"),
            (b"points = 3", "points: unknown key"),
            (b"a = " + b"[" * 100_000, "not valid TOML"),
            (b"# " + b"x" * 2_000_000, "longer than"),
            (b"", "is empty"),
            (b"\n# only a comment\n", "is empty"),
        ],
    )
    def test_file_without_a_valid_study_is_rejected_with_a_short_message(self, tmp_path, content, message):
        file = tmp_path / "bad.toml"
        file.write_bytes(content)
        with pytest.raises(StudyError, match=message) as error_info:
            Study.from_toml(file)
        assert "bad.toml" in str(error_info.value)
        assert len(str(error_info.value)) < 500

    def test_missing_study_file_is_reported(self, tmp_path):
        for path in (tmp_path / "none.toml", tmp_path):
            with pytest.raises(StudyError, match="cannot be read"):
                Study.from_toml(path)

    def test_many_errors_in_a_study_file_are_reported_in_a_few_lines(self, tmp_path):
        file = tmp_path / "bad.toml"
        file.write_text("\n".join(f"key{i} = 1" for i in range(100)))
        with pytest.raises(StudyError) as error_info:
            Study.from_toml(file)
        assert len(str(error_info.value).splitlines()) == 6


MEASURED_STUDY_TEXT = """
[surfaces]
kind = "measured"
upper = { file = "scan.npy", unit = "nm", spacing = ["2 um", "0.5 um"] }
lower = { file = "other/scan.csv", columns = ["x", 3], channel = 0 }

[friction]
mu0 = [0.3, 0.4]
load = ["1 mN", "10 mN"]
"""
MEASURED_AREA_STUDY = parse_study(MEASURED_STUDY_TEXT, "areas")
MEASURED_LINE_STUDY = parse_study(
    MEASURED_STUDY_TEXT.replace('"measured"', '"measured"\npress = "lines"\noffsets = 4'), "lines"
)
SURFACE_STUDY = Study().with_changes({"surfaces.kind": "surface", "contact.direction": ["+x", 90]})
SELF_AFFINE_STUDY = SURFACE_STUDY.with_changes({"surfaces.generator": "self-affine"})
HALF_SPACE_STUDY = SURFACE_STUDY.with_changes({"contact.mechanics": "half-space", "contact.hardness": "1 GPa"})
PLASTIC_STUDY = Study().with_changes(
    {"contact.law": {"name": "jackson-green", "yield_strength": "200 MPa", "poisson_ratio": 0.3}}
)


class TestStudyKinds:
    """Test studies of different kinds of surfaces and contact models."""

    @pytest.mark.parametrize(
        "study",
        [SURFACE_STUDY, SELF_AFFINE_STUDY, HALF_SPACE_STUDY, PLASTIC_STUDY, MEASURED_AREA_STUDY, MEASURED_LINE_STUDY],
    )
    def test_study_is_unchanged_by_writing_and_parsing_its_text_and_by_pickling(self, study):
        assert parse_study(study.to_toml(), "text") == study
        assert pickle.loads(pickle.dumps(study)) == study
        assert study.with_changes({}) == study

    def test_changing_the_kind_of_a_study_preserves_shared_keys(self):
        study = Study().with_changes({"surfaces.gamma": 1.6, "contact.effective_modulus": "70 GPa"})
        study = study.with_changes({"surfaces.kind": "surface", "contact.mechanics": "half-space"})
        assert study.surfaces.gamma == 1.6
        assert study.contact.effective_modulus == 70
        assert study.with_changes({"contact.mechanics": "asperities"}).contact.detection == "gap-minimum"
        restored_study = study.with_changes({"surfaces.kind": "profile", "contact.mechanics": "asperities"})
        assert (restored_study.contact.detection, restored_study.surfaces.gamma) == ("cell", 1.6)

    def test_comparison_of_two_kinds_of_studies_lists_the_keys_of_both_studies(self):
        differences_by_key = {
            study_key: (first_value, second_value)
            for study_key, first_value, second_value in find_section_differences(Study(), SELF_AFFINE_STUDY)
        }
        assert differences_by_key["surfaces.kind"] == ('"profile"', '"surface"')
        assert differences_by_key["surfaces.points"] == ("150_000", "none")
        assert not list(find_section_differences(MEASURED_AREA_STUDY, MEASURED_AREA_STUDY))

    @pytest.mark.parametrize(
        ("study", "sums", "step", "cells"),
        [
            (Study(), SUM_QUANTITIES, "approach", ["fractal_dimension", "amplitude"]),
            (SURFACE_STUDY, SUM_QUANTITIES + AREAL_SUM_QUANTITIES, "approach", ["fractal_dimension", "amplitude"]),
            (HALF_SPACE_STUDY, HALF_SPACE_SUM_QUANTITIES, "load", ["fractal_dimension", "amplitude"]),
            (MEASURED_AREA_STUDY, HALF_SPACE_SUM_QUANTITIES, "load", ["cut_off"]),
            (MEASURED_LINE_STUDY, (*SUM_QUANTITIES, "approach"), "load", ["cut_off"]),
        ],
    )
    def test_kind_of_a_study_determines_contact_sums_and_step_quantity_and_cell_coordinates(
        self, study, sums, step, cells
    ):
        assert (study.contact_sum_names(), study.step_quantity, list(study.surfaces.cell_coordinates())) == (
            sums,
            step,
            cells,
        )

    @pytest.mark.parametrize(
        ("study", "study_key", "value"),
        [
            (SURFACE_STUDY, "surfaces.points", 100),
            (Study(), "surfaces.kind", "line"),
            (SURFACE_STUDY, "surfaces.extent", "1 um"),
            (SURFACE_STUDY, "surfaces.shape", [100_000, 100_000]),
            (SELF_AFFINE_STUDY, "surfaces.longest_wavelength", "30 um"),
            (SELF_AFFINE_STUDY, "surfaces.shortest_wavelength", "1 nm"),
            (SURFACE_STUDY, "contact.detection", "cell"),
            (SURFACE_STUDY, "contact.law", "hertz-cylinder"),
            (HALF_SPACE_STUDY, "contact.law", "hertz-sphere"),
            (HALF_SPACE_STUDY, "contact.load", ["1 N"]),
            (SURFACE_STUDY, "contact.direction", ["+x", 360]),
            (SURFACE_STUDY, "contact.direction", []),
            (SURFACE_STUDY, "contact.direction", "north"),
            (Study(), "contact.direction", 90),
            (SURFACE_STUDY, "contact.sliding", "both"),
            (SURFACE_STUDY, "figures.draw", ["profiles"]),
            (MEASURED_AREA_STUDY, "surfaces.level", "line"),
            (MEASURED_AREA_STUDY, "surfaces.upper.fil", "scan.npy"),
            (MEASURED_AREA_STUDY, "surfaces.upper.spacing", ["1 um", "1 um", "1 um"]),
            (MEASURED_AREA_STUDY, "surfaces.upper.unit", "inch"),
            (MEASURED_AREA_STUDY, "surfaces.upper.columns", [0, -1]),
            (MEASURED_AREA_STUDY, "contact.direction", [index / 2 for index in range(500)]),
            (MEASURED_AREA_STUDY, "friction.load", ["1 N"]),
            (MEASURED_AREA_STUDY, "figures.draw", ["area"]),
        ],
    )
    def test_error_about_changing_the_kind_of_a_study_names_the_changed_key(self, study, study_key, value):
        with pytest.raises(StudyError) as error_info:
            study.with_changes({study_key: value})
        assert f"changes: {study_key}" in str(error_info.value)
        assert len(str(error_info.value)) < 400

    def test_error_for_a_key_of_the_wrong_surface_kind_names_both_kinds(self):
        with pytest.raises(StudyError, match=r"belongs to fractal profiles, not to Weierstrass-Mandelbrot surfaces"):
            SURFACE_STUDY.with_changes({"surfaces.points": 100})
        with pytest.raises(StudyError, match=r"belongs to areas of measured maps, not to lines of measured files"):
            MEASURED_LINE_STUDY.with_changes({"surfaces.rotate": 3.0})

    def test_study_rejects_too_many_combinations_of_loads_with_mu0_and_tau0(self):
        strengths = {
            "friction.mu0": [index / 100 for index in range(100)],
            "friction.tau0": ["0 MPa", "1 MPa", "2 MPa"],
        }
        with pytest.raises(StudyError, match=r"friction: .*at most 1000, got 600|at most 1000"):
            MEASURED_AREA_STUDY.with_changes(strengths | {"friction.load": [f"{1 + index} mN" for index in range(8)]})


class TestMeasuredStudies:
    """Test studies of measured surfaces."""

    def test_measured_study_has_both_sliding_rules_and_all_directions_by_default(self):
        assert MEASURED_AREA_STUDY.motion_coordinates() == {
            "sliding": ["all", "opposing"],
            "direction": [30.0 * step for step in range(12)],
        }
        assert MEASURED_LINE_STUDY.motion_coordinates() == {"sliding": ["all", "opposing"], "direction": [0.0, 180.0]}
        assert MEASURED_AREA_STUDY.with_changes({"contact.direction": -330}).motion_coordinates()["direction"] == [30.0]

    def test_load_steps_of_a_measured_study_extend_below_and_above_the_requested_loads(self):
        assert MEASURED_AREA_STUDY.contact.loading_steps() == pytest.approx([10**-0.5, 1, 10**0.5, 10, 10**1.5])
        for study in (MEASURED_LINE_STUDY, MEASURED_LINE_STUDY.with_changes({"contact.mechanics": "half-space"})):
            steps = study.contact.loading_steps()
            assert {1.0, 10.0} <= set(steps)
            assert steps[0] < 0.2
            assert steps[-1] > 90
        with pytest.raises(StudyError, match=r"contact.load"):
            parse_study(MEASURED_STUDY_TEXT.replace('load = ["1 mN", "10 mN"]', ""), "no load")

    def test_paths_in_a_study_file_are_relative_to_its_directory_and_scans_have_checksums(self, tmp_path, monkeypatch):
        heights = np.random.default_rng(1).normal(size=(24, 20))
        np.save(tmp_path / "scan.npy", heights)
        text = MEASURED_STUDY_TEXT.replace(
            '"other/scan.csv", columns = ["x", 3], channel = 0', '"scan.npy", unit = "um"'
        )
        text = text.replace(', unit = "um" }', ', unit = "um", spacing = "1 um" }')
        (tmp_path / "study.toml").write_text(text, encoding="utf-8")
        study = Study.from_toml(tmp_path / "study.toml")
        assert study.surfaces.upper.file == str(tmp_path / "scan.npy")
        body = study.surfaces.upper.read()
        assert body.spacing == (2.0, 0.5)
        assert body.heights == pytest.approx(heights / 1000)
        study_with_checksums = study.with_checksums()
        assert study_with_checksums == parse_study(study_with_checksums.to_toml(), "itself")
        assert study_with_checksums.surfaces.lower.read().heights.shape == (24, 20)
        np.save(tmp_path / "scan.npy", heights[:, ::-1])
        assert study.surfaces.upper.read().heights.shape == (24, 20)
        with pytest.raises(ValueError, match=r"scan\.npy has changed since"):
            study_with_checksums.surfaces.upper.read()
        assert study_with_checksums.with_checksums() == study_with_checksums
        monkeypatch.chdir(tmp_path)
        assert parse_study(text, "here").with_checksums().surfaces.upper.file == str(tmp_path / "scan.npy")
        with pytest.raises(ValueError, match="cannot be read"):
            MEASURED_AREA_STUDY.surfaces.upper.with_absolute_paths(tmp_path / "none").with_checksums()
        assert Study().with_checksums() == Study()


def test_checksum_of_a_body_in_memory_depends_on_its_numbers_but_not_on_its_history(tmp_path):
    heights = np.random.default_rng(1).normal(size=(6, 4))
    entries = [
        MeasuredBodySettings.from_body(Surface(heights, spacing=(0.5, 0.25), history=(step,)), "first")
        for step in ("turned over", "flipped")
    ]
    assert entries[0].sha256 == entries[1].sha256
    assert entries[0] != entries[1]
    saved_entries = [entry.with_saved_bodies(tmp_path, "upper") for entry in entries]
    assert saved_entries[0] == saved_entries[1]
    assert saved_entries[1].read().history == ("read from upper.npy", "turned over")
    missing = np.zeros(heights.shape, bool)
    missing[2, 3] = True
    other_bodies = (
        Surface(heights, spacing=(0.25, 0.25)),
        Surface(heights.reshape(4, 6), spacing=(0.5, 0.25)),
        Surface(heights * (1 + 1e-15), spacing=(0.5, 0.25)),
        Surface(heights, spacing=(0.5, 0.25), missing=missing),
    )
    checksums = {MeasuredBodySettings.from_body(body, "first").sha256 for body in other_bodies}
    assert len({entries[0].sha256, *checksums}) == 5


RANDOM_VALUE_TEXTS = [
    "", "3", "-1", "1.5", "true", "inf", "nan", '""', '"surface"', '"measured"', '"lines"', '"half-space"',
    '"self-affine"', '"1 um"', '"10 mN"', '["10 mN"]', '["1 um", "1 um"]', "[]", "[[1]]", "{}", '{ file = "x" }',
    "{ start = 1.0, stop = 1.7, count = 3 }", '{ name = "jackson-green" }', "1979-05-27", "9" * 400,
]  # fmt: skip


@pytest.mark.parametrize("seed", range(4))
def test_randomly_mutated_study_file_is_either_read_or_rejected(seed):
    random = np.random.default_rng(seed)
    texts = [
        study.to_toml().splitlines()
        for study in (
            Study(),
            SURFACE_STUDY,
            SELF_AFFINE_STUDY,
            HALF_SPACE_STUDY,
            MEASURED_AREA_STUDY,
            MEASURED_LINE_STUDY,
        )
    ]
    num_accepted = 0
    for _ in range(300):
        lines = list(texts[random.integers(len(texts))])
        for _ in range(random.integers(1, 4)):
            line_index, study_key = (
                (changed_line := int(random.integers(len(lines)))),
                lines[changed_line].partition("=")[0],
            )
            other_lines = texts[random.integers(len(texts))]
            lines[line_index] = random.choice(
                [f"{study_key}= {random.choice(RANDOM_VALUE_TEXTS)}", random.choice(other_lines), ""]
            )
        try:
            study = parse_study("\n".join(lines), "changed")
        except StudyError:
            continue
        num_accepted += 1
        assert parse_study(study.to_toml(), "itself") == study
        assert study.contact.loading_steps().size
        assert set(study.motion_coordinates()) <= {"sliding", "direction"}
    assert num_accepted


def test_built_in_studies_of_figures_7_and_8_have_the_amplitudes_of_the_paper():
    for name in ("figure7", "figure8"):
        assert Study.named(name).surfaces.amplitudes().tolist() == [0.05, 0.1, 0.2]


def test_built_in_study_of_figure_5_has_mu0_and_tau0_of_the_paper():
    friction = Study.named("figure5").friction
    assert friction.mu0 == (0.4,)
    assert [float(tau0) for tau0 in friction.tau0] == [0.01]


class TestRequestedLoads:
    """Test requested loads of studies of generated surfaces, and the solved loads around them."""

    LISTED_LOADS_STUDY = SELF_AFFINE_STUDY.with_changes(
        {"contact.mechanics": "half-space", "contact.load": ["0.04 mN", "4 mN"]}
    )

    def test_load_steps_of_a_generated_study_extend_below_and_above_the_requested_loads(self):
        assert [float(load) for load in self.LISTED_LOADS_STUDY.friction.load] == [0.04, 4.0]
        assert self.LISTED_LOADS_STUDY.contact.loading_steps() == pytest.approx(
            [0.04 / 10**0.5, 0.04, 4.0, 4.0 * 10**0.5], rel=1e-5
        )
        options = {"contact.mechanics": "half-space", "friction.load": ["0.1 mN", "0.2 mN"]}
        study = SELF_AFFINE_STUDY.with_changes(
            options | {"contact.load": {"start": "0.05 mN", "stop": "1 mN", "count": 5}}
        )
        assert study.contact.loading_steps()[0] == 0.05, "given loads of the curve are unchanged"

    def test_load_steps_of_a_study_stay_below_hardness_times_nominal_area(self):
        study_with_hardness = self.LISTED_LOADS_STUDY.with_changes(
            {"contact.hardness": "60 MPa", "contact.load": ["4 mN"]}
        )
        assert 4.0 < study_with_hardness.contact.loading_steps()[-1] < 0.06 * 100
        with pytest.raises(StudyError, match=r"contact\.load: must be below hardness times nominal area"):
            self.LISTED_LOADS_STUDY.with_changes({"contact.hardness": "10 MPa"})

    def test_changing_the_load_or_contact_model_of_a_study_replaces_the_requested_loads(self):
        assert [
            float(load) for load in self.LISTED_LOADS_STUDY.with_changes({"contact.load": ["1 mN"]}).friction.load
        ] == [1.0]
        assert [
            float(load) for load in self.LISTED_LOADS_STUDY.with_changes({"friction.load": ["9 mN"]}).friction.load
        ] == [9.0]
        assert self.LISTED_LOADS_STUDY.with_changes({"contact.mechanics": "asperities"}).friction.load == ()
        assert (
            parse_study(self.LISTED_LOADS_STUDY.to_toml(), "text")
            == self.LISTED_LOADS_STUDY
            == self.LISTED_LOADS_STUDY.with_changes({})
        )

    def test_friction_map_of_a_study_has_values_at_all_requested_loads(self):
        ensemble_changes = {
            "surfaces.shape": [32, 32],
            "ensemble.repetitions": 4,
            "surfaces.fractal_dimension": [1.2, 1.5],
        }
        study = self.LISTED_LOADS_STUDY.with_changes(
            ensemble_changes | {"surfaces.amplitude": ["20 nm"], "contact.boundary": "periodic"}
        )
        dataset = run(study).dataset
        assert dataset.sizes["load"] == 4
        friction = friction_map(dataset, [float(load) for load in study.friction.load], mu0=[0.4], tau0=[0.01])
        assert set(friction["status"].values.ravel().tolist()) == {"ok"}


class TestStudyKeys:
    """Test keys of study files: their documentation, alternative names and messages about unknown keys."""

    def test_documented_types_of_study_keys_match_their_parsers(self):
        documented_values = {}
        for title, _, rows in list_key_tables():
            for study_key, _, values, _ in rows:
                documented_values.setdefault((title, study_key.strip("`")), values)
        assert documented_values["`[contact]`", "work_of_adhesion"] == "an energy per area, at least 0"
        assert documented_values["`[surfaces]`, measured", "gap"] == "`true`"
        assert documented_values["`[contact]`", "adhesion_range"] == "a length above 0"
        for study_key, kind in (("effective_modulus", "a pressure"), ("hardness", "a pressure"), ("creep", "a number")):
            table = "`[friction]`" if study_key == "creep" else "`[contact]`"
            assert documented_values[table, study_key] == f"{kind}, a range or a value with its uncertainty"
        assert "hurst_exponent" in study_keys_text()

    def test_documentation_lists_allowed_values_and_default_of_each_study_key_in_one_table_cell(self):
        rows = [line for line in study_keys_markdown().splitlines() if line.startswith("| `")]
        assert '| `missing` | `"error"`, `"interpolate"` or `"mask"`; default `"error"` |' in "\n".join(rows)
        assert "| `file` | a name; required |" in "\n".join(rows)
        assert "| `indent` | a length above 0 |" in "\n".join(rows)
        assert {row.count(" | ") for row in rows} == {2}

    def test_self_affine_study_accepts_the_parameter_names_of_the_self_affine_function(self):
        changes = {"surfaces.hurst_exponent": [0.5, 0.8], "surfaces.rms": ["20 nm"], "surfaces.spacing": "0.1 um"}
        surfaces = SELF_AFFINE_STUDY.with_changes(changes | {"surfaces.shape": [64, 32]}).surfaces
        assert surfaces.fractal_dimensions() == pytest.approx([1.2, 1.5])
        assert (surfaces.amplitude_measure, surfaces.amplitudes().tolist()) == ("Sq", [0.02])
        assert surfaces.extents() == pytest.approx((6.4, 3.2))
        study_of_range = SELF_AFFINE_STUDY.with_changes(
            {"surfaces.hurst_exponent": {"start": 0.4, "stop": 0.8, "count": 5}}
        )
        assert study_of_range.surfaces.fractal_dimensions() == pytest.approx([1.2, 1.3, 1.4, 1.5, 1.6])

    @pytest.mark.parametrize(
        ("study", "study_key", "message"),
        [
            (SELF_AFFINE_STUDY, "surfaces.hurst", "is it 'hurst_exponent'"),
            (SURFACE_STUDY, "contact.modulus", "'effective_modulus'"),
            (Study(), "contact.xyzzy", "stiction studies --keys lists all"),
            (SELF_AFFINE_STUDY, "surfaces.hurst_exponent", "surfaces.hurst_exponent: must be"),
        ],
    )
    def test_error_about_an_unknown_key_suggests_the_nearest_key(self, study, study_key, message):
        with pytest.raises(StudyError, match=re.escape(message)):
            study.with_changes({study_key: "much"})
