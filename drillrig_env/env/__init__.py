"""The Gymnasium environment `DrillRig-v0`: one batch core with three thin variants."""
