"""stiction: the coefficient of static friction of rough surfaces, from their shape.

Lengths are in µm, forces in mN, pressures in GPa (1 GPa = 1 mN/µm²); angles in rad.
"""

from importlib import import_module as _import_module
from typing import Any as _Any

_HOMES = {
    "_core": ("__version__",),
    "cli.pair_function": ("pair",),
    "mechanics.asperity": ("Asperities", "asperities"),
    "mechanics.candidates": ("Candidates", "candidates"),
    "mechanics.closed_forms": (
        "effective_modulus",
        "gentle_friction",
        "hertz_cylinder",
        "hertz_ellipse",
        "hertz_line",
        "hertz_sphere",
        "slope_friction",
    ),
    "mechanics.contact": ("Contacts", "contacts"),
    "mechanics.friction": ("SurfaceValidity", "Validity"),
    "mechanics.half_space": ("HalfSpaceContact", "HalfSpaceCurve", "half_space"),
    "mechanics.law": ("HertzCylinder", "HertzSphere", "JacksonGreen", "force_and_area"),
    "mechanics.load_curve": ("LoadCurve", "SurfaceLoadCurve", "press"),
    "mechanics.loading": ("approach_at_load",),
    "mechanics.materials": (
        "Material",
        "MaterialValue",
        "compliance_fraction",
        "material",
        "materials",
        "softer_hardness",
    ),
    "mechanics.model": ("ContactModel",),
    "mechanics.onset": ("Onset",),
    "mechanics.presliding": ("FourParameterIwan", "LuGre"),
    "mechanics.resolution": ("resolution", "resolution_friction"),
    "mechanics.spectral_resolution": ("spectral_resolution",),
    "mechanics.westergaard": ("westergaard_contact_fraction", "westergaard_gap", "westergaard_pressure"),
    "studies.friction_table": ("friction_table", "table_study"),
    "studies.pressed_maps": ("pressed_maps", "pressed_maps_mean"),
    "studies.maps": ("area_map", "friction_map", "stiffness_map"),
    "studies.nondimensional": ("nondimensional",),
    "studies.members": ("pair_of",),
    "studies.runner": ("run",),
    "studies.study": ("Study", "study_names"),
    "studies.traverse": ("traverse", "traverse_mean"),
    "surfaces.cut_off": ("cut_off",),
    "surfaces.fractal": (
        "random_phases",
        "weierstrass_mandelbrot",
        "weierstrass_mandelbrot_family",
        "weierstrass_mandelbrot_moments",
        "weierstrass_mandelbrot_surface",
    ),
    "surfaces.hurst": ("HurstEstimate", "hurst_exponent_of"),
    "surfaces.joined": ("JoinedSpectrum", "joined_spectrum"),
    "surfaces.lines": ("LineRoughness", "line_roughness", "lines_along_both"),
    "surfaces.measured.raw": ("FormatError", "FormatWarning"),
    "surfaces.measured.reading": ("read_measurement", "read_profile", "read_surface"),
    "surfaces.measured.writing": ("write_profile", "write_surface"),
    "surfaces.pairing": ("paired_lines",),
    "surfaces.preparation": ("cropped", "levelled", "on_common_grid", "rotated", "turned_over"),
    "surfaces.profile": ("Profile",),
    "surfaces.roughness": (
        "RoughnessParameters",
        "SurfaceParameters",
        "bearing_curve",
        "roughness_parameters",
        "surface_parameters",
    ),
    "surfaces.scale": (
        "InstrumentLimit",
        "ScaleDependentRoughness",
        "instrument_limit",
        "scale_dependent_roughness",
    ),
    "surfaces.self_affine": ("self_affine", "self_affine_surface"),
    "surfaces.spectrum": (
        "PowerSpectrum",
        "ProfileMoments",
        "RadialSpectrum",
        "SurfaceSpectrum",
        "power_spectrum",
        "spectral_moments",
        "surface_spectrum",
    ),
    "surfaces.surface": ("Surface",),
    "surfaces.surrogates": ("isotropic_spectrum", "isotropic_surface", "surrogate"),
    "views.result": ("Result", "read_result"),
}
"""Where each public name is made; its module is imported when the name is first asked for. `__init__.pyi` says the same
to type checkers."""

_MODULE_OF = {name: module for module, names in _HOMES.items() for name in names}

__all__ = sorted(_MODULE_OF)


def __getattr__(name: str) -> _Any:
    if name not in _MODULE_OF:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(_import_module(f"{__name__}.{_MODULE_OF[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return __all__.copy()
