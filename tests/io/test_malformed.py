"""Whatever a case file or a data file holds: it is solved, or refused in one line, at once, with little memory."""

import io
import os
import re
import struct
import subprocess
import sys
import time
import tracemalloc
import zipfile
import zlib
from contextlib import redirect_stderr, redirect_stdout

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st
from PIL import Image
from typer.main import get_command

import contactqp as cq
from contactqp.cli.commands import app
from contactqp.foundation import limits

SECONDS, BYTES = 2.0, 500_000_000
PATIENCE = 5
"""Times of the contract that a shared machine may take; what was meant to be caught took minutes."""

MEMBRANE = {
    "spacing": "0.5",
    "tension": "1.0",
    "load": "2.0",
    "support": "0.3",
    "frame": '{shape = "rectangle", width = 2.0, height = 1.5}',
}
CABLE = {
    "model": '"cable"', "span": "10.0", "spacing": "1.0", "tension": "1.0", "load": "1.0", "support": "2.0"
}  # fmt: skip


def toml(case, **changes):
    return "\n".join(f"{key} = {value}" for key, value in (case | changes).items() if value is not None)


COMMAND = get_command(app)


def run(*arguments):
    """Return the exit code of the command line, and what it prints on standard output and standard error."""
    with redirect_stdout(io.StringIO()) as printed, redirect_stderr(io.StringIO()) as complained:
        try:
            COMMAND.main(list(arguments), prog_name="contactqp")
        except SystemExit as end:
            return end.code, printed.getvalue(), complained.getvalue()
    raise AssertionError("the command line ends by an exit code")


class Accepted(BaseException):
    """Stands for solving, which is none of the subject."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("malformed")


@pytest.fixture(scope="module", autouse=True)
def nothing_is_solved():
    def accept(*args, **kwargs):
        raise Accepted

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("contactqp.solving.solve.solve", accept)
        yield


def outcome(path, text, *arguments):
    """Write a case, hand it to the command line, and return the line that refuses it; None where it is accepted."""
    path.write_bytes(text if isinstance(text, bytes) else text.encode("utf-8", "surrogatepass"))
    started = time.perf_counter()
    try:
        code, printed, complained = run("solve", str(path), *arguments)
    except Accepted:
        return None
    assert time.perf_counter() - started < SECONDS * PATIENCE
    assert (code, printed) == (2, "")
    assert complained.startswith("contactqp: ")
    assert complained.count("\n") == 1
    assert len(complained) < 1000
    return complained


def refused(path, text, *arguments):
    tracemalloc.start()
    try:
        found = outcome(path, text, *arguments)
        assert tracemalloc.get_traced_memory()[1] < BYTES
    finally:
        tracemalloc.stop()
    assert found is not None
    return found


# Numbers.


@pytest.mark.parametrize(
    ("case", "changes", "message"),
    [
        (MEMBRANE, {"spacing": "1e-300"}, "spacing must lie between 1e-140 and 1e+140, got 1e-300"),
        (MEMBRANE, {"spacing": "1e300"}, "spacing must lie between"),
        (MEMBRANE, {"spacing": "1e-5"}, "3e+10 lattice points of spacing 1e-05 over Frame.rectangle(2, 1.5) would need "
         "2.4 TB of memory; at most 150,000,000 are taken: choose a larger spacing"),
        (MEMBRANE, {"spacing": "1e-100"}, "lattice points of spacing 1e-100"),
        (MEMBRANE, {"spacing": "1" * 400}, "case.toml"),
        (MEMBRANE, {"spacing": "1" * 5000}, "not a TOML file"),
        (MEMBRANE, {"origin": "[1e300, 0]"}, "spacing 0.5 is lost by rounding at x = 1e+300"),
        (MEMBRANE, {"origin": "[0, 1e17]"}, "spacing 0.5 is lost by rounding at y = 1e+17"),
        (MEMBRANE, {"frame": '{shape = "disk", radius = 1e308}'}, "a frame must be between 1e-130 and 1e+130 wide"),
        (MEMBRANE, {"frame": '{shape = "disk", radius = 1e-300}'}, "got 2e-300 by 2e-300 for disk(1e-300)"),
        (MEMBRANE, {"frame": '{shape = "hexagon", side = 1e308}'}, "a frame must be"),
        (MEMBRANE, {"frame": '{shape = "hexagon", side = 1e-308}'}, "case.toml"),
        (MEMBRANE, {"frame": '{shape = "rectangle", width = 1e300, height = 1e300}'}, "a frame must be"),
        (MEMBRANE, {"frame": '{shape = "rectangle", width = 2, height = 2, center = [1e300, 0]}'}, "a frame must be"),
        (MEMBRANE, {"frame": '{shape = "polygon", corners = [[0, 0], [1e300, 0], [0, 1e300]]}'}, "case.toml"),
        (MEMBRANE, {"frame": '{shape = "polygon", corners = [[0, 0], [1e-300, 0], [0, 1e-300]]}'}, "case.toml"),
        (MEMBRANE, {"frame": '{shape = "polygon", corners = [[0, 0], [1, 1], [1, 0], [0, 1]]}'}, "not a valid polygon"),
        (MEMBRANE, {"tension": "1e308", "load": "1e308"}, "overflow"),
        (MEMBRANE, {"support": '{profile = "cone", depth = 1, slope = 1e308, center = [1e200, 0]}'}, "precision"),
        (MEMBRANE, {"support": '{profile = "paraboloid", depth = 1, radius = 1e-320}'}, "double precision"),
        (CABLE, {"span": "1e300"}, "1e+300 nodes of a cable would need"),
        (CABLE, {"span": "1e300", "spacing": "1e-100"}, "nodes of a cable would need"),
        (CABLE, {"span": "1e5", "spacing": "1e-5"}, "1e+10 nodes of a cable would need 800 GB of memory"),
        (CABLE, {"spacing": "1e-300"}, "spacing must lie between"),
        (CABLE, {"start": "1e300"}, "spacing 1 is lost by rounding"),
        (CABLE, {"span": "0.5"}, "span must be a whole multiple"),
    ],
)  # fmt: skip
def test_absurd_numbers_are_refused_with_count_and_memory(folder, case, changes, message):
    assert message in refused(folder / "case.toml", toml(case, **changes))


@pytest.mark.parametrize("profile", ["cylinder", "hemisphere"])
def test_an_arc_of_a_huge_radius_is_flat(folder, profile):
    path = folder / "case.toml"
    path.write_text(toml(MEMBRANE, support=f'{{profile = "{profile}", depth = 0.25, radius = 1e300}}'))
    from contactqp.io.cases import load_case

    assert set(load_case(path).support) == {0.25}


@pytest.mark.parametrize(
    "make",
    [
        lambda: cq.Frame.rectangle(2.0, 1.5).lattice(1e-5),
        lambda: cq.Frame.disk(1e6).lattice(1e-3),
        lambda: cq.Cable(span=1e5, spacing=1e-5, tension=1.0, load=1.0, support=1.0),
        lambda: cq.Cable(nodes=10**400, spacing=1.0, tension=1.0, load=1.0, support=1.0),
    ],
)
def test_the_constructors_refuse_before_they_take_memory(make):
    tracemalloc.start()
    with pytest.raises(ValueError, match=r"would need .*B of memory; at most 150,000,000 are taken: choose"):
        make()
    assert tracemalloc.get_traced_memory()[1] < 1_000_000
    tracemalloc.stop()


def test_the_limit_can_be_set(monkeypatch):
    monkeypatch.setenv(limits.MAX_POINTS_VARIABLE, "8")
    with pytest.raises(ValueError, match=r"9 nodes of a cable would need 720 B of memory; at most 8 are taken"):
        cq.Cable(span=10.0, spacing=1.0, tension=1.0, load=1.0, support=1.0)
    monkeypatch.setenv(limits.MAX_POINTS_VARIABLE, "9")
    assert cq.Cable(span=10.0, spacing=1.0, tension=1.0, load=1.0, support=1.0).size == 9
    monkeypatch.setenv(limits.MAX_POINTS_VARIABLE, "many")
    with pytest.raises(ValueError, match=r"CONTACTQP_MAX_POINTS must be a whole number > 0, got 'many'"):
        cq.Cable(span=10.0, spacing=1.0, tension=1.0, load=1.0, support=1.0)


# Text.


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "frame, spacing, load, support and tension: fields required"),
        (b"\x00" * 100, "not a TOML file"),
        (b"\xff\xfe" + toml(MEMBRANE).encode("utf-16-le"), "not a TOML file"),
        (toml(MEMBRANE, title='"Br\u00fcckensteg"').encode("latin-1"), "not a TOML file"),
        (toml(MEMBRANE, spacing="=") + "\n", "not a TOML file"),
        ("a = " + "[" * 5000, "too deeply nested"),
        ("a = " + "[" * 5000 + "]" * 5000, "too deeply nested"),
        ("a = " + "{a = " * 5000 + "1" + "}" * 5000, "too deeply nested"),
        (toml(MEMBRANE, load="[" * 300 + "]" * 300), "load"),
        (".".join("a" * 5000) + " = 1", "a key of more than 16 parts"),
        (".".join(['"a"'] * 5000) + " = 1", "a key of more than 16 parts"),
        ("[" + ".".join("a" * 5000) + "]", "a key of more than 16 parts"),
        ("a" * 900_000 + " = 1", "fields required; aaa"),
        (toml(MEMBRANE, **{"a" * 900_000: "1"}), "aaa…: unknown key; known: title, frame"),
        (toml(MEMBRANE, **{f"k{k}": "1" for k in range(5000)}), "and 4997 more"),
        ("#" * 2_000_000, "more than 1,000,000 bytes"),
        ('"""' + '\\"""' * 100_000, "not a TOML file"),
        ("title = '''" + "'" * 0 + "a" * 500_000, "not a TOML file"),
        (toml(MEMBRANE, title='"\ud800"'), "not a TOML file"),
        (toml(MEMBRANE, support="{}"), "support: must be a number, or a table with profile or file"),
        (toml(MEMBRANE, support='{prof1le = "cone"}'), "got a table with prof1le; did you mean 'profile'?"),
        (toml(MEMBRANE, support='{profile = "conne"}'), "support.profile: must be 'plane', 'paraboloid', 'cone', "),
        (toml(MEMBRANE, support='{profile = "conne"}'), "got 'conne'; did you mean 'cone'?"),
        (toml(MEMBRANE, support='{profile = "cone", depht = 1.0, slope = 1}'), "unknown key; did you mean 'depth'?"),
        (toml(MEMBRANE, support='{file = "a.npy", offst = 1}'), "support.offst: unknown key; did you mean 'offset'?"),
        (toml(MEMBRANE, load='{profile = "cone", depth = 1.0, slope = 1}'), "load: must be a number or a table"),
        (toml(MEMBRANE, frame='{radius = 1.0}'), "frame: needs the key shape"),
        (toml(MEMBRANE, frame='{shape = "polygon", corners = [[0, 0], [1]]}'), "frame.corners"),
        (toml(MEMBRANE, frame="1"), "frame: must be a table, got 1"),
        (toml(MEMBRANE, spacing="1979-05-27T07:32:00Z"), "spacing: "),
        (toml(MEMBRANE, model='"shell"'), "model: input should be 'membrane'"),
        (toml(MEMBRANE, model="[1]"), "model: "),
    ],
)  # fmt: skip
def test_texts_that_are_no_case(folder, text, message):
    found = refused(folder / "case.toml", text)
    assert message in found
    assert "valid dictionary" not in found


def test_a_byte_order_mark_is_no_part_of_a_case(folder):
    assert outcome(folder / "case.toml", b"\xef\xbb\xbf" + toml(MEMBRANE).encode()) is None


def test_what_is_no_file(folder):
    for name in (".", "no/such.toml", "a" * 5000):
        code, _, complained = run("solve", str(folder / name))
        assert code == 2
        assert complained.startswith("contactqp: ")
        assert complained.count("\n") == 1
    for name in ("../..", "", "x" * 5000 + ".npy", "a\\u0000b.npy"):
        assert "there is no file" in refused(folder / "case.toml", toml(MEMBRANE, support=f'{{file = "{name}"}}'))


# Data files.


def npy(header, data=b"", version=(1, 0)):
    text = header.encode("latin-1")
    length = struct.pack("<H" if version == (1, 0) else "<I", len(text))
    return b"\x93NUMPY" + bytes(version) + length + text + data


def claims(shape, kind="<f8"):
    return npy(f"{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}\n", b"\0" * 64)


def saved(array, **kwargs):
    file = io.BytesIO()
    np.save(file, array, **kwargs)
    return file.getvalue()


def archive(**entries):
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w") as writer:
        for name, data in entries.items():
            writer.writestr(f"{name}.npy", data)
    return file.getvalue()


def bad_crc():
    data = bytearray(archive(depth=saved(np.ones((2, 3)))))
    data[data.index(b"NUMPY") + 130] ^= 0xFF
    return bytes(data)


def picture(kind, mode="L", size=(5, 4)):
    file = io.BytesIO()
    Image.new(mode, size, 7).save(file, kind)
    return file.getvalue()


def png_chunk(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def png(width, height, data):
    header = struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + png_chunk(b"IHDR", header) + png_chunk(b"IDAT", data) + png_chunk(b"IEND", b"")


def bmp(width, height):
    return b"BM" + struct.pack("<IHHIIiiHHIIiiII", 54, 0, 0, 54, 40, width, height, 1, 24, 0, 0, 0, 0, 0, 0)


DAMAGED = "cannot read it: |it is no picture, or a damaged one"

ZEROS = zlib.compress(bytes(1_000_000))

NASTY = {
    "empty.npy": (b"", "cannot read it"),
    "short.npy": (saved(np.ones((40, 50)))[:1000], "it is cut off: its header claims shape .40, 50. of float64"),
    "claims.npy": (claims("(1000000000, 1000000000)"), r"1e\+18 entries would need 8 EB of memory"),
    "long.npy": (claims("(1000000000000000000,)"), r"1e\+18 entries"),
    "longer.npy": (claims(f"({10**400},)"), "entries would need"),
    "below.npy": (claims("(-4, 5)"), r"claims the shape \(-4, 5\)"),
    "within.npy": (claims("(10000, 10000)"), "it is cut off"),
    "words.npy": (claims("(2,)", "<U100000000"), "expected an array of numbers"),
    "objects.npy": (saved(np.array([{}, 1], dtype=object), allow_pickle=True), "expected an array of numbers"),
    "records.npy": (saved(np.zeros(3, dtype=[("a", "f8")])), "expected an array of numbers"),
    "complex.npy": (saved(np.ones((2, 2)) * 1j), "expected an array of numbers"),
    "cube.npy": (saved(np.ones((2, 2, 2))), "two-dimensional"),
    "nothing.npy": (saved(np.ones((0, 5))), "it holds no numbers"),
    "nested.npy": (npy("(" * 3000), "cannot read it"),
    "header.npy": (npy("{'descr': '<f8'"), "cannot read it"),
    "version.npy": (npy("{}", version=(9, 9)), "expected an array of numbers"),
    "huge-header.npy": (b"\x93NUMPY\x02\x00" + struct.pack("<I", 2**32 - 1) + b"{" * 100, "cannot read it"),
    "text.npy": (b"1,2,3\n", "cannot read it"),
    "empty.npz": (b"", "cannot read it"),
    "none.npz": (archive(), "choose one of its arrays"),
    "crc.npz": (bad_crc(), "cannot read it"),
    "short.npz": (archive(depth=saved(np.ones((40, 50))))[:300], "cannot read it"),
    "claims.npz": (archive(depth=claims("(1000000000, 1000000000)")), r"1e\+18 entries"),
    "within.npz": (archive(depth=claims("(10000, 10000)")), "it is cut off"),
    "words.npz": (archive(depth=b"hello"), "cannot read it"),
    "empty.csv": (b"", "it holds no numbers"),
    "blank.csv": (b"\n\n\n", "it holds no numbers"),
    "letters.csv": (b"a,b\n1,2\n", "cannot read it"),
    "ragged.csv": (b"1,2\n3\n", "cannot read it"),
    "binary.csv": (bytes(range(256)), "cannot read it"),
    "commas.csv": ("1,5;2,5\n".encode("utf-16"), "cannot read it"),
    "empty.png": (b"", "it is no picture, or a damaged one"),
    "short.png": (picture("PNG", size=(60, 50))[:60], DAMAGED),
    "header.png": (picture("PNG")[:20], DAMAGED),
    "signature.png": (b"\x89PNG\r\n\x1a\n" + b"\xff" * 200, DAMAGED),
    "bomb.png": (png(100_000, 100_000, ZEROS), r"1e\+10 pixels would need 320 GB of memory"),
    "within.png": (png(12_000, 12_000, b""), "it is cut off: its header claims 144,000,000 pixels"),
    "crc.png": (picture("PNG").replace(b"IDAT", b"IDAU"), DAMAGED),
    "script.png": (b"%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 9 9\n%%EndComments\n", "it is no picture"),
    "empty.bmp": (b"", "it is no picture, or a damaged one"),
    "short.bmp": (picture("BMP", "RGB", (40, 50))[:200], DAMAGED),
    "bomb.bmp": (bmp(100_000, 100_000), r"1e\+10 pixels"),
    "within.bmp": (bmp(3000, 3000), DAMAGED),
    "empty.jpg": (b"", "it is no picture, or a damaged one"),
    "short.jpg": (picture("JPEG", size=(60, 50))[:200], DAMAGED),
    "empty.tif": (b"", "it is no picture, or a damaged one"),
    "short.tif": (picture("TIFF", size=(60, 50))[:100], DAMAGED),
    "header.tif": (picture("TIFF")[:12], DAMAGED),
}  # fmt: skip


@pytest.mark.parametrize("name", NASTY)
def test_nasty_data_files(folder, name):
    data, message = NASTY[name]
    (folder / name).write_bytes(data)
    assert re.search(message, refused(folder / "case.toml", toml(MEMBRANE, support=f'{{file = "{name}"}}')))
    if not name.startswith(("letters", "ragged")):
        refused(folder / "case.toml", toml(MEMBRANE, frame=f'{{shape = "mask", file = "{name}"}}'))


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"", "it has no rows"),
        (b"x,depth\n", "two samples or more"),
        (bytes(range(256)), "case.toml"),
        ("x,depth\n0,1\n".encode("utf-16"), "not a table in UTF-8"),
        (b'x,depth\n0,"1\n', "case.toml"),
        (b"x,depth\n" + b"1" * 300_000 + b",2\n", "case.toml"),
        (b"x,depth\n0,1\n0,2\n", "line 3: x must increase, but 0 follows 0; two samples at one place"),
        (b"x,depth\n0,1\n" + b"9,1\n" * 3_000_000, "line 4: x must increase, but 9 follows 9"),
    ],
)
def test_nasty_surveys(folder, data, message):
    (folder / "survey.csv").write_bytes(data)
    support = '{profile = "sampled", file = "survey.csv"}'
    assert message in outcome(folder / "case.toml", toml(CABLE, support=support))


def test_decimal_commas_in_arrays(folder):
    from contactqp.io.cases import load_case

    (folder / "commas.csv").write_bytes(b"\xef\xbb\xbf" + b"0,5;1,5;2,5\n" * 9)
    section = '{file = "commas.csv", decimal = ",", resample = true}'
    path = folder / "case.toml"
    path.write_text(toml(MEMBRANE, support=section))
    assert load_case(path).support.min() >= 0.5
    path.write_text(toml(CABLE, support='{file = "line.csv", decimal = ","}'))
    (folder / "line.csv").write_text("1,5;2;2;2;2;2;2;2;2,25\n")
    assert load_case(path).support.tolist() == [1.5, *[2.0] * 7, 2.25]


# Generated.

NUMBERS = st.sampled_from(
    [
        "0",
        "-0.0",
        "1",
        "-1",
        "nan",
        "inf",
        "-inf",
        "1e-320",
        "1e-300",
        "1e-150",
        "1e-20",
        "1e20",
        "1e150",
        "1e300",
        "1.7976931348623157e308",
        "9223372036854775808",
    ]
) | st.integers(-(10**30), 10**30).map(str)
OTHERS = st.sampled_from(
    ["true", '""', '"0.5"', '"cone"', "[]", "[[]]", "{}", "[1, 2]", "[1e300, 1e300]", "2020-01-01", '"\\u0000"']
)
LEAVES = NUMBERS | OTHERS | st.text("aé\u2028\U0001f600", max_size=5).map(lambda text: f'"{text}"')
NAMES = st.sampled_from(
    [
        "file",
        "key",
        "factor",
        "offset",
        "resample",
        "profile",
        "depth",
        "slope",
        "radius",
        "slope_x",
        "center",
        "axis",
        "floor",
        "hill",
        "scale",
        "shape",
        "width",
        "height",
        "side",
        "corners",
        "holes",
        "threshold",
        "decimal",
        "delimiter",
        "x",
        "outside",
        "duplicates",
        "interpolation",
        "a.b",
        '""',
    ]
)
WORDS = st.sampled_from(
    [
        '"plane"',
        '"paraboloid"',
        '"cone"',
        '"cylinder"',
        '"hemisphere"',
        '"hill-and-floor"',
        '"sampled"',
        '"rectangle"',
        '"hexagon"',
        '"disk"',
        '"polygon"',
        '"mask"',
        '"good.npy"',
        '"good.csv"',
        '"bad.png"',
    ]
)
TABLES = st.dictionaries(NAMES, WORDS | LEAVES, max_size=5).map(
    lambda table: "{" + ", ".join(f"{key} = {value}" for key, value in table.items()) + "}"
)
KEYS = st.sampled_from(
    ["spacing", "tension", "load", "support", "frame", "frame_height", "origin", "title", "span", "start", "model"]
)


@pytest.mark.slow
@settings(max_examples=1200)
@given(base=st.sampled_from([MEMBRANE, CABLE]), changes=st.dictionaries(KEYS, LEAVES | TABLES, min_size=1, max_size=3))
@example(base=MEMBRANE, changes={"load": "1e300", "tension": "1e-300"})
def test_generated_cases(folder, base, changes):
    (folder / "good.npy").write_bytes(saved(np.ones((4, 5))))
    (folder / "good.csv").write_text("1,2\n3,4\n")
    (folder / "bad.png").write_bytes(picture("PNG")[:40])
    outcome(folder / "case.toml", toml(base, **changes))


FILES = {
    "f.npy": saved(np.linspace(0.1, 0.5, 20).reshape(4, 5)),
    "f.npz": archive(depth=saved(np.linspace(0.1, 0.5, 20).reshape(4, 5))),
    "f.csv": b"0.1,0.2,0.3\n0.4,0.5,0.6\n",
    "f.png": picture("PNG"),
    "f.bmp": picture("BMP"),
    "f.jpg": picture("JPEG", size=(16, 16)),
    "f.tif": picture("TIFF"),
    "case.toml": toml(MEMBRANE, support='{file = "f.npy", resample = true}').encode(),
}


@pytest.mark.slow
@settings(max_examples=800)
@given(
    name=st.sampled_from(list(FILES)),
    cut=st.floats(0.0, 1.0),
    flips=st.dictionaries(st.floats(0.0, 1.0), st.integers(1, 255), max_size=4),
)
def test_generated_damage(folder, name, cut, flips):
    data = bytearray(FILES[name])
    for place, bits in flips.items():
        data[int(place * (len(data) - 1))] ^= bits
    del data[len(data) - int(cut * len(data) / 2) :]
    if name == "case.toml":
        (folder / "f.npy").write_bytes(FILES["f.npy"])
        outcome(folder / "case.toml", bytes(data))
    else:
        (folder / name).write_bytes(bytes(data))
        assume(len(data))
        outcome(folder / "case.toml", toml(MEMBRANE, support=f'{{file = "{name}", resample = true}}'))


# The whole command, measured.

MEASURED = """
import resource, subprocess, sys
done = subprocess.run(sys.argv[1:], capture_output=True, text=True)
sys.stderr.write(done.stderr)
print(done.returncode, resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)
"""
"""Runs a command from a small process: the system counts the memory of the process that starts one, too."""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "changes"),
    [
        ("bomb.png", {}),
        ("within.png", {}),
        ("bomb.bmp", {}),
        ("claims.npy", {}),
        ("claims.npz", {}),
        ("", {"spacing": "1e-5"}),
        ("", {"a": "[" * 5000 + "]" * 5000}),
        ("", {".".join("a" * 5000): "1"}),
    ],
)
@pytest.mark.skipif(not hasattr(os, "wait4"), reason="the system does not tell what a process took")
def test_time_and_memory_of_the_whole_command(folder, name, changes):
    path = folder / "case.toml"
    if name:
        (folder / name).write_bytes(NASTY[name][0])
        changes = {"support": f'{{file = "{name}"}}'}
    path.write_text(toml(MEMBRANE, **changes))
    command = [sys.executable, "-c", "from contactqp.cli.commands import main; main()", "solve", str(path)]
    started = time.perf_counter()
    done = subprocess.run([sys.executable, "-c", MEASURED, *command], capture_output=True, text=True, check=True)
    code, used = map(int, done.stdout.split())
    assert time.perf_counter() - started < SECONDS * PATIENCE
    assert code == 2
    assert done.stderr.startswith("contactqp: ")
    assert done.stderr.count("\n") == 1
    assert used * (1 if sys.platform == "darwin" else 1024) < BYTES


def test_a_truncated_file_is_told_in_words_and_not_by_a_number(tmp_path):
    file = cq.solve(cq.gallery.bowl(7)).save(tmp_path / "answer.nc")
    file.write_bytes(file.read_bytes()[:2000])
    for reader in (cq.load_solution, cq.read_surface):
        with pytest.raises((OSError, ValueError), match="it is no NetCDF file, or a damaged one: ") as caught:
            reader(file)
        assert "Errno" not in str(caught.value)
