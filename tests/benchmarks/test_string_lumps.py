"""The chain of many lumps that three are judged by."""

import numpy as np
import pytest

from benchmarks.string_lumps import COLLARS, FRICTION, PIPE, TOP, Chain, main, period_and_peak
from drillrig_env.lumps import STEEL
from drillrig_env.model import jacobian


def test_a_chain_holds_all_of_the_steel_whatever_its_number_of_lumps():
    for lumps in (5, 13, 80):
        chain = Chain(lumps, FRICTION)
        total = PIPE.inertia(STEEL["density"]) + COLLARS.inertia(STEEL["density"]) + TOP
        assert chain.J.sum() == pytest.approx(total)
        compliance = 1 / PIPE.stiffness(STEEL["shear_modulus"]) + 1 / COLLARS.stiffness(STEEL["shear_modulus"])
        assert (1 / chain.k).sum() == pytest.approx(compliance)


def test_its_modes_settle_with_the_number_of_lumps_close_to_those_of_three():
    def lowest(matrix):
        modes = np.linalg.eigvals(matrix)
        return np.abs(modes.imag[np.abs(modes.imag) > np.abs(modes.real)]).min()

    found = [lowest(Chain(lumps, FRICTION).matrix) for lumps in (20, 40, 80)]
    assert abs(found[2] - found[1]) < abs(found[1] - found[0]) < 1e-3
    assert lowest(jacobian(Chain(80, FRICTION).rig)) == pytest.approx(found[2], rel=0.03)


def test_period_and_peak_are_those_of_a_known_wave():
    times = np.arange(0.0, 60.0, 0.005)
    speed = np.maximum(0.0, 10.0 * np.sin(2 * np.pi * times / 4.7))
    period, peak = period_and_peak(times, speed)
    assert (period, peak) == (pytest.approx(4.7, abs=2e-3), pytest.approx(10.0, abs=1e-3))
    with pytest.raises(ValueError, match="does not stick and slip"):
        period_and_peak(times, np.full(times.shape, 8.0))


def test_rotation_without_friction_goes_to_the_reference():
    chain = Chain(6, type(FRICTION)(0.0, 0.5, 0.3, 0.2))
    assert chain.bit_speed(3.0, np.array([0.0, 300.0]))[-1] == pytest.approx(3.0, abs=1e-2)


def test_bad_flags_are_refused(capsys):
    with pytest.raises(SystemExit):
        main(["--lumps", "2"])
    assert ">= 4" in capsys.readouterr().err
