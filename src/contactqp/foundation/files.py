"""Files that are written: checked before the work, replaced as a whole, and held by one at a time."""

from __future__ import annotations

import os
import shutil
import sys
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

_held: set[Path] = set()
_held_guard = threading.Lock()


def path_of(value: object, name: str = "path") -> Path:
    """Return the path that a user gives for a file.

    Examples
    --------
    >>> path_of(None)
    Traceback (most recent call last):
    ...
    TypeError: path must be the name of a file, as a str or a Path, got None
    """
    if not isinstance(value, (str, os.PathLike)):
        raise TypeError(f"{name} must be the name of a file, as a str or a Path, got {value!r}")
    return Path(value)


def require_folder(path: Path, what: str) -> None:
    """Raise a ValueError that names ``what``, if there is no folder to write ``path`` into."""
    if not path.parent.is_dir():
        raise ValueError(f"cannot write the {what} {path}: there is no folder {path.parent}; make it first")


def require_file(path: Path) -> None:
    """Raise a FileNotFoundError that names a file, unless it is there.

    Examples
    --------
    >>> require_file(Path("no", "such", "bed.csv"))
    Traceback (most recent call last):
    ...
    FileNotFoundError: there is no file no/such/bed.csv
    """
    if not path.is_file():
        raise FileNotFoundError(f"there is no file {path}")


def made_folder(folder: Path) -> Path:
    """Return a folder that is to be written into, made if it is missing.

    Raises
    ------
    ValueError
        If there is a file of its name, or no folder to make it in.

    Examples
    --------
    >>> made_folder(Path("no", "such", "folder"))
    Traceback (most recent call last):
    ...
    ValueError: cannot make the folder no/such/folder: there is no folder no/such
    """
    if folder.exists() and not folder.is_dir():
        raise ValueError(f"cannot write into {folder}: it is a file, not a folder")
    if not folder.absolute().parent.is_dir():
        raise ValueError(f"cannot make the folder {folder}: there is no folder {folder.parent}")
    folder.mkdir(exist_ok=True)
    return folder


def require_suffix(path: Path, known: Sequence[str], what: str) -> None:
    """Raise a ValueError that lists the known suffixes, if that of ``path`` is none of them.

    Examples
    --------
    >>> require_suffix(Path("fields.NC"), [".nc"], "fields")
    >>> require_suffix(Path("hexagon.gif"), [".png", ".pdf"], "picture")
    Traceback (most recent call last):
    ...
    ValueError: cannot write the picture hexagon.gif: unknown suffix '.gif'; known: .png .pdf
    """
    suffix = path.suffix.lower()
    if suffix not in known:
        found = f"unknown suffix {suffix!r}" if suffix else "it has no suffix"
        raise ValueError(f"cannot write the {what} {path}: {found}; known: {' '.join(known)}")


def require_writable(path: Path, known: Sequence[str], what: str) -> None:
    """Raise a ValueError, if ``path`` cannot become a file of one of the ``known`` suffixes.

    Examples
    --------
    >>> require_writable(Path("no", "such", "r.html"), [".html"], "report")
    Traceback (most recent call last):
    ...
    ValueError: cannot write the report no/such/r.html: there is no folder no/such; make it first
    """
    require_suffix(path, known, what)
    require_folder(path, what)
    if path.is_dir() and not is_store(path):
        raise ValueError(f"cannot write the {what} {path}: there is a folder of that name")
    if not os.access(path if path.exists() else path.parent, os.W_OK):
        raise ValueError(f"cannot write the {what} {path}: permission denied")


def is_store(path: Path) -> bool:
    """Whether a folder is a Zarr store, which counts as one file."""
    return (path / "zarr.json").is_file() or (path / ".zgroup").is_file()


@contextmanager
def replaced_as_a_whole(path: Path) -> Iterator[Path]:
    """Give a file beside ``path`` to write to, which takes its place when that is done, and vanishes on an error.

    Its suffix is that of ``path``: libraries choose a format by it. It may be made a folder, as a Zarr store is; such a
    store at ``path`` is moved aside first.
    """
    unfinished = path.with_name(f".{path.stem}.{os.getpid()}.{threading.get_ident()}.part{path.suffix}")
    try:
        yield unfinished
        old = unfinished.with_suffix(".old")
        if path.is_dir() and unfinished.is_dir():
            path.replace(old)
        unfinished.replace(path)
        _remove(old)
    finally:
        _remove(unfinished)


def _remove(path: Path) -> None:
    if path.is_dir():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)


@contextmanager
def held(path: Path, what: str) -> Iterator[None]:
    """Keep a file to oneself, against other threads and other processes; a process that dies lets go of it.

    Raises
    ------
    ValueError
        If another thread or process has it.
    """
    path = path.absolute()
    path = path.parent.resolve() / path.name
    with _held_guard:
        if path in _held:
            raise ValueError(f"the {what} {path} is in use by another thread; {_ANOTHER}")
        _held.add(path)
    try:
        lock = path.with_name(f".{path.name}.lock")
        descriptor = _locked(lock)
        if descriptor is None:
            raise ValueError(f"the {what} {path} is in use by another process; {_ANOTHER}")
        try:
            yield
        finally:
            _release(descriptor, lock)
    finally:
        with _held_guard:
            _held.discard(path)


_ANOTHER = "name another file, or wait until that is done"


def _locked(lock: Path) -> int | None:
    """Return the descriptor of a lock file that is held now, None if another process holds it."""
    while True:
        descriptor = os.open(lock, os.O_RDWR | os.O_CREAT, 0o666)
        if not _try_to_lock(descriptor):
            os.close(descriptor)
            return None
        # The one who held it may have removed the file between opening and locking: then this is no lock any more.
        try:
            if os.path.samestat(os.fstat(descriptor), os.stat(lock)):
                return descriptor
        except FileNotFoundError:
            pass
        os.close(descriptor)


def _release(descriptor: int, lock: Path) -> None:
    if sys.platform == "win32":
        os.close(descriptor)  # an open file cannot be removed there
        lock.unlink(missing_ok=True)
    else:
        lock.unlink(missing_ok=True)
        os.close(descriptor)


if sys.platform == "win32":
    import msvcrt

    def _try_to_lock(descriptor: int) -> bool:
        try:
            msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)
        except OSError:
            return False
        return True

else:
    import fcntl

    def _try_to_lock(descriptor: int) -> bool:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            return False
        except OSError:
            return True  # some network folders know no locks; there only threads are kept apart
        return True
