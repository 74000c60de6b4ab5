import contextlib
import pickle
import tomllib

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from stiction import HertzCylinder, JacksonGreen, Study, study_names
from stiction._units import quantity
from stiction.studies.study_text import StudyError


class TestQuantities:
    @pytest.mark.parametrize(
        ("text", "kind", "value"),
        [
            ("0.1 um", "length", 0.1),
            ("100 nm", "length", 0.1),
            ("100nm", "length", 0.1),
            (" 1e-4 mm ", "length", 0.1),
            ("0.1 µm", "length", 0.1),
            ("0.1 μm", "length", 0.1),
            ("100_000 pm", "length", 0.1),
            ("200 MPa", "pressure", 0.2),
            ("2e8 Pa", "pressure", 0.2),
            ("10 GPa", "pressure", 10.0),
            (".5 uN", "force", 5e-4),
        ],
    )
    def test_are_read_into_core_units_exactly(self, text, kind, value):
        assert quantity(text, kind) == value

    @pytest.mark.parametrize(
        ("text", "kind"),
        [
            ("200 parrots", "pressure"),
            ("200", "pressure"),
            (200, "pressure"),
            (None, "pressure"),
            ("200 mPa", "pressure"),
            ("1 um", "pressure"),
            ("10**10**10 nm", "length"),
            ("1 nm nm", "length"),
            ("1/0 nm", "length"),
            ("nan nm", "length"),
            ("inf nm", "length"),
            ("1e999 nm", "length"),
            ("1" * 10_000 + " nm", "length"),
            ("", "length"),
            ("٣ nm", "length"),
        ],
    )
    def test_what_is_none_is_refused_shortly(self, text, kind):
        with pytest.raises(ValueError, match=kind) as caught:
            quantity(text, kind)
        assert len(str(caught.value)) < 200

    @given(st.text(max_size=30))
    def test_any_text_is_read_or_refused(self, text):
        with contextlib.suppress(ValueError):
            assert np.isfinite(quantity(text, "length"))


class TestLibrary:
    def test_has_the_papers_studies(self):
        names = ["figure2", "figure3", "figure5", "figure6", "figure7", "figure8", "quick"]
        areal = ["figure6-areal", "figure6-half-plane"]
        assert study_names() == sorted(names + areal)
        drawn = {name: Study.named(name).figures.draw for name in names}
        assert drawn["figure2"] == ("profiles",)
        assert drawn["figure3"] == ("length-scales",)
        assert drawn["figure5"] == drawn["figure8"] == ("area",)
        assert drawn["figure7"] == ("friction",)
        assert drawn["figure6"] == drawn["quick"] == ("friction", "area")

    def test_figures_7_and_8_have_the_papers_amplitudes(self):
        for name in ("figure7", "figure8"):
            assert Study.named(name).surfaces.amplitudes().tolist() == [0.05, 0.1, 0.2]

    def test_an_unknown_figure_is_refused(self):
        with pytest.raises(StudyError, match=r"figures.draw"):
            Study().with_changes({"figures.draw": ["heights"]})
        with pytest.raises(StudyError, match=r"figures.draw: must name each figure once"):
            Study().with_changes({"figures.draw": ["area", "area"]})

    def test_figure6_is_the_default(self):
        assert Study.named("figure6") == Study()
        surfaces, contact = Study().surfaces, Study().contact
        assert (surfaces.fractal_dimensions().size, surfaces.points, Study().ensemble.repetitions) == (50, 150_000, 100)
        assert contact.approaches()[[0, -1]].tolist() == pytest.approx([1e-4, 0.04])

    def test_figure5_has_the_papers_friction(self):
        friction = Study.named("figure5").friction
        assert friction.mu0 == (0.4,)
        assert [float(tau0) for tau0 in friction.tau0] == [0.01]

    @pytest.mark.parametrize("name", study_names())
    def test_studies_survive_their_own_text(self, name, tmp_path):
        study = Study.named(name)
        file = tmp_path / "study.toml"
        file.write_text(study.to_toml(), encoding="utf-8")
        assert Study.from_toml(file) == study
        assert pickle.loads(pickle.dumps(study)).to_toml() == study.to_toml()
        assert set(tomllib.loads(study.to_toml())) == {"surfaces", "contact", "friction", "ensemble", "figures"}

    def test_unknown_names_list_the_known(self):
        with pytest.raises(StudyError, match=r"no built-in study 'figure66'; there are figure2, figure3, figure5"):
            Study.named("figure66")


class TestChanges:
    def test_replace_values_by_dotted_key(self):
        study = Study().with_changes(
            {
                "ensemble.repetitions": 3,
                "surfaces.fractal_dimension": [1.2, 1.5],
                "contact.approach.count": 7,
                "contact.effective_modulus": "70 GPa",
            }
        )
        assert study.ensemble.repetitions == 3
        assert study.surfaces.fractal_dimensions().tolist() == [1.2, 1.5]
        assert study.contact.approaches().size == 7
        assert study.contact.effective_modulus == 70
        assert Study().ensemble.repetitions == 100

    def test_laws_with_parameters_are_tables(self):
        study = Study().with_changes(
            {"contact.law": {"name": "jackson-green", "yield_strength": "200 MPa", "poisson_ratio": 0.3}}
        )
        assert study.contact.model().law == JacksonGreen(yield_strength=0.2, poisson_ratio=0.3)
        assert study.with_changes({}).to_toml() == study.to_toml()
        cylinder = Study().with_changes({"contact.law": {"name": "hertz-cylinder", "width": "2 um"}})
        assert cylinder.contact.model().law == HertzCylinder(width=2.0)
        assert Study().with_changes({"contact.law": "hertz-cylinder"}).contact.model().law == "hertz-cylinder"

    def test_equal_quantities_are_equal_studies(self):
        changed = Study().with_changes({"surfaces.amplitude": ["100 nm"]})
        assert changed == Study()

    @pytest.mark.parametrize(
        ("key", "value", "message"),
        [
            ("ensemble.repetitons", 3, r"ensemble\.repetitons: unknown key; is it 'repetitions'\?"),
            ("ensembel.repetitions", 3, r"ensembel: unknown key; is it 'ensemble'\?"),
            ("ensemble.repetitions.more", 3, r"ensemble\.repetitions\.more: unknown key"),
            ("contact.approach.step", "1 nm", r"contact\.approach\.step: unknown key"),
            ("ensemble.repetitions", 0, r"ensemble\.repetitions: .*greater than or equal to 1, got 0"),
            ("ensemble.repetitions", 2.5, r"ensemble\.repetitions: .*valid integer"),
            ("ensemble.repetitions", True, r"ensemble\.repetitions: .*valid integer"),
            ("ensemble", 3, r"ensemble: must be a table"),
            ("ensemble.seed", -1, r"ensemble\.seed"),
            ("surfaces.fractal_dimension", [1.0, 2.0], r"surfaces\.fractal_dimension\[1\]: .*less than 2, got 2"),
            ("surfaces.fractal_dimension", [1.5, 1.2], r"surfaces\.fractal_dimension: must increase"),
            ("surfaces.fractal_dimension", 1.5, r"surfaces\.fractal_dimension: must be a list, or a table"),
            ("surfaces.fractal_dimension", [], r"surfaces\.fractal_dimension: .*at least 1 item"),
            ("surfaces.fractal_dimension", [float("nan")], r"surfaces\.fractal_dimension\[0\]: .*finite"),
            ("surfaces.fractal_dimension.stop", 0.5, r"surfaces\.fractal_dimension\.stop: .*greater"),
            ("surfaces.fractal_dimension.stop", 1.0, r"surfaces\.fractal_dimension: must stop above its start"),
            ("surfaces.fractal_dimension.count", 1, r"surfaces\.fractal_dimension: a range of count 1"),
            ("surfaces.amplitude", ["200 parrots"], r"surfaces\.amplitude\[0\]: has the unit 'parrots'"),
            ("surfaces.amplitude", ["0 nm"], r"surfaces\.amplitude\[0\]: must be above 0"),
            ("surfaces.amplitude", "0.1 um", r"surfaces\.amplitude: must be a list"),
            ("surfaces.length_scale", "1", r"surfaces\.length_scale: .*unit of length"),
            ("surfaces.length_scale", 1.0, r"surfaces\.length_scale: needs a length with its unit"),
            ("surfaces.extent", "10**10**10 nm", r"surfaces\.extent: "),
            ("surfaces.points", 3, r"surfaces\.points"),
            ("surfaces.gamma", 1.0, r"surfaces\.gamma"),
            ("surfaces.convention", "textbook", r"surfaces\.convention: .*'paper' or 'classical'"),
            ("contact.approach.start", "0 nm", r"contact\.approach: a geometric range cannot start at 0"),
            ("contact.approach", ["2 nm", "1 nm"], r"contact\.approach: must increase, but 2 nm is followed by 1 nm"),
            ("contact.law", "jkr", r"contact\.law"),
            ("contact.effective_modulus", "-10 GPa", r"contact\.effective_modulus: must be above 0"),
            ("surfaces.length_scale", "1e9 m", r"surfaces\.length_scale: must be from 1e-06 to 1e\+06 um"),
            ("contact.law", {"name": "jackson-green"}, r"contact\.law\.yield_strength: .*required"),
            ("contact.law", {"name": "jkr"}, r"contact\.law: must be"),
            ("contact.law.width", "1 um", r"contact\.law\.width: unknown key"),
            ("friction.mu0", [-0.1], r"friction\.mu0\[0\]"),
            ("friction.tau0", ["-1 MPa"], r"friction\.tau0\[0\]: must be at least 0"),
        ],
    )
    def test_faults_name_their_key(self, key, value, message):
        with pytest.raises(StudyError, match=message):
            Study().with_changes({key: value})

    def test_a_repetition_that_no_worker_holds_is_refused(self):
        many = {"start": 1.0, "stop": 1.9, "count": 10_000}
        with pytest.raises(
            StudyError, match=r"a repetition would take 18 GiB, more than 16: take fewer contact\.approach"
        ):
            Study().with_changes(
                {
                    "surfaces.fractal_dimension": many,
                    "contact.approach.count": 10_000,
                    "surfaces.amplitude": ["1 nm", "2 nm"],
                }
            )


class TestFiles:
    @pytest.mark.parametrize(
        ("content", "message"),
        [
            (b"\x89PNG\r\n\x1a\n\x00\x00\xff\xfe", "not a text file"),
            (b"\x00\x01\x02", "not TOML"),
            (b"[surfaces", "not TOML"),
            (b"points = 3", "points: unknown key"),
            (b"a = " + b"[" * 100_000, "not TOML"),
            (b"# " + b"x" * 2_000_000, "longer than"),
            (b"[surfaces]\npoints = 10\n[surfaces]\n", "not TOML"),
        ],
    )
    def test_what_is_no_study_is_said_so(self, tmp_path, content, message):
        file = tmp_path / "bad.toml"
        file.write_bytes(content)
        with pytest.raises(StudyError, match=message) as caught:
            Study.from_toml(file)
        assert "bad.toml" in str(caught.value)
        assert len(str(caught.value)) < 500

    def test_missing_files_and_directories_are_said_so(self, tmp_path):
        for path in (tmp_path / "none.toml", tmp_path):
            with pytest.raises(StudyError, match="cannot be read"):
                Study.from_toml(path)

    def test_many_faults_are_told_in_a_few_lines(self, tmp_path):
        file = tmp_path / "bad.toml"
        file.write_text("\n".join(f"key{i} = 1" for i in range(100)))
        with pytest.raises(StudyError) as caught:
            Study.from_toml(file)
        assert len(str(caught.value).splitlines()) == 6
