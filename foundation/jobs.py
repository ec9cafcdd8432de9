"""Many cases of one computation, on all cores of this machine or on a cluster: the same bytes.

A job is a pure function of a case. It draws its randomness from seeds inside the case, so its
result depends neither on who computes it nor on when. Dask is the engine: by default inside this
process, one thread a core; with an address, wherever that scheduler's workers are.

    def trip(images, seed):                  # a function of a module: workers import it by name
        ...
        return {"bias": 0.012}               # plain data, if there is a journal

    results = run(
        trip,
        {f"body-{seed}": seed for seed in range(1000)},
        shared=images,                       # sent once, not once a case
        scheduler="tcp://10.0.0.1:8786",     # from --scheduler; None is this process
        journal=out / "results.jsonl",       # kept as they come; a second run goes on from there
        question="trip of icx098 seed 0",    # whatever decides the results
        progress=advance,
    )
    results["body-7"]                        # in the order of the cases, whoever came first

A worker that dies takes nothing with it: its cases are given to the others. A case that kills four
workers is reported, with what to do. Workers must run the versions and the backend of this process,
or the bytes would differ: each case checks.
"""

from __future__ import annotations

import contextlib
import functools
import gc
import importlib.metadata
import logging
import uuid
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, TypeVar

from foundation.backend import backend
from foundation.cores import cores, keep_to
from foundation.errors import InputError
from foundation.journal import Journal, put_in_order

Case = TypeVar("Case")
Result = TypeVar("Result")

PROCESSES = "processes"
"""The scheduler that is started here, with a worker process for each core."""

ALLOWED_DEATHS = 3
"""A case may take this many workers with it before it is given up."""

CONNECT_S = 10.0
"""How long a scheduler elsewhere may take to answer."""

BEGIN_S = 120.0
"""How long one in this process may take to begin: it is there, but the machine may be busy."""

IN_FLIGHT = 4
"""Cases given out per thread of the workers: enough that none waits, few enough for memory."""

HERE_ALONE = "127.0.0.1:0"
"""Dask opens pages of its own: on any free port, for this machine alone."""

PACKAGES = ("camtruth", "drjit", "mitsuba", "numpy", "scipy")

QUIET = {
    "distributed.scheduler.allowed-failures": ALLOWED_DEATHS,
    "distributed.admin.large-graph-warning-threshold": "1GB",
    "distributed.worker.memory.spill": False,
    # it looks at all threads' stacks a hundred times a second, and where Python collects garbage on
    # that way (CPython issue 106883) a worker stands still for ever
    "distributed.worker.profile.enabled": False,
    # Dask has a worker give freed memory back at once, and ask for it again: a fifth of its time
    "distributed.nanny.pre-spawn-environ.MALLOC_TRIM_THRESHOLD_": 2**30,
    "distributed.nanny.pre-spawn-environ.MALLOC_MMAP_THRESHOLD_": 2**25,
}


class JobError(InputError):
    """The workers cannot do what they are asked."""


def run(
    work: Callable[[Any, Case], Result],
    cases: Mapping[str, Case],
    *,
    shared: Any = None,
    scheduler: str | None = None,
    threads: int | None = None,
    journal: Path | None = None,
    question: str = "",
    progress: Callable[[int], None] = lambda done: None,
) -> dict[str, Result]:
    """The results of ``work(shared, case)`` by key, in the order of the cases.

    Args:
        work: a pure function at the top of a module.
        cases: by key; small plain data.
        shared: what all cases need, such as rate images; picklable.
        scheduler: address of a Dask scheduler, `PROCESSES`, or None for this process.
        threads: cases at once in this process; one per core by default.
        journal: file that keeps results as they come, in the order of the cases when all of
            them, and no others, are there. What stands in it is not computed again.
            Results must be plain JSON data then.
        question: what decides the results besides the key; a journal of another is refused.
        progress: told the number of cases just finished.

    Raises:
        JobError: when the scheduler does not answer, or a case kills its workers.
        InputError: whatever `work` raised first; what was done by then is in the journal.
    """
    with contextlib.ExitStack() as stack:
        kept = stack.enter_context(Journal.open(journal, question)) if journal else None
        done: dict[str, Result] = dict(kept.results) if kept else {}
        known = [key for key in cases if key in done]
        progress(len(known))
        missing = {key: case for key, case in cases.items() if key not in done}
        for key, result in _computed(work, missing, shared, scheduler, threads or cores()):
            done[key] = kept.append(key, result) if kept else result
            progress(1)
    if journal:
        put_in_order(journal, cases)
    return {key: done[key] for key in cases}


def refuse_absent(scheduler: str) -> None:
    """Refuse a scheduler elsewhere that does not answer or has no workers, before there is work.

    Raises:
        JobError: with how to start one.
    """
    if scheduler != PROCESSES:
        with _client(scheduler, 1):
            pass


def _computed(
    work: Callable[[Any, Case], Result],
    cases: Mapping[str, Case],
    shared: Any,
    scheduler: str | None,
    threads: int,
) -> Iterator[tuple[str, Result]]:
    """Keys and results as they come."""
    if not cases:
        return
    if scheduler is None and (threads == 1 or len(cases) == 1):
        for key, case in cases.items():
            yield key, work(shared, case)
        return
    with _client(scheduler, min(threads, len(cases))) as client:
        apart = scheduler is not None
        yield from _gathered(client, work, cases, shared, fingerprint(), apart)


@contextlib.contextmanager
def _client(scheduler: str | None, threads: int) -> Iterator[Any]:
    import dask
    from distributed import Client, LocalCluster

    for name in ("distributed", "distributed.worker", "distributed.scheduler", "distributed.core"):
        logging.getLogger(name).setLevel(logging.CRITICAL)
    with contextlib.ExitStack() as stack:
        stack.enter_context(dask.config.set(QUIET))
        place: Any = scheduler
        if scheduler in (None, PROCESSES):
            apart = scheduler == PROCESSES
            place = stack.enter_context(
                LocalCluster(
                    n_workers=threads if apart else 1,
                    threads_per_worker=1 if apart else threads,
                    processes=apart,
                    dashboard_address=HERE_ALONE,
                    worker_dashboard_address=HERE_ALONE,
                    memory_limit=0,
                )
            )
        yield stack.enter_context(_connected(Client, place, scheduler))


def _connected(client: type[Any], place: Any, scheduler: str | None) -> Any:
    """A client of a scheduler that answers and has workers."""
    patience_s = CONNECT_S if scheduler is not None else BEGIN_S
    connected = None
    with contextlib.suppress(OSError, ValueError):
        connected = _begun(client, place, patience_s)
    if connected is None:
        # What is left of the client takes a lock of Dask's when it is collected: if that happened
        # while another one begins, which holds the lock, both would wait forever.
        gc.collect()
        raise JobError(
            f"no answer from the scheduler {scheduler}",
            "expected the address of a running Dask scheduler",
            "start one with 'dask scheduler', as in --scheduler tcp://127.0.0.1:8786",
        )
    try:
        connected.wait_for_workers(1, timeout=patience_s)
    except TimeoutError:
        connected.close()
        raise JobError(
            f"the scheduler {scheduler} has no workers",
            "expected at least one",
            f"start some with 'dask worker {scheduler}'",
        ) from None
    return connected


STARTS = 3
"""How often a client is begun: Dask gives its own thread ten seconds to start, and fails without a
word on a machine that is busy for longer."""


def _begun(client: type[Any], place: Any, patience_s: float) -> Any:
    """A client, begun again where its thread came too late."""
    for _ in range(STARTS - 1):
        with contextlib.suppress(AssertionError):
            return client(place, timeout=patience_s)
    return client(place, timeout=patience_s)


def _gathered(
    client: Any,
    work: Callable[[Any, Case], Result],
    cases: Mapping[str, Case],
    shared: Any,
    expected: Mapping[str, str],
    apart: bool,
) -> Iterator[tuple[str, Result]]:
    from concurrent.futures import CancelledError

    from distributed import KilledWorker, as_completed

    run_id = uuid.uuid4().hex
    # A task, not scattered data: if the worker that holds it dies, Dask makes it again.
    held = client.submit(_hold, shared, key=f"shared-{run_id}", pure=False)
    waiting = iter(cases.items())
    names: dict[str, str] = {}

    def give(count: int) -> list[Any]:
        futures = []
        for _, (key, case) in zip(range(count), waiting, strict=False):
            task = f"case-{run_id}-{len(names)}"
            names[task] = key
            futures.append(client.submit(_checked, work, held, case, expected, apart, key=task))
        return futures

    room = IN_FLIGHT * max(1, sum(client.nthreads().values()))
    finished = as_completed(give(room))
    for future in finished:
        key = names[future.key]
        try:
            result = future.result()
        except KilledWorker:
            raise JobError(
                f"case '{key}' lost {ALLOWED_DEATHS + 1} workers",
                "expected workers that outlive it",
                "give them more memory or fewer threads, then run it again with --resume",
            ) from None
        except CancelledError:
            raise JobError(
                f"the scheduler was gone before case '{key}' was done",
                "expected it to stay",
                "start it anew, then run it again with --resume",
            ) from None
        except ModuleNotFoundError as problem:
            raise JobError(
                f"a worker has no module '{problem.name}'",
                "expected camtruth and what it needs on every machine",
                "install the same requirements.lock there",
            ) from None
        future.release()
        finished.update(give(1))
        yield key, result


def _hold(shared: Any) -> Any:
    return shared


def _checked(
    work: Callable[[Any, Case], Result],
    shared: Any,
    case: Case,
    expected: Mapping[str, str],
    apart: bool,
) -> Result:
    if apart:
        _keep_to_own_cores()
    here = fingerprint()
    for name, version in expected.items():
        if here[name] != version:
            raise JobError(
                f"a worker has {name} {here[name]}",
                f"expected {version} as in the process that asks",
                "install the same requirements.lock on every machine",
            )
    return work(shared, case)


@functools.cache
def _keep_to_own_cores() -> None:
    """In a worker's process, use as many cores as the worker was given threads."""
    from distributed import get_worker

    keep_to(get_worker().state.nthreads)


def fingerprint() -> dict[str, str]:
    """What the bytes of a result depend on besides its case: versions and the backend."""
    versions = {name: importlib.metadata.version(name) for name in PACKAGES}
    return {**versions, "backend": backend().name}
