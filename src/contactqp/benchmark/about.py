"""What a folder of measurements tells of itself: versions, machine, and when it was begun."""

from __future__ import annotations

import json
from collections.abc import Mapping
from datetime import datetime
from pathlib import Path
from typing import Any

from ..backends import get_backend, installed_backends
from ..comparison.provenance import machine, versions_of
from ..foundation.files import replaced_as_a_whole

ABOUT = "about.json"
"""The file that it stands in."""


def measured_with() -> tuple[dict[str, str], dict[str, str]]:
    """Return the versions of what backends call here, and the machine."""
    found = (get_backend(name) for name in installed_backends())
    packages = [package for backend in found for package in (backend.package, *backend.also_needs)]
    return versions_of(packages), machine()


def now() -> str:
    """Return the time with its zone, by ISO 8601."""
    return datetime.now().astimezone().isoformat(timespec="seconds")


def write_about(folder: Path, told: Mapping[str, Any]) -> None:
    """Write what is told into a folder, which is made if need be."""
    folder.mkdir(parents=True, exist_ok=True)
    with replaced_as_a_whole(folder / ABOUT) as unfinished:
        unfinished.write_text(json.dumps(told, indent=2) + "\n", encoding="utf-8")


def read_about(folder: Path) -> dict[str, Any]:
    """Return what a folder tells.

    Raises
    ------
    ValueError
        If it holds no measurements.
    """
    if not (folder / ABOUT).exists():
        raise ValueError(f"folder {folder} holds no results of a benchmark: it has no {ABOUT}")
    found: dict[str, Any] = json.loads((folder / ABOUT).read_text(encoding="utf-8"))
    return found
