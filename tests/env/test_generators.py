"""Each rig's generator in 32 bytes draws what Gymnasium's own would."""

import numpy as np
import pytest
from gymnasium.utils import seeding

from drillrig_env.env.core import EpisodeBatch
from drillrig_env.env.generators import EpisodeGenerators, first_uniforms
from drillrig_env.env.scenario import UNIFORMS, Scenario

SEEDS = (0, 7, 2**40)


def seeded():
    generators = EpisodeGenerators(4)
    assert not generators.seeded
    assert [generators.seed(rig, seed) for rig, seed in enumerate(SEEDS)] == list(SEEDS)
    assert generators.seeded
    return generators


def test_a_rig_draws_what_gymnasium_draws_with_its_seed_episode_after_episode():
    generators = seeded()
    for rig, seed in enumerate(SEEDS):
        own, _ = seeding.np_random(seed)
        for _ in range(3):
            np.testing.assert_array_equal(generators.uniforms(np.array([rig]))[0], own.random(UNIFORMS))


def test_an_episode_takes_twelve_numbers_whatever_it_uses_of_them():
    core, generators, numbers = EpisodeBatch(1, scenario="default"), EpisodeGenerators(1), seeding.np_random(7)[0]
    generators.seed(0, 7)
    low, high = Scenario.named("default").normal_force
    for options in ({"start": "steady"}, {"load_steps": []}, {}):
        core.reset(np.array([0]), generators.uniforms(np.array([0])), options)
        assert core.episodes["normal_force"][0] == pytest.approx(low + (high - low) * numbers.random(12)[1])


def test_rigs_draw_independently_of_which_others_draw_and_in_what_order():
    together, alone = seeded(), seeded()
    drawn = together.uniforms(np.array([2, 0, 1]))
    assert drawn.shape == (3, UNIFORMS)
    for row, rig in zip(drawn, (2, 0, 1), strict=True):
        np.testing.assert_array_equal(row, alone.uniforms(np.array([rig]))[0])
    np.testing.assert_array_equal(together.states, alone.states)


def test_seeding_anew_begins_anew_and_leaves_the_others():
    generators = seeded()
    first = generators.uniforms(np.array([0, 1]))
    generators.seed(0, SEEDS[0])
    again = generators.uniforms(np.array([0, 1]))
    np.testing.assert_array_equal(again[0], first[0])
    assert not np.any(again[1] == first[1])


def test_fresh_entropy_is_used_for_no_seed_and_told():
    generators = EpisodeGenerators(2)
    used = [generators.seed(rig, None) for rig in range(2)]
    assert used[0] != used[1]
    drawn = generators.uniforms(np.array([0]))[0]
    np.testing.assert_array_equal(drawn, seeding.np_random(used[0])[0].random(UNIFORMS))


def test_first_uniforms_are_those_of_consecutive_seeds():
    found = first_uniforms(5, 3)
    for row, seed in zip(found, (5, 6, 7), strict=True):
        np.testing.assert_array_equal(row, seeding.np_random(seed)[0].random(UNIFORMS))


def test_a_text_and_an_array_without_a_dimension_are_no_list_of_seeds():
    with pytest.raises(ValueError, match="seed = '12' is text"):
        EpisodeGenerators(2).seed_all("12")
    with pytest.raises(ValueError, match=r"seed = \[\[1\], \[2\]\] is not allowed"):
        EpisodeGenerators(2).seed_all([[1], [2]])
    for seed, wanted in ((np.array(7), [7, 8]), (7, [7, 8]), ((4, 9), [4, 9]), (np.array([4, 9]), [4, 9])):
        generators = EpisodeGenerators(2)
        generators.seed_all(seed)
        assert generators.seeds == wanted
