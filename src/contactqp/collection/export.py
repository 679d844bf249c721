"""export_dataset(): a folder of problems with proved answers, their hashes, a reader, and a dedication to everyone."""

from __future__ import annotations

import csv
import hashlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

from .._version import __version__
from ..foundation.checks import integers_at_least
from ..foundation.files import made_folder, replaced_as_a_whole
from ..foundation.progress import Progress
from ..foundation.text import at_most
from ..gallery.catalogue import entry_of, names
from .proved import WIDTH, Proved, prove

FAMILIES = (
    "ball",
    "biactive-half",
    "bowl",
    "constant-obstacle",
    "incidence-set",
    "journal-bearing",
    "OBSTCLAE",
    "OBSTCLBL",
    "rough-05",
    "spiral",
)
"""Ten of `contactqp.gallery.families`: contact sets round and ragged, hardly one, two bounds, a varying coefficient."""

SIZES = (31, 63, 127, 255, 511, 1023)
"""Nodes along a side."""

SUMS, INDEX, READER, LICENSE, ABOUT = "SHA256SUMS", "index.csv", "read_proved.py", "LICENSE.txt", "README.txt"

_COUNTS = ("unknowns", "nonzeros", "contact", "clear", "undecided")
_INDEX_COLUMNS = ("file", "family", "n", *_COUNTS, "width", "scale", "relative_width", "proof", "source")


@dataclass(frozen=True)
class Exported:
    """What has been written.

    Attributes
    ----------
    folder : Path
    written : tuple of Path
        The problems with proved answers, in order.
    refused : tuple of str
        What was not written, for its enclosure is wider than 1e-12 of the scale: in words, with the width.
    """

    folder: Path
    written: tuple[Path, ...]
    refused: tuple[str, ...]


def _prepare(folder: Path) -> None:
    """Make a folder if it is missing; refuse one with something in it that must not be mistaken for proved.

    Raises
    ------
    ValueError
        If it cannot be made, or holds a file that is none of a data set.
    """
    made_folder(folder)
    strange = next((file.name for file in sorted(folder.iterdir()) if not _ours(file.name)), None)
    if strange is not None:
        raise ValueError(f"cannot write into {folder}: {strange} in it is no file of a data set; name another folder")


def _ours(name: str) -> bool:
    """Whether a file of that name may be of a data set, or comes of reading one."""
    family, _, size = name.removesuffix(".npz").rpartition("_")
    beside = (SUMS, INDEX, READER, LICENSE, ABOUT, "__pycache__")
    return name in beside or (name.endswith(".npz") and size.isdigit() and family in names())


def export_dataset(
    folder: str | Path,
    sizes: Sequence[int] | int = SIZES,
    families: Sequence[str] = FAMILIES,
    *,
    told: Callable[[Proved], object] | None = None,
) -> Exported:
    """Write problems whose exact solutions are enclosed, for programs in any language that reads numpy's arrays.

    For each family and size a file ``FAMILY_SIZE.npz`` has the rows of G (``data``, ``indices``, ``indptr``), ``q``,
    ``lower`` and ``upper`` of min ½ωᵀGω + qᵀω, lower ≤ ω ≤ upper, and ``omega_lower`` ≤ ω* ≤ ``omega_upper``. These are
    proved for the numbers in the file, with all rounding errors bounded (see `contactqp.certify`), and nowhere wider
    than 1e-12 of the largest modulus of ω*; what does not come out as narrow as that is not written. `contactqp.read`
    reads the problem as well. Beside them stand an index, SHA-256 sums (``sha256sum -c SHA256SUMS``), a reader of ten
    lines that needs numpy and scipy only, and the dedication of all of it to the public domain (CC0 1.0). Problems of
    an earlier call that are not asked for again are removed, so that the index is that of the folder.

    Parameters
    ----------
    folder : str or Path
        Made if it is missing.
    sizes : sequence of int, or int
        Nodes along a side.
    families : sequence of str
        Names of `contactqp.gallery.names`, of models.
    told : callable, optional
        Is called with each `Proved` as soon as it is there, whether it was written or not.

    Returns
    -------
    Exported

    Raises
    ------
    ValueError
        If the folder cannot be written into or holds other files, a family is unknown, or there is nothing to write.

    Examples
    --------
    >>> import tempfile
    >>> found = export_dataset(tempfile.mkdtemp(), sizes=[7], families=["ball", "OBSTCLBL"])
    >>> [file.name for file in found.written], found.refused
    (['ball_7.npz', 'OBSTCLBL_7.npz'], ())
    """
    folder = Path(folder)
    wanted = sorted(set(integers_at_least(sizes, 1, "sizes")))
    for family in families:
        entry_of(family)
    if not wanted or not families:
        raise ValueError("sizes and families must hold one or more each")
    _prepare(folder)
    (folder / SUMS).unlink(missing_ok=True)  # it would be that of other files, if this is interrupted
    written: list[Path] = []
    rows: list[list[Any]] = []
    refused: list[str] = []
    with Progress("exporting problems with proved answers") as progress:
        for n in wanted:
            for family in dict.fromkeys(families):
                progress.update(f"{family}, n = {n}")
                found = prove(family, n)
                if found.holds:
                    written.append(_write(found, folder))
                    rows.append(_index_row(found, written[-1].name))
                else:
                    refused.append(f"{family}, n = {n}: {found.relative_width:.1e} of the scale, more than {WIDTH:g}")
                if told is not None:
                    told(found)
    _write_others(folder, written, rows)
    return Exported(folder, tuple(written), tuple(refused))


def _write(found: Proved, folder: Path) -> Path:
    """Write a problem and its enclosure; numpy dates what it packs 1980, so that equal numbers are equal files."""
    problem, path = found.problem, folder / f"{found.family}_{found.n}.npz"
    matrix = problem.G
    with replaced_as_a_whole(path) as unfinished, unfinished.open("wb") as stream:
        np.savez_compressed(
            stream,
            allow_pickle=False,
            data=matrix.data,
            indices=matrix.indices.astype(np.int32),
            indptr=matrix.indptr.astype(np.int32),
            q=problem.q,
            lower=problem.lower,
            upper=problem.upper,
            omega_lower=found.lower,
            omega_upper=found.upper,
            symmetric=np.bool_(True),
            gap_scale=np.float64(problem.gap_scale),
            scale=np.float64(found.scale),
            width=np.float64(found.width),
            family=np.str_(found.family),
            n=np.int64(found.n),
            source=np.str_(found.source),
        )
    return path


def _index_row(found: Proved, name: str) -> list[Any]:
    size = found.problem.size
    undecided = size - found.contact - found.clear
    counts = [size, found.problem.G.nnz, found.contact, found.clear, undecided]
    widths = [repr(found.width), repr(found.scale), at_most(found.relative_width, 4)]
    return [name, found.family, found.n, *counts, *widths, found.barrier, found.source]


def _write_others(folder: Path, written: Sequence[Path], rows: Sequence[Sequence[Any]]) -> None:
    """Write reader, dedication, description, index and hashes; remove problems that are not among what was written."""
    for stale in set(folder.glob("*.npz")) - set(written):
        stale.unlink()
    shipped = files("contactqp.collection.shipped")
    texts = {
        READER: (shipped / f"{READER}.txt").read_text(encoding="utf-8"),
        LICENSE: (shipped / LICENSE).read_text(encoding="utf-8"),
        ABOUT: _ABOUT,
    }
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="utf-8")
    with (folder / INDEX).open("w", encoding="utf-8", newline="") as stream:
        csv.writer(stream).writerows([_INDEX_COLUMNS, *rows])
    listed = sorted([*(path.name for path in written), INDEX, *texts])
    lines = [f"{_sha256(folder / name)}  {name}\n" for name in listed]
    with replaced_as_a_whole(folder / SUMS) as unfinished:
        unfinished.write_text("".join(lines), encoding="utf-8")


def _sha256(path: Path) -> str:
    with path.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


_ABOUT = f"""Problems with proved answers
============================

Each FAMILY_SIZE.npz holds a linear complementarity problem, the optimality condition of

    min ½ω'Gω + q'ω   subject to   lower <= ω <= upper,

with a sparse, symmetric positive definite G, and two vectors between which its exact solution
lies at every node: omega_lower <= ω* <= omega_upper. They are proved for the very doubles of
the file, with all rounding errors bounded outwards, and nowhere farther apart than {WIDTH:g} of
the largest |ω*| ("scale"; where ω* is nothing but rounding of the data, a length of the problem).

    data, indices, indptr     rows of G (compressed sparse rows)
    q, lower, upper           vectors; inf where there is no bound
    omega_lower, omega_upper  bounds of the exact solution
    width, scale              the largest distance of these bounds, and what it is measured by
    family, n, source         which problem it is, nodes along a side, where it is from
    gap_scale, symmetric      what contactqp.read takes besides

{READER} reads them with numpy and scipy alone; {INDEX} lists them;
"sha256sum -c {SUMS}" checks them. A program's answer ω is wrong by at most
max(ω - omega_lower, omega_upper - ω), and by at least the distance from these bounds.

Written by contactqp {__version__}. To the extent possible under law, all copyright and related
rights in these files are waived: CC0 1.0 Universal, see {LICENSE}.
"""
