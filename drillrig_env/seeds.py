"""Which seeds belong to what, so that nothing is judged on rigs that it was trained, tuned or chosen on.

A rig's draws follow from its seed alone. The ranges have no seed in common, and rig i of a set has the
range's first seed plus i.
"""

from __future__ import annotations

TRAINING_FLEETS, TUNING_FLEETS, EVALUATION_FLEETS, VALIDATION_FLEETS = (
    range(0, 1_000_000),
    range(1_000_000, 2_000_000),
    range(2_000_000, 3_000_000),
    range(3_000_000, 4_000_000),
)
"""Seeds of the fleets (`drillrig_env.fleet`) to learn on, to tune on, to be judged on, and to choose settings by."""

TRAINING_SEEDS = range(0, 500_000_000)
"""Rigs that agents learn on."""

TUNING_SEEDS = range(500_000_000, 600_000_000)
"""Rigs that the parameters of the baselines are searched on."""

VALIDATION_SEEDS = range(600_000_000, 1_000_000_000)
"""Rigs of the evaluations during training, by which the best model and the settings are chosen."""

EVALUATION_SEEDS = range(1_000_000_000, 2_000_000_000)
"""Rigs of the suites: nothing may be trained, tuned or chosen on them."""

DATASET_SEEDS = range(2_000_000_000, 3_000_000_000)
"""Rigs of recorded episodes, which others learn from: no agent of the project has met them, and no suite has them."""
