"""Learning agents: PPO and SAC from Stable-Baselines3 on the project's own vector environment."""

from drillrig_env.moved import keep_former_names

keep_former_names(
    {
        "agents.agent": "agents.policy.agent",
        "agents.absolute_action": "agents.policy.absolute_action",
        "agents.environment": "agents.policy.environment",
        "agents.run_folder": "agents.policy.run_folder",
        "agents.schedules": "agents.training.schedules",
        "agents.ship": "agents.shipping.ship",
    }
)
