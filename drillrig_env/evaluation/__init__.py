"""The comparison: suites of rigs, scores of an episode, statistics over episodes, table and pictures."""
