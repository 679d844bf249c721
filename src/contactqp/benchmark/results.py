"""Results: the records of a benchmark in a folder, and what they were measured with."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Self

from ..foundation.loading import load_modules
from .about import ABOUT, now, read_about, write_about
from .record import Record
from .suites import Suite

if TYPE_CHECKING:
    import pandas as pd

_RECORDS = "records.jsonl"


@dataclass
class Results:
    """What a benchmark has found so far.

    Attributes
    ----------
    folder : Path
    suite : Suite
    versions, machine : mapping of str to str
    when : str
        When it began, by ISO 8601.
    records : list of Record

    Examples
    --------
    >>> import tempfile
    >>> from contactqp.benchmark.suites import SUITES
    >>> results = Results.begun(Path(tempfile.mkdtemp()), SUITES["quick"], {}, {})
    >>> results.add(Record("bowl", 31, "psor", "mid", status="certified"))
    >>> [record.problem for record in Results.read(results.folder).records]
    ['bowl 31']
    """

    folder: Path
    suite: Suite
    versions: Mapping[str, str]
    machine: Mapping[str, str]
    when: str
    records: list[Record] = field(default_factory=list)

    @classmethod
    def begun(cls, folder: Path, suite: Suite, versions: Mapping[str, str], machine: Mapping[str, str]) -> Self:
        """Return the results in a folder, to which a suite's are added; the folder is made if need be.

        Raises
        ------
        ValueError
            If it holds results of another suite or of other limits, or was measured with other versions or on another
            machine.
        """
        if (folder / ABOUT).exists():
            found = cls.read(folder)
            was = found.suite
            for what, before, wanted in (
                ("suite", was.name, suite.name),
                ("time limit", was.time_limit, suite.time_limit),
                ("memory limit", was.memory, suite.memory),
                ("repeats", was.repeats, suite.repeats),
                ("versions", dict(found.versions), dict(versions)),
                ("machine", dict(found.machine), dict(machine)),
            ):
                if before != wanted:
                    raise ValueError(
                        f"folder {folder} holds results of another {what} ({before}, now {wanted}), which would be "
                        "mixed; take another folder"
                    )
            return found
        when = now()
        told = {"suite": asdict(suite), "versions": dict(versions), "machine": dict(machine), "when": when}
        write_about(folder, told)
        return cls(folder, suite, versions, machine, when)

    @classmethod
    def read(cls, folder: str | Path) -> Self:
        """Return what a folder holds; a last line that was not completed is left out.

        Raises
        ------
        ValueError
            If it holds no results.
        """
        place = Path(folder)
        about = read_about(place)
        told = about["suite"]
        problems = {name: tuple(numbers) for name, numbers in told["problems"].items()}
        suite = Suite(**{**told, "problems": problems, "levels": tuple(told["levels"])})
        path = place / _RECORDS
        lines = path.read_text(encoding="utf-8").splitlines(keepends=True) if path.exists() else []
        records = [Record.from_dict(json.loads(line)) for line in lines if line.endswith("\n")]
        return cls(place, suite, about["versions"], about["machine"], about["when"], records)

    def add(self, record: Record) -> None:
        """Add a record, in the folder too."""
        path = self.folder / _RECORDS
        _cut_torn_line(path)
        with path.open("a", encoding="utf-8") as file:
            file.write(json.dumps(record.to_dict()) + "\n")
        self.records.append(record)

    @property
    def not_run(self) -> dict[str, tuple[int, ...]]:
        """The suite's problems without a record, by family: those of a run that was stopped, or narrowed to others.

        Examples
        --------
        >>> from contactqp.benchmark.suites import Suite
        >>> results = Results(Path(), Suite("two", {"bowl": (31, 63), "beam": 60}, ("mid",), 5.0, 2**31, 1), {}, {}, "")
        >>> results.records.append(Record("bowl", 31, "psor", "mid"))
        >>> results.not_run
        {'bowl': (63,), 'beam': (60,)}
        """
        has = {(record.family, record.number) for record in self.records}
        left = {
            family: tuple(number for number in numbers if (family, number) not in has)
            for family, numbers in self.suite.problems.items()
        }
        return {family: numbers for family, numbers in left.items() if numbers}

    @property
    def told_not_run(self) -> str:
        """The problems without a record in words, ``""`` if there is none."""
        left = (f"{family} {', '.join(map(str, numbers))}" for family, numbers in self.not_run.items())
        told = "; ".join(left)
        return f"not run yet: {told}" if told else ""

    def to_frame(self) -> pd.DataFrame:
        """Return a line for each record, with whether it is proven, and claimed but wrong."""
        load_modules("pandas")
        import pandas as pd

        derived = [
            {**record.to_dict(), "proven": record.proven, "claimed_but_wrong": record.claimed_but_wrong}
            for record in self.records
        ]
        return pd.DataFrame(derived)

    def write_tables(self) -> list[Path]:
        """Write the records as ``records.csv``, and as ``records.parquet`` where pyarrow is installed; return both."""
        frame = self.to_frame()
        frame.attrs = {"suite": self.suite.name, "when": self.when, **self.machine, **self.versions}
        written = [self.folder / "records.csv"]
        frame.to_csv(written[0], index=False)
        if find_spec("pyarrow") is None:
            return written
        written.append(self.folder / "records.parquet")
        frame.to_parquet(written[1], index=False)
        return written


def _cut_torn_line(path: Path) -> None:
    """Cut off a last line that was not completed, if a file has one."""
    if not path.exists() or path.stat().st_size == 0:
        return
    with path.open("rb+") as file:
        file.seek(-1, os.SEEK_END)
        if file.read() != b"\n":
            file.seek(0)
            file.truncate(file.read().rfind(b"\n") + 1)
