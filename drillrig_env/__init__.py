"""DrillRig: stick-slip of a drill string, simulated exactly, analysed, and met by controllers and agents.

>>> import drillrig_env
>>> run = drillrig_env.simulate(speed_reference=2.0, duration=60)  # a rig from rest into stick-slip
>>> round(float(drillrig_env.stability.critical_speed(drillrig_env.Rig(), drillrig_env.Friction(20.0))), 2)
2.69

>>> import gymnasium as gym
>>> env = gym.make("DrillRig-v0")
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from drillrig_env.starting import imports_begin, is_command

if is_command():
    imports_begin()

# isort: split
from drillrig_env.env.registration import ENVIRONMENTS, register_envs
from drillrig_env.lazy import loaded_when_used
from drillrig_env.moved import keep_former_names

if TYPE_CHECKING:
    from drillrig_env import stability
    from drillrig_env.course import Course
    from drillrig_env.drive import Drive
    from drillrig_env.env.reward import Reward
    from drillrig_env.env.reward_terms import RewardTerms
    from drillrig_env.env.sb3 import DrillRigVecEnv
    from drillrig_env.env.scenario import STARTS, Scenario
    from drillrig_env.env.sensors import observation_table
    from drillrig_env.env.task import Task
    from drillrig_env.env.wandering import Wandering
    from drillrig_env.evaluation.evaluate import evaluate
    from drillrig_env.friction import Friction
    from drillrig_env.friction.own import Law
    from drillrig_env.friction.tilt import Tilt
    from drillrig_env.rig import Rig
    from drillrig_env.simulation import Simulation, simulate
    from drillrig_env.stepper.batch import simulate_batch

__version__ = "0.2.0"

__all__ = [
    "ENVIRONMENTS",
    "STARTS",
    "Course",
    "Drive",
    "Fleet",
    "Friction",
    "Law",
    "Reward",
    "RewardTerms",
    "Rig",
    "Scenario",
    "Simulation",
    "Task",
    "Tilt",
    "Wandering",
    "evaluate",
    "make_sb3",
    "observation_table",
    "policy",
    "register_envs",
    "simulate",
    "simulate_batch",
    "stability",
]

_PLACES = {
    "Course": "drillrig_env.course",
    "Drive": "drillrig_env.drive",
    "Fleet": "drillrig_env.fleet",
    "Friction": "drillrig_env.friction",
    "Law": "drillrig_env.friction.own",
    "Reward": "drillrig_env.env.reward",
    "RewardTerms": "drillrig_env.env.reward_terms",
    "Rig": "drillrig_env.rig",
    "STARTS": "drillrig_env.env.scenario",
    "Scenario": "drillrig_env.env.scenario",
    "Simulation": "drillrig_env.simulation",
    "Task": "drillrig_env.env.task",
    "Tilt": "drillrig_env.friction.tilt",
    "Wandering": "drillrig_env.env.wandering",
    "evaluate": "drillrig_env.evaluation.evaluate",
    "observation_table": "drillrig_env.env.sensors",
    "policy": "drillrig_env.policy",
    "simulate": "drillrig_env.simulation",
    "simulate_batch": "drillrig_env.stepper.batch",
    "stability": "drillrig_env.stability",
}
"""Where public names come from; each is loaded when it is first used."""


__getattr__, __dir__ = loaded_when_used(__name__, _PLACES)


def make_sb3(num_envs: int = 1, seed: int | None = None, env_id: str = "DrillRig-v0", **kwargs: Any) -> DrillRigVecEnv:
    """A Stable-Baselines3 `VecEnv` of `num_envs` rigs of an environment; `kwargs` as for the environment.

    `seed` is that of the first rig, and the rig i has `seed` + i; `env_id` is a key of `ENVIRONMENTS`.

    >>> from stable_baselines3 import PPO
    >>> model = PPO("MlpPolicy", make_sb3(64, seed=0))

    Raises `ValueError` for an unknown environment. Needs the extra `agents`; without it, an
    `ImportError` that says what to install.
    """
    from drillrig_env.parameters import closest

    if env_id not in ENVIRONMENTS:
        raise ValueError(f"environment {env_id!r} is not known; {closest(env_id, ENVIRONMENTS)}")
    from drillrig_env.env.sb3 import DrillRigVecEnv

    return DrillRigVecEnv(num_envs, seed=seed, **{**ENVIRONMENTS[env_id], **kwargs})


register_envs()
keep_former_names(
    {
        "drillrig_env.batch": "drillrig_env.stepper.batch",
        "drillrig_env.stick_slip": "drillrig_env.verdict",
        "drillrig_env.animation": "drillrig_env.plots.animation",
        "drillrig_env.measured": "drillrig_env.calibrate.measured",
        "drillrig_env.figures": "drillrig_env.plots.figures",
        "drillrig_env.figures.__main__": "drillrig_env.plots.__main__",
    }
)
