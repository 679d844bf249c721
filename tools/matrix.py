"""Run the fast tests with every Python that is found, each in an environment of its own, .venv-3.12 and so on.

    make matrix                            # all that pyproject.toml allows
    make matrix VERSIONS="3.12 3.13"       # these

Looked at are the commands on the path, pyenv's versions and uv's. A Python that some dependency has no wheel for yet is
skipped with a line that says which. Exits with 1 if a test failed, or if no Python was left to run them.
"""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import time
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
UV = str(Path(sys.executable).with_name("uv"))
TESTS = ["-m", "pytest", "-m", "not slow"]


def interpreters() -> dict[str, str]:
    """Return the path of the newest Python of each minor version that the package allows, by version."""
    pyenv = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv")) / "versions"
    folders = [str(folder) for folder in pyenv.glob("*/bin")]
    path = os.pathsep.join([*folders, os.environ["PATH"]])
    listed = subprocess.run(
        [UV, "python", "list", "--only-installed", "--no-config", "--output-format", "json"],
        env={**os.environ, "PATH": path},
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,  # it warns of pyenv's commands that stand for no version
        check=True,
        text=True,
    )
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    oldest = tuple(int(part) for part in re.findall(r"\d+", project["requires-python"]))
    newest: dict[tuple[int, int], tuple[int, str]] = {}
    for found in json.loads(listed.stdout):
        if found["implementation"] != "cpython" or found["variant"] != "default":
            continue
        version = found["version_parts"]
        minor = (version["major"], version["minor"])
        if minor >= oldest and version["patch"] > newest.get(minor, (-1, ""))[0]:
            newest[minor] = version["patch"], found["path"]
    return {f"{major}.{minor}": path for (major, minor), (_, path) in sorted(newest.items())}


def prepared(version: str, interpreter: str) -> str:
    """Make the environment of a version, or bring it up to date; return why that cannot be done, or nothing."""
    folder = ROOT / f".venv-{version}"
    if not folder.exists():
        subprocess.run([UV, "venv", "--quiet", "--python", interpreter, str(folder)], check=True)
    install = [UV, "pip", "install", "--quiet", "--python", str(folder)]
    made = subprocess.run(
        [*install, "--no-build", "--requirements", "pyproject.toml", "--extra", "test"],
        cwd=ROOT,
        stderr=subprocess.PIPE,
        text=True,
    )
    if made.returncode == 0:
        subprocess.run([*install, "--no-deps", "--editable", str(ROOT)], check=True)
        return ""
    lacking = re.search(r"\S+ has no (?:usable )?wheels[^,]*", " ".join(made.stderr.split()))
    if lacking is None:
        raise SystemExit(f"{version}: {made.stderr}")
    return lacking[0]


def passes(version: str) -> bool:
    """Run the fast tests with a version whose environment is prepared."""
    folder = ROOT / f".venv-{version}"
    python = folder / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    # Compiled kernels are kept apart: another Python's would replace them.
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(folder / "numba")}
    return subprocess.run([str(python), *TESTS], cwd=ROOT, env=environment).returncode == 0


def main(wanted: list[str]) -> int:
    """Run the tests with the versions ``wanted``, or with all; return the exit code."""
    found = interpreters()
    for version in wanted:
        if version not in found:
            print(f"Python {version} was not found; found: {', '.join(found)}", file=sys.stderr)
            return 1
    outcomes = {}
    for version in wanted or found:
        print(f"\n== Python {version}, {found[version]}", flush=True)
        started = time.monotonic()
        lacking = prepared(version, found[version])
        if lacking:
            outcomes[version] = f"skipped: {lacking}"
            continue
        outcomes[version] = "passed" if passes(version) else "FAILED"
        outcomes[version] += f" in {time.monotonic() - started:.0f} s"
    print()
    for version, outcome in outcomes.items():
        print(f"Python {version} {outcome}")
    done = [outcome for outcome in outcomes.values() if not outcome.startswith("skipped")]
    return 0 if done and all(outcome.startswith("passed") for outcome in done) else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
