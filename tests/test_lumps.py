"""Field strings as three lumps, against the uniform shaft, and rigs by name."""

from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq

from drillrig_env import Friction, Rig
from drillrig_env.lumps import STEEL, Mud, Tube
from drillrig_env.model import jacobian, motor_power, steady_state
from drillrig_env.rig import RIGS
from drillrig_env.stability import critical_slope, critical_speed

PIPE, COLLARS, TOP = (2300.0, 0.127, 0.1086), (200.0, 0.1715, 0.0714), 2900.0
DOCS = Path(__file__).parents[1] / "docs" / "rigs"


def string(**changes):
    return Rig.from_string(**{"pipe": PIPE, "collars": COLLARS, "top_drive": TOP, "k_p": 38e3, "k_i": 1e5, **changes})


def test_inertia_and_stiffness_are_those_of_the_steel():
    rig, pipe, collars = string(), Tube(*PIPE), Tube(*COLLARS)
    total = pipe.inertia(7850.0) + collars.inertia(7850.0) + TOP
    assert pytest.approx(total, rel=1e-12) == rig.J_1 + rig.J_2 + rig.J_3
    assert 1 / rig.k_1 + 1 / rig.k_2 == pytest.approx(1 / pipe.stiffness(79.3e9), rel=1e-12)
    # A ring of mass m at radius r has the inertia m r^2, and twists a length l by T l / (G J).
    thin = Tube(3.0, 0.2, 0.1999)
    mass = 7850.0 * np.pi / 4 * (0.2**2 - 0.1999**2) * 3.0
    assert thin.inertia(7850.0) == pytest.approx(mass * 0.1**2, rel=2e-3)


@pytest.mark.parametrize("length", [500.0, 2300.0, 5000.0])
def test_the_lowest_mode_is_that_of_the_uniform_shaft(length):
    """A uniform shaft with its top held and a mass at its end, within 3 %."""
    pipe, collars = Tube(length, *PIPE[1:]), Tube(*COLLARS)
    wave, end = np.sqrt(79.3e9 / 7850.0), collars.inertia(7850.0) / (7850.0 * pipe.polar_moment)
    exact = brentq(lambda w: end * w / wave * np.tan(w * length / wave) - 1.0, 1e-9, 0.999 * np.pi / 2 * wave / length)
    lowest, _ = string(pipe=pipe).string_frequencies
    assert 2 * np.pi * lowest == pytest.approx(exact, rel=0.03)


def test_units_of_inertia_and_of_stiffness_scale():
    once, twice = (
        string(),
        string(density=2 * STEEL["density"], shear_modulus=2 * STEEL["shear_modulus"], top_drive=2 * TOP),
    )
    for name in ("J_1", "J_2", "J_3", "k_1", "k_2", "d_1", "d_2"):
        assert getattr(twice, name) == 2 * getattr(once, name)


@pytest.mark.parametrize("outer", [0.1, 0.19])
def test_the_drag_of_mud_is_that_of_flow_between_two_cylinders(outer):
    """Against the equation of the flow, d/dr (r^3 d(v/r)/dr) = 0, solved by differences from wall to wall."""
    mud, tube = Mud(0.04, 0.2), Tube(7.0, outer)
    r = np.linspace(outer / 2, mud.hole / 2, 4001)
    resistance = (1.0 / (0.5 * (r[1:] + r[:-1])) ** 3 * np.diff(r)).sum()  # of v/r to a torque, over 2 pi mu
    assert mud.drag(tube) == pytest.approx(2 * np.pi * mud.viscosity * tube.length / resistance, rel=1e-5)


def test_mud_takes_as_much_from_the_lumps_as_from_the_string():
    mud, speed, friction = Mud(0.05, 0.2159), 9.0, Friction(18000.0, 0.5, 0.3, 0.2)
    plain, rig = string(), string(mud=(0.05, 0.2159))
    drag = mud.drag(Tube(*PIPE)) + mud.drag(Tube(*COLLARS))
    assert rig.C_1 > rig.C_2 > rig.C_m > 0.0
    power = [motor_power(each, steady_state(each, friction, speed)) for each in (plain, rig)]
    assert power[1] - power[0] == pytest.approx(drag * speed**2, rel=1e-9)
    assert string(mud={"viscosity": 0.0, "hole": 0.3}) == string(mud=None) == plain
    assert critical_slope(rig) < critical_slope(plain)  # friction may fall more before steady rotation is lost


def test_the_string_of_2500_m_has_the_numbers_that_were_worked_out_for_it():
    rig = Rig.preset("field_2500m")
    modes = np.linalg.eigvals(jacobian(rig))
    assert sorted(modes.imag[modes.imag > 0.5])[:2] == pytest.approx([1.382, 4.217], abs=1e-3)
    assert critical_slope(rig) == pytest.approx(-10.820638, abs=1e-6)
    assert critical_speed(rig, Friction(18000.0, 0.5, 0.3, 0.2)) == pytest.approx(20.98898, abs=1e-4)
    assert rig == Rig.from_toml(DOCS / "field_2500_m.toml") == Rig.of("field_2500m")
    made = string(loss_time=20.0 / 819.0)
    for item in fields(Rig):
        assert getattr(made, item.name) == pytest.approx(getattr(rig, item.name), rel=3e-3)
    assert Rig.preset("laboratory") == Rig()
    assert set(RIGS) == {"laboratory", "field_2500m"}


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"pipe": (2300.0, 0.1, 0.2)}, "inner = 0.2 m is not allowed; allowed: < outer = 0.1 m$"),
        ({"pipe": (0.0, 0.127, 0.1)}, "length = 0.0 m"),
        ({"collars": (200.0,)}, "length, outer, inner"),
        ({"collars": 200.0}, "length, outer, inner"),
        ({"collars": {"length": 200.0, "outside": 0.2}}, "length, outer, inner"),
        ({"top_drive": -1.0}, "top_drive = -1.0 kg m\\^2"),
        ({"density": "7850"}, "density = '7850' is text"),
        ({"shear_modulus": 0.0}, "shear_modulus = 0.0 Pa"),
        ({"loss_time": float("nan")}, "loss_time = nan s"),
        ({"k_i": 0.0}, "k_i = 0.0 V/rad"),
        ({"mud": (-0.1, 0.3)}, "viscosity = -0.1 Pa s is not allowed; allowed: >= 0"),
        ({"mud": (0.1, 0.0)}, "hole = 0.0 m"),
        ({"mud": (0.1, 0.15)}, "hole = 0.15 m is not allowed; allowed: > outer = 0.1715 m"),
        ({"mud": 0.03}, "viscosity in Pa s, hole in m"),
        ({"mud": {"viscosity": 0.03}}, "viscosity in Pa s, hole in m"),
    ],
)
def test_what_is_no_string_is_refused(changes, words):
    with pytest.raises(ValueError, match=words):
        string(**changes)


def test_an_unknown_name_gets_the_nearest():
    with pytest.raises(ValueError, match="rig 'field_2500' is not known; did you mean field_2500m"):
        Rig.of("field_2500")
    with pytest.raises(FileNotFoundError, match=r"no_such\.toml"):
        Rig.of("no_such.toml")
