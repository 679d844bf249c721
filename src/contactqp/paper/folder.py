"""The folder with the paper's table and figures, and an index of its files."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..foundation.files import made_folder
from . import latex, table
from .facts import SURROGATE
from .sections import middle_section, section_solutions
from .text_maps import text_map

if TYPE_CHECKING:
    from .reproduction import Reproduction

INDEX = "README.txt"

CAPTIONS = {
    "table1.txt": "Table 1 of the paper beside ours, for both stopping rules, with theory's best factor.",
    "table1.csv": "The same as data.",
    "table1.tex": "The same as a table for LaTeX, to be read by \\input.",
    "table1_curves.png": "Sweeps N against the relaxation factor β at the ten loads: what stands behind β₀.",
    "table1_theory.png": "Theory's best relaxation factor beside the scanned ones and the paper's β₀.",
    "fig5.txt": "Contact maps at P′ = 0, 0.01, …, 0.10: dots for nodes, stars where the membrane has settled (Fig. 5).",
    "fig5.png": "The same as a picture, beside the depth of the support.",
    "fig5_touchdown.png": "All contact maps in one: between which of the loads each node settles.",
    "figs6-8.png": "Middle sections at P′ = 0.01, 0.03, 0.05: w′ = w/Δ and support, ω′ = ω/Δ, R′ = R/(TΔ) (Figs. 6-8).",
    "figs6-8.csv": "The same as data.",
}
"""What each file of the folder shows; beside each picture there is a PDF of the same name, for print."""


def write_folder(found: Reproduction, folder: Path) -> tuple[Path, ...]:
    """Write table, maps, pictures, sections and their index into a folder, replacing files of the same names.

    Parameters
    ----------
    found : Reproduction
    folder : Path
        It is made if it is missing.

    Returns
    -------
    tuple of Path
        What was written, the index first; without the pictures' PDFs.

    Raises
    ------
    ValueError
        See `contactqp.foundation.files.made_folder`.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> from contactqp.paper.reproduction import reproduce
    >>> with TemporaryDirectory() as folder:
    ...     [file.name for file in write_folder(reproduce(loads=[0.10]), Path(folder))][:3]
    ['README.txt', 'table1.txt', 'table1.csv']
    """
    from ..paper import figures

    made_folder(folder)
    texts = {
        INDEX: index(),
        "table1.txt": table.as_text(found) + "\n",
        "table1.csv": table.as_csv(found),
        "table1.tex": latex.as_latex(found),
        "fig5.txt": contact_maps(found),
    }
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="utf-8")
    for name, figure in (
        ("table1_curves.png", figures.plot_factor_curves(found)),
        ("table1_theory.png", figures.plot_optimal_factors(found)),
        ("fig5.png", figures.plot_contact_maps(found)),
        ("fig5_touchdown.png", figures.plot_touchdown(found)),
        ("figs6-8.png", figures.plot_sections(found)),
    ):
        figure.savefig(folder / name, dpi=150)
        figure.savefig((folder / name).with_suffix(".pdf"))
    _write_sections(found, folder / "figs6-8.csv")
    return tuple(folder / name for name in (INDEX, *CAPTIONS))


def index() -> str:
    """Return the text of the index: each file and its caption.

    Examples
    --------
    >>> index().splitlines()[2]
    'The rigid surface is a surrogate consistent with Table 1, not a reproduction.'
    """
    width = max(map(len, CAPTIONS))
    lines = [f"{name.ljust(width)}  {caption}" for name, caption in CAPTIONS.items()]
    return "\n".join(
        [
            "The paper's example, the hexagonal membrane of 1857 nodes, solved by contactqp.",
            "",
            SURROGATE,
            "This holds for every file below. Beside each picture (.png) there is the same for print (.pdf).",
            "",
            *lines,
            "",
        ]
    )


def contact_maps(found: Reproduction) -> str:
    """Return the contact maps of all loads, one below the other."""
    lattice = found.membrane.lattice
    parts = [
        "Contact maps in the manner of Fig. 5 of the paper: a dot for each node, a star where the membrane has settled."
        f"\n{SURROGATE}\nUnloaded, the membrane lies in the plane of the summit: it touches there and does not press."
    ]
    for load, contact in found.contact_maps:
        name = "0" if load == 0 else f"{load:.2f}"
        parts.append(f"P′ = {name}: {np.count_nonzero(contact)} of {lattice.size} nodes have settled")
        parts.append(text_map(lattice, contact))
    return "\n\n".join(parts) + "\n"


def _write_sections(found: Reproduction, file: Path) -> None:
    with file.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(("load", "x", "support", "deflection", "gap", "reaction"))
        for load, solution in section_solutions(found.path):
            section = middle_section(solution)
            columns = (section.x, section.support, section.deflection, section.gap, section.reaction)
            writer.writerows((load, *map(float, numbers)) for numbers in zip(*columns, strict=True))
