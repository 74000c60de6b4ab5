"""Whatever is made of a result is made of pieces of it, one in memory at a time."""

import shutil
import types

import numpy as np
import pytest
import stiction.studies.export as exports
import xarray
from reference.at_loads import at_load
from stiction import Study, area_map, friction_map, run, stiffness_map
from stiction.studies import claims, intervals, layout, lazy, maps, store, streams
from stiction.studies.export import ExportError, export
from stiction.views.figures import reached_loads, save_figures
from stiction.views.report import report_page
from stiction.views.report import study as study_page

CLOSE = 1e-12
"""Round-off of sums in another order."""

ENDS = 1e-9
"""Of the ends of an interval, beside the mean: a leave-one-out mean taken literally loses digits in the difference."""


def samples():
    """Normal loads and values (r, k) of every kind that the interval tells apart."""
    random = np.random.default_rng(5)
    for count, steps in ((2, 3), (3, 12), (7, 1), (40, 15), (200, 15)):
        rising = np.cumsum(random.lognormal(0, 1, (count, steps)), axis=1)
        yield rising, rising * random.uniform(0.2, 1, (count, 1))
        yield rising, rising**0.7 * random.lognormal(0, 1, (count, steps))
        yield rising, -rising * random.uniform(0.5, 1, (count, 1))
        yield rising, random.normal(0, 1, (count, steps))
        yield rising, np.zeros((count, steps))
        yield rising, np.ones((count, steps))
        few = rising * (random.random((count, 1)) < 0.3)
        yield few, few * random.uniform(0.2, 1, (count, 1))
        one = rising * (np.arange(count) == 1)[:, np.newaxis]
        yield one, one * 0.3


@pytest.mark.parametrize("size", [1, 3, 1000])
def test_a_jackknife_in_pieces_is_that_which_leaves_each_out(size):
    for normal, values in samples():
        curve = normal.mean(axis=0)
        loads = np.unique(np.concatenate([np.linspace(0.3, 1.2, 7) * curve.max(), curve[:2]]))
        loads = loads[loads > 0]
        if not loads.size:
            continue
        # Two curves at a time, of which the first carries nothing.
        both = [np.stack([np.zeros_like(each), each]) for each in (normal, values)]
        found = intervals.AtLoads(*(each.mean(axis=1) for each in both), normal.shape[0], loads)
        for first in range(0, normal.shape[0], size):
            found.add(*(each[:, first : first + size].transpose(0, 2, 1) for each in both))
        assert np.isnan(found.mean[0]).all()
        lower, upper = (each[1] for each in found.interval())
        for index, load in enumerate(loads):
            mean, low, high = at_load(normal, values, load)
            assert found.mean[1, index] == pytest.approx(mean, rel=CLOSE, nan_ok=True)
            tolerance = ENDS * max(abs(mean), np.abs(values).max()) if np.isfinite(mean) else 0
            assert lower[index] == pytest.approx(low, rel=ENDS, abs=tolerance, nan_ok=True)
            assert upper[index] == pytest.approx(high, rel=ENDS, abs=tolerance, nan_ok=True)


# ---- Results that are not in memory ---------------------------------------------------------------------------------

STUDY = Study().with_changes(
    {
        "surfaces.fractal_dimension": {"start": 1.0, "stop": 1.7, "count": 3},
        "surfaces.points": 300,
        "surfaces.extent": "2 um",
        "surfaces.directions": 4,
        "surfaces.frequencies": 6,
        "contact.approach.count": 5,
        "ensemble.repetitions": 37,
        "friction.mu0": [0.1, 0.4],
    }
)
MAPS = (friction_map, area_map, stiffness_map)


@pytest.fixture(scope="module")
def whole():
    return run(STUDY)


@pytest.fixture
def stored(tmp_path, whole, monkeypatch):
    """The same, left on the disk in chunks of four, of which pieces of eight come at a time; and what was read."""
    monkeypatch.setattr(layout, "FEWEST_BLOCKS", 9)
    monkeypatch.setattr(lazy, "MOST_LOADED", 0)
    monkeypatch.setattr(streams, "PIECE", 8 * whole.nbytes // 37)
    result = run(STUDY, store=tmp_path / "r.zarr")
    assert streams.repetitions_of_piece(result) == 8
    return result


def test_a_stored_result_is_read_when_it_is_asked_for(stored, whole):
    assert not isinstance(stored["contact_area"].variable._data, np.ndarray)
    for key in (
        {"repetition": slice(3, 30, 7)}, {"repetition": [5, 1, 36]}, {"repetition": 7}, {"repetition": slice(0)},
        {"amplitude": 0, "repetition": slice(9)}, {"approach": [0, 2], "repetition": -1}, {"fractal_dimension": 1},
        {"fractal_dimension": [2, 0], "approach": slice(None, None, -1)},
    ):  # fmt: skip
        xarray.testing.assert_identical(stored.isel(key).load(), whole.isel(key))
    xarray.testing.assert_identical(stored.transpose("repetition", ...).load(), whole.transpose("repetition", ...))


def test_damage_is_noticed_when_it_is_read(tmp_path, stored):
    (tmp_path / "r.zarr" / "contact_area" / "c.0.0.5.0").write_bytes(b"junk")
    loads = reached_loads(stored, 3)
    with pytest.raises(store.StoreError, match=r"is damaged: contact_area/c\.0\.0\.5\.0"):
        area_map(stored, loads)


@pytest.mark.parametrize("quantity", MAPS)
def test_maps_of_what_is_stored_are_those_in_memory(stored, whole, quantity, monkeypatch):
    loads = reached_loads(whole, 6)
    found = quantity(stored, loads)
    xarray.testing.assert_identical(found, quantity(whole, loads))  # the same pieces, so the same bits
    monkeypatch.undo()  # all in one piece
    xarray.testing.assert_allclose(found, quantity(whole, loads), rtol=CLOSE, atol=0)
    assert found["lower"].notnull().any()
    monkeypatch.setattr(maps, "AT_ONCE", 1)  # or one repetition at a time
    xarray.testing.assert_allclose(found, quantity(whole, loads), rtol=CLOSE, atol=0)
    assert quantity(whole, loads, mu0=[])["status"].size == 0


def test_nothing_holds_all_repetitions(stored, tmp_path, monkeypatch):
    """Whatever is made of a stored result, a piece is read at a time."""
    read = []
    of_store = lazy.Stored.__getitem__
    monkeypatch.setattr(lazy.Stored, "__getitem__", lambda self, key: read.append(out := of_store(self, key)) or out)
    monkeypatch.setattr(study_page, "MOST_SUMS", 0)
    loads = reached_loads(stored, 4)
    for quantity in MAPS:
        quantity(stored, loads)
    save_figures(stored, tmp_path)
    report_page(stored)
    export(stored, tmp_path / "r.nc")
    assert max(each.shape[2] for each in read) == 8


def test_a_page_and_claims_of_what_is_stored_are_those_in_memory(stored, whole):
    one, other = report_page(stored), report_page(whole)
    assert one == other
    means = streams.means(stored)
    for name in means:
        assert np.allclose(means[name], whole[name].mean("repetition"), rtol=CLOSE, atol=0)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(claims, "check", lambda _: None)
        patch.setattr(claims, "RESAMPLES", 30)
        found, wanted = claims.Resampled(stored, 0.1), claims.Resampled(whole, 0.1)
    random = np.random.default_rng(STUDY.ensemble.seed)
    weights = np.vstack([np.ones(37), random.multinomial(37, np.full(37, 1 / 37), 30)]) / 37
    for name in ("normal_elastic", "contact_area"):
        assert np.array_equal(found.sums(name, 0.1), wanted.sums(name, 0.1))
        of_all = np.einsum("sr,drk->sdk", weights, whole[name].values[:, 0])
        assert np.allclose(found.sums(name, 0.1), of_all, rtol=CLOSE, atol=0)


@pytest.mark.parametrize("most", [0, 2**27])
def test_what_is_stored_is_exported_to_the_bit(stored, whole, tmp_path, monkeypatch, most):
    monkeypatch.setattr(exports, "MOST_IN_MEMORY", most)
    export(stored, tmp_path / "r.nc")
    with xarray.open_dataset(tmp_path / "r.nc", engine="h5netcdf") as exported:
        xarray.testing.assert_identical(exported.load(), whole)
    for name in whole.variables:
        assert exported[name].values.tobytes() == whole[name].values.tobytes()
    monkeypatch.setattr(shutil, "disk_usage", lambda _: types.SimpleNamespace(free=100))
    if most == 0:
        with pytest.raises(ExportError, match=r"cannot be written: No space left on device"):
            export(stored, tmp_path / "no.nc")
        assert not (tmp_path / "no.nc").exists()


@pytest.mark.parametrize("quantity", MAPS)
def test_a_map_of_motions_is_that_of_each(quantity):
    study = Study.named("figure6-areal").with_changes(
        {"surfaces.shape": [32, 32], "ensemble.repetitions": 3, "surfaces.fractal_dimension": [1.2, 1.5],
         "contact.direction": [0, 90], "contact.approach.count": 5}
    )  # fmt: skip
    result = run(study)
    loads = reached_loads(result, 4)
    whole = quantity(result, loads, mu0=[0.1, 0.4, 2.0], tau0=[0.0, 0.1])
    assert (whole["status"] == "ok").any()
    for rule in range(2):
        for direction in range(2):
            one = {"sliding": rule, "direction": direction}
            found = quantity(result.isel(one), loads, mu0=[0.1, 0.4, 2.0], tau0=[0.0, 0.1])
            xarray.testing.assert_identical(found, whole.isel(one))
            for name in ("mu0", "tau0"):
                alone = quantity(result.isel(one), loads, mu0=[0.1, 0.4, 2.0], tau0=[0.0, 0.1]).isel({name: [1]})
                values = {"mu0": [0.1, 0.4, 2.0], "tau0": [0.0, 0.1]} | {name: found[name].values[1:2]}
                xarray.testing.assert_allclose(quantity(result.isel(one), loads, **values), alone, rtol=CLOSE, atol=0)


def test_maps_of_loads_and_motions_are_in_pieces_as_well(monkeypatch, tmp_path):
    study = Study.named("figure6-half-plane").with_changes(
        {"surfaces.points": 64, "surfaces.fractal_dimension": [1.2], "ensemble.repetitions": 5, "contact.load.count": 4,
         "contact.boundary": "periodic"}
    )  # fmt: skip
    result = run(study)
    wanted = [quantity(result, [0.02, 0.05]) for quantity in MAPS]
    monkeypatch.setattr(lazy, "MOST_LOADED", 0)
    monkeypatch.setattr(streams, "PIECE", 0)
    stored = run(study, store=tmp_path / "r.zarr")
    for quantity, want in zip(MAPS, wanted, strict=True):
        xarray.testing.assert_allclose(quantity(stored, [0.02, 0.05]), want, rtol=CLOSE, atol=0)
