"""Training: settings, schedules, callbacks, checkpoints, seeds, resume."""
