"""Parsing of table headers: column names, units, spacings, sizes, factors and codes for missing points."""

from __future__ import annotations

import html
import re
import unicodedata
from collections.abc import Sequence
from dataclasses import dataclass

from stiction._patterns import LazyPattern
from stiction.surfaces.measured.raw import HeaderDeclarations, parse_length_unit, parse_number, parse_positive_number
from stiction.surfaces.measured.spacing_lines import (
    DECIMAL_PATTERN,
    DECLARED_NUMBER_PATTERN,
    SEPARATOR_PATTERN,
    UNIT_PATTERN,
    find_first_match,
    is_spacing_declaration,
    parse_bracketed_length,
    parse_spacing_declarations,
)
from stiction.surfaces.measured.split import Dialect

COMMENT_CHARACTERS = "#%!/ "

_FACTOR_PATTERN = (
    r"(?:[x×*·]\s?)?(?:1/10+|10\s?\^?[-+][0-9]{1,2}|[0-9.,]*e[-+]?[0-9]{1,2}|10+|0[.,]0*1)[\s_]*[x×*·]?[\s_]*"
)
"""Regular expression for the factor in a unit such as "10 nm", "1e-6m" or "1/100 mm"."""

_UNIT_WORDS = (
    r"(?:units?|einheit(?:en)?|unités?|unidad(?:es)?(?: de valor)?|unità(?: valore)?|jednotk[ay](?: hodnot)?|"
    r"単位|値の単位|单位|값 단위|단위|единицы измерения)"
)
_HEIGHT_WORDS = r"(?:z|(?:image )?data|heights?|values?|amplitude|vertical|profile|channel|signal|image|topography)"
_HEIGHT_UNIT_PATTERN = LazyPattern(
    r"\W*(?:(?:z|heights?|höhen?|hauteurs?|data|values?)\s+(?:are\s+)?in\s+(?:1(?:[.,]0*)?\s+)?|"
    rf"(?:(?:{_HEIGHT_WORDS}|figure|plot)[\s_-]*)?(?:axis[\s_-]*)?{_UNIT_WORDS}"
    rf"(?:\s?[ ._:-]\s?(?:of )?{_HEIGHT_WORDS}(?![^\W_]))?"
    r"\s*[:=,;\t]\s*)[\"']?([^\s\"',;:]{1,20})[\"']?\W*",
    re.IGNORECASE,
)
_UNKNOWN_UNIT_PATTERN = LazyPattern(
    r"\W*(?:(?:z|heights?|höhen?)\s+(?:are\s+)?in\s+(?!the\b|an?\b|this\b|columns?\b|rows?\b|lines?\b|files?\b)|"
    rf"(?:(?:{_HEIGHT_WORDS}|figure|plot)[\s_-]*)?(?:axis[\s_-]*)?{_UNIT_WORDS}"
    rf"(?:\s?[ ._:-]\s?(?:of )?{_HEIGHT_WORDS}(?![^\W_]))?"
    r"(?:\s*[:=,;\t]\s*|\s+(?=[0-9])))"
    r"[\"']?((?:[^\"',;\t]|(?<=[0-9]),(?=[0-9])){1,40}?)[\"']?[\s,;]*",
    re.IGNORECASE,
)
"""Regular expression for a line that declares the unit of the heights in any words, even if the unit is unknown."""

_UNIT_OF_Z_PATTERN = LazyPattern(
    r"\W*(?:z\s*([:=])\s*|(?:z|(heights?|höhen?))[\s_/]+|(?:z[\s_-]*)?(?:units?|einheit)(\s+))([^:=]{1,16}?)[\s,;]*",
    re.IGNORECASE,
)
"""Regular expression for a line with a unit after the name of the heights. The second group matches the name "height",
which may denote the height of a map.
"""

_UNIT_WITH_FACTOR_PATTERN = LazyPattern(
    rf"(?:{_FACTOR_PATTERN}|[0-9](?=[^\W\d]))([^\W\d_]+)(?:/10+)?|([^\W\d_]+)\s?[/*×·x]\s?10+", re.IGNORECASE
)
"""Regular expression for a unit with a factor."""

_UNIT_OF_Y_PATTERN = LazyPattern(
    rf"\W*y[\s_-]*(?:axis[\s_-]*)?{_UNIT_WORDS}(?:[\s_-]*label)?\s*[:=,;\t]\s*[\"']?([^\"',;\t]{{1,20}}?)[\"']?[\s,;\t]*",
    re.IGNORECASE,
)
"""Regular expression for a line with the unit along y, which is the unit of the heights of a profile."""

_PLAIN_UNIT_PATTERN = LazyPattern(
    rf"\W*{_UNIT_WORDS}\s*[:=]\s*[\"']?([^\W\d][^\s\"',;]{{0,11}})[\"']?\W*", re.IGNORECASE
)
"""Regular expression for a line that declares a unit without naming a quantity, as in "Unit: nm"."""

_UNIT_IN_RECORD_PATTERN = LazyPattern(rf"[{{,]\s*{_UNIT_WORDS}\s*[:=]\s*([^\s,;}}\]]{{1,12}})", re.IGNORECASE)
"""Regular expression for the unit of a column in a line such as ``{"name": "x", "unit": "mm"}, {"name": "z", "unit":
"um"}``.
"""

_UNITS_OF_COLUMNS_PATTERN = LazyPattern(
    rf"\W*{_UNIT_WORDS}\s*[:=]\s*(?:[^\W\d][\w ]{{0,20}}[=:]\s*)?([^\s,;=:]{{1,12}})\s*[,;]\s*"
    r"(?:[^\W\d][\w ]{0,20}[=:]\s*)?([^\s,;=:]{1,12})\s*",
    re.IGNORECASE,
)
"""Regular expression for a line with the units of positions and heights, as in "Units: mm, um" or "Units: x=mm, z=um".
"""

_POSITION_UNIT_PATTERN = LazyPattern(
    rf"\W*(?:x|lateral|horizontal|position|length)[\s_-]*(?:axis[\s_-]*)?{_UNIT_WORDS}\s*[:=,;\t]\s*"
    r"[\"']?([^\"',;]{1,20}?)[\"']?[\s,;]*",
    re.IGNORECASE,
)
_POSITION_QUANTITY_PATTERN = LazyPattern(
    r"\W*x[\s_-]*(?:axis[\s_-]*)?(?:dimension|quantity|label|name|title|axis)\s*[:=,;\t]\s*[\"']?([^\"',;\t]{1,30}).*",
    re.IGNORECASE,
)
"""Regular expression for a line that names the quantity of the positions, such as "X_Dimension Time" of LabVIEW."""
_NON_UNIT_WORDS = ("", "-", "--", "1", "metric", "si", "none", "n/a", "default", "yes", "no", "on", "off")
"""Words after "unit" in a header line that are not units."""

_POWER_OF_TEN_PATTERN = r"(?:[×x*·]\s*)?(?:10\s*(?:(?:\^|\*\*)\s*[-−+]?|[-−+])[0-9]{1,2}|1?e[-−+][0-9]{1,2})"
_CONVERTER_UNIT_PATTERN = (
    r"(?:V|volts?|mV|LSB|bits?|digits?|counts?|inc(?:rements?)?|levels?|gr[ae]y[ _-]?(?:levels?|values?))"
)
_FACTOR_OTHER_THAN_ONE_PATTERN = r"(?!\s*1(?:[.,]0*)?\s*[*×x]?\W*$)"
_UNAPPLIED_FACTOR_PATTERN = LazyPattern(
    # This pattern matches a factor above a matrix of heights, such as "1.0e-03 *".
    rf"\W*{_FACTOR_OTHER_THAN_ONE_PATTERN}[0-9.,]{{1,20}}(?:e[+-]?[0-9]{{1,3}})?\s*[*×x]\W*|"
    rf"\W*{_POWER_OF_TEN_PATTERN}\W*|"
    r".*(?<![0-9])(?<![0-9] )(?:[×*·]\s*(?:10|1e)|x\s*(?:10\s*\^|10\s*[-−+][0-9]|1e[-+−]?[0-9]|10{3,6}\b)).*|"
    # This pattern matches a height factor such as "z x0.1 (um)".
    r".*\b(?:z|heights?)\s+x\s?(?!1(?:[.,]0*)?(?![0-9.,e]))[.,]?[0-9].*|"
    r".*\b(?:multiplied|multiply|divided|divide|scaled|normali[sz]ed|multipliziert|dividiert|skaliert|normiert)\s+"
    rf"(?:(?:by|mit|durch|um)\b{_FACTOR_OTHER_THAN_ONE_PATTERN}|(?:to|auf)\b(?!\s*1\s*:\s*1\W*$)).*|"
    rf".*\b(?:z|heights?|data|values?|numbers?)\W+(?:are\s+)?times\s+{_FACTOR_OTHER_THAN_ONE_PATTERN}{DECIMAL_PATTERN}\b.*|"
    rf"\W*(?:times\s+{_FACTOR_OTHER_THAN_ONE_PATTERN}{DECIMAL_PATTERN}|z\s*[/*×·]\s*10+)\W*|"
    r"\W*(?:z|heights?|höhen?)\b.*[0-9]\s*[nuµpm]?m\s*(?:/|per\b|pro\b)\s*(?!s\b|sec|min)[^\W\d_]+.*|"
    # This pattern excludes "heights in 1 µm", which is a unit and not a factor.
    r"(?!\W*(?:z|heights?|data|values?)\s+(?:are\s+)?in\s+1(?:[.,]0*)?\s)"
    rf"\W*(?:(?:z|heights?|data|values?|numbers?)\W+)?(?:are\s+)?(?:in|units? of)\s+{DECIMAL_PATTERN}\s*[nuµpm]?m\W*|"
    rf"\W*(?:(?:z|heights?|data|values?|vertical|scal\w*|conversion|calibration|unit|multiplication|amplitude|"
    rf"add[ _]offset\W*{DECIMAL_PATTERN})[\s_-]*)*"
    r"(?:fa[ck]tor|facteur|fattore|fator|multiplier|multiplicat\w*|scaling|skalierung|sensitivity|empfindlichkeit|"
    r"gain|verstärkung|amplification|conversion(?! of)|umrechnung|magnification|vertikalvergrößerung|"
    r"überhöhung|倍率|係数|系数|比例|множитель|коэффициент)(?![^\W\d_]).{0,20}?"
    rf"{SEPARATOR_PATTERN}{_FACTOR_OTHER_THAN_ONE_PATTERN}{DECIMAL_PATTERN}.*|"
    r"\W*(?:(?:z|heights?|data|values?|vertical|scal\w*|unit|decimal)[\s_-]*)*exponent(?![^\W\d_]).{0,20}?"
    # This pattern excludes an exponent of 0, which leaves the heights unchanged.
    rf"{SEPARATOR_PATTERN}(?![-+]?0(?:[.,]0*)?\W*$){DECIMAL_PATTERN}.*|"
    rf"\W*(?:(?:z|heights?|data|values?|vertical)[\s_-]*)*scale{SEPARATOR_PATTERN}"
    rf"{_FACTOR_OTHER_THAN_ONE_PATTERN}{DECIMAL_PATTERN}\W*|"
    rf".*(?:\b(?:[nuµp]?m|heights?|volts?|V)|[0-9][nuµp]m)\s*(?:/|per)\s*(?:{_CONVERTER_UNIT_PATTERN}|div|[nuµm]m)\b.*|"
    rf".*\b{_CONVERTER_UNIT_PATTERN}\s*(?:/|per)\s*[nuµm]m\b.*|.*\b(?:tenth|hundredth|thousandth)s? of\b.*|"
    rf"\W*(?:z|heights?)\s*=\s*(?:(?!1(?:[.,]0*)?\s*[*×·x]){DECIMAL_PATTERN}\s*[*×·x]\s*[^\W\d].*|"
    rf"[^\W\d]\w*\s*[*×·x/]\s*{_FACTOR_OTHER_THAN_ONE_PATTERN}{DECIMAL_PATTERN}\W*)|"
    rf"\W*(?:vertical[\s_-]*)?(?:vergrößerung|maßstab|massstab|scale){SEPARATOR_PATTERN}{_FACTOR_OTHER_THAN_ONE_PATTERN}(?!1\s*:\s*1\W*$)"
    rf"{DECIMAL_PATTERN}\s*:\s*1\W*|"
    rf"\W*(?:z\W+)?LSB{SEPARATOR_PATTERN}{DECIMAL_PATTERN}.*|"
    rf".*(?<![0-9.,])1\s*{_CONVERTER_UNIT_PATTERN}\s*[=:]\s*{DECIMAL_PATTERN}.*",
    re.IGNORECASE,
)
"""Regular expression for a line that describes in words a factor that may apply to the heights."""

_NON_HEIGHT_FACTOR_PATTERN = LazyPattern(
    r"objective|objektiv|(?<!vertical )(?<!height )(?<!\bz )magnif|zoom|lens|shape|form|crest|filter|quality|aspect|"
    r"exaggerat|spring|frequency|defl|piezo|bias|feedback|\bdB\b",
    re.IGNORECASE,
)
_HEIGHT_FACTOR_PATTERN = LazyPattern(
    rf"\W*(?:(?:z|height|vertical|data|value)[\s_-]*)+(?:conversion[\s_-]*)?(?:factor|scale|scaling|multiplier)"
    rf"\s*(?:\(\s*-?>?\s*({UNIT_PATTERN})\s*\)|[\[(]({UNIT_PATTERN})[^\])]{{0,20}}[\])])?{SEPARATOR_PATTERN}({DECLARED_NUMBER_PATTERN})\s*({UNIT_PATTERN})?\W*.{{0,20}}",
    re.IGNORECASE,
)
_CONVERSION_WORD_PATTERN = LazyPattern(r"factor|conversion|multiplier|->|\bper\b|/\s*(?:[^\W\d_]|1\b)", re.IGNORECASE)
"""Regular expression for words that mark a scale as a conversion from numbers to heights, rather than as a colour
range.
"""

_MISSING_CODE_PATTERN = LazyPattern(
    rf"\W*(?:no[\s_-]?data|missing|void|invalid|bad|undefined|fill|null|mask(?:ed)?|fehl)[\s_-]*"
    rf"(?:data|points?|pixels?|height)?[\s_-]*(values?|code|wert)?{SEPARATOR_PATTERN}({DECIMAL_PATTERN})\W*",
    re.IGNORECASE,
)
_POINT_COUNT_PATTERN = LazyPattern(
    r"\W*(?:(?:number|no\.?|anzahl) (?:of |der )?(?:data[ _-]?)?(?:points|punkte)|num[ _-]?points|data[ _-]?size|"
    r"points|datenpunkte|messpunkte)" + SEPARATOR_PATTERN + r"([0-9]{1,9})\W*",
    re.IGNORECASE,
)
_TIP_RADIUS_PATTERN = LazyPattern(
    rf"\W*(?:stylus|tip|probe)[\s,;:_-]*radius\s*(?:[\[(]({UNIT_PATTERN})[\])])?{SEPARATOR_PATTERN}({DECIMAL_PATTERN})\s*({UNIT_PATTERN})?\W*",
    re.IGNORECASE,
)
_HEIGHT_RANGE_PATTERN = LazyPattern(
    rf"\W*(?:z[\s_-]*(?:amplitude|range|p-?v)|height[\s_-]*range|peak[\s_-]*(?:to|-)[\s_-]*valley)"
    rf"\s*(?:[\[(]({UNIT_PATTERN})[\])])?{SEPARATOR_PATTERN}({DECIMAL_PATTERN})\s*({UNIT_PATTERN})?\W*",
    re.IGNORECASE,
)
MAX_UNIT_LENGTH = 12
_HISTORY_PREFIX = "# history: "

NON_LENGTH_UNIT_PATTERN = LazyPattern(
    r"(?:[afpnuµμmcdhkMGT]|micror?|milli|nano|kilo)?[ -]?"
    r"(?:V|A|N|s|Hz|Pa|K|C|W|J|g|F|T|dB|%|°|°C|in|ft|yd|pts?|px|1/0|0/1|1|"
    r"(?i:rad(?:ians?)?|volts?|amp(?:ere)?s?|newtons?|seconds?|sec|min|deg(?:rees?)?|"
    r"(?:raw ?)?counts?|cts|lsb|digits?|adu|a\.?u\.?|arb\.?(?: ?units?)?|pixels?|points?|"
    r"gr[ae]y ?(?:levels?|values?)|graustufen|inch(?:es)?|mils?|thou|zoll|feet|foot|yards?|ticks?|"
    r"tenths|steps?|schritte|bool|waves?|fringes?|lines?|pollic[ei]|pouces?))"
    r"(?:/[\w.°µ]+)?|[kdhf]m|"
    r"[nuµmp] m|[NUMCP]M|[Mm][UuYy]m?|µ|\\\\?mum|[Mm]ic|[Aa]ng|µm²|[µu]m\^?2|[nuµm]?m/(?:s|min|h|rev|N|V|nm|um|µm|mm)|"
    r"(?:tenths?|hundredths?|thousandths?) of .{1,12}"
)
"""Regular expression for units of other quantities than length, and for ambiguous units of length."""

NON_HEIGHT_NAME_PATTERN = LazyPattern(
    r"\b(slopes?|steigung|pente|phase|current|strom|voltage|spannung|intensity|intensität|luminance|brightness|"
    r"deflection|friction|lateral force|force|kraft|time|zeit|curvature|krümmung|gradient|temperature|"
    r"psd|power spectr\w*|spectr(?:um|al density)|acf|autocorrelation|probability|frequency|frequenz|reflect\w*)\b",
    re.IGNORECASE,
)
"""Regular expression for the names of quantities that are not heights."""

_SLOPE_LINE_PATTERN = LazyPattern(
    r"\W*(?:[^\W\d]+[\s_]+)?slopes?[\s_-]*(?:errors?|profiles?|data|scan|values?)\b(?!.*(?:remov|correct|subtract)).*|"
    r"\W*(?:ordinates?|[yz]|data|values?|quantity|type|(?:second |2nd )?column(?: 2)?)\W+(?:(?:are|is|contains?)\W+)?"
    r"slopes?\b.*",
    re.IGNORECASE,
)
_SLOPE_NAME_PATTERN = LazyPattern(r".*(?<![^\W_])slopes?(?![^\W_]).*(?<![^\W_])(?:micro|milli|[nuµm])?rad\w*\b.*", re.I)
"""Regular expression for a line of column names that names slopes.

`_SLOPE_LINE_PATTERN` matches other header lines that declare the numbers to be slopes.
"""
_SLOPE_VALUE_PATTERN = LazyPattern(r"[:=(]\s*[-+]?[0-9]")
"""Regular expression for a number after a name, as in "slope = 0.1": such a line gives one slope, and does not declare
the numbers of the table to be slopes.
"""

_OTHER_AXIS_NAME_PATTERN = LazyPattern(
    r"(?<![^\W_])(?:(wave[ _-]?(?:lengths?|numbers?|vectors?)|wellenlängen?|lambda|λ|frequenc(?:y|ies)|frequenz(?:en)?|"
    r"freq|lag|load|force|kraft|(?:time|zeit)\w*)|temps|t|seconds?|sekunden?|sec|minutes?|date|angles?|winkel|theta|phi|degrees?|"
    r"grad|radians?|f|q|k|pressure|druck|temp(?:eratur\w*)?|voltage|spannung|current|strom|cycles?|zyklen|"
    r"speed|velocity|energy|intensity|probability)(?![^\W_])",
    re.IGNORECASE,
)
"""Regular expression for the names of axes that are not positions, such as "time" or "t". The group matches names that
do not denote a position even if their unit is a length, such as "wavelength".
"""

_LENGTH_AXIS_PATTERN = LazyPattern(
    r"(?<![^\W_])(?:[xy]\w?|(?:pos|coord|koord|dist|length|län[gn]|lateral|horiz|travers|track|scan|path|abstand|"
    r"strecke|weg|mess(?:weg|länge)|ort|abscis|longit|longueur|lungh|compr|poz|odle|dłu[gż]|dél|vzd|poloh|afst|avst|"
    r"lengte|lengde|läge|etäis|paik|pituus|távol|hossz|mesafe|konum|uzun|полож|коорд|длин|расст|путь)\w*)(?![^\W_])|"
    r"距離|距离|位置|座標|坐标|長さ|长度|横|거리|위치|길이|좌표",
    re.IGNORECASE,
)
"""Regular expression for the names of positions along a profile, in several languages."""

_CALCULATION_PATTERN = LazyPattern(
    r"[*×·^√]|(?<![^\W_])x\s?(?:10+(?![0-9])|[0-9]*[.,][0-9])|[0-9]x(?![^\W_])|\|\w[^|]*\||/\s*(?:[0-9]|[RS][aqz]\b)|^\W*[-−]\s*z\b|"
    r"\b(?:log(?:10)?|ln|sqrt)\b|\b(?:abs|exp)\s*(?:[0-9]|z\b)|\bd\w\s*/\s*d\w\b|"
    r"\b(?:scaled|normali[sz]ed|skaliert|normiert)\b",
    re.IGNORECASE,
)
_HEIGHT_FUNCTION_PATTERN = LazyPattern(r"\b(?:abs|exp)\s*[(\[{][^)\]}]*\b(?:z|heights?|höhen?)\b", re.IGNORECASE)
_HEIGHT_NAME_PATTERN = LazyPattern(
    r"(?<![^\W_])(?:z|heights?|höhen?|hauteurs?|altezz[ae]|alturas?|topograph\w*|elevations?|amplitudes?)(?![^\W_])",
    re.I,
)
_POSITION_NAME_PATTERN = LazyPattern(
    r"(?<![^\W_])(?:[xy]+|xyz|positions?|coordinates?|lateral\w*|lengths?|all|spacings?|distances?|weg)(?![^\W_])", re.I
)
_BRACKETED_WORD_PATTERN = LazyPattern(r"[(\[{<]\s*([^()\[\]{}<>]{1,20}?)\s*[)\]}>]")
_HEADER_VALUE_PATTERN = LazyPattern(r"(?:^|[\s,;:=])[+-]?[0-9][0-9.,]*(?:[eE][+-]?[0-9]+)?[^\W\d_]{0,3}(?=$|[\s,;:/])")


_REMARK_PATTERN = LazyPattern(
    r"\W*|[0-9.]+|.{13,}|(?:(?:un)?(?:raw|filtered|level(?:l?ed)?|corrected|calibrated|measured|smoothed|processed)|trace|retrace|"
    r"forwards?|backwards?|fwd|bwd|mean|average|avg|left|right|abs|absolute|rel|relative|top|bottom|upper|lower|primary|"
    r"roughness|waviness|profile|p|r|w|heights?|depth|x|y|z|pos\w*|lateral|vertical|no|yes|optional|nominal|text|numbers?|"
    r"rows?|columns?|ch(?:annel)?|sensor|data|all|maps?|image|matrix|field|signal|surface|values?|werte?|ax[ei]s|achse|coord\w*|points?)[\s_-]*[0-9]*",
    re.IGNORECASE,
)
"""Regular expression for remarks in a column name that are not units, as in "Height (trace)"."""

_AXIS_NAME_PATTERN = (
    r"(?:[xyz]|(?:(?:surface|total|measured|profile?)[ _-]?)?(?:heights?|höhen?)|hauteur|altura|altezza|topography|"
    r"depth|profile?|pos(?:itions?)?|distances?|lengths?|weg|abstand|lateral)"
    r"(?:[ _-]?(?:axis|achse|pos(?:ition)?|coord\w*|values?|wert))?"
)
_UNIT_AFTER_NAME_PATTERN = LazyPattern(
    rf"{_AXIS_NAME_PATTERN}\s*(?:/|\bin\b|,(?=\s*(?:[0-9]|\S{{1,8}}(?: \S{{1,8}})?$)))\s*(\S{{1,12}}(?: \S{{1,12}})?)",
    re.IGNORECASE,
)
"""Regular expression for a column name with a unit after a slash, a comma or "in", as in "z/nm" or "height in nm"."""

_SHORT_UNIT_AFTER_NAME_PATTERN = LazyPattern(
    rf"\W*(?:{_AXIS_NAME_PATTERN}|{_HEIGHT_WORDS})\s*[(\[]\s*(?-i:[a-zµ]{{1,4}})\s*[)\]]\W*", re.IGNORECASE
)
"""Regular expression for the name of a single column that ends with a short word in brackets, as in "Profile (nmi)"."""

_TEXT_AFTER_AXIS_NAME_PATTERN = LazyPattern(rf"{_AXIS_NAME_PATTERN}[\s_.:|-]+((?!\d+$)[^\s_].{{0,20}})", re.IGNORECASE)
"""Regular expression for the name of an axis, followed by words that may be a unit."""

_SCALED_UNIT_PATTERN = LazyPattern(
    r"(.*?[^\W_])[\s_,.:/|-]+"
    rf"((?:{_FACTOR_PATTERN}|[0-9]+[.,][0-9]+[\s_]*|[0-9]+)([^\W\d_]+)(?:/10+)?|([^\W\d_]+)\s?[/*×·x]\s?10+|"
    r"[nuµmp] m|(?:tenth|hundredth|thousandth)s? of [^\W\d_]+)",
    re.IGNORECASE,
)
"""Regular expression for a column name and a unit with a factor, as in "z 10 nm" and "z mm/100", or with a separate
prefix, as in "z u m".
"""

_WORDS_BEFORE_PROFILE_NUMBER_PATTERN = LazyPattern(
    r".*\b(?:profile?|scan|trace|line|track|messung|nr\.?|no\.?)", re.IGNORECASE
)
"""Regular expression for words before the number of a profile, as in "Profile 10 um"."""

_NAME_ENDINGS_LIKE_UNITS = ("point", "points", "pt", "pts", "line", "lines", "min", "sec", "px", "pixel", "pixels")
"""Last words of column names that look like units but are no units, as in "data point" and "z min"."""


@dataclass(frozen=True)
class ColumnHeadings:
    """Names and units of the columns of a table, and the unit of the heights if a separate header line states it."""

    names: tuple[str, ...] = ()
    units: tuple[str | None, ...] = ()
    height_unit: str | None = None


_INCH_MARK_PATTERN = LazyPattern(r'([(\[])\s*"{1,2}\s*([)\]])|(?<=[^\W\d]/)"{1,2}(?=[,;\t]|$)')
_UNPAIRED_INCH_MARK_PATTERN = LazyPattern(r'(?<=[,;\t:=_ ])"(?=[,;\t]|$)')
"""Regular expression for an inch mark in a line with an odd number of double quotes, as in `Unit: "`."""


def normalise_line(line: str) -> str:
    """Replace unusual characters in a header line by common characters, and remove double quotes.

    Unusual characters are full-width characters, unit ligatures, inch marks and HTML entities.
    """
    line = html.unescape(line) if "&" in line else line
    line = _INCH_MARK_PATTERN.sub(r"\1inch\2", unicodedata.normalize("NFKC", line))
    if line.count('"') % 2:
        line = _UNPAIRED_INCH_MARK_PATTERN.sub("inch", line)
    return line.replace('"', "").replace("\u03bc", "µ").replace("\u2212", "-")


def parse_declarations(
    header: Sequence[str], *, footer: Sequence[str] = (), is_profile: bool = False, has_names: bool = False
) -> HeaderDeclarations:
    """Parse declarations above and below a table: units, spacings, factors and codes for missing points.

    Of several declarations of the same kind, the first one counts. In the header of a profile, y denotes the heights.
    With `has_names`, the last line contains column names.
    """
    header = [line for line in header if not line.startswith(_HISTORY_PREFIX)]
    lines = [normalise_line(line) for line in (*header, *footer) if not line.startswith(_HISTORY_PREFIX)]
    spacings = parse_spacing_declarations(lines)
    factor_lines = [
        line for line in lines if (match := _HEIGHT_FACTOR_PATTERN.fullmatch(line)) and _parse_factor_unit(match)
    ]
    factor_line = next((line for line in factor_lines if _CONVERSION_WORD_PATTERN.search(line)), "")
    unit, unit_line = _parse_height_unit(lines, is_profile, spacings.size is not None)
    factor = None
    if factor_line and (match := _HEIGHT_FACTOR_PATTERN.fullmatch(factor_line)):
        unit = _parse_factor_unit(match)
        factor = parse_positive_number(match[3], f"in its header line {factor_line[:80]!r}")
    else:
        factor_lines += [line for line in lines if is_unapplied_factor(line)]
    code_matches = [match for line in lines if (match := _MISSING_CODE_PATTERN.fullmatch(line))]
    codes = [parse_number(match[2], f"in its header line {match[0][:80]!r}") for match in code_matches]
    is_count = [
        match[1] is None and code.is_integer() and code >= 0 for match, code in zip(code_matches, codes, strict=True)
    ]
    position_units = [match[1] for line in lines if (match := _POSITION_UNIT_PATTERN.fullmatch(line))]
    if is_profile and (column_units := _find_column_units(lines)) is not None:
        position_units, unit = [column_units[0]], parse_length_unit(column_units[1]) or column_units[1]
    position_units += [
        match[1]
        for line in lines
        if (match := _POSITION_QUANTITY_PATTERN.fullmatch(line)) and find_other_axis(match[1], None)
    ]
    return HeaderDeclarations(
        spacing=spacings.spacing,
        spacings=spacings.spacings,
        row_spacing=spacings.row_spacing,
        size=spacings.size,
        bare_spacing=spacings.bare_spacing,
        unclear_spacing=spacings.unclear,
        unit=unit,
        position_unit=next((parse_length_unit(text) or text for text in position_units), None),
        factor=factor,
        codes=tuple(code for code, count in zip(codes, is_count, strict=True) if not count),
        counts=tuple(code for code, count in zip(codes, is_count, strict=True) if count),
        unapplied_factor_line="" if factor_line else next(iter(factor_lines), "").strip(),
        points=next((int(match[1]) for line in lines if (match := _POINT_COUNT_PATTERN.fullmatch(line))), None),
        height_range=find_first_match(_HEIGHT_RANGE_PATTERN, lines, parse_bracketed_length),
        tip_radius=find_first_match(_TIP_RADIUS_PATTERN, lines, parse_bracketed_length),
        unit_line=factor_line or unit_line,
        slope_line=_find_slope_line(lines[: len(header)], has_names) if is_profile else "",
    )


def _find_slope_line(lines: Sequence[str], has_names: bool) -> str:
    """Return the header line that declares that the numbers are slopes.

    Returns an empty string if there is no such line.

    A line that gives the value of a slope, such as "Rms slope: 0.02", is no such declaration.
    """
    name_line = "" if has_names else _find_last_line_with_letters(lines) or ""
    lines = lines[:-1] if has_names else lines
    if _SLOPE_NAME_PATTERN.fullmatch(name_line) and not _HEIGHT_NAME_PATTERN.search(name_line):
        return name_line
    return next(
        (line for line in lines if _SLOPE_LINE_PATTERN.fullmatch(line) and not _SLOPE_VALUE_PATTERN.search(line)), ""
    )


def _find_column_units(lines: Sequence[str]) -> tuple[str, str] | None:
    """Return the units of positions and heights that the header declares.

    Returns None without such units.

    One line may contain both units, or several lines may contain the same unit.
    """
    for line in lines:
        if (match := _UNITS_OF_COLUMNS_PATTERN.fullmatch(line)) is not None:
            return match[1], match[2]
        if len(record_units := _UNIT_IN_RECORD_PATTERN.findall(line)) > 1:
            return record_units[0], record_units[-1]
    plain_units = [unit for unit, _ in _list_plain_units(lines)]
    return (plain_units[0], plain_units[0]) if len(plain_units) > 1 and len(set(plain_units)) == 1 else None


def _list_plain_units(lines: Sequence[str]) -> list[tuple[str, str]]:
    """Return the header lines that contain a unit but no name of a quantity, each as a pair (unit, line)."""
    return [(match[1], line) for line in lines if (match := _PLAIN_UNIT_PATTERN.fullmatch(line))]


def _parse_height_unit(lines: Sequence[str], is_profile: bool, has_size: bool) -> tuple[str | None, str]:
    """Return the height unit that a header declares, and the header line with this unit.

    An unknown unit is returned unchanged. With `has_size`, the header declares the size of a map, and "Height 10 um" is
    a part of this size.
    """
    plain_units = dict(_list_plain_units(lines))
    if len({parse_length_unit(unit) or unit for unit in plain_units}) > 1:
        return " and ".join(plain_units), next(iter(plain_units.values()))
    for line in lines:
        if (match := _HEIGHT_UNIT_PATTERN.fullmatch(line)) and is_unit(match[1]):
            return parse_length_unit(match[1]) or match[1], line
    for line in lines:
        if (unit := _find_unit_after_height_name(line, is_profile, has_size)) is not None:
            return parse_length_unit(unit) or unit, line
        if is_profile and (match := _UNIT_OF_Y_PATTERN.fullmatch(line)) and match[1].casefold() not in _NON_UNIT_WORDS:
            return parse_length_unit(match[1]) or match[1], line
        if (match := _UNKNOWN_UNIT_PATTERN.fullmatch(line)) is None:
            continue
        text = match[1].strip()
        has_known_unit = any(parse_length_unit(word) for word in re.split(r"[\s,;()\[\]]+", text))
        if not (text.casefold() in _NON_UNIT_WORDS or (has_known_unit and not re.search("[0-9]", text))):
            return parse_length_unit(text) or text, line
    return None, ""


def _find_unit_after_height_name(line: str, is_profile: bool, has_size: bool) -> str | None:
    """Return the unit after the name of the heights in a header line ("Z: nm", "z 10 nm").

    Returns None without a unit.

    The unit may be unknown. Remarks and factors are not units.
    """
    if (match := _UNIT_OF_Z_PATTERN.fullmatch(line)) is None:
        return None
    colon, size_name, space_after_unit, text = match.groups()
    scaled_match = None if size_name and has_size else _UNIT_WITH_FACTOR_PATTERN.fullmatch(text)
    if is_unit(text) or (scaled_match and parse_length_unit(scaled_match[1] or scaled_match[2])):
        return text
    if (colon or space_after_unit) and text.casefold() == "raw":
        return text
    is_single_word = is_profile and re.fullmatch(r"[^\s0-9(\[{<]\S{0,7}", text)
    return None if not is_single_word or _REMARK_PATTERN.fullmatch(text) or is_unapplied_factor(line) else text


def is_unapplied_factor(text: str) -> bool:
    """Return whether a header line or column name contains a factor by which heights may have to be multiplied."""
    return (
        _UNAPPLIED_FACTOR_PATTERN.fullmatch(text) is not None
        and _NON_HEIGHT_FACTOR_PATTERN.search(text) is None
        and not (is_spacing_declaration(text) and not re.search(r"/|\bper\b", text))
    )


def parse_history(header: Sequence[str]) -> list[str]:
    """Return the processing steps that `write_profile` or `write_surface` has written above the numbers of a file."""
    return [line.removeprefix(_HISTORY_PREFIX) for line in header if line.startswith(_HISTORY_PREFIX)]


def _parse_factor_unit(match: re.Match[str]) -> str | None:
    unit = match[1] or match[2] or match[4]
    return parse_length_unit(unit) if unit else None


def _is_declaration(line: str) -> bool:
    """Return whether a header line declares a unit, spacing, factor or missing-point code, rather than column names."""
    declaration_patterns = (
        _UNKNOWN_UNIT_PATTERN,
        _POSITION_UNIT_PATTERN,
        _UNIT_OF_Y_PATTERN,
        _UNITS_OF_COLUMNS_PATTERN,
        _HEIGHT_UNIT_PATTERN,
        _HEIGHT_FACTOR_PATTERN,
        _MISSING_CODE_PATTERN,
        _POINT_COUNT_PATTERN,
        _HEIGHT_RANGE_PATTERN,
    )
    is_unit_of_z = (match := _UNIT_OF_Z_PATTERN.fullmatch(line)) is not None and bool(match[1] or match[3])
    return (
        is_unit_of_z or any(pattern.fullmatch(line) for pattern in declaration_patterns) or is_spacing_declaration(line)
    )


def _find_last_line_with_letters(lines: Sequence[str]) -> str | None:
    """Return the last header line that contains letters, after removing its leading comment characters.

    Returns None without such a line.
    """
    return next((line.lstrip(COMMENT_CHARACTERS) for line in reversed(lines) if any(map(str.isalpha, line))), None)


def _mentions_only_heights(line: str) -> bool:
    """Return whether a header line states a unit of heights, but mentions neither positions nor other lengths."""
    return bool(
        len(_find_units(line)) == 1
        and not _has_number_outside_brackets(line)
        and _HEIGHT_NAME_PATTERN.search(line)
        and not _POSITION_NAME_PATTERN.search(line)
    )


def _find_units(line: str) -> list[str]:
    """Return the units that a header line contains.

    Units in brackets have priority. Without such units, separate words that are units are returned.
    """
    bracketed_units = [word for word in _BRACKETED_WORD_PATTERN.findall(line) if is_unit(word)]
    units = [parse_length_unit(word.strip(" \"'.:")) or word for word in bracketed_units]
    return units or [unit for word in re.split(r"[\s,;]+", line) if (unit := parse_length_unit(word.strip(" \"'.:")))]


def _has_number_outside_brackets(line: str) -> bool:
    """Return whether a header line contains a number outside brackets, as in "Length (um): 1500".

    Such a line does not contain column names.
    """
    return _HEADER_VALUE_PATTERN.search(_BRACKETED_WORD_PATTERN.sub(" ", line)) is not None


def is_unit(word: str) -> bool:
    """Return whether a word is a unit, either of length or of another quantity."""
    return parse_length_unit(word) is not None or NON_LENGTH_UNIT_PATTERN.fullmatch(word) is not None


def find_other_axis(name: str, unit: str | None) -> str | None:
    """Return the quantity, such as "time", that a column contains instead of positions, or None for positions.

    The result is also None if the unit of the column is not a length, because such units are rejected elsewhere.
    """
    match = _OTHER_AXIS_NAME_PATTERN.search(_BRACKETED_WORD_PATTERN.sub(" ", name))
    if match is None or (unit is not None and (match[1] is None or parse_length_unit(unit) is None)):
        return None
    return match[0].lower()


def is_length_axis(name: str) -> bool:
    """Return whether a column name denotes positions along a profile."""
    return _LENGTH_AXIS_PATTERN.search(_BRACKETED_WORD_PATTERN.sub(" ", name)) is not None


def is_computed_height(name: str) -> bool:
    """Return whether a column name is a calculation from heights, such as "1000*z", "-z" or "log z"."""
    name_without_units = _BRACKETED_WORD_PATTERN.sub(" ", name)
    return bool(_CALCULATION_PATTERN.search(name_without_units) or _HEIGHT_FUNCTION_PATTERN.search(name))


# ---- Column names ---------------------------------------------------------------------------------------------------


def parse_column_headings(header: Sequence[str], width: int, dialect: Dialect) -> ColumnHeadings:
    """Parse the names and the units of `width` columns from the lines above the numbers of a table."""
    lines = [line for line in map(normalise_line, header) if not _is_declaration(line)]
    if not lines:
        return ColumnHeadings()
    names, has_unit_line = _parse_column_names(lines, width, dialect)
    if len(lines) > 2 and not has_unit_line and not _contains_axis_name(names):
        # Below the line of units, a table may have a line with the data types of the columns.
        names_above, has_unit_line = _parse_column_names(lines[:-1], width, dialect)
        if has_unit_line and _contains_axis_name(names_above):
            lines, names = lines[:-1], names_above
    units = _parse_column_units(lines, width, dialect)
    if has_unit_line:
        units = tuple(unit_in_column_name(name) for name in names)
    name_line = _find_last_line_with_letters(lines)
    is_of_heights = width > 2 and not any(units) and name_line is not None and _mentions_only_heights(name_line)
    return ColumnHeadings(names, units, _find_units(name_line)[0] if is_of_heights and name_line is not None else None)


def split_column_names(line: str, width: int, dialect: Dialect) -> list[str] | None:
    """Split a line of column names into `width` names, or return None if this is impossible.

    The separator of the names may differ from the separator of the numbers.
    """
    uncommented_line = line.lstrip(COMMENT_CHARACTERS) if line.lstrip(" ")[:1] in tuple("#%!/") else line
    candidates = [
        dialect.split_line(uncommented_line),
        *(uncommented_line.split(separator) for separator in "\t;,|"),
        re.split(r"\s{2,}", uncommented_line.strip()),
    ]
    # A unit in brackets ends a column name, as in "x (mm) z (um)".
    cells_with_units = re.split(r"(?<=[)\]])\s+", uncommented_line.strip())
    if all(is_unit(unit_in_column_name(cell) or "") for cell in cells_with_units):
        candidates.append(cells_with_units)
    words = uncommented_line.split()
    if dialect.separator is None and len(words) == 2 * width and any(map(parse_length_unit, words[1::2])):
        # The line has pairs of names and units, as in "DISTANCE mm DEPTH um".
        return [f"{name} [{unit}]" for name, unit in zip(words[::2], words[1::2], strict=True)]
    for candidate_index, cells in enumerate(candidates):
        cells = [cell.strip(" \"'") for cell in cells]
        while len(cells) > width and not cells[-1]:
            cells.pop()
        if (
            len(cells) > width > 1
            and candidate_index == 0
            and dialect.separator is not None
            and any(map(_has_unit, cells))
        ):
            # A header may have more names than there are columns; surplus names at its end are ignored.
            return cells[:width]
        if len(cells) == width:
            return cells
        # The header may have no name for the column of row numbers.
        if len(cells) == width - 1 and line[:1] in "\t;, ":
            return ["", *cells]
    return None


def _has_unit(cell: str) -> bool:
    return unit_in_column_name(cell) is not None


def _parse_column_names(lines: Sequence[str], width: int, dialect: Dialect) -> tuple[tuple[str, ...], bool]:
    """Return the column names of a table, and whether the last header line contains only the units of the columns."""
    names = split_column_names(lines[-1], width, dialect) if width > 1 else None
    if names is None:
        return (), False
    units = [cell.strip("[]() ") for cell in names]
    previous_names = (split_column_names(lines[-2], width, dialect) if len(lines) > 1 else None) or []
    is_unit_line = all(not unit or is_unit(unit) for unit in units) or (
        (
            any(map(parse_length_unit, units))
            or (_contains_axis_name(previous_names) and not _contains_axis_name(units) and all(units))
        )
        and all(len(unit) <= MAX_UNIT_LENGTH for unit in units)
    )
    previous_units = [cell.strip("[]() ") for cell in previous_names]
    if (
        any(map(parse_length_unit, previous_units))
        and not _contains_axis_name(previous_units)
        and _contains_axis_name(names)
    ):
        return tuple(
            f"{name} [{unit}]" if unit else name for name, unit in zip(names, previous_units, strict=True)
        ), True
    if previous_names and is_unit_line:
        return tuple(
            f"{name} [{unit}]" if unit else name for name, unit in zip(previous_names, units, strict=True)
        ), True
    return tuple(names), False


def _contains_axis_name(names: Sequence[str]) -> bool:
    """Return whether at least one column name denotes positions or heights."""
    return any(is_length_axis(name) or _HEIGHT_NAME_PATTERN.search(name) for name in names)


def _parse_column_units(lines: Sequence[str], width: int, dialect: Dialect) -> tuple[str | None, ...]:
    """Return the unit of each column (None if unknown) from the line of column names above the numbers."""
    name_line = _find_last_line_with_letters(lines)
    if name_line is None:
        return (None,) * width
    cells = split_column_names(name_line, width, dialect) if width > 1 else None
    # A number in a column name must belong to a unit, as in "z in 1e-9 m".
    if _has_number_outside_brackets(name_line):
        is_name_line = cells is not None and all(
            _UNIT_AFTER_NAME_PATTERN.fullmatch(cell)
            or _find_scaled_unit(cell)
            or is_unit(_find_unknown_unit(cell) or "")
            or not _has_number_outside_brackets(cell)
            for cell in cells
        )
        return tuple(map(unit_in_column_name, cells)) if cells is not None and is_name_line else (None,) * width
    if cells is not None and any(unit_in_column_name(cell) for cell in cells):
        # If one column name ends with a known unit ("x mm"), other names are assumed to end with units too ("z V").
        last_words = [_split_name_into_words(cell)[-1] for cell in cells]
        names_end_with_units = any(map(parse_length_unit, last_words))
        return tuple(
            unit_in_column_name(cell)
            or (word if names_end_with_units and word != cell and NON_LENGTH_UNIT_PATTERN.fullmatch(word) else None)
            or (_find_unknown_unit(cell) if names_end_with_units else None)
            for cell, word in zip(cells, last_words, strict=True)
        )
    # The same unknown unit may follow all column names, as in "x foo; z foo".
    if cells is not None and len(set(map(_find_unknown_unit, cells))) == 1:
        return tuple(map(_find_unknown_unit, cells))
    units = _find_units(name_line)
    name = _BRACKETED_WORD_PATTERN.sub(" ", name_line)
    mentions_heights = _HEIGHT_NAME_PATTERN.search(name) and not _POSITION_NAME_PATTERN.search(name)
    if width == 1 and mentions_heights and (not units or _find_scaled_unit(name_line)):
        return (unit_in_column_name(name_line),)
    if len(units) == width:
        return tuple(units)
    if width == 1 and _SHORT_UNIT_AFTER_NAME_PATTERN.fullmatch(name_line):
        return (unit_in_column_name(name_line),)
    is_unit_of_all_columns = width > 2 and len(units) == 1 and not _mentions_only_heights(name_line)
    return (units[0] if is_unit_of_all_columns else None,) * width


def unit_in_column_name(cell: str) -> str | None:
    """Return the unit at the end of a column name, such as "z (nm)", "z/nm" or "height in nm"; None without a unit.

    An unknown unit is returned unchanged, so that the column is rejected if it is used.
    """
    bracketed_texts = _BRACKETED_WORD_PATTERN.findall(cell)
    last_part = bracketed_texts[-1].strip() if bracketed_texts else cell.strip(" \"'")
    # A capitalised word such as "Pixel" names a column of point numbers, and is not a unit.
    is_point_number = (
        not bracketed_texts and last_part.casefold() in _NAME_ENDINGS_LIKE_UNITS and not last_part.islower()
    )
    if not is_point_number and NON_LENGTH_UNIT_PATTERN.fullmatch(last_part):
        return last_part
    if not bracketed_texts and (unit := _find_scaled_unit(last_part)) is not None:
        return parse_length_unit(unit) or unit
    unit_after_name = None if bracketed_texts else _UNIT_AFTER_NAME_PATTERN.fullmatch(last_part)
    if unit_after_name is not None and is_unit(unit_after_name[1]):
        return parse_length_unit(unit_after_name[1]) or unit_after_name[1]
    # A slash separates name and unit, as in "z_nm/nm".
    if "/" in (word := _split_name_into_words(last_part)[-1]) and NON_LENGTH_UNIT_PATTERN.fullmatch(word):
        return word
    # A reciprocal unit may follow a name: in "k/1/um", the name is k and the unit 1/um.
    if not bracketed_texts and (match := re.search(r"(?:^|[\s_/])(1/[^\W\d_]+)$", last_part)):
        return match[1]
    unit = parse_length_unit(
        (last_part if bracketed_texts else _split_name_into_words(last_part)[-1].rpartition("/")[2]).strip(" \"'.:")
    )
    if unit is not None:
        return unit
    words = _split_name_into_words(last_part)
    if unit_after_name is not None:
        last_part = unit_after_name[1]
    elif not bracketed_texts and len(words) > 1 and len(words[-1]) > 1:
        return words[-1] if _is_unit_word(words[-1]) else None
    elif not bracketed_texts:
        return None
    known_units = {unit for word in re.split(r"[\s,;]+", last_part) if (unit := parse_length_unit(word)) is not None}
    # A unit may be followed by a remark, as in "µm RMS" or "nm, filtered".
    if len(known_units) == 1 and not re.search(r"[0-9/*^×]|\b(?:of|per|pro)\b", last_part):
        return known_units.pop()
    return None if not known_units and _REMARK_PATTERN.fullmatch(last_part) else last_part


def _split_name_into_words(name: str) -> list[str]:
    """Split a column name into words."""
    return re.split(r"[\s_]+|(?<=[^\W\d_])[-.:|](?=\S)", name.rstrip(" ."))


def _find_unknown_unit(name: str) -> str | None:
    """Return the text after the axis name in a column name if it may be a unit, and None otherwise.

    A remark or a number is not a unit.
    """
    match = _TEXT_AFTER_AXIS_NAME_PATTERN.fullmatch(name)
    if match is None:
        return None
    is_remark_or_number = _REMARK_PATTERN.fullmatch(match[1]) or re.search(r"[^\W\d_]{3,}[\s_-]*[0-9]+$", match[1])
    return None if is_remark_or_number and not is_unit(match[1]) else match[1]


def _is_unit_word(word: str) -> bool:
    """Return whether a word is a unit of a quantity other than a length; words such as "point" are not units."""
    return word.casefold() not in _NAME_ENDINGS_LIKE_UNITS and NON_LENGTH_UNIT_PATTERN.fullmatch(word) is not None


def _find_scaled_unit(name: str) -> str | None:
    """Return a unit with a factor, such as "1e-6m", from the end of a column name.

    Returns None without such a unit.
    """
    match = _SCALED_UNIT_PATTERN.fullmatch(name)
    if match is None or (
        re.match(r"[0-9]+[\s_]", match[2]) and _WORDS_BEFORE_PROFILE_NUMBER_PATTERN.fullmatch(match[1])
    ):
        return None
    unit = match[3] or match[4]
    return match[2] if unit is None or parse_length_unit(unit) is not None else None
