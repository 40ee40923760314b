"""What limits where nobody knows the rig: the conditions, and what a table says of them."""

import json
import shutil
from dataclasses import asdict

import numpy as np
import pytest

from agents import limits as module
from agents.limits import conditions, limits, main
from agents.limits_kept import COLUMNS, FILE, read_limits, section, table
from agents.policy.run_folder import CONFIG, MODEL, TRAINED, load_policy
from agents.unknown import BESIDE
from drillrig_env.evaluation.runner import run
from drillrig_env.evaluation.statistics import Estimate
from drillrig_env.evaluation.suites import suite
from drillrig_env.policy import find_policy
from drillrig_env.rig import Rig
from drillrig_env.scales import SLEW_LIMIT


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


@pytest.fixture
def quick(monkeypatch):
    """Beside agents there is one law, and what is asked is not computed, only listed."""
    asked = []

    def scored(outcome):
        asked.append(outcome)
        return {"mitigated": np.ones(2)}

    monkeypatch.setattr(module, "BESIDE", {"constant": BESIDE["constant"]})
    monkeypatch.setattr(module, "run", lambda policy, one, **_: type(policy).__name__)
    monkeypatch.setattr(module, "score", scored)
    share = Estimate(0.5, 0.4, 0.6, 2)
    monkeypatch.setattr(module, "estimates", lambda scores, columns: {one.heading: share for one in columns})
    return asked


def a_run(folder, agent="ppo_surface"):
    folder.mkdir(parents=True)
    for name in (CONFIG, MODEL):
        shutil.copy(TRAINED / agent / name, folder)
    return str(folder)


def command(docs, *words):
    return main(["--rigs", "2", "--docs", str(docs), *words])


def stored(docs):
    return json.loads((docs / FILE).read_text())


def refused(capsys, docs, *words):
    """What is said on the standard error where arguments are bad."""
    with pytest.raises(SystemExit) as end:
        command(docs, *words)
    assert end.value.code == 2
    return capsys.readouterr().err


def test_other_agents_stay_in_the_file(quick, tmp_path):
    one, other = (a_run(tmp_path / name) for name in ("one", "other"))
    command(tmp_path, one)
    command(tmp_path, other)
    assert len(quick) == 6 * 2 + 6
    content = stored(tmp_path)
    assert list(content["models"]) == ["`one`", "`other`"]
    for rows in content["conditions"].values():
        assert list(rows) == ["`one`", "`other`", BESIDE["constant"]]
    content["models"]["`ppo_surface`"] = "one that does not ship any more"
    content["conditions"]["exact"]["`ppo_surface`"] = content["conditions"]["exact"]["`one`"]
    (tmp_path / FILE).write_text(json.dumps(content))
    command(tmp_path, one)
    assert list(stored(tmp_path)["models"]) == ["`one`", "`other`"]
    assert list(stored(tmp_path)["conditions"]["exact"]) == ["`one`", "`other`", BESIDE["constant"]]


def test_two_at_a_time_keep_what_both_have_found(quick, tmp_path, monkeypatch):
    one, other = (a_run(tmp_path / name) for name in ("one", "other"))
    first, begun = module.limits, []

    def while_another_runs(*given):
        for found in first(*given):
            if not begun:
                begun.append(True)
                command(tmp_path, other)
            yield found

    monkeypatch.setattr(module, "limits", while_another_runs)
    command(tmp_path, one)
    for rows in stored(tmp_path)["conditions"].values():
        assert set(rows) == {"`one`", "`other`", BESIDE["constant"]}


def test_a_file_of_other_rigs_is_refused_and_left(quick, tmp_path, capsys):
    run = a_run(tmp_path / "one")
    command(tmp_path, run)
    before = (tmp_path / FILE).read_bytes()
    told = refused(capsys, tmp_path, run, "--rigs", "3")
    assert "is of 2 rigs, not of 3; name another folder with --docs, or begin anew with --overwrite" in told
    assert (tmp_path / FILE).read_bytes() == before
    assert len(quick) == 6 * 2
    command(tmp_path, run, "--rigs", "3", "--overwrite")
    assert stored(tmp_path)["rigs"] == 3


def test_an_agent_that_was_added_and_stopped_is_not_shown_yet(quick, tmp_path):
    command(tmp_path, a_run(tmp_path / "one"))
    content = stored(tmp_path)
    first = next(iter(content["conditions"].values()))
    content["conditions"][next(iter(content["conditions"]))] = {"`other`": first["`one`"], **first}
    (tmp_path / FILE).write_text(json.dumps(content))
    page = section(read_limits(tmp_path))
    assert "| `one` | 0.500 |" in page
    assert "`other`" not in page


def test_names_that_tables_cannot_tell_apart_are_refused(quick, tmp_path, capsys):
    one, other = (a_run(tmp_path / name / "seed_0") for name in ("a", "b"))
    told = refused(capsys, tmp_path, one, other)
    assert f"tables would call both {one} and {other} `seed_0`; name their folders otherwise" in told
    module.BESIDE["lqg"] = "`lqg`"
    assert "tables call a law `lqg`; name its folder otherwise" in refused(capsys, tmp_path, a_run(tmp_path / "lqg"))
    assert not quick


@pytest.mark.parametrize("rigs", ["0", "257", "2.5"])
def test_only_as_many_rigs_as_the_fleet_has_are_allowed(rigs, tmp_path, capsys):
    told = refused(capsys, tmp_path, "ppo_surface", "--rigs", rigs)
    assert f"--rigs: '{rigs}' is not allowed; allowed: whole, >= 1 and <= 256" in told


@pytest.mark.parametrize(
    ("changes", "fault"),
    [
        ({"conditions": None}, "it does not tell conditions"),
        ({"models": []}, "it does not tell models"),
        ({"provenance": {}}, "provenance does not tell date and machine"),
        ({"rigs": "2"}, "rigs = '2'; allowed: whole"),
        ({"conditions": {}}, "it has no condition"),
        ({"conditions": {"as it is": []}}, "what it has of 'as it is' is no estimates by policy"),
        ({"conditions": {"as it is": {"`one`": {"mitigated": {"value": 0.5}}}}}, "what it has of 'as it is' is no"),
    ],
)
def test_a_damaged_file_is_told_in_a_sentence(quick, tmp_path, capsys, changes, fault):
    run = a_run(tmp_path / "one")
    command(tmp_path, run)
    (tmp_path / FILE).write_text(json.dumps(stored(tmp_path) | changes))
    asked = len(quick)
    told = refused(capsys, tmp_path, run)
    assert f"{tmp_path / FILE} is damaged: {fault}" in told
    assert "; begin anew with --overwrite\n" in told
    assert len(quick) == asked
    with pytest.raises(ValueError, match=r"make it again with: python -m agents\.limits ppo_unknown --overwrite"):
        read_limits(tmp_path)
    command(tmp_path, run, "--overwrite")
    assert read_limits(tmp_path) is not None


def test_an_agent_of_another_drive_is_refused():
    with pytest.raises(ValueError, match="agent = ppo_surface_soft is not allowed; allowed: one on the rig's own"):
        next(limits(["ppo_surface_soft"], 2))


def test_an_agent_of_another_rig_acts_as_where_it_is_evaluated(five_seeds, tmp_path):
    shutil.copytree(five_seeds / "seed_0", tmp_path / "field")
    config = json.loads((tmp_path / "field" / CONFIG).read_text())
    config["env_kwargs"]["rig"] = asdict(Rig.of("field_2500m"))
    (tmp_path / "field" / CONFIG).write_text(json.dumps(config))
    seen = np.random.default_rng(0).uniform(-1.0, 1.0, (4, 12)).astype(np.float32)
    there, here = find_policy(str(tmp_path / "field")).make(), module._agent(str(tmp_path / "field"))
    assert np.array_equal(there.predict(seen)[0], here.predict(seen)[0])
    unscaled = load_policy(tmp_path / "field").at_slew_limit(SLEW_LIMIT)
    assert not np.array_equal(there.predict(seen)[0], unscaled.predict(seen)[0])
