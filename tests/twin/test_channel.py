"""Messages are lost and late as told, and by the seed."""

import numpy as np
import pytest

from drillrig_env.twin.channel import Channel, Wire


def through(wire, messages=4000, seed=1):
    """When each message arrived that was sent at its own number of seconds."""
    channel, found = Channel(wire, np.random.default_rng(seed)), {}
    for k in range(messages):
        channel.send(k, float(k))
        for part in range(10):
            found.update(dict.fromkeys(channel.arrived(k + 0.1 * part), k + 0.1 * part))
    return found


def test_a_perfect_wire_delivers_at_once_and_in_order():
    channel = Channel(Wire(), np.random.default_rng(0))
    for k in range(5):
        channel.send(k, 1.0)
    assert channel.waiting == 5
    assert channel.arrived(0.99) == []
    assert channel.arrived(1.0) == [0, 1, 2, 3, 4]
    assert channel.arrived(9.0) == []


def test_loss_latency_and_jitter_are_as_told():
    found = through(Wire(loss=0.1, latency=0.2, jitter=0.5))
    assert len(found) / 4000 == pytest.approx(0.9, abs=0.02)
    late = np.array([arrived - sent for sent, arrived in found.items()])
    assert late.min() >= 0.2 - 1e-9
    assert late.max() <= 0.8 + 1e-9
    assert np.mean(late) == pytest.approx(0.45 + 0.05, abs=0.01)  # looked for each 0.1 s
    assert found == through(Wire(loss=0.1, latency=0.2, jitter=0.5))
    assert found != through(Wire(loss=0.1, latency=0.2, jitter=0.5), seed=2)


def test_messages_may_overtake_each_other():
    channel = Channel(Wire(jitter=1.0), np.random.default_rng(0))
    for k in range(50):
        channel.send(k, 0.0)
    arrived = channel.arrived(1.0)
    assert sorted(arrived) == list(range(50)) != arrived


@pytest.mark.parametrize("wrong", [{"loss": 1.1}, {"loss": -0.1}, {"latency": -1.0}, {"jitter": float("nan")}])
def test_impossible_wires_are_refused(wrong):
    with pytest.raises(ValueError, match=f"Wire: {next(iter(wrong))} = .* is not allowed"):
        Wire(**wrong)
