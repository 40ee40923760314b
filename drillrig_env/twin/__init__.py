"""A simulated rig in the place of hardware: in the same process (`dry_run`), or in one of its own behind a line."""
