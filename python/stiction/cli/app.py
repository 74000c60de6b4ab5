"""Command `stiction app`: the browser app."""

from __future__ import annotations

from typing import Annotated

import typer

from stiction.cli.application import command, print_message


@command("app", "stiction app", "stiction app --demo")
def app(
    demo: Annotated[bool, typer.Option("--demo", help="Start with two sample surfaces.")] = False,
    keep: Annotated[bool, typer.Option("--keep", help="Keep running after the last window is closed.")] = False,
) -> None:
    """Open the browser app: drop in two scans and get their coefficient of friction.

    The app accepts connections only from this computer, sends no data elsewhere, and exits 90 seconds after its last
    window is closed.
    """
    try:
        from stiction.app.run import run
    except ImportError:
        raise ValueError(
            "app requires starlette and uvicorn; run pip install starlette uvicorn, or ./dev setup in a checkout"
        ) from None
    run(print_message=print_message, keep=keep, demo=demo)
