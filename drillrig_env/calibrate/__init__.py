"""From a logger's records to a rig and its friction, with what is known of them and what is not.

See docs/calibrate.md. `records` reads what loggers write, `calibrate` fits, and `Posterior` reads back the folder that
`drillrig calibrate` writes.
"""

from drillrig_env.calibrate.calibration import Calibration, calibrate
from drillrig_env.calibrate.laws import choose_law
from drillrig_env.calibrate.posterior import JUDGED, TRAINING, Posterior
from drillrig_env.calibrate.records import Record, read_record

__all__ = ["JUDGED", "TRAINING", "Calibration", "Posterior", "Record", "calibrate", "choose_law", "read_record"]
