"""A sweep on Ray
==============

One law, ``z_torque``, over its gain and the age of what it measures: twenty pieces of work that know nothing of each
other. An engine does them here, on an instance of Ray that it starts, or on a cluster, with the same bits. The script's
argument says where, as ``--on`` does: local, ray, auto or ray://HOST:PORT. Ray comes with the extra ``scale``; without
it the pieces are done here.
"""

import sys
from dataclasses import replace
from importlib.util import find_spec

import matplotlib.pyplot as plt
import numpy as np

from baselines import make
from drillrig_env.engine import engine_at
from drillrig_env.evaluation.runner import run
from drillrig_env.evaluation.scores import score
from drillrig_env.evaluation.suites import suite

where = sys.argv[1] if len(sys.argv) > 1 else "ray" if find_spec("ray") else "local"
gains, delays = (1.0, 2.0, 4.0, 6.0, 8.0), (0, 1, 2, 4)  # rad/s per N m; control steps of 0.1 s
rigs = suite("default", rigs=50)


def mitigated(piece):
    """Share of the rigs that a gain brings calm to their target, where the measurements are some steps old."""
    gain, delay = piece
    late = replace(rigs, env={"delay": delay})
    return score(run(make("z_torque", gain=gain), late))["mitigated"].mean()


# %%
# ``engine.map`` keeps the order of the pieces; ``engine.each`` hands over each as it is done.

if __name__ == "__main__":
    with engine_at(where, jobs=2 if where == "ray" else None) as engine:
        found = engine.map(mitigated, [(gain, delay) for gain in gains for delay in delays])
    shares = np.reshape(found, (len(gains), len(delays)))
    print(f"done at: {where}", shares.round(2), sep="\n")

    fig, ax = plt.subplots(figsize=(6, 3.2))
    image = ax.imshow(shares, vmin=0, vmax=1, cmap="viridis", aspect="auto", origin="lower")
    ax.set_xticks(range(len(delays)), [f"{0.1 * delay:.1f}" for delay in delays])
    ax.set_yticks(range(len(gains)), [f"{gain:g}" for gain in gains])
    ax.set(title="The later the measurement, the less gain helps", xlabel="delay, s", ylabel="gain, rad/s per N m")
    fig.colorbar(image, label="share of 50 rigs mitigated")
    fig.tight_layout()
    plt.show()
