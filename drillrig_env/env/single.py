"""`DrillRig-v0` and `DrillRigSurface-v0` as a plain Gymnasium environment: the batch core with one rig.

>>> import numpy as np
>>> from drillrig_env.env.single import DrillRigEnv
>>> env = DrillRigEnv(scenario="nominal", duration=2.0)  # gym.make("drillrig_env:DrillRig-v0", ...) wraps it
>>> observation, info = env.reset(seed=0, options={"normal_force": 20.0, "speed_target": 3.0})
>>> observation, reward, terminated, truncated, info = env.step(np.zeros(1, dtype=np.float32))
>>> observation.shape, round(float(info["speed_target"]), 1)
((12,), 3.0)
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium import spaces
from gymnasium.error import ResetNeeded

from drillrig_env.env.generators import check_seed
from drillrig_env.env.info import REWARD, STEP, next_info
from drillrig_env.env.one import OneRig
from drillrig_env.env.privileged import Seen, observation_space, seen_by
from drillrig_env.env.scenario import UNIFORMS
from drillrig_env.env.task import TaskLike

_ACTION_SHAPE = (1,)
_ONLY = np.zeros(1, dtype=np.intp)


class DrillRigEnv(OneRig):
    """## Description
    A drill string winds up like a spring: the bit sticks, breaks loose, races at twice its speed and
    sticks again. The environment is a laboratory rig that shows this stick-slip vibration: two discs
    on a thin shaft, a DC motor with a PI speed loop, and a brake pin whose dry friction stands for the
    rock. The physics is a validated 7-state model, solved exactly (error below 1e-6 rad/s over 20 s).
    The goal is to bring the bit to calm rotation at the operator's target speed by moving the drive's
    speed reference. The policy is told the target, never the normal force or the friction.

    One step is 0.1 s, an episode 60 s. This and every other number with a unit is that of the chapter's rig; on
    another rig they grow with its scales of time, speed and torque (see `Task.for_rig`).

    ## Action Space
    `Box(-1, 1, (1,), float32)`: the rate of change of the speed reference, as a fraction of the slew
    limit. Values beyond +-1 are clipped; NaN and other shapes are refused with a `ValueError`.

    | Num | Action | Min | Max | Unit |
    |---|---|---|---|---|
    | 0 | rate of the speed reference | -1 | 1 | slew limit, 2 rad/s^2 |

    The speed reference stays within 0 and 10 rad/s and is held constant over a step.

    ## Observation Space
    `Box(-10, 10, (n,), float32)` with n channels. Each is (value - offset) / scale, clipped to +-10; the
    offset "target" is the speed target. `env.unwrapped.sensors.value(observation, name)` gives the
    physical value back, and `drillrig_env.observation_table(sensors)` prints these tables.

    `DrillRig-v0` has `sensors="state"`, everything there is, without noise or delay:

    | Num | Channel | Unit | Offset | Scale | Noise |
    |---|---|---|---|---|---|
    | 0 | `twist_12`, shaft twist between disc 1 (bit) and disc 2 (collars) | rad | -0.3 | 0.3 | 0 |
    | 1 | `twist_23`, shaft twist between disc 2 and the motor's output | rad | -1.0 | 1.0 | 0 |
    | 2 | `bit_speed`, speed of disc 1, the bit | rad/s | target | 2.0 | 0 |
    | 3 | `collar_speed`, speed of disc 2, the collars | rad/s | target | 2.0 | 0 |
    | 4 | `top_speed`, speed of the motor's output | rad/s | target | 2.0 | 0 |
    | 5 | `current`, armature current | A | 1.3 | 0.5 | 0 |
    | 6 | `speed_error_integral`, integral of speed reference less top speed | rad | 2.1 | 1.0 | 0 |
    | 7 | `speed_reference`, speed reference omega_ref | rad/s | target | 1.0 | 0 |
    | 8 | `speed_target`, what the operator wants, omega* | rad/s | 3.0 | 2.0 | 0 |
    | 9 | `bit_speed_mean`, running mean of the bit speed | rad/s | target | 1.0 | 0 |
    | 10 | `bit_speed_deviation`, running standard deviation of the bit speed | rad/s | 1.0 | 1.0 | 0 |
    | 11 | `string_torque_mean`, running mean of the torque into the string | N m | 0.3 | 0.2 | 0 |

    `DrillRigSurface-v0` has `sensors="surface"`, what a drilling rig measures, with the noise of the table
    (standard deviation, in the channel's unit), one control step late:

    | Num | Channel | Unit | Offset | Scale | Noise |
    |---|---|---|---|---|---|
    | 0 | `top_speed`, speed of the motor's output | rad/s | target | 2.0 | 0.02 |
    | 1 | `current`, armature current | A | 1.3 | 0.5 | 0.02 |
    | 2 | `voltage`, armature voltage, from the speed loop | V | 2.0 | 1.0 | 0.05 |
    | 3 | `string_torque`, torque into the string, as the drive estimates it | N m | 0.3 | 0.3 | 0.02 |
    | 4 | `string_torque_mean`, running mean of the torque into the string | N m | 0.3 | 0.2 | 0.002 |
    | 5 | `string_torque_deviation`, running deviation of that torque | N m | 0.2 | 0.2 | 0.002 |
    | 6 | `speed_reference`, speed reference omega_ref | rad/s | target | 1.0 | 0 |
    | 7 | `speed_target`, what the operator wants, omega* | rad/s | 3.0 | 2.0 | 0 |

    `sensors="encoders"` are the three speeds of the laboratory rig, reference and target; a tuple of channel
    names is a set of one's own. `noise` multiplies the standard noise of the channels, or gives standard
    deviations by name. `delay` is in control steps; a range (low, high) is drawn episode by episode.
    The reference and the target are the controller's own: never noisy, never late.

    With `privileged=True` an observation is a dictionary: "policy" is the array above, and "privileged" an exact one
    for a critic, with the channels of `sensors="state"`, normal force, friction and delay of the episode, and by how
    much a fleet's rig differs from the nominal one; `env.unwrapped.privileged_channels` has its names.

    ## Rewards
    With m and V the exponentially weighted mean and variance of the bit speed (time constant 2.5 s,
    updated 16 times within a step), w* the target and a the action,

        reward = - V / w*^2 - ((m - w*) / w*)^2 - 0.01 a^2.

    Calm rotation at the target scores 0, doing nothing in stick-slip about -0.6 a step. Weights, time
    constant and the shapes of the first two terms are fields of `Reward`; `RewardTerms` are terms of one's own.

    ## Starting State
    Drawn from the scenario, by default: the target from 1 to 5 rad/s; the normal force N_1 from 5 to
    30 N; mu_s, mu_k and v_b within 20 % of the chapter's values; the start in developed stick-slip
    where these parameters have it (70 %), in steady rotation (20 %) or at rest (10 %). In half of the
    episodes N_1 steps to a new draw at a uniform time (at the first control step from then on).
    Everything comes from the environment's own generator: a seed fixes an episode bit for bit.

    Each episode may have another rig: `Scenario(rigs=Fleet.around(spread={"string": 2.0, "motor": 1.1}))` draws one of
    256. Sensors, drive and what a controller is told are those of the nominal rig, `rig`.

    `reset(options={...})` pins any of `normal_force` (N), `mu_s`, `mu_k`, `v_b` (s/rad),
    `speed_target` (rad/s), `start` ("stick_slip", "steady", "rest"), `load_steps`, a list of
    (time in s, N_1 in N), and `rig`, the index of a rig of the fleet or any `Rig`. `state`, the 7 numbers of
    `drillrig_env.model`, is where an episode begins (`start` is then "given"), and beside it `speed_reference`
    (rad/s) the reference with which it does, in place of the target.

    ## Episode End
    Never terminated; truncated after 60 s. Another `step` needs a `reset` first.

    ## Info
    The same names with the same dtypes at every reset and step, NumPy scalars in the single environment and arrays of
    shape (num_envs,) in the vector environment:

    | Name | Unit | Meaning |
    |---|---|---|
    | `bit_speed`, `top_speed`, `speed_reference`, `speed_target` | rad/s | at the end of the step |
    | `normal_force` | N | N_1 of the pin during the step |
    | `mu_s`, `mu_k`, `v_b` | 1, 1, s/rad | friction during the step |
    | `torque_into_string` | N m | at the end of the step |
    | `reward_variance`, `reward_tracking`, `reward_action` | | the terms of the reward, which is their sum |
    | `reward_NAME` | | each term of the user's own, where there are any |
    | `delay` | control steps | by which measurements come late in the episode |
    | `start` | | how the episode really began, an index into `drillrig_env.STARTS` |
    | `rig` | | which rig of the fleet the episode has; 0 without a fleet |
    | `is_success` | | True at the last step of an episode that ends calm at the target |

    Calm at the target: over the last 10 s, max - min of the bit speed below 0.2 of its mean, and a mean within 5 %
    of the target. An episode that a wrapper cuts short is not judged; `duration`, and `max_episode_steps` of the
    vector environment, give shorter ones that are, by all there is of their last 10 s.

    ## Arguments
    Fields of a `Task`, which may be given as `task`, by their names, or both:

    | Name | Default | Unit | Meaning | Allowed |
    |---|---|---|---|---|
    | `rig` | `Rig()` | | the rig | a `Rig`, a dictionary of changes to the chapter's, or a TOML file |
    | `scenario` | `"default"` | | what an episode draws | `"nominal"`, `"default"`, `"wide"`, `"drift"`, a `Scenario` |
    | `sensors` | by id | | what is seen | `"state"`, `"encoders"`, `"surface"`, or names of channels |
    | `noise` | by sensors | | noise of the measurements | 0 for none, 1 for the standard, or deviations by channel |
    | `delay` | by sensors | control steps | by which measurements come late | 0 to 10, or a range (low, high), drawn |
    | `reward` | `Reward()` | | what is rewarded | `"phases"`, a `Reward`, changes to the default, or `RewardTerms` |
    | `slew_limit` | 2.0, by rig | rad/s^2 | largest rate of the speed reference | > 0 and <= 1000, by rig |
    | `largest_reference` | 10.0, by rig | rad/s | upper end of the speed reference, the scale of all speeds | > 0 |
    | `control_period` | 0.1, by rig | s | length of a control step | 1/200 to 1/5 of the rig's slowest period |
    | `drive` | the rig's | | the drive's speed loop | `Drive(k_p, k_i, back_emf_share)`, or its fields |
    | `privileged` | `False` | | whether a critic's part is observed, apart from the policy's | True or False |
    | `duration` | 60.0, by rig | s | length of an episode | a multiple of 0.1, at most 100000, by rig |

    Besides, `render_mode` is `"rgb_array"` or `"human"`, a window; both need the extra `render`.
    `gym.make_vec("DrillRig-v0", num_envs=N)` steps N rigs in one compiled call.

    `scenario`, `reward` and `slew_limit` can be given anew while the environment lives, for a curriculum: as
    attributes of `env.unwrapped`, by `env.set_wrapper_attr`, `set_attr` of vector environments, or the method
    `change(scenario=..., ...)`. Reward and slew limit hold from the next step on, the scenario from the next
    episode on. Setting any other of the fields raises an `AttributeError`.

    ## Copies and states
    `copy.deepcopy` and `pickle` give an environment that goes on bit for bit like this one, and apart from it; a copy
    of one that shows a window shows none. `get_state()` and `set_state(state)` do the same within one environment or
    between several of the same task, at less cost: for search and planning.

    ## Version History
    * v0: initial version. Since 0.2.0 infos are flat: `reward_variance`, `reward_tracking` and `reward_action` in
      place of `reward_terms`, and `start` (a number now) and `is_success` in every info; `drive_gains` is now
      `drive`; arguments are given by name.
    """

    def __init__(self, task: TaskLike = None, *, render_mode: str | None = None, **fields: Any) -> None:
        super().__init__(task, render_mode, fields)
        self.action_space = spaces.Box(-1.0, 1.0, _ACTION_SHAPE, np.float32)
        self.observation_space = observation_space(len(self.sensors.channels), self.core.critic)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Seen, dict[str, Any]]:
        """Begin an episode; `options` pins what would be drawn (see the class)."""
        super().reset(seed=check_seed(seed))
        uniforms = self.np_random.random((1, UNIFORMS))
        self.core.seeds = (self._np_random_seed,)
        self.core.reset(_ONLY, uniforms, options)
        self._follow()
        self._seen[:] = self.core.observations[0]
        if self._picture is not None:
            self._picture.begin()
        self._keep_info()
        return seen_by(self.core.seen, 0), next_info(self._info, self._numbers, self._own)

    def step(self, action: npt.NDArray[np.float32]) -> tuple[Seen, float, bool, bool, dict[str, Any]]:
        """Move the speed reference for 0.1 s; `action` of shape (1,)."""
        rate = np.asarray(action)
        if rate.shape != _ACTION_SHAPE:
            raise ValueError(f"action of shape {rate.shape} is not allowed; allowed: shape {_ACTION_SHAPE}, -1 to 1")
        value = rate.item()
        if (type(value) is not float and type(value) is not int) or value != value:
            raise ValueError(f"action = {rate} is not allowed; allowed: a number from -1 to 1")
        self._action[0, 0] = value
        if self._counts.item(STEP) >= self._steps:
            raise ResetNeeded(f"the episode of {self._steps} steps is over, or none has begun; call reset() first")
        if self._advance():
            self.core.refuse_lost()
        if self._picture is not None:
            self._picture.follow()
        info = next_info(self._info, self._numbers, self._own)
        truncated = self._counts.item(STEP) >= self._steps
        if truncated:
            info["is_success"] = self.core.mitigated[0, ...]
        seen = self._seen.copy() if self._show is None else self._seen_by_both()
        return seen, self._numbers.item(REWARD), False, truncated, info
