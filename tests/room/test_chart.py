"""The map against the stability analysis, and that what is slow can be stopped."""

from dataclasses import replace

import numpy as np
import pytest

from drillrig_env.drive import Drive
from drillrig_env.friction import Friction
from drillrig_env.rig import Rig
from drillrig_env.room.chart import chart_of, driven, followed, orbit_of
from drillrig_env.stability import critical_speed, fold_speed


def test_the_chart_is_the_stability_analysis_over_forces():
    chart = chart_of(Rig(), Friction(20.0), 40.0)
    assert (chart.forces[0], chart.forces[-1], len(chart.forces)) == (1.0, 40.0, 40)
    assert chart.critical_now == pytest.approx(2.68806, abs=1e-5)  # the chapter prints 2.689
    np.testing.assert_array_equal(chart.critical, critical_speed(Rig(), Friction(chart.forces)))
    np.testing.assert_array_equal(chart.end, fold_speed(Rig(), Friction(chart.forces)))
    assert chart_of(Rig(), Friction(0.0), 40.0).critical_now == 0.0


def test_beyond_the_fold_the_true_end_is_followed_unless_it_is_stopped():
    friction = Friction(30.0, mu_s=0.6, mu_k=0.3, v_b=2.0)
    chart = chart_of(Rig(), friction, 30.0)
    assert followed(chart, Rig(), friction, 30.0, lambda: True) is None
    light = replace(friction, normal_force=3.0)
    whole = followed(chart_of(Rig(), light, 3.0), Rig(), light, 3.0, lambda: False)
    assert whole.followed
    np.testing.assert_allclose(whole.end[-1], whole.end_now)
    assert whole.end_now >= float(fold_speed(Rig(), light)) * (1 - 1e-9)


def test_a_soft_drive_has_a_map_of_its_own():
    soft = driven(Rig(), Drive(0.8, 0.4, back_emf_share=0.5))
    assert (soft.k_p, soft.k_i, soft.K_E) == (0.8, 0.4, 0.5 * Rig().K_E)
    assert driven(Rig(), None) == Rig()
    assert chart_of(soft, Friction(), 40.0).critical_now < chart_of(Rig(), Friction(), 40.0).critical_now


def test_a_rig_without_a_map_says_why():
    shaking = chart_of(replace(Rig(), k_i=2000.0), Friction(), 40.0).as_dict()
    assert shaking["critical_now"] is None  # at no speed is steady rotation stable
    assert set(shaking["critical"]) == {1e9}


def test_what_the_analysis_refuses_is_said_in_place_of_a_map(monkeypatch):
    def refuse(*_):
        raise ValueError("critical_speed: no")

    monkeypatch.setattr("drillrig_env.room.chart.critical_speed", refuse)
    told = chart_of(Rig(), Friction(), 40.0)
    assert (told.note, told.as_dict()["critical"]) == ("critical_speed: no", [])
    assert followed(told, Rig(), Friction(), 40.0, lambda: False) is told


def test_orbit_and_calm_point():
    orbit = orbit_of(Rig(), Friction(), 2.0)
    assert orbit["calm_speed"] == 2.0
    assert min(orbit["bit_speed"]) == pytest.approx(0.0, abs=2e-3)
    assert max(orbit["bit_speed"]) > 4.0
    assert len(orbit["twist"]) == len(orbit["bit_speed"]) == 161
    calm = orbit_of(Rig(), Friction(), 3.5)
    assert (calm["twist"], calm["period"]) == ([], None)
