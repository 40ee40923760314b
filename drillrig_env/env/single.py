"""`DrillRig-v0` and `DrillRigSurface-v0` as a plain Gymnasium environment: the batch core with one rig."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, ClassVar

import gymnasium as gym
import numpy as np
import numpy.typing as npt
from gymnasium import spaces
from gymnasium.error import ResetNeeded

from drillrig_env.drive import DriveLike
from drillrig_env.env.core import EpisodeBatch
from drillrig_env.env.kernel import CONTROL_PERIOD, SLEW_LIMIT
from drillrig_env.env.reward import Reward
from drillrig_env.env.scenario import UNIFORMS, Scenario
from drillrig_env.env.sensors import LIMIT
from drillrig_env.rig import RigLike

if TYPE_CHECKING:
    from drillrig_env.env.rendering import RigPicture

_ACTION_SHAPE = (1,)


class DrillRigEnv(gym.Env[npt.NDArray[np.float32], npt.NDArray[np.float32]]):
    """## Description
    A drill string winds up like a spring: the bit sticks, breaks loose, races at twice its speed and
    sticks again. The environment is a laboratory rig that shows this stick-slip vibration: two discs
    on a thin shaft, a DC motor with a PI speed loop, and a brake pin whose dry friction stands for the
    rock. The physics is a validated 7-state model, solved exactly (error below 1e-6 rad/s over 20 s).
    The goal is to bring the bit to calm rotation at the operator's target speed by moving the drive's
    speed reference. The policy is told the target, never the normal force or the friction.

    One step is 0.1 s, an episode 60 s.

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

    ## Rewards
    With m and V the exponentially weighted mean and variance of the bit speed (time constant 2.5 s,
    updated 16 times within a step), w* the target and a the action,

        reward = - V / w*^2 - ((m - w*) / w*)^2 - 0.01 a^2.

    Calm rotation at the target scores 0, doing nothing in stick-slip about -0.6 a step. Weights, time
    constant and the shapes of the first two terms are fields of `Reward`.

    ## Starting State
    Drawn from the scenario, by default: the target from 1 to 5 rad/s; the normal force N_1 from 5 to
    30 N; mu_s, mu_k and v_b within 20 % of the chapter's values; the start in developed stick-slip
    where these parameters have it (70 %), in steady rotation (20 %) or at rest (10 %). In half of the
    episodes N_1 steps to a new draw at a uniform time (at the first control step from then on).
    Everything comes from the environment's own generator: a seed fixes an episode bit for bit.

    `reset(options={...})` pins any of `normal_force` (N), `mu_s`, `mu_k`, `v_b` (s/rad),
    `speed_target` (rad/s), `start` ("stick_slip", "steady", "rest") and `load_steps`, a list of
    (time in s, N_1 in N).

    ## Episode End
    Never terminated; truncated after 60 s. Another `step` needs a `reset` first.

    ## Info
    Every step: `bit_speed`, `top_speed`, `speed_reference`, `speed_target` (rad/s), `normal_force` (N),
    `torque_into_string` (N m), `mu_s`, `mu_k`, `v_b`, `delay` (control steps), and `reward_terms`, a
    dictionary of the terms `variance`, `tracking`, `action`. The last step adds `is_success`: whether the
    last 10 s were calm (max - min of the bit speed below 0.2 of its mean) with a mean within 5 % of the
    target. A reset also reports `start`, how the episode really began.

    ## Arguments
    | Name | Default | Meaning |
    |---|---|---|
    | `rig` | `Rig()` | the rig: a `Rig`, a dictionary of changes to the chapter's, or the path of a TOML file |
    | `scenario` | `"default"` | `"nominal"` (10 N), `"default"`, `"wide"`, a `Scenario` or a dictionary of its fields |
    | `sensors` | by id | `"state"`, `"encoders"`, `"surface"`, or names of channels |
    | `noise` | by sensors | 0 for none, 1 for the standard noise, or deviations by channel |
    | `delay` | by sensors | control steps by which measurements come late, or a range (low, high) |
    | `reward` | `Reward()` | weights and shape of the reward, or a dictionary of its fields |
    | `slew_limit` | `2.0` | largest rate of the speed reference, rad/s^2 |
    | `drive` | the rig's | `Drive(k_p, k_i, back_emf_share)`, a dictionary of its fields, or these numbers alone |
    | `duration` | `60.0` | length of an episode, s |
    | `render_mode` | `None` | `"rgb_array"` or `"human"`, a window; both need the extra `render` |

    `gym.make_vec("DrillRig-v0", num_envs=N)` steps N rigs in one compiled call.

    ## Version History
    * v0: initial version
    """

    metadata: ClassVar[dict[str, Any]] = {  # type: ignore[misc]
        "render_modes": ["rgb_array", "human"],
        "render_fps": round(1.0 / CONTROL_PERIOD),
    }

    def __init__(
        self,
        rig: RigLike = None,
        scenario: str | Mapping[str, Any] | Scenario = "default",
        sensors: str | Sequence[str] = "state",
        reward: Reward | Mapping[str, Any] | None = None,
        slew_limit: float = SLEW_LIMIT,
        duration: float = 60.0,
        render_mode: str | None = None,
        *,
        noise: float | Mapping[str, float] | None = None,
        delay: int | tuple[int, int] | None = None,
        drive: DriveLike = None,
    ) -> None:
        if render_mode not in (None, *self.metadata["render_modes"]):
            allowed = ", ".join(self.metadata["render_modes"])
            raise ValueError(f"render_mode = {render_mode!r} is not known; allowed: None, {allowed}")
        self.core = EpisodeBatch(
            1,
            rig,
            scenario,
            sensors,
            reward,
            slew_limit,
            duration,
            threads=1,
            noise=noise,
            delay=delay,
            drive=drive,
        )
        self.sensors = self.core.sensors
        self.render_mode = render_mode
        self.action_space = spaces.Box(-1.0, 1.0, _ACTION_SHAPE, np.float32)
        self.observation_space = spaces.Box(-LIMIT, LIMIT, (len(self.sensors.channels),), np.float32)
        self._steps = self.core.steps
        self._action = np.zeros((1, 1), dtype=np.float32)
        seen = np.zeros((1, len(self.sensors.channels)), dtype=np.float32)
        self._advance, self._seen = self.core.bound_step(self._action, seen), seen[0]
        record = self.core.episodes[0]
        self._numbers, self._counts = (_view(record, *names) for names in (("state", "terms"), ("step", "delay")))
        self._picture = None if render_mode is None else self._make_picture(record)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[npt.NDArray[np.float32], dict[str, Any]]:
        """Begin an episode; `options` pins what would be drawn (see the class)."""
        super().reset(seed=seed)
        only = np.zeros(1, dtype=np.intp)
        self.core.reset(only, self.np_random.random((1, UNIFORMS)), options)
        if self._picture is not None:
            self._picture.begin()
        _, info = self._reward_and_info()
        return self.core.observations[0], {**info, "start": self.core.starts(only)[0]}

    def step(
        self, action: npt.NDArray[np.float32]
    ) -> tuple[npt.NDArray[np.float32], float, bool, bool, dict[str, Any]]:
        """Move the speed reference for 0.1 s; `action` of shape (1,)."""
        rate = np.asarray(action)
        if rate.shape != _ACTION_SHAPE:
            raise ValueError(f"action of shape {rate.shape} is not allowed; allowed: shape {_ACTION_SHAPE}, -1 to 1")
        self._action[0, 0] = value = rate.item()
        if value != value:
            raise ValueError(f"action = {rate} is not allowed; allowed: a number from -1 to 1")
        if self._counts.item(0) >= self._steps:
            raise ResetNeeded(f"the episode of {self._steps} steps is over, or none has begun; call reset() first")
        self._advance()
        if self._picture is not None:
            self._picture.follow()
        reward, info = self._reward_and_info()
        truncated = self._counts.item(0) >= self._steps
        if truncated:
            info["is_success"] = bool(self.core.mitigated[0])
        return self._seen.copy(), reward, False, truncated, info

    def render(self) -> npt.NDArray[np.uint8] | None:
        """The rig as RGB of shape (540, 960, 3) in the mode "rgb_array"; otherwise None.

        In the mode "human" `reset` and `step` show the rig by themselves. Raises `ResetNeeded` before
        the first episode.
        """
        if self._picture is None:
            gym.logger.warn(
                "render() does nothing without a render_mode; name one when the environment is made, "
                'for example gym.make("DrillRig-v0", render_mode="rgb_array")'
            )
            return None
        if not self._picture.began:
            raise ResetNeeded("there is no episode to draw yet; call reset() first")
        if self.render_mode == "rgb_array":
            return self._picture.frame()
        self._picture.show()
        return None

    def close(self) -> None:
        """Close the window of the mode "human"."""
        if self._picture is not None:
            self._picture.close()

    def _make_picture(self, record: np.void) -> RigPicture:
        from drillrig_env.env.rendering import RigPicture

        return RigPicture(self.core.rig, record, self.render_mode == "human", self.metadata["render_fps"])

    def _reward_and_info(self) -> tuple[float, dict[str, Any]]:
        _, _, bit, _, top, _, _, _, reference, target, force, mu_s, mu_k, v_b, torque, reward, *terms = (
            self._numbers.tolist()
        )
        return reward, {
            "bit_speed": bit,
            "top_speed": top,
            "speed_reference": reference,
            "speed_target": target,
            "normal_force": force,
            "mu_s": mu_s,
            "mu_k": mu_k,
            "v_b": v_b,
            "torque_into_string": torque,
            "delay": self._counts.item(1),
            "reward_terms": {"variance": terms[0], "tracking": terms[1], "action": terms[2]},
        }


def _view(record: np.void, first: str, last: str) -> np.ndarray:
    """The numbers from one field of a rig's record to another, as an array that follows the record as it changes."""
    fields: Any = record.dtype.fields
    begin, (dtype, end) = fields[first][1], fields[last][:2]
    return np.ndarray((end + dtype.itemsize - begin) // 8, dtype.base, buffer=record.data, offset=begin)
