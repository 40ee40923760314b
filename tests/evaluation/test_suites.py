"""What the suites hold, and that the rigs are everyone's."""

import json

import numpy as np
import pytest

from baselines import Constant
from drillrig_env.env.core import EpisodeBatch
from drillrig_env.env.generators import first_uniforms
from drillrig_env.env.registration import ENVIRONMENTS
from drillrig_env.evaluation.runner import run
from drillrig_env.evaluation.suites import OF_ONE_RIG, SUITES, meant_for, suite
from drillrig_env.seeds import EVALUATION_SEEDS


class Hold:
    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        return np.zeros((len(observation), 1), np.float32), None


def rigs_of(one):
    batch = EpisodeBatch(one.rigs, scenario=one.scenario, **one.env)
    uniforms = first_uniforms(one.first_seed, one.rigs)
    first = 0
    for count, options in one.groups:
        batch.reset(np.arange(first, first + count), uniforms[first : first + count], options)
        first += count
    return batch


def test_chapter_holds_the_chapters_cases():
    chapter = suite("chapter")
    episodes = run(Hold(), chapter)
    assert chapter.rigs == len(episodes.speed_target) == 44
    assert set(np.asarray(episodes.friction.normal_force)) == {10.0, 20.0, 25.0}
    assert episodes.speed_target[-2:].tolist() == [3.0, 3.14]
    assert set(np.asarray(episodes.friction.mu_s)) == {0.5}
    begun = rigs_of(chapter).episodes
    assert begun["normal_force"].tolist() == [10.0] * 21 + [20.0] * 21 + [0.0] * 2  # no load until 25 N at 10 s
    assert begun["load_times"][-2:, :2].tolist() == [[10.0, np.inf]] * 2
    assert begun["load_forces"][-2:, 0].tolist() == [25.0, 25.0]


def test_load_starts_steady_at_a_low_force_and_steps_up():
    rigs = rigs_of(suite("load", 200)).episodes
    assert (rigs["normal_force"] >= 5.0).all()
    assert (rigs["normal_force"] <= 15.0).all()
    assert np.ptp(rigs["normal_force"]) > 8.0
    times, forces = rigs["load_times"], rigs["load_forces"]
    assert np.isinf(times[:, 1:]).all()
    assert times[:, 0].min() >= 12.0
    assert times[:, 0].max() <= 30.0
    assert forces[:, 0].min() >= 15.0
    assert forces[:, 0].max() <= 30.0
    assert (np.ptp(times[:, 0]) > 15.0) & (np.ptp(forces[:, 0]) > 12.0)


def test_degraded_has_the_rigs_of_default_seen_late_with_noise():
    plain, degraded = rigs_of(suite("default", 100)), rigs_of(suite("degraded", 100))
    for name in ("normal_force", "mu_s", "mu_k", "v_b", "speed_target", "state"):
        np.testing.assert_array_equal(plain.episodes[name], degraded.episodes[name])
    assert set(degraded.episodes["delay"]) == {1, 2, 3, 4, 5}
    assert suite("degraded", 1).slew_limit == 0.5 * suite("default", 1).slew_limit == 1.0


def test_wide_draws_beyond_default():
    wide = rigs_of(suite("wide", 200)).episodes
    assert wide["normal_force"].max() > 35.0
    assert wide["mu_s"].max() > 0.6 * 1.05


def test_a_policy_that_is_made_for_the_suite_slews_as_far_as_it_means_to():
    one = suite("degraded", 4)
    reference = run(Constant(slew_limit=one.slew_limit), one).speed_reference
    assert np.abs(np.diff(reference, axis=1)).max() <= 0.1 * one.slew_limit + 1e-9


@pytest.mark.parametrize(
    ("name", "rig"), [("default", 7), ("chapter", 0), ("chapter", 21), ("chapter", 43), ("degraded", 3)]
)
def test_a_single_rig_of_a_suite_faces_the_same_episode(name, rig):
    whole = suite(name, 10)
    one = run(Hold(), whole.only(rig))
    np.testing.assert_array_equal(one.average[0], run(Hold(), whole).average[rig])


def test_a_rig_that_is_not_there_is_refused():
    for rig in (-1, 10):
        with pytest.raises(ValueError, match=rf"rig = {rig} .* 0 to 9"):
            suite("default", 10).only(rig)


def test_a_definition_is_plain_and_tells_suites_apart():
    texts = {name: json.dumps(suite(name, 5).definition()) for name in SUITES}
    assert len(set(texts.values())) == len(SUITES)
    assert json.loads(texts["degraded"])["env"] == {"noise": 2.0, "delay": [1, 5], "slew_limit": 1.0}
    assert json.loads(texts["default"])["first_seed"] == EVALUATION_SEEDS.start
    *sweeps, stepped = json.loads(texts["chapter"])["groups"]
    for force, (count, options) in zip((10.0, 20.0), sweeps, strict=True):
        targets = [k / 10 for k in range(10, 51, 2)]
        assert (count, options["speed_target"], options["normal_force"]) == (21, targets, force)
    assert stepped[1]["load_steps"] == [[10.0, 25.0]]


def test_every_environment_has_suites_of_its_own_or_those_of_one_rig():
    assert {env_id: meant_for(env_id) for env_id in ENVIRONMENTS} == {
        "DrillRig-v0": OF_ONE_RIG,
        "DrillRigSurface-v0": OF_ONE_RIG,
        "DrillRigUnknown-v0": ("unknown", "unknown_hard"),
        "DrillRigDrift-v0": ("drift",),
    }


def test_unknown_suite_is_refused():
    with pytest.raises(ValueError, match="did you mean default"):
        suite("defaults")
    with pytest.raises(ValueError, match="rigs = 0"):
        suite("default", 0)


@pytest.mark.parametrize("make", [SUITES[name] for name in OF_ONE_RIG if name != "chapter"])
def test_suites_that_are_drawn_have_a_thousand_rigs_unless_told(make):
    assert make().rigs == suite(make().name).rigs == 1000
    assert make(7).rigs == 7
