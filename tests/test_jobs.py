"""Many cases at once: the same results in this process, on threads, and on a cluster that loses
a worker; and a run that was killed goes on where it stopped."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import distributed
import numpy as np
import pytest

from foundation.errors import InputError, OutputError
from foundation.jobs import JobError, run
from foundation.journal import Journal
from tests.clusters import Cluster, two_workers

SEEDS = {f"body-{seed}": seed for seed in range(40)}


def draws(pause_s: float = 0.0) -> Callable[[float, int], dict[str, float]]:
    """A job whose figures depend on its seed alone; a closure, so that workers get its source."""

    def work(scale: float, seed: int) -> dict[str, float]:
        time.sleep(pause_s)
        values = np.random.default_rng(seed).normal(size=1000) * scale
        return {"mean": float(values.mean()), "sd": float(values.std())}

    return work


def text(results: dict[str, dict[str, float]]) -> str:
    return json.dumps(results)


@pytest.fixture(scope="module")
def alone() -> str:
    return text({key: draws()(2.0, seed) for key, seed in SEEDS.items()})


def test_threads_give_the_results_of_a_plain_loop_in_the_order_of_the_cases(alone: str) -> None:
    told = []
    for threads in (1, 3):
        told.clear()
        assert text(run(draws(), SEEDS, shared=2.0, threads=threads, progress=told.append)) == alone
        assert sum(told) == len(SEEDS)


@pytest.mark.parametrize("scheduler", [None, "processes"])
def test_nobody_looks_at_the_stacks_of_threads(scheduler: str | None) -> None:
    """A worker that does so stands still for ever if garbage is collected meanwhile."""

    def watched(_: object, case: int) -> list[str]:
        return sorted(distributed.get_worker().periodic_callbacks)

    for found in run(watched, {"one": 1, "two": 2}, threads=2, scheduler=scheduler).values():
        assert "heartbeat" in found
        assert not [name for name in found if name.startswith("profile")]


def test_no_case_is_no_work() -> None:
    assert run(draws(), {}) == {}


def test_an_error_for_people_keeps_its_parts_on_the_way() -> None:
    def refuse(_: object, case: int) -> int:
        if case == 3:
            raise InputError("found", "expected", "remedy")
        return case

    with pytest.raises(InputError) as caught:
        run(refuse, {str(k): k for k in range(5)}, threads=2)
    assert (caught.value.found, caught.value.remedy) == ("found", "remedy")


def test_nobody_at_the_address(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("foundation.jobs.CONNECT_S", 0.5)
    with pytest.raises(JobError, match=r"scheduler tcp://127\.0\.0\.1:9"):
        run(draws(), SEEDS, shared=1.0, scheduler="tcp://127.0.0.1:9")
    with pytest.raises(JobError, match="no answer from the scheduler nonsense"):
        run(draws(), SEEDS, shared=1.0, scheduler="nonsense://x")


def test_a_client_whose_thread_comes_too_late_is_begun_again(
    monkeypatch: pytest.MonkeyPatch, alone: str
) -> None:
    begun: list[object] = []
    usual = distributed.Client

    def late(place: object, timeout: float) -> object:
        begun.append(place)
        assert len(begun) > 1, "its loop has not started"
        return usual(place, timeout=timeout)

    monkeypatch.setattr(distributed, "Client", late)
    assert text(run(draws(), SEEDS, shared=2.0, threads=2)) == alone
    assert len(begun) == 2


@pytest.fixture(scope="module")
def cluster(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Cluster]:
    with two_workers(tmp_path_factory.mktemp("cluster")) as made:
        yield made


def test_two_workers_one_of_them_killed_in_the_middle_give_the_same_bytes(
    cluster: Cluster, alone: str, tmp_path: Path
) -> None:
    whole = run(draws(), SEEDS, shared=2.0, scheduler=cluster.address)
    assert text(whole) == alone
    done = 0

    def kill_at_ten(parts: int) -> None:
        nonlocal done
        done += parts
        if done == 10:
            cluster.workers[0].kill()

    journal = tmp_path / "results.jsonl"
    survived = run(
        draws(0.02),
        SEEDS,
        shared=2.0,
        scheduler=cluster.address,
        journal=journal,
        progress=kill_at_ten,
    )
    assert cluster.workers[0].wait(10) != 0
    assert text(survived) == alone
    assert done == len(SEEDS)
    assert len(journal.read_text().splitlines()) == 1 + len(SEEDS)


def test_a_stopped_run_computes_only_what_is_missing(alone: str, tmp_path: Path) -> None:
    journal = tmp_path / "results.jsonl"
    run(draws(), dict(list(SEEDS.items())[:15]), shared=2.0, journal=journal, question="q")
    torn = journal.read_bytes()[:-7]
    journal.write_bytes(torn)
    computed = []

    def counted(scale: float, seed: int) -> dict[str, float]:
        computed.append(seed)
        return draws()(scale, seed)

    again = run(counted, SEEDS, shared=2.0, journal=journal, question="q", threads=1)
    assert text(again) == alone
    # threads finish in any order, so which line was cut is not known; that it was one is
    assert len(computed) == len(SEEDS) - 14
    assert len(journal.read_text().splitlines()) == 1 + len(SEEDS)


def test_a_journal_of_threads_is_that_of_one(tmp_path: Path) -> None:
    """Whoever came first; a journal that holds more keeps its order."""
    whole, threads = tmp_path / "whole.jsonl", tmp_path / "threads.jsonl"
    run(draws(), SEEDS, shared=2.0, journal=whole, threads=1)
    backwards = dict(reversed(SEEDS.items()))
    run(draws(), dict(list(backwards.items())[:9]), shared=2.0, journal=threads, threads=1)
    run(draws(0.002), SEEDS, shared=2.0, journal=threads, threads=3)
    assert threads.read_bytes() == whole.read_bytes()
    run(draws(), dict(list(backwards.items())[:9]), shared=2.0, journal=threads, threads=1)
    assert threads.read_bytes() == whole.read_bytes()


def test_a_journal_is_written_by_one_run_alone(tmp_path: Path) -> None:
    journal = tmp_path / "results.jsonl"
    with (
        Journal.open(journal, "one") as first,
        pytest.raises(OutputError, match="another run"),
        Journal.open(journal, "one"),
    ):
        pass
    with Journal.open(journal, "one") as again:
        assert again.results == first.results == {}


def test_a_journal_of_another_question_is_refused(tmp_path: Path) -> None:
    journal = tmp_path / "results.jsonl"
    run(draws(), SEEDS, shared=2.0, journal=journal, question="one")
    with pytest.raises(OutputError, match="another question"):
        run(draws(), SEEDS, shared=2.0, journal=journal, question="two")
    journal.write_text("hello\n")
    with pytest.raises(InputError, match="JSON"):
        run(draws(), SEEDS, shared=2.0, journal=journal, question="two")
    journal.write_text('{"format": "x"}\n')
    with pytest.raises(OutputError, match="no journal"):
        run(draws(), SEEDS, shared=2.0, journal=journal, question="two")


def test_killed_between_any_two_bytes_a_run_ends_with_the_same_results(
    alone: str, tmp_path: Path
) -> None:
    """A journal cut anywhere is the journal of a run that was killed there."""
    whole = tmp_path / "whole.jsonl"
    run(draws(), SEEDS, shared=2.0, journal=whole, threads=1)
    content = whole.read_bytes()
    for cut in np.random.default_rng(1).integers(0, len(content) + 1, 20):
        journal = tmp_path / "cut.jsonl"
        journal.write_bytes(content[:cut])
        assert text(run(draws(), SEEDS, shared=2.0, journal=journal, threads=1)) == alone
        assert journal.read_bytes() == content
