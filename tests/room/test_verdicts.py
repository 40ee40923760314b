"""The running verdict, against the scores of the same episode."""

import numpy as np
import pytest

from drillrig_env.env.task import Task
from drillrig_env.evaluation.runner import Episodes
from drillrig_env.evaluation.scores import score
from drillrig_env.friction import Friction
from drillrig_env.rig import Rig
from drillrig_env.room.lanes import Lanes
from drillrig_env.room.setting import Setting
from drillrig_env.room.verdicts import RunningVerdict


@pytest.mark.parametrize("policy", ["constant", "soft_torque"])
def test_at_the_end_of_an_episode_it_is_the_score(stock, policy):
    lanes = Lanes(Setting(a=policy, b="constant"), stock)
    lane, traces = lanes.lane("A"), []
    for _ in range(600):
        lanes.step()
        episode = lane.core.episodes[0]
        traces.append([float(episode[name]) for name in ("lowest", "highest", "average", "stuck")])
    low, high, mean, stuck = np.array(traces).T[:, None]
    nothing = np.zeros_like(low)
    episodes = Episodes(
        Task(), np.array([2.5]), Friction(), np.array(["stick_slip"]), low, high, mean, stuck,
        nothing, nothing, nothing, nothing, nothing, (Rig(),), np.zeros(1, int), 0.1,
    )  # fmt: skip
    scores, verdict = score(episodes), lane.verdict.now(2.5)
    assert verdict.full
    assert verdict.index == pytest.approx(float(scores["ssi"][0]), rel=1e-12)
    assert (verdict.calm, verdict.mitigated) == (bool(scores["calm"][0]), bool(scores["mitigated"][0]))
    since = 60.0 if verdict.calm_since is None else verdict.calm_since
    assert since == pytest.approx(float(scores["time_to_calm"][0]))
    assert verdict.stuck == pytest.approx(float(stuck[0, -100:].mean()))


def test_there_is_no_verdict_before_the_window_is_full():
    verdict = RunningVerdict(Task())
    for step in range(100):
        assert not verdict.now(2.0).full
        assert not verdict.now(2.0).calm
        verdict.add(2.0, 2.0, 2.0, 0.0)
        assert (verdict.now(2.0).calm_since is not None) == (step >= 49)
    assert verdict.now(2.0).mitigated
    assert verdict.now(2.2).calm
    assert not verdict.now(2.2).mitigated
    assert verdict.now(2.0).calm_since == 5.0
    verdict.add(0.0, 4.0, 2.0, 0.5)
    assert verdict.now(2.0).calm_since is None
