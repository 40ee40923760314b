import numpy as np
import pytest

from drillrig_env.env.core import RigBatch
from drillrig_env.env.sensors import LIMIT, Sensors
from drillrig_env.model import STATE_NAMES


def test_observations_turn_back_into_physical_values_by_name():
    core = RigBatch(50)
    core.reset(np.arange(50), [np.random.default_rng(i) for i in range(50)])
    for _ in range(20):
        core.step(np.full((50, 1), 0.5, np.float32))
    values = core.sensors.values(core.observations)
    for column, name in enumerate(STATE_NAMES):
        np.testing.assert_allclose(values[name], core.rigs["state"][:, column], atol=1e-5)
    np.testing.assert_allclose(values["bit_speed_mean"], core.rigs["mean"], atol=1e-5)
    np.testing.assert_allclose(values["bit_speed_deviation"], np.sqrt(core.rigs["variance"]), atol=1e-5)
    assert set(values) == set(core.sensors.names)


def test_observations_are_about_one_on_the_default_draws():
    core = RigBatch(300)
    core.reset(np.arange(300), [np.random.default_rng(i) for i in range(300)])
    seen = []
    for _ in range(300):
        core.step(np.zeros((300, 1), np.float32))
        seen.append(core.observations)
    deviation = np.concatenate(seen).std(axis=0)
    assert np.all((deviation > 0.2) & (deviation < 2.0))
    assert np.abs(np.concatenate(seen)).max() < LIMIT


def test_unknown_names_are_refused():
    with pytest.raises(ValueError, match="did you mean bit_speed"):
        Sensors.named("state").value(np.zeros(11), "bitspeed")
    with pytest.raises(ValueError, match="allowed: state"):
        Sensors.named("radar")


def test_docstring_of_the_environment_lists_every_channel():
    from drillrig_env.env.single import DrillRigEnv

    for channel in Sensors.named("state").channels:
        row = next(line for line in DrillRigEnv.__doc__.splitlines() if f"`{channel.name}`" in line and "|" in line)
        cells = [cell.strip() for cell in row.split("|")]
        assert cells[3:6] == [channel.unit, f"{channel.offset}", f"{channel.scale}"]
