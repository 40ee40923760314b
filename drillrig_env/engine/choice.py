"""An engine by the word that `--on` takes."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from drillrig_env.engine.contract import Engine
from drillrig_env.engine.local import Local

LOCAL = "local"

ALLOWED = "local, ray, auto (the cluster of this machine), or ray://HOST:PORT"


def engine_at(where: str = LOCAL, jobs: int | None = None) -> Engine:
    """The engine that `--on` calls `where`, for `jobs` pieces at a time; None is its own measure.

    "local" is this machine: with one job, its own measure, this process. "ray" is an instance of Ray that is started
    and ended here, "auto" the cluster that this machine is part of, and "ray://HOST:PORT" one elsewhere. Raises
    `ValueError` for another word, and `ImportError` where Ray is not installed.
    """
    if where == LOCAL:
        return Local(1 if jobs is None else jobs)
    host, _, port = where.removeprefix("ray://").rpartition(":")
    elsewhere = where.startswith("ray://") and host and port.isascii() and port.isdigit() and 0 < int(port) < 65_536
    if where not in ("ray", "auto") and not elsewhere:
        raise ValueError(f"--on {where} is not known; allowed: {ALLOWED}")
    from drillrig_env.engine.on_ray import OnRay

    return OnRay("local" if where == "ray" else where, jobs)


@contextmanager
def used(engine: Engine | str | None) -> Iterator[Engine]:
    """An engine that is there, which stays, or one by its word, which ends with the block; by default this process."""
    if isinstance(engine, Engine):
        yield engine
        return
    with engine_at(engine or LOCAL) as own:
        yield own
