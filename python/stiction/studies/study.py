"""What to compute: a study, validated, from a TOML file or the built-in library."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from pydantic import model_validator

from stiction._files import NotReadableError, content, reason
from stiction._text import LONGEST_NAME, named, printable
from stiction._units import shortened
from stiction.mechanics.half_space import WIDTH
from stiction.mechanics.quantities import AREAL_SUMS, DIRECTED, HALF_SPACE_SUMS, SUMS
from stiction.studies.study_tables import LATER, Contact, Ensemble, Figures, Friction, Surfaces, belongs
from stiction.studies.study_text import StudyError, as_toml, toml, validated
from stiction.studies.study_values import Table

if TYPE_CHECKING:
    import xarray

MOST_MEMORY = 16 * 2**30
"""Bytes of a repetition of a result."""

LONGEST_FILE = 1_000_000
"""Bytes of a study file; a study is a page."""

MOST_HARMONICS = 1_000_000
"""Directions times frequencies, of which each takes a phase, and time at every point."""


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

    surfaces: Surfaces = Surfaces()
    contact: Contact = Contact()
    friction: Friction = Friction()
    ensemble: Ensemble = Ensemble()
    figures: Figures = Figures()

    @model_validator(mode="before")
    @classmethod
    def _with_defaults_of_its_surfaces(cls, given: Any) -> Any:
        """On surfaces contacts are gap minima, and whatever is relatively convex touches."""
        if not isinstance(given, Mapping):
            return given
        surfaces, contact = given.get("surfaces", {}), given.get("contact", {})
        if isinstance(contact, Contact):
            contact = {name: getattr(contact, name) for name in contact.model_fields_set}
        kind = getattr(surfaces, "kind", None) or (surfaces.get("kind") if isinstance(surfaces, Mapping) else None)
        if kind != "surface" or not isinstance(contact, Mapping) or contact.get("mechanics") == "half-space":
            return given
        return {**given, "contact": {"detection": "gap-minimum", "curvature": "signed"} | dict(contact)}

    @model_validator(mode="after")
    def _goes_together(self) -> Study:
        contact, on_profiles = self.contact, self.surfaces.kind == "profile"
        given = list(contact.direction) if isinstance(contact.direction, tuple) else contact.direction
        if on_profiles and not (contact.direction is None or contact.direction in ("+x", "-x")):
            raise ValueError(f'contact.direction: must be "+x" or "-x" on profiles, got {shortened(given)}')
        if not on_profiles:
            if drawn := [name for name in self.figures.draw if name not in ("friction", "area")]:
                raise ValueError(f'figures.draw: "{drawn[0]}" is of profiles, and surfaces.kind is "surface"')
            if contact.mechanics == "asperities":
                try:
                    contact.model().for_surfaces()
                except ValueError as error:
                    raise ValueError(f"contact.{error}") from None
        if contact.hardness is not None:
            area = float(self.surfaces.extent) * WIDTH if on_profiles else float(np.prod(self.surfaces.extents()))
            most = float(contact.hardness) * area
            if not contact.steps()[-1] < most:
                raise ValueError(f"contact.load: must be below hardness times area, {most:g} mN")
        return self

    @model_validator(mode="after")
    def _fits(self) -> Study:
        harmonics = self.surfaces.directions * self.surfaces.frequencies
        if harmonics > MOST_HARMONICS:
            raise ValueError(
                f"surfaces.directions times surfaces.frequencies must be at most {MOST_HARMONICS}, got {harmonics}"
            )
        pairs = self.surfaces.fractal_dimensions().size * self.surfaces.amplitudes().size
        curves = sum(math.prod(map(len, self.motions().values())) if name in DIRECTED else 1 for name in self.sums())
        size = 8 * curves * pairs * self.contact.steps().size
        if size > MOST_MEMORY:
            raise ValueError(
                f"a repetition would take {size / 2**30:.0f} GiB, more than {MOST_MEMORY / 2**30:.0f}: take fewer "
                f"contact.{self.contact.step}, surfaces.fractal_dimension or surfaces.amplitude"
            )
        return self

    def sums(self) -> tuple[str, ...]:
        """Names of what a result of the study has of each pair at each approach or load."""
        if self.contact.mechanics == "half-space":
            return HALF_SPACE_SUMS
        return SUMS if self.surfaces.kind == "profile" else SUMS + AREAL_SUMS

    def motions(self) -> dict[str, list[Any]]:
        """Sliding rules and directions (degrees) of which there is a list: more dimensions of what depends on them."""
        lists: dict[str, list[Any]] = {}
        if isinstance(self.contact.sliding, tuple):
            lists["sliding"] = list(self.contact.sliding)
        if isinstance(self.contact.direction, tuple):
            lists["direction"] = self.contact.degrees().tolist()
        return lists

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
            return study_from_text(raw.decode("utf-8"), str(path))
        except OSError as error:
            raise StudyError(f"{named(path)}: cannot be read: {reason(error)}") from None
        except NotReadableError as error:
            raise StudyError(f"{named(path)}: {error}, so it is no study") from None
        except UnicodeDecodeError:
            raise StudyError(f"{named(path)}: is not a text file, so it is no study") from None

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
        data = self._written()
        if changes.keys() & {"surfaces.kind", "surfaces.generator", "contact.mechanics"}:
            data = self._of_another_kind(changes)
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

    def _of_another_kind(self, changes: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
        """All keys with the defaults of the new kind, but for what differs from those of the old one and belongs."""
        old: dict[str, dict[str, Any]] = {
            "surfaces": {"kind": self.surfaces.kind, "generator": self.surfaces.generator},
            "contact": {"mechanics": self.contact.mechanics},
        }
        new = {
            section: {key: changes.get(f"{section}.{key}", value) for key, value in table.items()}
            for section, table in old.items()
        }
        for tables in (old, new):
            if tables["surfaces"]["kind"] == "profile":
                del tables["surfaces"]["generator"]
        before, fresh = (validated(Study, tables, "changes") for tables in (old, new))
        cases = {"surfaces": fresh.surfaces.case, "contact": fresh.contact.mechanics}
        was, written = before._written(), fresh._written()
        for section, table in self._written().items():
            for key, value in table.items():
                if was[section].get(key) != value and belongs(key, cases.get(section, "")):
                    written[section][key] = value
        return written

    def _written(self) -> dict[str, dict[str, Any]]:
        """Every key of each table but those of other kinds, those that are not given, and those that came later."""
        cases = {"surfaces": self.surfaces.case, "contact": self.contact.mechanics}
        return {
            name: {
                key: value
                for key, value in table.items()
                if value is not None and belongs(key, cases.get(name, "")) and (key not in LATER or value != LATER[key])
            }
            for name, table in self.model_dump().items()
        }


_LIBRARY = resources.files("stiction.studies") / "library"


def study_names() -> list[str]:
    """Names of the built-in studies, sorted."""
    return sorted(item.name.removesuffix(".toml") for item in _LIBRARY.iterdir() if item.name.endswith(".toml"))


def study_summary(name: str) -> str:
    """What a built-in study computes, in one sentence: the first line of its file."""
    return (_LIBRARY / f"{name}.toml").read_text(encoding="utf-8").partition("\n")[0].removeprefix("# ")


def study_of(dataset: xarray.Dataset) -> Study:
    """The study that a result came from.

    Raises
    ------
    StudyError
        If the dataset does not say.
    """
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
    for name in type(one).model_fields:
        values = getattr(one, name), getattr(other, name)
        if values[0] == values[1]:
            continue
        if isinstance(values[0], Table) and type(values[0]) is type(values[1]):
            yield from _differences(*values, f"{prefix}{name}.")
        else:
            yield f"{prefix}{name}", as_toml(texts[0][name]), as_toml(texts[1][name])


def study_from_text(text: str, source: str) -> Study:
    """The study that a TOML text is; errors call it by the name of its source."""
    try:
        data = toml(text)
    except ValueError as error:
        raise StudyError(f"{named(source)}: is not TOML: {printable(error, LONGEST_NAME)}") from None
    return validated(Study, data, source)
