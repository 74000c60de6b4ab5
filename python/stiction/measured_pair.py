"""`stiction.pair`, the Python equivalent of the command `stiction pair`: static friction of two measured bodies."""

from __future__ import annotations

import atexit
import shutil
import tempfile
from concurrent.futures import Executor
from pathlib import Path
from typing import TYPE_CHECKING

from stiction._checks import check_bool, parse_path
from stiction._errors import ArgumentError
from stiction._warnings import warn_caller
from stiction.mechanics.half_space import TiltMode
from stiction.mechanics.model import CurvatureRequirement, DetectionMethod
from stiction.pipeline import complete_result
from stiction.solve.executors import executor_or_thread_pool
from stiction.study.interfaces import InterfaceStrength, store_interface
from stiction.study.pair_options import (
    BodyScans,
    Degrees,
    GapInput,
    InterfaceInput,
    LawChoice,
    Lay,
    LevellingForm,
    Mechanics,
    PairOptions,
    Positions,
    PositiveInteger,
    QuantityInput,
    QuantityInputs,
    Seed,
    SurrogateChoice,
    convert_validation_errors,
    format_python_name,
)
from stiction.study.pair_study import build_study_from_options
from stiction.surfaces.measured.interpret import MissingPointTreatment, OutlierTreatment
from stiction.surfaces.measured.raw import FormatError
from stiction.surfaces.preparation import count_flips
from stiction.surfaces.profile import LineOrientation, Profile
from stiction.surfaces.surface import Surface

if TYPE_CHECKING:
    from stiction.result import Result


# The script packaging/pair_options.py generates the parameters of `pair`, their docs and the call of `PairOptions`.
def pair(
    first: BodyScans | None = None,
    second: BodyScans | None = None,
    *,
    load: QuantityInputs,
    width: QuantityInput | None = None,
    mu0: QuantityInputs | None = None,
    tau0: QuantityInputs | None = None,
    interface: InterfaceInput | None = None,
    direction: QuantityInputs | None = None,
    upper: str | None = None,
    lower: str | None = None,
    effective_modulus: QuantityInput | None = None,
    young: QuantityInputs | None = None,
    poisson: QuantityInputs | None = None,
    hardness: QuantityInput | None = None,
    yield_strength: QuantityInput | None = None,
    junction_growth: QuantityInput | None = None,
    yield_exponent: QuantityInput | None = None,
    indent: QuantityInput | None = None,
    area_loss: QuantityInput | None = None,
    wait: QuantityInputs | None = None,
    creep: QuantityInput | None = None,
    work_of_adhesion: QuantityInput | None = None,
    adhesion_range: QuantityInput | None = None,
    mechanics: Mechanics | None = None,
    tilt: TiltMode | None = None,
    law: LawChoice | None = None,
    detection: DetectionMethod | None = None,
    curvature: CurvatureRequirement | None = None,
    gap: GapInput | None = None,
    lay: Lay | None = None,
    lines: PositiveInteger | None = None,
    along: LineOrientation | None = None,
    level: LevellingForm | None = None,
    cutoff: QuantityInputs | None = None,
    rotate: Degrees | None = None,
    shifts: PositiveInteger | None = None,
    offsets: PositiveInteger | None = None,
    travel: QuantityInput | None = None,
    positions: Positions | None = None,
    surrogates: SurrogateChoice | None = None,
    seed: Seed | None = None,
    unit: QuantityInputs | None = None,
    spacing: QuantityInputs | None = None,
    missing: MissingPointTreatment | None = None,
    missing_value: QuantityInputs | None = None,
    outliers: OutlierTreatment | None = None,
    crop: QuantityInputs | None = None,
    channel: QuantityInputs | None = None,
    columns: QuantityInputs | None = None,
    accept: QuantityInputs | None = None,
    texture: QuantityInputs | None = None,
    tip: QuantityInputs | None = None,
    onset: Seed | None = None,
    directory: str | Path | None = None,
    replace: bool = False,
    executor: Executor | None = None,
    progress: bool = False,
) -> Result:
    """Compute the static friction, with its interval, of two measured profiles or surfaces at given loads.

    Parameters
    ----------
    first : str, path, Profile, Surface, JoinedSpectrum or array, or several
        The slider: a measured profile or surface. Several scans of one part are given as a list, a directory, or names
        separated by commas.
    second : str, path, Profile, Surface, JoinedSpectrum or array, or several
        The counterface; both may be the same file.
    load : str or float, or several, mN
        Normal load over the nominal area, "10 MPa", or a force, "0.1 mN".
    width : str or float, µm, optional
        Width across two profiles on which a force acts. By default 1 um.
    mu0 : str or float, or several, optional
        Molecular friction coefficients, "0.3,0.4", or one with its standard deviation, "0.30±0.02", or its 95 % range,
        "0.2..0.4".
    tau0 : str or float, or several, GPa, optional
        Adhesive shear strengths, "0 MPa,50 MPa", or one with its uncertainty, "30..80 MPa". By default 0 MPa.
    interface : str, path or Interface, optional
        Joint values of `mu0` and `tau0`: a file from stiction calibrate, or a name listed by stiction interfaces.
    direction : str or float, or several, optional
        Directions of motion of the upper body, from +x towards +y, "0,90". By default every 30 degrees.
    upper : str, optional
        Material of the slider by name, as in steel; or give `young` and `poisson`.
    lower : str, optional
        Material of the counterface; the same as `upper` by default.
    effective_modulus : str or float, GPa, optional
        Effective modulus E*, "10 GPa", instead of materials.
    young : str or float, or several, GPa, optional
        Young's modulus of both bodies, or of the slider and the counterface, "200 GPa,70 GPa".
    poisson : str or float, or several, optional
        Poisson's ratios, "0.3" or "0.3,0.33".
    hardness : str or float, GPa, optional
        Hardness of the softer body, the largest contact pressure: "2 GPa", "150 HV" or "150 HV ± 10 %". By default the
        material's hardness.
    yield_strength : str or float, GPa, optional
        Yield strength of the softer body, for `law` jackson-green. By default the hardness divided by 2.84.
    junction_growth : str or float, optional
        Growth of plastic contacts under shear: "slip-line", α of p² + α τ² = H² as in "9" or "0..27", or 0. By default
        slip-line, or 0 if the softer body is a named rock, glass, ceramic, semiconductor or coating.
    yield_exponent : str or float, optional
        Exponent of the area of yielding contacts, "1.25" or "uniform 0.7 .. 1.6". By default "uniform 0.7 .. 1.6".
    indent : str or float, µm, optional
        Depth of the indentation that measured the hardness of a metal, "5 um". Small contacts are harder.
    area_loss : str or float, optional
        Fraction of the true area that soft elastic bodies lose under shear, "0.1" or "0..0.3". By default "0..0.3" if
        E* is below 100 MPa.
    wait : str or float, or several, s, optional
        Dwell times under load before sliding, "1 min,1 h". The given hardness applies after 1 s.
    creep : str or float, optional
        Exponent m of indentation creep, "0.03" or "0.02..0.05": the hardness falls as (t/1 s)^-m.
    work_of_adhesion : str or float, kJ/m², optional
        Work of adhesion, "50 mJ/m^2"; "0 mJ/m^2" declares that there is none. By default taken as 0.
    adhesion_range : str or float, µm, optional
        Gap over which the attraction decays to 1/e. By default 0.5 nm.
    mechanics : {"half-space", "asperities"}, optional
        The elastic half-space (half-plane for lines), or isolated asperities (fast). By default asperities for lines,
        except two profiles whose softer body is a material with a hardness.
    tilt : {"fixed", "free"}, optional
        Orientation of the slider: fixed, or tilted until the load is centred, as on a ball joint. By default fixed.
    law : {"hertz-sphere", "hertz-cylinder", "jackson-green"}, optional
        Contact law of asperities. By default hertz-sphere.
    detection : {"cell", "gap-minimum"}, optional
        Criterion that detects contacts of asperities. By default gap-minimum.
    curvature : {"convex", "signed"}, optional
        Contact points to count: convex only, or concave ones too. By default convex for lines, signed for areas.
    gap : str, path, Surface or array, optional
        A map of the gap between two faces, for example of a fracture, instead of `first` and `second`.
    lay : {"grooves", "isotropic"}, optional
        Lay of two profiles: measured across grooves, or on isotropic surfaces, which are then pressed as areas. By
        default pressed as lines.
    lines : int, optional
        Press this many pairs of lines of two maps instead of their areas; for surrogates of profiles, the number of
        surrogates. By default 128 of surrogates, and of a map and a profile.
    along : {"x", "y"}, optional
        Direction of the lines of maps. By default x.
    level : {"mean", "line", "plane", "quadratic", "none"}, optional
        Trend to subtract from each line (mean, line, quadratic or none) or map (mean, plane or quadratic). By default
        line for profiles, plane for maps.
    cutoff : str or float, or several, µm, optional
        Cutoff wavelength of a Gaussian low-pass filter, "0.1 um". Several cutoffs give several results; "none"
        attributes all wavelengths to the surfaces. By default unfiltered; also filtered if some wavelengths may not
        belong to the surface.
    rotate : float, optional
        Rotate the upper map in its plane. By default 0.
    shifts : int, optional
        Relative positions of two maps. By default 16.
    offsets : int, optional
        Positions along the lower profile. By default 64, or 1 for several lines.
    travel : str or float, µm, optional
        The largest offset. By default half the length.
    positions : str or float, or several, µm, optional
        Positions of the slider on the counterface, "0 um,5 um"; for maps, x and y of each position. By default spread
        evenly.
    surrogates : int or str, optional
        For areas: number of additional pairs of random surfaces with equal spectra. For lines: body to replace by
        random surfaces. By default none.
    seed : int, optional
        Seed of the random phases of surrogates. By default 2016.
    unit : str or float, or several, optional
        Unit of the lengths in the file, "um", or of positions and heights, "mm,um". Required if the file has no unit.
    spacing : str or float, or several, µm, optional
        Distance between points, "0.5 um", or between rows and columns, "2 um,0.5 um". Required if the file has no
        spacing.
    missing : {"error", "interpolate", "mask"}, optional
        Points without a height: reject the file, press only the measured points, or interpolate. By default error.
    missing_value : str or float, or several, optional
        Numbers or words that mark points without a height, "-9999".
    outliers : {"keep", "mask"}, optional
        Treat up to 4 adjacent points beyond 6 robust deviations of their neighbours as missing. By default keep.
    crop : str or float, or several, µm, optional
        Region of the file to read: "10 um,60 um"; for a map, first along x, then along y.
    channel : str or float, or several, optional
        Channel or sheet to read, by its name or number from 0. By default the first of heights.
    columns : str or float, or several, optional
        Columns of a table, names or numbers from 0: of heights, or of positions and heights.
    accept : str or float, or several, optional
        Names of caveats about a file that you have checked and accept, "whole-numbers".
    texture : str or float, or several, optional
        Machining process (turned, milled, ground, ...): lines and humps of the spectrum are then attributed to the
        surface.
    tip : str or float, or several, µm, optional
        Radius of the stylus or probe, "10 nm", which limits the curvature that it can follow.
    onset : int, optional
        Number of positions whose onset of sliding is computed; 0 for none. By default 16, or 4 for height maps with the
        half-space model.
    directory : path, optional
        Directory of the result, like ``--output``; by default a temporary one, removed when Python exits.
    replace : bool
        True to replace a different result in the directory.
    executor : concurrent.futures.Executor, optional
        Executor that computes the members; by default one thread per core.
    progress : bool
        True to draw a progress bar on the terminal, or to print a line every minute if there is no terminal.

    Returns
    -------
    Result
        Result, equal to the one that `open_result` returns for the directory.

    Raises
    ------
    FormatError
        If a file cannot be read; it is a `ValueError`.
    ValueError
        If a quantity has a wrong unit, or an argument does not apply.

    Examples
    --------
    >>> from stiction import pair, self_affine_surface
    >>> a, b = (
    ...     self_affine_surface(3, hurst_exponent=0.8, rms=0.02, shape=(48, 48), spacing=0.1, side=side)
    ...     for side in ("upper", "lower")
    ... )
    >>> result = pair(a, b, load="10 MPa", upper="steel", lower="brass", mu0=0.2, mechanics="asperities", shifts=4)
    >>> result.assessment in ("Quote it", "Quote with care", "Do not quote")
    True
    """
    for name, body in (("first", first), ("second", second)):
        if isinstance(body, (Profile, Surface)) and count_flips(body):
            warn_caller(
                f"{name} is flipped, but pair flips the first body itself: give both bodies as they were scanned, "
                "with heights that point out of the material"
            )
    for name, value in (("replace", replace), ("progress", progress)):
        check_bool(name, value)
    result_directory = (
        Path(tempfile.mkdtemp(prefix="stiction-")) if directory is None else parse_path("directory", directory)
    )
    if directory is None:
        atexit.register(shutil.rmtree, result_directory, ignore_errors=True)
    try:
        with convert_validation_errors():
            options = PairOptions(
                load=load,
                width=width,
                mu0=mu0,
                tau0=tau0,
                interface=interface,
                direction=direction,
                upper_material=upper,
                lower_material=lower,
                effective_modulus=effective_modulus,
                young=young,
                poisson=poisson,
                hardness=hardness,
                yield_strength=yield_strength,
                junction_growth=junction_growth,
                yield_exponent=yield_exponent,
                indent=indent,
                area_loss=area_loss,
                wait=wait,
                creep=creep,
                work_of_adhesion=work_of_adhesion,
                adhesion_range=adhesion_range,
                mechanics=mechanics,
                tilt=tilt,
                law=law,
                detection=detection,
                curvature=curvature,
                upper=first,
                lower=second,
                gap=gap,
                lay=lay,
                lines=lines,
                along=along,
                level=level,
                cutoff=cutoff,
                rotate=rotate,
                shifts=shifts,
                offsets=offsets,
                travel=travel,
                positions=positions,
                surrogates=surrogates,
                seed=seed,
                unit=unit,
                spacing=spacing,
                missing=missing,
                missing_value=missing_value,
                outliers=outliers,
                crop=crop,
                channel=channel,
                columns=columns,
                accept=accept,
                texture=texture,
                tip=tip,
                onset=onset,
            )
        # The interface is stored in a file, because the study file refers to it by a file name.
        if isinstance(interface, InterfaceStrength):
            options = options.model_copy(update={"interface": store_interface(interface, result_directory)})
        study = build_study_from_options(options)
        with executor_or_thread_pool(executor) as workers:
            return complete_result(
                study, result_directory, workers, replace=replace, onset=options.onset, progress=progress
            )
    except ArgumentError as error:
        raise ValueError(error.translated_message(format_python_name)) from None
    except ValueError as error:
        error_class = FormatError if isinstance(error, FormatError) else ValueError
        raise error_class("; ".join(str(error).splitlines())) from None
