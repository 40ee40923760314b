"""A trained policy: its model, frames, environment and run folder."""
