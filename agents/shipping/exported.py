"""The former place of `drillrig_env.deploy.policy_file.PolicyFile`."""

from drillrig_env.deploy.policy_file import PolicyFile as ExportedPolicy

__all__ = ["ExportedPolicy"]
