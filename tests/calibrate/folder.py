"""The folder of a calibration, made without a fit: what others read, with draws around a rig that is known."""

from dataclasses import replace

import numpy as np

from drillrig_env import Friction, Rig
from drillrig_env.calibrate.unknowns import values_of
from drillrig_env.files import json_text, write_text

NAMES = ("J_2", "k_2", "R", "mu_k", "mu_s - mu_k", "v_b")
RIG, FRICTION = replace(Rig(), k_2=0.45, J_2=0.02), Friction(24.0, 0.42, 0.25, 1.3)


def write_folder(folder, rig=RIG, friction=FRICTION, draws=64, deviation=0.03, names=NAMES):
    """Write what `Posterior` reads, and return the folder."""
    folder.mkdir()
    rig.to_toml(folder / "rig.toml")
    friction.to_toml(folder / "friction.toml")
    own = values_of(rig, friction)
    best = np.array([own[name] for name in names])
    values = best * np.exp(deviation * np.random.default_rng(3).standard_normal((draws, len(names))))
    np.savez(folder / "draws.npz", names=np.array(names), values=values)
    rows = {name: {"value": own[name], "low": 0.9 * own[name], "high": 1.1 * own[name]} for name in names}
    write_text(folder / "calibration.json", json_text({"parameters": rows, "load": friction.normal_force}))
    return folder
