"""The collection of proved answers: what is proved, what is written, and that others can read it."""

import csv
import hashlib
import json
import subprocess
import sys
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from rational import exact_solution
from typer.testing import CliRunner

import contactqp as cq
from contactqp.cli.commands import app
from contactqp.collection import export as module
from contactqp.collection.export import FAMILIES, SIZES, export_dataset
from contactqp.collection.proved import WIDTH, prove
from contactqp.gallery import families


@pytest.fixture(scope="module")
def exported(tmp_path_factory):
    return export_dataset(tmp_path_factory.mktemp("proved") / "set", sizes=[15, 7])


def test_there_are_ten_families_up_to_a_million_unknowns():
    assert len(set(FAMILIES)) == 10
    assert SIZES == (31, 63, 127, 255, 511, 1023)
    assert set(FAMILIES) <= set(cq.gallery.names()) & set(families.FAMILIES)


@pytest.mark.parametrize("family", FAMILIES)
def test_the_exact_rational_solution_lies_within(family):
    found = prove(family, 3)
    assert found.holds
    solution = cq.solve(found.problem, "active-set")
    state = np.where(solution.contact_lower, -1, np.where(solution.contact_upper, 1, 0))
    exact, _ = exact_solution(found.problem, state)
    for low, value, high in zip(found.lower, exact, found.upper, strict=True):
        assert Fraction(float(low)) <= value <= Fraction(float(high))
    ends = zip(found.lower, found.upper, strict=True)
    width = max(Fraction(float(high)) - Fraction(float(low)) for low, high in ends)
    assert width <= Fraction(found.width)
    largest = max(map(abs, exact))
    assert found.scale <= largest or largest < 1e-9


def test_every_family_is_enclosed_to_the_width(exported):
    assert exported.refused == ()
    assert [path.name for path in exported.written] == [f"{family}_{n}.npz" for n in (7, 15) for family in FAMILIES]
    for path in exported.written:
        with np.load(path, allow_pickle=False) as parts:
            assert (parts["omega_lower"] <= parts["omega_upper"]).all()
            assert (parts["omega_upper"] - parts["omega_lower"]).max() <= parts["width"] <= WIDTH * parts["scale"]
            assert parts["q"].size == int(parts["n"]) ** 2


def test_the_answers_are_those_of_the_problems_in_the_files(exported):
    for path in exported.written[:10]:
        problem = cq.read(path)
        with np.load(path, allow_pickle=False) as parts:
            certificate = cq.certify(problem, np.clip(parts["omega_lower"], problem.lower, problem.upper))
            slack = 4 * float(parts["width"])
            assert certificate.gap_bound <= slack
            assert (certificate.lower <= parts["omega_upper"]).all()
            assert (certificate.upper >= parts["omega_lower"]).all()


READING = """
import json, sys
sys.path.insert(0, sys.argv[1])
from read_proved import largest_error, read
G, q, lower, upper, least, most = read(sys.argv[2])
middle = (least + most) / 2
reaction = G @ middle + q
print(json.dumps({
    "shape": G.shape, "error": largest_error(middle, least, most),
    "admissible": bool((lower <= most).all() and (least <= upper).all()),
    "balance": float(abs(reaction[(least > lower) & (most < upper)]).max()),
    "modules": sorted(name.split(".")[0] for name in sys.modules),
}))
"""


def test_the_reader_needs_numpy_and_scipy_alone(exported):
    path = next(path for path in exported.written if path.name == "OBSTCLBL_15.npz")
    command = [sys.executable, "-I", "-B", "-W", "error", "-c", READING, str(exported.folder), str(path)]
    told = json.loads(subprocess.run(command, check=True, capture_output=True, text=True, timeout=60).stdout)
    assert told["shape"] == [225, 225]
    assert told["admissible"]
    assert told["error"] < 1e-14
    assert told["balance"] < 1e-13
    assert not {"contactqp", "numba", "osqp", "pandas"} & set(told["modules"])


def test_the_reader_has_ten_lines(exported):
    assert len((exported.folder / "read_proved.py").read_text(encoding="utf-8").splitlines()) == 10


def test_sums_and_index_are_those_of_the_files(exported):
    lines = (exported.folder / "SHA256SUMS").read_text(encoding="utf-8").splitlines()
    sums = {name: digest for digest, name in (line.split("  ") for line in lines)}
    assert set(sums) | {"SHA256SUMS"} == {file.name for file in exported.folder.iterdir()}
    for name, digest in sums.items():
        assert hashlib.sha256((exported.folder / name).read_bytes()).hexdigest() == digest
    with (exported.folder / "index.csv").open(encoding="utf-8", newline="") as stream:
        index = list(csv.DictReader(stream))
    assert [row["file"] for row in index] == [path.name for path in exported.written]
    assert all(float(row["relative_width"]) <= WIDTH for row in index)
    assert all(int(row["contact"]) + int(row["clear"]) + int(row["undecided"]) == int(row["unknowns"]) for row in index)
    assert "CC0" in (exported.folder / "README.txt").read_text(encoding="utf-8")
    assert "Statement of Purpose" in (exported.folder / "LICENSE.txt").read_text(encoding="utf-8")


def test_equal_numbers_are_equal_files_and_stale_ones_go(tmp_path):
    folder = tmp_path / "set"
    first = export_dataset(folder, sizes=[5], families=["bowl", "ball"])
    kept = {path.name: path.read_bytes() for path in first.written}
    export_dataset(folder, sizes=[5], families=["bowl"])
    assert [path.name for path in folder.glob("*.npz")] == ["bowl_5.npz"]
    assert (folder / "bowl_5.npz").read_bytes() == kept["bowl_5.npz"]


def test_what_is_too_wide_is_told_and_not_written(tmp_path, monkeypatch):
    def blurred(family, n):
        found = prove(family, n)
        return found if family == "bowl" else replace(found, upper=found.upper + 1e-11)

    monkeypatch.setattr(module, "prove", blurred)
    found = export_dataset(tmp_path / "set", sizes=[5], families=["ball", "bowl"])
    assert [path.name for path in found.written] == ["bowl_5.npz"]
    [told] = found.refused
    assert told.startswith("ball, n = 5: ")
    assert "more than 1e-12" in told
    result = CliRunner().invoke(app, ["export-dataset", str(tmp_path / "set"), "--sizes", "5", "--families", "ball"])
    assert result.exit_code == 1
    assert "contactqp: not written: ball, n = 5" in result.stderr
    assert list((tmp_path / "set").glob("*.npz")) == []


def test_what_cannot_be_exported_is_refused(tmp_path):
    with pytest.raises(ValueError, match="did you mean 'ball'"):
        export_dataset(tmp_path / "set", families=["bal"])
    with pytest.raises(ValueError, match="sizes must be >= 1"):
        export_dataset(tmp_path / "set", sizes=[0])
    with pytest.raises(ValueError, match="one or more each"):
        export_dataset(tmp_path / "set", sizes=[])
    assert not (tmp_path / "set").exists()
    with pytest.raises(ValueError, match="there is no folder"):
        export_dataset(tmp_path / "no" / "set", sizes=[3])
    with pytest.raises(ValueError, match="'american-put' is ContactLCP"):
        export_dataset(tmp_path / "set", sizes=[9], families=["american-put"])
    for own in ("measured_7.npz", "thesis.tex"):
        (tmp_path / "set" / own).write_text("mine", encoding="utf-8")
        with pytest.raises(ValueError, match=f"{own} in it is no file of a data set"):
            export_dataset(tmp_path / "set", sizes=[3])
        (tmp_path / "set" / own).replace(tmp_path / own)
    with pytest.raises(ValueError, match="it is a file, not a folder"):
        export_dataset(tmp_path / "thesis.tex", sizes=[3])


def test_the_command_tells_each_problem(tmp_path):
    arguments = ["export-dataset", str(tmp_path / "set"), "--sizes", "5", "--families", "ball,spiral"]
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 0
    assert [line.split()[0] for line in result.stdout.splitlines()] == ["ball", "spiral", "2"]
    assert max(map(len, result.stdout.splitlines()[:2])) <= 80
