"""The pytest plugin ``contactqp``: backends, a tolerance and assertions for the tests of contact problems.

pytest loads it at the start of every run in an environment that has contactqp. So it stands outside the package, whose
import takes numpy's tenth of a second and would come before coverage is measured: contactqp is imported only in runs
whose tests ask for a fixture, or that set an option.

PYTEST_DONT_REWRITE
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from contactqp.comparison.comparison import Comparison
    from contactqp.foundation.checks import Mask
    from contactqp.models.base import ContactModel
    from contactqp.problem.contact_problem import ContactProblem
    from contactqp.proof.judge import Verdict

DEFAULT_TOL = 1e-6


@dataclass(frozen=True)
class _Choice:
    """The checked settings of a run: which backends and which tolerance its tests use."""

    backends: tuple[str, ...]
    tol: float


_CHOICE = pytest.StashKey[_Choice]()


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the command-line options, and settings of the same meaning for the configuration file."""
    group = parser.getgroup("contactqp", "tests of contact problems")
    group.addoption(
        "--contact-backends",
        metavar="NAMES",
        help="backends to test with, separated by commas (default: all that are installed)",
    )
    group.addoption(
        "--contact-tol",
        metavar="TOL",
        help=f"tolerance relative to the error scale, between 0 and 1 (default: {DEFAULT_TOL:g})",
    )
    parser.addini("contact_backends", "backends to test with, unless --contact-backends is given", type="args")
    parser.addini("contact_tol", "tolerance relative to the error scale, unless --contact-tol is given")


def pytest_configure(config: pytest.Config) -> None:
    """Refuse bad options before anything is collected."""
    if _is_set(config):
        _choice(config)


def pytest_report_header(config: pytest.Config) -> str | None:
    """Name version, tolerance and backends where options set them, also in front of distributed runs."""
    return _summary(config) if _is_set(config) else None


def pytest_report_collectionfinish(config: pytest.Config, items: Sequence[pytest.Item]) -> str | None:
    """Name version, tolerance and defaults where a test asks for them, which the header cannot know."""
    if _is_set(config) or config.get_verbosity() < 0:
        return None
    settings = {"contact_backends", "contact_tol"}
    asked = any(not settings.isdisjoint(getattr(item, "fixturenames", ())) for item in items)
    return _summary(config) if asked else None


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """Run a test that asks for ``contact_backend`` once with each backend.

    It is the fixture ``_contact_backend_name`` that is parametrized, and ``contact_backend`` asks for it. A suite may
    define a ``contact_backend`` of its own, by a fixture or by ``pytest.mark.parametrize``; its tests then do not ask
    for ``_contact_backend_name`` and are left as they are.
    """
    if "_contact_backend_name" in metafunc.fixturenames:
        metafunc.parametrize("_contact_backend_name", _choice(metafunc.config).backends, indirect=True)


@pytest.fixture(scope="session")
def contact_backends(request: pytest.FixtureRequest) -> list[str]:
    """Names of the backends to test with: those of --contact-backends, by default all that are installed."""
    return list(_choice(request.config).backends)


@pytest.fixture(scope="session")
def _contact_backend_name(request: pytest.FixtureRequest) -> str:
    name: str = request.param
    return name


@pytest.fixture(scope="session")
def contact_backend(_contact_backend_name: str, contact_backends: list[str]) -> str:
    """Name of one backend: the test runs once with each of ``contact_backends``.

    For others, write ``@pytest.mark.parametrize("contact_backend", ["osqp", "psor"])`` above the test.
    """
    return _contact_backend_name


@pytest.fixture(scope="session")
def contact_tol(request: pytest.FixtureRequest) -> float:
    """Tolerance relative to the error scale: that of --contact-tol, by default 1e-6."""
    return _choice(request.config).tol


@pytest.fixture(scope="session")
def assert_complementary(contact_tol: float) -> Callable[..., Verdict]:
    """Return `contactqp.testing.assert_complementary`, with ``contact_tol`` unless told otherwise."""
    from contactqp import testing

    return partial(testing.assert_complementary, tol=contact_tol)


@pytest.fixture(scope="session")
def assert_backends_agree(contact_backends: list[str], contact_tol: float) -> Callable[..., Comparison]:
    """Return `contactqp.testing.assert_backends_agree`, with ``contact_tol`` unless told otherwise.

    Without ``backends=`` the assertion takes those of ``contact_backends`` whose methods suit the problem.
    """
    from contactqp import testing

    def check(
        problem: ContactProblem | ContactModel, backends: Sequence[str] | None = None, *, tol: float = contact_tol
    ) -> Comparison:
        __tracebackhide__ = True
        names = _suitable(contact_backends, problem) if backends is None else backends
        return testing.assert_backends_agree(problem, names, tol=tol)

    return check


@pytest.fixture(scope="session")
def assert_encloses() -> Callable[..., None]:
    """Return `contactqp.testing.assert_encloses`."""
    from contactqp import testing

    return testing.assert_encloses


@pytest.fixture(scope="session")
def assert_same_contact() -> Callable[..., Mask]:
    """Return `contactqp.testing.assert_same_contact`."""
    from contactqp import testing

    return testing.assert_same_contact


def _is_set(config: pytest.Config) -> bool:
    return any(_given(config, name) is not None for name in ("contact_backends", "contact_tol"))


def _given(config: pytest.Config, name: str) -> tuple[str, str] | None:
    """Return what the run sets ``name`` to, and where; None if it does not."""
    option = config.getoption(name)
    if option is not None:
        return option, f"--{name.replace('_', '-')}"
    configured = config.getini(name)
    if not configured:
        return None
    return configured if isinstance(configured, str) else ",".join(configured), f"{name} in the configuration file"


def _choice(config: pytest.Config) -> _Choice:
    if _CHOICE not in config.stash:
        config.stash[_CHOICE] = _Choice(_chosen_backends(config), _chosen_tol(config))
    return config.stash[_CHOICE]


def _chosen_backends(config: pytest.Config) -> tuple[str, ...]:
    from contactqp.backends import backend_names, installed_backends, why_missing

    given = _given(config, "contact_backends")
    if given is None:
        return tuple(installed_backends())
    text, source = given
    names = tuple(name for name in re.split(r"[\s,]+", text) if name)
    if not names:
        raise pytest.UsageError(f"{source} names no backend, got {text!r}; known: auto, {', '.join(backend_names())}")
    if len(set(names)) < len(names):
        raise pytest.UsageError(f"{source} must not repeat a backend, got {text!r}")
    for name in names:
        complaint = None if name == "auto" else why_missing(name)
        if complaint is not None:
            raise pytest.UsageError(f"{source}: {complaint}")
    return names


def _chosen_tol(config: pytest.Config) -> float:
    given = _given(config, "contact_tol")
    if given is None:
        return DEFAULT_TOL
    text, source = given
    try:
        tol = float(text)
    except ValueError:
        tol = float("nan")
    if not 0 < tol < 1:
        raise pytest.UsageError(f"{source} must be a number strictly between 0 and 1, got {text!r}; take 1e-6, say")
    return tol


def _suitable(names: Sequence[str], problem: ContactProblem | ContactModel) -> Sequence[str]:
    """Return those of the backends that suit the problem; all if none does, so that each tells why."""
    from contactqp.backends import get_backend
    from contactqp.errors import UnsuitableProblemError
    from contactqp.models.base import ContactModel
    from contactqp.problem.contact_problem import ContactProblem

    algebra = problem.problem if isinstance(problem, ContactModel) else problem
    if not isinstance(algebra, ContactProblem):
        return names

    def suits(name: str) -> bool:
        try:
            if name != "auto":
                get_backend(name).check_problem(algebra)
        except UnsuitableProblemError:
            return False
        return True

    return [name for name in names if suits(name)] or names


def _summary(config: pytest.Config) -> str:
    from contactqp import __version__

    choice = _choice(config)
    return f"contactqp: {__version__}, tol {choice.tol:g}, backends {', '.join(choice.backends)}"
