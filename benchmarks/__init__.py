"""Speed against peers: commands, never tests. Quote ratios from one run, not single times."""

import drillrig_env  # noqa: F401  # ahead of all others: a stop while they are imported ends without a traceback
