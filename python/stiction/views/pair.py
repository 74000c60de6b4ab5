"""`stiction.pair`: two bodies pressed together, with everything that is kept beside the result, as the command does."""

from __future__ import annotations

import atexit
import shutil
import tempfile
from collections.abc import Sequence
from concurrent.futures import Executor
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal
from warnings import warn

from stiction._checks import whole_number
from stiction._errors import ArgumentError
from stiction.studies.interfaces import Interface, write_interface
from stiction.studies.pair import ARGUMENTS, pair_study
from stiction.surfaces.joined_spectrum import JoinedSpectrum
from stiction.surfaces.profile import Profile
from stiction.surfaces.surface import Surface

if TYPE_CHECKING:
    from stiction.studies.result import Result

Body = str | Path | Profile | Surface | JoinedSpectrum | Sequence[Any] | Any
Quantity = str | float  # a text with a unit, such as "10 MPa", or a number in the library's units (µm, mN, GPa)

_NAMES = {"upper": "first", "lower": "second", "upper_material": "upper", "lower_material": "lower"}
"""Arguments of this function that `Pair` calls otherwise."""


def pair(
    first: Body | None = None,
    second: Body | None = None,
    *,
    gap: str | Path | Surface | None = None,
    load: Quantity | Sequence[Quantity],
    width: Quantity | None = None,
    mu0: float | Sequence[float] | None = None,
    tau0: Quantity | Sequence[Quantity] | None = None,
    interface: str | Path | Interface | None = None,
    upper: str | None = None,
    lower: str | None = None,
    effective_modulus: Quantity | None = None,
    young: Quantity | Sequence[Quantity] | None = None,
    poisson: float | Sequence[float] | None = None,
    hardness: Quantity | None = None,
    junction_growth: float | str | None = None,
    wait: Quantity | Sequence[Quantity] | None = None,
    creep: float | str | None = None,
    work_of_adhesion: Quantity | None = None,
    adhesion_range: Quantity | None = None,
    mechanics: Literal["half-space", "asperities"] | None = None,
    law: str | None = None,
    yield_strength: Quantity | None = None,
    cutoff: Quantity | Sequence[Quantity] | None = None,
    level: str | None = None,
    lay: Literal["grooves", "isotropic"] | None = None,
    shifts: int | None = None,
    rotate: float | None = None,
    tilt: Literal["fixed", "free"] | None = None,
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
    missing: Literal["error", "mask", "interpolate"] | None = None,
    outliers: Literal["keep", "mask"] | None = None,
    crop: str | Sequence[str] | None = None,
    channel: str | Sequence[str] | None = None,
    columns: str | Sequence[str] | None = None,
    missing_value: str | Sequence[str] | None = None,
    accept: str | Sequence[str] | None = None,
    tip: Quantity | Sequence[Quantity] | None = None,
    texture: str | Sequence[str] | None = None,
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
        surfaces are pressed, and another scan beside it is taken by its own spectrum. A list, or a folder, has scans of
        several places on one part: all pairs of them are pressed, and the interval is of the parts.
    gap : str, path or Surface
        In place of both: one map that is the gap of two faces, as of a fracture, pressed at this position alone.
    load : str or float, or several, mN
        Normal load over the nominal area, "10 MPa", or a force, "10 mN"; numbers are mN.
    width : str or float, µm
        Of two profiles, the width across them that forces are on, "5 mm"; by default the strip of 1 µm of the paper.
    mu0 : float, or several
        Molecular friction coefficient.
    tau0 : str or float, or several, GPa
        Adhesive shear strength, "50 MPa"; numbers are GPa. By default 0.
    interface : str, path or Interface
        In place of both, which it has jointly: a name of `interfaces`, a file that `write_interface` wrote, or what
        `calibrate` gave.
    upper, lower : str
        Materials by their names, see `materials`; one name is that of both.
    effective_modulus, young, hardness : str or float, GPa
    poisson : float, or two
        In place of materials, or beside them the hardness. One of effective_modulus, young with poisson, or materials
        is needed: nothing is assumed of a measured body.
    junction_growth : float or str
        α of p² + α s² = H² for pressure and shear in plastic contacts, a number or a range, "0..27": contacts that have
        yielded grow under shear. By default "0..27" of metals by name, and 0 of other bodies.
    wait : str or float, or several, s
        Times under load before the pair is sheared, "1 h"; the hardness is that after 1 s and falls as t**-creep.
    creep : float or str
        Exponent of indentation creep of the softer body, 0.03 or "0.02..0.05".
    work_of_adhesion : str or float, kJ/m²
        Energy that parts an area, "50 mJ/m^2", of the half-space; the load is then pressed from outside, and the result
        has the pull-off force and the friction at no load. Not given it is taken as 0, and doubted where it decides.
    adhesion_range : str or float, µm
        Gap over which the attraction falls off by 1/e; by default "0.5 nm", one to two distances of atoms.
    mechanics : {"half-space", "asperities"}
        By default the half-space of maps, and of two profiles whose materials have a hardness; else asperities.
    law, yield_strength, cutoff, level, lay, shifts, rotate, tilt, direction, lines, along, offsets, travel, \
    detection, curvature, surrogates, seed, missing, outliers, crop, channel, columns, missing_value, \
    accept, tip, texture
        As the options of `stiction pair`.
    unit, spacing : str, float (µm) or a sequence of two, optional
        As the options of `stiction pair`; of arrays the unit of heights (µm by default), and the distance of points.
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
        The same that `open_result` returns of the directory.

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
    from stiction.studies.complete import complete
    from stiction.studies.executors import given_or_threads

    given = locals()
    if onset is not None:
        whole_number("onset", onset, minimum=0)
    asked = {name: value for name in ARGUMENTS if (value := given.get(_NAMES.get(name, name))) is not None}
    for name in ("first", "second"):
        if any(step == "turned over" for step in getattr(given[name], "history", ())):
            warn(
                f"{name} was turned over, and pair turns the first body over itself: give both as they were scanned, "
                "heights out of the material",
                stacklevel=2,
            )
    folder = Path(tempfile.mkdtemp(prefix="stiction-") if directory is None else directory)
    if directory is None:  # it is gone when Python ends
        atexit.register(shutil.rmtree, folder, ignore_errors=True)
    if isinstance(interface, Interface):  # kept beside the result, which names it
        folder.mkdir(parents=True, exist_ok=True)
        write_interface(interface, folder / "interface.csv")
        asked["interface"] = folder / "interface.csv"
    try:
        study = pair_study(**asked)
        with given_or_threads(executor) as workers:
            return complete(study, folder, workers, replace=replace, onset=onset, progress=progress)
    except ValueError as error:
        said = error.with_names(lambda name: _NAMES.get(name, name)) if isinstance(error, ArgumentError) else str(error)
        raise ValueError("; ".join(said.splitlines())) from None
