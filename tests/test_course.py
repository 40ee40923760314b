"""Courses: tables over time, from arrays, functions and files, and what is refused of them."""

import numpy as np
import pytest

from drillrig_env import Course, Friction, Rig, Tilt, simulate
from drillrig_env.inputs import Inputs
from drillrig_env.simulation import SIGNALS
from drillrig_env.stepper.tables import step_tables

pytestmark = pytest.mark.usefixtures("coarser_radau")

TIME = np.array([0.0, 0.5, 2.0])


def test_values_hold_until_the_next_time_and_the_last_one_to_the_end():
    course = Course(TIME, normal_force=[10.0, 20.0, 5.0], v_b=lambda t: 1.0 + t)
    table = course.table(np.array([0.0, 0.49, 0.5, 0.5 - 1e-12, 1.9, 2.0, 99.0]))
    np.testing.assert_array_equal(table[:, 0], [10.0, 10.0, 20.0, 20.0, 20.0, 5.0, 5.0])
    np.testing.assert_array_equal(table[:, 3], [1.0, 1.0, 1.5, 1.5, 1.5, 3.0, 3.0])
    assert np.isnan(table[:, [1, 2, 4]]).all()
    assert course.given == ("normal_force", "v_b")


def test_a_course_is_its_own_copy():
    forces = np.array([10.0, 20.0, 5.0])
    course = Course(TIME, normal_force=forces)
    forces[:] = 0.0
    assert course.values("normal_force").tolist() == [10.0, 20.0, 5.0]


def test_a_csv_file_is_read_with_its_columns_in_any_order(tmp_path):
    path = tmp_path / "course.csv"
    path.write_text("normal_force, time\n10,0\n\n20,0.5\n5,2\n", encoding="utf-8")
    course = Course.of(str(path))
    np.testing.assert_array_equal(course.time, TIME)
    np.testing.assert_array_equal(course.values("normal_force"), [10.0, 20.0, 5.0])


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("time,normal_force\n0,ten\n", "line 2: normal_force = 'ten' is not a number"),
        ("time,normal_force\n0,1\n1\n", "line 3: 1 cells are not allowed; allowed: 2"),
        ("time,force\n0,1\n", "column 'force' is not known; .*normal_force"),
        ("normal_force\n1\n", "column 'time' is there 0 times"),
        ("time,v_b,v_b\n0,1,1\n", "column 'v_b' is there 2 times"),
        ("time,v_b\n0,-1\n", "v_b at 0 s = -1.0 s/rad is not allowed; allowed: > 0"),
        ("", "column 'time' is there 0 times"),
        ("time,v_b\n", r"shape of time = \(0,\) is not allowed; allowed: \(n,\)"),
        ("time;v_b\n0;1\n", "allowed: once; columns: 'time;v_b'"),
        ("time,v_b\n0," + "1" * 200_000, "is no file that can be read: field larger than"),
    ],
)
def test_a_file_that_is_no_course_is_refused_with_its_line(tmp_path, text, words):
    path = tmp_path / "course.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ValueError, match=words) as error:
        Course.of(path)
    assert str(path) in str(error.value)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"time": [0.0, 0.0], "v_b": [1.0, 1.0]}, "ascending, finite, from 0"),
        ({"time": [0.1, 0.2], "v_b": [1.0, 1.0]}, "ascending, finite, from 0"),
        ({"time": [0.0, np.nan], "v_b": [1.0, 1.0]}, "ascending, finite, from 0"),
        ({"time": [*range(500), 7.0], "v_b": np.ones(501)}, r"^Course: time 500 = 7.0 s is not allowed; [^\n]*$"),
        ({"time": np.zeros((2, 2)), "v_b": np.ones((2, 2))}, r"shape of time = \(2, 2\) is not allowed"),
        ({"time": range(500), "v_b": lambda t: None}, r"^Course: v_b = .{80} is not allowed; allowed: numbers[^\n]*$"),
        ({"time": [0.0, 1.0], "v_b": [1.0]}, r"shape of v_b = \(1,\) is not allowed; allowed: \(2,\)"),
        ({"time": [0.0, 1.0], "v_b": [1.0, np.nan]}, "v_b at 1 s = nan s/rad is not allowed"),
        ({"time": [0.0, 1.0], "v_b": lambda t: "x"}, "v_b = .* is not a"),
        ({"time": [0.0], "mu_s": [0.5]}, "mu_s and mu_k, or neither"),
        (
            {"time": [0.0, 3.0], "mu_s": [0.5, 0.2], "mu_k": [0.3, 0.3]},
            "mu_s at 3 s = 0.2 .*mu_k = 0.3",
        ),
        ({"time": [0.0]}, "what is given = nothing"),
        ({"v_b": [1.0]}, "'time' of a course is missing"),
        ({"time": [0.0], "N": [1.0]}, "unknown field 'N' of a course"),
        (3, "a Course, a dictionary of its fields, or a CSV file"),
    ],
)
def test_what_is_no_course_is_refused_by_name(given, words):
    with pytest.raises(ValueError, match=words):
        Course.of(given)


def test_a_missing_file_is_named():
    with pytest.raises(FileNotFoundError, match=r"no file nowhere\.csv"):
        Course.of("nowhere.csv")


def test_a_course_of_forces_is_a_schedule_of_them_bit_for_bit():
    pairs = [(0.0, 5.0), (1.23, 25.0), (4.0, 12.0)]
    course = Course(*(np.array(column) for column in zip(*pairs, strict=True)))
    scheduled = simulate(normal_force=pairs, speed_reference=2.5, duration=8.0, sample_period=0.1)
    followed = simulate(course=course, speed_reference=2.5, duration=8.0, sample_period=0.1)
    for name in SIGNALS:
        np.testing.assert_array_equal(scheduled.signals()[name], followed.signals()[name])


@pytest.mark.parametrize("off_grid", [False, True])
def test_coefficients_over_time_agree_with_runs_of_each_piece(off_grid):
    times = np.array([0.0, 0.73 if off_grid else 0.7, 1.9])
    course = Course(times, mu_s=[0.5, 0.7, 0.35], mu_k=[0.3, 0.2, 0.3], v_b=[1.0, 0.4, 3.0])
    run = simulate(friction=Friction(18.0), course=course, speed_reference=2.0, duration=3.0, sample_period=0.1)
    reference = simulate(
        friction=Friction(18.0), course=course, speed_reference=2.0, duration=3.0, sample_period=0.1, method="radau"
    )
    np.testing.assert_allclose(run.state, reference.state, atol=1e-6)
    state = None
    for begin, end, mu_s, mu_k, v_b in zip(times, [*times[1:], 3.0], *course.table(times)[:, 1:4].T, strict=True):
        friction = Friction(18.0, mu_s, mu_k, v_b)
        piece = simulate(None, friction, state, 2.0, end - begin, (end - begin) / 7.0)
        state = piece.state[-1]
    np.testing.assert_allclose(run.state[-1], state, atol=1e-6)
    np.testing.assert_allclose(run.friction_torque, reference.friction_torque, atol=1e-4)
    assert run.friction_torque[10] == Friction(18.0, 0.7, 0.2, 0.4).torque(Rig(), run.bit_speed[10])


def test_a_course_of_any_times_takes_two_tables_and_agrees_with_radau():
    random = np.random.default_rng(0)
    times = np.array([0.0, 3e-9, *np.sort(random.uniform(0.0, 2.0, 40))])
    course = Course(times, normal_force=random.uniform(5.0, 25.0, len(times)))
    arguments = {"speed_reference": 2.5, "duration": 2.0, "sample_period": 0.13, "course": course}
    built = step_tables.cache_info().misses
    fast = simulate(Rig(J_1=0.03), **arguments)
    assert step_tables.cache_info().misses <= built + 2
    np.testing.assert_allclose(fast.state, simulate(Rig(J_1=0.03), method="radau", **arguments).state, atol=1e-7)


def test_long_courses_are_looked_through_at_once():
    course = Course(0.001 * np.arange(100_000), normal_force=np.tile([20.0, 10.0], 50_000), v_b=np.ones(100_000))
    pieces = Inputs.of(Friction(), 2.0, None, course).pieces(0.001 * np.arange(100_001.0), 1e-11)
    assert pieces.intervals.tolist() == [0.001] * 100_000
    assert pieces.coefficients[:3, 0].tolist() == [20.0, 10.0, 20.0]


def test_a_simulation_refuses_what_is_given_twice_or_is_for_environments():
    with pytest.raises(ValueError, match="the course gives the normal_force already"):
        simulate(course={"time": [0.0], "normal_force": [5.0]}, normal_force=3.0)
    with pytest.raises(ValueError, match="speed_target is for an environment"):
        simulate(course={"time": [0.0], "speed_target": [5.0]})
    with pytest.raises(ValueError, match=r"turns = \(1, 2\) is not allowed; allowed: one number"):
        simulate(tilt=Tilt(0.1, (1, 2)))
