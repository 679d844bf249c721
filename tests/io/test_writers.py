"""Solutions as files."""

import csv
from pathlib import Path

import numpy as np
import pytest

import contactqp as cq
from contactqp.io.answers import read_answer
from contactqp.io.writers import WRITERS, write_solution

LATTICE = cq.Frame.rectangle(1.0, 1.0).lattice(0.25)


@pytest.mark.parametrize("suffix", WRITERS)
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
        np.save(tmp_path / "deflection.npy", solution.deflection)
        np.testing.assert_allclose(
            read_answer(tmp_path / "deflection.npy", model, "deflection"), solution.gap, atol=1e-15
        )
    else:
        np.testing.assert_array_equal(read_answer(file, model, "gap"), solution.gap)
        np.testing.assert_allclose(read_answer(file, model, "deflection"), solution.gap, atol=1e-15)


def test_unknown_suffixes_are_refused(tmp_path):
    model = cq.Cable(nodes=3, spacing=1.0, tension=1.0, load=1.0, support=1.0)
    with pytest.raises(ValueError, match=r"unknown suffix '\.vtk'; known: \.nc \.csv"):
        write_solution(cq.solve(model), model, tmp_path / "answer.vtk")


@pytest.mark.parametrize("suffix", WRITERS)
def test_a_file_is_replaced_as_a_whole_once(tmp_path, monkeypatch, suffix):
    replaced = []
    replace = Path.replace
    monkeypatch.setattr(Path, "replace", lambda self, target: replaced.append(target) or replace(self, target))
    model = cq.Cable(nodes=3, spacing=1.0, tension=1.0, load=1.0, support=1.0)
    write_solution(cq.solve(model), model, tmp_path / f"answer{suffix}")
    assert replaced == [tmp_path / f"answer{suffix}"]
