"""`stiction materials`: what is known of materials, as ranges with their sources."""

from __future__ import annotations

from typing import Annotated, Any

import typer

from stiction.cli.application import command, tell
from stiction.cli.options import Json


@command("materials", "stiction materials", "stiction materials steel brass", "stiction materials --json")
def materials(
    names: Annotated[
        list[str] | None, typer.Argument(metavar="NAME", help="Materials; all by default.", show_default=False)
    ] = None,
    as_json: Json = False,
) -> None:
    """List Young's modulus, Poisson's ratio and hardness of materials, as --upper and --lower of pair take them.

    Each is a range with a source: a hardness depends on treatment and on the size of the indentation. Where a pair
    needs one number, it is the geometric mean of both ends; --hardness says what was measured.
    """
    from stiction.mechanics.materials import material
    from stiction.mechanics.materials import materials as known
    from stiction.views.materials import materials_record, materials_text

    chosen: Any = tuple(material(name) for name in names) if names else known()
    tell(materials_record(chosen) if as_json else materials_text(chosen))
