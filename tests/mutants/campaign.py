"""Many mutants on one bench or several."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from queue import SimpleQueue

from tests.mutants.bench import Bench, Outcome
from tests.mutants.mutation import Mutant


def try_all(
    mutants: Sequence[Mutant],
    stages_of: Callable[[Mutant], list[list[str]]],
    benches: Sequence[Bench],
    done: Callable[[Mutant, Outcome], None],
) -> bool:
    """Try mutants out, as many at a time as there are benches; False where the user stopped it by Ctrl-C.

    `stages_of` gives the stages of tests of a mutant; `done` is called with each outcome, as it comes.
    """
    free: SimpleQueue[Bench] = SimpleQueue()
    for bench in benches:
        free.put(bench)

    def one(mutant: Mutant) -> tuple[Mutant, Outcome]:
        bench = free.get()
        try:
            return mutant, bench.try_out(mutant, stages_of(mutant))
        finally:
            free.put(bench)

    pool = ThreadPoolExecutor(len(benches))
    try:
        for future in as_completed([pool.submit(one, mutant) for mutant in mutants]):
            done(*future.result())
        return True
    except KeyboardInterrupt:
        return False
    finally:
        pool.shutdown(wait=False, cancel_futures=True)
        for bench in benches:
            bench.stop()
        pool.shutdown()
