"""Definitions of roughness parameters: name, standard, formula, unit and requirements."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from stiction._repr import TextReprMixin, format_number_and_unit, table_html

NOT_LEVELLED_VALUE = "no"


@dataclass(frozen=True)
class ParameterDefinition:
    """Definition of a roughness parameter: name, standard, formula, unit and requirements.

    Attributes
    ----------
    name : str
    meaning : str
    source : str
        Standard and clause, or the subject of the clause if its number is uncertain.
    formula : str
        In LaTeX, with z the height about the mean line or plane.
    unit : str
        "µm", "", "degrees", "1/µm" or "1/µm²".
    needs : str
        Requirement for a value; empty if the parameter always exists.
    is_fraction : bool
        True if the value is printed in percent.
    """

    name: str
    meaning: str
    source: str
    formula: str
    unit: str = "µm"
    needs: str = ""
    is_fraction: bool = False


_HEIGHT_GROUP, _HYBRID_GROUP, _MATERIAL_RATIO_GROUP = (
    "height parameters",
    "hybrid parameters",
    "material ratio functions",
)
_PEAK_GROUP, _ELEMENT_GROUP = "peak heights and pit depths per section", "profile elements"

_PROFILE_PARAMETER_TEXTS = {
    "a": ("arithmetic mean height", _HEIGHT_GROUP, r"\frac1l \int |z|\,dx", "µm"),
    "q": ("root-mean-square height", _HEIGHT_GROUP, r"\left(\frac1l \int z^2\,dx\right)^{1/2}", "µm"),
    "z": ("maximum height per section, mean of the sections", _PEAK_GROUP, r"\frac1n \sum_i (p_i + v_i)", "µm"),
    "p": ("peak height per section, mean of the sections", _PEAK_GROUP, r"\frac1n \sum_i p_i,\ p_i = \max_i z", "µm"),
    "v": ("pit depth per section, mean of the sections", _PEAK_GROUP, r"\frac1n \sum_i v_i,\ v_i = -\min_i z", "µm"),
    "t": ("total height", _HEIGHT_GROUP, r"\max z - \min z", "µm"),
    "sk": ("skewness", _HEIGHT_GROUP, r"\frac{1}{q^3\,l} \int z^3\,dx", ""),
    "ku": ("kurtosis", _HEIGHT_GROUP, r"\frac{1}{q^4\,l} \int z^4\,dx", ""),
    "dq": ("root-mean-square slope", _HYBRID_GROUP, r"\left(\frac1l \int (dz/dx)^2\,dx\right)^{1/2}", ""),
    "Sm": ("mean spacing of the profile elements", _ELEMENT_GROUP, r"\frac1m \sum_i X_i", "µm"),
    "c": ("mean height of the profile elements", _ELEMENT_GROUP, r"\frac1m \sum_i Z_i", "µm"),
    "mr": ("material ratio at the mean line, (c) = 0", _MATERIAL_RATIO_GROUP, r"\frac1l\,|\{x: z > c\}|", ""),
    "dc": ("height difference of material ratios 20 % and 80 %", _MATERIAL_RATIO_GROUP, r"c(20\,\%) - c(80\,\%)", "µm"),
    "k": ("core height", _MATERIAL_RATIO_GROUP, r"\text{fall of the core line from 0 to 100 %}", "µm"),
    "pk": ("reduced peak height", _MATERIAL_RATIO_GROUP, r"2 A_1/mrk_1", "µm"),
    "vk": ("reduced pit depth", _MATERIAL_RATIO_GROUP, r"2 A_2/(1 - mrk_2)", "µm"),
    "mrk1": ("material ratio at the upper end of the core", _MATERIAL_RATIO_GROUP, r"mr(\text{core line at 0})", ""),
    "mrk2": (
        "material ratio at the lower end of the core", _MATERIAL_RATIO_GROUP, r"mr(\text{core line at 100 %})", "",
    ),
}  # fmt: skip
"""Meaning, clause of ISO 21920-2, formula and unit of each profile parameter, by its name without the letter P, R or W.
"""

_PROFILE_PARAMETER_KEYS = {
    "P": ("a", "q", "t", "sk", "ku", "dq"),
    "R": tuple(_PROFILE_PARAMETER_TEXTS),
    "W": ("a", "q", "t", "sk", "ku", "dq", "Sm", "c"),
}
_PROFILE_REQUIREMENTS = {"P": "", "R": "one section length", "W": "one section length"}
_PROFILE_ELEMENT_REQUIREMENT = "three turns from hill to dale"


def _define_profile_parameters(letter: str) -> tuple[ParameterDefinition, ...]:
    definitions = []
    for name_without_letter in _PROFILE_PARAMETER_KEYS[letter]:
        meaning, clause, formula, unit = _PROFILE_PARAMETER_TEXTS[name_without_letter]
        requirement = _PROFILE_ELEMENT_REQUIREMENT if clause == _ELEMENT_GROUP else _PROFILE_REQUIREMENTS[letter]
        source, is_fraction = f"ISO 21920-2, {clause}", name_without_letter.startswith("mr")
        definitions.append(
            ParameterDefinition(letter + name_without_letter, meaning, source, formula, unit, requirement, is_fraction)
        )
    return tuple(definitions)


PROFILE_PARAMETERS = {letter: _define_profile_parameters(letter) for letter in "PRW"}
"""Definitions of the profile parameters, by the letter of the profile: primary (P), roughness (R) or waviness (W)
profile.
"""

_ISO_25178, _FIVE_PEAKS_REQUIREMENT = "ISO 25178-2", "five peaks"
SURFACE_PARAMETERS = (
    ParameterDefinition(
        "Sq", "root-mean-square height", f"{_ISO_25178}, 4.2 height",
        r"\left(\frac1A \int z^2\,dA\right)^{1/2}",
    ),
    ParameterDefinition("Sa", "arithmetic mean height", f"{_ISO_25178}, 4.2 height", r"\frac1A \int |z|\,dA"),
    ParameterDefinition("Sp", "maximum peak height", f"{_ISO_25178}, 4.2 height", r"\max z"),
    ParameterDefinition("Sv", "maximum pit depth", f"{_ISO_25178}, 4.2 height", r"-\min z"),
    ParameterDefinition("Sz", "maximum height", f"{_ISO_25178}, 4.2 height", "Sp + Sv"),
    ParameterDefinition("Ssk", "skewness", f"{_ISO_25178}, 4.2 height", r"\frac{1}{Sq^3\,A} \int z^3\,dA", ""),
    ParameterDefinition("Sku", "kurtosis", f"{_ISO_25178}, 4.2 height", r"\frac{1}{Sq^4\,A} \int z^4\,dA", ""),
    ParameterDefinition(
        "Sdq", "root-mean-square gradient", f"{_ISO_25178}, 4.4 hybrid",
        r"\left(\frac1A \int |\nabla z|^2\,dA\right)^{1/2}", "",
    ),
    ParameterDefinition(
        "Sdr", "developed interfacial area ratio", f"{_ISO_25178}, 4.4 hybrid",
        r"\frac1A \int \sqrt{1 + |\nabla z|^2}\,dA - 1", "", is_fraction=True,
    ),
    ParameterDefinition(
        "Sal", "autocorrelation length", f"{_ISO_25178}, 4.3 spatial", r"\min \{r: f_{ACF}(r) \le 0.2\}",
        needs="a decay to 0.2 within half the map",
    ),
    ParameterDefinition(
        "Str", "texture aspect ratio", f"{_ISO_25178}, 4.3 spatial", r"Sal/\max \{r: f_{ACF}(r) \le 0.2\}", "",
        "a decay to 0.2 within half the map in all directions",
    ),
    ParameterDefinition("Std", "texture direction", f"{_ISO_25178}, 4.3 spatial", r"\argmax f_{APS}(s)", "degrees"),
    ParameterDefinition(
        "Ssw", "dominant spatial wavelength", f"{_ISO_25178}, 4.3 spatial",
        r"2π/|q|,\ q = \argmax |\hat z(q)|",
    ),
    ParameterDefinition(
        "Smr", "material ratio at the mean plane, (c) = 0", f"{_ISO_25178}, 4.5 material ratio",
        r"\frac1A\,|\{z > c\}|", "", is_fraction=True,
    ),
    ParameterDefinition(
        "Sdc", "height difference of material ratios 10 % and 80 %", f"{_ISO_25178}, 4.5 material ratio",
        r"Smc(10\,\%) - Smc(80\,\%)",
    ),
    ParameterDefinition(
        "Sxp", "extreme peak height", f"{_ISO_25178}, 4.5 material ratio", r"Smc(2.5\,\%) - Smc(50\,\%)",
    ),
    ParameterDefinition(
        "Sk", "core height", f"{_ISO_25178}, 4.5 material ratio", r"\text{fall of the core line from 0 to 100 %}",
    ),
    ParameterDefinition("Spk", "reduced peak height", f"{_ISO_25178}, 4.5 material ratio", r"2 A_1/Smr_1"),
    ParameterDefinition("Svk", "reduced pit depth", f"{_ISO_25178}, 4.5 material ratio", r"2 A_2/(1 - Smr_2)"),
    ParameterDefinition(
        "Smr1", "material ratio at the upper end of the core", f"{_ISO_25178}, 4.5 material ratio",
        r"Smr(\text{core line at 0})", "", is_fraction=True,
    ),
    ParameterDefinition(
        "Smr2", "material ratio at the lower end of the core", f"{_ISO_25178}, 4.5 material ratio",
        r"Smr(\text{core line at 100 %})", "", is_fraction=True,
    ),
    ParameterDefinition("Vmp", "peak material volume, 1 µm³/µm² = 1 ml/m²", f"{_ISO_25178}, 4.5 volume", r"Vm(10\,\%)"),
    ParameterDefinition("Vmc", "core material volume", f"{_ISO_25178}, 4.5 volume", r"Vm(80\,\%) - Vm(10\,\%)"),
    ParameterDefinition("Vvc", "core void volume", f"{_ISO_25178}, 4.5 volume", r"Vv(10\,\%) - Vv(80\,\%)"),
    ParameterDefinition("Vvv", "pit void volume", f"{_ISO_25178}, 4.5 volume", r"Vv(80\,\%)"),
    ParameterDefinition("Spd", "density of peaks", f"{_ISO_25178}, 5.8 feature", r"n/A", "1/µm²"),
    ParameterDefinition(
        "Spc", "arithmetic mean peak curvature", f"{_ISO_25178}, 5.8 feature",
        r"-\frac{1}{2n} \sum_i (∂_x^2 z + ∂_y^2 z)_i", "1/µm", "a peak in the interior of the map",
    ),
    ParameterDefinition(
        "S5p", "five-point peak height", f"{_ISO_25178}, 5.8 feature", r"\frac15 \sum_{i=1}^5 z_{p,i}",
        needs=_FIVE_PEAKS_REQUIREMENT,
    ),
    ParameterDefinition(
        "S5v", "five-point pit depth", f"{_ISO_25178}, 5.8 feature", r"-\frac15 \sum_{i=1}^5 z_{v,i}", needs="five pits"
    ),
    ParameterDefinition(
        "S10z", "ten-point height", f"{_ISO_25178}, 5.8 feature",
        "S5p + S5v", needs="five peaks and five pits",
    ),
)  # fmt: skip
"""Definitions of the roughness parameters of height maps, in the order of printed tables."""

ROUGHNESS_PARAMETERS = {
    parameter.name: parameter
    for parameter in (*(p for group in PROFILE_PARAMETERS.values() for p in group), *SURFACE_PARAMETERS)
}
"""Definitions of all roughness parameters, by name."""


@dataclass(frozen=True, repr=False)
class RoughnessParameterSet(TextReprMixin):
    """Values of all roughness parameters computed for one profile or height map.

    Each parameter is available as an attribute, such as `Sq`.

    Attributes
    ----------
    values : dict
        Values by parameter name, in the order of the table; NaN where a parameter does not exist.
    levelled : str
        Form that was subtracted from the heights, or "no".
    """

    values: Mapping[str, float]
    levelled: str = NOT_LEVELLED_VALUE

    def __getattr__(self, name: str) -> float:
        """Return a computed roughness parameter by its name."""
        # The field `values` does not exist yet while a parameter set is being copied.
        values: Mapping[str, float] = self.__dict__.get("values", {})
        if name in values:
            return values[name]
        raise AttributeError(f"{type(self).__name__} has no parameter {name!r}")

    def _name_number_and_unit_texts(self) -> list[tuple[str, str, str]]:
        return [
            (name, *format_number_and_unit(value, ROUGHNESS_PARAMETERS[name].unit))
            for name, value in self.values.items()
        ]

    def _extra_table_rows(self) -> dict[str, str]:
        return {"levelled": self.levelled}

    def __repr__(self) -> str:
        """Return a table in plain text: one line for each roughness parameter, with value and unit."""
        lines = {
            name: f"{value} {unit}".strip() for name, value, unit in self._name_number_and_unit_texts()
        } | self._extra_table_rows()
        width = max(map(len, lines))
        return "\n".join([type(self).__name__, *(f"  {name:<{width}}  {text}" for name, text in lines.items())])

    def _repr_html_(self) -> str:
        text_rows = [(name, text, "") for name, text in self._extra_table_rows().items()]
        return table_html(("parameter", "value", "unit"), [*self._name_number_and_unit_texts(), *text_rows])
