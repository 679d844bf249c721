"""Starts from earlier answers and sessions, over rows that are divided: by threads in the place of processes."""

import shutil

import numpy as np
import pytest
from membranes_by_rows import CASES
from peers import alone, by_peers, in_the_place_of_ranks

import contactqp as cq
from contactqp.mpi.store import opened

pytest.importorskip("zarr")


@pytest.fixture(autouse=True)
def threads_in_the_place_of_processes(monkeypatch):
    in_the_place_of_ranks(monkeypatch)


def told(answer):
    """Return what must not depend on the number of processes: own rows, and numbers of all."""
    fields = answer.gap, answer.reaction, answer.contact_state, *answer.gap_bounds
    return [field.tobytes() for field in fields], (
        answer.gap_bound,
        answer.scale,
        answer.iterations,
        answer.termination,
    )


def same(found):
    """Whether by all numbers of processes the same rows follow each other, and the same numbers are known."""
    rows = [[b"".join(parts) for parts in zip(*(fields for fields, _ in told), strict=True)] for told in found]
    numbers = [one for told in found for _, one in told]
    return all(each == rows[0] for each in rows) and all(each == numbers[0] for each in numbers)


def flat(load=1.0, shape=(60, 24), **given):
    arguments = {"support": lambda x, y: 0.02 + 0.1 * (x - 0.3) ** 2, "tension": 1.0, **given}
    return cq.mpi.MembraneByRows(shape, 0.02, arguments.pop("tension"), load=load, **arguments)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["masked", "between", "patched", "woven"])
def test_starts_from_answers_and_from_stores_are_the_same_to_the_bit(name, tmp_path):
    membrane = CASES[name]()

    def one(peer):
        first = cq.mpi.solve(membrane, peer, tol=1e-5, least_rows=16)
        store = first.to_zarr(tmp_path / f"{peer.size}.zarr")
        again = cq.mpi.solve(membrane, peer, tol=1e-9, warm_start=first, least_rows=16)
        by_store = cq.mpi.solve(membrane, peer, tol=1e-9, warm_start=store, least_rows=16)
        of_three = cq.mpi.solve(membrane, peer, tol=1e-9, warm_start=tmp_path / "3.zarr", least_rows=16)
        cold = cq.mpi.solve(membrane, peer, tol=1e-9, least_rows=16)
        assert again.status.value == "certified"
        assert told(again) == told(by_store) == told(of_three)
        assert again.iterations < cold.iterations
        return told(again)

    assert same([by_peers(size, one) for size in (3, 1, 2)])


@pytest.mark.slow
@pytest.mark.parametrize("name", ["masked", "between", "patched", "woven"])
def test_sessions_are_the_same_to_the_bit(name):
    """Through a change of the coarser lattices' solutions, predictions, a cold start, and another load."""
    membrane = CASES[name]()

    def one(peer):
        session = cq.mpi.Solver(membrane, peer, tol=1e-8, least_rows=16)
        answers = [session.solve_varied(membrane.with_load(factor)) for factor in (0.8, 0.9, 1.0, 1.1)]
        answers.append(session.solve(warm_start=False))
        cold = cq.mpi.solve(membrane, peer, tol=1e-8, least_rows=16)
        assert told(answers[-1]) == told(cold)
        answers.append(session.solve(load=lambda x, y: 1.0 + y))
        assert all(answer.status.value == "certified" for answer in answers)
        return [told(answer) for answer in answers]

    found = [by_peers(size, one) for size in (1, 2, 3)]
    for number in range(6):
        assert same([[answers[number] for answers in ranks] for ranks in found])


@pytest.mark.slow
@pytest.mark.parametrize("loads", [(0.6, 0.8, 1.0, 1.2), (1.2, 1.0, 1.0, 0.8), (0.5, 0.7, 0.5, 0.9)])
def test_a_trace_leaves_the_same_stores_when_it_was_interrupted(loads, tmp_path):
    membrane = CASES["masked"]()

    def one(folder):
        return lambda peer: cq.mpi.trace(membrane, loads, tmp_path / folder, peer, tol=1e-7, least_rows=16)

    by_peers(1, one("whole"))
    for number in range(4):
        shutil.copytree(tmp_path / "whole", tmp_path / "part")
        for lost in range(number, 4):
            shutil.rmtree(tmp_path / "part" / f"load-{lost:04d}.zarr")
        for steps in by_peers(2, one("part")):
            assert [step.resumed for step in steps] == [k < number for k in range(4)]
        for k in range(4):
            whole, part = (opened(tmp_path / folder / f"load-{k:04d}.zarr")["gap"][:] for folder in ("whole", "part"))
            np.testing.assert_array_equal(whole, part)
        shutil.rmtree(tmp_path / "part")


def test_a_prediction_saves_cycles(tmp_path):
    membrane = flat(tension=lambda x, y: 1.0 + 5.0 * (x > 0.2))
    loads = np.linspace(1.0, 2.0, 8)
    cold = [cq.mpi.solve(membrane.with_load(load), alone(), tol=1e-8).iterations for load in loads]
    session = cq.mpi.Solver(membrane, alone(), tol=1e-8)
    warm = [session.solve_varied(membrane.with_load(load)).iterations for load in loads]
    assert sum(warm) < sum(cold)


def test_one_process_goes_on_as_the_backend_does():
    membrane = flat()
    model = cq.Membrane(
        cq.Lattice.from_mask(np.ones((60, 24), dtype=bool), 0.02), 1.0, load=1.0, support=membrane.given["support"]
    )
    session, whole = cq.mpi.Solver(membrane, alone(), tol=1e-8), cq.Solver(model, "multigrid", tol=1e-8)
    for load in (1.0, 1.1, 1.2, 1.3, 0.7):
        answer, solution = session.solve(load=load), whole.solve(load=load)
        assert answer.iterations == solution.iterations
        np.testing.assert_allclose(answer.gap.ravel(), solution.gap, atol=1e-12)


def test_a_start_is_clipped_and_one_of_more_energy_is_left_out():
    """An answer under suction is far above; started from it the membrane under a load finds its way all the same."""
    above = cq.mpi.solve(flat(load=-5.0), alone())
    cold, warm = (cq.mpi.solve(flat(), alone(), warm_start=start) for start in (None, above))
    assert told(warm) == told(cold)  # its energy is more than that of zero
    capped = flat(ceiling=0.0)
    loose = cq.mpi.solve(flat(load=-1e-3), alone())
    answer = cq.mpi.solve(capped, alone(), warm_start=loose)
    assert answer.status.value == "certified"
    assert answer.deflection.min() >= 0.0


def refusals(membrane, warm_start, size=2, **given):
    """Return the words that each of several processes refuses a start with."""

    def one(peer):
        value = warm_start(peer) if callable(warm_start) else warm_start
        with pytest.raises((ValueError, TypeError, OSError)) as refused:
            cq.mpi.solve(membrane, peer, warm_start=value, **given)
        return type(refused.value).__name__, str(refused.value)

    return by_peers(size, one)


def test_other_starts_are_refused_in_the_same_words_by_all(tmp_path):
    masked = flat(mask=lambda x, y: x + y < 1.4)
    answers = by_peers(2, lambda peer: cq.mpi.solve(flat(), peer))
    stores = {}
    for name, membrane in {
        "same": flat(),
        "shorter": flat(shape=(59, 24)),
        "shifted": flat(origin=(0.0, 0.5)),
        "masked": masked,
    }.items():
        stores[name] = cq.mpi.solve(membrane, alone()).to_zarr(tmp_path / f"{name}.zarr")
    spoilt = stores["same"].with_name("spoilt.zarr")
    shutil.copytree(stores["same"], spoilt)
    import zarr

    zarr.open_array(spoilt / "gap", mode="r+")[50, 3] = np.inf
    other = tmp_path / "other.zarr"
    zarr.open_group(other, mode="w", zarr_format=3)
    single = cq.mpi.solve(flat(), alone())
    refused = {
        "lattice, 60 x 24, but the store": stores["shorter"],
        "whose y goes from 0 to 1.18, but that of the store": stores["shifted"],
        "a finite gap at every node of the membrane, but it is nan at x=0.46, y=0.94": stores["masked"],
        "but it is inf at x=0.06, y=1": spoilt,
        "holds no 'gap'": other,
        "is no Zarr store, or a damaged one": tmp_path / "missing.zarr",
        "must be an AnswerByRows, or the path": 3.0,
        "must be the same in every process, but process 0 has no warm start, and process 1 the store": (
            lambda peer: stores["same"] if peer.rank else None
        ),
        "holds rows 0 to 38, and has those of 0 to 60, as process 0 of 1; write it by to_zarr": single,
    }
    for words, start in refused.items():
        (kind, first), second = refusals(flat(), start)
        assert words in first
        assert second == (kind, first)
    (_, words), _ = refusals(masked, stores["same"])
    assert "where the membrane has no node: it is of another mask" in words
    (_, words), _ = refusals(masked, lambda peer: answers[peer.rank])
    assert "that is of another mask" in words
    (_, words), _ = refusals(flat(shape=(59, 24)), lambda peer: answers[peer.rank])
    assert "lattice, 59 x 24, but the answer is of 60 x 24" in words


def test_a_session_is_of_one_membrane(tmp_path):
    session = cq.mpi.Solver(flat(), alone())
    with pytest.raises(ValueError, match="must differ in its load alone"):
        session.solve_varied(flat(load=2.0))
    with pytest.raises(TypeError, match=r"Solver.solve has no argument 'loads'"):
        session.solve(loads=1.0)  # type: ignore[call-arg]
    with pytest.raises(ValueError, match="load must be a number"):
        session.solve(load=np.ones((3, 4)))
    with pytest.raises(ValueError, match="load must be finite"):
        session.solve(load=lambda x, y: np.nan * x)
    assert session.solve().status.value == "certified"
    store = session.solve(load=2.0).to_zarr(tmp_path / "heavy.zarr")
    assert session.solve(load=2.0, warm_start=store).iterations == 1
    assert session.solve(load=2.0).iterations == 1


def test_refusals_come_before_what_takes_long(monkeypatch):
    """Where the tension varies a linear problem is solved for the proof: not for a start that is refused."""
    from contactqp.mpi import posed

    def never(*_):
        raise AssertionError("a barrier was looked for")

    answer = cq.mpi.solve(flat(), alone())
    monkeypatch.setattr(posed, "found_barrier", never)
    masked = flat(mask=lambda x, y: x + y < 1.4, tension=lambda x, y: 1.0 + x)
    with pytest.raises(ValueError, match="another mask"):
        cq.mpi.solve(masked, alone(), warm_start=answer)
