"""Work on every core: in order, on no more cores than the process was given."""

from __future__ import annotations

import threading
from collections.abc import Callable

import drjit
import numpy as np
import pytest
from threadpoolctl import threadpool_info, threadpool_limits

from foundation import cores


@pytest.mark.parametrize("given", [1, 3])
def test_work_keeps_to_the_cores_that_were_given(
    given: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """So many threads at once, kernels as well; and results in the order of the items."""
    told: list[int] = []
    monkeypatch.setattr(drjit, "set_thread_count", told.append)
    monkeypatch.setattr(cores, "_given", [])
    assert cores.cores() >= 1
    cores.keep_to(given)
    assert (cores.cores(), told) == (given, [given])
    lock, now, most = threading.Lock(), 0, 0
    together = threading.Barrier(given, timeout=20)

    def work(item: int) -> int:
        nonlocal now, most
        with lock:
            now += 1
            most = max(most, now)
        together.wait()  # broken unless so many run at once
        with lock:
            now -= 1
        return item * item

    assert list(cores.in_order(work, range(6 * given))) == [k * k for k in range(6 * given)]
    assert most == given


def _threads_of_products() -> set[int]:
    np.ones((2, 2)) @ np.ones((2, 2))
    return {one["num_threads"] for one in threadpool_info() if one["user_api"] == "blas"}


def test_products_keep_to_one_core_for_a_while() -> None:
    """The user's own products have all cores again afterwards."""
    with threadpool_limits(limits=2, user_api="blas"):
        with cores.products_on_one_core():
            assert _threads_of_products() == {1}
        assert _threads_of_products() == {2}


def test_a_few_pieces_are_begun_before_the_first_is_asked_for() -> None:
    """The results in order; no more of them on the way at once than that."""
    on_the_way: list[int] = []
    most = 0

    def begun(item: int) -> Callable[[], int]:
        nonlocal most
        on_the_way.append(item)
        most = max(most, len(on_the_way))

        def result() -> int:
            assert on_the_way.pop(0) == item
            return item

        return result

    assert list(cores.ahead(map(begun, range(10)))) == list(range(10))
    assert most == cores.AHEAD + 1
    assert list(cores.ahead(map(begun, range(1)))) == [0]


@pytest.mark.parametrize(("given", "kernels"), [(1, 1), (2, 1), (8, 4)])
def test_libraries_beside_other_work_have_few_cores(
    given: int, kernels: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Half of them for kernels, one for products of matrices; and all of them again afterwards."""
    told: list[int] = []
    monkeypatch.setattr(cores, "_given", [given])
    monkeypatch.setattr(drjit, "thread_count", lambda: given)
    monkeypatch.setattr(drjit, "set_thread_count", told.append)
    with threadpool_limits(limits=2, user_api="blas"):
        with cores.libraries_beside_other_work():
            assert (told, _threads_of_products()) == ([kernels], {1})
        assert (told, _threads_of_products()) == ([kernels, given], {2})
