"""Joint draws by Markov chains: of the density that the fit has, and only where they have converged."""

import sys
from dataclasses import replace

import numpy as np
import pytest

from drillrig_env import Friction
from drillrig_env.calibrate import command
from drillrig_env.calibrate import sampled as module
from drillrig_env.calibrate.calibration import calibrate
from drillrig_env.calibrate.sampled import Density, Sampling, draw_words, sampled, temper_of
from drillrig_env.engine import Local
from tests.calibrate.test_calibration import FIXED, STICKING, csv_of

TWO = dict.fromkeys(FIXED) | dict.fromkeys(("K_T", "J_2", "mu_k", "mu_s - mu_k"))
"""k_2 and v_b are looked for."""


@pytest.fixture(scope="module")
def found():
    return calibrate([STICKING], None, Friction(10.0), fix=TWO, starts=1)


def test_the_density_is_that_of_the_fit(found):
    density = Density(found.best, 1.0)
    assert density(found.best.logs) == 0.0
    root = np.linalg.cholesky(found.spread.covariance)
    for away in ([1.0, 0.0], [0.0, -1.0], [1.5, 1.5]):
        logs = found.best.logs + root @ away
        assert density(logs) < -0.1
        assert density(logs) == pytest.approx(density.anew(logs), rel=0.05, abs=0.05)
        assert Density(found.best, 4.0)(logs) == pytest.approx(0.25 * density(logs), abs=0.05)
    assert density(found.best.logs + 4.0) == -np.inf


def test_the_cost_is_divided_by_what_windows_disagree_more_than_samples(found):
    temper = temper_of(found.best, found.spread)
    assert temper >= 1.0
    wider = replace(found.spread, covariance=4.0 * found.spread.covariance)
    assert temper_of(found.best, wider) == pytest.approx(4.0 * temper, rel=1e-6)
    assert temper_of(found.best, replace(found.spread, determined=np.zeros(2, dtype=bool))) == 1.0


class Normal:
    """A density that is known, quick to ask for."""

    off = 0.0

    def __init__(self, best, temper):
        self.best, self.temper = best, temper
        self.inverse = np.diag([1.0 / 0.02**2, 1.0 / 0.1**2])

    def __call__(self, logs):
        away = logs - self.best.logs
        return -0.5 * away @ self.inverse @ away

    def anew(self, logs):
        return self(logs) - self.off


def test_draws_are_those_of_the_density(found, monkeypatch):
    pytest.importorskip("emcee")
    monkeypatch.setattr(module, "Density", Normal)
    seen = []
    drawn = sampled(found, 4000, lambda done, time: seen.append((done, time)))
    assert drawn.sampling.converged
    assert drawn.sampling.steps >= 50.0 * drawn.sampling.time
    assert [done for done, _ in seen] == list(range(250, 250 * len(seen) + 1, 250))
    assert drawn.draws.shape == found.draws.shape
    np.testing.assert_allclose(drawn.draws.std(axis=0), [0.02, 0.1], rtol=0.3)
    np.testing.assert_allclose((drawn.draws.mean(axis=0) - found.best.logs) / [0.02, 0.1], 0.0, atol=0.5)
    np.testing.assert_array_equal(sampled(found, 4000).draws, drawn.draws)
    assert "joint draws by emcee: 6 walkers" in str(drawn.sampling)
    monkeypatch.setattr(Normal, "off", 2.0)
    wrong = sampled(found, 4000)
    assert not wrong.sampling.converged
    np.testing.assert_array_equal(wrong.draws, found.draws)


@pytest.mark.slow
def test_several_processes_draw_the_same(found):
    pytest.importorskip("emcee")
    alone, both = (sampled(found, 40, engine=Local(jobs)) for jobs in (1, 2))
    assert alone.sampling == both.sampling
    np.testing.assert_array_equal(alone.draws, both.draws)


@pytest.mark.slow
def test_draws_spread_as_a_normal_distribution_where_that_holds(found):
    pytest.importorskip("emcee")
    drawn = sampled(found, 1500)
    assert drawn.sampling.converged
    ratio = drawn.draws.std(axis=0) / found.spread.deviations
    assert np.all((ratio > 0.6) & (ratio < 1.5))
    assert np.all(np.abs(drawn.draws.mean(axis=0) - found.best.logs) < 0.5 * found.spread.deviations)


def test_chains_that_are_too_short_change_no_draw(found, monkeypatch):
    pytest.importorskip("emcee")
    monkeypatch.setattr(module, "Density", Normal)
    drawn = sampled(found, 20)
    assert not drawn.sampling.converged
    np.testing.assert_array_equal(drawn.draws, found.draws)
    assert "emcee has not converged: 6 walkers of 15 steps" in str(drawn.sampling)
    assert "--posterior-steps 30 or more" in str(drawn.sampling)
    assert "stay those of a normal distribution" in str(drawn.sampling)

    def stop(*_):
        raise KeyboardInterrupt

    ended = sampled(found, 500, stop)
    assert not ended.sampling.converged
    assert ended.sampling.off == 0.0  # of draws that were not made
    np.testing.assert_array_equal(ended.draws, found.draws)


def test_draws_that_do_not_follow_the_records_are_told(found):
    assert draw_words(found) == []
    far = replace(found, draws=found.best.logs + 4.0 * (found.draws - found.best.logs))
    (line,) = draw_words(far)
    assert "the joint draws do not follow the records" in line
    assert "where 1 is usual; --posterior emcee draws from that density" in line
    converged = replace(far, sampling=Sampling(6, 1000, 10.0, 0.4, 1.2, 0.0))
    assert draw_words(converged) == [str(converged.sampling)]


def test_a_density_that_does_not_hold_at_its_draws_is_said():
    off = Sampling(6, 1000, 10.0, 0.4, 1.2, 3.0)
    assert not off.converged
    assert str(off).startswith("emcee: the density is off by 3 at its draws")


def test_a_missing_package_is_said_before_the_fit(tmp_path, capsys, monkeypatch):
    csv_of(STICKING, tmp_path / "run.csv")
    monkeypatch.setitem(sys.modules, "emcee", None)
    monkeypatch.setattr("drillrig_env.calibrate.command.fit_of", lambda *_: 1 / 0)
    with pytest.raises(SystemExit):
        command.main([str(tmp_path / "run.csv"), "--posterior", "emcee"])
    assert (
        "sampling a posterior needs emcee; in a clone of DrillRig: pip install -e '.[posterior]'"
        in capsys.readouterr().err
    )
    with pytest.raises(SystemExit):
        command.main([str(tmp_path / "run.csv"), "--posterior-steps", "9"])
    assert "--posterior-steps is given without --posterior emcee" in capsys.readouterr().err
    assert module.STEPS >= 1000
