"""The contact record: one way to make it, whether for one rig, for many, or within a kernel."""

import numpy as np

from drillrig_env import Friction, Rig
from drillrig_env.friction import CONTACT, Contact
from drillrig_env.friction.contact import EXPONENTIAL
from drillrig_env.friction.law import contacts_of, press, torque_in_zone, zone_of

RIG = Rig(r_1=0.05, omega_s=2e-3)


def test_record_holds_torques_decay_stick_zone_and_speed_reference():
    (record,) = Friction(20.0, 0.6, 0.3, 1.2).contacts(RIG, 2.5)
    contact = Contact(*record.item())
    of_the_pin, of_a_tilt = contact[:10], contact[10:]
    np.testing.assert_allclose(of_the_pin, (0.6, 0.3, 1.2, 2e-3, 2.5, np.inf, 1.0, 0.6, 0.3, EXPONENTIAL), rtol=1e-15)
    assert not any(of_a_tilt)
    assert (contact.static, contact.omega_s) == (record["static"], record["omega_s"])


def test_batch_has_a_record_a_rig():
    friction = Friction(np.array([10.0, 20.0]), 0.5, 0.3, np.array([1.0, 2.0]))
    records = friction.contacts(RIG, np.array([1.0, 3.0]))
    for i, (force, v_b, speed) in enumerate([(10.0, 1.0, 1.0), (20.0, 2.0, 3.0)]):
        assert records[i] == Friction(force, 0.5, 0.3, v_b).contacts(RIG, speed)[0]
    assert Friction(10.0).contacts(RIG, 1.0, rigs=3).tolist() == [Friction(10.0).contacts(RIG, 1.0)[0].item()] * 3


def test_kernels_press_the_pin_as_friction_does():
    (record,) = Friction(20.0, 0.6, 0.3, 1.2).contacts(RIG, 2.5)
    pressed = np.zeros(1, dtype=CONTACT)
    pressed["speed_reference"] = 2.5
    press.py_func(pressed.view(np.recarray)[0], 20.0, 0.6, 0.3, 1.2, RIG.r_1, 2e-3, EXPONENTIAL)
    assert pressed[0] == record


def test_law_is_the_same_for_plain_numbers_and_for_arrays():
    friction, speeds = Friction(20.0), np.array([-3.0, -1e-4, 0.0, 1e-3, 2e-3, 4.0])
    contact = Contact(*friction.contacts(RIG, 0.0)[0].item())
    pairs = [torque_in_zone.py_func(zone_of.py_func(x_3, RIG.omega_s, contact.knee), x_3, contact) for x_3 in speeds]
    np.testing.assert_allclose(friction.torque(RIG, speeds), [torque for torque, _ in pairs], rtol=1e-14)
    np.testing.assert_allclose(friction.slope(RIG, speeds), [slope for _, slope in pairs], rtol=1e-14)


def test_contact_without_a_speed_reference_is_that_of_a_drive_at_rest():
    assert contacts_of(RIG, 20.0, 0.6, 0.3, 1.2) == Friction(20.0, 0.6, 0.3, 1.2).contacts(RIG, 0.0)[0]
