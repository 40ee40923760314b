"""Trained agents as policies that are found by name: shipped ones, a run's folder, or a folder of training seeds."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from agents.policy.run_folder import find_run, is_run, load_policy, read_config, shipped
from drillrig_env.policy import PolicySource
from drillrig_env.rig import RigLike
from drillrig_env.scales import SLEW_LIMIT, Scales

if TYPE_CHECKING:
    from agents.policy.agent import Agent


def agent_names() -> list[str]:
    """The names of the agents that come with the project."""
    return shipped()


def find_agent(name: str) -> PolicySource | None:
    """A trained agent, or all seeds of one algorithm in a folder; None where the name is neither.

    `ValueError` where the runs in a folder are not the seeds of one algorithm, or one has left no model;
    `ImportError` where what agents need is not installed.
    """
    seeds = sorted(path for path in Path(name).glob("*") if is_run(path))
    if not is_run(name) and not seeds and name not in shipped():
        return None
    folders = seeds if seeds and not is_run(name) else [find_run(name)]
    configs = {str(read_config(folder)["seed"]): read_config(folder) for folder in folders}
    kinds = {(config["algorithm"], config["env_id"], str(config["env_kwargs"])) for config in configs.values()}
    if len(configs) < len(folders) or len(kinds) > 1:
        raise ValueError(
            f"the runs in {name} are not the seeds of one algorithm: {sorted(kinds)}, seeds {list(configs)}"
        )
    agents = {str(agent.config["seed"]): agent for agent in map(load_policy, folders)}
    makers = {seed: partial(at_slew_limit, agents[seed]) for seed in sorted(agents, key=int)}
    return PolicySource(name, makers, {"kind": "run", "configs": configs})


def at_slew_limit(
    agent: Agent, slew_limit: float | None = None, rig: RigLike = None, largest_reference: float | None = None
) -> Agent:
    """The agent for a task with a slew limit (rad/s^2), by default the standard one, in the scales of its rig."""
    scales = Scales.of(rig, largest_reference)
    return agent.at_slew_limit(SLEW_LIMIT * scales.rate if slew_limit is None else slew_limit, scales)
