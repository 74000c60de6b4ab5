"""`stiction.pair`: the command of that name as a function, for notebooks and scripts."""

from __future__ import annotations

import atexit
import hashlib
import inspect
import re
import shutil
import tempfile
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal
from warnings import warn

import numpy as np

from stiction._checks import number, whole_number
from stiction._units import exactly
from stiction.surfaces.foreign import taken_from
from stiction.surfaces.joined import JoinedSpectrum
from stiction.surfaces.measured.spectrum_file import write_spectrum
from stiction.surfaces.measured.writing import write_profile, write_surface
from stiction.surfaces.profile import Profile
from stiction.surfaces.surface import Surface, lengths

if TYPE_CHECKING:
    from stiction.studies.study import Study
    from stiction.views.result import Result

Body = str | Path | Profile | Surface | JoinedSpectrum | Any

Quantity = str | float
"""A text with a unit, such as "10 MPa", or a number in the library's units (µm, mN, GPa)."""


def pair(
    first: Body,
    second: Body,
    *,
    load: Quantity | Sequence[Quantity],
    mu0: float | Sequence[float],
    tau0: Quantity | Sequence[Quantity] = 0.0,
    upper: str | None = None,
    lower: str | None = None,
    effective_modulus: Quantity | None = None,
    young: Quantity | Sequence[Quantity] | None = None,
    poisson: float | Sequence[float] | None = None,
    hardness: Quantity | None = None,
    mechanics: Literal["half-space", "asperities"] | None = None,
    law: str | None = None,
    yield_strength: Quantity | None = None,
    cutoff: Quantity | Sequence[Quantity] | None = None,
    level: str | None = None,
    lay: Literal["grooves", "isotropic"] | None = None,
    shifts: int | None = None,
    rotate: float | None = None,
    direction: Sequence[float] | None = None,
    lines: int | None = None,
    along: Literal["x", "y"] | None = None,
    offsets: int | None = None,
    travel: Quantity | None = None,
    detection: str | None = None,
    curvature: str | None = None,
    surrogates: int | str | None = None,
    seed: int | None = None,
    unit: str | Sequence[str] | None = None,
    spacing: Quantity | Sequence[Quantity] | None = None,
    missing: Literal["error", "interpolate"] | None = None,
    channel: str | Sequence[str] | None = None,
    columns: str | Sequence[str] | None = None,
    directory: str | Path | None = None,
    replace: bool = False,
    onset: int | None = None,
    executor: Executor | None = None,
    progress: bool = False,
) -> Result:
    """Static friction of two measured profiles or surfaces at given loads, with intervals: the command as a function.

    Parameters
    ----------
    first, second : str, path, Profile, Surface or JoinedSpectrum
        The slider and what it is carried over, as files or as bodies; heights of both point out of the material, as
        they were scanned. Bodies of other libraries are taken as `Surface.from_` takes them. Of a spectrum random
        surfaces are pressed, and another scan beside it is taken by its own spectrum.
    load : str or float, or several, mN
        Normal load, "10 mN" or per nominal area "10 MPa"; numbers are mN.
    mu0 : float, or several
        Molecular friction coefficient.
    tau0 : str or float, or several, GPa
        Adhesive shear strength, "50 MPa"; numbers are GPa.
    upper, lower : str
        Materials by their names, see `materials`; one name is that of both.
    effective_modulus, young, hardness : str or float, GPa
    poisson : float, or two
        In place of materials, or beside them the hardness. One of effective_modulus, young with poisson, or materials
        is needed: nothing is assumed of a measured body.
    mechanics : {"half-space", "asperities"}
        By default the half-space of maps and asperities of lines.
    law, yield_strength, cutoff, level, lay, shifts, rotate, direction, lines, along, offsets, travel, detection, \
    curvature, surrogates, seed, unit, spacing, missing, channel, columns
        As the options of `stiction pair`.
    directory : path, optional
        Where the result is kept, as by ``--output``; by default as long as Python runs.
    replace : bool
        Whether another result in that directory is replaced.
    onset : int, optional
        Members whose onset of sliding is computed besides, as by ``--onset``; 0 for none.
    executor : concurrent.futures.Executor, optional
        Where members are computed; a thread for each core by default.
    progress : bool
        Whether to draw a progress bar on the terminal.

    Returns
    -------
    Result
        The same that `read_result` returns of the directory.

    Raises
    ------
    ValueError
        If a file cannot be read, a quantity has a wrong unit, or an argument does not apply.

    Examples
    --------
    >>> from stiction import pair, self_affine_surface
    >>> a, b = (
    ...     self_affine_surface(3, hurst_exponent=0.8, rms=0.02, shape=(48, 48), spacing=0.1, side=side)
    ...     for side in ("upper", "lower")
    ... )
    >>> result = pair(a, b, load="10 MPa", upper="steel", lower="brass", mu0=0.2, mechanics="asperities", shifts=4)
    >>> result.verdict in ("Quote it", "Quote with care", "Do not quote")
    True
    """
    from stiction.cli.pair_study import Asked
    from stiction.studies.executors import given_or_threads
    from stiction.studies.members import about
    from stiction.views.result import read_result

    asked_for = {name: value for name, value in locals().items() if name in _TEXTS and value is not None}
    folder = _temporary() if directory is None else Path(directory)
    with _names_of_arguments():
        options = {name: _TEXTS[name](name, value) for name, value in asked_for.items()}
        options |= {f"{side}_material": name for side, name in (("upper", upper), ("lower", lower)) if name is not None}
        bodies = list(map(_checked, ("first", "second"), (first, second)))
        _refuse_of_bodies(options, bodies)
        files = [_file(body, folder, side) for side, body in zip(("upper", "lower"), bodies, strict=True)]
        asked = Asked.asking(options | dict(zip(("upper", "lower"), files, strict=True)), defaults())
        study = asked.studies()[0]
        about(study)  # refuses what cannot be pressed, before anything is computed
        with given_or_threads(executor) as workers:
            _fill(study, folder, workers, replace=replace, onset=onset, progress=progress)
    return read_result(folder)


def _fill(study: Study, folder: Path, workers: Executor, *, replace: bool, onset: int | None, progress: bool) -> None:
    """Compute what the folder lacks, as the command does, without a word."""
    import typer

    from stiction.cli.running import fill_folder

    try:
        fill_folder(study, folder, workers, said=lambda _: None, replace=replace, onset=onset, progress=progress)
    except typer.Exit:  # what the command does when it is interrupted
        raise KeyboardInterrupt from None


# ---- Arguments as the texts of options -------------------------------------------------------------------------------


def _one(unit: str, name: str, value: Any) -> str:
    """A quantity as text; a number is in this unit, or has none."""
    return value if isinstance(value, str) else exactly(number(name, value), unit).strip()


def _list(unit: str, name: str, value: Any) -> list[str]:
    """One or several of them."""
    several = value if isinstance(value, (list, tuple, range, np.ndarray)) and np.ndim(value) == 1 else [value]
    if not len(several):
        raise ValueError(f"{name} must have at least one value, got {value!r}")
    return [_one(unit, name, each) for each in several]


def _joined(unit: str, name: str, value: Any) -> str:
    return ",".join(_list(unit, name, value))


def _of_each(name: str, value: Any) -> list[str]:
    """What describes both files, or one after the other; a pair of parts is for one."""
    several = value if isinstance(value, (list, tuple)) else [value]
    return [str(each) for each in several]


def _as_it_is(_: str, value: Any) -> Any:
    return value


_TEXTS: dict[str, Callable[[str, Any], Any]] = {
    **{name: partial(_list, unit) for name, unit in (("load", "mN"), ("spacing", "um"))},
    **{
        name: partial(_joined, unit)
        for name, unit in (
            ("mu0", ""), ("tau0", "GPa"), ("young", "GPa"), ("poisson", ""), ("cutoff", "um"), ("direction", ""),
        )
    },
    **{
        name: partial(_one, unit)
        for name, unit in (
            ("effective_modulus", "GPa"), ("hardness", "GPa"), ("yield_strength", "GPa"), ("travel", "um"),
        )
    },
    **dict.fromkeys(("unit", "channel", "columns"), _of_each),
    **dict.fromkeys(
        ("mechanics", "law", "level", "lay", "along", "detection", "curvature", "missing", "rotate"), _as_it_is
    ),
    **dict.fromkeys(("shifts", "lines", "offsets"), partial(whole_number, least=1)),
    "seed": partial(whole_number, least=0),
    "surrogates": lambda _, value: str(value),
}  # fmt: skip
"""What the command takes of each argument."""


def defaults() -> dict[str, Any]:
    """What the command has where an option is not given: its own signature, so that there is one table."""
    from stiction.cli.pair import pair as of_command

    parameters = inspect.signature(of_command).parameters.values()
    return {each.name: None if each.default is each.empty else each.default for each in parameters}


# ---- Bodies ----------------------------------------------------------------------------------------------------------


def _checked(name: str, body: Any) -> Path | Profile | Surface | JoinedSpectrum:
    """A file, or a body as it was scanned; those of other libraries as ours."""
    if isinstance(body, (str, Path)):
        return Path(body)
    if isinstance(body, JoinedSpectrum):
        return body
    heights, spacing, history = taken_from(name, body)
    found: Profile | Surface
    if heights.ndim == 1:
        found = Profile(heights, spacing=spacing[0], history=history)
    else:
        found = Surface(heights, spacing=lengths("spacing", spacing), history=history)
    if "turned over" in found.history:
        warn(
            f"{name} was turned over, and pair turns the first body over itself: give both as they were scanned, "
            "heights out of the material",
            stacklevel=3,
        )
    return found


def _file(body: Path | Profile | Surface | JoinedSpectrum, folder: Path, side: str) -> Path:
    """The file that holds a body, of one in memory a new one in the folder, under a checksum of its own."""
    if isinstance(body, Path):
        return body
    if isinstance(body, JoinedSpectrum):
        content, ending = repr(body.history).encode() + body.density.tobytes(), "csv"
    else:
        content, ending = repr((body.spacing, body.history)).encode() + body.heights.tobytes(), "npy"
    path = folder / "bodies" / hashlib.sha256(content).hexdigest()[:12] / f"{side}.{ending}"
    if not path.exists():
        path.parent.mkdir(parents=True, exist_ok=True)
        if isinstance(body, JoinedSpectrum):
            write_spectrum(body, path)
        elif isinstance(body, Surface):
            write_surface(body, path)
        else:
            write_profile(body, path)
    return path


def _refuse_of_bodies(options: dict[str, Any], bodies: list[Any]) -> None:
    """How files are read cannot be said of bodies in memory."""
    if all(isinstance(body, Path) for body in bodies):
        return
    for name in ("unit", "spacing", "channel", "columns", "missing"):
        if name in options:
            raise ValueError(f"{name} is for files: read them first where only one of both is one, got {name}")


@contextmanager
def _names_of_arguments() -> Iterator[None]:
    """Errors call an option by the name of its argument."""
    try:
        yield
    except ValueError as error:
        named = str(error).replace("--upper-material", "--upper").replace("--lower-material", "--lower")
        said = re.sub(r"--([a-z][a-z0-9-]*)", lambda match: match[1].replace("-", "_"), named)
        raise ValueError("; ".join(said.splitlines())) from None


def _temporary() -> Path:
    """A folder that is gone when Python ends."""
    folder = Path(tempfile.mkdtemp(prefix="stiction-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return folder
