"""Compute the onset of sliding of rough surfaces, and write images/onset.png and generated/onset_*.md.

The script takes about four minutes on one core. Arguments, as in ``onset.py dimension``, select tables.
"""

import math
import sys
from itertools import product
from pathlib import Path

import numpy as np
import scipy.fft
from matplotlib.figure import Figure
from scipy.ndimage import uniform_filter
from scipy.sparse.linalg import LinearOperator, cg
from scipy.stats import t as student
from stiction import Study, Surface, half_space, press, run, self_affine_surface
from stiction._drawing import map_extent
from stiction._estimate import Estimate

DOCS_DIRECTORY = Path(__file__).parents[1]

EFFECTIVE_MODULUS = 10.0
MU0 = 0.3
POISSON_RATIO = 0.3
TAU0_OVER_MODULUS = (0.0, 0.02)
"""Values of tau0/E*, for gaps with an rms gradient of 0.14."""
BANDWIDTHS = (8, 16, 32)
"""Ratios of the longest to the shortest wavelength."""
RELATIVE_PRESSURES = (0.002, 0.02, 0.1)
"""Mean pressures, divided by E* h'."""
NUM_PAIRS = 6
MAP_STUDY_CHANGES = {
    "surfaces.kind": "surface", "surfaces.shape": [256, 256], "surfaces.extent": ["10 um", "10 um"],
    "surfaces.band_limit": "nyquist", "surfaces.fractal_dimension": [1.0, 1.2, 1.4, 1.6], "ensemble.repetitions": 30,
}  # fmt: skip
SEED = 2016
ORANGE, BLUE, GREEN, GREY = "#D55E00", "#0072B2", "#009E73", "#777777"  # colours from Okabe and Ito (2008)


def create_surface(bandwidth: int, repetition: int, side: str, *, slope: float = 0.1, points: int = 8) -> Surface:
    """Return a periodic unit square with a given rms gradient, whose sides are two of the longest wavelengths."""
    n = 2 * bandwidth * points
    surface = self_affine_surface(
        SEED, hurst_exponent=0.8, rms=1.0, shape=(n, n), spacing=1 / n, longest_wavelength=0.5,
        shortest_wavelength=0.5 / bandwidth, repetition=repetition, side=side,
    )  # fmt: skip
    return Surface(surface.heights * slope / rms_gradient(surface.heights), spacing=1 / n)


def rms_gradient(heights: np.ndarray) -> float:
    n = heights.shape[0]
    return n * math.sqrt(sum(np.mean((np.roll(heights, -1, axis) - heights) ** 2) for axis in (0, 1)))


def create_pair(bandwidth: int, repetition: int, **surface_options: float) -> tuple[Surface, Surface, float]:
    """Return upper surface, lower surface, and the load for a mean pressure of E* h'."""
    upper, lower = (create_surface(bandwidth, repetition, side, **surface_options) for side in ("upper", "lower"))
    return upper, lower, EFFECTIVE_MODULUS * rms_gradient(upper.heights - lower.heights)


def render_table_header(*names: str) -> list[str]:
    """Return the header lines of a table."""
    return ["| " + " | ".join(names) + " |", "|" + "---|" * len(names)]


def format_ratio_interval(ratios: list[float]) -> str:
    """Return the geometric mean of ratios with its 95 % interval as text."""
    log_ratios = np.log(ratios)
    half_width = student.ppf(0.975, log_ratios.size - 1) * log_ratios.std(ddof=1) / math.sqrt(log_ratios.size)
    mean = log_ratios.mean()
    return f"{math.exp(mean):.2f} [{math.exp(mean - half_width):.2f}, {math.exp(mean + half_width):.2f}]"


def compare_asperity_model() -> list[str]:
    """Return table rows with results of the asperity model divided by half-space results at equal elastic load."""
    lines = render_table_header(
        "longest / shortest wavelength",
        "mean pressure / (E\\* h')",
        "initial tangential stiffness",
        "pre-sliding displacement, τ0 = 0",
        "pre-sliding displacement, τ0 = 2 % of E\\*",
        "sliding load, τ0 = 2 % of E\\*",
        "fraction of the load that slips at half of the sliding load: half-space, asperities",
    )
    for bandwidth in BANDWIDTHS:
        ratios_by_pressure = [[[] for _ in range(6)] for _ in RELATIVE_PRESSURES]
        for repetition in range(NUM_PAIRS):
            upper, lower, unit_load = create_pair(bandwidth, repetition)
            half_space_curve = half_space(
                upper,
                lower,
                np.multiply(RELATIVE_PRESSURES, unit_load),
                effective_modulus=EFFECTIVE_MODULUS,
                boundary="periodic",
            )
            height_range = np.ptp(upper.heights - lower.heights)
            trial_approaches = np.geomspace(1e-3, 1, 300) * height_range
            curve = press(upper, lower, trial_approaches, effective_modulus=EFFECTIVE_MODULUS)
            approaches = np.interp(half_space_curve.load, np.maximum.accumulate(curve.normal_elastic), trial_approaches)
            curve = press(upper, lower, approaches, effective_modulus=EFFECTIVE_MODULUS)
            for k in range(len(RELATIVE_PRESSURES)):
                onsets = [
                    [
                        curve_or_half_space.onset(k, mu0=MU0, tau0=tau0 * EFFECTIVE_MODULUS, steps=[0.5, 1.0])
                        for curve_or_half_space in (curve, half_space_curve)
                    ]
                    for tau0 in TAU0_OVER_MODULUS
                ]
                ratios_by_pressure[k][0].append(onsets[0][0].stiffness / onsets[0][1].stiffness)
                for step_index in range(2):
                    ratios_by_pressure[k][1 + step_index].append(
                        onsets[step_index][0].displacement_at_sliding / onsets[step_index][1].displacement_at_sliding
                    )
                ratios_by_pressure[k][3].append(onsets[1][0].sliding_load / onsets[1][1].sliding_load)
                ratios_by_pressure[k][4].append(onsets[0][1].slipped_load[0])
                ratios_by_pressure[k][5].append(onsets[0][0].slipped_load[0])
        for load, columns in zip(RELATIVE_PRESSURES, ratios_by_pressure, strict=True):
            ratios = " | ".join(format_ratio_interval(column) for column in columns[:4])
            slip_texts = ", ".join(f"{100 * np.mean(column):.0f} %" for column in columns[4:])
            lines.append(f"| {bandwidth} | {load:g} | {ratios} | {slip_texts} |")
            print(lines[-1], flush=True)
    return lines


def compare_tangential_kernels() -> list[str]:
    """Return table rows with the initial stiffness of the full kernel, relative to the isotropic kernel, at ν = 0.3."""
    lines = render_table_header("roughness", "exact kernel", "exact kernel without transverse displacement")
    upper, lower, unit_load = create_pair(8, 0, points=32)
    gap = upper.heights - lower.heights
    n = gap.shape[0]
    stretched_surfaces = (("stretched fourfold along the motion", 0), ("stretched fourfold across the motion", 1))
    for name, axis in (("isotropic", None), *stretched_surfaces):
        if axis is not None:
            gap = np.concatenate([np.take(upper.heights - lower.heights, np.arange(0, n, 4), axis)] * 4, axis)
        bodies = Surface(gap, spacing=1 / n), Surface(np.zeros(gap.shape), spacing=1 / n)
        curve = half_space(*bodies, [0.02 * unit_load], effective_modulus=EFFECTIVE_MODULUS, boundary="periodic")
        is_contact = curve.contact(0).pressure > 0
        isotropic_stiffness = curve.onset(0, mu0=MU0, poisson=POISSON_RATIO, steps=1).stiffness
        ratios = [
            _sticking_contact_stiffness(is_contact, is_fixed_along_y=is_fixed_along_y) / isotropic_stiffness
            for is_fixed_along_y in (False, True)
        ]
        lines.append(f"| {name} | {ratios[0]:.3f} | {ratios[1]:.3f} |")
        print(lines[-1], flush=True)
    return lines


def _sticking_contact_stiffness(is_contact: np.ndarray, *, is_fixed_along_y: bool) -> float:
    """Return the load that displaces all contact points by 1 along x. They may also be kept in place along y."""
    n = is_contact.shape[0]
    k = 2 * np.pi * np.stack(np.meshgrid(scipy.fft.fftfreq(n, 1 / n), scipy.fft.rfftfreq(n, 1 / n), indexing="ij"))
    wave_number = np.hypot(*k)
    wave_number[0, 0] = np.inf
    # The shear moduli of both bodies act in series, E* = 2 G'/(1 - ν), so u = 2/(E* (1 - ν) |k|) (1 - ν kx²/k²) q.
    mean_kernel = 2 / (EFFECTIVE_MODULUS * (1 - POISSON_RATIO) * wave_number)
    direct_compliances = [mean_kernel * (1 - POISSON_RATIO * (k[axis] / wave_number) ** 2) for axis in (1, 0)]
    cross_compliance = -mean_kernel * POISSON_RATIO * k[0] * k[1] / wave_number**2
    num_contact_points = int(is_contact.sum())

    def compute_displacement(q: np.ndarray) -> np.ndarray:
        load_transforms = []
        for component in q.reshape(-1, num_contact_points):
            traction_map = np.zeros(is_contact.shape)
            traction_map[is_contact] = component
            load_transforms.append(scipy.fft.rfft2(traction_map))
        transforms = [direct_compliances[0] * load_transforms[0]]
        if is_fixed_along_y:
            transforms = [
                transforms[0] + cross_compliance * load_transforms[1],
                direct_compliances[1] * load_transforms[1] + cross_compliance * load_transforms[0],
            ]
        return np.concatenate([scipy.fft.irfft2(transform, is_contact.shape)[is_contact] for transform in transforms])

    num_unknowns = num_contact_points * (1 + is_fixed_along_y)
    target_displacement = np.zeros(num_unknowns)
    target_displacement[:num_contact_points] = 1.0
    # A constant added to the kernel, whose mean is zero, makes the kernel positive definite, and is removed at the end.
    mean_compliance = 10.0 / EFFECTIVE_MODULUS

    def compute_displacement_with_mean(q: np.ndarray) -> np.ndarray:
        displacement = compute_displacement(q)
        for component in range(1 + is_fixed_along_y):
            displacement[component * num_contact_points : (component + 1) * num_contact_points] += (
                mean_compliance
                * q[component * num_contact_points : (component + 1) * num_contact_points].mean()
                * num_contact_points
                / n**2
            )
        return displacement

    q, _ = cg(
        LinearOperator((num_unknowns, num_unknowns), compute_displacement_with_mean),
        target_displacement,
        rtol=1e-8,
        maxiter=5000,
    )
    load = q[:num_contact_points].sum() / n**2
    return float(1 / (1 / load - mean_compliance))


def fit_presliding_models() -> list[str]:
    """Fit the Iwan and LuGre models to onset curves, and return the rows of a table."""
    lines = render_table_header(
        "boundary", "mean pressure / (E\\* h')", "τ0 / E\\*", "Iwan: χ, β", "Iwan: rms error of the load",
        "Iwan: rms error of the energy per cycle", "LuGre: σ0 / initial stiffness", "LuGre: rms error of the load",
    )  # fmt: skip
    upper, lower, unit_load = create_pair(16, 0)
    for boundary in ("periodic", "free"):
        loads = np.multiply(RELATIVE_PRESSURES, unit_load)
        curve = half_space(upper, lower, loads, effective_modulus=EFFECTIVE_MODULUS, boundary=boundary)
        for k, tau0 in product(range(len(RELATIVE_PRESSURES)), TAU0_OVER_MODULUS):
            onset = curve.onset(k, mu0=MU0, tau0=tau0 * EFFECTIVE_MODULUS)
            iwan_model, lugre_model = onset.iwan(), onset.lugre()
            lost_energy = onset.energy_lost(onset.tangential_load[4:])
            energy_error = math.sqrt(np.mean((iwan_model.energy_lost(onset.displacement[4:]) / lost_energy - 1) ** 2))
            residuals = [
                math.sqrt(np.mean(model.residual**2)) / onset.sliding_load for model in (iwan_model, lugre_model)
            ]
            error_texts = [f"{100 * residual:.1f} %" for residual in residuals]
            lines.append(
                f"| {boundary} | {RELATIVE_PRESSURES[k]:g} | {tau0:g} "
                f"| {iwan_model.chi:z.2f}, {iwan_model.beta:z.2f} | {error_texts[0]} | "
                f"{100 * energy_error:.0f} % | {lugre_model.stiffness / onset.stiffness:.2f} "
                f"| {error_texts[1]} |"
            )
            print(lines[-1], flush=True)
    return lines


def compare_gap_slopes() -> list[str]:
    lines = render_table_header("h' of the gap", "sliding load / (μ0 F + τ0 A)")
    for slope in (0.05, 0.1, 0.3, 0.6):
        upper, lower, unit_load = create_pair(16, 0, slope=slope / math.sqrt(2))
        curve = half_space(
            upper,
            lower,
            [0.02 * unit_load],
            effective_modulus=EFFECTIVE_MODULUS,
            boundary="periodic",
            sliding="all",
            direction=[0, 180],
        )
        onset = curve.onset(0, mu0=MU0, steps=1)
        lines.append(f"| {slope:g} | {curve.tangential_load(mu0=MU0)[:, 0].mean() / onset.sliding_load:.4f} |")
        print(lines[-1], flush=True)
    return lines


def compute_onset_over_dimension() -> list[str]:
    """Compute the onset of profiles (built-in study) and of maps as a function of D, and return the rows of a table."""
    profile_result = run(Study.named("presliding"), progress=True)
    map_result = run(Study.named("presliding").with_changes(MAP_STUDY_CHANGES), progress=True)
    rows = render_table_header(
        "D",
        *(
            f"{surface_kind}: {quantity_text}"
            for surface_kind in ("profiles", "height maps")
            for quantity_text in ("pre-sliding displacement (nm)", "slips at half (%)", "k_t (mN/µm)")
        ),
    )
    datasets = [result.at(load).squeeze() for result, load in ((profile_result, 4e-3), (map_result, 0.1))]
    for dimension in datasets[1]["fractal_dimension"].values:
        cells = [f"{dimension:.1f}"]
        for dataset in datasets:
            values = dataset.sel(fractal_dimension=dimension, method="nearest")
            for name, unit_factor in (
                ("displacement_at_sliding", 1000.0),
                ("fraction_slipped", 100.0),
                ("tangential_stiffness", 1.0),
            ):
                estimate = Estimate(
                    *(unit_factor * float(values[name].sel(statistic=end)) for end in ("mean", "lower", "upper"))
                )
                cells.append(estimate.table_text)
        rows.append("| " + " | ".join(cells) + " |")
        print(rows[-1], flush=True)
    return rows


def draw_figure() -> None:
    """Draw the onset of ground steel faces: E* 115 GPa, hardness 5 GPa, 50 MPa, mu0 0.2, tau0 50 MPa."""
    n, length, window_size = 512, 20.0, 128
    upper, lower = (
        self_affine_surface(
            SEED, hurst_exponent=0.8, rms=0.02, shape=(n, n), spacing=length / n, longest_wavelength=length / 4,
            shortest_wavelength=8 * length / n, side=side,
        )
        for side in ("upper", "lower")
    )  # fmt: skip
    curve = half_space(upper, lower, [0.05 * length**2], effective_modulus=115.0, hardness=5.0, boundary="periodic")
    onset = curve.onset(0, mu0=0.2, tau0=0.05, steps=40)
    figure = Figure(figsize=(6.7, 2.3), dpi=300, layout="constrained")
    cycle_axes, slip_axes, map_axes = figure.subplots(1, 3, width_ratios=[1.15, 1, 1])
    displacement, load = 1e3 * np.append(0, onset.displacement), np.append(0, onset.tangential_load)
    cycle_axes.plot(displacement, load, color="black", lw=1.2)
    for amplitude, colour in ((0.5, BLUE), (0.9, ORANGE)):
        load_loop = onset.loop(amplitude * onset.sliding_load)
        cycle_axes.fill(1e3 * load_loop[0], load_loop[1], color=colour, alpha=0.25, lw=0)
        cycle_axes.plot(
            1e3 * np.append(load_loop[0], load_loop[0][0]),
            np.append(load_loop[1], load_loop[1][0]),
            color=colour,
            lw=0.8,
        )
        lost_energy = 1e3 * float(onset.energy_lost(amplitude * onset.sliding_load))
        cycle_axes.annotate(
            f"{amplitude:g} $T_s$: {lost_energy:.2g} pJ a cycle", (0.97, 0.06 if amplitude > 0.5 else 0.16),
            xycoords="axes fraction", ha="right", fontsize=6, color=colour,
        )  # fmt: skip
    cycle_axes.axhline(onset.sliding_load, color=GREY, lw=0.6, ls=":")
    cycle_axes.set(xlabel="displacement (nm)", ylabel="tangential load (mN)")
    load_fraction = load / onset.sliding_load
    slip_axes.plot(load_fraction, 100 * np.append(0, onset.slipped_load), color=ORANGE, lw=1.2, label="of the load")
    slip_axes.plot(load_fraction, 100 * np.append(0, onset.slipped_area), color=BLUE, lw=1.2, label="of the area")
    slip_axes.plot(load_fraction, 100 * (1 - (1 - load_fraction) ** (2 / 3)) ** 1.5, color=ORANGE, lw=0.8, ls="--")
    slip_axes.plot(load_fraction, 100 * (1 - (1 - load_fraction) ** (2 / 3)), color=BLUE, lw=0.8, ls="--")
    slip_axes.set(xlabel="tangential load / sliding load", ylabel="slips (%)", xlim=(0, 1), ylim=(0, 100))
    slip_axes.legend(frameon=False, fontsize=6, title="dashed: one ball", title_fontsize=6)
    slip_fraction = onset.slip_load().reshape(n, n) / onset.sliding_load
    # Show the square section with the largest contact area.
    is_contact = curve.contact(0).pressure > 0
    contact_density = uniform_filter(is_contact.astype(float), window_size)[
        window_size // 2 : -window_size // 2, window_size // 2 : -window_size // 2
    ]
    row, column = np.unravel_index(contact_density.argmax(), contact_density.shape)
    image = map_axes.imshow(
        slip_fraction[row : row + window_size, column : column + window_size], origin="lower",
        vmin=0, vmax=1, cmap="viridis", interpolation="nearest",
        extent=map_extent((window_size, window_size), (length / n, length / n)),
    )  # fmt: skip
    colour_bar = figure.colorbar(image, ax=map_axes)
    colour_bar.set_label("slips at $T/T_s$", size=7)
    colour_bar.ax.tick_params(labelsize=6, width=0.4)
    map_axes.set(xlabel="x (µm)", ylabel="y (µm)", facecolor="#f4f4f4")
    for axes in (cycle_axes, slip_axes, map_axes):
        axes.tick_params(labelsize=6, width=0.4)
        axes.xaxis.label.set_size(7)
        axes.yaxis.label.set_size(7)
    figure.savefig(DOCS_DIRECTORY / "images/onset.png")
    print(
        f"mu_s {onset.sliding_load / onset.normal_load:.4f}, creep {1e3 * onset.displacement_at_sliding:.3g} nm, "
        f"at half of it {100 * onset.slipped_load[19]:.0f} % of the load slips, stiffness {onset.stiffness:.3g} mN/µm"
    )


def main(*names: str) -> None:
    tables = {
        "asperities": compare_asperity_model,
        "kernel": compare_tangential_kernels,
        "slopes": compare_gap_slopes,
        "fits": fit_presliding_models,
        "dimension": compute_onset_over_dimension,
    }
    for name in names or tables:
        table_path = DOCS_DIRECTORY / f"generated/onset_{name}.md"
        table_path.write_text("\n".join(tables[name]()) + "\n", encoding="utf-8")
    if not names:
        draw_figure()


if __name__ == "__main__":
    main(*sys.argv[1:])
