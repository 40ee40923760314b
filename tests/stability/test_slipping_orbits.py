"""The family of slipping orbits: where it begins, that its members obey the rig, and the inverses taken of it."""

from typing import ClassVar

import numpy as np
import pytest

from drillrig_env import Friction, Rig
from drillrig_env.model import jacobian
from drillrig_env.stability import critical_slope, hopf_points
from drillrig_env.stability.harmonic_balance import HarmonicBalance
from drillrig_env.stability.slipping_orbits import MANY_SAMPLES, _ahead, slipping_orbits

RIG = Rig()
FAMILY = slipping_orbits(RIG)


def test_family_begins_at_the_hopf_point():
    point = hopf_points(RIG, Friction(10.0))[1]
    assert FAMILY.depth[0] == 0.0
    assert FAMILY.log_gain[0] == pytest.approx(np.log(-critical_slope(RIG)), abs=1e-12)
    assert FAMILY.frequency[0] == pytest.approx(point.frequency, abs=1e-6)
    assert FAMILY.guess(1e-6) == pytest.approx([FAMILY.log_gain[0], FAMILY.frequency[0]], abs=1e-4)


def test_family_is_followed_to_its_depth_and_no_further():
    assert FAMILY.depth[-1] == 12.0
    assert np.all(np.diff(FAMILY.depth) > 0)
    assert slipping_orbits(RIG, 2.0).depth[-1] == 2.0
    assert len({len(x) for x in (FAMILY.depth, FAMILY.log_gain, FAMILY.frequency, FAMILY.waves)}) == 1
    for depth, wave in zip(FAMILY.depth[1:], FAMILY.waves[1:], strict=True):
        assert wave.min() == pytest.approx(wave[0]) == pytest.approx(-depth)


@pytest.mark.parametrize("depth", [0.3, 2.0, 6.0])
def test_orbit_obeys_the_rig_harmonic_by_harmonic(depth):
    """Each harmonic of q is G times that of exp(-q), times the rig's answer to it, from (i k Omega - A) x = b T."""
    q, frequency, log_gain = FAMILY.orbit(depth)
    response, forcing = np.fft.rfft(q), np.fft.rfft(np.exp(log_gain - q))
    into = np.zeros(7)
    into[2] = -1.0 / RIG.J_1
    assert abs(response[0]) < 1e-9 * abs(response).max()  # the drive's integrator lets the mean be
    for k in (1, 2, 3, 5):
        answer = np.linalg.solve(1j * k * frequency * np.eye(7) - jacobian(RIG), into)[2]
        assert response[k] == pytest.approx(answer * forcing[k], abs=1e-8 * abs(response).max())
    assert q[0] == pytest.approx(-depth, abs=1e-10) == q.min()


def test_orbit_between_those_of_the_family_lies_on_its_splines():
    depth = 3.0 + 0.4 / 12.0
    _, frequency, log_gain = FAMILY.orbit(depth)
    assert FAMILY.guess(depth) == pytest.approx([log_gain, frequency], abs=1e-6)


def test_depths_by_load_and_by_gain_are_inverses():
    inside = FAMILY.depth[1::7]
    gains = FAMILY.guess(inside)[:, 0]
    np.testing.assert_allclose(FAMILY.grazing_depth(gains + inside), inside, atol=1e-6)
    np.testing.assert_allclose(FAMILY.depth_of_gain(gains), inside, atol=1e-6)
    weaker, steeper = FAMILY.log_gain[0] - 1e-6, FAMILY.log_gain[0] + 1.0
    assert np.isnan(FAMILY.grazing_depth(np.array(weaker)))
    assert FAMILY.grazing_depth(np.array(FAMILY.log_gain[0])) == pytest.approx(0.0, abs=1e-9)
    assert FAMILY.depth_of_gain(np.array(steeper)) == 0.0
    assert FAMILY.depth_of_gain(np.array(-100.0)) == pytest.approx(12.0)


def test_slope_of_the_transfer_function_is_its_derivative():
    balance = HarmonicBalance(RIG, 32)
    middle, slope = balance.transfer(2.7)
    difference = (balance.transfer(2.7 + 1e-6)[0] - balance.transfer(2.7 - 1e-6)[0]) / 2e-6
    np.testing.assert_allclose(slope, difference, atol=1e-6 * np.abs(middle).max())
    assert middle[0] == 0.0
    assert middle[-1].imag == 0.0


def test_resolved_waves_have_no_high_harmonics():
    balance = HarmonicBalance(RIG, 64)
    theta = 2 * np.pi * np.arange(64) / 64
    assert balance.is_resolved(np.cos(theta) + 0.1 * np.cos(5 * theta))
    assert not balance.is_resolved(np.cos(theta) + 1e-6 * np.cos(31 * theta))
    assert balance.is_resolved(np.cos(theta) + 1e-6 * np.cos(25 * theta))


@pytest.mark.parametrize(("samples", "first"), [(32, 14), (64, 29), (256, 113)])
def test_high_harmonics_are_the_last_three_or_the_last_eighth(samples, first):
    balance, theta = HarmonicBalance(RIG, samples), 2 * np.pi * np.arange(samples) / samples
    for harmonic, resolved in ((first - 1, True), (first, False), (samples // 2, False)):
        assert balance.is_resolved(np.cos(theta) + 1e-6 * np.cos(harmonic * theta)) == resolved


def test_newtons_method_finds_the_orbit_from_a_wave_of_another_depth():
    """The depth is an equation like the others: it need not hold for the guess."""
    wave = FAMILY.waves[30]
    wanted, frequency, log_gain = FAMILY.orbit(FAMILY.depth[30])
    found = HarmonicBalance(RIG, len(wave)).solve(FAMILY.depth[30], 0.97 * wave, frequency, log_gain)
    np.testing.assert_allclose(found[0], wanted, atol=1e-9)
    assert found[1:] == pytest.approx((frequency, log_gain), abs=1e-9)


def test_each_orbit_is_looked_for_where_the_last_few_lead(monkeypatch):
    """A guess leads to its orbit in a few rounds; that it was a good one shows in nothing else."""
    guesses, found, solve = [], [], HarmonicBalance.solve

    def watched(self, depth, q, frequency, log_gain):
        guesses.append((q, frequency, log_gain))
        found.append(solve(self, depth, q, frequency, log_gain))
        return found[-1]

    monkeypatch.setattr(HarmonicBalance, "solve", watched)
    family = slipping_orbits(Rig(J_2=0.0151), 2.0)
    for i in range(6, len(found)):
        guess, frequency, log_gain = guesses[i]
        np.testing.assert_allclose(guess, found[i][0], atol=2e-4)
        assert (frequency, log_gain) == pytest.approx(found[i][1:], abs=2e-5)
    family.orbit(0.51)  # its nearest neighbour is the one of 6 / 12
    guess, _, _ = guesses[-1]
    np.testing.assert_allclose(guess, 0.51 / family.depth[7] * family.waves[7], rtol=1e-12)


def test_what_a_step_changes_where_the_bit_is_fast_need_not_be_solved_for():
    """Deep orbits are solved for where friction is felt alone, and are those of all equations."""
    family = slipping_orbits(Rig(J_2=0.0151), 40.0)
    depth = float(family.depth[-1])
    wave, frequency, log_gain = family.orbit(depth)
    balance = HarmonicBalance(family.rig, len(wave))
    response, _ = balance.transfer(frequency)
    answer = np.fft.irfft(response * np.fft.rfft(np.exp(log_gain) * np.expm1(-wave)), len(wave))
    assert np.mean(np.exp(-wave - depth) > 1e-10) < 0.6
    np.testing.assert_allclose(wave, answer, atol=1e-9 * depth)


@pytest.mark.filterwarnings("ignore::RuntimeWarning")  # what diverges overflows
def test_no_orbit_is_said_where_newton_finds_none():
    with pytest.raises(FloatingPointError, match=r"no orbit of depth 5 found with 16 samples"):
        HarmonicBalance(RIG, 16).solve(5.0, FAMILY.waves[60][:: len(FAMILY.waves[60]) // 16], 2.0, FAMILY.log_gain[1])


class Unresolved:
    """Finds every orbit at the first guess, and resolves none."""

    tried: ClassVar[list[int]] = []

    def __init__(self, rig, samples):
        self.tried.append(samples)

    def solve(self, depth, q, frequency, log_gain):
        return q, frequency, log_gain

    def is_resolved(self, q):
        return False


def test_orbits_that_are_never_resolved_end_in_a_sentence_before_they_fill_the_memory(monkeypatch):
    """The samples are doubled from 64 on, and a matrix for 2,048 of them fills 32 MB."""
    monkeypatch.setattr("drillrig_env.stability.harmonic_balance.HarmonicBalance", Unresolved)
    with pytest.raises(
        FloatingPointError, match=r"2048 samples do not resolve the orbit of depth 0\.02; check the rig"
    ):
        slipping_orbits(Rig(J_2=0.0213), 1.0, MANY_SAMPLES)
    assert sorted(set(Unresolved.tried)) == [64, 128, 256, 512, 1024, 2048]


def test_rig_without_a_hopf_point_has_no_family():
    with pytest.raises(ValueError, match="never stable: its drive shakes by itself"):
        slipping_orbits(Rig(k_p=0.0, k_i=5.0, K_E=0.0, C_m=0.0))


def test_a_guess_goes_on_along_the_last_few_but_for_the_flat_beginning():
    orbits = [np.array([value]) for value in (7.0, 2.0, 6.0)]
    assert _ahead(5.0, [0.0, 1.0, 3.0], orbits) == [10.0]
    assert _ahead(5.0, [0.0, 1.0], orbits[:2]) == [2.0]
    depths = [0.0, 0.5, 1.0, 1.5, 2.5, 3.0]
    quartic = np.polynomial.Polynomial([1.0, -2.0, 0.5, 0.1, 0.3])
    assert _ahead(3.5, depths, [np.array([quartic(depth)]) for depth in depths]) == pytest.approx([quartic(3.5)])
    assert _ahead(4.0, depths, [*[np.zeros(4)] * 4, np.full(8, 1.0), np.full(8, 2.0)]) == pytest.approx(np.full(8, 4.0))


def test_grazing_is_known_up_to_the_deepest_orbit():
    depths, products, radii = FAMILY._at_grazing
    assert depths[-1] == FAMILY.depth[-1]
    assert depths[0] > 0.0
    assert len(depths) == len(products) == len(radii)
