import numpy as np
import pytest

from drillrig_env import Friction, simulate

RPM = 60.0 / (2.0 * np.pi)


@pytest.fixture(scope="session")
def run():
    """Stick-slip of the chapter's rig from rest, 12 s at 50 Hz."""
    return simulate(friction=Friction(25.0), speed_reference=3.14, duration=12.0, sample_period=0.02)


@pytest.fixture(scope="session")
def table(run):
    """Its time, bit speed and top speed with the six digits that loggers write."""
    return np.round(np.column_stack([run.time, run.bit_speed, run.top_speed]), 6)


@pytest.fixture
def write(tmp_path):
    """Write a text file of names and rows; its path."""

    def write(names, columns, separator=",", decimal=".", encoding="utf-8", end="\n", above=(), below=(), quote=""):
        def cells(row):
            return separator.join(f"{quote}{cell}{quote}" for cell in row)

        rows = [
            [value if isinstance(value, str) else f"{value:.6f}".replace(".", decimal) for value in row]
            for row in zip(*columns, strict=True)
        ]
        lines = [*above, *([cells(names)] if names else []), *below, *(cells(row) for row in rows), ""]
        path = tmp_path / "run.csv"
        path.write_bytes(end.join(lines).encode(encoding))
        return path

    return write
