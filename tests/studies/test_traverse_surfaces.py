import numpy as np
import pytest
from stiction import Surface, press, traverse
from support.rough_surfaces import rough_maps

CHOICES = {
    "hurst_exponent": 0.8, "rms": 0.03, "shape": (64, 80), "spacing": (0.05, 0.04), "shortest_wavelength": 0.4,
}  # fmt: skip


def pair():
    return rough_maps(**CHOICES)


def test_traverse_of_surfaces_equals_press_of_overlap():
    upper, lower = pair()
    offsets = [(0.0, 0.0), (0.8, -0.5), (-0.4, 1.0)]
    result = traverse(upper, lower, [0.02, 0.1], mu0=0.3, offsets=offsets, direction=[0, 45], load="elastic")
    assert dict(result.sizes) == {"direction": 2, "offset": 3, "load": 2}
    assert result["x"].values.tolist() == [0.0, 0.8, -0.4]
    assert np.allclose(result["nominal_area"], [3.2**2, 2.4 * 2.7, 2.8 * 2.2])
    # Moved by 20 columns to the right and 10 rows down.
    above, below = (
        Surface(upper.heights[10:, :60], spacing=upper.spacing),
        Surface(lower.heights[:54, 20:], spacing=lower.spacing),
    )
    for d, angle in enumerate((0, 45)):
        for k, load in enumerate((0.02, 0.1)):
            at = result.isel(direction=d, offset=1, load=k)
            assert at["status"] == "ok"
            curve = press(above, below, [float(at["approach"])], direction=angle)
            assert curve.normal_elastic[0] == pytest.approx(load, rel=1e-9)
            assert curve.friction_coefficient(mu0=0.3)[0] == pytest.approx(float(at["friction_coefficient"]), rel=1e-12)
            assert curve.lateral_load(mu0=0.3)[0] == pytest.approx(float(at["lateral_load"]), rel=1e-12)


def test_traverse_of_surfaces_has_four_directions_and_stores_the_rule():
    result = traverse(*pair(), 0.05, mu0=0.3, sliding="all")
    assert result["direction"].values.tolist() == [0, 90, 180, 270]
    assert result.attrs["sliding"] == "all"
    assert result.sizes["offset"] == 1


@pytest.mark.parametrize(
    ("changes", "match"),
    [
        ({"offsets": [(2.6, 0.0)]}, "at least 16 rows and columns"),
        ({"offsets": [1.0, 2.0, 3.0]}, "offsets"),
        ({"offsets": [(1e300, 0.0)]}, "offsets"),
        ({"direction": "north"}, "direction"),
        ({"detection": "cell"}, "detection"),
    ],
)
def test_traverse_of_surfaces_rejects_bad_arguments(changes, match):
    with pytest.raises(ValueError, match=match):
        traverse(*pair(), **({"loads": 0.1, "mu0": 0.3} | changes))


def test_traverse_rejects_surface_on_profile():
    upper, lower = pair()
    with pytest.raises(ValueError, match="both"):
        traverse(upper, lower.row(0), 0.1, mu0=0.3)
