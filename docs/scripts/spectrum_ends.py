"""Draw the ends of spectra that `pair` distinguishes, and write images/spectrum_ends.png.

The program assigns each profile, which is generated, the end that the title states.
"""

from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from stiction import Profile, power_spectrum, self_affine
from stiction.views.style import INCHES_PER_MILLIMETRE, MATPLOTLIB_STYLE, OPPOSING_CONTACT_COLOUR

IMAGES_DIRECTORY = Path(__file__).parents[1] / "images"

NUM_POINTS, SPACING = 4096, 0.1  # spacing in µm
RMS_HEIGHT = 0.1  # µm
BINS_PER_DECADE, MAX_BINS_PER_DECADE = 12, 60


def create_profiles():
    """Return the heights (µm) of a profile for each kind of end, and the wave number (1/µm) at which the end begins."""
    generator = np.random.default_rng(5)
    options = {"hurst_exponent": 0.8, "rms": RMS_HEIGHT, "points": NUM_POINTS, "spacing": SPACING}
    clean_profile = self_affine(1, **options)
    noise = generator.normal(size=NUM_POINTS)
    wave_numbers = 2 * np.pi * np.fft.rfftfreq(NUM_POINTS, SPACING)
    hump_filter = np.exp(-0.5 * (np.log(np.maximum(wave_numbers, 1e-3) / 12.0) / 0.18) ** 2)
    hump_noise = np.fft.irfft(np.fft.rfft(noise) * hump_filter, NUM_POINTS)
    smooth_profile = self_affine(1, longest_wavelength=40.0, **(options | {"rms": 0.02}))
    tool_marks = np.square(2 * ((clean_profile.x / 8.0) % 1) - 1)  # grooves every 8 µm
    return {
        "flat: noise": (clean_profile.heights + 1.5e-3 * noise, 7.0),
        "hump: unknown origin": (clean_profile.heights + 1.5e-2 * hump_noise, 7.0),
        "flattened: possible noise": (clean_profile.heights + 6e-4 * noise, 7.0),
        "harmonics: machining": (smooth_profile.heights + RMS_HEIGHT * tool_marks, 0.5),
    }


def draw_figure():
    figure = Figure(figsize=(150 * INCHES_PER_MILLIMETRE, 36 * INCHES_PER_MILLIMETRE), layout="constrained")
    for axes, (title, (heights, end_wave_number)) in zip(figure.subplots(1, 4), create_profiles().items(), strict=True):
        spectrum = power_spectrum(Profile(heights, spacing=SPACING))
        bins = spectrum.in_bins(MAX_BINS_PER_DECADE if "harmonics" in title else BINS_PER_DECADE)
        is_end = bins.wave_number >= end_wave_number
        axes.loglog(bins.wave_number, bins.density, color="0.3", linewidth=1)
        axes.loglog(bins.wave_number[is_end], bins.density[is_end], color=OPPOSING_CONTACT_COLOUR, linewidth=1.2)
        axes.set_title(title)
        axes.set(xticks=[], yticks=[])
        axes.minorticks_off()
    return figure


def save_figures(directory):
    """Draw the figure, and write it to a directory."""
    with mpl.rc_context(MATPLOTLIB_STYLE):
        draw_figure().savefig(directory / "spectrum_ends.png", dpi=200)


if __name__ == "__main__":
    save_figures(IMAGES_DIRECTORY)
