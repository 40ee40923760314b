import os
import signal
import threading
from pathlib import Path
from time import sleep

import numpy as np
import pytest

from drillrig_env import Friction, Rig, simulate
from drillrig_env.engine import engine_at
from drillrig_env.model import steady_state, wound_up
from drillrig_env.stability import critical_speed, fold_speed, vibration_map
from drillrig_env.stability.vibration_map import (
    BISTABLE,
    CALM,
    VIBRATING,
    load_step_margin,
    region_map,
    simulated_map,
    vibrates,
)

RIG = Rig()


def test_simulated_map_agrees_with_the_curves_away_from_them():
    speeds, forces = np.linspace(0.8, 6.0, 25), np.linspace(4.0, 30.0, 20)
    by_curves, by_simulation = (f(RIG, Friction(), speeds, forces) for f in (region_map, simulated_map))
    frictions = Friction(forces)
    distance = np.minimum(
        np.abs(speeds / critical_speed(RIG, frictions)[:, None] - 1),
        np.abs(speeds / fold_speed(RIG, frictions)[:, None] - 1),
    )
    clear = distance > 0.03
    np.testing.assert_array_equal(by_simulation.region[clear], by_curves.region[clear])
    assert {CALM, BISTABLE, VIBRATING} == set(by_curves.region[clear])


def test_regions_of_known_points():
    found = region_map(RIG, Friction(), np.array([1.5, 2.5, 3.5]), np.array([0.5, 10.0]))
    assert found.region.tolist() == [[CALM, CALM, CALM], [VIBRATING, BISTABLE, CALM]]
    assert (CALM, BISTABLE, VIBRATING) == (0, 1, 2)  # the worse, the higher
    assert region_map(RIG, Friction(), np.array([1e-3, 0.5]), np.array([0.5])).region.tolist() == [[CALM, CALM]]


def test_a_point_on_a_curve_belongs_to_the_calmer_side():
    curves = np.array([critical_speed(RIG, Friction(10.0)), fold_speed(RIG, Friction(10.0))])
    assert region_map(RIG, Friction(), curves, np.array([10.0])).region.tolist() == [[BISTABLE, CALM]]


def test_load_step_margin_is_the_step_that_knocks_a_rig_out():
    margin = load_step_margin(RIG, Friction(), np.array([1.5, 3.0, 8.0]), np.array([10.0]), largest_step=25.0)[0]
    assert margin[0] == 0.0
    assert margin[2] == np.inf
    for step, sticks in ((margin[1] * 1.02, True), (margin[1] * 0.97, False)):
        start = steady_state(RIG, Friction(10.0), 3.0)
        run = simulate(friction=Friction(10.0 + step), initial_state=start, speed_reference=3.0, duration=60)
        assert (np.ptp(run.bit_speed[-1000:]) > 0.6) == sticks


def test_margin_is_nothing_below_the_critical_speed_and_something_on_it():
    border = critical_speed(RIG, Friction(10.0))
    below, on = load_step_margin(RIG, Friction(), np.array([border - 1e-9, border]), np.array([10.0]), halvings=2)[0]
    assert (below, on) == (0.0, 15.0)


def test_impossible_grids_are_refused():
    good = np.array([1.0])
    for analysis in (simulated_map, load_step_margin):
        for bad in (np.array([0.0]), np.array([1.0, np.nan]), np.array([[1.0]]), 1.0):
            with pytest.raises(ValueError, match=r"vibration map: speeds = .* rad/s"):
                analysis(RIG, Friction(), bad, good)
            with pytest.raises(ValueError, match=r"vibration map: forces = .* N"):
                analysis(RIG, Friction(), good, bad)
    with pytest.raises(ValueError, match="largest_step = -1"):
        load_step_margin(RIG, Friction(), np.array([1.0]), np.array([1.0]), largest_step=-1.0)


def test_margin_is_found_to_a_256th_of_the_largest_step():
    margins = load_step_margin(RIG, Friction(), np.linspace(2.4, 4.0, 6), np.array([5.0]), largest_step=25.6)[0]
    tenths = margins / 0.1
    np.testing.assert_allclose(tenths, np.round(tenths), atol=1e-9)
    assert np.any(np.round(tenths) % 2 == 1)


@pytest.mark.parametrize(("speed", "nudge", "shakes"), [(3.2, 0.01, False), (2.6, 0.0, False), (2.6, 0.01, True)])
def test_vibrates_sees_what_grows_from_unstable_rotation(speed, nudge, shakes):
    """Just below the critical speed, 2.688 rad/s at 20 N, a nudge grows slowly: after 50 s it still looks calm."""
    state = steady_state(RIG, Friction(20.0), speed)
    state[2] += nudge
    found = vibrates(RIG, Friction(20.0), np.array([speed]), state[None], 50.0)
    assert found.tolist() == [shakes]
    run = simulate(None, Friction(20.0), state, speed, duration=50.0)
    assert np.ptp(run.bit_speed[-1000:]) < 0.2 * speed


def test_vibrates_needs_time_to_tell():
    with pytest.raises(ValueError, match=r"duration = 40.0 s .*> 40"):
        vibrates(RIG, Friction(20.0), np.array([3.0]), steady_state(RIG, Friction(20.0), 3.0)[None], 40.0)


def test_rows_are_forces_and_columns_speeds():
    speeds, forces = np.array([1.0, 6.0, 7.0]), np.array([2.0, 30.0])
    for made in (region_map, simulated_map):
        found = made(RIG, Friction(), speeds, forces)
        assert found.region.tolist() == [[CALM, CALM, CALM], [VIBRATING, BISTABLE, CALM]]
        np.testing.assert_array_equal(found.speed_reference, speeds)
        np.testing.assert_array_equal(found.normal_force, forces)


@pytest.mark.parametrize(("beyond", "shakes"), [(0.01, False), (-0.01, True)])
def test_vibrates_tells_growth_from_decay_close_to_the_critical_speed(beyond, shakes):
    """The nudge is still there after 100 s, a few per cent smaller or larger."""
    speed = critical_speed(RIG, Friction(20.0)) + beyond
    state = steady_state(RIG, Friction(20.0), speed)
    state[2] += 0.01
    assert vibrates(RIG, Friction(20.0), np.array([speed]), state[None], 100.0).tolist() == [shakes]


@pytest.mark.parametrize(("nudge", "shakes"), [(0.9, False), (1.033, True)])
def test_vibrates_looks_at_the_last_ten_seconds(nudge, shakes):
    """The larger swing dies out as well, but its index falls below 0.1 only within those ten seconds."""
    speed, friction = 2.9, Friction(20.0)
    state = steady_state(RIG, friction, speed)
    state[2] += nudge
    assert vibrates(RIG, friction, np.array([speed]), state[None], 41.0).tolist() == [shakes]
    late = simulate(RIG, friction, state, speed, duration=41.0, sample_period=0.1).bit_speed[-100:]
    assert [np.ptp(part) > 0.2 * part.mean() for part in (late, late[50:])] == [shakes, False]


def test_a_map_starts_each_rig_nudged_and_stuck_four_thousand_at_a_time(monkeypatch):
    starts = []

    def watched(rig, friction, speed, states, duration, threads):
        starts.append((friction, speed, states))
        return np.zeros(len(speed), dtype=bool)

    monkeypatch.setattr("drillrig_env.stability.vibration_map.vibrates", watched)
    simulated_map(RIG, Friction(), np.linspace(1.0, 5.0, 81), np.linspace(5.0, 40.0, 50))
    assert [len(speed) for _, speed, _ in starts] == [4000, 4000, 50, 50]
    for (friction, speed, nudged), (_, _, stuck) in zip(starts[::2], starts[1::2], strict=True):
        nudge = nudged - steady_state(RIG, friction, speed)
        np.testing.assert_allclose(nudge, np.broadcast_to(0.01 * np.eye(7)[2], nudge.shape), atol=1e-12)
        np.testing.assert_array_equal(stuck, wound_up(RIG, friction, speed))


def verdict_of(monkeypatch, bit_speed, duration=60.0):
    """What `vibrates` says of a bit whose speed is any function of time, which the pretended state carries."""

    def pretended(rig, friction, states, speed_reference, *, period, periods, every, threads=None):
        after = period * every * np.arange(1, periods // every + 1)
        samples = np.zeros((len(states), len(after), 7))
        samples[:, :, 0] = states[:, :1] + after
        samples[:, :, 2] = bit_speed(np.round(samples[:, :, 0], 6))
        return samples

    monkeypatch.setattr("drillrig_env.stability.vibration_map.advance_batch", pretended)
    return vibrates(RIG, Friction(20.0), np.array([3.0]), np.zeros((1, 7)), duration).tolist()


@pytest.mark.parametrize("duration", [40.1, 60.0, 120.0])
@pytest.mark.parametrize(
    ("begin", "end", "counts"), [(0.0, 20.0, False), (20.1, 30.0, True), (30.1, 30.1, False), ("end", "end", True)]
)
def test_swings_count_from_20_to_30_seconds_and_in_the_last_ten(monkeypatch, duration, begin, end, counts):
    """Early swings excuse as large ones at the end; what happens in between counts for neither."""
    last = np.round(duration - 10.0 + 0.1, 6)
    begin, end = (last, duration) if begin == "end" else (begin, end)
    for time in {begin, end}:

        def blip(t, time=time):
            return 3.0 + 0.02 * (t == time)

        def two(t, time=time):
            return blip(t, time) + 0.019 * (t == duration)

        early = time < last
        assert verdict_of(monkeypatch, blip, duration) == [counts and not early]
        if early:  # the swing at the end has grown, but where the early one counts
            assert verdict_of(monkeypatch, two, duration) == [not counts]


def test_what_grows_out_of_rounding_is_no_vibration(monkeypatch):
    for swing, shakes in ((0.9e-8, False), (1.1e-8, True), (1e-6, True)):
        assert verdict_of(monkeypatch, lambda t, swing=swing: 3.0 + swing * (t == 60.0)) == [shakes]


def test_a_bit_that_shakes_at_the_end_vibrates_even_if_it_shook_more_before(monkeypatch):
    for swing, shakes in ((0.59, False), (0.61, True)):  # the index is half the swing over the mean
        assert verdict_of(
            monkeypatch, lambda t, swing=swing: 3.0 + (t < 50) + 0.5 * swing * np.cos(np.pi * t / 0.1)
        ) == [shakes]


def test_a_map_in_pieces_is_the_map(tmp_path, monkeypatch):
    """Points do not see each other: pieces of another size, and those of a folder, give the same."""
    speeds, forces = np.linspace(1.0, 5.0, 5), np.linspace(8.0, 20.0, 3)
    whole = simulated_map(RIG, Friction(), speeds, forces, duration=50.0)
    monkeypatch.setattr(vibration_map, "_CHUNK", 4)
    for _ in range(2):
        parts = simulated_map(RIG, Friction(), speeds, forces, duration=50.0, folder=tmp_path)
        np.testing.assert_array_equal(parts.region, whole.region)
        monkeypatch.setattr(vibration_map, "vibrates", None)  # the second time nothing is done
    assert len(list(tmp_path.glob("piece_*.npz"))) == 4
    with pytest.raises(ValueError, match="holds pieces of other work"):
        simulated_map(RIG, Friction(), speeds, forces, duration=51.0, folder=tmp_path)


@pytest.mark.slow
def test_a_large_map_on_ray_is_the_map_of_one_process(tmp_path):
    """400 x 400 points by two workers, one of which is killed in the midst."""
    ray = pytest.importorskip("ray")
    speeds, forces = np.linspace(0.8, 6.0, 400), np.linspace(4.0, 40.0, 400)
    whole = simulated_map(RIG, Friction(), speeds, forces, duration=45.0)

    def kill():
        while len(list(tmp_path.glob("piece_*.npz"))) < 3:
            sleep(0.02)
        while not killed:
            names = [Path(f"/proc/{number}/cmdline") for number in os.listdir("/proc") if number.isdigit()]
            killed.extend(name for name in names if is_worker_of_mine(name))
        os.kill(int(killed[0].parent.name), signal.SIGKILL)

    killed = []
    with engine_at("ray", 2) as engine:
        threading.Thread(target=kill, daemon=True).start()
        found = simulated_map(RIG, Friction(), speeds, forces, duration=45.0, engine=engine, folder=tmp_path)
    assert killed
    assert not ray.is_initialized()
    np.testing.assert_array_equal(found.region, whole.region)


def is_worker_of_mine(cmdline):
    """Whether a process does a piece for the instance of Ray that this process has started."""
    try:
        if not cmdline.read_bytes().startswith(b"ray::_answer_here"):
            return False
        return parent(parent(int(cmdline.parent.name))) == os.getpid()
    except OSError:
        return False


def parent(number):
    return int(Path(f"/proc/{number}/stat").read_text().rpartition(")")[2].split()[1])
