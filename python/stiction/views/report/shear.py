"""Report on a direct shear test: coefficients at the peak and the end, caveats, figure, and table by displacement."""

from __future__ import annotations

from string import Template
from typing import TYPE_CHECKING

from stiction._core import __version__
from stiction._number_format import format_with_unit
from stiction.mechanics.friction import STATUS_OK
from stiction.views.figures.shear import shear_figure
from stiction.views.report.page import HtmlPage, escape_html, read_package_file
from stiction.views.report.pictures import inline_svg
from stiction.views.shear import curve_rows, headline_estimates, headline_lines, list_caveats

if TYPE_CHECKING:
    import xarray


def shear_page(test: xarray.Dataset, *, name: str, head: list[str] | None = None, command: str = "") -> HtmlPage:
    """Return the report on a direct shear test as an HTML page.

    `head` contains the lines below the title, and `command` is the command line that gives the same test.
    """
    peak = headline_estimates(test)["peak_friction_coefficient"]
    headline = f"<i>μ</i> = {escape_html(peak.text())} at the peak" if peak.status == STATUS_OK else "no peak"
    caveats = "".join(f"<li>{escape_html(caveat)}</li>" for caveat in list_caveats(test))
    titles, *rows = curve_rows(test, range(test.sizes["displacement"]))
    title_cells = "".join(f'<th scope="col">{escape_html(title)}</th>' for title in titles)
    main_markup = Template(read_package_file("shear.html")).substitute(
        headline=headline, lines="".join(f"<li>{escape_html(line)}</li>" for line in headline_lines(test)),
        caveats=f'<h3>Caveats</h3><ul class="caveats">{caveats}</ul>' if caveats else "",
        command=f"<p>Equivalent command: <code>{escape_html(command)}</code></p>" if command else "",
        figure=inline_svg(shear_figure(test), "Shear stress and dilation over the displacement, and the contacts"),
        table=f"<tr>{title_cells}</tr>"
        + "".join(f"<tr>{''.join(f'<td>{escape_html(cell)}</td>' for cell in row)}</tr>" for row in rows),
    )  # fmt: skip
    lines = [*(head or []), *_describe_conditions(test)]
    return HtmlPage(name, lines, main_markup, f"Sheared by stiction {__version__}")


def _describe_conditions(test: xarray.Dataset) -> list[str]:
    """Return one line with the conditions of a shear test: normal stress, interface, hardness, E* and direction."""
    attributes = test.attrs
    conditions = [
        f"normal stress {format_with_unit(float(attributes['normal_stress_GPa']), 'GPa')} on the overlap at the start",
        f"interface {attributes['interface']}" if attributes["interface"] else f"μ0 {attributes['mu0']}",
        f"τ0 {attributes['tau0']}" if not attributes["interface"] else "",
        f"hardness {attributes['hardness'] or 'none'}",
        f"E* {format_with_unit(float(attributes['effective_modulus_GPa']), 'GPa')}",
        f"direction {attributes['direction_deg']:g}°",
    ]  # fmt: skip
    return ["; ".join(condition for condition in conditions if condition)]
