"""Run a policy over a suite: every rig at once, and what each control step showed."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from drillrig_env.arrays import FloatArray
from drillrig_env.env.actions import check_actions
from drillrig_env.env.core import EpisodeBatch
from drillrig_env.env.generators import first_uniforms
from drillrig_env.env.task import Task
from drillrig_env.evaluation.suites import Suite
from drillrig_env.friction import Friction
from drillrig_env.model import STATE_NAMES
from drillrig_env.policy import Policy, channels_of, drive_of, is_exact, privileged_of
from drillrig_env.rig import Rig, RigLike
from drillrig_env.stepper.finite import NotFiniteError

_TRACES = ("lowest", "highest", "average", "stuck", "torque_into_string", "highest_torque", "speed_reference", "reward")
"""Fields of a rig's record that are kept for every control step."""


@dataclass(frozen=True, eq=False)
class Episodes:
    """What a policy did with a suite: a row a rig, a column a control step.

    `task` is what was played, `start` how each began, `place` which of `rigs` it had; `speed_target` is in rad/s. Of
    the columns, `torque_into_string` is at the end of a step and `highest_torque` within it, `speed_reference` and
    `top_speed` are at its end.

    Of each step: lowest, highest and average bit speed (rad/s), share of time stuck, string torque
    (N m, at its end and the highest within), speed reference and top speed (rad/s, at its end) and
    reward. `friction` is that of the episode's end. `rigs` are those of the fleet, or the one that all episodes share,
    and `calm_index` is the stick-slip index below which the suite takes them for calm.
    """

    task: Task
    speed_target: FloatArray  # rad/s, (n,)
    friction: Friction
    start: npt.NDArray[np.str_]  # (n,)
    lowest: FloatArray
    highest: FloatArray
    average: FloatArray
    stuck: FloatArray
    torque_into_string: FloatArray
    highest_torque: FloatArray
    speed_reference: FloatArray
    top_speed: FloatArray
    reward: FloatArray
    rigs: tuple[Rig, ...]
    place: npt.NDArray[np.intp]  # of each episode's rig in `rigs`, (n,)
    calm_index: float


def play(
    policy: Policy,
    core: EpisodeBatch,
    first_seed: int | None = None,
    taken: npt.NDArray[np.float32] | None = None,
    first_rig: int = 0,
) -> Iterator[int]:
    """Let a policy play the episodes that have begun in all rigs to their end; yields after each control step.

    `core` is the batch of these rigs.

    A policy that names in `privileged` what it must be told gets `info` before each step. Into `taken`, shape
    (steps, n, 1), go the actions of each step, where it is given. Raises `ValueError` for
    actions of another shape or such as are not finite, and `NotFiniteError` for a state that is not; both name
    policy, rig and step, and the rig's seed where rig i has the seed `first_seed` + i; the first rig's number is
    `first_rig`.

    >>> from drillrig_env.env.core import EpisodeBatch
    >>> from drillrig_env.policy import load
    >>> core = EpisodeBatch(3)
    >>> sum(1 for step in play(load("constant"), core)) == core.steps
    True
    """

    def place(finite: npt.NDArray[np.bool_]) -> str:
        rig = int(np.argmin(finite))
        seed = "" if first_seed is None else f" (seed {first_seed + rig})"
        return f"rig {first_rig + rig}{seed} in control step {step + 1}"

    told = privileged_of(policy)
    state, begins = None, np.ones(len(core), dtype=np.bool_)
    for step in range(core.steps):
        if told:
            policy.tell(core.info())  # type: ignore[attr-defined]
        actions, state = policy.predict(core.observations, state, begins, deterministic=True)
        begins = np.zeros(len(core), dtype=np.bool_)
        if np.shape(actions) == (len(core), 1) and np.asarray(actions).dtype.kind == "f":
            finite = np.isfinite(actions[:, 0])
            if not finite.all():
                raise ValueError(f"{type(policy).__name__}: the action for {place(finite)} is not finite")
        rates = check_actions(actions, len(core))
        if taken is not None:
            taken[step] = rates
        try:
            core.step(rates)
        except NotFiniteError as error:
            finite = np.isfinite(core.episodes["state"]).all(axis=1)
            raise NotFiniteError(f"{type(policy).__name__}, {place(finite)}: {error}") from error
        yield step


def run(
    policy: Policy,
    suite: Suite,
    *,
    rig: RigLike = None,
    sensors: str | tuple[str, ...] = "state",
    threads: int | None = None,
    progress: Callable[[int, int], None] | None = None,
    **env: Any,
) -> Episodes:
    """Let a policy face every rig of a suite, all at once, for one episode each.

    `rig`, `sensors` and `threads` are those of the environment.

    `progress` is called with the steps done and the steps in all. The environment is made with `env` (`reward`,
    `noise`, ...), then the suite's own arguments, which go first, and the policy's `drive`. An exact policy is shown
    its own channels without noise and delay.

    >>> from drillrig_env.evaluation.suites import suite
    >>> from drillrig_env.policy import load
    >>> episodes = run(load("lqg"), suite("default", rigs=5))
    >>> episodes.lowest.shape  # rigs, control steps
    (5, 600)
    """
    arguments = {**env, **suite.env, "drive": drive_of(policy)}
    if is_exact(policy):
        sensors, arguments = channels_of(policy) or (), {**arguments, "noise": 0.0, "delay": 0}
    core = EpisodeBatch(suite.rigs, rig=rig, scenario=suite.scenario, sensors=sensors, threads=threads, **arguments)
    uniforms = first_uniforms(suite.first_seed, suite.rigs)
    first = 0
    for count, options in suite.groups:
        core.reset(np.arange(first, first + count), uniforms[first : first + count], options)
        first += count
    start = np.array(core.starts(np.arange(suite.rigs)))
    traces = {name: np.empty((suite.rigs, core.steps)) for name in (*_TRACES, "top_speed")}
    for step in play(policy, core, suite.first_seed, first_rig=suite.first_rig):
        for name in _TRACES:
            traces[name][:, step] = core.episodes[name]
        traces["top_speed"][:, step] = core.episodes["state"][:, STATE_NAMES.index("top_speed")]
        if progress:
            progress(step + 1, core.steps)
    target, place = core.episodes["speed_target"].copy(), core.episodes["rig"].copy()
    rigs, index = core.bank.rigs, suite.calm_index
    return Episodes(core.task, target, core.friction, start, rigs=rigs, place=place, calm_index=index, **traces)
