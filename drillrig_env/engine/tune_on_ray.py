"""Tries of a search on Ray: Tune gives them out and ends early, by ASHA, those that fall behind."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import inf
from typing import Any, Protocol

from drillrig_env.engine.contract import Engine
from drillrig_env.engine.likeness import check_alike
from drillrig_env.engine.on_ray import OnRay
from drillrig_env.engine.packing import unpacked
from drillrig_env.engine.worker import packed_work
from drillrig_env.jit.threads import use_threads

Drawn = Mapping[str, Any]
Told = Callable[[int, float], bool]

_THIRD = 3  # of the tries that came as far goes on from one rung of ASHA to the next
_AGAIN = 3  # more times that a try is begun whose worker or machine was lost
_ERROR = "what_failed"


class Asker(Protocol):
    """Who asks for tries and hears of them: a study."""

    def ask(self) -> tuple[int, dict[str, Any]]:
        """The number of the next try, and what is drawn for it."""

    def told(self, number: int, steps: int, worth: float) -> None:
        """A try has come so far, and is worth so much there."""

    def ended(self, number: int, error: str | None = None) -> None:
        """A try has ended, with an error where it failed."""

    def enough(self) -> bool:
        """Whether the search is at its end."""


@dataclass(frozen=True)
class Tries:
    """What is done for each try: called with what was drawn, and told of steps and worth on the way.

    `steps` is the length of one that is not ended early, `first` that at which one may be ended first.
    """

    work: Callable[[Drawn, Told], object]
    steps: int
    first: int


def is_ray(engine: Engine) -> bool:
    """Whether tries are done on Ray."""
    return isinstance(engine, OnRay)


def tune(engine: Engine, asker: Asker, tries: Tries) -> None:
    """Do tries until there are enough. Ctrl-C cuts those that are on their way."""
    assert isinstance(engine, OnRay)
    engine.begin()
    os.environ["TUNE_DISABLE_SIGINT_HANDLER"] = "1"  # Ctrl-C is an exception, as everywhere
    os.environ.setdefault("RAY_AIR_NEW_OUTPUT", "0")
    from ray import tune as of_ray
    from ray.tune.schedulers import ASHAScheduler

    content = packed_work(tries.work)

    def trainable(config: dict[str, Any]) -> None:
        use_threads(1)
        try:
            wanted, work = unpacked(content)
            check_alike(wanted, "a worker")
            unpacked(work)(config["drawn"], lambda steps, worth: bool(of_ray.report({"steps": steps, "worth": worth})))
        except Exception as error:  # which is the try's own, and is told of
            of_ray.report({"steps": 0, "worth": -inf, _ERROR: f"{type(error).__name__}: {error}"})

    with tempfile.TemporaryDirectory(prefix="drillrig-") as folder:
        of_ray.Tuner(
            of_ray.with_resources(trainable, {"cpu": 1}),
            tune_config=of_ray.TuneConfig(
                metric="worth",
                mode="max",
                num_samples=-1,
                search_alg=_searcher(asker, engine.jobs),
                scheduler=ASHAScheduler(
                    time_attr="steps", max_t=tries.steps, grace_period=tries.first, reduction_factor=_THIRD
                ),
            ),
            run_config=of_ray.RunConfig(
                storage_path=folder,
                verbose=0,
                stop=_stopper(asker),
                failure_config=of_ray.FailureConfig(max_failures=_AGAIN),
            ),
        ).fit()


def _searcher(asker: Asker, at_a_time: int | None) -> Any:
    from ray.tune.search import ConcurrencyLimiter, Searcher

    class OfAsker(Searcher):
        """What Tune asks for the next try, and tells of each."""

        def __init__(self) -> None:
            super().__init__(metric="worth", mode="max")
            self.numbers: dict[str, int] = {}

        def suggest(self, trial_id: str) -> Any:
            if asker.enough():
                return Searcher.FINISHED
            self.numbers[trial_id], drawn = asker.ask()
            return {"drawn": drawn}

        def on_trial_result(self, trial_id: str, result: dict[str, Any]) -> None:
            if _ERROR not in result:
                asker.told(self.numbers[trial_id], int(result["steps"]), float(result["worth"]))

        def on_trial_complete(self, trial_id: str, result: dict[str, Any] | None = None, error: bool = False) -> None:
            failed = (result or {}).get(_ERROR) or ("its worker was lost" if error else None)
            if failed is None and result is not None:
                self.on_trial_result(trial_id, result)
            asker.ended(self.numbers[trial_id], failed)

        def save(self, checkpoint_path: str) -> None:
            """Nothing: the study is kept by who asks."""

        def restore(self, checkpoint_path: str) -> None:
            """Nothing: the study is kept by who asks."""

    found = OfAsker()
    return found if at_a_time is None else ConcurrencyLimiter(found, max_concurrent=at_a_time)


def _stopper(asker: Asker) -> Any:
    from ray.tune import Stopper

    class WhenEnough(Stopper):
        """The end of all tries."""

        def __call__(self, trial_id: str, result: dict[str, Any]) -> bool:
            return False

        def stop_all(self) -> bool:
            return asker.enough()

    return WhenEnough()
