"""stiction: the coefficient of static friction of rough surfaces, from their shape.

Lengths are in µm, forces in mN, pressures in GPa (1 GPa = 1 mN/µm²); angles in rad.
"""

from stiction._core import __version__
from stiction.mechanics.asperity import Asperities, asperities
from stiction.mechanics.contact import Contacts, LoadCurve, contacts, press
from stiction.studies.ensemble import friction_map
from stiction.studies.runner import run
from stiction.studies.study import Study, study_names
from stiction.surfaces.fractal import random_phases, weierstrass_mandelbrot, weierstrass_mandelbrot_family
from stiction.surfaces.profile import Profile

__all__ = [
    "Asperities",
    "Contacts",
    "LoadCurve",
    "Profile",
    "Study",
    "__version__",
    "asperities",
    "contacts",
    "friction_map",
    "press",
    "random_phases",
    "run",
    "study_names",
    "weierstrass_mandelbrot",
    "weierstrass_mandelbrot_family",
]
