"""Make the files that come with the package: `python -m drillrig_env.deploy.ship`, in a clone.

python -m drillrig_env.deploy.ship               # all of them
python -m drillrig_env.deploy.ship lqg z_torque
"""

from __future__ import annotations

from collections.abc import Sequence

from drillrig_env.command_line import Parser, command
from drillrig_env.deploy.export import export, policy_to_export
from drillrig_env.deploy.policy_file import SHIPPED

POLICIES = ("ppo", "ppo_surface", "z_torque", "lqg", "jump_ease_estimated", "constant")
"""What is shipped: agents for whole state and surface, and the laws that graphs can hold."""


@command
def main(arguments: Sequence[str] | None = None, prog: str = "python -m drillrig_env.deploy.ship") -> None:
    """Parse the command line, and write the files."""
    parser = Parser(prog=prog, description=__doc__)
    parser.add_argument("policies", nargs="*", metavar="POLICY", help=f"which (default: {', '.join(POLICIES)})")
    chosen = parser.parse_args(arguments)
    for name in chosen.policies:
        if name not in POLICIES:
            parser.error(f"{name} is not shipped; allowed: {', '.join(POLICIES)}")
    for name in chosen.policies or POLICIES:
        path = SHIPPED / f"{name}.onnx"
        export(policy_to_export(name), path, name)
        print(f"{path.name}: {path.stat().st_size / 1024:.0f} kB")


if __name__ == "__main__":
    raise SystemExit(main())
