"""From a logger's records to a rig and its friction, with what is known of them and what is not.

See docs/calibrate.md. `records` reads what loggers write, `calibrate` fits, and `Posterior` reads back the folder that
`drillrig calibrate` writes. The names load when they are first used: a controller at a rig reads records without SciPy.
"""

from typing import TYPE_CHECKING

from drillrig_env.lazy import loaded_when_used

if TYPE_CHECKING:
    from drillrig_env.calibrate.calibration import Calibration, calibrate
    from drillrig_env.calibrate.laws import choose_law
    from drillrig_env.calibrate.posterior import JUDGED, TRAINING, Posterior
    from drillrig_env.calibrate.records import Record, read_record

__all__ = ["JUDGED", "TRAINING", "Calibration", "Posterior", "Record", "calibrate", "choose_law", "read_record"]

__getattr__, __dir__ = loaded_when_used(
    __name__,
    {
        "Calibration": "drillrig_env.calibrate.calibration",
        "JUDGED": "drillrig_env.calibrate.posterior",
        "Posterior": "drillrig_env.calibrate.posterior",
        "Record": "drillrig_env.calibrate.records",
        "TRAINING": "drillrig_env.calibrate.posterior",
        "calibrate": "drillrig_env.calibrate.calibration",
        "choose_law": "drillrig_env.calibrate.laws",
        "read_record": "drillrig_env.calibrate.records",
    },
)
