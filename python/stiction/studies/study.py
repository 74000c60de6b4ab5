"""What to compute: a study, validated, from a TOML file or the built-in library."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from pydantic import Field, ValidationInfo, field_validator, model_validator
from pydantic_core import PydanticCustomError

from stiction._files import NotReadableError, content, reason
from stiction._text import LONGEST_NAME, named, printable
from stiction._units import exactly, quantity, shortened
from stiction.mechanics.model import THICKNESS
from stiction.mechanics.quantities import AREAL_SUMS, DIRECTED, HALF_SPACE_SUMS, ONSET, SUMS
from stiction.studies.contact_tables import Asperities, ByAsperities, Contact, HalfSpace
from stiction.studies.generated_surfaces import Profiles
from stiction.studies.ladder import ladder
from stiction.studies.measured_surfaces import Measured
from stiction.studies.tables import (
    Ensemble,
    Figures,
    Friction,
    MeasuredFriction,
    Surfaces,
    contact_case,
    read_contact,
    read_friction,
    read_surfaces,
    surfaces_case,
)
from stiction.studies.text import StudyError, as_toml, toml, validated
from stiction.studies.values import Table

if TYPE_CHECKING:
    import xarray

MOST_MEMORY = 16 * 2**30
"""Largest number of bytes of a repetition of a result."""

LONGEST_FILE = 1_000_000
"""Largest number of bytes of a study file; a study is a page."""

MOST_ANSWERS = 1000
"""Largest number of loads times mu0 times tau0 of measured surfaces."""

_CASE_KEYS = {"surfaces": ("kind", "generator", "press"), "contact": ("mechanics",)}
"""Keys that say which case a table is of."""

_FIRST = (
    "kind", "generator", "press", "upper", "lower", "mechanics", "effective_modulus", "law", "detection", "curvature",
)  # fmt: skip
"""Keys that stand first in their tables."""


def _empty() -> Any:
    """A table that says nothing, from which the case that goes with the surfaces is made."""
    return {}


class Study(Table):
    """A study: which pairs of surfaces, how they are pressed, over which parameters.

    Tables left out, and keys left out of tables, take the values of the paper's Fig. 6. Quantities are
    "number unit" in files and plain numbers in core units (µm, GPa, mN) inside. Keys belong to a kind of surfaces or
    of mechanics; those of another kind are refused.

    Examples
    --------
    >>> from stiction import Study
    >>> study = Study.named("figure6").with_changes({"ensemble.repetitions": 10})
    >>> study.ensemble.repetitions, float(study.surfaces.extent)
    (10, 40.0)
    """

    surfaces: Surfaces = Profiles()
    contact: Contact = Field(default_factory=_empty)
    friction: Friction | MeasuredFriction = Field(default_factory=_empty)
    ensemble: Ensemble = Ensemble()
    figures: Figures = Figures()

    @model_validator(mode="before")
    @classmethod
    def _with_loads_around_those_asked_for(cls, given: Any) -> Any:
        """A study of measured surfaces that says no `contact.load` is pressed to loads around `friction.load`."""
        if not isinstance(given, Mapping):
            return given
        surfaces, contact, friction = (given.get(name, {}) for name in ("surfaces", "contact", "friction"))
        tables = all(isinstance(table, Mapping) for table in (surfaces, contact, friction))
        if not tables or surfaces.get("kind") != "measured" or "load" in contact or "load" not in friction:
            return given
        try:
            mechanics = contact_case(surfaces_case(surfaces), contact).model_fields["mechanics"].default
            loads = [float(quantity(load, "force")) for load in friction["load"]]
            around = ladder(loads, press=surfaces.get("press", "areas"), mechanics=mechanics)
        except (ValueError, TypeError):  # said of the key that is wrong
            return given
        return {**given, "contact": {**contact, "load": [exactly(load, "mN") for load in around.tolist()]}}

    @field_validator("surfaces", mode="before")
    @classmethod
    def _read_surfaces(cls, value: object) -> Surfaces:
        return read_surfaces(value)

    @field_validator("contact", mode="before")
    @classmethod
    def _read_contact(cls, value: object, info: ValidationInfo) -> Contact:
        """The contact that goes with the surfaces; where these are wrong, nothing is said of it."""
        return read_contact(value, info.data["surfaces"]) if "surfaces" in info.data else Asperities()

    @field_validator("friction", mode="before")
    @classmethod
    def _read_friction(cls, value: object, info: ValidationInfo) -> Friction | MeasuredFriction:
        return read_friction(value, info.data["surfaces"]) if "surfaces" in info.data else Friction()

    @model_validator(mode="after")
    def _goes_together(self) -> Study:
        contact, surfaces = self.contact, self.surfaces
        if isinstance(surfaces, Measured):
            self._check_measured()
            return self
        if surfaces.kind == "profile":
            given = contact.direction
            if not (given is None or given in ("+x", "-x")):
                words = shortened(list(given) if isinstance(given, tuple) else given)
                raise ValueError(f'contact.direction: must be "+x" or "-x" on profiles, got {words}')
            area = float(surfaces.extent) * THICKNESS
        else:
            if drawn := [name for name in self.figures.draw if name in ("profiles", "length-scales")]:
                raise ValueError(f'figures.draw: "{drawn[0]}" is of profiles, and surfaces.kind is "surface"')
            self._check_areal_contact()
            area = math.prod(surfaces.extents())
        if "onset" in self.figures.draw and not set(ONSET) & set(self.sums()):
            raise ValueError('figures.draw: "onset" needs contact.onset, which says at which strengths')
        if isinstance(contact, HalfSpace) and contact.hardness is not None:
            most = float(contact.hardness) * area
            if not contact.steps()[-1] < most:
                raise ValueError(f"contact.load: must be below hardness times area, {most:g} mN")
        return self

    def _check_areal_contact(self) -> None:
        if isinstance(self.contact, ByAsperities):
            try:
                self.contact.model().for_surfaces()
            except ValueError as error:
                raise ValueError(f"contact.{error}") from None

    def _check_measured(self) -> None:
        """Loads that are asked for lie on the curve, and there are not too many answers."""
        assert isinstance(self.surfaces, Measured)
        if self.surfaces.is_areal:
            self._check_areal_contact()
        friction = self.friction
        assert isinstance(friction, MeasuredFriction)
        if self.figures != Figures():
            raise ValueError("figures.draw: belongs to generated surfaces; of measured ones all figures are drawn")
        steps = self.contact.steps()
        if not steps[0] <= float(friction.load[0]) <= float(friction.load[-1]) <= steps[-1]:
            raise ValueError(
                f"friction.load: must be from {steps[0]:g} to {steps[-1]:g} mN, the ends of contact.load; without "
                "contact.load there are loads around those that are asked for"
            )
        answers = len(friction.load) * len(friction.mu0) * len(friction.tau0)
        if answers > MOST_ANSWERS:
            raise ValueError(f"friction: loads times mu0 times tau0 must be at most {MOST_ANSWERS}, got {answers}")

    @model_validator(mode="after")
    def _fits(self) -> Study:
        cells = math.prod(values.size for values in self.surfaces.cells().values())
        curves = sum(math.prod(map(len, self.motions().values())) if name in DIRECTED else 1 for name in self.sums())
        size = 8 * curves * cells * self.contact.steps().size
        if size > MOST_MEMORY:
            cell_keys = " or ".join(f"surfaces.{name}" for name in self.surfaces.cells())
            raise ValueError(
                f"a repetition would take {size / 2**30:.0f} GiB, more than {MOST_MEMORY / 2**30:.0f}: take fewer "
                f"contact.{self.step} or {cell_keys}"
            )
        return self

    @property
    def is_measured(self) -> bool:
        """Whether its bodies were scanned; else they are generated."""
        return self.surfaces.kind == "measured"

    @property
    def is_areal(self) -> bool:
        """Whether its members are pairs of areas, and not of profiles or lines."""
        return self.surfaces.is_areal

    @property
    def by_half_space(self) -> bool:
        """Whether its members are pressed as elastic half-spaces, and not at asperities."""
        return self.contact.mechanics == "half-space"

    @property
    def step(self) -> Literal["approach", "load"]:
        """What a pair is pressed to, one after the other."""
        return self.contact.step

    def sums(self) -> tuple[str, ...]:
        """Names of what a result of the study has of each member at each approach or load."""
        if self.contact.mechanics == "half-space":
            return HALF_SPACE_SUMS
        lines = not self.surfaces.is_areal
        approach = ("approach",) if self.step == "load" else ()
        onset = ONSET if self.contact.onset is not None else ()
        return SUMS + (() if lines else AREAL_SUMS) + approach + onset

    def motions(self) -> dict[str, list[Any]]:
        """Sliding rules and directions (degrees) of which there is a list: more dimensions of what depends on them."""
        return self.contact.motions()

    def with_known_files(self, folder: Path | None = None) -> Study:
        """The study with absolute names and checksums of the files that it is made for; one of none is returned as is.

        Bodies in memory are written into the folder, if there is one. Raises a `ValueError` if a file cannot be read.
        """
        if not isinstance(self.surfaces, Measured):
            return self
        surfaces = self.surfaces if folder is None else self.surfaces.kept(folder)
        return self.model_copy(update={"surfaces": surfaces.located(Path.cwd()).known()})

    @classmethod
    def named(cls, name: str) -> Study:
        """A built-in study; their names are `study_names()`.

        Raises
        ------
        StudyError
            If there is none of that name.
        """
        if name not in study_names():
            raise StudyError(f"there is no built-in study {shortened(name)}; there are {', '.join(study_names())}")
        return study_from_text((_LIBRARY / f"{name}.toml").read_text(encoding="utf-8"), name)

    @classmethod
    def from_toml(cls, path: str | Path) -> Study:
        """Read a study file.

        Raises
        ------
        StudyError
            If the file cannot be read, is not TOML, or has unknown keys, wrong units or impossible values.
        """
        try:
            raw = content(Path(path), LONGEST_FILE)
            study = study_from_text(raw.decode("utf-8"), str(path))
        except OSError as error:
            raise StudyError(f"{named(path)}: cannot be read: {reason(error)}") from None
        except NotReadableError as error:
            raise StudyError(f"{named(path)}: {error}, so it is no study") from None
        except UnicodeDecodeError:
            raise StudyError(f"{named(path)}: is not a text file, so it is no study") from None
        if not isinstance(study.surfaces, Measured):
            return study
        return study.model_copy(update={"surfaces": study.surfaces.located(Path(path).absolute().parent)})

    def with_changes(self, changes: Mapping[str, Any]) -> Study:
        """The study with some values replaced, by dotted key.

        Parameters
        ----------
        changes : mapping
            Such as ``{"ensemble.repetitions": 10, "surfaces.amplitude": ["50 nm"]}``.

        Raises
        ------
        StudyError
            If a key is unknown or a value impossible.
        """
        data = self._before(changes)
        for key, value in changes.items():
            table: Any = data
            if not isinstance(key, str):
                raise StudyError(f"{shortened(key)}: unknown key")
            *path, last = key.split(".")
            for part in path:
                table = table.setdefault(part, {}) if isinstance(table, dict) else None
            if not isinstance(table, dict):
                raise StudyError(f"{printable(key)}: unknown key")
            table[last] = value
        return validated(Study, data, "changes")

    def to_toml(self) -> str:
        """The whole study as TOML, with every key that it has; `Study.from_toml` reads it back equal."""
        tables = []
        for name, table in self._written().items():
            lines = [f"{key} = {as_toml(value)}" for key, value in table.items()]
            tables.append("\n".join([f"[{name}]", *lines]) + "\n")
        return "\n".join(tables)

    def _before(self, changes: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
        """What changes are made to: all keys, carried over where the changes make a table another case."""
        data = self._written()
        chosen = {
            section: {key: changes.get(f"{section}.{key}", data[section].get(key)) for key in keys}
            for section, keys in _CASE_KEYS.items()
        }
        chosen = {section: {key: v for key, v in keys.items() if v is not None} for section, keys in chosen.items()}
        try:
            surfaces = surfaces_case(chosen["surfaces"])
            cases = {"surfaces": surfaces, "contact": contact_case(surfaces, chosen["contact"])}
        except PydanticCustomError:  # said of the key that is wrong
            return data
        return data | {section: self._carried_over(section, case) for section, case in cases.items()}

    def _carried_over(self, section: str, case: type[Table]) -> dict[str, Any]:
        """A table of another case: its defaults, and what of the old one differs from its own and belongs."""
        old = getattr(self, section)
        if type(old) is case:
            return self._written()[section]
        own = {key: value for key, value in old if value != type(old).model_fields[key].default}
        return written_table(case.model_construct(**{key: own[key] for key in own if key in case.model_fields}))

    def _written(self) -> dict[str, dict[str, Any]]:
        """Every key of each table that is given."""
        names = [
            name for name in type(self).model_fields if name != "figures" or not isinstance(self.surfaces, Measured)
        ]
        return {name: written_table(getattr(self, name)) for name in names}


def written_table(table: Table) -> dict[str, Any]:
    """The keys of a table that are given, what it is a table of first."""
    data = table.model_dump(exclude_none=True)
    return {key: data[key] for key in sorted(data, key=lambda key: _FIRST.index(key) if key in _FIRST else len(_FIRST))}


_LIBRARY = resources.files("stiction.studies") / "library"


def study_names() -> list[str]:
    """Names of the built-in studies, sorted.

    Examples
    --------
    >>> from stiction import study_names
    >>> "quick" in study_names()
    True
    """
    return sorted(item.name.removesuffix(".toml") for item in _LIBRARY.iterdir() if item.name.endswith(".toml"))


def study_summary(name: str) -> str:
    """What a built-in study computes, in one sentence: the first line of its file."""
    return (_LIBRARY / f"{name}.toml").read_text(encoding="utf-8").partition("\n")[0].removeprefix("# ")


def study_of(dataset: xarray.Dataset) -> Study:
    """The study that a result came from; a `StudyError` if it does not say."""
    return study_of_attributes(dataset.attrs)


def study_of_attributes(attributes: Mapping[str, Any]) -> Study:
    """`study_of` a result that has these attributes."""
    if not isinstance(attributes.get("study"), str):
        raise StudyError(
            "the dataset does not say what study it is of (attribute 'study'), so mu0 and tau0 must be given"
        )
    return study_from_text(attributes["study"], "the dataset's study")


def step_of(dataset: xarray.Dataset) -> str:
    """The dimension along which a pair of a result is pressed together: "approach", or "load" by the half-space."""
    return "load" if "load" in dataset.dims else "approach"


def differences(one: Study, other: Study) -> list[tuple[str, str, str]]:
    """Every value that differs, in the order of a study file: its dotted key, and what it is in either, as TOML."""
    return list(_differences(one, other, ""))


def _differences(one: Table, other: Table, prefix: str) -> Iterator[tuple[str, str, str]]:
    texts = one.model_dump(), other.model_dump()
    for name in dict.fromkeys((*type(one).model_fields, *type(other).model_fields)):
        values = getattr(one, name, None), getattr(other, name, None)
        if values[0] == values[1]:
            continue
        if isinstance(values[0], Table) and isinstance(values[1], Table):
            yield from _differences(values[0], values[1], f"{prefix}{name}.")
        else:
            yield f"{prefix}{name}", as_toml(texts[0].get(name)), as_toml(texts[1].get(name))


def study_from_text(text: str, source: str) -> Study:
    """The study that a TOML text is; errors call it by the name of its source."""
    try:
        data = toml(text)
    except ValueError as error:
        raise StudyError(f"{named(source)}: is not TOML: {printable(error, LONGEST_NAME)}") from None
    return validated(Study, data, source)
