"""Tests that the table of quantities is complete, compared with results of all kinds."""

import math
import re
from pathlib import Path

import numpy as np
import pytest
import stiction
from stiction import Profile, Study, Surface, pair, resolution, run
from stiction._core import contact_statistics
from stiction.evaluate.at_load import at_load
from stiction.mechanics.friction import LOAD_SUM_NAMES, VALIDITY_RATIOS, ContactSums, SurfaceValidity, Validity
from stiction.mechanics.quantities import (
    ADHESION_QUANTITIES,
    HALF_SPACE_SUM_QUANTITIES,
    QUANTITIES,
    QUANTITIES_SUMMED_AT_ZERO_LOAD,
    SUM_QUANTITIES,
    quantity_names_shown_in,
)
from stiction.study.study import parse_study_of_dataset
from stiction.summary.summary import summarize
from stiction.views.rows import summary_table
from support.studies_of_files import pair_study

LOADS = ["20 MPa", "40 MPa"]
PAIR_OPTIONS = {"effective_modulus": "10 GPa", "mu0": 0.2, "tau0": "50 MPa", "onset": 1, "load": LOADS}
NON_QUANTITY_DIMENSIONS = {"statistic", "offset", "shear"}  # these names are dimensions of datasets, not quantities


def rough_heights(shape, seed, rms=0.1):
    coefficients = np.fft.rfftn(np.random.default_rng(seed).standard_normal(shape))
    frequencies = np.meshgrid(*(np.fft.fftfreq(n) for n in shape[:-1]), np.fft.rfftfreq(shape[-1]), indexing="ij")
    radial_frequency = np.sqrt(sum(np.square(frequency) for frequency in frequencies))
    heights = np.fft.irfftn(np.where(radial_frequency < 0.15, coefficients, 0.0), s=shape, axes=range(len(shape)))
    return rms * heights / heights.std()


def create_profiles():
    return tuple(Profile(rough_heights((400,), seed), spacing=0.5) for seed in (1, 2))


def create_surfaces():
    return tuple(Surface(rough_heights((40, 40), seed), spacing=0.5) for seed in (3, 4))


def load_small_study(name, **changes):
    small_changes = {"ensemble.repetitions": 2, "surfaces.fractal_dimension": [1.2, 1.4]}
    return Study.named(name).with_changes(small_changes | changes)


@pytest.fixture(scope="module")
def datasets_by_title(no_contact_pictures):
    """Return datasets of member sums for all kinds of studies, by a title."""
    areal_changes = {"surfaces.shape": [64, 64], "surfaces.extent": ["2 um", "2 um"]}
    half_space = {"shifts": 3, "mechanics": "half-space", "direction": [0, 180]}
    result = {
        "generated": run(load_small_study("quick", **{"surfaces.points": 2000})).dataset,
        "generated areas": run(load_small_study("figure6-areal", **areal_changes)).dataset,
        "generated half-planes": run(load_small_study("figure6-half-plane", **{"surfaces.points": 512})).dataset,
        "generated onset": run(load_small_study("presliding", **{"surfaces.points": 2000})).dataset,
        "lines": pair(*create_profiles(), **PAIR_OPTIONS, mechanics="asperities", offsets=4).dataset,
        "half-planes": pair(
            *create_profiles(), **PAIR_OPTIONS, mechanics="half-space", offsets=4, hardness="1 GPa"
        ).dataset,
        "areas": pair(*create_surfaces(), **PAIR_OPTIONS, mechanics="asperities", shifts=3, direction=[0, 180]).dataset,
        "half-spaces": pair(*create_surfaces(), **PAIR_OPTIONS | {"onset": 0}, **half_space).dataset,
        "adhesion": pair(
            *create_surfaces(),
            **PAIR_OPTIONS | {"onset": 0},
            **half_space,
            work_of_adhesion="50 mJ/m^2",
            adhesion_range="20 nm",
        ).dataset,
    }
    return {name: dataset for name, dataset in result.items() if dataset is not None}


@pytest.fixture(scope="module")
def results_at_loads(datasets_by_title):
    """Evaluate each result at one or two loads within its range."""
    return {name: at_load(result, choose_loads(result)) for name, result in datasets_by_title.items()}


def choose_loads(dataset):
    if "load" in dataset.coords:
        return np.unique(dataset["load"].values)[:2]
    mean_loads = dataset["normal_elastic"].mean("repetition")
    return [float(mean_loads.max()) / 4]


def iterate_variables(datasets):
    for title, dataset in datasets.items():
        for name, item in (*dataset.data_vars.items(), *dataset.coords.items()):
            yield title, str(name), item


def normalize_dims(name, dataset):
    """Return the dimensions of a variable as the table of quantities lists them, without cells and members."""
    omitted_dims = {"fractal_dimension", "amplitude", "cut_off", "repetition", "statistic"}
    renamed_dims = {"approach": "step", "load": "step"}
    return {renamed_dims.get(str(dim), str(dim)) for dim in dataset[name].dims} - omitted_dims


def test_table_of_quantities_contains_every_result_variable_with_its_unit(datasets_by_title, results_at_loads):
    for title, name, item in iterate_variables(
        datasets_by_title | {f"{title} at a load": dataset for title, dataset in results_at_loads.items()}
    ):
        if name not in NON_QUANTITY_DIMENSIONS:
            assert name in QUANTITIES, f"{name} of {title}"
            assert item.attrs.get("units", "") == QUANTITIES[name].unit, f"{name} of {title}"


def test_stored_variables_have_the_dimensions_and_dtypes_listed_in_the_table_of_quantities(datasets_by_title):
    for title, dataset in datasets_by_title.items():
        for name in map(str, dataset.data_vars):
            quantity = QUANTITIES[name]
            listed_dims = {
                item for item in quantity.along if item not in ("sliding", "direction") or item in dataset.dims
            }
            assert normalize_dims(name, dataset) == listed_dims, f"{name} of {title}"
            assert dataset[name].dtype == np.dtype(quantity.dtype), f"{name} of {title}"
            assert quantity.stored, f"{name} of {title}"


def test_variables_at_a_load_have_the_dimensions_listed_in_the_table_of_quantities(results_at_loads):
    for title, dataset in results_at_loads.items():
        for name in map(str, dataset.data_vars):
            if name == "status":
                assert normalize_dims(name, dataset) == normalize_dims("friction_coefficient", dataset)
            else:
                # The mean load depends on the sliding rule, mu0 and tau0, and so do all quantities at this load.
                extra_dims = {"sliding", "mu0", "tau0"} if dataset.attrs["load_definition"] == "mean" else set()
                missing_dimensions = {"sliding", "direction"} - set(dataset.dims)
                assert (
                    normalize_dims(name, dataset) - extra_dims
                    == {*QUANTITIES[name].along} - extra_dims - missing_dimensions
                ), f"{name} of {title}"


def test_intervals_at_a_load_lie_between_the_limits_listed_in_the_table_of_quantities(results_at_loads):
    for title, name, item in iterate_variables(results_at_loads):
        if name in QUANTITIES and "statistic" in item.dims and item.dtype.kind == "f":
            interval_limits, mean = item.sel(statistic=["lower", "upper"]), item.sel(statistic="mean")
            lower_bound, upper_bound = QUANTITIES[name].bounds
            assert not (interval_limits < min(lower_bound, float(mean.min()))).any(), f"{name} of {title}"
            assert not (interval_limits > max(upper_bound, float(mean.max()))).any(), f"{name} of {title}"


def test_variables_of_single_pairs_have_the_units_listed_in_the_table_of_quantities():
    options = {"mu0": 0.2, "effective_modulus": 10.0}
    longer_profile = Profile(rough_heights((600,), 5), spacing=0.5)
    result = {
        "lines": run(pair_study(create_profiles()[0], longer_profile, load=[1e-3], positions=[0.0, 5.0], **options)),
        "areas": run(pair_study(*create_surfaces(), load=[1.0], shifts=2, mechanics="asperities", **options)),
    }
    values = {title: result_at_load.at(per_member=True) for title, result_at_load in result.items()}
    assert "lateral_load" in values["areas"]
    for title, name, item in iterate_variables(values):
        if name not in NON_QUANTITY_DIMENSIONS:
            assert name in QUANTITIES, f"{name} of {title}"
            assert item.attrs.get("units", "") == QUANTITIES[name].unit, f"{name} of {title}"


def test_variables_of_a_resolution_dataset_have_the_units_listed_in_the_table_of_quantities():
    result = resolution(*create_surfaces(), [1.0], mu0=0.2, effective_modulus=10.0, hardness=1.0)
    shared_names = {*map(str, result.data_vars)} & {*QUANTITIES}
    assert {"contact_area", "contact_count", "mean_pressure", "error", *LOAD_SUM_NAMES} <= shared_names
    for name in shared_names:
        assert result[name].attrs["units"] == QUANTITIES[name].unit


def test_table_of_quantities_contains_every_contact_sum_and_validity_indicator():
    assert set(LOAD_SUM_NAMES) < set(SUM_QUANTITIES)
    assert {*SUM_QUANTITIES} == {*ContactSums.__dataclass_fields__}
    profile_indicators = {
        name
        for name, (numerator, denominator) in VALIDITY_RATIOS.items()
        if {numerator, *denominator} <= {*SUM_QUANTITIES}
    }
    assert profile_indicators == {*Validity.__dataclass_fields__}
    assert {*VALIDITY_RATIOS} == {*SurfaceValidity.__dataclass_fields__}
    contact = np.ones(1)
    statistics = contact_statistics(
        contact, contact, contact, np.ones(1, bool), contact, contact, probabilities=contact / 2, max_small_cells=1
    )
    assert {*statistics} <= {name for name, quantity in QUANTITIES.items() if "measured" in quantity.stored}
    assert ADHESION_QUANTITIES[0] == "contact_load"
    assert not {*HALF_SPACE_SUM_QUANTITIES} & {*ADHESION_QUANTITIES}
    assert [QUANTITIES[name].sum_under_load for name in QUANTITIES_SUMMED_AT_ZERO_LOAD] == list(LOAD_SUM_NAMES[3:])


def test_quantities_in_the_table_have_a_label_and_refer_to_existing_quantities():
    for name, quantity in QUANTITIES.items():
        assert quantity.words, name
        assert len(quantity.table_label) <= len(quantity.words), name
        for part in filter(None, (quantity.numerator, *quantity.denominator, quantity.bound_fraction)):
            assert part in QUANTITIES, name
        if quantity.percent:
            assert quantity.unit == "1", name
        assert bool(quantity.denominator) == (quantity.kind == "validity"), name
        if math.isfinite(quantity.bounds[1]):
            assert quantity.unit == "1", name
        assert len(set(quantity.along)) == len(quantity.along), name


def test_csv_columns_are_in_the_order_of_the_table_of_quantities(results_at_loads):
    result = results_at_loads["half-planes"]
    columns = list(summary_table(summarize(result, parse_study_of_dataset(result))).columns)
    shown_names = [
        name for name in quantity_names_shown_in("csv") if name in result and "direction" not in result[name].dims
    ]
    places = [
        next(i for i, column in enumerate(columns) if column.startswith(QUANTITIES[name].table_label))
        for name in shown_names
    ]
    assert places == sorted(places)


def test_modules_do_not_derive_properties_of_quantities_from_quantity_names():
    name_pattern = "share|fraction|count|load|area|pull_off|slipped|stiffness|unloaded|friction|pressure"
    tests = "startswith|endswith|replace|removeprefix|removesuffix"
    pattern = re.compile(
        rf"""["']_?({name_pattern})\w*["'] in (str\()?name\b|\bname\)?\.({tests})\(\(?["']_?({name_pattern})"""
    )
    root = Path(stiction.__file__).parent
    files = [path for path in root.rglob("*.py") if "surfaces" not in path.relative_to(root).parts]
    assert len(files) > 100
    result = {path.name for path in files if pattern.search(path.read_text(encoding="utf-8"))}
    assert result == set()
