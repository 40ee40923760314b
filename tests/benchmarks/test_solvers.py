"""The solvers of the benchmarks: every peer solves the same equations, and missing ones are left out with a hint."""

import json
import sys

import numpy as np
import pytest
import scipy
from packaging.version import Version

from benchmarks import batches, solvers
from benchmarks.case import (
    ONE_RIG,
    RIG,
    START,
    array_rates,
    compiled_jacobian,
    compiled_rates,
    drawn_rigs,
    largest_errors,
    sample_times,
)
from benchmarks.peers import BATCH_PEERS, PEERS, heyoka_taylor
from benchmarks.peers.peer import Library, settings
from drillrig_env import simulate, simulate_batch
from drillrig_env.friction.law import zone_of
from drillrig_env.model import jacobian, state_equations

BIT_SPEEDS = (-3.0, -1.001e-3, -1e-3, -4e-4, 0.0, 9.9e-4, 1e-3, 1.5, 8.0)
STATES = np.random.default_rng(1).normal(size=(len(BIT_SPEEDS), 7))
STATES[:, 2] = BIT_SPEEDS
RIGS = drawn_rigs(len(BIT_SPEEDS))


def model_rates(rigs):
    """The rates that the package itself gives for `STATES`."""
    torques = rigs.friction.torque(RIG, STATES[:, 2])
    speeds = np.broadcast_to(rigs.speed_reference, len(STATES))
    return np.array([state_equations(x, w, T, RIG) for x, w, T in zip(STATES, speeds, torques, strict=True)])


def test_compiled_right_hand_side_and_jacobian_are_the_models():
    rates, slopes, wanted = compiled_rates(), compiled_jacobian(), model_rates(RIGS)
    for n, (x, contact) in enumerate(zip(STATES, RIGS.contacts, strict=True)):
        out, matrix = np.empty(7), np.empty((7, 7))
        rates(x, contact, out)
        slopes(x, contact, matrix)
        slope = np.asarray(RIGS.friction.slope(RIG, x[2]))[n]
        np.testing.assert_allclose(out, wanted[n], rtol=1e-12, atol=1e-12)
        np.testing.assert_allclose(matrix, jacobian(RIG, slope), rtol=1e-12)


@pytest.mark.parametrize("library", ["numpy", "torch", "jax.numpy"])
def test_right_hand_side_over_arrays_is_the_models(library):
    namespace = pytest.importorskip(library)
    if library == "jax.numpy":
        sys.modules["jax"].config.update("jax_enable_x64", True)
    columns = namespace.asarray(STATES.T.copy()), namespace.asarray(RIGS.contacts.T.copy())
    rates = np.stack([np.asarray(rate) for rate in array_rates(namespace, *columns)], axis=1)
    np.testing.assert_allclose(rates, model_rates(RIGS), rtol=1e-12, atol=1e-12)


def test_symbols_of_each_piece_are_the_models():
    heyoka = pytest.importorskip("heyoka")
    for x, wanted in zip(STATES, model_rates(ONE_RIG), strict=True):
        pairs = heyoka_taylor.equations(zone_of(float(x[2]), RIG.omega_s, np.inf))
        function = heyoka.cfunc([rate for _, rate in pairs], vars=[state for state, _ in pairs])
        np.testing.assert_allclose(function(x), wanted, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize(
    "peer",
    [pytest.param(peer, marks=pytest.mark.slow if peer in PEERS[2:] else ()) for peer in PEERS],
    ids=lambda peer: peer.name,
)
def test_each_solver_follows_the_first_stick_and_slip(peer):
    if not peer.package.found:
        pytest.skip(peer.package.hint)
    if "SciPy" in peer.name and Version(scipy.__version__) < Version("1.17"):
        pytest.skip("VODE and LSODA of an earlier SciPy cannot call compiled functions")
    times = sample_times(2.0)
    wanted = simulate(None, ONE_RIG.friction, START, 2.0, duration=2.0, sample_period=0.1).bit_speed[1:]
    states = peer.prepare(peer.settings[len(peer.settings) // 2], times)()
    assert states.shape == (len(times), 7)
    np.testing.assert_array_equal(states[0], START)
    assert largest_errors(states, wanted) < 1e-3


@pytest.mark.parametrize("peer", BATCH_PEERS, ids=lambda peer: peer.name)
def test_each_batch_solver_keeps_rigs_and_samples_in_order(peer):
    if not peer.package.found:
        pytest.skip(peer.package.hint)
    rigs, times = drawn_rigs(3), sample_times(0.3)  # short: torchdiffeq needs a second for it
    wanted = simulate_batch(None, rigs.friction, START, rigs.speed_reference, duration=0.3)[:, 1:, 2]
    states = peer.prepare(rigs, peer.settings[0], times, 2)()
    assert states.shape == (3, 4, 7)
    assert np.all(largest_errors(states, wanted) < 1e-2)


def test_the_project_gives_the_last_states_alone_too():
    peer, rigs, times = BATCH_PEERS[0], drawn_rigs(3), sample_times(1.0)
    every, last = (peer.prepare(rigs, peer.settings[-1], grid, 2)() for grid in (times, times[[0, -1]]))
    np.testing.assert_array_equal(last, every[:, [0, -1]])


def test_a_larger_batch_begins_with_the_smaller_ones_rigs():
    np.testing.assert_array_equal(drawn_rigs(40).contacts[:7], drawn_rigs(7).contacts)
    assert drawn_rigs(40).normal_force.min() >= 5.0
    assert drawn_rigs(40).speed_reference.max() <= 5.0


def test_errors_count_the_judged_samples_only_and_never_hide_what_is_not_a_number():
    states = np.zeros((2, 4, 7))
    states[0, 3, 2], states[1, 1, 2] = 5.0, np.nan
    np.testing.assert_array_equal(largest_errors(states, np.zeros((2, 2))), [0.0, np.inf])


def test_ratios_take_the_fastest_peer_within_the_error():
    def result(library, solver, rtol, error, rate):
        keys = ("library", "solver", "rtol", "error_rad_s", "simulated_s_per_s", "setting")
        return dict(zip(keys, (library, solver, rtol, error, rate, "a setting"), strict=True))

    found = solvers.ratios(
        [
            result("DrillRig", "DrillRig fast stepper", 1e-6, 1e-7, 1000.0),
            result("numbalsoda", "numbalsoda LSODA", 1e-3, 1e-2, 900.0),
            result("numbalsoda", "numbalsoda LSODA", 1e-7, 9e-7, 100.0),
            result("SciPy", "SciPy odeint (LSODA)", 1e-8, 5e-7, 20.0),
            result("SciPy", "SciPy odeint (LSODA)", 1e-9, 5e-8, 10.0),
        ]
    )
    assert found["the fastest SciPy solver, error <= 1e-6"]["ratio"] == 50.0
    assert found["the fastest peer, error <= 1e-6"]["ratio"] == 10.0
    assert "VODE in the chapter's form, error <= 1e-6" not in found


def missing(peer):
    """The same peer, from a library that is not installed."""
    library = Library("Nothing", "no_such_module", "no-such-package")
    return type(peer)(**{**vars(peer), "package": library})


def test_solvers_write_json_and_leave_out_what_is_missing(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(solvers, "PEERS", (PEERS[0], missing(PEERS[-1])))
    for name, duration in (("DURATION", 2.0), ("JUDGED", 1.0)):
        monkeypatch.setattr(solvers, name, duration)
    monkeypatch.setattr(solvers, "compile_seconds", lambda: 1.0)
    monkeypatch.setattr(solvers, "accuracy", lambda: 1e-7)
    monkeypatch.setattr(solvers, "use_one_core", lambda: None)  # the other tests shall keep theirs
    monkeypatch.setattr(sys, "argv", ["solvers", "--quick", "--json", str(tmp_path / "solvers.json")])
    solvers.main()
    assert "pip install no-such-package" in capsys.readouterr().err
    results = json.loads((tmp_path / "solvers.json").read_text())["results"]
    assert {result["library"] for result in results["solvers"]} == {"DrillRig"}
    assert all(0.0 < result["error_rad_s"] < 1e-3 and result["seconds_for_50_s"] > 0.0 for result in results["solvers"])


@pytest.mark.slow
def test_batches_give_time_and_error_of_each_size():
    reference = drawn_rigs(1).bit_speeds(sample_times(0.2), rtol=1e-7)
    peer, setting = BATCH_PEERS[0], BATCH_PEERS[0].settings[-1]
    result = batches.described(peer, setting)
    assert len(list(batches.measure(result, setting, reference, [1, 3], 1, 60.0))) == 4
    assert "not_run" not in result
    assert result["median_error_rad_s"] < 1e-5
    assert {size: one["repeats"] for size, one in result["sizes"].items()} == {"1": 1, "3": 1}
    assert result["sizes"]["3"]["simulated_s_per_s"] == pytest.approx(30.0 / result["sizes"]["3"]["seconds"])
    assert len(batches.rows(result)) == 2


def test_a_batch_that_fails_says_why():
    setting = BATCH_PEERS[0].settings[0]
    result = {**batches.described(BATCH_PEERS[0], setting), "solver": "nobody"}
    list(batches.measure(result, setting, np.zeros((1, 1)), [1], 1, 60.0))
    assert result["not_run"].startswith("0 of 1 sizes done: ")


def test_batches_write_json_and_leave_out_what_is_missing(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(batches, "BATCH_PEERS", (missing(BATCH_PEERS[-1]),))
    monkeypatch.setattr(batches, "references", lambda rigs: np.zeros((rigs, 100)))
    monkeypatch.setattr(sys, "argv", ["batches", "--quick", "--json", str(tmp_path / "batches.json")])
    batches.main()
    assert "pip install no-such-package" in capsys.readouterr().err
    assert json.loads((tmp_path / "batches.json").read_text())["results"]["batches"] == []


def test_batch_times_grow_as_the_last_two_sizes_tell():
    sizes = {"1": {"seconds": 1.0}, "11": {"seconds": 2.0}}
    assert batches.expected_seconds(sizes, 111) == pytest.approx(12.0)
    assert batches.expected_seconds({}, 111) == 0.0


def test_settings_are_told_apart_in_tables():
    labels = [setting.label for peer in PEERS for setting in peer.settings]
    assert "rtol 1e-08, atol 1e-11" in labels
    for peer in PEERS:
        assert len({setting.label for setting in peer.settings}) == len(peer.settings)
    assert settings(1e-4, ratio=0.1)[0].atol == pytest.approx(1e-5)
