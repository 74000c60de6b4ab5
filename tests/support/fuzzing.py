"""Calls of functions and commands with random inputs, which must be accepted or rejected without a traceback.

Functions must raise `ValueError`; commands must end with exit status 2. The caller provides a NumPy generator, so
that runs with the same seed are equal.
"""

import io
import math
import os
import re
import shutil
import warnings
import zipfile

import numpy as np
import stiction
from stiction import Profile, Study, Surface

from support.command import call_stiction

# ---- Study files ----------------------------------------------------------------------------------------------------

_FUZZED_STUDY_VALUES = [
    "0", "1", "-1", "3", "1e308", "1e-308", "nan", "inf", "-inf", "true", '""', '"1 um"', '"1e400 um"', '"-1 nm"',
    '"0 um"', '"200 MPa"', '"200 mPa"', '"10 GPa "', "[]", "[1.0]", "[1.0, 1.7]", "[1.7, 1.0]", '["1 um", "2 um"]',
    "{}",
    "{ start = 1.0, stop = 1.7, count = 3 }", '{ start = "0 nm", stop = "1 nm", count = 2 }', "1979-05-27", "0x10",
    '"cell"', '"gap-minimum"', '"hertz-cylinder"', '{ name = "jackson-green" }', "9" * 400, '"é"', "'''x'''",
]  # fmt: skip
_SMALL_STUDY_CHANGES = {
    "surfaces.points": "64",
    "surfaces.directions": "3",
    "surfaces.frequencies": "4",
    "contact.approach.count": "3",
    "surfaces.fractal_dimension.count": "2",
    "ensemble.repetitions": "2",
    "figures.draw": "[]",
}


def random_study_text(random):
    """Return the text of a valid study in which lines, numbers or bytes were changed at random."""
    lines = (
        Study()
        .with_changes({study_key: _parse_value(value) for study_key, value in _SMALL_STUDY_CHANGES.items()})
        .to_toml()
        .splitlines()
    )
    for _ in range(random.integers(1, 4)):
        line_index = int(random.integers(len(lines)))
        study_key, _, _ = lines[line_index].partition(" = ")
        match random.integers(7):
            case 0 | 1 | 2 if " = " in lines[line_index]:
                lines[line_index] = f"{study_key} = {random.choice(_FUZZED_STUDY_VALUES)}"
            case 3:
                lines.insert(line_index, str(random.choice(lines)))
            case 4:
                del lines[line_index]
            case 5 if lines[line_index]:
                position = int(random.integers(len(lines[line_index])))
                lines[line_index] = (
                    lines[line_index][:position] + chr(int(random.integers(1, 300))) + lines[line_index][position + 1 :]
                )
            case _:
                lines[line_index] = lines[line_index][: int(random.integers(len(lines[line_index]) + 1))]
    text = "\n".join(lines).encode("utf-8", "surrogatepass")
    if random.random() < 0.1:
        damaged_text = bytearray(text)
        for _ in range(5):
            damaged_text[int(random.integers(len(damaged_text)))] = int(random.integers(256))
        text = bytes(damaged_text)
    return text


def _parse_value(text):
    return [] if text == "[]" else int(text)


def fuzz_study_file(random, directory):
    """Run `stiction run` on a random study file, and return the exit status, or None if the study is too large."""
    path = directory / "study.toml"
    text = random_study_text(random)
    path.write_bytes(text)
    try:
        study = Study.from_toml(path)
    except ValueError:
        study = None
    if study is not None and (
        study.surfaces.points * study.surfaces.fractal_dimensions().size * 80 > 1e6 or study.ensemble.repetitions > 100
    ):
        return None
    output = directory / "output"
    completed = call_stiction("run", path, "--output", output, "--workers", "1", cwd=directory)
    assert completed.returncode in (0, 2), (text, completed)
    assert completed.returncode == 0 or (completed.stdout + completed.stderr).startswith("stiction: "), (
        text,
        completed,
    )
    assert "Traceback" not in completed.stderr, (text, completed)
    assert (completed.returncode == 0) <= (study is not None), (text, completed)
    shutil.rmtree(output, ignore_errors=True)
    return completed.returncode


# ---- Stores ---------------------------------------------------------------------------------------------------------


def small_fuzz_study():
    """Return a study that runs in a few milliseconds."""
    return Study().with_changes({study_key: _parse_value(value) for study_key, value in _SMALL_STUDY_CHANGES.items()})


def fuzz_stored_result(random, original, directory):
    """Run `stiction info`, `export` and `plot` on a damaged result, and return the exit status of the last command."""
    copy = directory / "copy"
    shutil.rmtree(copy, ignore_errors=True)
    shutil.copytree(original, copy)
    files = sorted(path for path in copy.rglob("*") if path.is_file())
    for _ in range(random.integers(1, 3)):
        damage_file(random, files[int(random.integers(len(files)))])
    (directory / "out.nc").unlink(missing_ok=True)
    statuses = []
    for arguments in (("info", copy), ("export", copy, directory / "out.nc"), ("plot", copy)):
        completed = call_stiction(*arguments, cwd=directory)
        assert completed.returncode in (0, 2), (arguments, completed)
        assert completed.returncode == 0 or "stiction: " in completed.stderr, (arguments, completed)
        assert "Traceback" not in completed.stderr, (arguments, completed)
        statuses.append(completed.returncode)
    return statuses[-1]


def damage_file(random, path):
    """Damage a file at random: remove, truncate, overwrite or extend the file, or change some of its bytes."""
    if not path.exists():
        return
    file_bytes = bytearray(path.read_bytes())
    match random.integers(6):
        case 0:
            path.unlink()
        case 1:
            path.write_bytes(file_bytes[: int(random.integers(len(file_bytes) + 1))])
        case 2:
            path.write_bytes(random.bytes(int(random.integers(200))))
        case 3 if file_bytes:
            file_bytes[int(random.integers(len(file_bytes)))] ^= 1 << int(random.integers(8))
            path.write_bytes(file_bytes)
        case 4:
            replacements = [b"null", b"[]", b"{}", b"0", b"-1", b'"x"', b"1e999", b"[" * 2000]
            position = int(random.integers(len(file_bytes) + 1))
            path.write_bytes(
                file_bytes[:position]
                + replacements[int(random.integers(len(replacements)))]
                + file_bytes[position + 3 :]
            )
        case _:
            os.truncate(path, len(file_bytes) + 7)


# ---- Measured files -------------------------------------------------------------------------------------------------

_INSERTED_BYTES = [
    b"nan", b"", b"1e999", b"-9999", b"***", b"\n", b"\r", b"\t", b",", b";", b"0", b"-", b"1e-400", b"\x00",
    b"\xff\xfe", b"(um)", b"(V)", b"spacing: 1e9 um\n", b"<!ENTITY", b"9" * 50, b"\xb5m", b"1_0", "٣".encode(), b"inf",
    b"</Record1>",
]  # fmt: skip


_INSERTED_NUMBERS = [
    b"inf",
    b"nan",
    b"1e999",
    b"-1e999",
    b"1e-400",
    b"-3",
    b"0",
    b"2.5",
    b"1e12",
    b"1e5",
    b"9" * 30,
    b"1e",
]


def fuzz_measurement_file(random, name, original, directory):
    """Read a damaged file as a profile and as a surface. Return "read" if either succeeds, or else "refused"."""
    file_bytes = bytearray(original)
    if name.endswith(("x3p", "xlsx")) and random.random() < 0.7:
        file_bytes = _damage_zip_archive(random, original)
    else:
        scramble_bytes(random, file_bytes)
    path = directory / name
    path.write_bytes(file_bytes)
    options = [{}, {"unit": "um", "spacing": "0.1 um"}, {"missing": "interpolate"}, {"unit": "m", "spacing": "1 um"}]
    reader_options = options[int(random.integers(len(options)))]
    outcome = "refused"
    for read_body in (stiction.read_profile, stiction.read_surface):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", stiction.FormatWarning)
            try:
                body = read_body(path, **reader_options)
            except stiction.FormatError as error:
                message = str(error)
            else:
                message = f"{path}: "
                assert np.isfinite(body.heights).all()
                outcome = "read"
        assert message.startswith(f"{path}: "), (bytes(file_bytes), message)
        assert "\n" not in message, (bytes(file_bytes), message)
    return outcome


def scramble_bytes(random, file_bytes):
    """Return `data` with bytes that are inserted, removed and replaced at random."""
    for _ in range(random.integers(1, 5)):
        position = int(random.integers(len(file_bytes) + 1))
        match random.integers(7):
            case 0:
                del file_bytes[position:]
            case 6 if (
                match := re.compile(rb"[0-9.+-]+(?:[eE][+-]?[0-9]+)?").search(bytes(file_bytes), int(position))
            ) is not None:
                file_bytes[match.start() : match.end()] = _INSERTED_NUMBERS[
                    int(random.integers(len(_INSERTED_NUMBERS)))
                ]
            case 1:
                del file_bytes[position : position + int(random.integers(1, 20))]
            case 2 | 3:
                file_bytes[position : position + int(random.integers(4))] = _INSERTED_BYTES[
                    int(random.integers(len(_INSERTED_BYTES)))
                ]
            case 4 if position < len(file_bytes):
                file_bytes[position] = int(random.integers(256))
            case _:
                file_bytes[position:position] = file_bytes[position : position + int(random.integers(1, 60))]


def _damage_zip_archive(random, original):
    """Return a valid ZIP archive that contains one damaged file."""
    stream = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(original)) as original_archive, zipfile.ZipFile(stream, "w") as damaged_archive:
        names = original_archive.namelist()
        damaged_name = names[int(random.integers(len(names)))]
        for name in names:
            content = bytearray(original_archive.read(name))
            if name == damaged_name:
                scramble_bytes(random, content)
            damaged_archive.writestr(name, bytes(content))
    return stream.getvalue()


# ---- Arrays and numbers ---------------------------------------------------------------------------------------------

_FUZZED_NUMBERS = [
    0, 1, -1, 0.5, 1e-300, 1e300, 5e-324, -0.0, math.nan, math.inf, -math.inf, 10**400, True, None, "1", 1j, [], [1.0],
    np.float32(0.3), np.int8(3), np.array(0.2), np.array([1.0]), object(),
]  # fmt: skip
_FUZZED_OPTION_VALUES = [
    "cell",
    "gap-minimum",
    "convex",
    "signed",
    "+x",
    "-x",
    "hertz-sphere",
    "hertz-cylinder",
    "x",
    "",
    None,
    3,
]


def random_number(random, valid_number):
    """Return a valid number or, sometimes, an extreme number or something that is not a number."""
    return valid_number if random.random() < 0.9 else _FUZZED_NUMBERS[int(random.integers(len(_FUZZED_NUMBERS)))]


def random_choice(random, valid_choice):
    """Return a valid choice or, sometimes, something that is not a valid choice."""
    return (
        valid_choice
        if random.random() < 0.95
        else _FUZZED_OPTION_VALUES[int(random.integers(len(_FUZZED_OPTION_VALUES)))]
    )


def random_array(random, size):
    """Return an array of heights, sometimes of an unusual type, shape or size."""
    values = random.normal(size=size) * 10.0 ** random.integers(-12, 4)
    match random.integers(30):
        case 0:
            values = values * 10.0 ** random.integers(-300, 300)
        case 1 if size:
            values[int(random.integers(size))] = random.choice([math.nan, math.inf, 1e308, -1e308])
        case 2:
            values = np.round(values, 1)
        case 3:
            values = np.full(size, values[0] if size else 0.0)
        case 4:
            return values.astype(random.choice(["f4", "i2", "c16", "U3", "O", "M8[s]", "?"]), casting="unsafe")
        case 5:
            return values.reshape(1, -1)
        case 6:
            return values[::-1][::2]
        case 7:
            return list(values)
        case 8:
            return np.ma.masked_less(values, 0)
        case _:
            pass
    return values


def fuzz_numeric_function(random):
    """Call a numeric function with random arguments, and return the ValueError that it raises, or None."""
    size = int(random.integers(0, 120))
    try:
        with np.errstate(all="ignore"), warnings.catch_warnings(action="ignore"):
            _call_random_function(random, size)
    except ValueError as error:
        rejection = error
    else:
        return None
    assert str(rejection), "an error must have a message"
    return rejection


def _call_random_function(random, size):
    spacing = random_number(random, 0.01)
    match random.integers(9):
        case 0 | 1 | 2:
            upper = Profile(random_array(random, size), spacing=spacing)
            lower = Profile(random_array(random, size if random.random() < 0.9 else size + 1), spacing=spacing)
            options = {
                "effective_modulus": random_number(random, 10.0),
                "law": random_choice(random, "hertz-sphere"),
                "detection": random_choice(random, str(random.choice(["cell", "gap-minimum"]))),
                "curvature": random_choice(random, str(random.choice(["convex", "signed"]))),
                "shear": random_choice(random, "+x"),
            }
            approaches = np.sort(random.random(int(random.integers(1, 4)))) * 10.0 ** random.integers(-9, 2)
            curve = stiction.press(
                upper, lower, approaches if random.random() < 0.9 else random_array(random, 2), **options
            )
            curve.friction_coefficient(mu0=random_number(random, 0.4), tau0=random_number(random, 0.0))
            status = curve.status(mu0=0.4)
            assert set(status.ravel()) <= {"ok", "no-contact", "self-locked"}
            table = stiction.contacts(upper, lower, curve.approach[-1], **options)
            assert len(table.force) == curve.contact_count[-1]
        case 3:
            stiction.asperities(Profile(random_array(random, size), spacing=spacing), random_choice(random, "upper"))
        case 4:
            Profile(random_array(random, size), spacing=spacing).with_amplitude(
                random_number(random, 0.1), random_choice(random, str(random.choice(["height", "Ra", "Rq"])))
            )
        case 5:
            phases = random_array(random, 12)
            phases = phases.reshape(3, 4) if isinstance(phases, np.ndarray) and phases.size == 12 else phases
            heights = stiction.weierstrass_mandelbrot_family(
                phases,
                random_array(random, int(random.integers(3))) if random.random() < 0.5 else [1.0, 1.6],
                length_scale=random_number(random, 1.0),
                gamma=random_number(random, 1.5),
                extent=random_number(random, 2.0),
                points=random_number(random, size),
                convention=random_choice(random, "paper"),
                band_limit=random.choice([None, "nyquist"]),
            )
            assert heights.ndim == 2
        case 6:
            stiction.weierstrass_mandelbrot_surface(
                np.ones((2, 3)),
                random_number(random, 1.3),
                shape=(random_number(random, 5), random_number(random, 6)),
                extent=random_number(random, 2.0),
                gamma=random_number(random, 1.5),
                length_scale=random_number(random, 1.0),
            )
        case 7:
            heights = random_array(random, 2 * size)
            Surface(np.reshape(heights, (2, -1)) if np.size(heights) == 2 * size else heights, spacing=spacing)
        case _:
            stiction.force_and_area(
                random_choice(random, "hertz-sphere"),
                overlap=random_number(random, 0.1),
                radius=random_number(random, 1.0),
                effective_modulus=random_number(random, 10.0),
            )
            stiction.hertz_sphere(random_array(random, size), random_number(random, 1.0), random_number(random, 10.0))
            stiction.slope_friction(random_number(random, 0.3), mu0=random_number(random, 0.4))
