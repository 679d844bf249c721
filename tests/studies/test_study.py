"""Studies: errors against closed forms, their orders, the table, the files and the picture."""

import json
import math

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

import contactqp as cq
from contactqp.cli.commands import app
from contactqp.studies.errors import QUANTITIES, StudyRow
from contactqp.studies.study import Study


def run(*arguments):
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def row(spacing, deflection=math.nan, bound=0.0, status="certified", area=math.nan, edge=math.nan, exact=False):
    errors = deflection, math.nan, area, edge, bound
    return StudyRow(round(1 / spacing) - 1, 9, spacing, *errors, status, 0.1, exact)


def made(*rows):
    return Study("made", "a made one", "nowhere", "psor", rows)


def test_orders_are_slopes():
    study = made(row(0.4, 16.0), row(0.2, 4.0), row(0.05, 0.25))
    assert study.orders("deflection") == pytest.approx((2.0, 2.0))
    assert study.order("deflection") == pytest.approx(2.0)
    assert all(math.isnan(value) for value in study.orders("reaction"))
    assert math.isnan(study.order("reaction"))
    assert repr(study) == "Study('made', 3 spacings, orders: deflection 2.00)"


def test_errors_of_the_solver_and_zeros_show_no_order():
    study = made(row(0.4, 16.0), row(0.2, 4.0), row(0.1, 1.0, bound=0.5), row(0.05, 0.0))
    assert study.orders("deflection")[0] == pytest.approx(2.0)
    assert np.isnan(study.orders("deflection")[1:]).all()
    assert study.order("deflection") == pytest.approx(2.0)
    assert math.isnan(made(row(0.4, 16.0, exact=True), row(0.2, 4.0, exact=True)).order("deflection"))


def test_errors_that_scatter_or_grow_have_no_order_over_all_spacings():
    scattered = made(*(row(1 / n, area=error) for n, error in ((10, 0.2), (20, 0.02), (40, 0.18), (80, 0.01))))
    assert math.isnan(scattered.order("contact_area"))
    assert np.isfinite(scattered.orders("contact_area")).all()
    assert math.isnan(made(row(0.4, 1.0), row(0.2, 4.0)).order("deflection"))
    assert "all" not in str(scattered)
    assert "no order" in repr(scattered)


def test_columns_never_run_together():
    errors = {3: 3e-1, 4: 4e-9, 5: 2e-3, 6: 1e-2}
    study = made(*(row(1 / (n + 1), deflection=error, area=error) for n, error in errors.items()))
    rows = [line for line in str(study).splitlines() if line[:5].strip().isdigit()]
    assert [len(line.split()) for line in rows] == [4, 6, 6, 6]


def test_a_single_size_is_taken():
    assert [found.n for found in cq.study("cable-on-foundation", 9).rows] == [9]


def test_a_study_measures_what_it_says():
    study = cq.study("disk-over-floor", [31, 15])
    assert [found.n for found in study.rows] == [15, 31]
    known = cq.gallery.load("disk-over-floor", 31)
    solution = cq.solve(known.model, tol=1e-9)
    fine = study.rows[-1]
    assert fine.deflection == pytest.approx(np.abs(solution.deflection - known.deflection).max(), rel=1e-4)
    assert fine.contact_area == pytest.approx(abs(solution.contact.sum() / 16**2 - math.pi / 4) / (math.pi / 4))
    edge = known.model.free_boundary(solution.contact)
    assert fine.free_boundary == pytest.approx(np.abs(np.hypot(*edge.T) - 0.5).max())
    assert fine.bound < 1e-3 * fine.deflection
    assert study.certified
    assert study.order("deflection") > 1.7
    assert study.order("free_boundary") > 0.7


def test_a_bare_problem_is_studied_as_a_model_is():
    study = cq.study("american-put", [99, 399])
    assert study.order("deflection") > 1.5
    assert study.rows[0].free_boundary < 0.03


def test_exact_answers_have_rounding_for_errors():
    study = cq.study("cable-on-hill", [9, 19])
    assert study.exact
    assert max(found.deflection for found in study.rows) < 1e-12
    text = " ".join(str(study).split())
    assert "errors of deflection and reaction are rounding. Where contact ends between two nodes no discrete" in text
    assert "exact to rounding at the nodes, orders: contact area 1.00, free boundary 1.00" in repr(study)
    assert math.isnan(study.order("deflection"))
    assert study.order("contact_area") == pytest.approx(1.0)
    mixed = cq.study("cable-on-hill", [8, 9, 19])
    assert not mixed.exact
    assert "At the nodes of n = 9, 19 the discrete answer" in " ".join(str(mixed).split())


@pytest.mark.parametrize(
    ("name", "known"),
    [("plate-under-load", {"deflection"}), ("ball", set(QUANTITIES)), ("cable-on-posts", {"deflection", "reaction"})],
)
def test_the_table_has_what_is_known_in_eighty_columns(name, known):
    study = cq.study(name, {"ball": [9, 19], "cable-on-posts": [7, 11]}.get(name, [5, 9]))
    lines = str(study).splitlines()
    assert max(map(len, lines)) <= 80
    heads = {"deflection": "deflection", "reaction": "reaction", "contact_area": "area", "free_boundary": "boundary"}
    head = next(line for line in lines if line.lstrip().startswith("n "))
    assert {quantity for quantity, word in heads.items() if word in head} == known


def test_what_is_not_certified_is_said():
    study = made(row(0.4, 16.0), row(0.2, 4.0, status="iteration_limit"))
    assert not study.certified
    assert "iteration_limit" in str(study)
    stopped = cq.study("ball", [9], backend="psor", time_limit=1e-9, on_failure="ignore")
    assert not stopped.certified


def test_files_have_errors_and_orders(tmp_path):
    study = cq.study("cable-on-foundation", [9, 19])
    told = json.loads(study.write(tmp_path / "study.json").read_text(encoding="utf-8"))
    assert told["orders"]["deflection"] == pytest.approx(study.order("deflection"))
    assert told["rows"][0]["order_of_deflection"] is None
    assert told["rows"][1]["deflection"] == study.rows[1].deflection
    frame = pd.read_csv(study.write(tmp_path / "study.csv"))
    assert frame["order of deflection"][1] == pytest.approx(2.0, abs=0.05)
    assert frame["n"].tolist() == [9, 19]
    with pytest.raises(ValueError, match=r"unknown suffix '\.txt'; known: \.json \.csv"):
        study.write(tmp_path / "study.txt")


def test_the_picture_has_a_line_for_each_quantity():
    figure = cq.study("ring", [9, 19]).plot()
    axes = figure.axes[0]
    assert (axes.get_xscale(), axes.get_yscale()) == ("log", "log")
    assert len(axes.get_legend().get_texts()) == 4
    assert sum("order" in text.get_text() for text in axes.texts) == 2


def test_what_cannot_be_studied_is_refused():
    with pytest.raises(ValueError, match="no closed form is known of 'spiral'"):
        cq.study("spiral", [9])
    with pytest.raises(ValueError, match="did you mean 'ball'"):
        cq.study("bal")
    with pytest.raises(ValueError, match="sizes must hold one"):
        cq.study("ball", [])
    with pytest.raises(ValueError, match="sizes must be >= 1"):
        cq.study("ball", [0])


def test_the_command_prints_and_writes(tmp_path):
    out, picture = tmp_path / "s.csv", tmp_path / "s.png"
    result = run("study", "cable-on-foundation", "--sizes", "9,19", "--out", out, "--plot", picture)
    assert result.exit_code == 0
    assert "  all" in result.stdout
    assert out.is_file()
    assert picture.stat().st_size > 10_000


def test_the_command_lists_the_gallery():
    result = run("study")
    assert result.exit_code == 0
    assert [line.split()[0] for line in result.stdout.splitlines()] == list(cq.gallery.names())


def test_the_command_refuses_in_one_line(tmp_path):
    for arguments, told in (
        (("study", "bal"), "did you mean 'ball'?"),
        (("study", "ball", "--sizes", "9;19"), "--sizes must be whole numbers separated by commas"),
        (("study", "ball", "--out", tmp_path / "x.txt"), "--out: cannot write the file"),
        (("study", "spiral"), "no closed form"),
    ):
        result = run(*arguments)
        assert result.exit_code == 2
        assert told in result.stderr
        assert len(result.stderr.splitlines()) == 1
