"""Command `stiction materials`: ranges of material properties, with their sources."""

from __future__ import annotations

from typing import Annotated, Any

import typer

from stiction.cli.application import command, print_output
from stiction.cli.options import JsonOption


@command("materials", "stiction materials", "stiction materials steel brass", "stiction materials --json")
def materials(
    names: Annotated[
        list[str] | None, typer.Argument(metavar="NAME", help="Materials (default: all).", show_default=False)
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """List the materials that --upper and --lower of `pair` accept, with Young's modulus, Poisson's ratio and hardness.

    Each value is a range with a source, because hardness depends on treatment and on indentation size. The central
    value is the geometric mean of both ends. Use --hardness of pair for a measured hardness.
    """
    from stiction.mechanics.materials import material
    from stiction.mechanics.materials import materials as all_materials
    from stiction.views.materials import materials_json, materials_text

    chosen_materials: Any = tuple(material(name) for name in names) if names else all_materials()
    print_output(materials_json(chosen_materials) if as_json else materials_text(chosen_materials))
