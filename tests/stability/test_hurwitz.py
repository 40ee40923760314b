import numpy as np
import pytest
from scipy.optimize import brentq

from drillrig_env import Friction, Rig
from drillrig_env.model import jacobian
from drillrig_env.stability import (
    characteristic_polynomial,
    critical_slope,
    critical_speed,
    eigenvalues,
    hurwitz_matrix,
    hurwitz_minors,
    is_stable,
    minor_polynomials,
)


def random_rigs(count):
    rng = np.random.default_rng(3)
    names = ("J_1", "J_2", "J_3", "k_1", "k_2", "d_1", "d_2", "R", "K_T", "k_p", "k_i")
    default = Rig()
    return [Rig(**{name: getattr(default, name) * rng.uniform(0.7, 1.4) for name in names}) for _ in range(count)]


@pytest.mark.parametrize("slope", [-0.05, -0.0128, 0.0, 0.2])
def test_polynomial_4_22_has_the_eigenvalues_as_roots(slope):
    expected = np.linalg.eigvals(jacobian(Rig(), slope))
    np.testing.assert_allclose(
        np.sort_complex(np.roots(characteristic_polynomial(Rig(), slope))), np.sort_complex(expected), rtol=1e-6
    )


def test_hurwitz_matrix_is_laid_out_as_in_4_23():
    matrix = hurwitz_matrix(np.array([1.0, 1, 2, 3, 4, 5, 6, 7]))
    assert matrix[0].tolist() == [1, 3, 5, 7, 0, 0, 0]
    assert matrix[1].tolist() == [1, 2, 4, 6, 0, 0, 0]
    assert matrix[5].tolist() == [0, 0, 1, 2, 4, 6, 0]
    assert matrix[6].tolist() == [0, 0, 0, 1, 3, 5, 7]


def test_minors_are_polynomials_in_the_slope():
    polynomials = minor_polynomials(Rig())
    for slope in (-0.07, -0.01, 0.03):
        np.testing.assert_allclose([p(slope) for p in polynomials], hurwitz_minors(Rig(), slope), rtol=1e-8)


@pytest.mark.parametrize("rig", [Rig(), *random_rigs(20)])
def test_critical_slope_is_where_an_eigenvalue_crosses(rig):
    crossing = brentq(lambda slope: np.linalg.eigvals(jacobian(rig, slope)).real.max(), -0.1, 0.0, xtol=1e-14)
    assert critical_slope(rig) == pytest.approx(crossing, abs=1e-9)


def test_values_of_an_independent_computation():
    assert critical_slope(Rig()) == pytest.approx(-0.0127986, abs=1e-7)
    assert critical_speed(Rig(), Friction(10.0)) == pytest.approx(1.99491718, abs=1e-8)
    assert critical_speed(Rig(), Friction(20.0)) == pytest.approx(2.6881, abs=5e-5)
    pair = eigenvalues(Rig(), Friction(10.0), 1.99491718)[:2]
    np.testing.assert_allclose(np.abs(pair.imag), 2.69399, atol=1e-4)


def test_stability_changes_at_the_critical_speed_of_a_batch():
    friction = Friction(np.array([5.0, 12.0, 40.0]), 0.55, 0.3, 1.2)
    for speed, row in zip(critical_speed(Rig(), friction), friction.as_array(), strict=True):
        one = Friction(*row.tolist())
        assert is_stable(Rig(), one, speed + 1e-4)
        assert not is_stable(Rig(), one, speed - 1e-4)
        assert eigenvalues(Rig(), one, speed + 1e-4).real.max() < 0 < eigenvalues(Rig(), one, speed - 1e-4).real.max()


def test_weak_friction_leaves_every_speed_stable():
    assert critical_speed(Rig(), Friction(0.5)) == 0.0
    assert critical_speed(Rig(), Friction(0.0)) == 0.0


def test_complex_roots_of_the_minors_are_no_change_of_sign():
    """A rig of which a complex pair of roots has a larger real part than the slope at which an eigenvalue crosses."""
    rig = Rig(J_1=0.28, J_2=0.613, J_3=0.00309, k_1=0.0608, k_2=2.59, d_1=0.0833, d_2=0.0109,
              R=1.07, K_T=4.4, k_p=46.2, k_i=1.73, L=0.0222, K_E=1.85, C_m=0.00156)  # fmt: skip
    roots = np.concatenate([minor.roots() for minor in minor_polynomials(rig)])
    assert roots.real.max() > critical_slope(rig) + 1e-3
    crossing = brentq(lambda slope: np.linalg.eigvals(jacobian(rig, slope)).real.max(), -0.2, 0.0, xtol=1e-14)
    assert critical_slope(rig) == pytest.approx(crossing, abs=1e-6)


def test_rig_that_no_friction_leaves_stable_has_an_infinite_critical_speed():
    """Without back-EMF, viscous loss and proportional gain nothing damps the drive: steady rotation is never stable."""
    rig = Rig(k_p=0.0, k_i=5.0, K_E=0.0, C_m=0.0)
    assert critical_slope(rig) == np.inf
    assert not is_stable(rig, Friction(10.0), 8.0)
    assert critical_speed(rig, Friction(10.0)) == np.inf
    assert critical_speed(rig, Friction(np.array([0.0, 10.0]))).tolist() == [np.inf, np.inf]


def test_eigenvalues_come_by_falling_real_part():
    values = eigenvalues(Rig(), Friction(10.0), 1.0)
    assert np.all(np.diff(values.real) <= 1e-12)
    assert values[0].real > 0.0


def test_critical_speed_is_where_the_law_is_as_steep_as_the_rig_can_bear():
    friction = Friction(np.array([5.0, 12.0, 40.0]), 0.55, 0.3, 1.2)
    np.testing.assert_allclose(
        friction.slope(Rig(), critical_speed(Rig(), friction)), critical_slope(Rig()), rtol=1e-12
    )
