"""Tests of the script of docs/explanation/experiments.md with generated surfaces, and with measured data if present."""

import os
import runpy
from pathlib import Path

import numpy as np
import pytest
from stiction import Surface, self_affine_surface

pytestmark = pytest.mark.docs
FRACTURES_NAMESPACE = runpy.run_path(str(Path(__file__).parents[1] / "docs/scripts/fractures.py"))
DATA_DIRECTORY = os.environ.get("STICTION_FRACTURES")
EXPONENT_TOLERANCE = 0.15
DOCUMENTED_STIFFNESS = {
    "vd1": ((37, 116), (48, 122)),
    "vd2": ((25, 127), (50, 131)),
}  # computed and measured stiffness in MPa/mm, from 1 to 2 MPa and from 5 to 10 MPa


def test_fracture_script_reads_the_gap_and_shear_test_files_of_the_experiment(tmp_path):
    spacing = 2000.0
    heights = np.add.outer(np.arange(64.0), np.arange(64.0))
    np.savez(tmp_path / "a.npz", gap_um=heights, spacing_um=spacing)
    (tmp_path / "a-closure.csv").write_text("Number,Disp,sigmaZ\n[-],[mm],[MPa]\n1,0,1\n2,0.1,3\n3,0.02,1\n")
    square, disc = (FRACTURES_NAMESPACE["read_gap"](tmp_path, "a", square=square) for square in (True, False))
    assert np.hypot(*square.extent) <= FRACTURES_NAMESPACE["DISC_DIAMETER"] < np.hypot(*square.extent) + 3 * spacing
    assert (~disc.missing).sum() * spacing**2 == pytest.approx(
        np.pi / 4 * FRACTURES_NAMESPACE["DISC_DIAMETER"] ** 2, rel=0.02
    )
    (load, stress), (unloading_displacement, unloading_stress) = FRACTURES_NAMESPACE["read_load_test"](tmp_path, "a")
    assert FRACTURES_NAMESPACE["secant_stiffness"](load, stress, (1.0, 3.0)) == pytest.approx(20)
    assert [*unloading_displacement, *unloading_stress] == [0.1, 0.02, 3, 1]


@pytest.mark.parametrize("hurst", [0.5, 0.9])
def test_random_roughness_has_the_spectrum_estimated_from_the_scan(hurst):
    gap = self_affine_surface(1, hurst_exponent=hurst, rms=20.0, shape=(256, 256), spacing=250.0)
    result, density = FRACTURES_NAMESPACE["estimate_spectrum"](gap)
    assert result == pytest.approx(hurst, abs=EXPONENT_TOLERANCE)
    wave, heights = 1 / 800.0, FRACTURES_NAMESPACE["generate_random_heights"]((256, 256), 250.0, density, 10e3, 1)
    estimated_density = FRACTURES_NAMESPACE["estimate_spectrum"](Surface(heights, spacing=250.0))[1]
    assert estimated_density(wave) == pytest.approx(density(wave), rel=0.3)


@pytest.mark.skipif(
    DATA_DIRECTORY is None, reason="the measured data are not available; STICTION_FRACTURES may name their directory"
)
@pytest.mark.parametrize("name", list(DOCUMENTED_STIFFNESS))
def test_experiment_script_with_fixed_settings_reproduces_the_documented_numbers(name):
    directory, steps = Path(DATA_DIRECTORY), np.array([1.0, 2.0, 5.0, 10.0])
    closure, _ = FRACTURES_NAMESPACE["compute_closure"](FRACTURES_NAMESPACE["read_gap"](directory, name), steps)
    (load, stress), _ = FRACTURES_NAMESPACE["read_load_test"](directory, name)
    for expected, (closures, stresses) in zip(
        DOCUMENTED_STIFFNESS[name], ((closure, steps), (load, stress)), strict=True
    ):
        result = [
            FRACTURES_NAMESPACE["secant_stiffness"](closures, stresses, stress_range)
            for stress_range in (FRACTURES_NAMESPACE["LOW_STRESS_RANGE"], FRACTURES_NAMESPACE["HIGH_STRESS_RANGE"])
        ]
        assert result == pytest.approx(expected, abs=1)
