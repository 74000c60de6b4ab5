"""stiction: the coefficient of static friction of rough surfaces, from their shape.

Lengths are in µm, forces in mN, pressures in GPa (1 GPa = 1 mN/µm²); angles in rad.
"""

from stiction._core import __version__
from stiction.mechanics.asperity import Asperities, asperities
from stiction.mechanics.candidates import Candidates, candidates
from stiction.mechanics.closed_forms import (
    effective_modulus,
    hertz_cylinder,
    hertz_sphere,
    slope_friction,
    westergaard_contact_fraction,
)
from stiction.mechanics.contact import Contacts, LoadCurve, SurfaceLoadCurve, SurfaceValidity, contacts, press
from stiction.mechanics.friction import Validity
from stiction.mechanics.law import HertzCylinder, HertzSphere, JacksonGreen, force_and_area
from stiction.mechanics.loading import approach_at_load
from stiction.mechanics.model import ContactModel
from stiction.studies.ensemble import area_map, friction_map, stiffness_map
from stiction.studies.runner import run
from stiction.studies.scaling import nondimensional
from stiction.studies.study import Study, study_names
from stiction.studies.traverse import paired_lines, traverse, traverse_mean
from stiction.surfaces.formats import (
    FormatError,
    FormatWarning,
    read_measurement,
    read_profile,
    read_surface,
    write_profile,
    write_surface,
)
from stiction.surfaces.fractal import (
    ProfileMoments,
    random_phases,
    weierstrass_mandelbrot,
    weierstrass_mandelbrot_family,
    weierstrass_mandelbrot_moments,
    weierstrass_mandelbrot_surface,
)
from stiction.surfaces.lines import LineRoughness, line_roughness
from stiction.surfaces.preparation import cropped, levelled, on_common_grid, turned_over
from stiction.surfaces.profile import Profile
from stiction.surfaces.roughness import (
    HurstEstimate,
    PowerSpectrum,
    RoughnessParameters,
    hurst_exponent_of,
    power_spectrum,
    roughness_parameters,
    self_affine,
    spectral_moments,
    surrogate,
)
from stiction.surfaces.self_affine_surface import self_affine_surface
from stiction.surfaces.surface import Surface

__all__ = [
    "Asperities",
    "Candidates",
    "ContactModel",
    "Contacts",
    "FormatError",
    "FormatWarning",
    "HertzCylinder",
    "HertzSphere",
    "HurstEstimate",
    "JacksonGreen",
    "LineRoughness",
    "LoadCurve",
    "PowerSpectrum",
    "Profile",
    "ProfileMoments",
    "RoughnessParameters",
    "Study",
    "Surface",
    "SurfaceLoadCurve",
    "SurfaceValidity",
    "Validity",
    "__version__",
    "approach_at_load",
    "area_map",
    "asperities",
    "candidates",
    "contacts",
    "cropped",
    "effective_modulus",
    "force_and_area",
    "friction_map",
    "hertz_cylinder",
    "hertz_sphere",
    "hurst_exponent_of",
    "levelled",
    "line_roughness",
    "nondimensional",
    "on_common_grid",
    "paired_lines",
    "power_spectrum",
    "press",
    "random_phases",
    "read_measurement",
    "read_profile",
    "read_surface",
    "roughness_parameters",
    "run",
    "self_affine",
    "self_affine_surface",
    "slope_friction",
    "spectral_moments",
    "stiffness_map",
    "study_names",
    "surrogate",
    "traverse",
    "traverse_mean",
    "turned_over",
    "weierstrass_mandelbrot",
    "weierstrass_mandelbrot_family",
    "weierstrass_mandelbrot_moments",
    "weierstrass_mandelbrot_surface",
    "westergaard_contact_fraction",
    "write_profile",
    "write_surface",
]
