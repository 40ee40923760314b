"""The documentation; `docs.make` makes the pages that come from results."""

import drillrig_env  # noqa: F401  # ahead of all others: a stop while they are imported ends without a traceback
