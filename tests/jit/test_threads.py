"""Slices of a batch: every rig once, and threads only where they pay."""

import threading

import pytest

from drillrig_env.jit.threads import available_threads, check_threads, over_slices


@pytest.mark.parametrize(("rigs", "threads", "periods"), [(1, 4, 1), (7, 3, 1000), (500, 2, 1), (10, 100, 10_000)])
def test_slices_cover_every_rig_once(rigs, threads, periods):
    seen, lock = [], threading.Lock()

    def kernel(part):
        with lock:
            seen.append(part)

    over_slices(kernel, rigs, threads, periods)
    assert sorted(i for part in seen for i in range(part.start, part.stop)) == list(range(rigs))
    assert len(seen) <= min(rigs, threads)
    sizes = [part.stop - part.start for part in seen]
    assert max(sizes) - min(sizes) <= 1


@pytest.mark.parametrize(("rigs", "periods", "slices"), [(383, 1, 1), (384, 1, 2), (100, 5, 2), (3, 192, 3)])
def test_a_second_thread_is_woken_for_work_that_repays_it(rigs, periods, slices):
    seen = []
    over_slices(seen.append, rigs, 3, periods)
    assert len(seen) == slices


def test_what_a_slice_raises_reaches_the_caller():
    def kernel(part):
        if part.start > 0:
            raise RuntimeError("in another thread")

    with pytest.raises(RuntimeError, match="in another thread"):
        over_slices(kernel, 1000, 2, 10)


def test_number_of_threads():
    assert check_threads(None) == available_threads() >= 1
    assert check_threads(3) == 3
    for wrong in (0, -1, 1.5):
        with pytest.raises(ValueError, match="threads"):
            check_threads(wrong)
