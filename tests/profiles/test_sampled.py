"""Depth profiles that were sampled at abscissae, from arrays and from CSV files."""

import subprocess
import sys

import numpy as np
import pytest

import contactqp as cq
from contactqp.profiles import Plane, Sampled, Uppermost

X, DEPTH = [0.0, 2.0, 3.0, 7.0], [1.0, 2.0, 2.0, -2.0]
TABLE = "station, x, depth\na, 0, 1.0\nb, 2, 2.0\n\nc, 3, 2.0\nd, 7, -2.0\n"


@pytest.fixture
def csv(tmp_path):
    def write(text, name="bed.csv"):
        path = tmp_path / name
        path.write_text(text, encoding="utf-8")
        return path

    return write


def test_between_samples_the_profile_is_straight():
    bed = Sampled(X, DEPTH)
    np.testing.assert_allclose(bed([0.0, 0.5, 2.0, 2.5, 4.0, 7.0], 0.0), [1.0, 1.25, 2.0, 2.0, 1.0, -2.0])
    assert repr(bed) == "Sampled(4 samples, x from 0 to 7, linear)"


def test_it_is_the_same_for_all_y():
    bed = Sampled(X, DEPTH)
    grid = bed(np.array([[0.0, 1.0, 2.0]]), np.array([[5.0], [6.0]]))
    np.testing.assert_allclose(grid, [[1.0, 1.5, 2.0]] * 2)
    np.testing.assert_allclose(Uppermost(bed, Plane(1.2))([1.0, 5.0], 0.0), [1.2, 0.0])


def test_pchip_is_smooth_and_does_not_overshoot():
    bed = Sampled(X, DEPTH, interpolation="pchip")
    np.testing.assert_array_equal(bed(X), DEPTH)
    fine = np.linspace(0, 7, 701)
    depth = bed(fine)
    assert depth.max() == 2.0
    assert np.abs(np.diff(depth, 2)).max() < 3e-4
    assert np.abs(np.diff(Sampled(X, DEPTH)(fine), 2)).max() > 9e-3
    assert not np.allclose(depth, Sampled(X, DEPTH)(fine), atol=0.05)


@pytest.mark.parametrize("interpolation", ["linear", "pchip"])
def test_what_happens_outside_the_samples_is_chosen(interpolation):
    outside = [-1.0, 7.5]
    with pytest.raises(ValueError, match=r"x = -1 lies outside the samples, which go from 0 to 7.*outside='hold'"):
        Sampled(X, DEPTH, interpolation=interpolation)(outside)
    np.testing.assert_array_equal(Sampled(X, DEPTH, interpolation=interpolation, outside="hold")(outside), [1.0, -2.0])
    np.testing.assert_array_equal(Sampled(X, DEPTH, interpolation=interpolation, outside="none")(outside), [np.inf] * 2)


def test_the_last_sample_is_not_missed_by_rounding():
    """A node at 0.1 + 2 x 0.1 lies an ulp beyond a last sample at 0.3."""
    cable = cq.Cable(nodes=3, spacing=0.1, tension=1.0, load=1.0, support=Sampled([0.1, 0.2, 0.3], [1.0, 2.0, 4.0]))
    assert cable.lattice.node_x[2] > 0.3
    np.testing.assert_allclose(cable.support, [1.0, 2.0, 4.0])


def test_a_cable_takes_it_as_ground_and_for_the_heights_of_its_ends():
    bed = Sampled([0.0, 4.0], [1.0, 3.0])
    cable = cq.Cable(span=4.0, spacing=1.0, tension=1.0, load=0.0, support=bed, frame_height=bed)
    np.testing.assert_array_equal(cable.support, [1.5, 2.0, 2.5])
    np.testing.assert_array_equal(cable.problem.q, [0.0, 0.0, 0.0])


def test_samples_are_copied_and_read_only():
    x, depth = np.array(X), np.array(DEPTH)
    bed = Sampled(x, depth)
    depth[:] = 9.0
    assert bed(0.0) == 1.0
    with pytest.raises(ValueError, match="read-only"):
        bed.depth[0] = 2.0


@pytest.mark.parametrize("columns", [{}, {"x": 1, "depth": 2}, {"x": "x", "depth": 2}])
def test_columns_are_chosen_by_name_or_by_position(csv, columns):
    bed = Sampled.from_csv(csv(TABLE), **columns)
    np.testing.assert_array_equal(bed.x, X)
    np.testing.assert_array_equal(bed.depth, DEPTH)


def test_a_table_without_a_header_is_read_by_position(csv):
    text = "# survey of the made-up bed\n0;1\n2;2\n3;2\n7;-2\n"
    bed = Sampled.from_csv(csv(text), x=0, depth=1, delimiter=";", interpolation="pchip", outside="hold")
    np.testing.assert_array_equal(bed.depth, DEPTH)
    assert bed(8.0) == -2.0
    assert repr(bed) == "Sampled(4 samples, x from 0 to 7, pchip, outside='hold')"


def test_a_byte_order_mark_is_no_part_of_a_name(csv):
    np.testing.assert_array_equal(Sampled.from_csv(csv("\ufeffx,depth\n0,1\n2,3\n")).x, [0.0, 2.0])


@pytest.mark.parametrize(
    ("text", "columns", "message"),
    [
        (TABLE, {"depth": "z"}, r"bed.csv: no column 'z'; it has station, x, depth"),
        (TABLE, {"depth": "dept"}, r"no column 'dept'; .*; did you mean 'depth'\?"),
        (TABLE, {"depth": 3}, r"bed.csv, line 2: no column 3, it has 3 columns, counted from 0"),
        ("x,depth,x\n0,1,2\n1,2,3\n", {}, r"bed.csv: 2 columns are called 'x'; choose one by position"),
        (TABLE.replace("2.0\n\n", "two\n\n"), {}, r"bed.csv, line 3: depth is 'two', which is no number"),
        (TABLE.replace("1.0", ""), {}, r"bed.csv, line 2: depth is '', which is no number"),
        (TABLE.replace("1.0", "nan"), {}, r"bed.csv, line 2: depth must be finite, got nan"),
        (TABLE.replace("c, 3, 2.0", "c"), {}, r"bed.csv, line 5: no column 1, it has 1 column, counted from 0"),
        (TABLE.replace("7", "3"), {}, r"bed.csv, line 6: x must increase, but 3 follows 3"),
        (TABLE.replace("7", "1"), {}, r"bed.csv, line 6: x must increase, but 1 follows 3; sort the samples"),
        ("x,depth\n0,1\n", {}, r"bed.csv: a profile needs two samples or more, got 1"),
        ("# nothing\n", {}, r"bed.csv: it has no rows"),
        ("x,depth\n", {}, r"bed.csv: a profile needs two samples or more, got 0"),
        ("a,b\n1,2\n3,4\n", {"x": 0, "depth": 0}, r"x and depth must be different columns, got 0 for both"),
    ],
)
def test_bad_tables_name_file_line_and_value(csv, text, columns, message):
    with pytest.raises(ValueError, match=message):
        Sampled.from_csv(csv(text), **columns)


def test_a_table_that_is_not_there_or_is_no_text(tmp_path):
    with pytest.raises(FileNotFoundError, match=r"nowhere.csv"):
        Sampled.from_csv(tmp_path / "nowhere.csv")
    (tmp_path / "bed.csv").write_bytes(b"x,depth\n0,\xff\n")
    with pytest.raises(ValueError, match=r"bed.csv: not a table in UTF-8"):
        Sampled.from_csv(tmp_path / "bed.csv")


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        ({"x": [0.0, 1.0]}, ValueError, r"depth must have shape \(2,\), got \(4,\)"),
        ({"x": [[0.0, 1.0]]}, ValueError, r"x must have one dimension, got shape \(1, 2\)"),
        ({"x": [0.0], "depth": [1.0]}, ValueError, "two samples or more, got 1"),
        ({"x": [0.0, 2.0, 2.0, 3.0]}, ValueError, r"x must increase, but x\[2\] = 2 follows x\[1\] = 2"),
        ({"x": [0.0, np.nan, 2.0, 3.0]}, ValueError, "x must be finite, but entry 1 is nan"),
        ({"depth": [0.0, 1.0, np.inf, 3.0]}, ValueError, "depth must be finite, but entry 2 is inf"),
        ({"depth": ["a", "b", "c", "d"]}, TypeError, "depth must hold real numbers"),
        ({"interpolation": "cubic"}, ValueError, "interpolation must be one of 'linear', 'pchip', got 'cubic'"),
        ({"outside": "extend"}, ValueError, "outside must be one of 'error', 'hold', 'none', got 'extend'"),
    ],
)
def test_bad_samples_say_what_is_wrong(arguments, error, message):
    with pytest.raises(error, match=message):
        Sampled(**({"x": X, "depth": DEPTH} | arguments))


def test_a_linear_profile_is_read_without_scipy_or_pandas(csv):
    code = (
        "import sys; from contactqp.profiles import Sampled; "
        f"Sampled.from_csv({str(csv(TABLE))!r})(1.0); print([n for n in ('scipy', 'pandas') if n in sys.modules])"
    )
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert result.stdout.strip() == "[]"


DOUBLED = "km;z\n0;1,5\n2;3,0\n2;1,0\n2;2,0\n5;4,0\n"


@pytest.mark.parametrize(
    ("duplicates", "depth"), [("mean", 2.0), ("first", 3.0), ("last", 2.0), ("shallowest", 1.0), ("deepest", 3.0)]
)
def test_one_of_several_samples_at_one_place_is_kept(csv, duplicates, depth):
    bed = Sampled.from_csv(csv(DOUBLED), "km", "z", delimiter=";", decimal=",", duplicates=duplicates)
    assert bed.x.tolist() == [0.0, 2.0, 5.0]
    assert bed.depth.tolist() == [1.5, depth, 4.0]


@pytest.mark.parametrize(
    ("text", "options", "message"),
    [
        (
            DOUBLED,
            {},
            r"line 4: x \(column 'km'\) must increase, but 2 follows 2; two samples .*'deepest'",
        ),
        (
            DOUBLED.replace("5;", "1;"),
            {"duplicates": "mean"},
            r"line 6: x \(column 'km'\) must increase, but 1 follows 2",
        ),
        (DOUBLED, {"decimal": "."}, r"line 2: depth \(column 'z'\) is '1,5', which is no number; decimal=',' reads it"),
        (DOUBLED.replace("3,0", "deep"), {}, r"line 3: depth \(column 'z'\) is 'deep', which is no number$"),
        (DOUBLED, {"duplicates": "best"}, r"duplicates must be one of 'error', .*'deepest', got 'best'"),
        (DOUBLED, {"delimiter": ","}, r"delimiter and decimal must differ, got ',' for both"),
        (DOUBLED, {"decimal": "'"}, r"decimal must be '\.' or ',', got \"'\""),
        (DOUBLED, {"delimiter": ";;"}, r"delimiter must be one character .*, got ';;'"),
        (DOUBLED, {"delimiter": "5"}, r"delimiter must be one character that is in no number"),
        ("km;z\n2;1\n2;3\n", {"duplicates": "mean"}, r"bed.csv: a profile needs two samples or more, got 1"),
    ],
)
def test_columns_are_told_by_name_and_decimals_by_their_sign(csv, text, options, message):
    with pytest.raises(ValueError, match=message):
        Sampled.from_csv(csv(text), "km", "z", **({"delimiter": ";", "decimal": ","} | options))


def test_cells_that_only_the_slow_reader_knows(csv):
    """Quoted cells with line breaks, rows of empty cells, and underscores in numbers."""
    text = 'name,x,depth\n"a\nb",0,1\n,,\nc,1_0,2\n\n# note\nd,20,3\n'
    assert Sampled.from_csv(csv(text)).x.tolist() == [0.0, 10.0, 20.0]
    with pytest.raises(ValueError, match=r"line 8: depth is 'x', which is no number"):
        Sampled.from_csv(csv(text.replace("20,3", "20,x")))


@pytest.mark.parametrize("last", ["1,1", "3000000,deep", "3000000,nan"])
def test_millions_of_rows_are_refused_at_their_last_line_without_being_read_cell_by_cell(csv, monkeypatch, last):
    from contactqp.profiles import sample_files

    rows = 100_000
    path = csv("x,depth\n" + "\n".join(f"{k},1" for k in range(rows)) + f"\n{last}\n")
    cells = []
    number = sample_files._Table.number
    monkeypatch.setattr(sample_files._Table, "number", lambda table, cell: cells.append(cell) or number(table, cell))
    with pytest.raises(ValueError, match=rf"line {rows + 2}: "):
        Sampled.from_csv(path)
    assert len(cells) < 20


def test_a_table_that_is_not_there_is_told_by_its_name(tmp_path):
    with pytest.raises(FileNotFoundError, match=r"^there is no file .*bed\.csv$"):
        Sampled.from_csv(tmp_path / "bed.csv")
    with pytest.raises(FileNotFoundError, match=r"^there is no file .*bed\.xyz$"):
        cq.profiles.Scattered.from_file(tmp_path / "bed.xyz")
