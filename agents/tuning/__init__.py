"""Tuning: hyperparameters looked for by Optuna, in this process or, with Tune's ASHA, on a Ray cluster."""
