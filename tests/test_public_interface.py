"""Test the public interface: examples, signatures, reprs, conversions, and `pair` against the command."""

import copy
import doctest
import inspect
import re
import warnings

import numpy as np
import pytest
import stiction
import xarray
from matplotlib.figure import Figure
from stiction import (
    Profile,
    Surface,
    candidates,
    contacts,
    flipped,
    half_space,
    open_result,
    pair,
    power_spectrum,
    press,
    read_surface,
    roughness_parameters,
    self_affine_surface,
    surface_parameters,
    surface_spectrum,
    write_surface,
)
from stiction.companions.contact_picture import contact_picture
from stiction.evaluate.at_load import at_load
from stiction.evaluate.member_values import member_values
from stiction.mechanics.quantities import QUANTITIES
from stiction.views.rows import point_record
from support.command import call_stiction, check_stiction
from support.studies_of_files import pair_study

PUBLIC_NAMES = [name for name in stiction.__all__ if name != "__version__"]
PUBLIC_EXCEPTIONS = [
    name for name in PUBLIC_NAMES if inspect.isclass(value := getattr(stiction, name)) and issubclass(value, Exception)
]

MAX_REPR_LENGTH = 2000  # characters


def create_surface(side, points=48):
    return self_affine_surface(
        3, hurst_exponent=0.8, rms=0.02, shape=(points, points + 8), spacing=(0.1, 0.2), shortest_wavelength=0.6,
        side=side,
    )  # fmt: skip


@pytest.fixture(scope="module")
def upper():
    return create_surface("upper")


@pytest.fixture(scope="module")
def lower():
    return create_surface("lower")


@pytest.fixture(scope="module")
def curve(upper, lower):
    return half_space(upper, lower, ["1 mN", "3 mN"], direction=[0, 90])


# ---- Every public name -----------------------------------------------------------------------------------------------


def parse_examples(name):
    value = getattr(stiction, name)
    return doctest.DocTestParser().get_doctest(inspect.getdoc(value) or "", {}, name, None, None)


def test_public_names_have_examples_and_full_signatures():
    for name in PUBLIC_NAMES:
        if name not in PUBLIC_EXCEPTIONS:
            assert parse_examples(name).examples, name
            kinds = {item.kind for item in inspect.signature(getattr(stiction, name)).parameters.values()}
            assert not kinds & {inspect.Parameter.VAR_KEYWORD, inspect.Parameter.VAR_POSITIONAL}, name


def test_press_function_and_contacts_function_accept_every_argument_in_their_signature(upper, lower):
    for call, approach in ((press, [0.01]), (contacts, 0.01)):
        parameters = inspect.signature(call).parameters
        arguments = {
            parameter_name: parameter.default
            for parameter_name, parameter in parameters.items()
            if parameter.kind is parameter.KEYWORD_ONLY
        }
        call(upper, lower, approach, **arguments | {"model": stiction.ContactModel()})


UNITS_BY_NAME = {
    **dict.fromkeys(("tau0", "effective_modulus", "hardness", "pressure"), "GPa"),
    **dict.fromkeys(("loads", "normal_load", "sliding_load", "force"), "mN"),
    **dict.fromkeys(
        ("approach", "approaches", "spacing", "heights", "extent", "longest_wavelength", "shortest_wavelength", "rms",
         "cut_offs", "overlap", "radius", "offsets", "displacement", "deepest"), "µm",
    ),
    **dict.fromkeys(("contact_area", "area"), "µm²"), "stiffness": "mN/µm", "angles": "degrees",
}  # fmt: skip
"""Units of arguments and attributes whose names stand for the same quantity everywhere."""


def test_docstrings_state_the_units_of_numbers():
    text = "\n".join(inspect.getdoc(getattr(stiction, name)) or "" for name in PUBLIC_NAMES)
    for names, kind in re.findall(r"^ *([a-z]\w*(?:, \w+)*) : (.*)$", text, re.MULTILINE):
        for parameter_name in names.split(", "):
            if parameter_name in UNITS_BY_NAME and re.search(r"\b(float|ndarray|array_like)\b", kind):
                assert re.search(rf"\b{UNITS_BY_NAME[parameter_name]}(\W|$)", kind), f"{parameter_name} : {kind}"


CLASSES_WITH_GENERATED_REPR = {
    "Ball",
    "ContactModel",
    "FrictionTest",
    "HertzCylinder",
    "HertzSphere",
    "JacksonGreen",
    "Material",
}
"""Classes whose repr is the call that creates the object, or lists the sources of its values."""


def test_public_classes_define_their_own_repr():
    for name in PUBLIC_NAMES:
        if inspect.isclass(public_class := getattr(stiction, name)):
            dataclass_options = getattr(public_class, "__dataclass_params__", None)
            has_generated_repr = (
                dataclass_options is not None and dataclass_options.repr and public_class.__repr__.__doc__ is None
            )  # a `__repr__` that the package itself defines has a docstring
            assert public_class.__repr__ is not object.__repr__ or name in PUBLIC_EXCEPTIONS, name
            assert not has_generated_repr or name in CLASSES_WITH_GENERATED_REPR, name


def test_dir_function_lists_only_public_names_of_the_package():
    assert set(dir(stiction)) >= set(stiction.__all__)
    assert [name for name in dir(stiction) if name not in stiction.__all__ and not name.startswith("__")] == []


# ---- Representations ------------------------------------------------------------------------------------------------


def displayed_objects(upper, lower, curve):
    row, result = lower.row(0), press(upper, lower, [0.01, 0.02, 0.04])
    yield from (upper, row, power_spectrum(row), surface_parameters(lower), roughness_parameters(row))
    yield from (curve, curve.contact(1), curve.onset(1, mu0=0.3), result)
    line = half_space(levelled_row(upper), levelled_row(lower), [0.05, 0.1])
    yield from (line, line.contact(0), line.onset(0, mu0=0.3))


def levelled_row(body):
    return stiction.levelled(body.row(3), "line")


def objects_with_repr(upper, lower):
    result = press(upper, lower, [0.02])
    spectrum = surface_spectrum(lower)
    yield from (result.validity, contacts(upper, lower, 0.02), candidates(upper, lower, deepest=0.02))
    yield from (spectrum, spectrum.radial(), stiction.asperities(lower.row(0), "lower"))
    yield from (stiction.line_roughness(lower, "x"), stiction.scale_dependent_roughness(lower))
    yield from (stiction.material("brass"), stiction.ContactModel(), stiction.Study.named("quick"))


def test_reprs_of_public_objects_are_short_and_contain_no_arrays(upper, lower, curve):
    for item in (*displayed_objects(upper, lower, curve), *objects_with_repr(upper, lower)):
        text = repr(item)
        assert len(text) <= MAX_REPR_LENGTH
        assert "array(" not in text
        assert " object at 0x" not in text
        assert type(item).__name__ in text


def test_reprs_of_public_objects_contain_units(upper, lower, curve):
    assert "0.2 µm apart along x and 0.1 µm along y" in repr(upper)
    assert re.search(r"load +1, 3 mN\n", repr(curve))
    assert re.search(r"density +28: .* µm³\n", repr(power_spectrum(lower.row(0))))
    assert re.search(r"lateral_adhesive .* mN per GPa of tau0\n", repr(press(upper, lower, [0.01, 0.02])))
    assert re.search(r"Sq +20 nm\n", repr(surface_parameters(lower)))
    assert re.search(r"levelled +no$", repr(surface_parameters(lower)))
    assert re.search(r"levelled +by a plane$", repr(surface_parameters(stiction.levelled(lower, "plane"))))


def test_html_representation_of_a_result_contains_a_figure_or_table(upper, lower, curve):
    for item in displayed_objects(upper, lower, curve):
        html_text = item._repr_html_()
        assert '<img alt="Plot' in html_text or "<table" in html_text
        assert "<pre " not in html_text or '<pre tabindex="0" ' in html_text
        if hasattr(item, "plot"):
            ax = Figure().subplots()
            assert item.plot(ax) is ax
            assert ax.get_xlabel() or not ax.get_xticks().size


def test_plot_of_a_load_curve_shows_friction_coefficients(curve):
    ax = curve.plot(Figure().subplots(), mu0=[0.1, 0.3], tau0=0.05)
    drawn_coefficients = np.array([line.get_ydata() for line in ax.get_lines()])
    np.testing.assert_array_equal(
        drawn_coefficients, curve.friction_coefficient(mu0=[0.1, 0.3], tau0=0.05).reshape(-1, 2)
    )
    assert ax.get_legend().get_texts()[0].get_text() == "μ0 = 0.1, τ0 = 50 MPa, 0°"


def test_plot_method_rejects_a_spectrum_of_zeros():
    zero_spectrum = power_spectrum(Profile(np.zeros(16), spacing=1.0))
    with pytest.raises(ValueError, match="must not be 0 everywhere"):
        zero_spectrum.plot(Figure().subplots())
    assert "nothing to draw" in zero_spectrum._repr_html_()


# ---- From and to other libraries -------------------------------------------------------------------------------------


def test_surface_is_unchanged_by_an_xarray_round_trip(lower):
    flipped_surface = flipped(lower)
    for body in (flipped_surface, flipped_surface.row(3)):
        array = body.to_xarray()
        assert array.attrs["units"] == array["x"].attrs["units"] == "um"
        restored_body = type(body).from_(array)
        np.testing.assert_array_equal(restored_body.heights, body.heights)
        assert (restored_body.spacing, restored_body.history) == (body.spacing, body.history)


XARRAY_METHODS = {name for kind in (xarray.Dataset, xarray.DataArray) for name in dir(kind) if not name.startswith("_")}

ACCEPTED_NAME_CONFLICTS = {"load"}
"""Names of variables that are also methods of xarray, so that brackets are needed, as in ``result["load"]``."""


def create_datasets(upper, lower, function_result, directory):
    """Yield a dataset of every kind that public functions return or store."""
    options = {"mu0": 0.3, "effective_modulus": 10.0}
    areas = stiction.run(pair_study(upper, lower, load="1 mN", shifts=3, mechanics="asperities", **options))
    lines = stiction.run(pair_study(upper.row(0), lower.row(0), load="10 uN", positions=[0.0], **options))
    small_study_changes = {
        "ensemble.repetitions": 2,
        "surfaces.points": 3000,
        "contact.approach": ["5 nm", "20 nm", "40 nm"],
    }
    generated_dataset = stiction.run(stiction.Study.named("quick").with_changes(small_study_changes)).dataset
    loads = [1e-3, 2e-3]
    datasets = [dataset for result in (areas, lines) for dataset in (result.at(), result.at(per_member=True))] + [
        generated_dataset
    ]
    datasets += [
        stiction.friction_map(generated_dataset, loads),
        stiction.area_map(generated_dataset, loads),
        stiction.stiffness_map(generated_dataset, loads),
    ]
    datasets += [
        stiction.nondimensional(generated_dataset),
        at_load(generated_dataset, loads),
        member_values(generated_dataset, loads),
    ]
    datasets += [stiction.resolution(upper, lower, [1.0], hardness=1.0, effective_modulus=10.0, cut_offs=[0.8])]
    roughness = stiction.scale_dependent_roughness(lower)
    datasets += [stiction.spectral_resolution(roughness, roughness, pressure=0.01, hardness=1.0, mu0=0.3)]
    datasets += [function_result.dataset, function_result.at("10 MPa"), member_values(function_result.source, [1.0])]
    datasets += [contact_picture(function_result.source), xarray.load_dataset(directory / "onset.nc")]
    return datasets


def test_names_of_dataset_variables_do_not_clash_with_xarray_methods(upper, lower, surface_directory):
    stored_result = pair(
        surface_directory / "upper.npy",
        surface_directory / "lower.npy",
        directory=surface_directory / "kept",
        **PAIR_ARGUMENTS | {"onset": 2, "mu0": 0.2},
    )
    result = {
        str(name)
        for dataset in create_datasets(upper, lower, stored_result, surface_directory / "kept")
        for name in (*dataset.dims, *dataset.variables)
    }
    result |= set(QUANTITIES)
    array = lower.to_xarray()
    assert (result | {*array.dims, array.name}) & XARRAY_METHODS == ACCEPTED_NAME_CONFLICTS


def test_contacts_method_of_a_result_returns_a_data_frame(function_result):
    result = function_result.contacts(["5 MPa", "10 MPa"], members=[0, 2])
    assert list(result.columns) == [
        "member", "cut_off_um", "load_mN", "x_um", "y_um", "force_mN", "area_um2", "mean_pressure_GPa", "slope_x",
        "slope_y", "at_edge",
    ]  # fmt: skip
    loads = result.groupby(["member", "load_mN"])["force_mN"].sum()
    assert len(loads) == 4
    np.testing.assert_allclose(loads, loads.index.get_level_values("load_mN"), rtol=1e-9)
    areas = result[result["load_mN"] == result["load_mN"].max()].groupby("member")["area_um2"].sum()
    pressed_contacts = (
        function_result.dataset["contact_area"].isel(cut_off=0).sel(load=result["load_mN"].max(), method="nearest")
    )
    np.testing.assert_allclose(areas, pressed_contacts.sel(repetition=[0, 2]), rtol=1e-9)
    np.testing.assert_array_equal(result["mean_pressure_GPa"], result["force_mN"] / result["area_um2"])


def test_contacts_method_of_a_result_returns_contacts_of_the_most_typical_pair_by_default(function_result):
    picture = contact_picture(function_result.source)
    result = function_result.contacts()
    assert set(result["member"]) == {picture.attrs["member"]}
    np.testing.assert_array_equal(result["force_mN"], picture["contact_force"])
    for members, words in ((3, "members must be indices of the 3"), ([], "members must be"), (0.5, "whole number")):
        with pytest.raises(ValueError, match=words):
            function_result.contacts(members=members)
    with pytest.raises(ValueError, match="load must be a force or a pressure with its unit"):
        function_result.contacts("10 nm")


def test_contacts_of_a_pair_in_a_generated_result_equal_contacts_computed_directly():
    small_study_changes = {"ensemble.repetitions": 3, "surfaces.points": 3000, "surfaces.fractal_dimension": [1.1, 1.4]}
    study = stiction.Study.named("quick").with_changes(small_study_changes)
    result = stiction.run(study).contacts(1e-3, members=[0, 1])
    member_contacts = result[(result["fractal_dimension"] == 1.4) & (result["member"] == 1)]
    upper, lower = stiction.pair_of(
        study, 1, fractal_dimension=1.4, amplitude=float(member_contacts["amplitude_um"].iloc[0])
    )
    approach = float(stiction.approach_at_load(upper, lower, 1e-3, mu0=0.0))
    expected = contacts(upper, lower, approach, sliding="all")
    np.testing.assert_allclose(member_contacts["x_um"], expected.centre[:, 0], rtol=1e-9)
    np.testing.assert_allclose(member_contacts["force_mN"].sum(), 1e-3, rtol=1e-9)


def test_surface_from_an_xarray_array_converts_units(lower):
    array = lower.to_xarray() * 1000
    array.attrs["units"] = "nm"
    surface = Surface.from_(array.transpose("x", "y"))
    np.testing.assert_allclose(surface.heights, lower.heights, rtol=1e-15)
    assert surface.spacing == lower.spacing


def test_surface_from_a_surface_topography_object_preserves_heights(lower):
    topography = pytest.importorskip("SurfaceTopography")
    rows, columns = lower.heights.shape
    sizes = columns * lower.spacing[1] * 1000, rows * lower.spacing[0] * 1000
    converted = Surface.from_(topography.Topography(lower.heights.T * 1000, sizes, unit="nm"))
    np.testing.assert_allclose(converted.heights, lower.heights, rtol=1e-14)
    np.testing.assert_allclose(converted.spacing, lower.spacing, rtol=1e-14)
    line = Profile.from_(topography.UniformLineScan(lower.heights[0], columns * 0.2), unit="um")
    np.testing.assert_array_equal(line.heights, lower.heights[0])
    masked_heights = np.ma.masked_greater(lower.heights.T, 0.01)
    with pytest.raises(ValueError, match="must have a height at every point"):
        Surface.from_(topography.Topography(masked_heights, sizes, unit="nm"))


class SurfalizeStandIn:
    """Object with those attributes of a surface of the package surfalize that stiction reads."""

    def __init__(self, data, step_x, step_y):
        self.data, self.step_x, self.step_y = data, step_x, step_y


def test_surface_from_a_surfalize_object_preserves_heights(lower):
    converted = Surface.from_(SurfalizeStandIn(lower.heights, 0.2, 0.1))
    np.testing.assert_array_equal(converted.heights, lower.heights)
    assert converted.spacing == (0.1, 0.2)


def test_conversion_to_a_surface_rejects_unsuitable_objects(lower):
    array = lower.to_xarray()
    array_with_missing_points, array_with_uneven_spacing = array.copy(), array.copy()
    array_with_missing_points[0, 0] = np.nan
    array_with_uneven_spacing = array_with_uneven_spacing.assign_coords(
        x=("x", np.square(array["x"].values), array["x"].attrs)
    )
    for invalid_object, words in (
        (lower.row(0), "must be a surface, got a profile; use Profile.from_"),
        ([[0.0, 1.0]], "an object from SurfaceTopography, surfalize or xarray, got list"),
        (array.drop_attrs(), "must have a unit of length"),
        (array.rename(x="u"), "must have the dimensions y and x"),
        (array_with_missing_points, "1 points without a height"),
        (array_with_uneven_spacing, "equal steps along x"),
    ):
        with pytest.raises(ValueError, match=re.escape(words)):
            Surface.from_(invalid_object)


def test_message_about_a_missing_unit_starts_with_the_argument_name_of_the_pair_function(lower):
    array = lower.to_xarray().drop_attrs()
    with pytest.raises(ValueError, match=r"^first must have a unit of length along y \(m, "):
        stiction.pair(array, array, load="10 MPa", effective_modulus="100 GPa", mu0=0.3)


# ---- Quantities, moduli and identical bodies -------------------------------------------------------------------------


def test_public_functions_accept_quantities_as_strings_with_units(upper, lower):
    np.testing.assert_array_equal(press(upper, lower, ["5 nm", "0.02 um"]).approach, [0.005, 0.02])
    area = float(np.prod(upper.extent))
    np.testing.assert_allclose(half_space(upper, lower, ["1 MPa", "3 mN"]).load, [0.001 * area, 3.0], rtol=1e-12)
    assert len(contacts(upper, lower, "20 nm")) == len(contacts(upper, lower, 0.02))
    for call, words in (
        (lambda: press(upper, lower, "5 mN"), "approaches has the unit 'mN', which is not a unit of length"),
        (lambda: half_space(upper, lower, "5 nm"), "loads must be a force or a pressure with its unit"),
    ):
        with pytest.raises(ValueError, match=words):
            call()


def test_press_function_accepts_a_modulus_with_its_unit(upper, lower):
    curve = press(upper, lower, "5 nm", effective_modulus="3 GPa")
    expected = press(upper, lower, [0.005], effective_modulus=3.0)
    np.testing.assert_array_equal(curve.normal_elastic, expected.normal_elastic)
    assert curve.effective_modulus == 3.0


@pytest.fixture(scope="module")
def scanned_surface(lower, tmp_path_factory):
    path = tmp_path_factory.mktemp("scan") / "scan.npy"
    write_surface(lower, path)
    result = read_surface(path)
    np.testing.assert_array_equal(result.heights, lower.heights)
    assert result.spacing == lower.spacing
    return result


def test_contact_functions_require_a_modulus_for_measured_surfaces(upper, scanned_surface):
    for call in (
        lambda: press(upper, scanned_surface, "10 nm"),
        lambda: contacts(upper, scanned_surface, "10 nm"),
        lambda: press(candidates(upper, scanned_surface, deepest=0.02), "10 nm"),
        lambda: half_space(upper, scanned_surface, "1 mN"),
        lambda: stiction.resolution(upper, scanned_surface, [1.0], hardness=None),
        lambda: stiction.approach_at_load(upper, scanned_surface, "1 mN", mu0=0.3),
    ):
        with pytest.raises(ValueError, match=r"effective_modulus .* must be given, because a body was read from scan"):
            call()
    model = stiction.ContactModel(effective_modulus=10.0)
    curve_with_model, generated_surface = (
        press(upper, scanned_surface, "10 nm", model=model),
        Surface(scanned_surface.heights, spacing=scanned_surface.spacing),
    )
    np.testing.assert_array_equal(
        curve_with_model.normal_elastic, press(upper, generated_surface, "10 nm").normal_elastic
    )


def test_contact_functions_warn_about_a_surface_pressed_on_itself(scanned_surface, lower):
    mirrored_surface = Surface(
        0.3 - scanned_surface.heights, spacing=scanned_surface.spacing, history=(*scanned_surface.history, "flipped")
    )
    for call, words in (
        (lambda: half_space(scanned_surface, scanned_surface, "1 mN", effective_modulus=10.0), "face the same way"),
        (lambda: half_space(lower, lower, "1 mN"), "fit into each other everywhere"),
        (
            lambda: half_space(mirrored_surface, scanned_surface, "1 mN", effective_modulus=10.0),
            "is the mirror image of lower",
        ),
        (lambda: press(flipped(lower), lower, "5 nm"), "slopes along y cancel"),
    ):
        with pytest.warns(UserWarning, match=words):
            call()


def test_press_function_issues_no_warning_about_two_different_surfaces(scanned_surface, upper, lower):
    with warnings.catch_warnings(action="error"):
        press(upper, lower, "5 nm")
        press(flipped(scanned_surface), upper, "5 nm", effective_modulus=10.0)
        stiction.pair(
            scanned_surface,
            scanned_surface,
            load="1 mN",
            mu0=0.3,
            effective_modulus=10.0,
            shifts=2,
            mechanics="asperities",
        )


def test_surface_on_its_mirror_image_has_no_elastic_tangential_load(lower):
    """The slopes of a surface in contact with its mirror image cancel."""
    mirrored_surface = Surface(-lower.heights, spacing=lower.spacing)
    result = half_space(mirrored_surface, lower, "1 mN", direction=[0, 90], sliding="all")
    assert np.abs(result.tangential_elastic).max() < 1e-6 * result.normal_elastic.max()


# ---- A pair ----------------------------------------------------------------------------------------------------------

PAIR_ARGUMENTS = {
    "load": "10 MPa",
    "mu0": [0.2, 0.3],
    "tau0": "50 MPa",
    "effective_modulus": "80 GPa",
    "shifts": 3,
    "onset": 0,
}
COMMAND_OPTIONS = (
    "--load", "10 MPa", "--mu0", "0.2,0.3", "--tau0", "50 MPa", "--effective-modulus", "80 GPa", "--shifts", "3",
    "--onset", "0", "--mechanics", "asperities",
)  # fmt: skip


@pytest.fixture(scope="module")
def surface_directory(tmp_path_factory):
    directory = tmp_path_factory.mktemp("notebook")
    for side in ("upper", "lower"):
        write_surface(create_surface(side), directory / f"{side}.npy")
    return directory


@pytest.fixture(scope="module")
def command_result(surface_directory):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("stiction.views.figures.draw_figures", lambda *_, **__: [])
        completed = call_stiction(
            "pair", "upper.npy", "lower.npy", *COMMAND_OPTIONS, "--output", "command", cwd=surface_directory
        )
    assert completed.returncode == 0, completed
    return open_result(surface_directory / "command")


@pytest.fixture(scope="module")
def function_result(surface_directory):
    return pair(
        surface_directory / "upper.npy",
        surface_directory / "lower.npy",
        mechanics="asperities",
        directory=surface_directory / "function",
        **PAIR_ARGUMENTS,
    )


def test_pair_function_and_pair_command_give_equal_results(command_result, function_result, surface_directory):
    assert function_result.study == command_result.study
    xarray.testing.assert_identical(function_result.dataset, command_result.dataset)
    assert function_result.to_dataframe().equals(command_result.to_dataframe())
    assert repr(function_result) == repr(command_result)
    records = [
        [point_record(point) for point in result.summary().points] for result in (function_result, command_result)
    ]
    assert records[0] == records[1]
    stored_result = open_result(surface_directory / "function")
    assert (stored_result.value, stored_result.assessment) == (function_result.value, function_result.assessment)


def test_at_command_reads_a_result_of_the_pair_function(function_result, surface_directory):
    completed = check_stiction("at", "function", "--load", "10 MPa", cwd=surface_directory)
    assert f"{function_result.value:.2f}" in completed.stdout


def test_pair_function_gives_equal_results_for_surfaces_in_memory_and_for_files(function_result):
    """Compare surfaces in memory with the same heights read from files."""
    load = float(function_result.study.friction.load[0])
    options = PAIR_ARGUMENTS | {"load": load, "tau0": 0.05, "effective_modulus": 80.0}
    result = pair(create_surface("upper"), create_surface("lower"), mechanics="asperities", **options)
    for name in ("contact_area", "tangential_elastic"):
        np.testing.assert_array_equal(result.dataset[name], function_result.dataset[name])
    assert result.value == function_result.value


def test_result_of_the_pair_function_has_a_value_and_interval_and_assessment_and_table(function_result, tmp_path):
    first_point = function_result.summary().points[0]
    assert function_result.value == first_point.value
    assert function_result.interval == (first_point.lower, first_point.upper)
    assert function_result.assessment in repr(function_result)
    assert all(caveat.text in " ".join(repr(function_result).split()) for caveat in first_point.caveats)
    table = function_result.to_dataframe()
    assert {"assessment", "caveats", "coefficient of static friction"} <= set(table.columns)
    assert "<pre" in (shows := function_result._repr_html_())
    assert "<img" in shows
    assert function_result.save_report(tmp_path / "page.html").stat().st_size > 1000


def test_result_can_be_evaluated_at_other_loads_and_other_mu0_and_tau0(function_result):
    table = function_result.at(["5 MPa", "2 mN"], mu0=0.25, tau0="20 MPa")
    np.testing.assert_allclose(table["load"], sorted([2.0, 0.005 * float(function_result.dataset["nominal_area"])]))
    assert (table["mu0"].item(), table["tau0"].item()) == (0.25, 0.02)


def test_result_of_the_pair_function_can_draw_every_figure(function_result):
    for name in function_result.figures():
        assert isinstance(figure := function_result.figure(name), Figure)
    assert figure._repr_png_().startswith(b"\x89PNG")
    with pytest.raises(ValueError, match="name must be one of 'friction'"):
        function_result.figure("picture")


REJECTED_ARGUMENT_CASES = [
    ({"load": "10 nm"}, "load must be a force or a pressure with its unit"),
    ({"load": []}, "load must have at least one value"),
    ({"tau0": "3 mN"}, "tau0 has the unit 'mN', which is not a unit of pressure"),
    ({"mu0": "x"}, "mu0 must be one or more numbers"),
    ({"effective_modulus": None}, "give effective_modulus, or young and poisson, or upper and lower"),
    ({"upper": "steel"}, "not both effective_modulus and upper and lower"),
    ({"mechanics": "fem"}, "mechanics must be half-space or asperities, got 'fem'"),
    ({"lines": 3}, "shifts is for the areas of two maps, without lines"),
    ({"unit": "nm"}, "unit applies to files, but a body is an array or an object in memory"),
    ({"first": [0.0, 1.0]}, "first must be a Profile or a Surface, or an object from .* got float"),
    ({"second": "nowhere.npy"}, "nowhere.npy"),
    ({"first": "a\0b"}, "first must be a path of printable characters, got 'a\\\\x00b'"),
    ({"onset": "\uff11"}, "onset must be a whole number of at least 0, got '\uff11'"),
]


@pytest.mark.parametrize(("changes", "pattern"), REJECTED_ARGUMENT_CASES)
def test_pair_function_rejects_invalid_input_with_a_one_line_error(upper, lower, changes, pattern):
    arguments = {"first": upper, "second": lower} | PAIR_ARGUMENTS | changes
    with pytest.raises(ValueError, match=pattern) as error_info:
        pair(arguments.pop("first"), arguments.pop("second"), **arguments)
    assert "--" not in str(error_info.value)
    assert "\n" not in str(error_info.value)


ARRAY_OF_ZEROS = np.zeros((3, 3))
REJECTED_VALUE_CASES = [
    (
        lambda result: result.at(load_definition=ARRAY_OF_ZEROS),
        "load_definition must be one of 'mean', 'elastic', 'normal', got array",
    ),
    (lambda result: result.at(load_definition=ARRAY_OF_ZEROS, per_member=True), "load_definition must be one of"),
    (
        lambda result: result.at(load_definition=ARRAY_OF_ZEROS, height_scale=2),
        "load_definition must be 'elastic' if height_scale is given",
    ),
    (lambda result: result.at(mu0=1e300), "mu0 must be at most 1e\\+12, got 1e\\+300"),
    (lambda result: result.at(tau0=1e300), "tau0 must be at most 1e\\+12, got 1e\\+300"),
    (lambda result: result.at(mu0=[]), "mu0 must have at least one value"),
    (lambda result: result.contacts(members=[[1.0], [2.0, 3.0]]), "members must be a whole number of at least 0"),
    (lambda _: stiction.LoadCurve.from_columns(3), "columns must be a mapping of names to arrays, got int"),
    (lambda _: stiction.LoadCurve.from_columns({}), "columns must contain .*, got \\[\\]"),
    (lambda result: result.compute_once(3), "compute must be a function, got 3"),
    (
        lambda _: half_space(*SMALL_SURFACES, [1e-3], progress=ARRAY_OF_ZEROS),
        "progress must be a function of three arguments",
    ),
    (
        lambda _: half_space(*SMALL_SURFACES, [1e-3], record=ARRAY_OF_ZEROS),
        "record must be a SolutionRecord, got ndarray",
    ),
    (lambda _: half_space(*SMALL_SURFACES, [1e-3]).at(SMALL_SURFACES[0]), "index must be at least -1 and below 1"),
    (lambda _: stiction.read_surface("u.csv", unit=SMALL_SURFACES[0]), "unit must be a unit of length"),
    (lambda _: stiction.read_surface("u.csv", crop=ARRAY_OF_ZEROS), "crop must be"),
    (lambda _: stiction.read_surface("u.csv", channel=ARRAY_OF_ZEROS), "channel must be a name or a number"),
    (lambda _: stiction.read_surface("u.csv", missing_value="\ud800"), "missing_value must have printable words"),
    (lambda _: stiction.lines_along_both(SMALL_SURFACES[0], band="x" * 5000), "band must be"),
    (lambda _: stiction.weierstrass_mandelbrot_family([[1.0]], [[1.0], [2.0, 3.0]]), "fractal_dimensions must be"),
    (lambda _: stiction.table_study(extent=1e300), "extent must be a finite number above 0 and below"),
]
SMALL_SURFACES = [create_surface(side, 16) for side in ("upper", "lower")]


@pytest.mark.parametrize(("call", "pattern"), REJECTED_VALUE_CASES)
def test_public_functions_reject_arrays_and_extreme_values_with_a_short_message(function_result, call, pattern):
    with pytest.raises(ValueError, match=pattern) as error_info:
        call(function_result)
    assert "\n" not in str(error_info.value)
    assert len(str(error_info.value)) < 200


def test_pair_function_warns_about_a_flipped_surface(upper, lower):
    with pytest.warns(UserWarning, match="first is flipped, but pair flips the first body itself"):
        pair(flipped(upper), lower, mechanics="asperities", **PAIR_ARGUMENTS)


def test_pair_function_replaces_a_result_of_another_study_only_on_request(function_result, surface_directory, tmp_path):
    directory = tmp_path / "result"
    options = PAIR_ARGUMENTS | {"mechanics": "asperities", "directory": directory}
    pair(surface_directory / "upper.npy", surface_directory / "lower.npy", **options)
    assert pair(
        surface_directory / "upper.npy", surface_directory / "lower.npy", **options | {"mu0": 0.1}
    ).study.friction.mu0 == (0.1,)
    other_options = options | {"effective_modulus": "70 GPa"}
    with pytest.raises(ValueError, match="contains another study") as error_info:
        pair(surface_directory / "upper.npy", surface_directory / "lower.npy", **other_options)
    assert "\n" not in str(error_info.value)
    assert (
        pair(
            surface_directory / "upper.npy", surface_directory / "lower.npy", **other_options, replace=True
        ).study.contact.effective_modulus
        == 70
    )


def test_copy_of_a_surface_has_an_equal_repr(lower):
    assert repr(copy.deepcopy(lower)) == repr(lower)


def test_pair_raises_a_format_error_for_a_file_that_cannot_be_read(tmp_path):
    (tmp_path / "scan.csv").write_text("hello\nworld\n")
    with pytest.raises(stiction.FormatError, match="no numbers were found"):
        stiction.pair(
            tmp_path / "scan.csv", tmp_path / "scan.csv", load="1 MPa", effective_modulus="80 GPa", mu0=0.2,
            directory=tmp_path / "pair",
        )  # fmt: skip
