"""Sampled heights from files: values as they are stored, rows, missing values and geo-transforms."""

import struct
import zlib

import numpy as np
import pytest
from PIL import Image
from PIL.TiffImagePlugin import ImageFileDirectory_v2
from typer.testing import CliRunner

import contactqp as cq
from contactqp.cli.commands import app
from contactqp.io.cases import load_case
from contactqp.io.rasters import read_picture, read_tiff

SIDE = 0.5
LATTICE = cq.Frame.rectangle(3.0, 2.0).lattice(SIDE)  # 5 x 3 nodes in an array of 7 x 5
RAMP = np.arange(35.0).reshape(5, 7)


def write_tiff(path, values, no_data=None, place=None, point=False, matrix=None, **options):
    tags = ImageFileDirectory_v2()
    if no_data is not None:
        tags[42113] = no_data
    if place is not None:  # x of the left edge and y of the upper one
        tags.tagtype[33550] = tags.tagtype[33922] = tags.tagtype[34264] = 12
        tags[33550] = (SIDE, SIDE, 0.0)
        tags[33922] = (0.0, 0.0, 0.0, *place, 0.0)
        tags.tagtype[34735] = 3
        tags[34735] = (1, 1, 0, 1, 1025, 0, 1, 2 if point else 1)
    if matrix is not None:
        tags.tagtype[34264] = 12
        tags[34264] = matrix
    Image.fromarray(values).save(path, tiffinfo=tags, **options)
    return path


@pytest.fixture
def case(tmp_path):
    def write(support, more="", load="1.0", frame='{shape = "rectangle", width = 3.0, height = 2.0}'):
        path = tmp_path / "case.toml"
        lines = [
            f"spacing = {SIDE}",
            "tension = 1.0",
            f"load = {load}",
            f"support = {support}",
            f"frame = {frame}",
            more,
        ]
        path.write_text("\n".join(lines))
        return path

    return write


@pytest.mark.parametrize("compression", [None, "tiff_lzw", "tiff_adobe_deflate"])
@pytest.mark.parametrize("kind", ["f4", "u2", "i4", "u1"])
def test_values_of_a_tiff_are_as_stored(tmp_path, kind, compression):
    stored = np.array([[0, 3, 200], [7, 4, 1]], kind)
    if kind == "f4":
        stored = stored * np.float32(2.0) + np.float32(0.3)
    elif kind != "u1":
        stored[0, 2] = 400 if kind == "u2" else -70000
    found = read_tiff(write_tiff(tmp_path / "f.tif", stored, compression=compression)).values
    assert found.dtype == np.dtype(kind)
    np.testing.assert_array_equal(found, stored)


def test_elevations_in_metres_stay_metres(case, tmp_path):
    heights = (400 + RAMP / 10).astype("f4")
    write_tiff(tmp_path / "dem.tif", heights[::-1].copy())
    model = load_case(case('{file = "dem.tif"}', "upwards = true\nframe_height = 405.0"))
    np.testing.assert_array_equal(model.support, LATTICE.gather(heights))
    shifted = load_case(case('{file = "dem.tif", offset = 800.0, factor = -1.0}'))
    np.testing.assert_array_equal(shifted.support, LATTICE.gather(800.0 - heights.astype(float)))


@pytest.mark.parametrize("rows", ["up", "down", None])
def test_one_array_touches_at_one_place_whatever_file_it_is_in(case, tmp_path, rows):
    """Higher ground in the array's first row: y of the contact's middle goes by ``rows``, not by the file."""
    levels = np.array([20, 60, 100, 140, 180], "u1")[:, None] * np.ones(7, "u1")
    np.save(tmp_path / "f.npy", levels / 255)
    np.savez(tmp_path / "f.npz", levels / 255)
    np.savetxt(tmp_path / "f.csv", levels / 255, delimiter=",")
    Image.fromarray(levels).save(tmp_path / "f.png")
    Image.fromarray(levels).save(tmp_path / "f.bmp")
    write_tiff(tmp_path / "f.tif", (levels / 255).astype("f4"))
    told = "" if rows is None else f', rows = "{rows}"'
    for suffix, own in (("npy", "up"), ("npz", "up"), ("csv", "up"), ("png", "down"), ("bmp", "down"), ("tif", "down")):
        solution = cq.solve(load_case(case(f'{{file = "f.{suffix}"{told}}}', load="0.8")))
        middle = LATTICE.node_y[solution.contact].mean()
        assert middle == pytest.approx(-0.5 if (rows or own) == "up" else 0.5), suffix


def test_pictures_hold_grey_levels_of_eight_bits(tmp_path):
    colours = np.array([[[255, 0, 0, 9], [255, 255, 255, 0]]], "u1")
    for mode, expected in (("RGBA", [[1 / 3, 1.0]]), ("RGB", [[1 / 3, 1.0]])):
        Image.fromarray(colours[..., : len(mode)]).save(tmp_path / "p.png")
        np.testing.assert_allclose(read_picture(tmp_path / "p.png").values, expected)
    Image.fromarray(np.array([[0, 51, 255]], "u1")).save(tmp_path / "g.png")
    np.testing.assert_allclose(read_picture(tmp_path / "g.png").values, [[0, 0.2, 1]])
    Image.fromarray(np.array([[0, 400]], "u2")).save(tmp_path / "deep.png")
    with pytest.raises(cq.CaseFileError, match=r"a picture of 16 bits: .*save numbers as \.tif or \.npy"):
        read_picture(tmp_path / "deep.png")
    (tmp_path / "rgb.png").write_bytes(png_of_deep_colours())
    with pytest.raises(cq.CaseFileError, match="a picture of 16 bits"):
        read_picture(tmp_path / "rgb.png")
    with pytest.raises(cq.CaseFileError, match="no picture, or a damaged one"):
        read_picture(write_text(tmp_path / "no.png"))


def write_text(path):
    path.write_text("no picture")
    return path


def png_of_deep_colours():
    """Return a PNG of one pixel with 16 bits for each of red, green and blue, of which Pillow keeps 8."""

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", 1, 1, 16, 2, 0, 0, 0)
    pixel = zlib.compress(b"\0" + struct.pack(">HHH", 400, 400, 400))
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", pixel) + chunk(b"IEND", b"")


def test_tiffs_whose_values_cannot_be_had_are_refused(tmp_path):
    Image.fromarray(np.zeros((2, 2, 3), "u1")).save(tmp_path / "f.tif")
    with pytest.raises(cq.CaseFileError, match="a TIFF file of 3 bands"):
        read_tiff(tmp_path / "f.tif")
    pages = [Image.fromarray(np.full((2, 2), k, "f4")) for k in range(2)]
    pages[0].save(tmp_path / "p.tif", save_all=True, append_images=pages[1:])
    with pytest.raises(cq.CaseFileError, match="a TIFF file of several pages"):
        read_tiff(tmp_path / "p.tif")
    Image.fromarray(np.eye(2, dtype="u1")).convert("P").save(tmp_path / "c.tif")
    with pytest.raises(cq.CaseFileError, match="as they are stored"):
        read_tiff(tmp_path / "c.tif")
    write_text(tmp_path / "t.tif")
    with pytest.raises(cq.CaseFileError, match="it is no picture, or a damaged one, or a kind of TIFF"):
        read_tiff(tmp_path / "t.tif")
    turned = [1.0, 0.5, 0, 0, 0.5, -1.0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1.0]
    with pytest.raises(cq.CaseFileError, match="turns or shears the rows"):
        read_tiff(write_tiff(tmp_path / "r.tif", RAMP.astype("f4"), matrix=turned))
    with pytest.raises(cq.CaseFileError, match="no-data value is 'none'"):
        read_tiff(write_tiff(tmp_path / "n.tif", RAMP.astype("f4"), no_data="none"))


def test_pictures_are_refused_by_the_size_in_their_header(tmp_path, monkeypatch):
    Image.fromarray(np.zeros((20, 20), "u1")).save(tmp_path / "f.png")
    write_tiff(tmp_path / "f.tif", np.zeros((20, 20), "f4"))
    monkeypatch.setenv("CONTACTQP_MAX_POINTS", "399")
    for limit in (300, 100):  # beyond the first, Pillow warns, beyond the second it refuses
        monkeypatch.setattr(Image, "MAX_IMAGE_PIXELS", limit)
        for read, name in ((read_picture, "f.png"), (read_tiff, "f.tif")):
            with pytest.raises(ValueError, match=r"400 pixels would need .* at most 399 are taken"):
                read(tmp_path / name)


@pytest.mark.parametrize("no_data", ["-9999", "-3.4028234663852886e+38", "nan"])
def test_missing_values_are_refused_by_node_or_taken_for_no_support(case, tmp_path, no_data):
    stored = RAMP.astype("f4")
    stored[0, 0] = stored[2, 3] = float(no_data)  # a frame point, and the node in the middle
    write_tiff(tmp_path / "f.tif", stored, no_data=no_data)
    with pytest.raises(
        cq.CaseFileError, match=r"support.file = 'f.tif': it holds no value at node 7 \(x=0, y=0\); fill"
    ):
        load_case(case('{file = "f.tif"}'))
    model = load_case(case('{file = "f.tif", missing = "none"}'))
    assert np.flatnonzero(~model.supported).tolist() == [7]
    above = "upwards = true\nframe_height = 99.0"
    assert load_case(case('{file = "f.tif", missing = "none"}', above, load="100.0")).support[7] == -np.inf
    np.savetxt(tmp_path / "f.csv", np.where(stored == np.float32(no_data), np.nan, stored), delimiter=",")
    model = load_case(case('{file = "f.csv", missing = "none"}'))
    assert np.count_nonzero(~model.supported) == 1
    with pytest.raises(cq.CaseFileError, match=r'load.missing = "none" goes with a support or a ceiling only'):
        load_case(case("1.0", load='{file = "f.tif", missing = "none"}'))


def test_a_case_can_tell_what_stands_for_no_value(case, tmp_path):
    grid = RAMP.copy()
    grid[2, 3] = -9999
    np.save(tmp_path / "f.npy", grid)
    with pytest.warns(cq.ContactWarning, match=r"support is -9999 at node 7 \(x=0, y=0\)"):
        load_case(case('{file = "f.npy"}'))
    model = load_case(case('{file = "f.npy", no_data = -9999.0, missing = "none", offset = 5.0}'))
    assert model.support[7] == np.inf
    assert model.support[6] == 21.0
    coarse = '{file = "f.npy", no_data = -9999.0, missing = "none", resample = true}'
    fine = load_case(case(coarse).with_name("case.toml"))
    assert np.flatnonzero(~fine.supported).tolist() == [7]


@pytest.mark.parametrize("point", [False, True])
def test_a_geo_transform_tells_where_values_lie(case, tmp_path, point):
    """A file that is larger than the lattice, north up, with values x + 10 y at the middles of its pixels."""
    x, y = SIDE * np.arange(-10, 12), SIDE * np.arange(9, -8, -1)
    edge = 0.0 if point else SIDE / 2
    values = (100 + x + 10 * y[:, None]).astype("f4")
    write_tiff(tmp_path / "f.tif", values, place=(x[0] - edge, y[0] + edge), point=point)
    expected = 100 + LATTICE.node_x + 10 * LATTICE.node_y
    np.testing.assert_allclose(load_case(case('{file = "f.tif"}')).support, expected)
    np.testing.assert_allclose(load_case(case('{file = "f.tif", rows = "down"}')).support, expected)
    with pytest.raises(cq.CaseFileError, match="rows = 'up', but by its geo-transform they go down"):
        load_case(case('{file = "f.tif", rows = "up"}'))
    moved = '{shape = "rectangle", width = 3.0, height = 2.0, center = [0.1, 0.2]}'
    with pytest.raises(cq.CaseFileError, match=r"its values lie between the nodes; .*resample = true"):
        load_case(case('{file = "f.tif"}', frame=moved))
    model = load_case(case('{file = "f.tif", resample = true}', frame=moved))
    np.testing.assert_allclose(model.support, 100 + model.node_x + 10 * model.node_y, rtol=1e-6)
    far = '{shape = "rectangle", width = 3.0, height = 2.0, center = [20, 0]}'
    with pytest.raises(cq.CaseFileError, match=r"from x = -5 to 5.5, but nodes lie from 19 to 21; place the frame"):
        load_case(case('{file = "f.tif"}', frame=far))
    with pytest.raises(cq.CaseFileError, match=r"has shape \(17, 22\), the lattice \(5, 7\)"):
        load_case(case('{file = "f.tif", transform = false}'))


def test_a_mask_with_a_geo_transform_lies_where_that_puts_it(case, tmp_path):
    mask = np.array([[1, 0, 1], [1, 1, 1]], "u1")
    write_tiff(tmp_path / "m.tif", mask, place=(10.0, 21.0))
    frame = '{shape = "mask", file = "m.tif"}'
    lattice = load_case(case("1.0", frame=frame)).lattice
    assert lattice.origin == (10.25, 20.25)
    np.testing.assert_array_equal(lattice.mask, mask[::-1] > 0)
    with pytest.raises(cq.CaseFileError, match=r"steps of 0.5 and 0.5 from \(10.25, 20.25\), the case spacing = 0.5"):
        load_case(case("1.0", frame=frame, more="origin = [0.0, 0.0]"))
    free = load_case(case("1.0", frame=frame.replace("}", ", transform = false}"), more="origin = [1.0, 2.0]"))
    assert free.lattice.origin == (1.0, 2.0)
    np.save(tmp_path / "m.npy", mask)
    for rows, expected in (("up", mask), ("down", mask[::-1])):
        told = f'{{shape = "mask", file = "m.npy", rows = "{rows}"}}'
        np.testing.assert_array_equal(load_case(case("1.0", frame=told)).lattice.mask, expected > 0)


def test_elevations_in_case_files(case, tmp_path):
    (tmp_path / "bed.csv").write_text("x,z\n0,-1.0\n4,-3.0\n")
    section = '{profile = "sampled", file = "bed.csv", depth = "z"}'
    text = f'model = "cable"\nspan = 4\nspacing = 1\ntension = 1\nload = 1\nsupport = {section}\nupwards = true\n'
    path = tmp_path / "cable.toml"
    path.write_text(text + f"frame_height = {section}\n")
    cable = load_case(path)
    np.testing.assert_array_equal(cable.support, [-1.5, -2.0, -2.5])
    np.testing.assert_allclose(cq.solve(cable).deflection, cable.support)
    up = load_case(case("-0.3", "upwards = true"))
    down = load_case(case("0.3"))
    np.testing.assert_array_equal(cq.solve(up).deflection, -cq.solve(down).deflection)
    with pytest.raises(cq.CaseFileError, match="upwards: input should be a valid boolean"):
        load_case(case("-0.3", 'upwards = "yes"'))
    dome = '{profile = "hemisphere", depth = 0.1, radius = 0.8}'
    np.testing.assert_array_equal(load_case(case(dome, "upwards = true")).support, -load_case(case(dome)).support)


def test_an_answer_to_a_case_of_rasters_must_say_which_way_its_rows_go(case, tmp_path):
    write_tiff(tmp_path / "f.tif", (0.1 + RAMP / 100).astype("f4"))
    path = case('{file = "f.tif"}', load="0.8")
    model = load_case(path)
    assert model.rows == "down"
    solution = cq.solve(model)
    data = solution.to_dataset()
    np.save(tmp_path / "vector.npy", solution.gap)
    np.save(tmp_path / "grid.npy", data["gap"].values)
    data.to_netcdf(tmp_path / "fields.nc")
    arguments = ["certify", str(path), str(tmp_path / "grid.npy")]
    refused = CliRunner().invoke(app, arguments)
    assert refused.exit_code == 2
    assert "say --rows down if its first row has the largest y, --rows up if the smallest" in refused.stderr
    assert CliRunner().invoke(app, [*arguments, "--rows", "up"]).exit_code == 0
    assert CliRunner().invoke(app, [*arguments, "--rows", "down"]).exit_code == 1
    for name in ("vector.npy", "fields.nc"):
        assert CliRunner().invoke(app, ["certify", str(path), str(tmp_path / name)]).exit_code == 0


@pytest.mark.parametrize("suffix", ["npy", "tif"])
def test_a_model_of_a_case_is_the_same_whichever_way_the_rows_of_its_files_go(case, tmp_path, suffix):
    heights = 0.1 + RAMP / 100
    np.save(tmp_path / "load.npy", 1 + heights)
    write_tiff(tmp_path / "f.tif", heights[::-1].copy())
    np.save(tmp_path / "f.npy", heights)
    model = load_case(case(f'{{file = "f.{suffix}"}}', load='{file = "load.npy"}'))
    assert model.rows == ("up" if suffix == "npy" else "down")
    np.testing.assert_allclose(model.support, LATTICE.gather(heights), rtol=1e-6)
    np.testing.assert_array_equal(model.load, LATTICE.gather(1 + heights))
