"""The picture of a rig: what it shows, what it needs, and what it leaves alone."""

import sys
import warnings

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.error import ResetNeeded
from gymnasium.utils.env_checker import check_env

from drillrig_env import Friction, Rig
from drillrig_env.env.single import DrillRigEnv
from drillrig_env.stability import EndOfStickSlip
from tests.rigs import STEADY_AND_WINDOW, scaled

pygame = pytest.importorskip("pygame", reason="rendering needs the extra `render` (pygame-ce)")

UP = np.ones(1, dtype=np.float32)
PINNED = {"normal_force": 20.0, "speed_target": 3.0, "start": "stick_slip", "load_steps": []}


@pytest.fixture
def env():
    env = gym.make("DrillRig-v0", render_mode="rgb_array")
    yield env
    env.close()


@pytest.fixture
def no_screen(monkeypatch):
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")


def area(frame, name):
    """A part of the frame: the rig, the strip charts or the map."""
    return {"rig": frame[:, :380], "chart": frame[60:256, 425:930], "map": frame[330:490, 425:930]}[name]


def test_a_frame_is_rgb_of_the_stated_size_and_opens_no_display(env):
    pygame.display.quit()
    env.reset(seed=0)
    frame = env.render()
    assert frame.shape == (540, 960, 3)
    assert frame.dtype == np.uint8
    assert frame.std() > 10
    assert pygame.display.get_init() is False


@pytest.mark.parametrize("part", ["rig", "chart", "map"])
def test_every_part_moves_with_the_rig(env, part):
    env.reset(seed=0, options=PINNED)
    before = env.render()
    for _ in range(5):
        env.step(UP)
    assert np.any(area(before, part) != area(env.render(), part))


def test_a_frame_stays_as_it_was_and_drawing_again_draws_the_same(env):
    env.reset(seed=0)
    first, again = env.render(), env.render()
    kept = first.copy()
    np.testing.assert_array_equal(first, again)
    env.step(UP)
    env.render()
    np.testing.assert_array_equal(first, kept)


def test_the_same_seed_draws_the_same_pictures(env):
    frames = []
    for _ in range(2):
        env.reset(seed=3)
        for _ in range(20):
            env.step(UP)
        frames.append(env.render())
    np.testing.assert_array_equal(*frames)


def test_the_map_is_that_of_the_friction_drawn_at_reset(env):
    maps = []
    for mu_s in (0.45, 0.6):
        env.reset(seed=0, options={**PINNED, "mu_s": mu_s, "mu_k": 0.3, "v_b": 1.0})
        maps.append(area(env.render(), "map"))
    assert np.any(maps[0] != maps[1])


@pytest.mark.parametrize(
    "options",
    [
        {"normal_force": 0.0},
        {"mu_s": 0.4, "mu_k": 0.4},
        {"start": "rest", "speed_target": 10.0},
        {"normal_force": 150.0, "load_steps": [(0.2, 400.0)]},
    ],
    ids=["no force", "no stick-slip", "from rest", "far beyond the usual map"],
)
def test_extreme_episodes_can_be_drawn(env, options):
    env.reset(seed=0, options=options)
    for _ in range(5):
        env.step(UP)
        assert env.render().shape == (540, 960, 3)


@pytest.mark.parametrize(
    "change",
    [
        pytest.param({"k_p": 0.0, "k_i": 100.0, "d_1": 0.0, "d_2": 0.0}, marks=pytest.mark.slow),
        STEADY_AND_WINDOW,
        pytest.param({"J_1": 1e-5}, marks=pytest.mark.slow),
    ],
)
def test_a_rig_without_one_critical_speed_or_without_a_fold_can_be_drawn(change):
    env = DrillRigEnv(rig=Rig(**change), render_mode="rgb_array")
    env.reset(seed=0)
    assert env.render().shape == (540, 960, 3)


def test_rendering_does_not_change_the_episode(env):
    plain = gym.make("DrillRig-v0")
    np.testing.assert_array_equal(env.reset(seed=5)[0], plain.reset(seed=5)[0])
    for _ in range(30):
        env.render()
        np.testing.assert_array_equal(env.step(UP)[0], plain.step(UP)[0])


def test_human_mode_shows_itself_and_closes_its_window(no_screen):
    env = gym.make("DrillRig-v0", render_mode="human")
    env.reset(seed=0)
    env.step(UP)
    shown = pygame.surfarray.array3d(pygame.display.get_surface())
    assert shown.shape == (960, 540, 3)
    assert shown.std() > 10
    assert env.render() is None
    env.close()
    env.close()
    assert pygame.display.get_init() is False


def test_an_episode_goes_on_when_its_window_is_closed(no_screen):
    env = gym.make("DrillRig-v0", render_mode="human")
    env.reset(seed=0)
    pygame.event.post(pygame.event.Event(pygame.QUIT))
    env.step(UP)
    assert pygame.display.get_init() is False
    env.step(UP)
    env.reset(seed=1)
    env.close()


def test_without_a_mode_render_warns_and_returns_nothing():
    env = DrillRigEnv()
    env.reset(seed=0)
    with pytest.warns(UserWarning, match="render_mode"):
        assert env.render() is None
    env.close()


def test_nothing_can_be_drawn_before_the_first_episode():
    with pytest.raises(ResetNeeded, match="reset"):
        DrillRigEnv(render_mode="rgb_array").render()


def test_an_unknown_mode_is_refused_with_those_allowed():
    with pytest.raises(ValueError, match=r"render_mode = 'ansi' .*allowed: None, rgb_array, human"):
        DrillRigEnv(render_mode="ansi")


def test_without_pygame_the_error_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "pygame", None)
    for module in ("charts", "rendering"):
        monkeypatch.delitem(sys.modules, f"drillrig_env.env.{module}", raising=False)
    with pytest.raises(ImportError, match=r"pip install .*render"):
        DrillRigEnv(render_mode="rgb_array")
    DrillRigEnv().close()


@pytest.mark.parametrize("mode", [None, "rgb_array"])
def test_the_checker_passes_without_a_warning(mode, no_screen):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(gym.make("DrillRig-v0", render_mode=mode).unwrapped)


def test_record_video_writes_a_film(env, tmp_path):
    pytest.importorskip("moviepy", reason="gymnasium.wrappers.RecordVideo needs moviepy")
    film = gym.wrappers.RecordVideo(env, str(tmp_path / "films"), disable_logger=True)
    film.reset(seed=0)
    for _ in range(10):
        film.step(UP)
    film.close()
    (path,) = tmp_path.glob("films/*.mp4")
    assert path.stat().st_size > 1000


@pytest.mark.parametrize(
    ("highest", "marks"),
    [
        (10.0, [0, 2, 4, 6, 8, 10]),
        (7.5, [0, 2, 4, 6]),
        (36.0, [0, 10, 20, 30]),
        (0.06, [0, 0.01, 0.02, 0.03, 0.04, 0.05, 0.06]),
    ],
)
def test_axes_have_round_numbers_at_any_size(highest, marks):
    from drillrig_env.env.charts import _steps

    assert _steps(highest) == marks


def test_a_picture_of_a_scaled_rig_shows_the_scaled_episode():
    frames = []
    for rig in (None, scaled(time=0.25)):
        env = gym.make("DrillRig-v0", rig=rig, render_mode="rgb_array")
        env.reset(seed=4)
        for _ in range(30):
            env.step(np.array([0.5], dtype=np.float32))
        frames.append(env.render())
    assert np.mean(frames[0] != frames[1]) < 0.02  # but for the numbers


@pytest.mark.parametrize(("kind", "most"), [("grazing", 60), ("none", 60), ("fold", 11), ("other", 11), (None, 11)])
def test_the_map_follows_few_branches_where_that_is_slow(kind, most, monkeypatch):
    from drillrig_env.env import charts

    asked = []

    def end(_, friction):
        asked.append(friction.normal_force)
        if kind is None:
            raise ValueError("not found")
        return EndOfStickSlip(3.0 + friction.normal_force, kind)

    monkeypatch.setattr(charts, "end_of_stick_slip", end)
    charts._boundaries.cache_clear()
    forces, critical, fold = charts._boundaries(Rig(), 0.5, 0.3, 1.0, "exponential", 30.0)
    charts._boundaries.cache_clear()
    assert len(asked) == len(set(asked)) == most
    assert np.all(critical < fold)
    np.testing.assert_allclose(fold, 3.0 + forces if kind else np.inf, rtol=1e-12)


def test_the_map_is_exact_beside_the_load_from_which_on_none_is_found(monkeypatch):
    from drillrig_env.env import charts

    def end(_, friction):
        if friction.normal_force > 17.1:
            raise FloatingPointError("no orbit")
        return EndOfStickSlip(friction.normal_force**2, "fold")

    monkeypatch.setattr(charts, "end_of_stick_slip", end)
    frictions = [Friction(0.5 * place) for place in range(1, 61)]
    folds = charts._folds(Rig(), frictions)
    np.testing.assert_array_equal(np.isfinite(folds), [0.5 * place <= 17.1 for place in range(1, 61)])
    assert folds[33] == 17.0**2
