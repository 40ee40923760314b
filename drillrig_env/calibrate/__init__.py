"""From a measured record to the model: compare, score."""
