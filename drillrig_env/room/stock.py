"""What a page may choose from: rigs and policies by name, fixed when the server starts; no page adds to it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

from drillrig_env.friction import Friction
from drillrig_env.parameters import closest
from drillrig_env.policy import PolicySource, find_policy
from drillrig_env.policy.finding import installed_names
from drillrig_env.rig import RIGS, Rig
from drillrig_env.room.shipped import ShippedAgent, shipped_agents
from drillrig_env.room.strangers import named

OWN_RIG = "own"
"""The name of the rig that the command line gives."""


@dataclass(frozen=True)
class Stock:
    """Rigs and policies by name, and the friction that is given at the command line, None for each rig's own.

    `rig` is the name of the one to begin with.
    """

    rigs: dict[str, Rig]
    policies: dict[str, PolicySource]
    rig: str
    friction: Friction | None = None
    left_out: dict[str, str] = field(default_factory=dict)  # names of policies, and why they are not there

    @classmethod
    def of(cls, rig: Rig | None = None, friction: Friction | None = None, policies: Sequence[str] = ()) -> Stock:
        """The rigs with a name and `rig`; the installed policies but slow ones, the shipped agents, and `policies`.

        `policies` are names or FILE.py:CLASS as `find_policy` takes them. `ValueError` for one that is not there, that
        cannot be read, or that is called as another one is.
        """
        rigs = {name: Rig.preset(name) for name in RIGS}
        begun = next((name for name, known in rigs.items() if known == rig), OWN_RIG) if rig else next(iter(rigs))
        if rig and begun == OWN_RIG:
            rigs[OWN_RIG] = rig
        found, left_out = {}, {}
        for name in installed_names():
            try:
                with named(name):
                    source = find_policy(name)
            except ValueError as error:
                left_out[name] = str(error)
                continue
            if not source.slow:
                found[name] = source
        for name in shipped_agents():
            found[name] = PolicySource(name, {"": partial(ShippedAgent, name)}, {"kind": "shipped"})
        for name in policies:
            with named(f"policy {name!r} cannot be read"):
                source = find_policy(name)
            if found.setdefault(short := _short(name), source).about != source.about:
                raise ValueError(f"policy {name!r}: there is another one that is called {short}; rename its class")
        return cls(rigs, found, begun, friction, left_out)

    def policy(self, name: Any) -> PolicySource:
        """A policy by name. `ValueError` for one that is not there, with the closest."""
        if not isinstance(name, str) or name not in self.policies:
            raise ValueError(f"control room: policy {name!r} is not known here; {closest(name, self.policies)}")
        return self.policies[name]

    def check_rig(self, rig: Rig) -> None:
        """Raise `ValueError` for a rig that is none of the stock's, whatever the gains of its drive."""
        if all(replace(known, k_p=rig.k_p, k_i=rig.k_i) != rig for known in self.rigs.values()):
            raise ValueError(
                "the recorded run: its rig is none of this room's; start the room with it: drillrig room --replay FILE"
            )

    def rig_named(self, name: Any) -> Rig:
        """A rig by name. `ValueError` for one that is not there, with the closest."""
        if not isinstance(name, str) or name not in self.rigs:
            raise ValueError(f"control room: rig {name!r} is not known here; {closest(name, self.rigs)}")
        return self.rigs[name]


def _short(name: str) -> str:
    """What a policy is called in the page: of a file its class, whose path is nobody's business."""
    return name.rpartition(":")[2]
