"""Small datasets that lie beside a result, because they take a moment to compute: contacts, the onset of sliding."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from stiction._files import NotReadableError, content, reason
from stiction._text import named
from stiction.studies.store import StoreError

if TYPE_CHECKING:
    import xarray


def read_beside(
    path: Path,
    variables: Mapping[str, tuple[str, ...]],
    numbers: Iterable[str],
    *,
    text: Mapping[str, list[str]] | None = None,
    optional: Mapping[str, tuple[str, ...]] | None = None,
) -> xarray.Dataset | None:
    """A small dataset that `export` wrote beside a result, if it is there, checked; a `StoreError` if it is not that.

    It has `variables` of real numbers by name, with their dimensions, attributes that are `numbers`, coordinates that
    are `text`, and `optional` variables, which are left out unless all of them are there.
    """
    from stiction.studies.netcdf import MOST_BESIDE, DamageError, decoded_beside

    try:
        return decoded_beside(content(path, MOST_BESIDE, link=False), variables, numbers, text or {}, optional or {})
    except FileNotFoundError:
        return None
    except (OSError, NotReadableError, DamageError) as error:
        why = reason(error) if isinstance(error, OSError) else error
        raise StoreError(f"{named(path)}: {why}; to have it made again, remove it and run the study again") from None
