"""The pytest plugin, run on small suites.

Runs in this process must not solve: whatever they import is forgotten afterwards, and compiled libraries cannot be
imported twice. Runs that solve have a process of their own.
"""

import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

import contactqp as cq
from contactqp.backends import get_backend

ROOT = Path(__file__).parents[2]
INSTALLED = cq.backend_names()
for _name in INSTALLED:
    get_backend(_name)


@pytest.fixture
def alone(pytester, monkeypatch):
    """Load the plugin by name and no other, whether or not the environment has it as an entry point."""
    monkeypatch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")
    monkeypatch.setenv("PYTEST_PLUGINS", "pytest_contactqp")
    monkeypatch.delenv("PYTEST_ADDOPTS", raising=False)
    return pytester


@pytest.fixture
def installed(pytester, monkeypatch):
    """Announce the plugin as a wheel does; it comes first on the path, so an installed contactqp is not seen."""
    for name in ("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "PYTEST_PLUGINS", "PYTEST_ADDOPTS"):
        monkeypatch.delenv(name, raising=False)
    declared = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["entry-points"]
    entries = [f"{name} = {value}" for name, value in declared["pytest11"].items()]
    record = pytester.mkdir(f"contactqp-{cq.__version__}.dist-info")
    (record / "METADATA").write_text(f"Metadata-Version: 2.1\nName: contactqp\nVersion: {cq.__version__}\n")
    (record / "entry_points.txt").write_text("\n".join(["[pytest11]", *entries]))
    (record / "RECORD").write_text("contactqp/__init__.py,,\npytest_contactqp.py,,\n")
    pytester.makepyprojecttoml(
        """
        [tool.pytest.ini_options]
        addopts = ["--strict-config", "--strict-markers"]
        filterwarnings = ["error"]
        """
    )
    return pytester


def collected(pytester, *options):
    """Return the ids that a run would execute."""
    result = pytester.runpytest_inprocess("--collect-only", "-q", *options)
    assert result.ret == 0
    return [line.partition("::")[2] for line in result.outlines if "::" in line]


def test_a_test_that_asks_for_a_backend_runs_once_with_each(alone):
    alone.makepyfile("def test_it(contact_backend): pass")
    assert collected(alone) == [f"test_it[{name}]" for name in INSTALLED]
    assert collected(alone, "--contact-backends=psor, osqp") == ["test_it[psor]", "test_it[osqp]"]
    assert collected(alone, "--contact-backends=auto") == ["test_it[auto]"]


@pytest.mark.parametrize("value", ['"psor clarabel"', '"psor, clarabel"', '["psor", "clarabel"]'])
def test_the_configuration_file_names_backends_too(alone, value):
    alone.makepyprojecttoml(f"[tool.pytest.ini_options]\ncontact_backends = {value}")
    alone.makepyfile("def test_it(contact_backend): pass")
    assert collected(alone) == ["test_it[psor]", "test_it[clarabel]"]
    assert collected(alone, "--contact-backends=osqp") == ["test_it[osqp]"]


def test_a_fixture_of_any_scope_may_ask_for_a_backend(alone):
    alone.makepyfile(
        """
        import pytest

        made = []

        @pytest.fixture(scope="module")
        def answer(contact_backend):
            made.append(contact_backend)
            return contact_backend.upper()

        def test_first(answer, contact_backend):
            assert answer == contact_backend.upper()

        def test_second(answer, contact_backend):
            assert made[-1] == contact_backend
            assert len(set(made)) == len(made)
        """
    )
    alone.runpytest_inprocess("--contact-backends=osqp,psor").assert_outcomes(passed=4)


def test_a_suite_may_choose_backends_of_its_own(alone):
    alone.makepyfile(
        test_marked="""
        import pytest

        @pytest.mark.parametrize("contact_backend", ["psor"])
        def test_it(contact_backend):
            assert contact_backend == "psor"
        """,
        test_overridden="""
        import pytest

        @pytest.fixture(params=["mine", "yours"])
        def contact_backend(request):
            return request.param

        def test_it(contact_backend):
            assert contact_backend in ("mine", "yours")
        """,
    )
    assert collected(alone) == ["test_it[psor]", "test_it[mine]", "test_it[yours]"]
    alone.runpytest_inprocess().assert_outcomes(passed=3)


SETTINGS = """
def test_settings(contact_backends, contact_tol):
    assert (contact_backends, contact_tol) == ({!r}, {!r})
"""


def test_settings_by_default(alone):
    alone.makepyfile(SETTINGS.format(INSTALLED, 1e-6))
    alone.runpytest_inprocess().assert_outcomes(passed=1)


@pytest.mark.parametrize(
    ("configured", "options", "tol"),
    [("", ["--contact-tol=1e-8"], 1e-8), ("1e-3", [], 1e-3), ("1e-3", ["--contact-tol=0.5"], 0.5)],
)
def test_the_tolerance_can_be_set(alone, configured, options, tol):
    alone.makeini(f"[pytest]\ncontact_tol = {configured}")
    alone.makepyfile(SETTINGS.format(["osqp"], tol))
    alone.runpytest_inprocess("--contact-backends=osqp", *options).assert_outcomes(passed=1)


def test_a_backend_without_its_library_is_left_out_unless_it_is_named(alone, monkeypatch):
    monkeypatch.setattr(type(get_backend("osqp")), "version", lambda self: None)
    alone.makepyfile(SETTINGS.format([name for name in INSTALLED if name != "osqp"], 1e-6))
    alone.runpytest_inprocess().assert_outcomes(passed=1)
    result = alone.runpytest_inprocess("--contact-backends=clarabel,osqp")
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    result.stderr.fnmatch_lines(
        ["*--contact-backends: backend 'osqp' needs the package 'osqp'*type: pip install osqp*"]
    )


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--contact-backends=ossqp"], f"--contact-backends: unknown*'osqp'*known: auto, {', '.join(INSTALLED)}*"),
        (["--contact-backends=,"], f"--contact-backends names no backend, got ','; known: auto, {INSTALLED[0]}, *"),
        (["--contact-backends="], "--contact-backends names no backend, got ''; known: *"),
        (["--contact-backends=osqp,psor,osqp"], "--contact-backends must not repeat a backend, got 'osqp,psor,osqp'"),
        (["-o", "contact_backends=ossqp"], "contact_backends in the configuration file: unknown backend 'ossqp'*"),
        (["--contact-tol=0"], "--contact-tol must be a number strictly between 0 and 1, got '0'*"),
        (["--contact-tol=nan"], "--contact-tol must be a number strictly between 0 and 1, got 'nan'*"),
        (["--contact-tol=tight"], "--contact-tol must be a number strictly between 0 and 1, got 'tight'*"),
        (["-o", "contact_tol=1"], "contact_tol in the configuration file must be *, got '1'*"),
    ],
)
def test_bad_options_end_the_run_before_a_test_is_seen(alone, options, message):
    alone.makepyfile("raise SystemExit('collected')")
    result = alone.runpytest_inprocess("-q", *options)  # without a header, which would find out too
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    result.stderr.fnmatch_lines([f"ERROR: {message}"])
    assert "collect" not in result.stdout.str()


def test_a_backend_that_cannot_be_imported_is_left_out_unless_it_is_named(alone):
    record = alone.mkdir("strangers-1.0.dist-info")
    (record / "METADATA").write_text("Metadata-Version: 2.1\nName: strangers\nVersion: 1.0\n")
    (record / "entry_points.txt").write_text(
        "[contactqp.backends]\nbroken = strangers:Broken\nloose = strangers:Loose\n"
    )
    alone.makepyfile(
        strangers="""
        from contactqp.backends.base import Backend

        class Loose(Backend):
            name, summary, package = "loose", "takes anything", "numpy"

            def solve(self, problem, task, **options):
                raise AssertionError
        """
    )
    alone.makepyfile("def test_it(contact_backend): pass")
    result = alone.runpytest_subprocess("-v")
    result.assert_outcomes(passed=len(INSTALLED))
    result = alone.runpytest_subprocess("--contact-backends=broken")
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    result.stderr.fnmatch_lines(["ERROR: --contact-backends: backend 'broken' * cannot be loaded: AttributeError: *"])
    result = alone.runpytest_subprocess("--contact-backends=loose")
    result.stderr.fnmatch_lines(["ERROR: --contact-backends: backend 'loose' must name its options as keywords *"])


SAID = "contactqp: *, tol *, backends *"


def test_runs_that_ask_for_it_are_told_version_tolerance_and_backends(alone):
    alone.makepyfile("def test_it(assert_complementary): pass")
    lines = [f"contactqp: {cq.__version__}, tol 1e-06, backends {', '.join(INSTALLED)}"]
    alone.runpytest_inprocess().stdout.fnmatch_lines(["collected 1 item", *lines])
    alone.runpytest_inprocess("-q").stdout.no_fnmatch_line(SAID)
    lines = [f"contactqp: {cq.__version__}, tol 1e-06, backends psor, auto"]
    result = alone.runpytest_inprocess("--contact-backends=psor,auto")
    result.stdout.fnmatch_lines([*lines, "collected 1 item"])
    assert result.stdout.str().count("contactqp: ") == 1


def test_other_runs_are_told_nothing(alone):
    alone.makepyfile("def test_it(tmp_path): pass")
    result = alone.runpytest_inprocess()
    result.assert_outcomes(passed=1)
    result.stdout.no_fnmatch_line(SAID)


ASSERTIONS = """
import pytest
import contactqp as cq

MATRIX = cq.ContactQP([[2.0, -1.0], [-1.0, 2.0]], [-1.0, 3.0])
NO_Z_MATRIX = cq.ContactQP([[1.0, 0.5], [0.5, 1.0]], [-1.0, 1.0])

def test_tolerance(assert_complementary):
    assert_complementary(MATRIX, [0.5 + 1e-4, 0.0])

def test_tolerance_of_its_own(assert_complementary):
    assert_complementary(MATRIX, [0.5 + 1e-4, 0.0], tol=1e-2)

def test_agreement_takes_the_backends_that_suit(assert_backends_agree):
    assert list(assert_backends_agree(MATRIX).solutions) == ["osqp", "auto", "psor"]

def test_agreement_of_others(assert_backends_agree, contact_tol):
    comparison = assert_backends_agree(MATRIX, ["clarabel"])
    assert list(comparison.solutions) == ["clarabel"]
    assert comparison.tol == contact_tol

def test_bounds_and_contact(assert_encloses, assert_same_contact):
    first, second = cq.solve(MATRIX, "psor"), cq.solve(MATRIX, "active-set")
    assert_encloses(first, [0.5, 0.0])
    assert assert_same_contact(first, second).all()

def test_enclosure_fails(assert_encloses):
    assert_encloses(cq.solve(MATRIX), [1.0, 0.0])
"""


def test_the_assertions_take_the_settings_of_the_run(alone):
    alone.makepyfile(ASSERTIONS)
    backends = "--contact-backends=osqp,multigrid,auto,psor"
    result = alone.runpytest_subprocess(backends, "-W", "error")
    result.assert_outcomes(passed=4, failed=2)
    result.stdout.fnmatch_lines(["FAILED *::test_tolerance *", "FAILED *::test_enclosure_fails*"])
    result = alone.runpytest_subprocess(backends, "-W", "error", "--contact-tol=1e-2")
    result.assert_outcomes(passed=5, failed=1)
    result.stdout.fnmatch_lines(
        [
            ">       assert_encloses(cq.solve(MATRIX), [[]1.0, 0.0[]])",
            "E       AssertionError: gap leaves the bounds of active-set's answer to ContactQP(2 *",
            "E         node 0: gap 1 is 0.5 above the upper bound 0.5",
            "test_*.py:27: AssertionError",
        ]
    )
    result.stdout.no_fnmatch_line("*testing.py*")


def test_where_no_backend_suits_each_tells_why(alone):
    alone.makepyfile(
        """
        import contactqp as cq

        def test_it(assert_backends_agree):
            assert_backends_agree(cq.ContactQP([[1.0, 0.5], [0.5, 1.0]], [-1.0, 1.0]))

        def test_no_problem(assert_backends_agree):
            assert_backends_agree(7)
        """
    )
    result = alone.runpytest_subprocess("--contact-backends=mangasarian,multigrid")
    result.assert_outcomes(failed=2)
    result.stdout.fnmatch_lines(
        [
            "E *No agreement: mangasarian (unsuitable: *needs a Z-matrix*multigrid (unsuitable: *needs a problem *",
            "E *TypeError: problem must be a Membrane, a Cable, a CableNet, a ContactQP or a ContactLCP, got int",
        ]
    )


def test_importing_the_plugin_imports_nothing_heavy():
    code = "import pytest_contactqp, sys; print({'contactqp', 'numpy', 'scipy'} & set(sys.modules))"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == "set()"


def test_an_installed_plugin_leaves_other_suites_alone(installed):
    installed.makepyfile(
        """
        import sys

        def test_it(pytestconfig):
            assert pytestconfig.pluginmanager.has_plugin("contactqp")
            assert "contactqp" not in sys.modules
        """
    )
    result = installed.runpytest_subprocess()
    result.assert_outcomes(passed=1, warnings=0)
    result.stdout.no_fnmatch_line(SAID)


def test_an_installed_plugin_works_under_strict_settings(installed):
    installed.makepyfile(
        """
        import contactqp as cq

        def test_it(contact_backend, assert_complementary):
            cable, _ = cq.gallery.cable_on_floor(nodes=9, contact_starts_after=2)
            assert_complementary(cable, cq.solve(cable, contact_backend).gap)
        """
    )
    result = installed.runpytest_subprocess("--contact-backends=osqp,active-set")
    result.assert_outcomes(passed=2, warnings=0)
    result.stdout.fnmatch_lines([f"contactqp: {cq.__version__}, tol 1e-06, backends osqp, active-set"])
    result = installed.runpytest_subprocess("-p", "no:contactqp")
    result.stdout.fnmatch_lines(["E *fixture 'contact_backend' not found"])


def test_contactqp_may_be_imported_before_pytest(installed):
    """A marked package that was imported unmarked is a warning, here an error before the first test."""
    path = installed.makepyfile("def test_it(contact_tol): assert contact_tol == 1e-6")
    code = f"import contactqp, pytest_contactqp, pytest, sys; sys.exit(pytest.main([{str(path)!r}]))"
    result = installed.run(sys.executable, "-c", code)
    assert result.ret == 0
    result.assert_outcomes(passed=1, warnings=0)
