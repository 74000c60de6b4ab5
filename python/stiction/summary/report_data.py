"""Data model of a report: the study, evaluated datasets, and all numbers that the HTML page shows."""

from __future__ import annotations

import contextlib
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from stiction._checks import Floats
from stiction.evaluate.point import list_rules_with_reported_first
from stiction.study.study_description import StudyDescription, describe_study
from stiction.summary.evaluation import Evaluation
from stiction.summary.figure_values import (
    evaluate_height_factors,
    evaluate_onset_over_dimension,
    evaluate_positions_at_first_load,
    find_opposing_contacts,
)
from stiction.summary.report_grid import ReportGrid
from stiction.summary.report_values import (
    ReportValuesOfGeneratedSurfaces,
    ReportValuesOfMeasuredSurfaces,
    evaluate_generated_report,
    evaluate_measured_report,
)
from stiction.surfaces.pairing import SIDES

if TYPE_CHECKING:
    import xarray

    from stiction.companions.height_scale import ScaledBodies
    from stiction.study.measured_bodies import MeasuredBodySettings
    from stiction.study.study import Study
    from stiction.summary.summary import Summary
    from stiction.surfaces.measured.reading import FileReading

MAX_DESCRIBED_FILE_READINGS = 4


@dataclass(frozen=True, eq=False, kw_only=True)
class ReportData:
    """Data that every report contains, whether its surfaces are generated or measured.

    Attributes
    ----------
    study : Study
    description : StudyDescription
    version : str
        Version of stiction that computed the result.
    num_members, num_solved : int
        Numbers of finished members, and of members with a solution at all loads. Both numbers are equal for measured
        surfaces, whose reports include members without a solution.
    rules, directions : list
        Sliding rules and directions of motion (degrees), in the axis order of report values.
    """

    study: Study
    description: StudyDescription
    version: str
    num_members: int
    num_solved: int
    rules: list[str]
    directions: list[float]


@dataclass(frozen=True, eq=False, kw_only=True)
class ReportDataOfMeasuredSurfaces(ReportData):
    """Data of a report on measured surfaces: files, summary, contact picture and datasets for figures.

    Attributes
    ----------
    cut_offs : list of float, µm
    nominal_area : float, µm²
    effective_modulus : float, GPa
    bodies : dict
        Files and processing of the upper and the lower body.
    contact_picture, loading_cycle : xarray.Dataset or None
        As for `Result`.
    num_opposing_contacts : int
        Number of contacts in the picture that oppose the motion in the first direction.
    summary : Summary
    positions : xarray.Dataset or None
        Result of `evaluate_positions_at_first_load`, or None if there is only one member.
    height_factors : dict
        Results of `evaluate_height_factors`.
    """

    cut_offs: list[float]
    nominal_area: float
    effective_modulus: float
    bodies: dict[str, BodyHistory]
    contact_picture: xarray.Dataset | None
    num_opposing_contacts: int
    loading_cycle: xarray.Dataset | None
    summary: Summary
    positions: xarray.Dataset | None
    height_factors: dict[ScaledBodies, xarray.Dataset]


@dataclass(frozen=True, eq=False)
class BodyHistory:
    """Scan files and processing steps of one measured body.

    Attributes
    ----------
    name : str
        Names of the files.
    steps : list of str
        Processing steps.
    readings : list
        Settings of at most `MAX_DESCRIBED_FILE_READINGS` scans whose files can be read, and how each file was read.
    num_scans : int
    """

    name: str
    steps: list[str]
    readings: list[tuple[MeasuredBodySettings, FileReading[Any]]]
    num_scans: int


@dataclass(frozen=True, eq=False, kw_only=True)
class ReportDataOfGeneratedSurfaces(ReportData):
    """Data of a report on generated surfaces: fractal dimensions, amplitudes, loads and datasets for figures.

    Attributes
    ----------
    dimensions, amplitudes : ndarray of float
        Fractal dimensions, and amplitudes (µm).
    loads : ndarray of float, mN
        Loads shown on the page, or an empty array if no pair is in contact.
    num_steps : int
        Number of computed loads or approaches.
    contact_forces : xarray.Dataset or None
        As for `Result`.
    onset : xarray.Dataset or None
        Result of `evaluate_onset_over_dimension`.
    """

    dimensions: Floats
    amplitudes: Floats
    loads: Floats
    num_steps: int
    contact_forces: xarray.Dataset | None
    onset: xarray.Dataset | None


def evaluate_measured_values(result: Evaluation) -> ReportValuesOfMeasuredSurfaces:
    """Evaluate friction and contact quantities of measured surfaces for each load, mu0 and tau0 of a report."""
    return evaluate_measured_report(ReportGrid(result))


def evaluate_generated_values(result: Evaluation) -> ReportValuesOfGeneratedSurfaces | None:
    """Evaluate friction and contact quantities of generated surfaces for each load, mu0 and tau0 of a report.

    Returns None if no pair is in contact.
    """
    grid = ReportGrid(result)
    return evaluate_generated_report(grid, result.num_solved) if grid.loads.size else None


def count_coefficients(result: Evaluation) -> int:
    """Return the number of friction coefficients in a report of a given result."""
    return ReportGrid(result).num_coefficients


def collect_report_data(
    result: Evaluation, picture: xarray.Dataset | None = None
) -> ReportDataOfMeasuredSurfaces | ReportDataOfGeneratedSurfaces:
    """Collect the data of a report, except for the results that change with the report's sliders.

    `picture` comes from `contact_picture`; by default it is the picture that is stored with the result.
    """
    return _collect_measured_data(result, picture) if result.study.is_measured else _collect_generated_data(result)


def _collect_common_data(result: Evaluation) -> dict[str, Any]:
    study = result.study
    return {
        "study": study, "description": describe_study(study), "version": result.version,
        "num_members": result.members.size,
        "directions": [float(angle) for angle in study.contact.direction_angles()],
    }  # fmt: skip


# ---- Measured surfaces -----------------------------------------------------------------------------------------------


def _collect_measured_data(result: Evaluation, picture: xarray.Dataset | None) -> ReportDataOfMeasuredSurfaces:
    study, head = result.study, result.head
    picture = result.contact_picture if picture is None else picture
    first_direction = float(study.contact.direction_angles()[0])
    return ReportDataOfMeasuredSurfaces(
        bodies={side: _read_body_history(getattr(study.surfaces, side), head.attrs.get(side)) for side in SIDES},
        **_collect_common_data(result),
        rules=list_rules_with_reported_first(study),
        num_solved=result.members.size,
        cut_offs=head["cut_off"].values.tolist(),
        nominal_area=float(head["nominal_area"]),
        effective_modulus=float(head["effective_modulus"]),
        contact_picture=picture,
        num_opposing_contacts=0 if picture is None else int(find_opposing_contacts(picture, first_direction).sum()),
        loading_cycle=result.loading_cycle,
        summary=result.summary(),
        positions=evaluate_positions_at_first_load(result) if result.members.size > 1 else None,
        height_factors={scaled: evaluate_height_factors(result, scaled) for scaled in result.height_factors},
    )


def _read_body_history(body: MeasuredBodySettings, history: str | None) -> BodyHistory:
    readings = []
    for scan in body.scans[:MAX_DESCRIBED_FILE_READINGS]:
        with contextlib.suppress(ValueError, OSError):
            if (reading := scan.reading) is not None:
                readings.append((scan, reading))
    return BodyHistory(body.name, str(history or "").splitlines(), readings, len(body.scans))


# ---- Generated surfaces ----------------------------------------------------------------------------------------------


def _collect_generated_data(result: Evaluation) -> ReportDataOfGeneratedSurfaces:
    study, head, loads = result.study, result.head, ReportGrid(result).loads
    has_contact = bool(loads.size)
    return ReportDataOfGeneratedSurfaces(
        **_collect_common_data(result),
        rules=list(study.contact.sliding_rules()),
        num_solved=result.num_solved,
        dimensions=head["fractal_dimension"].values,
        amplitudes=head["amplitude"].values,
        loads=loads,
        num_steps=int(head.sizes[study.step_quantity]),
        contact_forces=result.contact_forces if has_contact else None,
        onset=evaluate_onset_over_dimension(result) if has_contact else None,
    )
