"""What the chapter shows or states that the model cannot be held to, and why."""

OUT_OF_REACH = (
    (
        "figures 4.2 to 4.6, grey curves",
        "measured speeds of discs and motor",
        "the measured data are not published with the chapter; pictures give no numbers",
    ),
    (
        "table 4.2, (4-10), (4-11)",
        "P_C 0.893 to 0.955 and APL 0.010 to 0.172",
        "both compare with those measurements. `drillrig_env.indicators` has the formulas, and "
        "`python -m drillrig_env.calibrate.measured` applies them to any recording",
    ),
    (
        "figures 4.2, 4.3",
        "start-up at 3.14 and 4.19 rad/s like the measured one",
        "besides the data, N_1 and how the voltage was imposed are not stated",
    ),
    (
        "figure 4.4",
        "phases part and meet again after nearly 10 peaks; stick time and amplitude similar",
        "statements about the distance from the measured curve, without numbers",
    ),
    (
        "figure 4.5",
        "frequency near the measured one, amplitude not met",
        "no number is printed for either; our own frequency is in the table above",
    ),
    (
        "table 3.1",
        "L, R, K_T, K_E, C_m, T_f, k_p, k_i of the motor",
        "the table is in another chapter. An identified motor stands in: it was chosen to reproduce (4-25), both "
        "critical speeds and the fold, so these four numbers do not test the motor",
    ),
    (
        "section 3, figure 3.3",
        "radius r_1 of the brake pin",
        "in another chapter; derived from (4-25) and the printed critical speeds",
    ),
    (
        "appendix A",
        "coefficients and minors as formulas",
        "not part of the chapter; computed here as polynomials, and compared with eigenvalues instead",
    ),
    (
        "figures 4.12, 4.13",
        "amplitudes of p1 and p2, points 1, 2, 3, the fold at 20 N",
        "drawn, not printed as numbers",
    ),
    (
        "section 4.5",
        "temperature of the contact, tilt of disc 1 that varies N_1",
        "named by the chapter as not modelled; not in this model either",
    ),
)
"""Rows of where, what and why."""
