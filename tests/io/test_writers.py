"""Solutions as files."""

import csv
from pathlib import Path

import numpy as np
import pytest

import contactqp as cq
from contactqp.io.answers import SUFFIXES, read_answer
from contactqp.io.writers import WRITERS, write_solution

LATTICE = cq.Frame.rectangle(1.0, 1.0).lattice(0.25)


@pytest.mark.parametrize("suffix", sorted(set(WRITERS) & set(SUFFIXES)))
@pytest.mark.parametrize("upwards", [False, True])
def test_what_is_written_is_read_again(tmp_path, suffix, upwards):
    """Gaps and deflections, whichever way heights are positive, are the answer that they were."""
    model = cq.Membrane(LATTICE, 1.0, load=4.0, support=-0.1 if upwards else 0.1, upwards=upwards)
    solution = cq.solve(model)
    file = tmp_path / f"answer{suffix}"
    write_solution(solution, model, file)
    if suffix == ".csv":
        with file.open(encoding="utf-8", newline="") as stream:
            rows = list(csv.DictReader(stream))
        for name in ("gap", "deflection", "reaction"):
            np.testing.assert_array_equal([float(row[name]) for row in rows], getattr(solution, name))
        np.testing.assert_array_equal([float(row["x"]) for row in rows], model.node_x)
        assert [row["contact"] for row in rows] == [str(int(each)) for each in solution.contact]
    np.testing.assert_array_equal(read_answer(file, model, "gap"), solution.gap)
    np.testing.assert_allclose(read_answer(file, model, "deflection"), solution.gap, atol=1e-15)


BOUNDED = cq.ContactQP([[2.0, -1.0], [-1.0, 2.0]], [-1.0, 3.0], lower=[0.0, -np.inf], upper=[0.1, 2.0])


def test_a_bare_problems_solution_is_a_table(tmp_path):
    solution = cq.solve(BOUNDED)
    with solution.save(tmp_path / "two.csv").open(encoding="utf-8", newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert [row["node"] for row in rows] == ["0", "1"]
    told = {"gap": solution.gap, "reaction": solution.reaction, "lower": BOUNDED.lower, "upper": BOUNDED.upper}
    for name, values in told.items():
        np.testing.assert_array_equal([float(row[name]) for row in rows], values)
    assert [row["contact_state"] for row in rows] == ["1.0", "0.0"]


@pytest.mark.parametrize("problem", [BOUNDED, cq.ContactLCP([[3.0, -0.5], [-2.0, 3.0]], [-6.0, 1.0])])
def test_a_bare_problems_solution_is_loaded_and_judged_anew(tmp_path, problem):
    solution = cq.solve(problem, "psor", tol=1e-7)
    file = solution.save(tmp_path / "two.npz")
    again = cq.load_solution(file)
    np.testing.assert_array_equal(again.gap, solution.gap)
    assert (again.backend, again.tol, again.status) == ("psor", 1e-7, cq.Status.CERTIFIED)
    assert (cq.read(file).G != problem.G).nnz == 0
    assert cq.load_solution(file, tol=1e-3).tol == 1e-3
    with np.load(file) as archive:
        np.testing.assert_array_equal(archive["reaction"], solution.reaction)


def test_what_a_bare_problems_solution_cannot_become(tmp_path):
    solution = cq.solve(BOUNDED)
    with pytest.raises(ValueError, match=r"solution of a bare problem .*\.nc'; known: \.csv \.npz"):
        solution.save(tmp_path / "two.nc")
    BOUNDED.write(tmp_path / "problem.npz")
    with pytest.raises(ValueError, match=r"problem\.npz: it holds a problem, which contactqp.read returns, and no gap"):
        cq.load_solution(tmp_path / "problem.npz")


def test_a_table_of_nodes_is_read_in_any_order_and_where_there_is_no_support(tmp_path):
    model = cq.Membrane(LATTICE, 1.0, load=4.0, support=lambda x, y: np.where(x < 0, 0.1, np.inf))
    solution = cq.solve(model)
    file = tmp_path / "answer.csv"
    write_solution(solution, model, file)
    head, *lines = file.read_text().splitlines()
    file.write_text("\n".join([head, *lines[::-1]]) + "\n\n")
    np.testing.assert_allclose(read_answer(file, model), solution.gap, atol=1e-15)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("node,gap\n0,1\n", r"column node must hold each of 0, ..., 2 once, got 1 lines"),
        ("node,gap\n0,1\n1,1\n1,1\n", "must hold each of 0, ..., 2 once, got 3 lines"),
        ("node,gap\n0,1\n1\n2,1\n", "line 3 has 1 entries, and the line of names 2"),
        ("node,gap\n0,1\n1,x\n2,1\n", "line 3: could not convert string to float: 'x'; write numbers only"),
        ("node,gaps\n0,1\n1,1\n2,1\n", "it has no column gap, but node, gaps; did you mean 'gaps'"),
        ("node,gap\n0,nan\n1,1\n2,1\n", "gap .* nan"),
    ],
)
def test_tables_of_nodes_that_are_none_say_what_is_wrong(tmp_path, text, told):
    model = cq.Cable(nodes=3, spacing=1.0, tension=1.0, load=1.0, support=1.0)
    file = tmp_path / "answer.csv"
    file.write_text(text)
    with pytest.raises(cq.CaseFileError, match=told):
        read_answer(file, model)


def test_unknown_suffixes_are_refused(tmp_path):
    model = cq.Cable(nodes=3, spacing=1.0, tension=1.0, load=1.0, support=1.0)
    with pytest.raises(ValueError, match=r"unknown suffix '\.vtk'; known: \.nc \.csv \.zarr"):
        write_solution(cq.solve(model), model, tmp_path / "answer.vtk")


@pytest.mark.parametrize("suffix", WRITERS)
def test_a_file_is_replaced_as_a_whole_once(tmp_path, monkeypatch, suffix):
    replaced = []
    replace = Path.replace
    monkeypatch.setattr(Path, "replace", lambda self, target: replaced.append(target) or replace(self, target))
    model = cq.Membrane(LATTICE, 1.0, load=4.0, support=0.1)
    write_solution(cq.solve(model), model, tmp_path / f"answer{suffix}")
    # A store replaces its own parts while it is written.
    assert [target for target in replaced if Path(target).parent == tmp_path] == [tmp_path / f"answer{suffix}"]
