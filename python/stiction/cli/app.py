"""`stiction app`: a page on this computer where two scans are dropped."""

from __future__ import annotations

from typing import Annotated

import typer

from stiction.cli.application import command, say


@command("app", "stiction app", "stiction app --demo")
def app(
    demo: Annotated[bool, typer.Option("--demo", help="Begin with two surfaces of its own.")] = False,
    keep: Annotated[bool, typer.Option("--keep", help="Go on when no window is open any more.")] = False,
) -> None:
    """Open a page in the browser: drop two scans, and see their friction.

    It answers to this computer alone, sends nothing anywhere, and ends 90 seconds after its last window was closed.
    """
    try:
        from stiction.app.run import run
    except ImportError:
        raise ValueError(
            "app needs the packages starlette and uvicorn: pip install starlette uvicorn, or ./dev setup app in a clone"
        ) from None
    run(say=say, keep=keep, demo=demo)
