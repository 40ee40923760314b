"""The tests that a policy can run on itself: what keeps the contract passes, each breach is named."""

import numpy as np
import pytest

from drillrig_env.policy import check_policy, policy_names


class Keeps:
    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        seen = np.zeros((len(observation), 1)) if state is None else np.array(state[0])
        seen[np.asarray(episode_start, bool)] = 0.0
        seen += observation[:, :1]
        return np.tanh(seen).astype(np.float32), (seen,)


class Remembers(Keeps):
    calls = 0

    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        self.calls += 1
        actions, state = super().predict(observation, state, episode_start)
        return actions / self.calls, state


class ChangesObservations(Keeps):
    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        observation *= 1.0
        observation[:] = 0.0
        return super().predict(observation, state, episode_start)


class ChangesItsState(Keeps):
    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        if state is not None:
            state[0][:] = 0.0
        return super().predict(observation, state, episode_start)


class LooksAround(Keeps):
    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        return np.tanh(observation[:, :1] - observation[:, :1].mean()).astype(np.float32), None


class CountsRigs(Keeps):
    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        return np.linspace(0.0, 1.0, len(observation), dtype=np.float32)[:, None], None


class NeverForgets(Keeps):
    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        return super().predict(observation, state, np.zeros(len(observation), bool))


class Flat(Keeps):
    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        return np.zeros(len(observation), np.float32), None


class TooMuch(Keeps):
    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        return np.full((len(observation), 1), 2.0, np.float32), None


class NotFinite(Keeps):
    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        return np.full((len(observation), 1), np.nan, np.float32), None


class Whole(Keeps):
    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        return np.zeros((len(observation), 1), int), None


class NoState(Keeps):
    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        return np.zeros((len(observation), 1), np.float32)


class OddSensors(Keeps):
    sensors = 5


class CannotBeTold(Keeps):
    privileged = ("mu_s",)


class OddPrivileged(Keeps):
    privileged = "mu_s"

    def tell(self, info):
        pass


class Exits(Keeps):
    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        raise SystemExit(0)


class ExitsWhenMade(Keeps):
    def __init__(self):
        raise SystemExit("no licence")


class ExitsWhenTold(Keeps):
    privileged = ("mu_s",)

    def tell(self, info):
        raise SystemExit


class OddExact(Keeps):
    exact = "yes"


class ExactOfNothing(Keeps):
    exact = True


class NoPolicy:
    pass


@pytest.mark.parametrize("policy", [Keeps, Keeps()])
def test_a_policy_that_keeps_the_contract_passes(policy):
    check_policy(policy)


@pytest.mark.parametrize(
    ("policy", "fault"),
    [
        (Remembers, "keeps something of its own"),
        (ChangesObservations, "changes the observations"),
        (ChangesItsState, "keeps something of its own|changes the state"),
        (LooksAround, "otherwise on rig 0 alone"),
        (CountsRigs, "otherwise on rig"),
        (NeverForgets, "remembers, after an episode's start"),
        (Flat, r"shape \(6,\).*allowed.*\(6, 1\)"),
        (TooMuch, "finite, -1 to 1"),
        (NotFinite, "finite, -1 to 1"),
        (Whole, "int64"),
        (NoState, r"predict returns ndarray; allowed: \(actions, state\)"),
        (OddSensors, "sensors = 5"),
        (CannotBeTold, "must be told mu_s"),
        (OddPrivileged, "privileged = 'mu_s' is not allowed; allowed: names of entries"),
        (OddExact, "exact = 'yes' is not allowed; allowed: True or False"),
        (ExactOfNothing, "sensors = None is not allowed; allowed: names of channels"),
        (NoPolicy, "has no predict"),
        (Exits, r"Exits: ends the whole program \(SystemExit: 0\)"),
        (ExitsWhenMade, "ExitsWhenMade: ends the whole program .*no licence"),
        (ExitsWhenTold, "ends the whole program"),
    ],
)
def test_each_breach_is_named(policy, fault):
    with pytest.raises((ValueError, TypeError), match=fault):
        check_policy(policy)


def test_a_file_that_ends_the_program_is_a_finding(tmp_path):
    (tmp_path / "mine.py").write_text("raise SystemExit(3)\n")
    with pytest.raises(ValueError, match=r"mine.py:Mine: ends the whole program \(SystemExit: 3\)"):
        check_policy(f"{tmp_path / 'mine.py'}:Mine")


class Listens(Keeps):
    def __init__(self):
        self.told = []

    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        self.told.append((state is None, *episode_start))
        return super().predict(observation, state, episode_start)


def test_an_episode_starts_where_there_is_no_state_and_once_where_it_starts_anew():
    """Every call is made twice, and one of the runs begins a second episode halfway."""
    policy = Listens()
    check_policy(policy)
    assert all(len(set(starts)) == 1 for _, *starts in policy.told)
    assert all(starts[0] for begins, *starts in policy.told if begins)
    assert sum(starts[0] for begins, *starts in policy.told if not begins) == 2


@pytest.mark.parametrize("name", [name for name in policy_names() if name != "mppi"])
def test_the_projects_own_policies_keep_it(name):
    check_policy(name, sensors="state" if name != "ppo_surface_soft" else "surface")


@pytest.mark.slow
def test_the_planner_keeps_it():
    check_policy("mppi", sensors="state")
