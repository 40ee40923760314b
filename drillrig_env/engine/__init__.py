"""Where pieces of work are done: in this process, in processes beside it, or on a Ray cluster; the result is the same.

    with engine_at("ray") as engine:
        for number, result in engine.each(work, pieces):
            ...

Who cuts work into pieces cuts it by what the work is, never by where it is done, and a piece's seeds follow from what
it is. Then the same pieces give the same bits in any order, on any number of workers.
"""

from drillrig_env.engine.choice import LOCAL, engine_at, used
from drillrig_env.engine.contract import Engine, Outcome
from drillrig_env.engine.local import Local

__all__ = ["LOCAL", "Engine", "Local", "Outcome", "engine_at", "used"]
