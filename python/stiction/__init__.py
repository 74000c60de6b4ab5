"""stiction: static friction coefficient of rough surfaces, computed from their heights.

Lengths are in µm, forces in mN, pressures in GPa (1 GPa = 1 mN/µm²); angles in rad.
"""

_PUBLIC_NAMES_BY_MODULE = {
    "stiction._core": "__version__",
    "stiction.mechanics.candidates": "Candidates candidates",
    "stiction.mechanics.closed_forms": (
        "dmt effective_modulus fuller_tabor gentle_friction hardness_under_shear hertz_cylinder hertz_ellipse "
        "hertz_line hertz_sphere jkr maugis_dugdale slope_friction tabor_friction tabor_parameter "
        "westergaard_contact_fraction westergaard_gap westergaard_pressure"
    ),
    "stiction.mechanics.contact": "Asperities Contacts asperities contacts",
    "stiction.mechanics.friction": "SurfaceValidity Validity",
    "stiction.mechanics.half_space": "HalfSpaceContact HalfSpaceCurve half_space",
    "stiction.mechanics.law": "HertzCylinder HertzSphere JacksonGreen force_and_area",
    "stiction.mechanics.load_curve": "LoadCurve SurfaceLoadCurve press",
    "stiction.mechanics.loading": "approach_at_load",
    "stiction.mechanics.materials": "Material MaterialValue compliance_fraction material materials softer_hardness",
    "stiction.mechanics.model": "ContactModel",
    "stiction.mechanics.onset": "Onset",
    "stiction.mechanics.presliding": "FourParameterIwan LuGre",
    "stiction.mechanics.resolution": "resolution resolution_friction spectral_resolution",
    "stiction.mechanics.shear": "shear_gap",
    "stiction.calibration.calibration": "calibrate",
    "stiction.summary.friction_table": "friction_table table_study",
    "stiction.calibration.friction_tests": "Ball FrictionTest",
    "stiction.calibration.prediction": "Interface interface read_interface",
    "stiction.study.interfaces": "interfaces write_interface",
    "stiction.solve.layout": "nondimensional",
    "stiction.evaluate.maps": "area_map friction_map stiffness_map",
    "stiction.study.members": "pair_of",
    "stiction.result": "Result open_result",
    "stiction.pipeline": "run",
    "stiction.study.study": "Study study_names",
    "stiction.surfaces.cut_off": "cut_off",
    "stiction.surfaces.filters": "filtered",
    "stiction.surfaces.fractal": (
        "random_phases weierstrass_mandelbrot weierstrass_mandelbrot_family weierstrass_mandelbrot_moments "
        "weierstrass_mandelbrot_surface"
    ),
    "stiction.surfaces.hurst": "HurstEstimate estimate_hurst_exponent",
    "stiction.surfaces.joined_spectrum": "JoinedSpectrum joined_spectrum",
    "stiction.surfaces.lines": "LineRoughness line_roughness lines_along_both",
    "stiction.surfaces.material_ratio": "bearing_curve material_ratio",
    "stiction.surfaces.measured.raw": "FormatError FormatWarning",
    "stiction.surfaces.measured.reading": "read_measurement read_profile read_surface",
    "stiction.surfaces.measured.spectrum_file": "read_spectrum write_spectrum",
    "stiction.surfaces.measured.writing": "write_profile write_surface",
    "stiction.surfaces.pairing": "paired_lines",
    "stiction.surfaces.preparation": "cropped flipped levelled on_common_grid rotated",
    "stiction.surfaces.profile": "Profile",
    "stiction.surfaces.repeated_scans": "RepeatedScans compare_repeated_scans",
    "stiction.surfaces.roughness": "RoughnessParameters SurfaceParameters roughness_parameters surface_parameters",
    "stiction.surfaces.scale": "InstrumentLimit ScaleDependentRoughness instrument_limit scale_dependent_roughness",
    "stiction.surfaces.sections": "SectionFilters SectionParameters section_parameters",
    "stiction.surfaces.self_affine": "self_affine self_affine_surface",
    "stiction.surfaces.spectrum": (
        "PowerSpectrum ProfileMoments RadialSpectrum SurfaceSpectrum power_spectrum spectral_moments surface_spectrum"
    ),
    "stiction.surfaces.surface": "Surface",
    "stiction.surfaces.surrogates": "isotropic_spectrum isotropic_surface surrogate",
    "stiction.surfaces.tip": "tip_reconstructed",
    "stiction.views.calibration": "calibration_figure",
    "stiction.direct_shear": "export_shear_test shear_test",
    "stiction.measured_pair": "pair",
}
"""Public names by module, as in the stub file. A module is imported when one of its names is first used."""

_MODULES_BY_PUBLIC_NAME = {name: module for module, names in _PUBLIC_NAMES_BY_MODULE.items() for name in names.split()}

__all__ = sorted(_MODULES_BY_PUBLIC_NAME)


def __getattr__(name: str) -> object:
    # Most commands use none of the package's public names, so `importlib` is imported only on demand.
    from importlib import import_module

    if name not in _MODULES_BY_PUBLIC_NAME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_MODULES_BY_PUBLIC_NAME[name]), name)


def __dir__() -> list[str]:
    return __all__
