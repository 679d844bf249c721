"""What a comparison was made with: settings, versions, machine, time."""

from __future__ import annotations

import os
import platform
import sys
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path
from typing import Any

from .._version import __version__
from ..foundation.text import shortened

_LIBRARIES = ("numpy", "scipy", "numba")


@dataclass(frozen=True)
class Provenance:
    """What the answers of a comparison were asked for and made with.

    Attributes
    ----------
    max_iter, time_limit : int or float or None
        Limits that every backend was given; None where each has its own.
    repeats : int
        Runs of each backend after the first.
    options : mapping of str to mapping
        By backend, the options in effect; of ``own_defaults`` those that were given.
    own_defaults : tuple of str
        Backends whose library ran with its own default settings.
    versions : mapping of str to str
        Of contactqp, Python and the libraries that were called.
    machine : mapping of str to str
    when : datetime
        With time zone.
    """

    max_iter: int | None = None
    time_limit: float | None = None
    repeats: int = 0
    options: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    own_defaults: tuple[str, ...] = ()
    versions: Mapping[str, str] = field(default_factory=dict)
    machine: Mapping[str, str] = field(default_factory=dict)
    when: datetime = field(default_factory=lambda: datetime.now().astimezone())

    def to_dict(self) -> dict[str, Any]:
        """Return the record as plain data; options that are neither numbers nor strings are shortened to text."""
        plain = (bool, int, float, str, type(None))
        return {
            "max_iter": self.max_iter,
            "time_limit": self.time_limit,
            "repeats": self.repeats,
            "options": {
                name: {key: value if isinstance(value, plain) else shortened(value) for key, value in chosen.items()}
                for name, chosen in self.options.items()
            },
            "own_defaults": list(self.own_defaults),
            "versions": dict(self.versions),
            "machine": dict(self.machine),
            "when": self.when.isoformat(timespec="seconds"),
        }


def versions_of(packages: Iterable[str]) -> dict[str, str]:
    """Return the versions of contactqp, Python, the numerical libraries and other packages."""
    from importlib import metadata

    found = {"contactqp": __version__, "Python": platform.python_version()}
    for package in dict.fromkeys([*_LIBRARIES, *packages]):
        try:
            found[package] = metadata.version(package)
        except metadata.PackageNotFoundError:
            found[package] = "not installed"
    return found


def machine() -> dict[str, str]:
    """Return platform, processor and number of processors, as far as the system tells.

    Of the platform, its kind: a kernel's release tells whose machine it was rather than why a figure came out.
    """
    name = _processor()
    available = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    found = {
        "platform": f"{platform.system()} {platform.machine()}",
        "processors": str(available or "unknown"),
        "byte order": sys.byteorder,
    }
    return found | ({"processor": name} if name else {})


def _processor() -> str:
    """Return the processor's name, which on Linux stands in a file only."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor()
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor()
