"""Rigs of other sizes, on which stability is tested too."""

from dataclasses import replace

from drillrig_env import Drive, Friction, Rig


def faster(rig: Rig, times: float) -> Rig:
    """The rig with time running so many times faster: speeds grow by as much, torques and currents stay."""
    t = 1.0 / times
    return replace(
        rig,
        J_1=rig.J_1 * t**2,
        J_2=rig.J_2 * t**2,
        J_3=rig.J_3 * t**2,
        d_1=rig.d_1 * t,
        d_2=rig.d_2 * t,
        C_m=rig.C_m * t,
        L=rig.L * t,
        K_E=rig.K_E * t,
        k_p=rig.k_p * t,
        omega_s=rig.omega_s / t,
    )


def driven(rig: Rig, drive: Drive) -> Rig:
    """The rig with a drive of its own."""
    return replace(rig, k_p=drive.k_p, k_i=drive.k_i, K_E=drive.remaining_K_E(rig))


LABORATORY, LABORATORY_FRICTION = faster(Rig(), 6.5), Friction(10.0, v_b=1.0 / 6.5)
"""A fast rig for the laboratory: a period of 0.36 s, speeds of 20 rad/s."""

FIELD = Rig(
    J_1=182.6,
    J_2=107.2,
    J_3=2954.0,
    k_1=819.0,
    k_2=819.0,
    d_1=20.0,
    d_2=20.0,
    eta=1.0,
    R=1.0,
    K_T=1.0,
    r_1=1.0,
    K_E=0.0,
    C_m=0.0,
    T_f=0.0,
    L=0.01,
    k_p=38e3,
    k_i=100e3,
)
"""A drill string of 2.5 km in three lumps, its drive with gains in torque per speed and angle."""

FIELD_FRICTION = Friction(9000.0, 1.0, 0.6, 0.2)

SOFT = driven(Rig(), Drive(k_p=0.3, k_i=0.3, back_emf_share=0.5))
"""The chapter's rig with a soft drive."""
