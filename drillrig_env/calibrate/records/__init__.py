"""What loggers write, read as records in SI units."""

from drillrig_env.calibrate.records.columns import parse_map
from drillrig_env.calibrate.records.plausible import check_reference
from drillrig_env.calibrate.records.read import read_record
from drillrig_env.calibrate.records.record import SPEEDS, Record

__all__ = ["SPEEDS", "Record", "check_reference", "parse_map", "read_record"]
