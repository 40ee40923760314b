"""The benchmark over rigs of all kinds: what it draws, its own solution, its table."""

import json

import numpy as np
import pytest

from benchmarks import any_rig
from benchmarks.any_rig import Case, draw, error_of, main, reference, speed_scale
from benchmarks.radau9 import solve
from drillrig_env import Friction, Rig
from drillrig_env.model import steady_state
from drillrig_env.reference import radau


def test_draws_are_the_same_for_the_same_seed_and_within_their_ranges():
    cases = draw(300, 3)
    assert all(case.numbers() == Case.of(case.numbers()).numbers() for case in cases)
    assert [case.numbers() for case in draw(5, 3)] == [case.numbers() for case in cases[:5]]
    for name in ("J_1", "L", "k_i", "eta"):
        shares = [getattr(case.rig, name) / getattr(Rig(), name) for case in cases]
        assert 0.1 <= min(shares) < 0.15
        assert 7.0 < max(shares) <= 10.0
    assert all(case.rig.T_r2 == 0.0 and case.friction.mu_s >= case.friction.mu_k for case in cases)
    assert 0.1 <= min(case.speed_reference for case in cases) < 50.0


@pytest.mark.slow
def test_reference_agrees_with_scipys():
    rig, friction = Rig(J_2=0.004, L=3e-3, k_p=1.3), Friction(26.0, 0.55, 0.3, 1.6)
    start = np.array([0.0, 0.0, 1.8, 1.8, 1.8, 0.5, 0.0])
    found = solve(rig, friction, start, 1.8, 0.5, 8)
    expected = radau(rig, friction, 1.8, start, np.linspace(0.0, 4.0, 9), rtol=1e-10, atol=1e-12)
    np.testing.assert_allclose(found[1:, :5], expected[:, :5], atol=1e-8)


def test_reference_keeps_steady_rotation():
    rig, friction = Rig(R=1.0), Friction(9.0, 0.3, 0.3)
    start = steady_state(rig, friction, 2.5)
    np.testing.assert_allclose(solve(rig, friction, start, 2.5, 0.7, 3), np.broadcast_to(start, (4, 7)), atol=1e-10)


def test_rig_that_runs_away_has_no_reference():
    case = Case(Rig(k_p=0.0, k_i=9e5), Friction(5.0), (0.0,) * 7, 1.0)
    assert reference(case) is None


def test_error_is_a_share_of_the_speed_scale():
    case = Case(Rig(), Friction(0.0), tuple(steady_state(Rig(), Friction(0.0), 40.0).tolist()), 40.0)
    speeds = np.full((21, 3), 40.0)
    assert speed_scale(case, speeds) == pytest.approx(4.0)
    assert error_of(case, speeds, 0.25) < 1e-9
    assert error_of(case, speeds + 2e-3, 0.25) == pytest.approx(5e-4, rel=1e-3)


def test_command_prints_the_table_and_writes_figures(tmp_path, capsys, monkeypatch):
    refusing = any_rig.error_of

    def error(case, speeds, period):
        if case.speed_reference == draw(3, 1)[1].speed_reference:
            raise ValueError("it cannot be")
        return refusing(case, speeds, period)

    monkeypatch.setattr(any_rig, "error_of", error)
    path = tmp_path / "any_rig.json"
    assert main(["--rigs", "3", "--seed", "1", "--json", str(path)]) in (None, 0)
    printed = capsys.readouterr()
    assert "| rigs | 3 |" in printed.out
    assert "refused: rig 1: it cannot be" in printed.out
    assert "rigs done in" in printed.err
    outcomes = json.loads(path.read_text(encoding="utf-8"))["results"]["outcomes"]
    assert [outcome["rig"] for outcome in outcomes] == [0, 1, 2]
    assert outcomes[0]["error"] < 1e-6


def test_one_rig_alone_keeps_its_number(tmp_path, capsys):
    path = tmp_path / "any_rig.json"
    assert main(["--rigs", "3", "--seed", "1", "--only", "2", "--period", "0.25", "--json", str(path)]) in (None, 0)
    assert "rig 2 at" in capsys.readouterr().out
    assert [outcome["rig"] for outcome in json.loads(path.read_text(encoding="utf-8"))["results"]["outcomes"]] == [2]


def test_a_look_at_one_rig_leaves_the_figures_of_all_alone(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    main(["--rigs", "2", "--seed", "3"])
    whole = (tmp_path / "results/benchmarks/any_rig.json").read_bytes()
    main(["--rigs", "2", "--seed", "3", "--only", "1"])
    assert (tmp_path / "results/benchmarks/any_rig.json").read_bytes() == whole
    assert (tmp_path / "results/benchmarks/any_rig_1.json").exists()


@pytest.mark.parametrize(("flag", "value"), [("--period", "0.3"), ("--only", "4"), ("--only", "-1")])
def test_command_refuses_what_it_cannot_do(flag, value, tmp_path):
    with pytest.raises(SystemExit):
        main(["--rigs", "4", flag, value, "--json", str(tmp_path / "any_rig.json")])
    assert not list(tmp_path.iterdir())


def test_a_run_that_was_stopped_is_gone_on_with(tmp_path, monkeypatch, capsys):
    asked = []

    def outcome(_period, piece):
        asked.append(piece[0])
        if len(asked) == 3:
            raise KeyboardInterrupt
        return {"rig": piece[0], "error": 1e-9}

    monkeypatch.setattr(any_rig, "outcome_of", outcome)
    words = ["--rigs", "4", "--json", str(tmp_path / "any_rig.json")]
    assert main(words) == 130
    assert main([*words, "--resume"]) == 0
    assert asked == [0, 1, 2, 2, 3]
    outcomes = json.loads((tmp_path / "any_rig.json").read_text())["results"]["outcomes"]
    assert [one["rig"] for one in outcomes] == [0, 1, 2, 3]
    capsys.readouterr()
    with pytest.raises(SystemExit):
        main([*words, "--resume", "--seed", "1"])
    assert "any_rig.json is of seed = 0, not 1" in capsys.readouterr().err
