"""Fits from many starts: the same from any number of processes, and after any stop."""

import json
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from drillrig_env import Friction, Rig
from drillrig_env.calibrate import command
from drillrig_env.calibrate import fit as module
from drillrig_env.calibrate.fit import fit
from drillrig_env.calibrate.kept import Ended, Kept
from drillrig_env.calibrate.projection import Problem
from drillrig_env.calibrate.search import Search, key_of
from drillrig_env.calibrate.unknowns import Unknowns
from drillrig_env.calibrate.windows import Windows
from drillrig_env.engine import engine_at
from tests.calibrate.test_calibration import FIXED, STICKING, csv_of

FEW = {name: value for name, value in FIXED.items() if name != "v_b"} | dict.fromkeys(("K_T", "mu_k", "mu_s - mu_k"))
"""J_2, k_2 and v_b are looked for."""


def problem_of(noise=None):
    windows = Windows.of(STICKING, 0.02, 3.0)
    return Problem([windows], Unknowns.of(Rig(), Friction(10.0), FEW), [windows.noise if noise is None else noise])


def same(one, other):
    np.testing.assert_array_equal(one.logs, other.logs)
    np.testing.assert_array_equal(one.costs, other.costs)
    np.testing.assert_array_equal(one.residuals[0], other.residuals[0])


@pytest.mark.slow
@pytest.mark.parametrize("where", ["local", "ray"])
def test_the_last_bit_is_the_same_from_several_processes(where):
    if where == "ray":
        pytest.importorskip("ray")
    with engine_at(where, 2) as engine:
        same(fit(problem_of(), 5, 3), fit(problem_of(), 5, 3, search=Search(engine)))


def test_the_last_bit_is_the_same_after_a_stop(tmp_path, monkeypatch):
    path = tmp_path / "search.json"

    def told(done, cost):
        if done == 1:
            raise KeyboardInterrupt

    early = fit(problem_of(), 3, 3, told, Search(kept=Kept(path, {})))
    assert early.stopped
    assert early.starts == 1
    begun = []
    solve = module._solve
    with monkeypatch.context() as patch:
        patch.setattr(module, "_solve", lambda *given: begun.append(given[2]) or solve(*given))
        again = fit(problem_of(), 3, 3, search=Search(kept=Kept(path, {}, resume=True)))
    assert begun.count(module._FIRST) == 2  # starts that were not done
    assert not again.stopped
    same(fit(problem_of(), 3, 3), again)


def test_a_fit_is_known_by_all_that_decides_how_it_ends():
    place = np.zeros(3)
    known = key_of(problem_of(), 10, place)
    assert key_of(problem_of(), 10, place.copy()) == known
    fewer = problem_of()
    fewer.windows = [fewer.windows[0].take(np.arange(3))]
    other_whole = problem_of()
    other_whole.windows = [other_whole.windows[0].take(np.arange(8))]
    others = [
        key_of(problem_of(), 11, place),
        key_of(problem_of(), 10, place + 1e-16),
        key_of(problem_of(np.ones(4)), 10, place),
        key_of(fewer, 10, place),
        key_of(other_whole, 10, place),
    ]
    assert len({known, *others}) == 6


def test_what_is_kept_is_read_back_to_the_last_bit(tmp_path):
    path = tmp_path / "search.json"
    kept = Kept(path, {"seed": "0"})
    assert not path.exists()
    logs = np.random.default_rng(0).standard_normal(17)
    kept.put("a", Ended(0.1 + 0.2, logs))
    kept.put("b", Ended(np.inf, np.empty(0), "the model runs away"))
    with pytest.raises(FileExistsError, match="give --resume to go on, or --overwrite"):
        Kept(path, {"seed": "0"})
    again = Kept(path, {"seed": "0"}, resume=True)
    assert again.get("a").cost == 0.1 + 0.2
    np.testing.assert_array_equal(again.get("a").logs, logs)
    assert again.get("b").failure == "the model runs away"
    assert again.get("c") is None
    with pytest.raises(ValueError, match="a search with seed = 0, here 1; give the same to go on"):
        Kept(path, {"seed": "1"}, resume=True)
    path.write_text('{"of": {}}')
    with pytest.raises(ValueError, match="is damaged: it is no search"):
        Kept(path, {}, resume=True)
    again.remove()
    with pytest.raises(FileNotFoundError, match="no search was stopped there; leave out --resume"):
        Kept(path, {}, resume=True)


def words_of(tmp_path, *more):
    fixed = [name for name in FEW if name not in ("T_r2", "C_1", "C_2")]
    files = [str(tmp_path / "run.csv"), "--output", str(tmp_path / "out")]
    return [*files, "--fix", *fixed, "--starts", "3", "--jobs", "1", *more]


def test_the_command_goes_on_with_a_search_that_was_stopped(tmp_path, capsys, monkeypatch):
    csv_of(STICKING, tmp_path / "run.csv")
    solve, count = module._solve, []

    def stop(*given):
        count.append(given)
        if len(count) >= 3:
            raise KeyboardInterrupt
        return solve(*given)

    with monkeypatch.context() as patch:
        patch.setattr(module, "_solve", stop)
        assert command.main(words_of(tmp_path)) == 130  # the last fit is stopped too
    said = capsys.readouterr().err
    assert "2 fits are kept; to go on: drillrig calibrate" in said
    assert said.rstrip().endswith("--resume")
    assert not (tmp_path / "out").exists()
    with pytest.raises(SystemExit):
        command.main(words_of(tmp_path))
    assert "holds a search that was stopped" in capsys.readouterr().err
    with pytest.raises(SystemExit):
        command.main(words_of(tmp_path, "--resume", "--seed", "7"))
    assert "a search with seed = 0, here 7" in capsys.readouterr().err
    with pytest.raises(SystemExit):
        command.main([str(tmp_path / "run.csv"), "--resume"])
    assert "--resume is given without --output" in capsys.readouterr().err
    found = []
    monkeypatch.setattr(command, "_report", lambda calibration, *_: found.append(calibration.best))
    assert command.main(words_of(tmp_path, "--resume")) == 0
    assert not (tmp_path / "out.search.json").exists()
    assert command.main(words_of(tmp_path, "--overwrite")) == 0
    assert found[0].starts == 3
    same(*found)


def run(tmp_path, *more):
    return subprocess.Popen(
        [sys.executable, "-m", "drillrig_env.calibrate.command", *words_of(tmp_path, *more)],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        start_new_session=True,
    )


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="signals")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGKILL])
def test_a_signal_ends_all_processes_and_keeps_what_is_done(tmp_path, number):
    csv_of(STICKING, tmp_path / "run.csv")
    path = tmp_path / "out.search.json"
    process = run(tmp_path, "--starts", "200", "--jobs", "2")
    while not path.exists():
        assert process.poll() is None
        time.sleep(0.1)
    begun = time.monotonic()
    if number == signal.SIGINT:
        for _ in range(2):  # the second one ends the last fit
            os.killpg(process.pid, number)  # as a terminal does
            time.sleep(2.0)
    else:
        process.kill()
    process.communicate()  # until all that have its output are at their end
    assert time.monotonic() - begun < 20.0
    assert 0 < len(json.loads(path.read_text())["ended"]) < 200
