"""What all commands share: the application, its exit codes, options that several have, and what is bad input."""

from __future__ import annotations

import inspect
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from typer.core import TyperGroup

from .._version import __version__
from ..foundation.checks import Vector
from ..foundation.files import require_writable
from ..foundation.interrupts import INTERRUPTED, ended_by_interrupts

EXIT_OK, EXIT_NOT_CERTIFIED, EXIT_BAD_INPUT, EXIT_INTERRUPTED = 0, 1, 2, INTERRUPTED


class bad_input:  # noqa: N801
    """Turn an error of the input into one line on standard error and exit code 2, and Ctrl-C into its exit code."""

    def __enter__(self) -> None:
        return None

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: object) -> None:
        if isinstance(error, KeyboardInterrupt):
            typer.echo(f"contactqp: interrupted{_notes_of(error)}", err=True)
            raise typer.Exit(EXIT_INTERRUPTED) from None
        if isinstance(error, BrokenPipeError):  # who read our output has enough of it
            return
        if isinstance(error, MemoryError):
            error = MemoryError(f"not enough memory: {error}")
        if isinstance(error, (ValueError, TypeError, ImportError, OSError, ArithmeticError, MemoryError)):
            typer.echo(f"contactqp: {' '.join(f'{_words_of(error)}{_notes_of(error)}'.split())}", err=True)
            raise typer.Exit(EXIT_BAD_INPUT) from None


def _notes_of(error: BaseException) -> str:
    """Return what was noted beside an error, each note in parentheses."""
    return "".join(f" ({note})" for note in getattr(error, "__notes__", ()))


def _words_of(error: BaseException) -> str:
    """Return what an error says; one of the system about a file without its number, the file's name first."""
    if isinstance(error, OSError) and error.filename is not None and error.strerror:
        return f"{error.filename}: {error.strerror.lower()}"
    return str(error)


class _Commands(TyperGroup):
    """All commands: each is ended by Ctrl-C, and tells of bad input, in the same way."""

    def __init__(self, **given: Any) -> None:
        super().__init__(**given)
        _reflow(self)

    def invoke(self, ctx: typer.Context) -> Any:  # type: ignore[override]
        """Run the command that the command line names."""
        with ended_by_interrupts(), bad_input():
            return super().invoke(ctx)


def _reflow(command: Any) -> None:
    """Join the lines of each paragraph of a command's help, and of those below it.

    Typer keeps the line breaks of a docstring in all paragraphs but the first, whatever the terminal's width.
    """
    if command.help:
        paragraphs = inspect.cleandoc(command.help).split("\n\n")
        command.help = "\n\n".join(" ".join(paragraph.split()) for paragraph in paragraphs)
    for below in getattr(command, "commands", {}).values():
        _reflow(below)


app = typer.Typer(
    name="contactqp",
    cls=_Commands,
    help=(
        "Membranes, plates, cables and beams over rigid obstacles, solved by any backend by name.\n\n"
        "A case file (TOML) describes frame, spacing, tension, load and support; 'contactqp new' writes one. "
        "Every answer is judged by the package itself and comes with a certified bound of its error "
        "against the exact solution of the discrete problem.\n\n"
        "Exit codes: 0 ok; 1 not certified, or no agreement; 2 bad input; 130 interrupted by Ctrl-C."
    ),
    no_args_is_help=True,
    rich_markup_mode="rich",
    pretty_exceptions_show_locals=False,
)

PICTURES = (".png", ".pdf", ".svg", ".eps", ".jpg", ".jpeg", ".tif", ".tiff", ".webp")
"""Suffixes of pictures that matplotlib writes in every version that is allowed."""

Case = Annotated[Path, typer.Argument(help="Case file (TOML).", show_default=False)]
Tol = Annotated[
    str,
    typer.Option(
        help="Wanted bound of the gap's error against the exact solution of the discrete problem, relative to the "
        "error scale (a length of the problem, or the answer's largest deflection where that is smaller): a number in "
        "(0, 1), low (1e-3), mid (1e-6), high (1e-9), or default: each library as its authors ship it, judged by 1e-6.",
        metavar="NUMBER|LEVEL",
    ),
]
TimeLimit = Annotated[float | None, typer.Option(help="Seconds for each backend.", show_default=False)]
EFFORTS = "energy", "pointwise"
Continuum = Annotated[
    str | None,
    typer.Option(
        help="Tell what the answer proves of the membrane itself, the distance from its lattice included: energy, or "
        "pointwise, which takes longer.",
        metavar="|".join(EFFORTS),
        show_default=False,
    ),
]
Plot = Annotated[Path | None, typer.Option(help="Write a picture (.png, .pdf, .svg).", show_default=False)]


def times_told(text: str) -> Vector:
    """Return the times that were typed: numbers separated by commas, or START:STOP:STEPS.

    Raises
    ------
    ValueError
        If they are neither.
    """
    try:
        if ":" in text:
            start, stop, steps = text.split(":")
            return np.linspace(float(start), float(stop), int(steps) + 1)
        return np.array([float(part) for part in text.split(",")])
    except ValueError:
        wanted = "numbers separated by commas, as 0,0.5,1, or START:STOP:STEPS, as 0:10:100"
        raise ValueError(f"--times must be {wanted}, got {text!r}") from None


def tolerance(text: str) -> float | str:
    """Return the number that was typed; what is none is taken for a level's name."""
    try:
        return float(text)
    except ValueError:
        return text


def check_output(option: str, file: Path | None, known: tuple[str, ...]) -> None:
    """Refuse an output file that cannot be written or whose suffix is unknown, before any work.

    Raises
    ------
    ValueError
        It names the option.
    """
    if file is not None:
        try:
            require_writable(file, known, "file")
        except ValueError as error:
            raise ValueError(f"{option}: {error}") from None


def _show_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"contactqp {__version__}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_show_version, is_eager=True, help="Show the version and exit.")
    ] = False,
) -> None:
    pass
