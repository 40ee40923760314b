"""The chain of many lumps that three are judged by."""

import numpy as np
import pytest

from benchmarks.string_lumps import (
    COLLARS,
    FRICTION,
    HOLE,
    PIPE,
    TOP,
    Chain,
    lowest_mode,
    main,
    period_and_peak,
)
from drillrig_env.lumps import STEEL, Mud
from drillrig_env.model import jacobian


def test_a_chain_holds_all_of_the_steel_whatever_its_number_of_lumps():
    for lumps in (5, 13, 80):
        chain = Chain(lumps, FRICTION, 0.03)
        mud = Mud(0.03, HOLE)
        assert chain.C.sum() == pytest.approx(mud.drag(PIPE) + mud.drag(COLLARS))
        assert chain.C.sum() == pytest.approx(chain.rig.C_1 + chain.rig.C_2 + chain.rig.C_m)
        total = PIPE.inertia(STEEL["density"]) + COLLARS.inertia(STEEL["density"]) + TOP
        assert chain.J.sum() == pytest.approx(total)
        compliance = 1 / PIPE.stiffness(STEEL["shear_modulus"]) + 1 / COLLARS.stiffness(STEEL["shear_modulus"])
        assert (1 / chain.k).sum() == pytest.approx(compliance)


def test_its_modes_settle_with_the_number_of_lumps_close_to_those_of_three():
    found = [lowest_mode(Chain(lumps, FRICTION).matrix)[0] for lumps in (20, 40, 80)]
    assert abs(found[2] - found[1]) < abs(found[1] - found[0]) < 1e-3
    assert lowest_mode(jacobian(Chain(80, FRICTION).rig))[0] == pytest.approx(found[2], rel=0.03)


def test_mud_damps_the_lowest_mode_of_many_lumps_as_it_does_that_of_three():
    plain, muddy = (Chain(80, FRICTION, viscosity) for viscosity in (0.0, 0.1))
    gained = [lowest_mode(muddy.matrix)[1] - lowest_mode(plain.matrix)[1]]
    gained.append(lowest_mode(jacobian(muddy.rig))[1] - lowest_mode(jacobian(plain.rig))[1])
    assert gained[0] > 0.02  # as much again as shafts and drive take
    assert gained[1] == pytest.approx(gained[0], rel=0.03)


def test_period_and_peak_are_those_of_a_known_wave():
    times = np.arange(0.0, 60.0, 0.005)
    speed = np.maximum(0.0, 10.0 * np.sin(2 * np.pi * times / 4.7))
    period, peak = period_and_peak(times, speed)
    assert (period, peak) == (pytest.approx(4.7, abs=2e-3), pytest.approx(10.0, abs=1e-3))
    with pytest.raises(ValueError, match="does not stick and slip"):
        period_and_peak(times, np.full(times.shape, 8.0))


def test_rotation_without_friction_goes_to_the_reference():
    chain = Chain(6, type(FRICTION)(0.0, 0.5, 0.3, 0.2))
    assert chain.bit_speed(3.0, np.array([0.0, 150.0]))[-1] == pytest.approx(3.0, abs=0.1)


def test_bad_flags_are_refused(capsys):
    with pytest.raises(SystemExit):
        main(["--lumps", "2"])
    assert ">= 4" in capsys.readouterr().err
    with pytest.raises(SystemExit):
        main(["--viscosity", "-1"])
    assert ">= 0 Pa s" in capsys.readouterr().err
