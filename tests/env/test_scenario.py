import numpy as np
import pytest

from drillrig_env import Friction, Rig, Scenario
from drillrig_env.env.draws import draw_episodes
from drillrig_env.env.generators import first_uniforms
from drillrig_env.env.pins import check_pins
from drillrig_env.env.scenario import PRESETS, STARTS, UNIFORMS
from drillrig_env.env.task import Task

UNIFORM = np.random.default_rng(5).random((4000, UNIFORMS))


def test_default_draws_are_those_of_the_contract():
    drawn = draw_episodes(Scenario(), UNIFORM, 60.0, {})
    table = Friction()
    for values, low, high in (
        (drawn.speed_target, 1.0, 5.0),
        (drawn.friction.normal_force, 5.0, 30.0),
        (drawn.friction.mu_k / table.mu_k, 0.8, 1.2),
        (drawn.friction.v_b / table.v_b, 0.8, 1.2),
    ):
        assert low <= values.min() < low + 0.01 * (high - low)
        assert high - 0.01 * (high - low) < values.max() <= high
    assert np.all(drawn.friction.mu_s >= 1.05 * drawn.friction.mu_k - 1e-15)
    shares = np.bincount(drawn.start, minlength=3) / len(UNIFORM)
    np.testing.assert_allclose(shares, [0.7, 0.2, 0.1], atol=0.03)
    stepped = np.isfinite(drawn.load_times[:, 0])
    assert stepped.mean() == pytest.approx(0.5, abs=0.03)
    assert np.all((drawn.load_times[stepped, 0] >= 0) & (drawn.load_times[stepped, 0] < 60))
    assert not np.isfinite(drawn.load_times[:, 1:]).any()


def test_draws_are_independent_of_each_other():
    drawn = draw_episodes(Scenario(), UNIFORM, 60.0, {})
    columns = [
        drawn.speed_target,
        drawn.friction.normal_force,
        drawn.friction.mu_k,
        drawn.friction.v_b,
        drawn.start,
        drawn.phase,
    ]
    correlation = np.corrcoef(columns) - np.eye(len(columns))
    assert np.abs(correlation).max() < 0.06


def test_presets_differ_as_documented():
    nominal = draw_episodes(PRESETS["nominal"], UNIFORM, 60.0, {})
    assert set(nominal.friction.normal_force) == {10.0}
    assert set(nominal.friction.mu_s) == {0.5}
    wide = draw_episodes(PRESETS["wide"], UNIFORM, 60.0, {})
    assert 2.0 <= wide.friction.normal_force.min() < 3.0
    assert 39.0 < wide.friction.normal_force.max() <= 40.0
    assert 1.35 < wide.friction.v_b.max() <= 1.4


def test_pins_hold_and_leave_the_rest_as_it_was():
    free = draw_episodes(Scenario(), UNIFORM, 60.0, {})
    pins = check_pins({"normal_force": 20.0, "start": "rest", "load_steps": [(1.0, 5.0), (2.5, 9.0)]}, 4000, 60.0)
    pinned = draw_episodes(Scenario(), UNIFORM, 60.0, pins)
    assert set(pinned.friction.normal_force) == {20.0}
    assert {STARTS[i] for i in pinned.start} == {"rest"}
    assert pinned.load_times[0, :3].tolist() == [1.0, 2.5, np.inf]
    np.testing.assert_array_equal(pinned.speed_target, free.speed_target)
    np.testing.assert_array_equal(pinned.friction.mu_k, free.friction.mu_k)


@pytest.mark.parametrize("pins", [{"mu_k": 0.55}, {"mu_s": 0.2}, {"mu_s": 0.3, "mu_k": 0.3}])
def test_one_pinned_coefficient_keeps_the_other_possible(pins):
    drawn = draw_episodes(Scenario(), UNIFORM, 60.0, check_pins(pins, 4000, 60.0))
    assert np.all(drawn.friction.mu_s >= drawn.friction.mu_k)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"normal_forc": 3.0}, ["normal_forc", "did you mean normal_force"]),
        ({"normal_force": -3.0}, ["normal_force", "-3.0 N", ">= 0"]),
        ({"normal_force": "heavy"}, ["normal_force", "heavy", "N"]),
        ({"normal_force": [1.0, 2.0]}, ["shape of normal_force", "(2,)", "(3,)"]),
        ({"speed_target": 0.0}, ["speed_target", "rad/s", ">= 0.01", "<= 10"]),
        ({"speed_target": 11.0}, ["speed_target", "11.0"]),
        ({"v_b": float("nan")}, ["v_b", "nan", "s/rad"]),
        ({"mu_s": 0.1, "mu_k": 0.3}, ["mu_s", "mu_k = 0.3"]),
        ({"start": "rolling"}, ["start", "rolling", "stick_slip, steady, rest"]),
        ({"load_steps": 5.0}, ["load_steps", "list of (time in s, N_1 in N)"]),
        ({"load_steps": [(70.0, 5.0)]}, ["load_steps", "70.0", "0 to 60"]),
        ({"load_steps": [(5.0, 5.0), (1.0, 5.0)]}, ["load_steps", "ascending"]),
        ({"load_steps": [(5.0, -5.0)]}, ["load_steps", "-5.0 N"]),
        ({"load_steps": [(float(i), 5.0) for i in range(9)]}, ["load_steps", "9", "<= 8"]),
    ],
)
def test_impossible_options_are_named(options, words):
    with pytest.raises(ValueError, match="reset options") as caught:
        check_pins(options, 3, 60.0, Task().targets)
    for word in words:
        assert word in str(caught.value)


@pytest.mark.parametrize(
    ("fields", "word"),
    [
        ({"speed_target": (3.0, 1.0)}, "speed_target"),
        ({"speed_target": (0.0, 1.0)}, "speed_target"),
        ({"normal_force": (-1.0, 1.0)}, "normal_force"),
        ({"spread": 1.0}, "spread"),
        ({"stick_slip": 0.9, "steady": 0.2}, "stick_slip"),
        ({"load_step": 2.0}, "load_step"),
    ],
)
def test_impossible_scenario_is_refused(fields, word):
    with pytest.raises(ValueError, match=word):
        Scenario(**fields)


def test_unknown_preset_is_refused():
    with pytest.raises(ValueError, match="did you mean default"):
        Scenario.named("defalt")


def test_slow_targets_can_be_made_more_frequent():
    plain, slow = (
        draw_episodes(Scenario.named(of), UNIFORM, 60.0, {}).speed_target for of in ("default", {"target_skew": 3.0})
    )
    assert np.median(plain) == pytest.approx(3.0, abs=0.1)
    assert np.median(slow) == pytest.approx(1.0 + 4.0 * 0.5**3, abs=0.1)
    assert (slow.min(), slow.max()) == pytest.approx((1.0, 5.0), abs=0.05)


def test_a_scenario_from_its_fields():
    assert Scenario.named({"spread": 0.1}).spread == 0.1
    with pytest.raises(ValueError, match="did you mean spread"):
        Scenario.named({"spred": 0.1})
    with pytest.raises(ValueError, match="target_skew = 0"):
        Scenario(target_skew=0.0)


def test_static_friction_stays_five_per_cent_above_the_kinetic_one():
    """Where the draws would cross, the ratio is the least allowed, and the other coefficient is as drawn."""
    tight = Scenario(spread=0.4, friction=Friction(10.0, 0.31, 0.306))
    drawn = draw_episodes(tight, UNIFORM, 60.0, {})
    ratio = drawn.friction.mu_s / drawn.friction.mu_k
    assert ratio.min() == pytest.approx(1.05, rel=1e-12)
    assert 0.3 < np.mean(ratio < 1.05 + 1e-9) < 0.7
    np.testing.assert_allclose(drawn.friction.mu_k, 0.306 * (1.0 + 0.4 * (2.0 * UNIFORM[:, 3] - 1.0)))
    pinned = draw_episodes(tight, UNIFORM, 60.0, check_pins({"mu_s": 0.3}, 4000, 60.0))
    assert set(pinned.friction.mu_s) == {0.3}
    assert pinned.friction.mu_k.max() == pytest.approx(0.3 / 1.05, rel=1e-12)
    kinetic = draw_episodes(tight, UNIFORM, 60.0, check_pins({"mu_k": 0.3}, 4000, 60.0))
    assert kinetic.friction.mu_s.min() == pytest.approx(0.315, rel=1e-12)


def test_with_candidates_every_second_episode_is_the_hardest_of_them():
    """Harder is steeper: friction that falls faster with speed at the target. The others stay as they were drawn."""
    uniforms = first_uniforms(0, 4000)
    plain, hard = (draw_episodes(Scenario(candidates=number), uniforms, 60.0, {}) for number in (1, 5))
    same = hard.speed_target == plain.speed_target
    assert 0.45 < same.mean() < 0.65  # half of them, and a fifth of the rest
    steepness = [-np.asarray(one.friction.slope(Rig(), one.speed_target)) for one in (plain, hard)]
    assert np.all(steepness[1] >= steepness[0])
    assert steepness[1][~same].mean() > 2.0 * steepness[0].mean()
    for name in ("normal_force", "mu_s", "mu_k", "v_b"):
        ends = [(np.min(getattr(one.friction, name)), np.max(getattr(one.friction, name))) for one in (plain, hard)]
        np.testing.assert_allclose(ends[0], ends[1], rtol=0.02)


def test_candidates_are_of_the_same_distribution():
    """Where steepness does not differ between candidates, the draws stay uniform."""
    flat = Scenario(candidates=5, speed_target=(2.0, 2.0), normal_force=(10.0, 10.0), spread=0.0)
    draws = draw_episodes(flat, first_uniforms(0, 4000), 60.0, {})
    assert abs(np.isfinite(draws.load_times[:, 0]).mean() - 0.5) < 0.03
    assert abs(draws.phase.mean() - 0.5) < 0.02


def test_there_are_no_more_than_a_hundred_candidates():
    assert Scenario(candidates=100).candidates == 100
    with pytest.raises(ValueError, match="candidates = 101"):
        Scenario(candidates=101)


def test_pins_hold_for_the_candidates_too():
    pins = check_pins({"speed_target": 3.0, "normal_force": 20.0}, 50, 60.0)
    draws = draw_episodes(Scenario(candidates=3), first_uniforms(0, 50), 60.0, pins)
    assert set(draws.speed_target) == {3.0}
    assert set(draws.friction.normal_force) == {20.0}
