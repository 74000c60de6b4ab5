"""Studies of surfaces and by the half-space, from the study file to the figures."""

import json
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
import xarray
from stiction import (
    Study,
    Surface,
    area_map,
    friction_map,
    nondimensional,
    pair_of,
    press,
    random_phases,
    run,
    self_affine_surface,
    stiffness_map,
    weierstrass_mandelbrot_surface,
)
from stiction.mechanics.half_space import half_space
from stiction.mechanics.quantities import AREAL_SUMS, DIRECTED, HALF_SPACE_SUMS, SUMS
from stiction.studies import store
from stiction.studies.study import study_from_text
from stiction.studies.study_text import StudyError
from stiction.views.figures import save_figures

FEW = {
    "surfaces.fractal_dimension": [1.2, 1.5],
    "surfaces.amplitude": ["50 nm", "100 nm"],
    "ensemble.repetitions": 3,
    "friction.mu0": [0.4],
    "friction.tau0": ["0 MPa", "200 MPa"],
    "contact.sliding": ["opposing", "all"],
}
SURFACES = Study().with_changes(
    FEW
    | {
        "surfaces.kind": "surface",
        "surfaces.shape": [24, 32],
        "surfaces.extent": ["1.5 um", "2 um"],
        "surfaces.band_limit": "nyquist",
        "contact.direction": ["+x", 90],
        "contact.approach.count": 5,
    }
)
SELF_AFFINE = SURFACES.with_changes(
    {
        "surfaces.generator": "self-affine",
        "surfaces.shortest_wavelength": "0.25 um",
        "surfaces.amplitude_measure": "Sq",
        "surfaces.amplitude": ["10 nm", "20 nm"],
    }
)
HALF_SPACES = SURFACES.with_changes(
    {
        "contact.mechanics": "half-space",
        "contact.boundary": "periodic",
        "contact.hardness": "1 GPa",
        "contact.compliance_share": 0.3,
        "contact.load": {"start": "0.001 mN", "stop": "0.1 mN", "count": 4},
    }
)
HALF_PLANES = Study().with_changes(
    FEW
    | {
        "surfaces.points": 512,
        "surfaces.extent": "2 um",
        "contact.mechanics": "half-space",
        "contact.load": ["1 uN", "10 uN", "0.1 mN"],
    }
)
STUDIES = {
    "surfaces": SURFACES, "self-affine": SELF_AFFINE, "half-spaces": HALF_SPACES, "half-planes": HALF_PLANES,
}  # fmt: skip


@pytest.fixture(scope="module", params=STUDIES)
def result(request):
    return run(STUDIES[request.param])


def curves_of(study, upper, lower):
    """A curve for each sliding rule, by the functions that a user would call."""
    contact = study.contact
    for rule in contact.rules():
        if contact.mechanics == "asperities":
            yield press(upper, lower, contact.steps(), direction=contact.direction, sliding=rule)
        else:
            yield half_space(
                upper, lower, contact.steps(), boundary=contact.boundary,
                hardness=contact.hardness and float(contact.hardness), compliance_share=contact.compliance_share,
                direction=contact.direction or "+x", sliding=rule,
            )  # fmt: skip


@pytest.mark.parametrize("name", STUDIES)
def test_every_sum_is_that_of_its_pair(name):
    study = STUDIES[name]
    dataset = run(study)
    step = study.contact.step
    for d, a, r in ((0, 1, 0), (1, 0, 2)):
        pair = pair_of(
            study, r, fractal_dimension=dataset["fractal_dimension"].values[d],
            amplitude=dataset["amplitude"].values[a],
        )  # fmt: skip
        here = dataset.isel(fractal_dimension=d, amplitude=a, repetition=r)
        for rule, curve in zip(study.contact.rules(), curves_of(study, *pair), strict=True):
            for each in study.sums():
                directed = each in DIRECTED
                found = here[each].sel(sliding=rule) if directed else here[each]
                assert found.dims == (("direction", step) if directed and "direction" in dataset.dims else (step,))
                assert found.values.tobytes() == getattr(curve, each).tobytes(), each
    assert (dataset["normal_elastic"].values.max(axis=-1) > 0).all()


def test_pairs_are_surfaces_of_their_study():
    for body, side in zip(pair_of(SURFACES, 7, fractal_dimension=1.3, amplitude=0.1), ("upper", "lower"), strict=True):
        alone = weierstrass_mandelbrot_surface(
            random_phases(2016, repetition=7, side=side), 1.3, shape=(24, 32), extent=(1.5, 2.0), band_limit="nyquist"
        ).with_amplitude(0.1)
        assert isinstance(body, Surface)
        assert (body.heights.tobytes(), body.spacing) == (alone.heights.tobytes(), (0.0625, 0.0625))
    _, lower = pair_of(SELF_AFFINE, 7, fractal_dimension=1.3, amplitude=0.02)
    alone = self_affine_surface(
        2016, repetition=7, hurst_exponent=2 - 1.3, rms=1.0, shape=(24, 32), spacing=0.0625, shortest_wavelength=0.25
    ).with_amplitude(0.02, "Sq")
    assert lower.heights.tobytes() == alone.heights.tobytes()


@pytest.mark.parametrize("name", STUDIES)
def test_studies_survive_their_own_text(name):
    study = STUDIES[name]
    assert study_from_text(study.to_toml(), "itself") == study
    assert study_from_text(study.to_toml(), "itself").to_toml() == study.with_changes({}).to_toml() == study.to_toml()


def test_texts_of_profiles_and_asperities_are_what_they_were():
    """So are the stores, which hold the text and its checksum."""
    assert not any(key in Study().to_toml() for key in ("kind", "mechanics", "sliding", "direction =", "boundary"))


def test_another_kind_brings_its_own_defaults():
    there = Study().with_changes({"surfaces.kind": "surface"})
    assert (there.contact.detection, there.contact.curvature) == ("gap-minimum", "signed")
    assert there.surfaces.extents() == (10.0, 10.0)
    assert there.with_changes({"surfaces.kind": "profile"}) == Study()
    assert (
        there.with_changes({"contact.mechanics": "half-space"}).with_changes({"contact.mechanics": "asperities"})
        == there
    )


@pytest.mark.parametrize("name", STUDIES)
def test_stores_hold_and_continue_them(name, tmp_path):
    study = STUDIES[name]
    whole = run(study)
    with ThreadPoolExecutor(2) as pool:
        run(study.with_changes({"ensemble.repetitions": 1}), store=tmp_path / "r.zarr", executor=pool)
        continued = run(study, store=tmp_path / "r.zarr", executor=pool)
    assert continued.identical(whole)
    assert store.read(tmp_path / "r.zarr").identical(whole)
    dims = whole["tangential_elastic"].ndim
    assert (tmp_path / "r.zarr" / "tangential_elastic" / ("c.0.0.2" + (dims - 3) * ".0")).is_file()
    lazy = xarray.open_zarr(tmp_path / "r.zarr", consolidated=False)
    assert np.array_equal(lazy["tangential_elastic"].values, whole["tangential_elastic"].values)
    other = study.with_changes({"contact.sliding": "all"})
    with pytest.raises(store.StoreError, match=r"contact\.sliding = "):
        run(other, store=tmp_path / "r.zarr")


def test_a_damaged_chunk_is_noticed(tmp_path):
    run(SURFACES, store=tmp_path / "r.zarr")
    chunk = tmp_path / "r.zarr" / "lateral_elastic" / "c.0.0.1.0.0.0"
    raw = bytearray(chunk.read_bytes())
    raw[len(raw) // 2] ^= 1
    chunk.write_bytes(raw)
    with pytest.raises(store.StoreError, match=r"lateral_elastic/c\.0\.0\.1\.0\.0\.0"):
        store.read(tmp_path / "r.zarr")
    json.loads((tmp_path / "r.zarr" / "zarr.json").read_text())


def test_maps_have_rules_and_directions_and_are_those_of_each(result):
    elastic = result["normal_elastic"].mean("repetition")
    load = float(elastic.isel({elastic.dims[-1]: -2}).min())
    maps = friction_map(result, [load])
    assert maps.sizes["sliding"] == 2
    for rule in ("opposing", "all"):
        one = result.sel(sliding=rule)
        assert friction_map(one, [load]).equals(maps.sel(sliding=rule))
    assert (maps["status"] == "ok").any()
    assert area_map(result, [load])["contact_area"].dims == maps["friction_coefficient"].dims
    without = nondimensional(maps)["friction_coefficient"]  # by numbers without units along loads and strengths
    assert np.array_equal(without.values, maps["friction_coefficient"].values, equal_nan=True)


def test_friction_at_a_load_of_the_half_space_is_the_ratio_of_means():
    """Without friction in the normal load (mu0 = tau0 = 0) a load of the study is reached exactly at its own step."""
    dataset = run(HALF_SPACES)
    loads = HALF_SPACES.contact.steps()
    maps = friction_map(dataset, loads[1:-1], mu0=[0.0], tau0=[0.0]).squeeze(["mu0", "tau0"])
    expected = dataset["tangential_elastic"].mean("repetition") / dataset["normal_elastic"].mean("repetition")
    # To round-off of the loads; the last one may be missed by that.
    assert np.allclose(
        maps["friction_coefficient"].transpose(*expected.dims).values, expected.values[..., 1:-1], rtol=1e-6, atol=1e-9
    )


def test_stiffness_by_the_half_space_is_that_of_the_approaches():
    dataset = run(HALF_SPACES.with_changes({"contact.sliding": "all", "contact.direction": 90}))
    loads = HALF_SPACES.contact.steps()
    stiffness = stiffness_map(dataset, [loads[1]], mu0=[0.0], tau0=[0.0])["normal_stiffness"].squeeze()
    slopes = np.gradient(dataset["approach"].values, loads, axis=-1, edge_order=2)[..., 1]
    assert np.allclose(stiffness.values, (1 / slopes).mean(axis=-1), rtol=1e-6)
    with pytest.raises(ValueError, match="a free half-plane has no approach"):
        stiffness_map(run(HALF_PLANES), [0.01])


def test_variables_are_those_of_the_mechanics():
    assert set(run(SURFACES).data_vars) == {*SUMS, *AREAL_SUMS}
    assert set(run(HALF_PLANES).data_vars) == set(HALF_SPACE_SUMS)


def test_figures_are_files_for_each_rule_and_direction(tmp_path):
    paths = save_figures(run(SURFACES), tmp_path)
    names = {f"{kind}_{rule}_{angle}.png" for kind in ("friction_mu0_0.4", "area")
             for rule in ("opposing", "all") for angle in (0, 90)}  # fmt: skip
    assert {path.name for path in paths} == names
    assert {path.name for path in save_figures(run(HALF_PLANES), tmp_path)} == {
        f"{kind}_{rule}.png" for kind in ("friction_mu0_0.4", "area") for rule in ("opposing", "all")
    }


@pytest.mark.parametrize(
    ("study", "key", "value", "message"),
    [
        (SURFACES, "surfaces.points", 100, r"surfaces\.points: belongs to profiles, not to Weierstrass"),
        (SURFACES, "surfaces.longest_wavelength", "1 um", r"surfaces\.longest_wavelength: belongs to self-affine"),
        (SELF_AFFINE, "surfaces.gamma", 1.5, r"surfaces\.gamma: belongs to profiles and Weierstrass-M.*, not to self"),
        (Study(), "surfaces.shape", [8, 8], r"surfaces\.shape: belongs to Weierstrass.*, not to profiles"),
        (Study(), "surfaces.kind", "line", r"surfaces\.kind: .*'profile' or 'surface'"),
        (SURFACES, "surfaces.extent", "1 um", r"surfaces\.extent: .*must be two lengths"),
        (SURFACES, "surfaces.extent", ["1 um"], r"surfaces\.extent: must be a length, or of surfaces two"),
        (Study(), "surfaces.extent", ["1 um", "1 um"], r"surfaces\.extent: of profiles must be one length"),
        (SURFACES, "surfaces.shape", [8], r"surfaces\.shape"),
        (SURFACES, "surfaces.shape", [100_000, 100_000], r"surfaces\.shape: must hold at most"),
        (SURFACES, "surfaces.amplitude_measure", "Ra", r"surfaces\.amplitude_measure: .*\"Sa\""),
        (Study(), "surfaces.amplitude_measure", "Sq", r"surfaces\.amplitude_measure: .*\"Rq\""),
        (SELF_AFFINE, "surfaces.convention", "paper", r"surfaces\.convention: .*must be \"classical\""),
        (SELF_AFFINE, "surfaces.longest_wavelength", "3 um", r"surfaces\.longest_wavelength: .*longer side, 2 um"),
        (SELF_AFFINE, "surfaces.shortest_wavelength", "1 nm", r"surfaces\.shortest_wavelength: .*twice the larger"),
        (SURFACES, "contact.detection", "cell", r"contact\.detection must be \"gap-minimum\" on surfaces"),
        (SURFACES, "contact.law", "hertz-cylinder", r"contact\.law must not be HertzCylinder"),
        (SURFACES, "contact.load", ["1 mN"], r"contact\.load: belongs to the half-space, not to asperities"),
        (HALF_SPACES, "contact.law", "hertz-sphere", r"contact\.law: belongs to asperities, not to the half-space"),
        (HALF_SPACES, "contact.approach", ["1 nm"], r"contact\.approach: belongs to asperities"),
        (HALF_SPACES, "contact.boundary", "open", r"contact\.boundary: .*'free' or 'periodic'"),
        (HALF_SPACES, "contact.load", ["1 nm"], r"contact\.load\[0\]: has the unit 'nm'"),
        (HALF_SPACES, "contact.load", ["1 N"], r"contact\.load: must be below hardness times area, 3 mN"),
        (HALF_SPACES, "contact.compliance_share", 1.5, r"contact\.compliance_share"),
        (SURFACES, "contact.direction", ["+x", 360], r"contact\.direction: must have each direction once"),
        (SURFACES, "contact.direction", [], r"contact\.direction: must have from 1"),
        (SURFACES, "contact.direction", "north", r"contact\.direction: must be \"\+x\", \"-x\" or degrees"),
        (SURFACES, "contact.direction", float("nan"), r"contact\.direction: must be"),
        (SURFACES, "contact.shear", "-x", r"contact\.direction: must not be given beside shear"),
        (Study(), "contact.direction", 90, r"contact\.direction: must be \"\+x\" or \"-x\" on profiles, got 90"),
        (SURFACES, "contact.sliding", ["all", "all"], r"contact\.sliding: must have each rule once"),
        (SURFACES, "contact.sliding", "both", r"contact\.sliding: must be \"opposing\" or \"all\""),
        (SURFACES, "figures.draw", ["profiles"], r"figures\.draw: \"profiles\" is of profiles"),
    ],
)
def test_faults_name_their_key(study, key, value, message):
    with pytest.raises(StudyError, match=message) as caught:
        study.with_changes({key: value})
    assert len(str(caught.value)) < 400
