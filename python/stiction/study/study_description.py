"""Description of a study for reports: name, text of the study file, and differences from the defaults."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from stiction.study.study import Study, find_section_differences, study_names
from stiction.surfaces.pairing import SIDES


@dataclass(frozen=True)
class StudyDescription:
    """Description of a study for reports: its name, the text of its file, and its differences from the defaults.

    Attributes
    ----------
    name : str
        For measured surfaces, the file names. Otherwise the name of the built-in study that differs at most in the
        repetitions, or "study".
    file_text : str
        Study file (TOML) with names of files but without their directories, which other computers do not have.
    changed_settings : list of (str, str)
        Keys of a study of generated surfaces whose values differ from the defaults, and the values as text.
    """

    name: str
    file_text: str
    changed_settings: list[tuple[str, str]]


def describe_study(study: Study) -> StudyDescription:
    """Describe a study for reports by its name, the text of its file, and its differences from the defaults."""
    if study.is_measured:
        return StudyDescription(get_pair_name(study), _strip_directories(study).to_toml(), [])
    name, file_text = _find_built_in_name(study), study.to_toml()
    return StudyDescription(
        name, file_text, [(key, value) for key, _, value in find_section_differences(Study(), study)]
    )


def get_pair_name(study: Study) -> str:
    """Return the name of a measured pair from its files, as in "a on b", or of a gap, as in "gap a"."""
    upper, lower = (getattr(study.surfaces, side).name for side in SIDES)
    if study.is_gap:
        return upper if "gap" in upper.lower() else f"gap {upper}"
    return f"{upper} on {lower}"


def _strip_directories(study: Study) -> Study:
    surfaces: Any = study.surfaces
    changes: dict[str, Any] = {"surfaces": surfaces.with_changed_files(lambda file, _: file.without_directories())}
    if (interface := study.friction.interface) is not None:
        interface = interface.model_copy(update={"file": interface.name})
        changes["friction"] = study.friction.model_copy(update={"interface": interface})
    return study.model_copy(update=changes)


def _find_built_in_name(study: Study) -> str:
    for name in study_names():
        built_in_study = Study.named(name)
        ensemble = built_in_study.ensemble.model_copy(update={"repetitions": study.ensemble.repetitions})
        if built_in_study.model_copy(update={"ensemble": ensemble}) == study:
            return name
    return "study"
