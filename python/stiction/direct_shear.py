"""`stiction.shear_test`: direct shear test of two faces that fit, such as the walls of a rock joint."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable
from dataclasses import dataclass, fields
from dataclasses import replace as replace_fields
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

import stiction.evaluate.shear_intervals as shear_intervals
from stiction._arguments import parse_quantity
from stiction._checks import check_bool, check_choice, parse_path, validate_number, validate_whole_number
from stiction._errors import ArgumentError
from stiction._files import describe_os_error
from stiction._text import printable_path
from stiction._units import loads_to_core_units, quantity, short_repr
from stiction._warnings import warn_caller
from stiction.evaluate.shear_intervals import (
    ContactVariation,
    ShearInputSamples,
    add_shear_intervals,
    draw_shear_samples,
    list_variations,
)
from stiction.mechanics.friction import CENTRAL_SHEAR_RATIO, FrictionLaw, warn_if_tau0_is_large
from stiction.mechanics.half_space import BoundaryCondition, TiltMode
from stiction.mechanics.joint_closure import fit_bandis_law
from stiction.mechanics.onset import parse_direction
from stiction.mechanics.shear import MIN_STRIPS, ShearBox, check_gap, shear_gap
from stiction.mechanics.solution_record import SolutionRecord, StepResult
from stiction.solve.members_in_progress import (
    compute_steps_key,
    find_steps_with_other_keys,
    remove_stored_steps,
    stored_record,
)
from stiction.solve.store import SHEAR_TEST_FILE_NAME, STUDY_FILE, export, load_shear_test
from stiction.study.inputs import Inputs
from stiction.study.interfaces import InterfaceStrength
from stiction.study.pair_options import validate_option_values
from stiction.study.pair_study import MeasuredPair
from stiction.summary.interface_caveats import find_interface_caveats
from stiction.summary.joint_table import DEFAULT_JOINT_UNITS, UnitSystem
from stiction.surfaces.joint_roughness import measure_joint_roughness
from stiction.surfaces.measured.writing import write_profile, write_surface
from stiction.surfaces.preparation import count_flips, flipped, levelled, on_common_grid
from stiction.surfaces.profile import Profile
from stiction.surfaces.registration import Registration, correlate_facing_slopes, register_faces
from stiction.surfaces.surface import BodyLike, as_bodies
from stiction.views.files import check_file_extension, write_new_text_file, write_shear_parameters
from stiction.views.shear import shear_csv

if TYPE_CHECKING:
    import xarray as xr

ShearLevel = Literal["mean", "line", "plane", "none"]

_STEP_MODULES = (Path(__file__), Path(shear_intervals.__file__))
"""Modules that decide, besides the solver, which steps a shear test consists of."""


def shear_test(
    upper: BodyLike,
    lower: BodyLike,
    *,
    load: float | str,
    mu0: float | str | None = None,
    tau0: float | str | None = None,
    interface: str | Path | InterfaceStrength | None = None,
    path: float | str,
    steps: int = 40,
    direction: float | Literal["+x", "-x"] = 0.0,
    normal_stiffness: float | str | None = None,
    upper_material: str | None = None,
    lower_material: str | None = None,
    young: Any = None,
    poisson: Any = None,
    effective_modulus: float | str | None = None,
    hardness: float | str | None = None,
    boundary: BoundaryCondition = "free",
    tilt: TiltMode = "fixed",
    level: ShearLevel | None = None,
    register: bool = False,
    strips: int | None = None,
    spacing: Any = None,
    unit: str = "um",
    tolerance: float = 1e-6,
    directory: str | Path | None = None,
    replace: bool = False,
    progress: Callable[[int, int], object] | None = None,
) -> xr.Dataset:
    r"""Compute a direct shear test of two faces that fit: shear stress and dilation against displacement.

    Parameters
    ----------
    upper, lower : Profile, Surface or array_like
        Faces as they were scanned, with heights that point out of the material. The upper face is flipped as `pair`
        flips it, and both faces start at the same corner.
    load : float, mN, or str
        Normal load, "1 MPa" on the overlap at the start of the path, or a force. With `normal_stiffness`, the load at
        the start.
    mu0 : float or str, optional
        Molecular friction coefficient. A range, "0.5..0.7", gives intervals, also for the inputs below.
    tau0 : float or str, GPa, optional
        Adhesive shear strength, "1 MPa" or a range. By default 0.
    interface : str, path or Interface, optional
        Joint values of mu0 and tau0, as for `pair`.
    path : float, µm, or str
        Displacement of the upper face at the end of the test, "2 mm".
    steps : int
        Number of displacements, which are rounded to grid points: at most one per grid point along the path.
    direction : float, degrees, "+x" or "-x"
        Direction of the motion of the upper face, from +x towards +y; on profiles along x.
    normal_stiffness : float, GPa/µm, or str, optional
        Increase of the normal stress per dilation, "5 MPa/mm", on the overlap at the start. By default the load is
        constant.
    upper_material, lower_material : str, optional
        Materials by name, as `upper` and `lower` of `pair`.
    young, poisson, effective_modulus
        Elastic constants of one or both bodies, or E*, as for `pair`.
    hardness : float, GPa, or str, optional
        Largest contact pressure, the strength of the asperities that interlock: "150 MPa" or "120 HV ± 10 %". By
        default that of the softer material, and without materials none.
    boundary : {"free", "periodic"}
        "free": the overlap decreases along the path. "periodic": the faces continue beyond their edges.
    tilt : {"fixed", "free"}
        "free": the upper face rotates until the load is centred on the overlap. Requires a free boundary.
    level : {"mean", "line", "plane", "none"}, optional
        Trend to subtract from each face. By default a line from profiles and a plane from maps, and the mean if
        periodic.
    register : bool
        True to start where the faces fit best: the upper face is shifted, rotated by up to 3 degrees (maps) and tilted
        until the gap is smallest, also between grid points. The attributes of the result contain the position.
    strips : int, optional
        Number of strips along the motion that are also sheared one by one. The scatter between strips widens the
        intervals. By default 4 to 8 strips of maps with at least 128 points across the motion; 0 for none.
    spacing, unit
        Distance of the points and unit of the heights, for arrays.
    tolerance : float
        As for `half_space`.
    directory : path, optional
        Directory of the result. The same call resumes an interrupted test, and opens a finished one.
    replace : bool
        True to replace another test in the directory.
    progress : callable, optional
        Called with the number of solved steps and their total number. Uncertain inputs and strips need further steps.

    Returns
    -------
    test : xarray.Dataset
        Over `displacement` (µm): `friction_coefficient` (tangential over normal load, against the motion),
        `shear_stress` (GPa, on the overlap at this displacement), `dilation` (µm, 0 at the start),
        `contact_area_fraction` (projected), `normal_load` (mN), `overlap_area` (µm²), `contact_count`,
        `load_fraction_at_hardness`, `load_fraction_at_edges` (of the faces), `elastic_energy` (nJ), the six contact
        sums, and `status`. A coefficient below 0 is NaN with the status "downhill": the face slides by itself.

        Over `y` and `x` (µm): `peak_pressure` (GPa), the contacts at the peak. Over `gap_y` and `gap_x` (µm): `gap`
        (µm), the gap between the faces at the start of the path, see `shear_gap`.

        Over `normal_stress` (GPa), up to that of the load: `closure` (µm) at the start of the path, and its derivative
        `closure_stiffness` (MPa/mm).

        With ranges or strips that change them, over `end` ("lower", "upper"): `friction_coefficient_interval`,
        `shear_stress_interval`, `dilation_interval`, `closure_interval` and `closure_stiffness_interval`, 95 %.

        Attributes: `peak`, `peak_displacement_um`, `peak_dilation_angle_deg`, `peak_shear_stress_GPa`, `end` (value at
        the end of the path), with limits such as `peak_lower` and `peak_upper`, and `peak_status`, which is not "ok" if
        the faces lock. `strips` is the number of strips. The roughness of the lower face along the motion: `z2` and
        `jrc` (NaN outside its range), `rising_slope` and `falling_slope`. The closure at the start, by Bandis' law:
        `closure_initial_stiffness_GPa_per_um`, `maximum_closure_um` and `closure_misfit`, the largest relative
        deviation; NaN if the faces do not close. `fit_correlation` is the correlation of the slopes of both faces at
        the start; NaN if a face is flat. `body_shears_first` is 1 if asperities at the hardness would, by slip lines,
        shear before they slide; the coefficients do not include this limit.

    Raises
    ------
    ValueError
        If an argument is outside its range, or the path leaves too small an overlap.

    See Also
    --------
    pair : Mean friction over relative positions of two faces that do not fit.

    Notes
    -----
    Each displacement is a half-space contact with friction at all contacts. The asperities deform elastically, and
    yield at the hardness. Breakage, gouge and wear are not included: each step starts from the scanned faces. On a
    sawtooth of angle i the coefficient is :math:`\tan(\phi + i)` with :math:`\tan \phi = μ_0`; without friction, the
    work of the tangential load is the work of dilation plus the elastic energy. The dilation is the change of the mean
    gap, without the bending of the bodies. The dilation angle at the peak is the arctangent of dilation over
    displacement between the displacements before and after the peak.

    For ranges of mu0 and tau0, the forces of the solved contacts are evaluated again. For ranges of the hardness and of
    E*, the test is repeated at both limits, and curves are interpolated. If the contact has no solution at a limit, the
    friction has the upper limit infinity (and, unless the faces lock, the lower limit 0), and dilation and closure have
    no interval there. Each strip is sheared under the same normal stress, free of the other strips; the standard error
    of the mean over the strips, with Student's t distribution, stands for another piece of the same joint. It does not
    include wavelengths longer than the width of a strip. An interval of the displacement at the peak includes the
    displacements before and after the peak. A curve, and the dilation angle at the peak, have no interval if no input
    or strip changes them. A value equals one of its limits if both limits of an input change it in the same direction.

    Examples
    --------
    >>> from stiction import Surface, self_affine_surface, shear_test
    >>> lower = self_affine_surface(1, hurst_exponent=0.8, rms=20.0, shape=(64, 64), spacing=50.0)
    >>> upper = Surface(-lower.heights[::-1], spacing=lower.spacing)
    >>> test = shear_test(
    ...     upper, lower, path="0.5 mm", load="1 MPa", mu0=0.6, young="30 GPa", poisson=0.25, hardness="150 MPa"
    ... )
    >>> float(test.friction_coefficient[0].round(2))  # before the faces ride up
    0.59
    >>> round(test.attrs["peak"], 2)
    0.78
    """
    upper, lower = as_bodies(upper, lower, spacing=spacing, unit=unit)
    options = {
        "mu0": mu0, "tau0": tau0, "interface": interface, "upper_material": upper_material,
        "lower_material": lower_material, "young": young, "poisson": poisson, "effective_modulus": effective_modulus,
        "hardness": hardness,
    }  # fmt: skip
    given_options = {name: value for name, value in options.items() if value is not None}
    contact = MeasuredPair(
        validate_option_values({"upper": upper, "lower": lower, "load": load, **given_options}), reads_scans=False
    )
    box, registration = _build_shear_box(
        upper, lower, contact, load=load, direction=direction, normal_stiffness=normal_stiffness, boundary=boundary,
        tilt=tilt, level=level, register=register, tolerance=tolerance,
    )  # fmt: skip
    length = validate_number("path", path, unit="µm", above=0)
    check_bool("replace", replace)
    offsets = box.choose_offsets(length, validate_whole_number("steps", steps, minimum=1))
    attributes = {} if registration is None else _describe_registration(registration)
    setup = _build_shear_test_setup(box, contact, offsets, strips)
    if directory is None:
        return _compute_shear_tests(setup, SolutionRecord(), progress).assign_attrs(attributes)
    test_directory, description = parse_path("directory", directory), _describe_inputs(setup)
    key = hashlib.sha256(description.encode()).hexdigest()[:16]
    # The key of stored steps depends on `variations`, because repeated tests take their input limits from the samples.
    steps_key = compute_steps_key(description + repr(setup.variations), _STEP_MODULES)
    if (test := _open_stored_test(test_directory, key, replace=replace)) is not None:
        return test
    _create_directory(test_directory)
    _warn_about_other_steps(test_directory, steps_key)
    record = stored_record(test_directory, 0, steps_key)
    test = _compute_shear_tests(setup, record, progress).assign_attrs(attributes, key=key)
    export(test, test_directory / SHEAR_TEST_FILE_NAME, replace=True)
    remove_stored_steps(test_directory, key=steps_key)
    return test


_TEST_FORMATS = {".nc": "the whole test", ".csv": "the curve"}
_GAP_FORMATS = {".npy": "a NumPy array", ".csv": "a matrix"}


def export_shear_test(
    test: xr.Dataset, path: str | Path, *, joint: bool = False, gap: bool = False, units: UnitSystem | None = None
) -> None:
    """Write a shear test to a new file: all its data to a `.nc` file, or only its curve to a `.csv` file.

    Parameters
    ----------
    test : xarray.Dataset
        Result of `shear_test`.
    path : path
    joint : bool
        True to write the parameters of a joint model to a ``.csv`` or ``.json`` file: peak and dilation, and the
        closure and its stiffness against the normal stress.
    gap : bool
        True to write the gap of `shear_gap` to a ``.npy`` or ``.csv`` file, with its unit and spacing.
    units : {"mm,N,MPa", "m,N,Pa", "um,mN,GPa"}, optional
        Units of the parameters; by default the first.

    Raises
    ------
    ValueError
        If the file exists or cannot be written, its name has another ending, or an earlier version stored the test
        without closure and gap.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> from stiction import Surface, export_shear_test, read_surface, self_affine_surface, shear_test
    >>> lower, noise = (
    ...     self_affine_surface(seed, hurst_exponent=0.8, rms=rms, shape=(64, 64), spacing=50.0)
    ...     for seed, rms in ((1, 20.0), (2, 1.0))
    ... )
    >>> upper = Surface(-(lower.heights + noise.heights)[::-1], spacing=lower.spacing)
    >>> test = shear_test(upper, lower, path="0.1 mm", load="1 MPa", mu0=0.6, effective_modulus="16 GPa")
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "gap.npy"
    >>> export_shear_test(test, file, gap=True)
    >>> read_surface(file).spacing
    (50.0, 50.0)
    """
    path = parse_path("path", path)
    check_bool("joint", joint)
    check_bool("gap", gap)
    if joint and gap:
        raise ValueError("gap must be False if joint is True, got True")
    if units is not None and not joint:
        raise ArgumentError("{units} applies only if joint is True, got {value}", value=units)
    if joint:
        check_gap(test)
        write_shear_parameters(test, path, DEFAULT_JOINT_UNITS if units is None else units)
    elif gap:
        check_file_extension(path, _GAP_FORMATS)
        body = shear_gap(test)
        if isinstance(body, Profile):
            write_profile(body, path)
        else:
            write_surface(body, path)
    else:
        check_file_extension(path, _TEST_FORMATS)
        if path.suffix.lower() == ".nc":
            export(test, path)
        else:
            write_new_text_file(path, shear_csv(test))


def _create_directory(directory: Path) -> None:
    """Create the directory of a shear test, or raise a `ValueError` if it contains a study or cannot be created."""
    try:
        directory.mkdir(parents=True, exist_ok=True)
        has_study = (directory / STUDY_FILE).exists()
    except OSError as error:
        raise ValueError(f"{printable_path(directory)}: {describe_os_error(error)}") from None
    if has_study:
        raise ValueError(f"{printable_path(directory)} contains the result of a study; choose another directory")


def _warn_about_other_steps(directory: Path, key: str) -> None:
    """Warn about stored steps of an interrupted shear test that belong to other inputs, versions or machines."""
    names = [printable_path(path) for path in find_steps_with_other_keys(directory, 0, key)]
    if names:
        warn_caller(
            f"{', '.join(names)}: steps of a shear test that was interrupted with other inputs, by another version or "
            "on another machine; this test does not resume from these steps. Remove the directory, unless you will "
            "run the interrupted test again"
        )


@dataclass(frozen=True, eq=False)
class _ShearTestSetup:
    """Simulated shear test at the central inputs, and the simulations at other inputs that its intervals require."""

    box: ShearBox
    offsets: NDArray[np.int64]
    inputs: Inputs
    strength: InterfaceStrength | None
    interface_name: str
    samples: list[ShearInputSamples]
    variations: list[ContactVariation]
    strips: list[ShearBox]

    @cached_property
    def interface_attributes(self) -> dict[str, str]:
        """Dataset attributes that state the sliding rule and the caveats of a calibrated interface."""
        if self.strength is None:
            return {}
        caveats = find_interface_caveats(self.strength, self.interface_name, self.inputs)
        lines = [f"{caveat.text}; {caveat.remedy}" for caveat in caveats]
        rule = {"interface_rule": self.strength.fits[0].sliding}
        return rule | ({"interface_caveats": "\n".join(lines)} if lines else {})


def _build_shear_test_setup(
    box: ShearBox, contact: MeasuredPair, offsets: NDArray[np.int64], strips: Any
) -> _ShearTestSetup:
    inputs, strength = contact.half_space_inputs, contact.given_interface
    samples = draw_shear_samples(inputs, strength, len(offsets))
    strip_boxes = _cut_strips(box, offsets, strips)
    interface = contact.options.interface
    name = "" if interface is None else Path(interface).name if isinstance(interface, (str, Path)) else "joint samples"
    return _ShearTestSetup(box, offsets, inputs, strength, name, samples, list_variations(samples), strip_boxes)


def _cut_strips(box: ShearBox, offsets: NDArray[np.int64], strips: Any) -> list[ShearBox]:
    """Cut the faces of a shear test into strips, and return one test per strip. Reject an impossible strip count."""
    if strips is None:
        boxes = box.cut_strips(offsets)
        return boxes if len(boxes) >= MIN_STRIPS else []
    count = validate_whole_number("strips", strips, minimum=0)
    if count == 0:
        return []
    max_count = box.find_max_strips(offsets)
    if not 2 <= count <= max_count:
        numbers = "0" if max_count < 2 else "0 or 2" if max_count == 2 else f"0, or from 2 to {max_count}"
        condition = "for these faces and this path" if box.can_have_strips else "for these faces"
        raise ArgumentError(
            "{strips} must be {numbers} {condition}, got {got}", numbers=numbers, condition=condition, got=count
        )
    boxes = box.cut_strips(offsets, count)
    if len(boxes) < 2:
        raise ArgumentError(
            "{strips} must be 0, or give at least 2 strips with enough measured points, got {got}", got=count
        )
    return boxes


def _compute_shear_tests(
    setup: _ShearTestSetup, record: SolutionRecord, progress: Callable[[int, int], object] | None
) -> xr.Dataset:
    box, offsets, inputs = setup.box, setup.offsets, setup.inputs
    boxes = [box, *(variation.apply_to(box) for variation in setup.variations), *setup.strips]
    num_steps = len(offsets)

    def solve(index: int) -> tuple[list[StepResult], xr.Dataset]:
        """Solve the shear test with the number `index`, and return its steps as a list and as a dataset.

        The dataset also contains the closure of the joint under the normal load.
        """

        def show_total_progress(num_finished: int, _: int) -> None:
            if progress is not None:
                progress(index * num_steps + num_finished, len(boxes) * num_steps)

        rows = boxes[index].solve(offsets, record, show_total_progress)
        return rows, boxes[index].to_dataset(offsets, rows).assign(boxes[index].solve_closure(record))

    rows, test = solve(0)
    pressure = box.solve_peak_pressure(test, offsets, rows, record)
    area = float(test["overlap_area"][0])
    law = fit_bandis_law(test["normal_stress"].values, test["closure"].values)
    other_tests = [solve(index)[1] for index in range(1, len(boxes))]
    variations, strips = other_tests[: len(setup.variations)], other_tests[len(setup.variations) :]
    test = add_shear_intervals(test, setup.samples, list(zip(setup.variations, variations, strict=True)), strips)
    test = test.assign(gap=box.initial_gap)
    test = test if pressure is None else test.assign(peak_pressure=pressure)
    hardness = inputs.entries.get("hardness")
    return test.assign_attrs(
        mu0=inputs.entries["mu0"].estimate.short_text, tau0=inputs.entries["tau0"].text,
        interface=setup.interface_name,
        **setup.interface_attributes,
        direction_deg=box.direction, load_mN=box.load,
        normal_stress_GPa=box.load / area, normal_stiffness_GPa_per_um=box.stiffness / area,
        effective_modulus_GPa=box.effective_modulus, hardness_GPa=math.nan if box.hardness is None else box.hardness,
        hardness="" if hardness is None else hardness.text, body_shears_first=_shears_before_sliding(box),
        strips=len(strips), uncertain_inputs=_describe_uncertain_inputs(setup),
        tilt=box.tilt, boundary=box.boundary, closure_initial_stiffness_GPa_per_um=law.initial_stiffness,
        maximum_closure_um=law.maximum_closure, closure_misfit=law.misfit,
        fit_correlation=correlate_facing_slopes(*box.faces_at(offsets[0])), **_describe_roughness(box),
    )  # fmt: skip


def _shears_before_sliding(box: ShearBox) -> int:
    """Return 1 if slip-line theory predicts that the softer body shears before the contacts slide, else 0."""
    law = FrictionLaw(box.law.mu0, box.law.tau0, CENTRAL_SHEAR_RATIO, uses_slip_lines=True)
    return int(box.hardness is not None and bool(law.is_stronger_than_body(box.hardness)))


def _describe_uncertain_inputs(setup: _ShearTestSetup) -> str:
    """Return the labels of all uncertain inputs of a shear test as one text."""
    labels = [entry.label for entry in setup.inputs.uncertain.values()]
    return ", ".join(labels + ["the interface"] * bool(setup.strength and setup.samples))


def _describe_roughness(box: ShearBox) -> dict[str, float]:
    roughness = measure_joint_roughness(box.lower, box.direction)
    return {
        "sampling_interval_um": roughness.sampling_interval, "z2": roughness.z2, "jrc": roughness.jrc,
        "rising_slope": roughness.rising_slope, "falling_slope": roughness.falling_slope,
    }  # fmt: skip


def _describe_registration(registration: Registration) -> dict[str, float]:
    shifts = zip(("y", "x")[-len(registration.shift) :], registration.shift, strict=True)
    return {
        **{f"registration_shift_{axis}_um": shift for axis, shift in shifts},
        "registration_rotation_deg": registration.rotation, "registration_correlation": registration.correlation,
        "registration_rms_gap_um": registration.rms_gap, "rms_gap_before_registration_um": registration.rms_gap_before,
        "registration_gap_noise_um": registration.gap_noise,
    }  # fmt: skip


def _describe_inputs(setup: _ShearTestSetup) -> str:
    """Return all inputs of a shear test as one text, which identifies the test.

    With an interface, these include the samples of its joint distribution and its caveats.
    """
    box = setup.box
    checksums = [
        hashlib.sha256(face.heights_with_nan.tobytes()).hexdigest() + repr((face.heights.shape, face.spacing))
        for face in (box.upper, box.lower)
    ]
    box_settings = {
        field.name: getattr(box, field.name) for field in fields(box) if field.name not in ("upper", "lower")
    }
    input_texts = sorted((name, entry.text) for name, entry in setup.inputs.entries.items())
    joint_samples = () if setup.strength is None else (setup.strength.fits[0].mu0, setup.strength.fits[0].tau0)
    checksums += [hashlib.sha256(array.tobytes()).hexdigest() for array in joint_samples]
    description = [checksums, sorted(box_settings.items()), input_texts, setup.offsets.tolist(), len(setup.strips)]
    if setup.strength is not None:
        samples = hashlib.sha256()
        for each in setup.samples:
            for array in (each.mu0, each.tau0, *each.contact_inputs.values()):
                samples.update(array.tobytes())
        coverages = [each.coverage for each in setup.samples]
        description += [samples.hexdigest(), coverages, setup.interface_attributes]
    return repr(tuple(description))


def _open_stored_test(directory: Path, key: str, *, replace: bool) -> xr.Dataset | None:
    """Return the finished shear test in a directory.

    Returns None if there is no test that can be reused.
    """
    test = load_shear_test(directory)
    # A shear test without a stored gap comes from an earlier version of stiction: `replace` lets it be computed again.
    if test is None or (replace and "gap" not in test):
        return None
    if test.attrs.get("key") == key:
        return test
    if replace:
        return None
    raise ArgumentError(
        "{directory} contains another shear test; choose another directory, or overwrite the test with {replace}",
        directory=printable_path(directory),
    )


def _build_shear_box(
    upper: Any, lower: Any, contact: MeasuredPair, *, load: Any, direction: Any, normal_stiffness: Any, boundary: Any,
    tilt: Any, level: Any, register: Any, tolerance: float,
) -> tuple[ShearBox, Registration | None]:  # fmt: skip
    """Check the arguments of a shear test. Return its shear box and, if requested, the registration of its faces."""
    is_profile = isinstance(lower, Profile)
    if isinstance(upper, Profile) != is_profile:
        raise ValueError(
            "the upper and the lower face must both be profiles or both surfaces, got "
            f"{type(upper).__name__} and {type(lower).__name__}"
        )
    check_choice("boundary", boundary, BoundaryCondition)
    check_choice("tilt", tilt, TiltMode)
    if tilt == "free" and boundary == "periodic":
        raise ValueError("tilt must be 'fixed' if the faces are periodic, got 'free'")
    if level is None:
        level = "mean" if boundary == "periodic" else "line" if is_profile else "plane"
    check_choice("level", level, ShearLevel)
    if level == ("plane" if is_profile else "line"):
        allowed = "mean, line or none for profiles" if is_profile else "mean, plane or none for maps"
        raise ValueError(f"level must be {allowed}, got {level!r}")
    if count_flips(upper):
        raise ValueError("the upper face must be oriented as it was scanned, got a face that is already flipped")
    faces = [face if level == "none" else levelled(face, level) for face in (upper, lower)]
    upper, lower = flipped(faces[0]), faces[1]
    if upper.spacing != lower.spacing:
        upper, lower = on_common_grid(upper, lower)
    check_bool("register", register)
    registration = None
    if register:
        if boundary == "periodic":
            raise ValueError("`register` must be False if the faces are periodic, got True")
        if upper.is_flat or lower.is_flat:
            raise ValueError("`register` must be False if a face is flat, got True")
        upper, lower, registration = register_faces(upper, lower)
    inputs, moduli = contact.half_space_inputs, contact.elasticity
    warn_if_tau0_is_large(np.asarray(inputs.central("tau0")), moduli.effective_modulus)
    strength = inputs.central("hardness") if "hardness" in inputs.entries else None
    box = ShearBox(
        upper, lower, load=1.0, stiffness=0.0, direction=parse_direction(direction, line=is_profile),
        law=FrictionLaw(inputs.central("mu0"), inputs.central("tau0")), effective_modulus=moduli.effective_modulus,
        compliance_share=moduli.compliance_share, hardness=strength, boundary=boundary, tilt=tilt,
        tolerance=validate_number("tolerance", tolerance, above=0, below=1),
    )  # fmt: skip
    area = box.initial_overlap_area
    if boundary == "periodic" and upper.heights.shape != lower.heights.shape:
        raise ValueError(
            f"the upper and the lower face must have equal shapes if they are periodic, got {upper.heights.shape} and "
            f"{lower.heights.shape}"
        )
    force = validate_number("load", loads_to_core_units("load", load, area), unit="mN", above=0)
    if strength is not None and not force < strength * area:
        raise ArgumentError(
            "{load} must be below {limit:.4g} mN, the hardness times the overlap area of the faces, got {got}",
            limit=strength * area, got=short_repr(load),
        )  # fmt: skip
    stiffness = 0.0 if normal_stiffness is None else _parse_stiffness(normal_stiffness) * area
    return replace_fields(box, load=force, stiffness=stiffness), registration


def _parse_stiffness(value: Any) -> float:
    """Parse a stiffness per area: a number in GPa/µm, or a pressure per length, such as "5 MPa/mm"."""
    if isinstance(value, str):
        pressure, _, length = value.partition("/")
        try:
            value = float(parse_quantity("", pressure, "pressure") / quantity(f"1 {length}", "length"))
        except ValueError:
            raise ArgumentError(
                '{normal_stiffness} must be a pressure per length, as in "5 MPa/mm", got {got}', got=repr(value)
            ) from None
    stiffness = validate_number("normal_stiffness", value)
    if not stiffness >= 0:
        raise ArgumentError("{normal_stiffness} must be at least 0, got {got}", got=short_repr(value))
    return stiffness
