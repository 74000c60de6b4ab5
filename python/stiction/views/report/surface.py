"""Report on a measured profile or surface: small-slope estimate, heights, spectra, and roughness."""

from __future__ import annotations

from string import Template
from typing import Any

from stiction._core import __version__
from stiction._number_format import format_percent, format_with_unit
from stiction.summary.characterisation import ASSUMED_MU0, Characterisation
from stiction.surfaces.profile import Profile
from stiction.surfaces.surface import Surface
from stiction.views.characterisation import (
    NEGLIGIBLE_SLOPE_FRACTION,
    CharacterisationTable,
    TableRow,
    to_characterisation,
)
from stiction.views.figures.roughness import characterisation_figure
from stiction.views.point import SLIDING_RULE_DESCRIPTIONS
from stiction.views.report.page import HtmlPage, escape_html, read_package_file
from stiction.views.report.pictures import inline_svg

MAX_SHORTEST_OCTAVE_FRACTION = 0.1


def surface_page(
    body: Profile | Surface | Characterisation, *, name: str, command: str, reading: str = "", **options: Any
) -> HtmlPage:
    """Return the report page for a levelled profile or surface, including the command and the reading options.

    `options` are the options of `characterisation_text`.
    """
    characterisation = to_characterisation(body, **options)
    table = CharacterisationTable(characterisation)
    main_markup = Template(read_package_file("surface.html")).substitute(
        meaning=_interpretation_markup(characterisation), command=escape_html(command),
        table=_table_markup([*table.rows, *table.line_table_rows]),
        figure=inline_svg(characterisation_figure(characterisation), "Heights, their distribution, and spectra"),
        reading=reading and Template(read_package_file("file_reading.html")).substitute(table=reading).rstrip(),
    )  # fmt: skip
    return HtmlPage(name, list(characterisation.body.history), main_markup, f"Characterised by stiction {__version__}")


def _interpretation_markup(characterisation: Characterisation) -> str:
    """Return HTML with caveats, the small-slope estimate of friction, and the expected effect of a finer scan."""
    caveats_markup = "".join(
        f"<li>{escape_html(f'{caveat.text[0].upper()}{caveat.text[1:]}; {caveat.remedy}.')}</li>"
        for caveat in characterisation.caveats
    )
    coefficient_texts = [f"{value:.2f}" for value in characterisation.friction_estimates]
    axes_text = " along x and y" if len(coefficient_texts) == 2 else ""
    limit = characterisation.instrument_limit
    grid_wavelength = limit.pixels
    fraction = float(characterisation.roughness.fraction_below(2 * grid_wavelength))
    change_text = (
        "finds steeper slopes, more friction and less true area"
        if fraction > MAX_SHORTEST_OCTAVE_FRACTION
        else "would change little"
    )
    finer_scan_text = (
        f"Wavelengths below {format_with_unit(2 * grid_wavelength, 'um')} (four points) contribute "
        f"{format_percent(fraction)} of the mean square slope: a finer scan {change_text}."
    )
    if limit.slope_fraction >= NEGLIGIBLE_SLOPE_FRACTION:
        finer_scan_text = (
            f"Wavelengths below {format_with_unit(limit.wavelength, 'um')} may be noise and "
            f"contribute {format_percent(limit.slope_fraction)} of the mean square slope: filter the "
            "scan before you quote a number."
        )
    paragraphs = [
        f"Small-slope estimates for two such surfaces, elastic and without τ0: μₛ = μ0 with "
        f"{SLIDING_RULE_DESCRIPTIONS['all']}; with {SLIDING_RULE_DESCRIPTIONS['opposing']}, "
        f"μₛ = {' and '.join(coefficient_texts)}{axes_text} if μ0 = {ASSUMED_MU0:g}."
        if coefficient_texts
        else "The surface is flat, and so has no small-slope estimate.",
        finer_scan_text,
        "For friction at a given load, compute a pair of surfaces; stiction pair --help shows examples.",
    ]
    return (f'<ul class="caveats">{caveats_markup}</ul>' if caveats_markup else "") + "".join(
        f"<p>{escape_html(line)}</p>" for line in paragraphs
    )


def _table_markup(rows: list[TableRow]) -> str:
    """Return table rows as HTML; the texts of a row without a label are added to the row above."""
    lines: list[tuple[str, list[str]]] = []
    for row in rows:
        label, texts = row.label, row.texts
        cells = [escape_html(text) for text in texts]
        if label or len(lines[-1][1]) > 1:
            lines.append((f'<th scope="row">{escape_html(label.strip())}</th>' if label else "<td></td>", cells))
        else:
            lines[-1][1][0] += f"<br>{cells[0]}"
    cell_attributes = {1: " colspan=2", 2: ""}
    return "".join(
        f"<tr>{heading}{''.join(f'<td{cell_attributes[len(cells)]}>{cell}</td>' for cell in cells)}</tr>"
        for heading, cells in lines
    )
