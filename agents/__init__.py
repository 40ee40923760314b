"""Learning agents: PPO and SAC from Stable-Baselines3 on the project's own vector environment."""
