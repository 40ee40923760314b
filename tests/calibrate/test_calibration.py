"""The fit of a rig to records of it: on twins, whose rig is known."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from drillrig_env import Friction, Rig, simulate
from drillrig_env.calibrate import fit as module
from drillrig_env.calibrate.calibration import BY_RECORDS, calibrate
from drillrig_env.calibrate.fit import fit
from drillrig_env.calibrate.projection import FREE, Problem
from drillrig_env.calibrate.records import Record
from drillrig_env.calibrate.unknowns import OF_FRICTION, OF_RIGS, Unknowns
from drillrig_env.calibrate.windows import Windows

NOISE = {"bit_speed": 0.02, "top_speed": 0.02, "current": 0.02, "voltage": 0.05}
LOOKED_FOR = ("k_2", "J_2", "K_T", "mu_k", "mu_s - mu_k", "v_b")
FIXED = dict.fromkeys(name for name in (*OF_RIGS, *OF_FRICTION) if name not in LOOKED_FOR)


def twin(speed_reference, normal_force, duration, noise=1.0, seed=0, rig=None, period=0.02):
    """A record as a logger would write it, of a rig that is known."""
    run = simulate(rig, Friction(10.0), None, speed_reference, duration, period, normal_force=normal_force)
    random = np.random.default_rng(seed)
    signals = {
        name: getattr(run, name) + noise * size * random.standard_normal(len(run.time)) for name, size in NOISE.items()
    }
    return Record("twin.csv", "", run.time, signals, run.speed_reference, run.normal_force)


STICKING = twin(2.0, 20.0, 24.0)
UNLOADED = twin([(0, 2.0), (4, 4.0), (9, 3.0)], 0.0, 15.0)


def problem_of(record, fix=FIXED, noise=None):
    windows = Windows.of(record, 0.02, 3.0)
    unknowns = Unknowns.of(Rig(), Friction(10.0), fix)
    return Problem([windows], unknowns, [windows.noise if noise is None else noise])


def test_unknowns_are_logarithms_of_ratios():
    unknowns = Unknowns.of(Rig(), Friction(10.0), {"J_1": 0.03}, {"k_2": 0.02})
    assert "J_1" not in unknowns.names
    assert "T_r2" not in unknowns.names  # it is 0
    assert unknowns.deviations[unknowns.names.index("k_2")] == 0.02
    same, friction = unknowns.at(np.zeros(len(unknowns.names)))
    assert same == replace(Rig(), J_1=0.03)
    assert (friction.mu_s, friction.mu_k, friction.v_b) == pytest.approx((0.5, 0.306, 1.0))
    logs = np.linspace(-0.3, 0.3, len(unknowns.names))
    rig, friction = unknowns.at(logs)
    for name, log in zip(unknowns.names, logs, strict=True):
        if name in OF_RIGS:
            assert getattr(rig, name) == pytest.approx(getattr(Rig(), name) * np.exp(log))
    fall = logs[unknowns.names.index("mu_s - mu_k")]
    assert friction.mu_s - friction.mu_k == pytest.approx(0.194 * np.exp(fall))


def test_windows_hold_inputs_and_data_at_their_times():
    record = UNLOADED
    windows = Windows.of(record, 0.02, 3.0)
    assert windows.data.shape == (5, 150, 4)
    np.testing.assert_array_equal(windows.data[1, 0], [record.signals[name][151] for name in windows.names])
    assert windows.references[1, 49] == 2.0  # held until 4 s
    assert windows.references[1, 50] == 4.0
    assert windows.asked[1, 49] == 4.0
    np.testing.assert_allclose(windows.noise, list(NOISE.values()), rtol=0.25)


def test_samples_count_at_their_times_and_gaps_stay_open():
    record = twin(2.0, 20.0, 7.0, period=0.005)
    time = record.time
    masked = {name: np.where((time > 1.0) & (time < 1.5), np.nan, values) for name, values in record.signals.items()}
    windows = Windows.of(replace(record, signals=masked), 0.02, 3.0)
    np.testing.assert_array_equal(windows.data[0, :50, 0], record.signals["bit_speed"][4:204:4])
    assert np.isnan(windows.data[0, 50:74]).all()
    assert np.isfinite(windows.data[1]).all()


def test_steps_go_from_sample_to_sample_and_inputs_are_means_over_them():
    record = twin([(0.0, 2.0), (1.015, 4.0)], 20.0, 7.0, period=0.005)
    uneven = replace(record, time=record.time + 0.001 * (np.arange(len(record.time)) % 2))
    windows = Windows.of(uneven, 0.02, 3.0)
    np.testing.assert_array_equal(windows.times[0], uneven.time[4:601:4])
    np.testing.assert_allclose(windows.lengths[0], np.diff(uneven.time[:601:4]))
    np.testing.assert_array_equal(windows.data[0, :, 0], record.signals["bit_speed"][4:601:4])
    assert windows.references[0, 49] == pytest.approx(2.0)
    assert windows.references[0, 50] == pytest.approx((0.016 * 2.0 + 0.004 * 4.0) / 0.02)
    assert windows.asked[0, 50] == 4.0


def test_a_reference_jumps_before_the_sample_that_shows_it():
    windows = Windows.of(twin([(0.0, 2.0), (1.0, 4.0), (2.0, 3.0)], 0.0, 3.2), 0.02, 1.5)
    assert windows.jumps.tolist() == [[1.0, 2.0], [2.0, 4.0], [4.0, 3.0]]
    held, first, second = windows.lagging(np.array([-0.015, 0.0]))
    assert held[0, 49] == pytest.approx(0.005)  # the step up to 1 s
    assert (first[0, 49], second[0, 49], first[0, 50], second[0, 50]) == (2.0, 4.0, 4.0, 4.0)
    assert np.delete(held[0], 49) == pytest.approx(0.02)
    assert held[1] == pytest.approx(0.02)
    assert (second[1, 24], first[1, 25]) == (4.0, 3.0)
    noise = 0.01 * np.random.default_rng(0).standard_normal(161)
    noisy = replace(twin([(0.0, 2.0), (1.0, 4.0)], 0.0, 3.2), speed_reference=2.0 + noise)
    assert Windows.of(noisy, 0.02, 1.5).jumps.size == 0


def test_the_lag_of_a_reference_is_found_with_the_starts():
    record = twin([(0.0, 2.0), (4.013, 4.0)], 0.0, 9.0, noise=0.0)
    problem = problem_of(record, fix=FIXED | dict.fromkeys(OF_FRICTION), noise=np.array(list(NOISE.values())))
    zero = np.zeros(len(problem.unknowns.names))
    problem.begin(zero)
    (residuals,) = problem.residuals(zero)
    assert np.abs(residuals[1, :-FREE]).max() < 0.5
    assert problem.starts[0][1, 7] == pytest.approx(-0.007, abs=1e-4)


def test_no_window_spans_a_long_gap_or_a_change_in_a_gap():
    record = twin([(0.0, 2.0), (4.02, 4.0)], 20.0, 10.0)
    time = record.time

    def without(begin, end):
        kept = (time < begin) | (time > end)
        signals = {name: values[kept] for name, values in record.signals.items()}
        inputs = {name: getattr(record, name)[kept] for name in ("speed_reference", "normal_force")}
        return Windows.of(replace(record, time=time[kept], signals=signals, **inputs), 0.02, 1.0)

    whole, short = without(20.0, 20.0), without(2.47, 2.53)
    assert whole.follows.tolist() == [False] + 9 * [True]
    assert short.follows.tolist() == [False] + 8 * [True]
    assert short.lengths.max() == pytest.approx(0.08)  # a step of its own
    for begin, end in ((2.4, 3.2), (3.99, 4.05)):
        cut = without(begin, end)
        assert cut.lengths.max() == pytest.approx(0.02)
        (after,) = np.flatnonzero(~cut.follows[1:]) + 1
        assert cut.times[after - 1, -1] < begin
        assert cut.times[after, 0] > end
    with pytest.raises(ValueError, match=r"length of the record = 10 s is not allowed; allowed: >= 11 s without"):
        Windows.of(record, 0.02, 11.0)


def test_a_model_led_along_an_uneven_record_with_a_gap_is_where_the_rig_is():
    record = twin([(0.0, 2.0), (4.0, 4.0)], 20.0, 16.0, noise=0.0, period=0.01)
    kept = np.random.default_rng(0).random(len(record.time)) < 0.8
    kept &= (record.time < 9.0) | (record.time > 9.8)
    signals = {name: values[kept] for name, values in record.signals.items()}
    inputs = {name: getattr(record, name)[kept] for name in ("speed_reference", "normal_force")}
    noise = np.array(list(NOISE.values()))
    problem = problem_of(replace(record, time=record.time[kept], signals=signals, **inputs), noise=noise)
    zero = np.zeros(len(LOOKED_FOR))
    problem.begin(zero)
    (residuals,) = problem.residuals(zero)
    changes = np.abs(residuals[:, :-FREE]).reshape(len(residuals), -1).max(axis=1)
    assert np.median(changes) < 0.1
    assert len(residuals) - problem.windows[0].follows.sum() == 2


def test_without_noise_the_best_starts_are_the_states_themselves():
    run = simulate(None, Friction(10.0), None, 2.0, 24.0, 0.02, normal_force=20.0)
    problem = problem_of(twin(2.0, 20.0, 24.0, noise=0.0), noise=np.array(list(NOISE.values())))
    zero = np.zeros(len(LOOKED_FOR))
    problem.begin(zero)
    (residuals,) = problem.residuals(zero)
    assert np.abs(residuals[1:, :-FREE]).max() < 0.5  # of the noise, which is not there
    np.testing.assert_allclose(problem.starts[0][2:, :7], run.state[:-1:150][2:], atol=0.03)


def test_derivatives_are_those_of_the_cost_at_the_best_starts():
    problem = problem_of(STICKING)
    logs = np.full(len(problem.unknowns.names), 0.02)
    problem.begin(logs)

    def cost(x):
        return sum(0.5 * np.sum(one**2) for one in problem.residuals(x))

    for _ in range(3):
        (residuals,) = problem.residuals(logs)
    (derivatives,) = problem.derivatives(logs)
    slopes = np.einsum("nij,ni->j", derivatives, residuals)
    for k in range(len(logs)):
        step = np.zeros(len(logs))
        step[k] = 1e-4
        difference = (cost(logs + step) - cost(logs - step)) / 2e-4
        assert slopes[k] == pytest.approx(difference, rel=0.02, abs=0.02 * np.abs(slopes).max())


@cache
def fitted():
    """A calibration of two twins."""
    start = replace(Rig(), k_2=0.3659 * 1.2, J_2=0.0149 * 0.8, K_T=0.126 * 1.15)
    records = [STICKING, UNLOADED]
    return calibrate(records, start, Friction(10.0, 0.45, 0.34, 0.8), fix=FIXED, starts=2, seed=1)


@pytest.fixture(name="calibrated")
def _calibrated():
    return fitted()


def test_a_fit_finds_the_rig_of_a_twin(calibrated):
    true = {"k_2": 0.3659, "J_2": 0.0149, "K_T": 0.126, "mu_k": 0.306, "mu_s - mu_k": 0.194, "v_b": 1.0}
    assert set(calibrated.unknowns.names) == set(LOOKED_FOR)
    for name, value, low, high, told in calibrated.rows():
        assert value == pytest.approx(true[name], rel=0.05)
        assert told == BY_RECORDS
        assert low < value < high
        assert low < true[name] * (1.0 + 0.5 * (high / low - 1.0))
        assert high > true[name] / (1.0 + 0.5 * (high / low - 1.0))
    assert calibrated.rig.J_1 == Rig().J_1
    assert calibrated.draws.shape == (64, len(LOOKED_FOR))
    spread = calibrated.draws.std(axis=0)
    np.testing.assert_allclose(spread, calibrated.spread.deviations, rtol=0.35)


def test_a_step_too_far_does_not_end_a_fit():
    record = twin(2.0, 20.0, 40.0).since(10.0)  # begins amid a cycle, which its bit's speed alone tells badly
    record = replace(record, signals={"bit_speed": record.signals["bit_speed"]})
    fixed = FIXED | dict.fromkeys(("K_T", "mu_k"))
    found = calibrate([record], None, Friction(10.0, 0.45, 0.306), fix=fixed, starts=1)
    for name, value in (("J_2", 0.0149), ("k_2", 0.3659), ("mu_s - mu_k", 0.194), ("v_b", 1.0)):
        assert found.unknowns.values(found.best.logs)[name] == pytest.approx(value, rel=0.05)


def test_a_fit_comes_out_the_same_again():
    fits = [calibrate([STICKING], None, Friction(10.0), fix=FIXED, starts=2, seed=3) for _ in range(2)]
    np.testing.assert_array_equal(fits[0].best.logs, fits[1].best.logs)
    np.testing.assert_array_equal(fits[0].draws, fits[1].draws)


def test_what_nothing_presses_on_is_not_looked_for():
    found = calibrate([UNLOADED], None, Friction(10.0), fix=FIXED, starts=1)
    assert set(found.unknowns.names) == {"k_2", "J_2", "K_T"}


def test_ctrl_c_goes_on_with_the_best_so_far(monkeypatch):
    seen = []

    def told(done, cost):
        seen.append((done, cost))
        if done == 2:
            raise KeyboardInterrupt

    last = []
    solve = module._solve
    monkeypatch.setattr(module, "_solve", lambda *given: last.append(given) or solve(*given))
    best = fit(problem_of(STICKING), 5, 0, told)
    assert [done for done, _ in seen] == [1, 2]
    assert best.cost <= seen[-1][1] * 1.5
    assert len(best.costs) == 2
    assert len(last) == 3  # a last fit of the best one only


def test_ctrl_c_before_anything_is_found_ends_it():
    problem = problem_of(STICKING)
    problem.begin = lambda logs: (_ for _ in ()).throw(KeyboardInterrupt)
    with pytest.raises(KeyboardInterrupt):
        fit(problem, 5, 0)


@pytest.mark.parametrize(
    ("record", "arguments", "words"),
    [
        (replace(STICKING, speed_reference=None), {}, "twin.csv: the speed_reference is missing"),
        (replace(STICKING, normal_force=None), {}, "twin.csv: the normal_force is missing"),
        (STICKING, {"window": 30.0}, r"twin.csv: length of the record = 24 s is not allowed; allowed: >= 30"),
        (STICKING, {"window": 9.0}, "number of windows = 2 is not allowed; allowed: >= 4"),
        (STICKING, {"fix": {"J1": None}}, "unknown parameter 'J1'; did you mean J_1"),
        (STICKING, {"starts": 0}, "starts = 0 is not allowed"),
    ],
)
def test_what_cannot_be_fitted_is_refused(record, arguments, words):
    with pytest.raises(ValueError, match=words):
        calibrate([record], None, Friction(10.0), **{"fix": FIXED, "starts": 1, **arguments})


def test_no_records_are_refused():
    with pytest.raises(ValueError, match="no record is given"):
        calibrate([])


def csv_of(record, path):
    names = [*record.signals, "speed_reference", "normal_force"]
    columns = [record.time, *record.signals.values(), record.speed_reference, record.normal_force]
    np.savetxt(path, np.column_stack(columns), "%.6g", ",", header=",".join(["time", *names]), comments="")
