"""stiction: the coefficient of static friction of rough surfaces, from their shape.

Lengths are in µm, forces in mN, pressures in GPa (1 GPa = 1 mN/µm²); angles in rad.
"""

from stiction._core import __version__
from stiction.mechanics.asperity import Asperities, asperities
from stiction.mechanics.candidates import Candidates, candidates
from stiction.mechanics.closed_forms import (
    effective_modulus,
    gentle_friction,
    hertz_cylinder,
    hertz_ellipse,
    hertz_line,
    hertz_sphere,
    slope_friction,
    westergaard_contact_fraction,
    westergaard_gap,
    westergaard_pressure,
)
from stiction.mechanics.contact import Contacts, LoadCurve, SurfaceLoadCurve, SurfaceValidity, contacts, press
from stiction.mechanics.friction import Validity
from stiction.mechanics.half_space import HalfSpaceContact, HalfSpaceCurve, half_space
from stiction.mechanics.law import HertzCylinder, HertzSphere, JacksonGreen, force_and_area
from stiction.mechanics.loading import approach_at_load
from stiction.mechanics.model import ContactModel
from stiction.studies.map_pair import pressed_maps, pressed_maps_mean
from stiction.studies.maps import area_map, friction_map, stiffness_map
from stiction.studies.nondimensional import nondimensional
from stiction.studies.pairs import pair_of
from stiction.studies.runner import run
from stiction.studies.study import Study, study_names
from stiction.studies.traverse import traverse, traverse_mean
from stiction.surfaces.fractal import (
    random_phases,
    weierstrass_mandelbrot,
    weierstrass_mandelbrot_family,
    weierstrass_mandelbrot_moments,
    weierstrass_mandelbrot_surface,
)
from stiction.surfaces.hurst import HurstEstimate, hurst_exponent_of
from stiction.surfaces.lines import LineRoughness, line_roughness, lines_along_both
from stiction.surfaces.measured.raw import FormatError, FormatWarning
from stiction.surfaces.measured.reading import read_measurement, read_profile, read_surface
from stiction.surfaces.measured.writing import write_profile, write_surface
from stiction.surfaces.pairing import paired_lines
from stiction.surfaces.preparation import cropped, levelled, on_common_grid, rotated, turned_over
from stiction.surfaces.profile import Profile
from stiction.surfaces.roughness import RoughnessParameters, roughness_parameters
from stiction.surfaces.self_affine import self_affine, surrogate
from stiction.surfaces.self_affine_surface import self_affine_surface
from stiction.surfaces.spectrum import PowerSpectrum, ProfileMoments, power_spectrum, spectral_moments
from stiction.surfaces.surface import Surface
from stiction.surfaces.surface_parameters import SurfaceParameters, bearing_curve, surface_parameters
from stiction.surfaces.surface_spectrum import RadialSpectrum, SurfaceSpectrum, surface_spectrum

__all__ = [
    "Asperities",
    "Candidates",
    "ContactModel",
    "Contacts",
    "FormatError",
    "FormatWarning",
    "HalfSpaceContact",
    "HalfSpaceCurve",
    "HertzCylinder",
    "HertzSphere",
    "HurstEstimate",
    "JacksonGreen",
    "LineRoughness",
    "LoadCurve",
    "PowerSpectrum",
    "Profile",
    "ProfileMoments",
    "RadialSpectrum",
    "RoughnessParameters",
    "Study",
    "Surface",
    "SurfaceLoadCurve",
    "SurfaceParameters",
    "SurfaceSpectrum",
    "SurfaceValidity",
    "Validity",
    "__version__",
    "approach_at_load",
    "area_map",
    "asperities",
    "bearing_curve",
    "candidates",
    "contacts",
    "cropped",
    "effective_modulus",
    "force_and_area",
    "friction_map",
    "gentle_friction",
    "half_space",
    "hertz_cylinder",
    "hertz_ellipse",
    "hertz_line",
    "hertz_sphere",
    "hurst_exponent_of",
    "levelled",
    "line_roughness",
    "lines_along_both",
    "nondimensional",
    "on_common_grid",
    "pair_of",
    "paired_lines",
    "power_spectrum",
    "press",
    "pressed_maps",
    "pressed_maps_mean",
    "random_phases",
    "read_measurement",
    "read_profile",
    "read_surface",
    "rotated",
    "roughness_parameters",
    "run",
    "self_affine",
    "self_affine_surface",
    "slope_friction",
    "spectral_moments",
    "stiffness_map",
    "study_names",
    "surface_parameters",
    "surface_spectrum",
    "surrogate",
    "traverse",
    "traverse_mean",
    "turned_over",
    "weierstrass_mandelbrot",
    "weierstrass_mandelbrot_family",
    "weierstrass_mandelbrot_moments",
    "weierstrass_mandelbrot_surface",
    "westergaard_contact_fraction",
    "westergaard_gap",
    "westergaard_pressure",
    "write_profile",
    "write_surface",
]
