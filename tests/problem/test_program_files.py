"""Problems as files, read again to the bit, and by the programs that they are for."""

import subprocess
import sys

import highspy
import numpy as np
import pytest
from scipy import io

import contactqp as cq
from contactqp.problem.program_files import PROBLEM_WRITERS
from contactqp.problem.read import PROBLEM_READERS

UNEVEN = cq.ContactQP(
    [[2.1, -1 / 3, 0.0], [-1 / 3, np.pi, -1e-9], [0.0, -1e-9, 1.0]],
    [-1 / 7, 0.0, 1e-20],
    lower=[0.0, -np.inf, -1 / 3],
    upper=[np.inf, 1 / 9, 0.0],
)
RING = 2 * np.eye(4) - np.roll(np.eye(4), 1, 0) - np.roll(np.eye(4), -1, 0)
PERIODIC = cq.ContactQP(RING, [-2.0, 0.0, 3.0, 0.0], kernel="constant")
LCP = cq.ContactLCP([[3.0, -0.5], [-2.0, 3.0]], [-6.0, 1.0], upper=[1.0, np.inf])
PROBLEMS = {"hexagon": cq.gallery.paper_hexagon().problem, "uneven": UNEVEN, "periodic": PERIODIC}


def same(one, other):
    assert type(one) is type(other)
    assert (one.G != other.G).nnz == 0
    for name in ("q", "lower", "upper"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))


@pytest.mark.parametrize("suffix", PROBLEM_WRITERS)
@pytest.mark.parametrize("name", PROBLEMS)
def test_what_is_written_is_read_again_to_the_bit(tmp_path, suffix, name):
    problem = PROBLEMS[name]
    file = problem.write(tmp_path / f"problem{suffix}")
    lost = suffix in (".mps", ".lp") and problem.kernel is not None
    again = cq.read(file, kernel="constant" if lost else None)
    same(problem, again)
    solution = cq.solve(again, tol=1e-9)
    assert solution.status.ok
    np.testing.assert_allclose(solution.gap, cq.solve(problem, tol=1e-9).gap, atol=2e-9 * problem.gap_scale)


@pytest.mark.parametrize("suffix", [".npz", ".mtx"])
def test_a_problem_that_is_not_symmetric_is_kept(tmp_path, suffix):
    same(LCP, cq.read(LCP.write(tmp_path / f"lcp{suffix}")))


@pytest.mark.parametrize("suffix", [".mps", ".lp"])
def test_highs_solves_what_is_written_for_it(tmp_path, suffix):
    file = UNEVEN.write(tmp_path / f"problem{suffix}")
    highs = highspy.Highs()
    highs.setOptionValue("output_flag", False)
    highs.readModel(str(file))
    highs.run()
    assert highs.getModelStatus() == highspy.HighsModelStatus.kOptimal
    np.testing.assert_allclose(highs.getSolution().col_value, cq.solve(UNEVEN).gap, atol=1e-6)
    with pytest.raises(cq.UnsuitableProblemError):
        LCP.write(tmp_path / f"lcp{suffix}")


def test_the_gap_scale_of_a_model_goes_with_its_arrays(tmp_path):
    problem = cq.gallery.paper_hexagon().problem
    assert cq.read(problem.write(tmp_path / "hexagon.npz")).gap_scale == problem.gap_scale


def test_matrix_market_reads_what_is_written_for_it(tmp_path):
    UNEVEN.write(tmp_path / "x.mtx")
    assert io.mminfo(tmp_path / "x.mtx")[-1] == "symmetric"
    np.testing.assert_array_equal(io.mmread(tmp_path / "x.mtx").toarray(), UNEVEN.G.toarray())
    np.testing.assert_array_equal(io.mmread(tmp_path / "x_upper.mtx")[:, 0], UNEVEN.upper)
    cq.ContactQP(np.eye(2), [1.0, -1.0]).write(tmp_path / "x.mtx")  # what is left of the first would be wrong
    assert sorted(path.name for path in tmp_path.iterdir()) == ["x.mtx", "x_q.mtx"]
    (tmp_path / "x_q.mtx").unlink()
    with pytest.raises(FileNotFoundError, match=r"x_q\.mtx with the forces"):
        cq.read(tmp_path / "x.mtx")


def test_a_singular_matrix_in_a_file_is_told_of_to_the_end(tmp_path):
    file = PERIODIC.write(tmp_path / "a-file-with-a-long-name-of-its-own.mps")
    with pytest.raises(ValueError, match="its row sums are zero: pass kernel='constant' if contact alone is to hold"):
        cq.read(file)


def test_nothing_is_printed_where_highs_reads(tmp_path):
    UNEVEN.write(tmp_path / "x.mps")
    code = f"import contactqp as cq; cq.read({str(tmp_path / 'x.mps')!r})"
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert (result.stdout, result.stderr) == ("", "")


def test_a_dense_matrix_of_ones_own_is_read(tmp_path):
    np.savez(tmp_path / "own.npz", G=UNEVEN.G.toarray(), q=UNEVEN.q, lower=UNEVEN.lower, upper=UNEVEN.upper, note=1)
    same(UNEVEN, cq.read(tmp_path / "own.npz"))


@pytest.mark.parametrize(
    ("name", "text", "told"),
    [
        ("rows.lp", "min\n obj: x + [ x * x ] / 2\nst\n c: x >= 1\nend\n", "1 rows of constraints"),
        ("linear.lp", "min\n obj: x\nst\nbounds\n 0 <= x\nend\n", "no quadratic part"),
        ("most.lp", "max\n obj: x - [ x * x ] / 2\nst\nend\n", "to be maximised|HiGHS cannot read it"),
        ("whole.lp", "min\n obj: x + [ x * x ] / 2\nst\ngeneral\n x\nend\n", "integers"),
        ("broken.mps", "NAME x\nROWZ\n", "HiGHS cannot read it"),
        ("no.npz", "PK", "no file of arrays, or a damaged one"),
        ("no.txt", "", "unknown kind of problem '.txt'; known: .mps .lp .npz .mtx"),
    ],
)
def test_files_of_other_things_are_refused_in_words(tmp_path, name, text, told):
    file = tmp_path / name
    file.write_text(text)
    with pytest.raises(ValueError, match=told) as error:
        cq.read(file)
    assert str(file) in str(error.value)


def test_missing_arrays_and_files_are_named(tmp_path):
    np.savez(tmp_path / "own.npz", G=np.eye(2))
    with pytest.raises(ValueError, match="it must hold q"):
        cq.read(tmp_path / "own.npz")
    with pytest.raises(FileNotFoundError, match="there is no file"):
        cq.read(tmp_path / "nothing.lp")
    with pytest.raises(ValueError, match=r"known: \.mps \.lp \.npz \.mtx"):
        UNEVEN.write(tmp_path / "x.txt")


def test_readers_and_writers_know_the_same_formats():
    assert PROBLEM_READERS.keys() == PROBLEM_WRITERS.keys()
