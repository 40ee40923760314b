"""The benchmark over the wire: the same rigs in the arena and behind the line, and its page."""

import pytest

from benchmarks.line_of_twins import Sort
from benchmarks.over_the_wire import Played, arena, main, over_the_wire

pytest.importorskip("onnxruntime")


def test_the_arena_is_the_suites():
    from drillrig_env.evaluation import runner, suites
    from drillrig_env.policy import find_policy

    suite = suites.default_suite(6)
    episodes = runner.run(find_policy("lqg").make(sensors="surface"), suite, sensors="surface")
    window = slice(-100, None)
    low, high = episodes.lowest[:, window].min(axis=1), episodes.highest[:, window].max(axis=1)
    mean = episodes.average[:, window].mean(axis=1)
    calm = high - low < 0.2 * mean
    assert arena("lqg", "surface", 6).tolist() == (calm & (abs(mean / episodes.speed_target - 1.0) <= 0.05)).tolist()


@pytest.mark.slow
def test_rigs_are_played_over_the_wire_and_told_of(tmp_path):
    page = tmp_path / "page.md"
    assert main(["--policy", "constant", "--sensors", "surface", "--rigs", "2", "--output", str(page)]) == 0
    text = page.read_text()
    assert "| perfect |" in text
    assert "watchdog of 10 periods" in text
    dead = Played(Sort(loss=1.0))
    over_the_wire("constant", "surface", dead.sort, 1, 1000.0, dead)
    assert (len(dead.mitigated), dead.tripped) == (1, 1)
