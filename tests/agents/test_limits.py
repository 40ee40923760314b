"""What limits where nobody knows the rig: the conditions, and what a table says of them."""

import json

import numpy as np
import pytest

from agents import limits as module
from agents.limits import COLUMNS, conditions, limits, main, table
from agents.unknown import BESIDE
from drillrig_env.evaluation.runner import run
from drillrig_env.evaluation.suites import suite


def test_each_condition_takes_away_what_it_says_and_keeps_the_episodes():
    drawn, asked = suite("unknown", 3), conditions(3)
    assert asked["as it is"].definition() == drawn.definition()
    found = {name: (one.env["noise"], one.env["delay"], one.scenario.rigs is not None) for name, one in asked.items()}
    assert found == {
        "as it is": (1.0, (1, 2), True),
        "exact": (0.0, (1, 2), True),
        "at once": (1.0, 0, True),
        "exact, at once": (0.0, 0, True),
        "nominal rig": (1.0, (1, 2), False),
        "nominal rig, exact, at once": (0.0, 0, False),
    }
    for one in asked.values():
        assert (one.first_seed, one.rigs, one.scenario.load_step) == (drawn.first_seed, 48, drawn.scenario.load_step)
        assert one.groups[0][1]["start"] == "stick_slip"


@pytest.mark.slow
def test_every_policy_faces_every_condition(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(module, "BESIDE", {name: BESIDE[name] for name in ("constant", "baselines/told.py:LQROfRig")})
    main(["ppo_surface", "--rigs", "2", "--docs", str(tmp_path)])
    content = json.loads((tmp_path / "agents" / "limits.json").read_text())
    assert content["command"].startswith("python -m agents.limits ppo_surface")
    assert set(content["conditions"]) == set(conditions(2))
    headings = [column.heading for column in COLUMNS]
    for policies in content["conditions"].values():
        assert list(policies) == ["`ppo_surface`", *module.BESIDE.values()]
        ceiling = policies[BESIDE["baselines/told.py:LQROfRig"]]
        assert list(ceiling) == headings
        assert ceiling["mitigated"]["value"] >= policies[BESIDE["constant"]]["mitigated"]["value"]
        assert np.isfinite(ceiling["mitigated"]["high"])
    assert "| `ppo_surface` | " in capsys.readouterr().out
    assert table(content).count("\n") >= 4
    del content["conditions"]["at once"]
    del content["conditions"]["exact"]["`ppo_surface`"]
    (tmp_path / "agents" / "limits.json").write_text(json.dumps(content))
    asked = []
    monkeypatch.setattr(module, "run", lambda policy, one, **others: asked.append(one) or run(policy, one, **others))
    main(["ppo_surface", "--rigs", "2", "--docs", str(tmp_path)])
    assert [one.env["delay"] for one in asked] == [(1, 2), 0, 0, 0]  # what was missing
    again = json.loads((tmp_path / "agents" / "limits.json").read_text())
    assert set(again["conditions"]) == set(conditions(2))
    again["models"]["`ppo_surface`"] = "that of another"
    (tmp_path / "agents" / "limits.json").write_text(json.dumps(again))
    main(["ppo_surface", "--rigs", "2", "--docs", str(tmp_path)])
    assert len(asked) == 4 + 6
    main(["ppo_surface", "--rigs", "2", "--docs", str(tmp_path), "--overwrite"])
    assert len(asked) == 4 + 6 + 18


def test_an_unknown_agent_is_refused_before_anything_runs():
    with pytest.raises(ValueError, match="neither a shipped agent nor the folder of a run"):
        next(limits(["nobody"], 1))
