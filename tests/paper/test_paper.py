"""The paper's example: Table 1, contact maps, sections, and the folder that ``contactqp paper`` writes."""

import csv
import math
import re
from dataclasses import replace

import matplotlib.image
import numpy as np
import pytest
from strategies import BACKENDS, altered
from typer.testing import CliRunner

import contactqp as cq
from contactqp import paper
from contactqp.cli.commands import app
from contactqp.paper import table
from contactqp.paper.folder import CAPTIONS

STEP_SWEEPS = [52, 44, 36, 26, 23, 21, 20, 19, 18, 17]
STEP_BEST = [(1.7,), (1.65, 1.7), (1.6,), (1.5, 1.55), (1.5,), (1.45,), (1.45,), (1.4,), (1.4,), (1.35, 1.4)]
CONTACT_NODES = [105, 225, 303, 553, 711, 847, 925, 971, 1033, 1107]


def run(*arguments):
    return CliRunner().invoke(app, ["paper", *map(str, arguments)])


@pytest.fixture(scope="module")
def found():
    return paper.reproduce()


@pytest.fixture(scope="module")
def printed_and_folder(tmp_path_factory, found):
    """What the command makes of the ten loads, which it asks for by no argument."""
    folder = tmp_path_factory.mktemp("out") / "new"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("contactqp.paper.reproduction.reproduce", lambda: found)
        result = run("--out", folder)
    assert result.exit_code == 0, result.output
    return result.output, folder


@pytest.fixture(scope="module")
def printed(printed_and_folder):
    return " ".join(printed_and_folder[0].split())


@pytest.fixture(scope="module")
def folder(printed_and_folder):
    return printed_and_folder[1]


def test_table_1_with_the_step_rule(found):
    assert [row.step.least for row in found.rows] == STEP_SWEEPS
    assert [row.step.best for row in found.rows] == STEP_BEST
    far = [row.paper.load for row in found.rows if abs(row.step.least - row.paper.sweeps) > 1]
    assert far == [0.03]  # where the paper's N contradicts its own CPU time


def test_the_papers_factors_are_among_the_best_with_the_residual_rule(found):
    assert len(found.rows) == 10
    assert all(row.paper.factor in row.residual.best for row in found.rows)


def test_the_cpu_times_of_nine_loads_contradict_the_tenth():
    fit = paper.fit_cpu_time()
    assert (round(fit.at_start, 3), round(fit.a_sweep, 3)) == (0.381, 0.316)
    assert fit.deviation < 0.2
    assert round(fit.sweeps) == 40
    (doubtful,) = (row for row in paper.TABLE_1 if row.load == 0.03)
    assert abs(fit.at_start + fit.a_sweep * doubtful.sweeps - doubtful.cpu_seconds) > 10 * fit.deviation


def test_the_radius_of_jacobis_matrix_is_that_of_the_full_spectrum(found):
    row, solution = found.rows[-1], found.path.solutions[-1]
    free = ~solution.contact
    part = solution.problem.G[free][:, free].toarray()
    jacobi = np.eye(len(part)) - part / 4  # symmetric, the diagonal being 4T throughout
    assert row.radius == pytest.approx(np.abs(np.linalg.eigvalsh(jacobi)).max(), abs=1e-12)
    assert row.optimal == 2 / (1 + math.sqrt(1 - row.radius**2))


def test_theorys_factor_is_the_best_in_the_long_run_only(found):
    for row in found.rows:
        assert min(abs(factor - row.optimal) for factor in row.long_run.best) < 0.03
        assert max(row.step.best) < row.optimal - 0.03
        assert max(row.residual.best) < row.optimal - 0.03


def test_the_radius_of_small_free_sets_and_what_is_refused():
    cable = cq.Cable(nodes=4, spacing=1.0, tension=1.0, load=1.0, support=9.0)
    for count in range(5):
        expected = math.cos(math.pi / (count + 1)) if count else 0.0
        assert paper.jacobi_radius(cable, np.arange(4) < count) == pytest.approx(expected, abs=1e-14)
    with pytest.raises(TypeError, match="free must be boolean, got dtype int64"):
        paper.jacobi_radius(cable, np.arange(4))
    with pytest.raises(ValueError, match=r"free must have shape \(4,\), got \(3,\)"):
        paper.jacobi_radius(cable, np.full(3, True))
    with pytest.raises(ValueError, match="Z-matrices only"):
        paper.jacobi_radius(cq.ContactQP([[2.0, 1.0], [1.0, 2.0]], [1.0, 1.0]), [True, True])
    for radius in (-0.1, 1.0, math.nan):
        with pytest.raises(ValueError, match=r"radius must lie in \[0, 1\), got"):
            paper.optimal_factor(radius)


def test_contact_sets_are_certified_nested_and_the_same_by_every_backend(found):
    assert found.ok
    assert [int(solution.contact.sum()) for solution in found.path.solutions] == CONTACT_NODES
    assert found.backends == BACKENDS
    assert [int(contact.sum()) for _, contact in found.contact_maps] == [0, *CONTACT_NODES]
    assert found.unloaded.certificate.clear.all()


def test_what_is_not_verified_is_said(found):
    backwards = replace(found.path, solutions=found.path.solutions[::-1])
    shrinking = replace(found, path=backwards)
    assert not shrinking.nested
    assert not shrinking.identical
    assert not shrinking.ok
    assert "NOT proven: the gap grows between load 0.01 and 0.02" in table.remarks(shrinking)[-2]
    forged = cq.certify(found.unloaded.problem, np.full(1857, 0.5), effort="fast")
    vague = altered(found.path.solutions[0], certificate=forged)
    vague.__dict__["certificate"] = forged
    unsure = replace(found, path=replace(found.path, solutions=(vague, *found.path.solutions[1:])))
    assert not unsure.decided
    assert not unsure.nested
    assert "NOT proven: certificates leave nodes undecided" in table.remarks(unsure)[-2]
    bad = cq.compare(cq.gallery.paper_hexagon(0.01), ["osqp", "clarabel"], tol="default")
    spoilt = replace(found, comparisons=(bad, *found.comparisons[1:]))
    assert spoilt.nested
    assert not spoilt.identical
    assert "NOT identical, or not certified. at P′ = 0.01: No agreement" in table.remarks(spoilt)[-1]


def test_only_loads_of_the_table():
    for loads in ([0.015], []):
        with pytest.raises(ValueError, match=r"loads must be some of Table 1's, 0\.01, .*, 0\.10, got \["):
            paper.reproduce(loads)


def test_scans_of_other_models_and_what_is_refused():
    cable = cq.Cable(nodes=9, spacing=1.0, tension=1.0, load=1.0, support=11.0)
    found = paper.scan(cable, "step", stopping_length=1e-9, factors=[1.9, 1.0, 1.5])
    sweeps = dict(zip(found.factors.tolist(), found.sweeps.tolist(), strict=True))
    assert found.best == (1.5,)
    assert found.least == sweeps[1.5] < sweeps[1.0] < sweeps[1.9]
    with pytest.raises(ValueError, match=r"factors must be a sequence of numbers, got shape \(0,\)"):
        paper.scan(cable, "step", factors=[])
    with pytest.raises(ValueError, match=r"relaxation must lie strictly between 0 and 2, got 2"):
        paper.scan(cable, "step", factors=[2.0])
    with pytest.raises(ValueError, match=r"got 'stepp'; did you mean 'step'\?"):
        paper.scan(cable, "stepp")


def test_text_maps_show_each_node_and_are_symmetric(folder):
    parts = (folder / "fig5.txt").read_text(encoding="utf-8").rstrip("\n").split("\n\n")
    assert paper.SURROGATE in parts[0]
    heads, maps = parts[1::2], parts[2::2]
    assert len(heads) == len(maps) == 11
    for head, picture, nodes in zip(heads, maps, [0, *CONTACT_NODES], strict=True):
        assert f": {nodes} of 1857 nodes" in head
        assert picture.count("*") == nodes
        assert picture.count("*") + picture.count(".") == 1857
        assert set(picture) <= set("*. \n")
        lines = [line.ljust(125) for line in picture.split("\n")]
        assert len(lines) == 47
        assert {len(line) for line in lines} == {125}
        assert lines == lines[::-1] == [line[::-1] for line in lines]


def test_a_text_map_has_its_first_row_at_the_largest_y():
    lattice = cq.gallery.islands().lattice
    highest = lattice.node_y == lattice.node_y.max()
    upper, *others = paper.text_map(lattice, highest).split("\n")
    assert upper.replace(" ", "") == "*" * int(highest.sum())
    assert "".join(others).count(".") == lattice.size - int(highest.sum())
    assert len(others) == int(np.ptp(lattice.node_y))
    with pytest.raises(TypeError, match="contact must be boolean, got dtype float64"):
        paper.text_map(lattice, np.zeros(lattice.size))
    with pytest.raises(ValueError, match="vector must have shape"):
        paper.text_map(lattice, np.full(3, True))


def test_sections_are_without_unit():
    """The same membrane in other units has the same section."""
    spacing, tension = 0.02, 50.0
    corners = [(spacing * x, spacing * y) for x, y in cq.gallery.PAPER_CORNERS]
    lattice = cq.Frame.polygon(corners).lattice(spacing)
    depth = cq.profiles.HillAndFloor(floor=1.25 * spacing, hill=5 * spacing, scale=spacing)
    scaled = cq.Membrane(lattice, tension=tension, load=0.03 * tension / spacing, support=depth)
    found = paper.middle_section(cq.solve(scaled, tol=1e-9))
    plain = paper.middle_section(cq.solve(cq.gallery.paper_hexagon(0.03), tol=1e-9))
    for name in ("x", "support", "deflection", "gap", "reaction", "frame"):
        np.testing.assert_allclose(getattr(found, name), getattr(plain, name), atol=1e-7)
    assert plain.reaction[31] > 0.05
    with pytest.raises(ValueError, match="needs a membrane's solution"):
        paper.middle_section(cq.solve(scaled.problem))


def test_the_folder_holds_what_its_index_names(folder):
    index = (folder / "README.txt").read_text(encoding="utf-8")
    pictures = {name.replace(".png", ".pdf") for name in CAPTIONS if name.endswith(".png")}
    assert {file.name for file in folder.iterdir()} == {"README.txt", *CAPTIONS, *pictures}
    assert all((folder / name).read_bytes().startswith(b"%PDF") for name in pictures)
    assert paper.SURROGATE in index
    for name, caption in CAPTIONS.items():
        assert f"{name} " in index
        assert caption in index
        if name.endswith(".png"):
            assert matplotlib.image.imread(folder / name).shape[1] > 1000


def test_the_tables_in_the_folder(folder, found):
    text = (folder / "table1.txt").read_text(encoding="utf-8")
    assert text == table.as_text(found) + "\n"
    assert max(map(len, text.splitlines())) <= 120
    assert paper.SURROGATE in text
    assert "0.03  1.60   31?  1.60" in text
    with (folder / "table1.csv").open(encoding="utf-8", newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert [int(row["step_sweeps"]) for row in rows] == STEP_SWEEPS
    assert [tuple(map(float, row["step_best_factors"].split())) for row in rows] == STEP_BEST
    assert [int(row["paper_sweeps"]) for row in rows] == [row.sweeps for row in paper.TABLE_1]
    assert [int(row["contact_nodes"]) for row in rows] == CONTACT_NODES
    with (folder / "figs6-8.csv").open(encoding="utf-8", newline="") as stream:
        section = [{name: float(number) for name, number in row.items()} for row in csv.DictReader(stream)]
    assert [row["load"] for row in section] == [load for load in (0.01, 0.03, 0.05) for _ in range(63)]
    assert max(abs(row["deflection"] + row["gap"] - row["support"]) for row in section) < 1e-12
    assert min(row["reaction"] for row in section) > -1e-9


def test_the_table_for_latex(folder, found):
    text = (folder / "table1.tex").read_text(encoding="utf-8")
    assert text.isascii()
    rows = [line.strip() for line in text.splitlines() if line.endswith(r"\\")]
    assert [row.count("&") for row in rows[1:]] == [len(table.HEADINGS) - 1] * 11
    spans = [int(part) for part in re.findall(r"multicolumn\{(\d+)\}", rows[0])]
    assert sum(spans) == len(table.HEADINGS)
    assert rows[1].startswith(r"$P'$ & $\beta_0$ & $N$ & best $\beta$ & $N$ &")
    assert rows[-1].startswith("0.10 & 1.35 & 17 & 1.35 1.40 & 17 & 1.35 & 17 & 0.9221 & 1.442 &")
    for opened in ("table", "tabular"):
        assert text.count(rf"\begin{{{opened}}}") == text.count(rf"\end{{{opened}}}") == 1


def test_what_is_printed(printed, printed_and_folder):
    assert paper.SURROGATE in printed
    assert "0.10 1.35 17 1.35 1.40 17 1.35 17 0.9221 1.442" in printed
    assert "probably a misprint: the other nine loads fit CPU seconds = 0.381 + 0.316 N" in printed
    assert "the paper's β₀ is among the best at 10 of 10 loads" in printed
    assert "105 ⊂ 225 ⊂ 303 ⊂ 553 ⊂ 711 ⊂ 847 ⊂ 925 ⊂ 971 ⊂ 1033 ⊂ 1107 nodes: proven" in printed
    assert f"All {len(BACKENDS)} backends are certified at every load, and their contact sets are identical" in printed
    assert all(name in printed for name in CAPTIONS)
    before_files = printed_and_folder[0].split("README.txt")[0].splitlines()[:-1]
    assert max(map(len, before_files)) <= 120


def test_bad_folders_are_refused_before_any_work(tmp_path, monkeypatch):
    def work(*_):
        raise AssertionError("work was done")

    monkeypatch.setattr("contactqp.paper.reproduction.reproduce", work)
    (tmp_path / "file").write_text("x")
    for out, message in (
        (tmp_path / "no" / "such", f"there is no folder {tmp_path / 'no'}"),
        (tmp_path / "file", "it is a file, not a folder"),
        (tmp_path / "file" / "below", "there is no folder"),
    ):
        result = run("--out", out)
        assert result.exit_code == 2, result.output
        assert result.stderr.startswith("contactqp: cannot ")
        assert message in result.stderr
    assert sorted(file.name for file in tmp_path.iterdir()) == ["file"]


def test_exit_code_1_where_something_is_not_verified(tmp_path, monkeypatch, found):
    monkeypatch.setattr(
        "contactqp.paper.reproduction.reproduce",
        lambda: replace(found, comparisons=found.comparisons[::-1]),
    )
    monkeypatch.setattr("contactqp.paper.folder.write_folder", lambda *_: ())
    result = run("--out", tmp_path)
    assert result.exit_code == 1
    assert "NOT identical" in result.output
