"""The simulated rig is the environment's, in parts of a control step."""

import numpy as np
import pytest

from drillrig_env.env.core import EpisodeBatch
from drillrig_env.env.generators import first_uniforms
from drillrig_env.env.sensors import SENSORS
from drillrig_env.rig import Rig
from drillrig_env.seeds import VALIDATION_SEEDS
from drillrig_env.twin.rig import PARTS, SimulatedRig

SEED = VALIDATION_SEEDS.start + 11
FAST = Rig(J_1=Rig().J_1 / 4.0, J_2=Rig().J_2 / 4.0, J_3=Rig().J_3 / 4.0)


def both(options, rig=None, sensors="state", **settings):
    """A simulated rig, and an episode of the environment with the same draws."""
    core = EpisodeBatch(1, rig=rig, sensors=sensors, noise=0.0, delay=0)
    core.reset(np.arange(1), first_uniforms(SEED, 1), options)
    return SimulatedRig(SEED, sensors, noise=0.0, delay=0, options=options, rig=rig, **settings), core


def control_step(rig, core, action):
    """The same control step of both."""
    core.step(np.full((1, 1), action, np.float32))
    rig.reference = core.episodes["speed_reference"][0]
    for _ in range(PARTS):
        rig.advance()


@pytest.mark.parametrize("chosen", [None, FAST])
def test_it_moves_and_measures_as_the_environment(chosen):
    rig, core = both({"start": "steady", "load_steps": [(5.999, 25.0)]}, chosen)
    assert rig.reference == core.episodes["speed_reference"][0]
    for step in range(300):
        control_step(rig, core, np.sin(0.3 * step))
        state, episode = rig.core.episodes["state"][0], core.episodes[0]
        np.testing.assert_allclose(state[:7], episode["state"][:7], rtol=1e-5, atol=1e-5)
        shown = rig.measure()
        assert shown["string_torque"] == pytest.approx(episode["string_torque"], abs=5e-3)  # a mean of other samples
        assert shown["bit_speed"][-1] == pytest.approx(episode["state"][2], abs=1e-5)
        assert len(shown["bit_speed"]) == PARTS
    assert rig.time == pytest.approx(300 * rig.period)
    assert rig.period == core.control_period
    assert core.episodes["normal_force"] == rig.core.episodes["normal_force"] == 25.0


def test_load_steps_come_when_the_environment_has_them():
    rig, core = both({"start": "steady"})
    assert np.isfinite(core.episodes["load_times"][0, 0])
    np.testing.assert_allclose(rig.core.episodes["load_times"], core.episodes["load_times"])


@pytest.mark.parametrize("options", [{"start": "steady", "load_steps": []}, {"start": "stick_slip"}])
def test_the_verdict_is_the_environments(options):
    rig, core = both({**options, "normal_force": 8.0 if options["start"] == "steady" else 25.0, "speed_target": 3.0})
    assert not rig.is_mitigated  # before anything has been seen
    for _ in range(core.steps):
        control_step(rig, core, 0.0)
    assert rig.is_mitigated == core.mitigated[0] == (options["start"] == "steady")
    assert not rig.is_over


def test_its_instruments_are_as_noisy_and_as_late_as_the_environments():
    rig = SimulatedRig(SEED, options={"start": "steady", "load_steps": []})
    for _ in range(100):
        rig.advance()
    shown = {name: [] for name in rig.channels}
    for _ in range(400):
        for _ in range(PARTS):
            rig.advance()
        for name, value in rig.measure().items():
            shown[name].append(value)
    standard = {channel.name: channel.noise for channel in SENSORS["surface"].channels}
    for name, values in shown.items():
        assert np.std(values) == pytest.approx(standard[name], rel=0.15)
    late, exact = (SimulatedRig(SEED, noise=0.0, delay=delay, options={"start": "stick_slip"}) for delay in (2, 0))
    seen = []
    for step in range(30):
        for rig in (late, exact):
            for _ in range(PARTS):
                rig.advance()
        seen.append(exact.measure())
        if step >= 2:
            assert late.measure() == pytest.approx(seen[step - 2], abs=1e-6)


def test_what_it_cannot_be_is_named():
    with pytest.raises(ValueError, match="delay = 3 control steps is not allowed; allowed: whole, >= 0 and <= 2"):
        SimulatedRig(SEED, delay=3)
    with pytest.raises(ValueError, match="unknown key 'speed'"):
        SimulatedRig(SEED, options={"speed": 1.0})
