"""The benchmark of large evaluations: its tables, and what it reckons for larger clusters."""

from benchmarks.scale import evaluated, expected, tabulate
from drillrig_env.engine import Local


def test_an_evaluation_is_timed_with_what_it_leaves_on_disk():
    found = evaluated(Local(), 8)
    assert found["rigs"] == 8
    assert found["seconds"] > 0.0
    assert 100.0 < found["bytes_a_rig"] < 1e5


def test_tables_show_what_was_measured(capsys):
    size = {"rigs": 10_000, "seconds": 20.0, "bytes_a_rig": 170.0, "memory_B": 4e8}
    tabulate({1: {"start_s": 6.0, "piece_s": 1e-3, "10000": size}, 2: {"start_s": 7.0}})
    said = capsys.readouterr().out
    assert "| 10,000 | 20.0 | 500 | 400 | - | - | - |" in said
    assert "| a piece without work, ms | 1 | - |" in said


def test_larger_clusters_are_bound_by_their_work_or_by_the_head():
    words = expected({"rigs": 1000, "seconds": 2.0, "bytes_a_rig": 170.0}, 1e-3)
    assert "100 cores: 50 pieces/s by their work, 1,000 by the head; 1,000,000 rigs in 20.0 s at best" in words
    slow = expected({"rigs": 1000, "seconds": 0.5, "bytes_a_rig": 170.0}, 1e-3)
    assert "1,000 cores: 2,000 pieces/s by their work, 1,000 by the head; 1,000,000 rigs in 1.0 s at best" in slow
