"""Draw docs/images/fractures.png, and print the tables of explanation/experiments.md on two fractures in granodiorite.

    python docs/scripts/fractures.py DIRECTORY [SPECIMEN ...]
    python docs/scripts/fractures.py DIRECTORY --errors  # only the table of errors of the stiffness

DIRECTORY contains vd1.npz (gap_um, spacing_um) and vd1-closure.csv (number, displacement in mm, nominal stress in MPa;
loading, then unloading), and the same for vd2, from github.com/danielvogler/hm_coupled_fracture_response.
"""

import sys
from pathlib import Path

import matplotlib as mpl
import numpy as np
from scipy.ndimage import gaussian_filter, zoom
from stiction import Surface, half_space, levelled
from stiction.views.style import (
    ALL_CONTACTS_COLOUR,
    FORCE_COLOUR,
    MATPLOTLIB_STYLE,
    PAGE_WIDTH,
    new_figure,
    save_figure,
)

IMAGE_FILE = Path(__file__).resolve().parents[1] / "images/fractures.png"
# The authors compute the stress from this diameter (µm); in the coordinates of the map, the face has 124 to 125 mm.
DISC_DIAMETER = 122e3
YOUNG_MODULUS, POISSON_RATIO = (
    11.0,
    0.33,
)  # Young's modulus (GPa, measured as 10 to 12) and Poisson's ratio (assumed by the authors)
LOW_STRESS_RANGE, HIGH_STRESS_RANGE = ((1.0, 2.0), (5.0, 10.0))  # MPa
TANGENT_STIFFNESS_STRESSES = 1.0, 2.0, 5.0  # MPa
SECANT_STRESS_RANGES = LOW_STRESS_RANGE, (2.0, 5.0), HIGH_STRESS_RANGE
DIGITISING_STEP = 4.0  # µm
FIT_WAVELENGTH_RANGE = 1e3, 10e3  # µm
MIN_STRESS = 0.2  # MPa


def read_gap(directory, name, *, square=True):
    """Return the gap (µm) in the largest square inside the disc, or in the whole disc with missing points around it."""
    with np.load(directory / f"{name}.npz") as archive:
        heights, spacing = archive["gap_um"].astype(float), float(archive["spacing_um"])
    side_length = int(DISC_DIAMETER / (np.sqrt(2) if square else 1) / spacing)
    first_indices = [(count - side_length) // 2 for count in heights.shape]
    square_heights = heights[
        first_indices[0] : first_indices[0] + side_length, first_indices[1] : first_indices[1] + side_length
    ]
    if square:
        return Surface(square_heights, spacing=spacing)
    distance = np.hypot(*(np.indices(square_heights.shape) - (side_length - 1) / 2)) * spacing
    return Surface(square_heights, spacing=spacing, missing=distance > DISC_DIAMETER / 2)


def read_load_test(directory, name):
    """Return the displacement (mm) and the stress (MPa) of a test while loading and while unloading."""
    number, displacement, stress = np.loadtxt(directory / f"{name}-closure.csv", delimiter=",", skiprows=2).T
    peak_index = int(stress.argmax())
    assert (np.diff(number) == 1).all()
    return (displacement[: peak_index + 1], stress[: peak_index + 1]), (displacement[peak_index:], stress[peak_index:])


def compute_closure(
    gap, stress, *, young=YOUNG_MODULUS, poisson=POISSON_RATIO, boundary="free", tilt="free", hardness=None
):
    """Return the closure (mm) since first contact at given stresses (MPa), together with the load curve."""
    flat_surface = Surface(np.zeros(gap.heights.shape), spacing=gap.spacing)
    rough_surface = Surface(-gap.heights, spacing=gap.spacing, missing=gap.missing)
    area = np.prod(gap.spacing) * (gap.heights.size - (0 if gap.missing is None else gap.missing.sum()))
    curve = half_space(
        flat_surface,
        rough_surface,
        stress * area / 1e3,
        effective_modulus=young / (1 - poisson**2) / 2,
        boundary=boundary,
        tilt=tilt,
        hardness=hardness,
        tolerance=1e-5,
    )
    return curve.closure / 1e3, curve


def secant_stiffness(closure, stress, stress_range):
    """Return the secant stiffness (MPa/mm) between two stresses (MPa), by linear interpolation."""
    return float(np.diff(stress_range)[0] / np.diff(np.interp(stress_range, stress, closure))[0])


def tabulate_stiffness_errors(directory, names=("vd1", "vd2")):
    """Return a Markdown table of computed and measured stiffnesses (MPa/mm) in loading, with frozen settings.

    The measured tangent stiffness is the slope between two neighbouring measured points, assigned to their mean stress
    and interpolated in between. The highest mean stress is the last row of tangents.
    """
    titles = [f"{name} {column}" for name in names for column in ("computed", "measured", "error")]
    rows = {}
    for name in names:
        (displacement, stress), _ = read_load_test(directory, name)
        mean_stress, measured_tangent = (stress[1:] + stress[:-1]) / 2, np.diff(stress) / np.diff(displacement)
        tangent_stresses = [*TANGENT_STIFFNESS_STRESSES, mean_stress[-1]]
        stresses = np.unique(np.concatenate([tangent_stresses, *SECANT_STRESS_RANGES]))
        closure, curve = compute_closure(read_gap(directory, name), stresses)
        for tangent_stress in tangent_stresses:
            computed = 1e6 * np.interp(tangent_stress, stresses, curve.closure_stiffness)
            measured = np.interp(tangent_stress, mean_stress, measured_tangent)
            rows.setdefault(f"tangent at {tangent_stress:.2g} MPa", []).append((computed, measured))
        for stress_range in SECANT_STRESS_RANGES:
            computed, measured = (
                secant_stiffness(*curve_points, stress_range)
                for curve_points in ((closure, stresses), (displacement, stress))
            )
            label = f"secant from {stress_range[0]:g} to {stress_range[1]:g} MPa"
            rows.setdefault(label, []).append((computed, measured))
    lines = [f"| stiffness (MPa/mm) | {' | '.join(titles)} |", "|-" * (len(titles) + 1) + "|"]
    for label, pairs in rows.items():
        cells = [f"{computed:.0f} | {measured:.0f} | {computed / measured - 1:+z.0%}" for computed, measured in pairs]
        lines.append(f"| {label} | {' | '.join(cells).replace('%', ' %').replace('-', '−')} |")
    return "\n".join(lines)


def estimate_spectrum(gap):
    """Return the Hurst exponent of a gap, and its spectral density as a function of the wavenumber (1/µm)."""
    heights = levelled(gap, "plane").heights * np.hanning(gap.heights.shape[0])[:, None]
    heights = heights * np.hanning(gap.heights.shape[1])
    wave_number = np.hypot(*np.meshgrid(*(np.fft.fftfreq(n, gap.spacing[0]) for n in gap.heights.shape), indexing="ij"))
    power_density = np.abs(np.fft.fft2(heights)) ** 2 * np.prod(gap.spacing) / heights.size / (9 / 64)
    is_fitted = (wave_number > 1 / FIT_WAVELENGTH_RANGE[1]) & (wave_number < 1 / FIT_WAVELENGTH_RANGE[0])
    slope, log_factor = np.polyfit(np.log(wave_number[is_fitted]), np.log(power_density[is_fitted]), 1)
    return (
        -slope / 2 - 1,
        lambda wave_number: np.exp(log_factor + np.euler_gamma) * wave_number**slope,
    )  # corrects the bias of the mean of the logarithm


def generate_random_heights(shape, spacing, density, longest, seed):
    """Return random heights (µm) that have a given spectral density at wavelengths below `longest` (µm)."""
    wave_number = np.hypot(*np.meshgrid(*(np.fft.fftfreq(n, spacing) for n in shape), indexing="ij"))
    wave_number[0, 0] = np.inf
    amplitude = np.where(wave_number > 1 / longest, np.sqrt(density(wave_number) / (np.prod(shape) * spacing**2)), 0.0)
    noise = np.fft.fft2(np.random.default_rng(seed).standard_normal(shape)) / np.sqrt(np.prod(shape))
    return np.fft.ifft2(amplitude * noise).real * np.prod(shape)


def refine_gap(gap, factor, seed=1):
    """Return a gap on a finer grid, with self-affine roughness at the wavelengths that the finer grid adds."""
    _, density = estimate_spectrum(gap)
    spacing = gap.spacing[0] / factor
    smooth_heights = zoom(gap.heights, factor, order=1)
    return Surface(
        smooth_heights + generate_random_heights(smooth_heights.shape, spacing, density, 2 * gap.spacing[0], seed),
        spacing=spacing,
    )


def shift_gap(gap, displacement, seed=1):
    """Return the gap after a shift of one surface along x. This surface is random, with the spectrum of the gap."""
    _, density = estimate_spectrum(gap)
    displaced_face = generate_random_heights(gap.heights.shape, gap.spacing[0], density, FIT_WAVELENGTH_RANGE[1], seed)
    return Surface(
        gap.heights + displacement * np.gradient(displaced_face, gap.spacing[0], axis=1), spacing=gap.spacing
    )


def change_heights(gap, change):
    """Return a copy of a gap, with the function `change` applied to its heights."""
    return Surface(change(gap.heights), spacing=gap.spacing)


def list_gap_variants(directory, name):
    """Return the variants of a gap: label, kind of uncertainty or None, the gap, and arguments of `compute_closure`."""
    gap, generator = read_gap(directory, name), np.random.default_rng(1)
    yield "frozen settings", "", gap, {}
    for young in (10.0, 12.0):
        yield f"E = {young:g} GPa", "E", gap, {"young": young}
    yield "Poisson's ratio 0.25", "E", gap, {"poisson": 0.25}
    yield "tilt fixed as scanned", "tilt", gap, {"tilt": "fixed"}
    yield "tilt fixed after a plane is removed", "tilt", levelled(gap, "plane"), {"tilt": "fixed"}
    yield "tilt fixed, periodic", "tilt", gap, {"tilt": "fixed", "boundary": "periodic"}
    yield "whole disc", "tilt", read_gap(directory, name, square=False), {}
    yield "heights random within 4 µm", "digitising", change_heights(
        gap, lambda z: z + generator.uniform(-DIGITISING_STEP / 2, DIGITISING_STEP / 2, z.shape)
    ), {}  # fmt: skip
    yield "blurred by one point", "digitising", change_heights(gap, lambda z: gaussian_filter(z, 1.0)), {}
    yield (
        "points clipped at 1 mm set to 1.5 mm",
        "digitising",
        change_heights(gap, lambda z: np.where(z >= 1e3, 1.5e3, z)),
        {},
    )
    for hardness in (1.0, 0.5):
        yield f"hardness {hardness:g} GPa", "hardness" if hardness >= 1 else "", gap, {"hardness": hardness}
    yield "finer wavelengths on a grid of half the spacing", "", refine_gap(gap, 2), {}
    for shear_displacement in (100.0, 300.0):
        yield f"one face displaced by {shear_displacement / 1e3:g} mm", "", shift_gap(gap, shear_displacement), {}
    yield "form removed (second degree)", "", levelled(gap, "quadratic"), {}


def main(directory, names):
    results = {}
    for name in names:
        (loading_displacement, stress), (unloading_displacement, unloading_stress) = read_load_test(directory, name)
        measured_stiffness = [
            secant_stiffness(loading_displacement, stress, stress_range)
            for stress_range in (LOW_STRESS_RANGE, HIGH_STRESS_RANGE)
        ]
        hurst, _ = estimate_spectrum(read_gap(directory, name))
        clipped_fraction = float((read_gap(directory, name).heights >= 1e3).mean())
        print(
            f"\n**{name}**: Hurst exponent of the gap {hurst:.2f}, "
            f"{100 * clipped_fraction:.1f} % of its points are clipped.\n"
        )
        print(
            "| change | secant stiffness, 1 to 2 MPa (MPa/mm) | difference | secant stiffness, 5 to 10 MPa (MPa/mm) "
            "| difference | true area at 10 MPa (%) |"
        )
        print("|-|-|-|-|-|-|")
        print(f"| measured, loading | {measured_stiffness[0]:.0f} | | {measured_stiffness[1]:.0f} | | |")
        unloading_stiffness = [
            secant_stiffness(unloading_displacement[::-1], unloading_stress[::-1], stress_range)
            for stress_range in (LOW_STRESS_RANGE, HIGH_STRESS_RANGE)
        ]
        print(f"| measured, unloading | {unloading_stiffness[0]:.0f} | | {unloading_stiffness[1]:.0f} | | |")
        stresses = np.unique(np.concatenate([stress, LOW_STRESS_RANGE, HIGH_STRESS_RANGE]))
        curves_by_kind = {}
        for label, uncertainty_kind, gap, options in list_gap_variants(directory, name):
            closure, curve = compute_closure(gap, stresses, **options)
            computed_stiffness = [
                secant_stiffness(closure, stresses, stress_range)
                for stress_range in (LOW_STRESS_RANGE, HIGH_STRESS_RANGE)
            ]
            deviations = [
                100 * (value / measured_value - 1)
                for value, measured_value in zip(computed_stiffness, measured_stiffness, strict=True)
            ]
            area = 100 * curve.contact_area[-1] * stress[-1] / 1e3 / curve.load[-1]
            cells = (
                f"{computed_stiffness[0]:.0f}",
                f"{deviations[0]:+z.0f} %",
                f"{computed_stiffness[1]:.0f}",
                f"{deviations[1]:+z.0f} %",
                f"{area:.1f}",
            )
            print(f"| {label} |", " | ".join(cells), "|", flush=True)
            curves = np.interp(stress, stresses, closure), 1e6 * np.interp(stress, stresses, curve.closure_stiffness)
            curves_by_kind.setdefault(uncertainty_kind, []).append(curves) if uncertainty_kind or label.startswith(
                "frozen"
            ) else None
        results[name] = (loading_displacement, stress, unloading_displacement, unloading_stress, curves_by_kind)
    draw_closure_and_stiffness(results)


def combine_variant_intervals(curves_by_kind):
    """Return the limits of closure and stiffness: the root sum of squares of each kind's largest deviation."""
    intervals = []
    for quantity_index in (0, 1):
        reference_curve = curves_by_kind[""][0][quantity_index]
        reference_curve = reference_curve - reference_curve[0] if quantity_index == 0 else reference_curve
        squared_deviations = np.zeros((2, reference_curve.size))
        for uncertainty_kind, curves in curves_by_kind.items():
            deviations = (
                [
                    item[quantity_index] - (item[quantity_index][0] if quantity_index == 0 else 0) - reference_curve
                    for item in curves
                ]
                if uncertainty_kind
                else []
            )
            if deviations:
                squared_deviations += np.square(
                    [np.minimum(0, np.min(deviations, axis=0)), np.maximum(0, np.max(deviations, axis=0))]
                )
        intervals.append(
            (
                reference_curve,
                reference_curve - np.sqrt(squared_deviations[0]),
                reference_curve + np.sqrt(squared_deviations[1]),
            )
        )
    return intervals


def draw_closure_and_stiffness(results):
    with mpl.rc_context(MATPLOTLIB_STYLE):
        figure = new_figure(100, width=PAGE_WIDTH)
        axes = figure.subplots(2, len(results), sharex=True, sharey="row", squeeze=False)
        for (closure_axes, stiffness_axes), (
            name,
            (loading_displacement, stress, unloading_displacement, unloading_stress, curves_by_kind),
        ) in zip(axes.T, results.items(), strict=True):
            closure, stiffness = combine_variant_intervals(curves_by_kind)
            for ax, (computed_curve, lower_limit, upper_limit) in (
                (closure_axes, closure),
                (stiffness_axes, stiffness),
            ):
                ax.fill_between(
                    stress,
                    lower_limit,
                    upper_limit,
                    color=ALL_CONTACTS_COLOUR,
                    alpha=0.2,
                    linewidth=0,
                    label="all uncertainties",
                )
                ax.plot(stress, computed_curve, color=ALL_CONTACTS_COLOUR, label="computed, nothing fitted")
            for _, stiffness_curve in curves_by_kind["E"][:2]:
                stiffness_axes.plot(stress, stiffness_curve, color=ALL_CONTACTS_COLOUR, linewidth=0.5, linestyle="--")
            closure_axes.plot(
                stress,
                loading_displacement - loading_displacement[0],
                "o",
                color=FORCE_COLOUR,
                markersize=3,
                label="measured, loading",
            )
            closure_axes.plot(
                unloading_stress,
                unloading_displacement - loading_displacement[0],
                "x",
                color=FORCE_COLOUR,
                markersize=3,
                label="measured, unloading",
            )
            mean_stress = (stress[1:] + stress[:-1]) / 2
            stiffness_axes.plot(
                mean_stress, np.diff(stress) / np.diff(loading_displacement), "o", color=FORCE_COLOUR, markersize=3
            )
            is_unloading = np.diff(unloading_displacement) < 0
            unloading_stiffness = (
                np.diff(unloading_stress)[is_unloading] / np.diff(unloading_displacement)[is_unloading]
            )
            stiffness_axes.plot(
                (unloading_stress[1:] + unloading_stress[:-1])[is_unloading] / 2,
                unloading_stiffness,
                "x",
                color=FORCE_COLOUR,
                markersize=3,
            )
            closure_axes.set_title(name, fontsize=7)
            stiffness_axes.set(xlabel="nominal stress (MPa)", xlim=(0, None), ylim=(0, 400))
        axes[0, 0].set(ylabel=f"closure since {MIN_STRESS + 0.06:.2f} MPa (mm)", ylim=(0, None))
        axes[1, 0].set(ylabel="stiffness (MPa/mm)")
        figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=4)
        save_figure(figure, IMAGE_FILE)


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    if sys.argv[2:] == ["--errors"]:
        print(tabulate_stiffness_errors(Path(sys.argv[1])))
    else:
        main(Path(sys.argv[1]), sys.argv[2:] or ["vd1", "vd2"])
