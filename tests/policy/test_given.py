"""What a policy is given and cannot act on is named in one sentence, by agents and controllers alike."""

import numpy as np
import pytest

from drillrig_env.policy import load

POLICIES = ["ppo", "sac_soft", "lqg", "z_torque"]  # with frames and without, with memory and without
CHANNELS = 12


def seen(rigs=3):
    return np.full((rigs, CHANNELS), 0.1, np.float32)


@pytest.mark.parametrize("name", POLICIES)
@pytest.mark.parametrize(
    ("observation", "words"),
    [
        (
            np.zeros((2, 5), np.float32),
            r"shape of an observation = \(2, 5\) .* allowed: \(12,\) or \(n, 12\): twist_12",
        ),
        (np.zeros((2, 8, CHANNELS), np.float32), r"shape of an observation = \(2, 8, 12\)"),
        (None, r"shape of an observation = \(\)"),
        (np.where(np.arange(CHANNELS) == 2, np.nan, seen(2)), "observation of bit_speed = nan .* finite"),
        (np.where(np.arange(CHANNELS) == 5, -np.inf, seen(1)[0]), "observation of current = -inf .* finite"),
        (np.full((2, CHANNELS), "a"), "kind of an observation = <U1"),
        (np.zeros((2, CHANNELS), complex), "kind of an observation = complex128"),
    ],
    ids=["width", "stacked", "nothing", "nan", "infinite", "text", "complex"],
)
def test_an_observation_that_is_none_is_refused_by_name(name, observation, words):
    with pytest.raises(ValueError, match=f"^{name}: {words}"):
        load(name).predict(observation)


@pytest.mark.parametrize("name", POLICIES)
def test_flags_and_memory_of_other_rigs_are_refused(name):
    policy = load(name)
    _, memory = policy.predict(seen())
    for flags in (True, [True, False], np.zeros(4, bool), np.zeros((3, 1), bool)):
        with pytest.raises(ValueError, match=rf"^{name}: shape of episode_start = \(.*; allowed: \(3,\), one a rig"):
            policy.predict(seen(), memory, flags)
    unclear = ((["yes", "no", "no"], "'yes'"), ([None] * 3, "None"), ([0.0, np.nan, 1.0], "nan"), ([0, 1, 2], "2"))
    for flags, told in unclear:
        with pytest.raises(ValueError, match=f"^{name}: episode_start = {told} .* allowed: true or false, one a rig"):
            policy.predict(seen(), memory, flags)
    if memory is not None:
        with pytest.raises(ValueError, match=rf"^{name}: shape of the state = \(3, \d+\) .* allowed: \(2, \d+\)"):
            policy.predict(seen(2), memory)


@pytest.mark.parametrize("name", ["ppo", "sac", "lqg", "z_torque"])
def test_what_no_predict_of_the_policy_returned_is_refused_as_its_state(name):
    policy = load(name)
    _, (own, *_) = policy.predict(seen())
    for other, told in (((), "tuple"), (7, "int"), (own, "ndarray"), ("memory", "str")):
        with pytest.raises(ValueError, match=f"^{name}: kind of the state = {told} .* what the last predict returned$"):
            policy.predict(seen(), other)
    for other in ((own[:, 1:],), (own[0],), (None,), load("speed_pulse").predict(seen())[1]):
        with pytest.raises(ValueError, match=rf"^{name}: shape of the state = .*; allowed: \(3, {own.shape[1]}\), as"):
            policy.predict(seen(), other)


@pytest.mark.parametrize("name", POLICIES)
def test_lists_and_no_rigs_at_all_are_taken(name):
    policy = load(name)
    actions, memory = policy.predict(seen())
    listed, _ = policy.predict(seen().tolist(), memory, [True, True, True])
    np.testing.assert_allclose(listed, actions, atol=1e-6)
    assert policy.predict(seen(0))[0].shape == (0, 1)
    assert policy.predict(seen(1)[0], None, True)[0].shape == (1,)


def test_a_network_with_a_memory_refuses_half_of_it_and_what_is_no_number():
    policy = load("ppo_unknown")
    shown = seen()[:, : len(policy.sensors.names)]
    actions, memory = policy.predict(shown)
    assert actions.shape == (3, 1)
    with pytest.raises(ValueError, match="parts of the state = 1 is not allowed; allowed: 2, as the last predict"):
        policy.predict(shown, memory[:1])
    with pytest.raises(ValueError, match=r"shape of the state = \(2, 128\) .*; allowed: \(3, 128\)"):
        policy.predict(shown, (memory[0], memory[1][:2]))
    with pytest.raises(ValueError, match="state = one that is not finite is not allowed; allowed: finite numbers"):
        policy.predict(shown, (memory[0], np.full_like(memory[1], np.nan)))
    actions, memory = policy.predict(shown[:0])
    assert (actions.shape, [part.shape for part in memory]) == ((0, 1), [(0, 128), (0, 128)])
    assert policy.predict(shown[:0], memory)[0].shape == (0, 1)
