"""Files that are replaced as a whole: whoever opens one finds the old contents or the new, never a part."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


def require_folder(path: Path, what: str) -> None:
    """Raise a ValueError that names ``what``, if there is no folder to write ``path`` into."""
    if not path.parent.is_dir():
        raise ValueError(f"cannot write the {what} {path}: there is no folder {path.parent}; make it first")


@contextmanager
def replaced_as_a_whole(path: Path) -> Iterator[Path]:
    """Give a file beside ``path`` to write to, which takes its place when that is done, and vanishes on an error."""
    unfinished = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        yield unfinished
        unfinished.replace(path)
    finally:
        unfinished.unlink(missing_ok=True)
