"""Data sets for offline reinforcement learning: recorded episodes in Minari's format, each set with a card."""
