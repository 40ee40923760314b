"""One episode of the chapter's rig under a policy, for tests of what policies do."""

import gymnasium as gym
import numpy as np

import drillrig_env  # noqa: F401  (registers the environments)

BISTABLE = {"normal_force": 20.0, "speed_target": 3.2, "start": "stick_slip"}
"""Above the critical speed of 2.688 rad/s at 20 N and below the fold of 4.79 rad/s."""

UNSTABLE = {"normal_force": 20.0, "speed_target": 2.2, "start": "stick_slip"}
"""Below the critical speed: steady rotation is unstable under the stiff drive."""

LOAD_STEP = {"normal_force": 5.0, "speed_target": 3.2, "start": "steady", "load_steps": [(10.0, 25.0)]}
"""Calm rotation at 5 N on which 25 N is put after 10 s; the stiff drive falls into stick-slip."""


def play(policy, options, seed=0, **arguments):
    """Info at the end of the episode, and the speed references on the way."""
    env = gym.make(
        "DrillRig-v0",
        scenario="nominal",
        sensors=policy.sensors,
        drive=policy.drive,
        **arguments,
    )
    observation, info = env.reset(seed=seed, options=options)
    state, start, references = None, np.array([True]), []
    while True:
        policy.tell(info)
        action, state = policy.predict(observation, state, start)
        start = np.array([False])
        observation, _, _, truncated, info = env.step(action)
        references.append(info["speed_reference"])
        if truncated:
            return info, np.array(references)
