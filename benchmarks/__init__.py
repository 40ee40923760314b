"""Speed against peers: commands, never tests. Quote ratios from one run, not single times."""
