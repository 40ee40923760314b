"""The impedance of a rig against its matrices: eigenvalues, transfer function and eigenvectors."""

from fractions import Fraction

import numpy as np
import pytest

from drillrig_env import Rig
from drillrig_env.model import friction_input, jacobian
from drillrig_env.stability.impedance import impedance, impedance_fraction, mode_shape

RIGS = [
    Rig(),
    Rig(J_1=0.01, J_2=0.05, k_1=2.0, d_1=0.001, k_p=0.7, k_i=2.5, K_E=0.01, L=0.02),
    Rig(d_1=0.0, d_2=0.0, C_m=0.0, K_E=0.0),
]
FREQUENCIES = np.array([0.3j, 2.7j, 11.0j, 0.4 + 3.0j, -0.2 + 50.0j])


@pytest.mark.parametrize("rig", RIGS)
def test_transfer_function_from_friction_torque_to_bit_speed_is_minus_its_inverse(rig):
    Z, derivative = impedance(rig, FREQUENCIES)
    answers = [np.linalg.solve(s * np.eye(7) - jacobian(rig), friction_input(rig))[2] for s in FREQUENCIES]
    np.testing.assert_allclose(-1.0 / Z, answers, rtol=1e-9)
    step = 1e-6
    difference = (impedance(rig, FREQUENCIES + step)[0] - impedance(rig, FREQUENCIES - step)[0]) / (2 * step)
    np.testing.assert_allclose(derivative, difference, rtol=1e-6)


@pytest.mark.parametrize("rig", RIGS)
def test_fraction_of_polynomials_is_the_impedance(rig):
    fraction = impedance_fraction(rig)
    D, E = (np.array([float(value) for value in part]) for part in (fraction.D, fraction.E))
    assert (len(D), len(E)) == (8, 6)
    assert (D >= 0).all()
    assert (E >= 0).all()
    quotient = np.polyval(D[::-1], FREQUENCIES) / (FREQUENCIES * np.polyval(E[::-1], FREQUENCIES))
    np.testing.assert_allclose(quotient, impedance(rig, FREQUENCIES)[0], rtol=1e-9)


@pytest.mark.parametrize("rig", RIGS)
def test_characteristic_polynomial_vanishes_at_the_eigenvalues_and_modes_are_eigenvectors(rig):
    slope = -0.03
    polynomial = [float(value) for value in impedance_fraction(rig).characteristic(Fraction(slope))]
    values = np.linalg.eigvals(jacobian(rig, slope))
    scale = np.polyval(np.abs(polynomial)[::-1], np.abs(values))
    assert (np.abs(np.polyval(polynomial[::-1], values)) < 1e-10 * scale).all()
    for value in values:
        mode = mode_shape(rig, np.array(value))
        assert mode[2] == pytest.approx(1.0, abs=1e-14)
        np.testing.assert_allclose(jacobian(rig, slope) @ mode, value * mode, atol=1e-6 * np.abs(value * mode).max())


def test_torques_and_time_of_another_size_scale_it_to_the_last_bit():
    """Twice as slow and 2^20 times the torque: Z(s) of a rig, a torque over a speed, follows."""
    rig, torque, time = RIGS[1], 2.0**20, 2.0
    scaled = Rig(
        **{name: getattr(rig, name) * torque * time**2 for name in ("J_1", "J_2", "J_3")},
        **{name: getattr(rig, name) * torque * time for name in ("d_1", "d_2", "C_m")},
        **{name: getattr(rig, name) * torque for name in ("k_1", "k_2", "K_T", "T_f", "r_1")},
        **{name: getattr(rig, name) * time for name in ("L", "K_E", "k_p")},
        k_i=rig.k_i,
        R=rig.R,
    )
    np.testing.assert_array_equal(
        impedance(scaled, FREQUENCIES / time)[0], torque * time * impedance(rig, FREQUENCIES)[0]
    )
