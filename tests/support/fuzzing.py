"""Random inputs of many kinds: each must be accepted, or rejected with a `ValueError` or exit status 2.

Whoever calls gives a NumPy generator, so that a seed repeats a run. A finding is an exception that escapes.
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

_VALUES = [
    "0", "1", "-1", "3", "1e308", "1e-308", "nan", "inf", "-inf", "true", '""', '"1 um"', '"1e400 um"', '"-1 nm"',
    '"0 um"', '"200 MPa"', '"200 mPa"', '"10 GPa "', "[]", "[1.0]", "[1.0, 1.7]", "[1.7, 1.0]", '["1 um", "2 um"]',
    "{}",
    "{ start = 1.0, stop = 1.7, count = 3 }", '{ start = "0 nm", stop = "1 nm", count = 2 }', "1979-05-27", "0x10",
    '"cell"', '"gap-minimum"', '"hertz-cylinder"', '{ name = "jackson-green" }', "9" * 400, '"é"', "'''x'''",
]  # fmt: skip
# Small, so that a file that is taken is soon computed.
_SMALL_STUDY = {
    "surfaces.points": "64",
    "surfaces.directions": "3",
    "surfaces.frequencies": "4",
    "contact.approach.count": "3",
    "surfaces.fractal_dimension.count": "2",
    "ensemble.repetitions": "2",
    "figures.draw": "[]",
}


def study_text(random):
    """Return the text of a study with some lines, values or bytes changed."""
    lines = Study().with_changes({key: _toml(value) for key, value in _SMALL_STUDY.items()}).to_toml().splitlines()
    for _ in range(random.integers(1, 4)):
        at = int(random.integers(len(lines)))
        key, _, _ = lines[at].partition(" = ")
        match random.integers(7):
            case 0 | 1 | 2 if " = " in lines[at]:
                lines[at] = f"{key} = {random.choice(_VALUES)}"
            case 3:
                lines.insert(at, str(random.choice(lines)))
            case 4:
                del lines[at]
            case 5 if lines[at]:
                where = int(random.integers(len(lines[at])))
                lines[at] = lines[at][:where] + chr(int(random.integers(1, 300))) + lines[at][where + 1 :]
            case _:
                lines[at] = lines[at][: int(random.integers(len(lines[at]) + 1))]
    text = "\n".join(lines).encode("utf-8", "surrogatepass")
    if random.random() < 0.1:
        noise = bytearray(text)
        for _ in range(5):
            noise[int(random.integers(len(noise)))] = int(random.integers(256))
        text = bytes(noise)
    return text


def _toml(text):
    return [] if text == "[]" else int(text)


def fuzz_study_file(random, folder):
    """Run `stiction run` on a random study file, and return its exit status."""
    path = folder / "study.toml"
    text = study_text(random)
    path.write_bytes(text)
    try:
        study = Study.from_toml(path)
    except ValueError:
        study = None
    if study is not None and (
        study.surfaces.points * study.surfaces.fractal_dimensions().size * 80 > 1e6 or study.ensemble.repetitions > 100
    ):
        return None  # too much to compute
    output = folder / "output"
    completed = call_stiction("run", path, "--output", output, "--workers", "1", cwd=folder)
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


def small_study():
    """Return a study with a small result."""
    return Study().with_changes({key: _toml(value) for key, value in _SMALL_STUDY.items()})


def fuzz_store(random, pristine, folder):
    """Run `stiction info`, `export` and `plot` on a damaged result, and return the last exit status."""
    copy = folder / "copy"
    shutil.rmtree(copy, ignore_errors=True)
    shutil.copytree(pristine, copy)
    files = sorted(path for path in copy.rglob("*") if path.is_file())
    for _ in range(random.integers(1, 3)):
        damage(random, files[int(random.integers(len(files)))])
    (folder / "out.nc").unlink(missing_ok=True)
    statuses = []
    for arguments in (("info", copy), ("export", copy, folder / "out.nc"), ("plot", copy)):
        completed = call_stiction(*arguments, cwd=folder)
        assert completed.returncode in (0, 2), (arguments, completed)
        assert completed.returncode == 0 or "stiction: " in completed.stderr, (arguments, completed)
        assert "Traceback" not in completed.stderr, (arguments, completed)
        statuses.append(completed.returncode)
    return statuses[-1]


def damage(random, path):
    """Damage a file as faulty disks, interrupted copies and edits do."""
    if not path.exists():
        return
    data = bytearray(path.read_bytes())
    match random.integers(6):
        case 0:
            path.unlink()
        case 1:
            path.write_bytes(data[: int(random.integers(len(data) + 1))])
        case 2:
            path.write_bytes(random.bytes(int(random.integers(200))))
        case 3 if data:
            data[int(random.integers(len(data)))] ^= 1 << int(random.integers(8))
            path.write_bytes(data)
        case 4:
            words = [b"null", b"[]", b"{}", b"0", b"-1", b'"x"', b"1e999", b"[" * 2000]
            at = int(random.integers(len(data) + 1))
            path.write_bytes(data[:at] + words[int(random.integers(len(words)))] + data[at + 3 :])
        case _:
            os.truncate(path, len(data) + 7)


# ---- Measured files -------------------------------------------------------------------------------------------------

_PIECES = [
    b"nan", b"", b"1e999", b"-9999", b"***", b"\n", b"\r", b"\t", b",", b";", b"0", b"-", b"1e-400", b"\x00",
    b"\xff\xfe", b"(um)", b"(V)", b"spacing: 1e9 um\n", b"<!ENTITY", b"9" * 50, b"\xb5m", b"1_0", "٣".encode(), b"inf",
    b"</Record1>",
]  # fmt: skip


_COUNTS = [b"inf", b"nan", b"1e999", b"-1e999", b"1e-400", b"-3", b"0", b"2.5", b"1e12", b"1e5", b"9" * 30, b"1e"]


def fuzz_measured(random, name, pristine, folder):
    """Read a damaged file of measured heights with both readers; return whether one accepted it."""
    data = bytearray(pristine)
    if name.endswith(("x3p", "xlsx")) and random.random() < 0.7:
        data = _damaged_inside(random, pristine)
    else:
        scramble(random, data)
    path = folder / name
    path.write_bytes(data)
    options = [{}, {"unit": "um", "spacing": "0.1 um"}, {"missing": "interpolate"}, {"unit": "m", "spacing": "1 um"}]
    chosen = options[int(random.integers(len(options)))]
    outcome = "refused"
    for read in (stiction.read_profile, stiction.read_surface):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", stiction.FormatWarning)  # but no other
            try:
                body = read(path, **chosen)
            except stiction.FormatError as error:
                message = str(error)
            else:
                message = f"{path}: "
                assert np.isfinite(body.heights).all()
                outcome = "read"
        assert message.startswith(f"{path}: "), (bytes(data), message)
        assert "\n" not in message, (bytes(data), message)
    return outcome


def scramble(random, data):
    for _ in range(random.integers(1, 5)):
        at = int(random.integers(len(data) + 1))
        match random.integers(7):
            case 0:
                del data[at:]
            case 6 if (match := re.compile(rb"[0-9.+-]+(?:[eE][+-]?[0-9]+)?").search(bytes(data), int(at))) is not None:
                data[match.start() : match.end()] = _COUNTS[int(random.integers(len(_COUNTS)))]
            case 1:
                del data[at : at + int(random.integers(1, 20))]
            case 2 | 3:
                data[at : at + int(random.integers(4))] = _PIECES[int(random.integers(len(_PIECES)))]
            case 4 if at < len(data):
                data[at] = int(random.integers(256))
            case _:
                data[at:at] = data[at : at + int(random.integers(1, 60))]


def _damaged_inside(random, pristine):
    """Return a valid archive with a damaged member."""
    stream = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(pristine)) as old, zipfile.ZipFile(stream, "w") as new:
        names = old.namelist()
        damaged = names[int(random.integers(len(names)))]
        for name in names:
            content = bytearray(old.read(name))
            if name == damaged:
                scramble(random, content)
            new.writestr(name, bytes(content))
    return stream.getvalue()


# ---- Arrays and numbers ---------------------------------------------------------------------------------------------

_FUZZED_NUMBERS = [
    0, 1, -1, 0.5, 1e-300, 1e300, 5e-324, -0.0, math.nan, math.inf, -math.inf, 10**400, True, None, "1", 1j, [], [1.0],
    np.float32(0.3), np.int8(3), np.array(0.2), np.array([1.0]), object(),
]  # fmt: skip
_CHOICES = ["cell", "gap-minimum", "convex", "signed", "+x", "-x", "hertz-sphere", "hertz-cylinder", "x", "", None, 3]


def any_number(random, usual):
    """Return a usual number, or sometimes any number."""
    return usual if random.random() < 0.9 else _FUZZED_NUMBERS[int(random.integers(len(_FUZZED_NUMBERS)))]


def any_choice(random, usual):
    """Return a usual string, or sometimes any object."""
    return usual if random.random() < 0.95 else _CHOICES[int(random.integers(len(_CHOICES)))]


def any_array(random, size):
    """Return heights of a random kind."""
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


def fuzz_arrays(random):
    """Make a random call of the numeric interface, and return its ValueError or None."""
    size = int(random.integers(0, 120))
    try:
        with np.errstate(all="ignore"), warnings.catch_warnings(action="ignore"):
            _call(random, size)
    except ValueError as error:
        refused = error
    else:
        return None
    assert str(refused), "an error must say what is wrong"
    return refused


def _call(random, size):
    spacing = any_number(random, 0.01)
    match random.integers(9):
        case 0 | 1 | 2:
            upper = Profile(any_array(random, size), spacing=spacing)
            lower = Profile(any_array(random, size if random.random() < 0.9 else size + 1), spacing=spacing)
            how = {
                "effective_modulus": any_number(random, 10.0),
                "law": any_choice(random, "hertz-sphere"),
                "detection": any_choice(random, str(random.choice(["cell", "gap-minimum"]))),
                "curvature": any_choice(random, str(random.choice(["convex", "signed"]))),
                "shear": any_choice(random, "+x"),
            }
            approaches = np.sort(random.random(int(random.integers(1, 4)))) * 10.0 ** random.integers(-9, 2)
            curve = stiction.press(upper, lower, approaches if random.random() < 0.9 else any_array(random, 2), **how)
            curve.friction_coefficient(mu0=any_number(random, 0.4), tau0=any_number(random, 0.0))
            status = curve.status(mu0=0.4)
            assert set(status.ravel()) <= {"ok", "no-contact", "self-locked"}
            table = stiction.contacts(upper, lower, curve.approach[-1], **how)
            assert len(table.force) == curve.contact_count[-1]
        case 3:
            stiction.asperities(Profile(any_array(random, size), spacing=spacing), any_choice(random, "upper"))
        case 4:
            Profile(any_array(random, size), spacing=spacing).with_amplitude(
                any_number(random, 0.1), any_choice(random, str(random.choice(["height", "Ra", "Rq"])))
            )
        case 5:
            phases = any_array(random, 12)
            phases = phases.reshape(3, 4) if isinstance(phases, np.ndarray) and phases.size == 12 else phases
            heights = stiction.weierstrass_mandelbrot_family(
                phases, any_array(random, int(random.integers(3))) if random.random() < 0.5 else [1.0, 1.6],
                length_scale=any_number(random, 1.0), gamma=any_number(random, 1.5), extent=any_number(random, 2.0),
                points=any_number(random, size), convention=any_choice(random, "paper"),
                band_limit=random.choice([None, "nyquist"]),
            )  # fmt: skip
            assert heights.ndim == 2
        case 6:
            stiction.weierstrass_mandelbrot_surface(
                np.ones((2, 3)), any_number(random, 1.3), shape=(any_number(random, 5), any_number(random, 6)),
                extent=any_number(random, 2.0), gamma=any_number(random, 1.5), length_scale=any_number(random, 1.0),
            )  # fmt: skip
        case 7:
            heights = any_array(random, 2 * size)
            Surface(np.reshape(heights, (2, -1)) if np.size(heights) == 2 * size else heights, spacing=spacing)
        case _:
            stiction.force_and_area(
                any_choice(random, "hertz-sphere"), overlap=any_number(random, 0.1), radius=any_number(random, 1.0),
                effective_modulus=any_number(random, 10.0),
            )  # fmt: skip
            stiction.hertz_sphere(any_array(random, size), any_number(random, 1.0), any_number(random, 10.0))
            stiction.slope_friction(any_number(random, 0.3), mu0=any_number(random, 0.4))
