from stiction._core import __version__ as __version__
from stiction.calibration.calibration import calibrate as calibrate
from stiction.calibration.friction_tests import Ball as Ball, FrictionTest as FrictionTest
from stiction.calibration.prediction import (
    Interface as Interface,
    interface as interface,
    read_interface as read_interface,
)
from stiction.summary.friction_table import friction_table as friction_table, table_study as table_study
from stiction.evaluate.maps import area_map as area_map, friction_map as friction_map, stiffness_map as stiffness_map
from stiction.direct_shear import export_shear_test as export_shear_test, shear_test as shear_test
from stiction.measured_pair import pair as pair
from stiction.mechanics.candidates import Candidates as Candidates, candidates as candidates
from stiction.mechanics.closed_forms import (
    dmt as dmt,
    effective_modulus as effective_modulus,
    fuller_tabor as fuller_tabor,
    gentle_friction as gentle_friction,
    hardness_under_shear as hardness_under_shear,
    hertz_cylinder as hertz_cylinder,
    hertz_ellipse as hertz_ellipse,
    hertz_line as hertz_line,
    hertz_sphere as hertz_sphere,
    jkr as jkr,
    maugis_dugdale as maugis_dugdale,
    slope_friction as slope_friction,
    tabor_friction as tabor_friction,
    tabor_parameter as tabor_parameter,
    westergaard_contact_fraction as westergaard_contact_fraction,
    westergaard_gap as westergaard_gap,
    westergaard_pressure as westergaard_pressure,
)
from stiction.mechanics.contact import (
    Asperities as Asperities,
    Contacts as Contacts,
    asperities as asperities,
    contacts as contacts,
)
from stiction.mechanics.friction import SurfaceValidity as SurfaceValidity, Validity as Validity
from stiction.mechanics.half_space import (
    HalfSpaceContact as HalfSpaceContact,
    HalfSpaceCurve as HalfSpaceCurve,
    half_space as half_space,
)
from stiction.mechanics.law import (
    HertzCylinder as HertzCylinder,
    HertzSphere as HertzSphere,
    JacksonGreen as JacksonGreen,
    force_and_area as force_and_area,
)
from stiction.mechanics.load_curve import LoadCurve as LoadCurve, SurfaceLoadCurve as SurfaceLoadCurve, press as press
from stiction.mechanics.loading import approach_at_load as approach_at_load
from stiction.mechanics.materials import (
    Material as Material,
    MaterialValue as MaterialValue,
    compliance_fraction as compliance_fraction,
    material as material,
    materials as materials,
    softer_hardness as softer_hardness,
)
from stiction.mechanics.model import ContactModel as ContactModel
from stiction.mechanics.onset import Onset as Onset
from stiction.mechanics.presliding import FourParameterIwan as FourParameterIwan, LuGre as LuGre
from stiction.mechanics.resolution import (
    resolution as resolution,
    resolution_friction as resolution_friction,
    spectral_resolution as spectral_resolution,
)
from stiction.mechanics.shear import shear_gap as shear_gap
from stiction.pipeline import run as run
from stiction.result import Result as Result, open_result as open_result
from stiction.solve.layout import nondimensional as nondimensional
from stiction.study.interfaces import interfaces as interfaces, write_interface as write_interface
from stiction.study.members import pair_of as pair_of
from stiction.study.study import Study as Study, study_names as study_names
from stiction.surfaces.cut_off import cut_off as cut_off
from stiction.surfaces.filters import filtered as filtered
from stiction.surfaces.fractal import (
    random_phases as random_phases,
    weierstrass_mandelbrot as weierstrass_mandelbrot,
    weierstrass_mandelbrot_family as weierstrass_mandelbrot_family,
    weierstrass_mandelbrot_moments as weierstrass_mandelbrot_moments,
    weierstrass_mandelbrot_surface as weierstrass_mandelbrot_surface,
)
from stiction.surfaces.hurst import HurstEstimate as HurstEstimate, estimate_hurst_exponent as estimate_hurst_exponent
from stiction.surfaces.joined_spectrum import JoinedSpectrum as JoinedSpectrum, joined_spectrum as joined_spectrum
from stiction.surfaces.lines import (
    LineRoughness as LineRoughness,
    line_roughness as line_roughness,
    lines_along_both as lines_along_both,
)
from stiction.surfaces.material_ratio import bearing_curve as bearing_curve, material_ratio as material_ratio
from stiction.surfaces.measured.raw import FormatError as FormatError, FormatWarning as FormatWarning
from stiction.surfaces.measured.reading import (
    read_measurement as read_measurement,
    read_profile as read_profile,
    read_surface as read_surface,
)
from stiction.surfaces.measured.spectrum_file import read_spectrum as read_spectrum, write_spectrum as write_spectrum
from stiction.surfaces.measured.writing import write_profile as write_profile, write_surface as write_surface
from stiction.surfaces.pairing import paired_lines as paired_lines
from stiction.surfaces.preparation import (
    cropped as cropped,
    flipped as flipped,
    levelled as levelled,
    on_common_grid as on_common_grid,
    rotated as rotated,
)
from stiction.surfaces.profile import Profile as Profile
from stiction.surfaces.repeated_scans import (
    RepeatedScans as RepeatedScans,
    compare_repeated_scans as compare_repeated_scans,
)
from stiction.surfaces.roughness import (
    RoughnessParameters as RoughnessParameters,
    SurfaceParameters as SurfaceParameters,
    roughness_parameters as roughness_parameters,
    surface_parameters as surface_parameters,
)
from stiction.surfaces.scale import (
    InstrumentLimit as InstrumentLimit,
    ScaleDependentRoughness as ScaleDependentRoughness,
    instrument_limit as instrument_limit,
    scale_dependent_roughness as scale_dependent_roughness,
)
from stiction.surfaces.sections import (
    SectionFilters as SectionFilters,
    SectionParameters as SectionParameters,
    section_parameters as section_parameters,
)
from stiction.surfaces.self_affine import self_affine as self_affine, self_affine_surface as self_affine_surface
from stiction.surfaces.spectrum import (
    PowerSpectrum as PowerSpectrum,
    ProfileMoments as ProfileMoments,
    RadialSpectrum as RadialSpectrum,
    SurfaceSpectrum as SurfaceSpectrum,
    power_spectrum as power_spectrum,
    spectral_moments as spectral_moments,
    surface_spectrum as surface_spectrum,
)
from stiction.surfaces.surface import Surface as Surface
from stiction.surfaces.surrogates import (
    isotropic_spectrum as isotropic_spectrum,
    isotropic_surface as isotropic_surface,
    surrogate as surrogate,
)
from stiction.surfaces.tip import tip_reconstructed as tip_reconstructed
from stiction.views.calibration import calibration_figure as calibration_figure
