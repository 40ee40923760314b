"""Rigs of other sizes that the tests share: the chapter's, slower, stronger and turning further; and a field string."""

from dataclasses import replace

from drillrig_env import Rig

FIELD = Rig(
    J_1=182.6,
    J_2=107.2,
    J_3=2954.0,
    k_1=819.0,
    k_2=819.0,
    d_1=20.0,
    d_2=20.0,
    eta=1.0,
    r_1=1.0,
    L=0.01,
    R=1.0,
    K_T=1.0,
    K_E=0.0,
    C_m=0.0,
    T_f=0.0,
    k_p=38e3,
    k_i=100e3,
)
"""A string of 2.5 km as three matched lumps, in units of its top drive's torque."""


def scaled(time=1.0, torque=1.0, angle=1.0, rig=None):
    """A rig with time running so many times slower, torques so many times larger, and angles so many times wider."""
    rig = rig or Rig()
    inertia, damping, stiffness = torque * time**2 / angle, torque * time / angle, torque / angle
    return replace(
        rig,
        J_1=rig.J_1 * inertia,
        J_2=rig.J_2 * inertia,
        J_3=rig.J_3 * inertia,
        k_1=rig.k_1 * stiffness,
        k_2=rig.k_2 * stiffness,
        d_1=rig.d_1 * damping,
        d_2=rig.d_2 * damping,
        omega_s=rig.omega_s * angle / time,
        T_r2=rig.T_r2 * torque,
        r_1=rig.r_1 * torque,
        L=rig.L * time,
        K_T=rig.K_T * torque,
        K_E=rig.K_E * time / angle,
        C_m=rig.C_m * damping,
        C_1=rig.C_1 * damping,
        C_2=rig.C_2 * damping,
        T_f=rig.T_f * torque,
        k_p=rig.k_p * time / angle,
        k_i=rig.k_i / angle,
    )


FAST = scaled(time=1.0 / 6.5)
"""A laboratory rig with a period of 0.36 s, for speeds of 20 rad/s."""

SOFT = replace(Rig(), k_p=0.3, k_i=0.3, K_E=0.5 * Rig().K_E)
"""The chapter's rig on a soft drive, `Drive(0.3, 0.3, back_emf_share=0.5)`."""

TWO_WINDOWS = {
    "L": 0.265, "k_p": 0.0, "k_i": 0.524, "K_E": 0.0, "d_2": 0.0044, "d_1": 0.0922, "J_3": 0.00172, "J_1": 0.0518,
    "J_2": 0.00207, "k_1": 0.0679, "k_2": 10.4,
}  # fmt: skip
"""Changes to the chapter's: a drive that shakes by itself but in two windows of friction slopes."""

STEADY_AND_WINDOW = {
    "L": 0.116, "k_p": 0.0, "k_i": 0.345, "K_E": 0.0, "d_2": 0.00633, "d_1": 0.151, "J_3": 0.00149, "J_1": 0.0586,
    "J_2": 0.00355, "k_1": 0.0247, "k_2": 22.1,
}  # fmt: skip
"""Changes to the chapter's: a rig that turns steadily without friction, and in a window of steeper slopes once more."""
