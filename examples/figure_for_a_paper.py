"""A figure for a paper
====================

The bifurcation diagram of a rig, drawn by the project's own figures in print size, with its caption as text.
``drillrig figures --rig my_rig.toml --only 4.12`` writes the same files from the command line.
"""

from pathlib import Path
from tempfile import mkdtemp

import matplotlib.pyplot as plt

from drillrig_env import Friction, Rig, stability
from drillrig_env.plots.figures import write

folder = Path(mkdtemp())
print(*write(folder, ["4.12"]), *sorted(path.name for path in folder.iterdir()))
print((folder / "captions.md").read_text(encoding="utf-8"))

# %%
# Or from the numbers, for a figure of your own: branches of equilibria and orbits over the speed reference.

diagram = stability.bifurcation_diagram(Rig(), Friction(normal_force=20.0), points=60)
print({name: round(float(value), 3) for name, value in diagram.special.items()})
p1, e = diagram.p1.table(), diagram.equilibria
fig, ax = plt.subplots(figsize=(6.5, 3.2))
calm = e[(e["branch"] == "e2") & e["stable"]]
ax.plot(calm["speed_reference"], calm["state"][:, 2], "tab:blue", label="calm rotation, stable")
ax.fill_between(
    p1["speed_reference"],
    p1["lowest_bit_speed"],
    p1["highest_bit_speed"],
    color="tab:orange",
    alpha=0.4,
    label="stick-slip",
)
for name in ("H2", "fold"):
    ax.axvline(diagram.special[name], color="0.4", ls=":", lw=0.8)
    ax.text(diagram.special[name], ax.get_ylim()[1], f" {name}", va="top", fontsize=8)
ax.set(title="Between H2 and fold both are stable", xlabel="speed reference, rad/s", ylabel="bit speed, rad/s")
ax.legend(loc="center left")
fig.tight_layout()
plt.show()
