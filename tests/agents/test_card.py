import re

import pytest

from agents.policy.run_folder import TRAINED, read_seeds, shipped
from agents.shipping.card import CARD, card
from drillrig_env.env.scenario import STICK_SLIP

CARDS = [name for name in shipped() if read_seeds(TRAINED / name)]


def test_card_tells_task_scores_training_and_use(trained):
    text = (trained / "ppo" / CARD).read_text(encoding="utf-8")
    assert text == card("ppo", trained)
    about = read_seeds(trained / "ppo")
    for words in (
        "PPO for `DrillRig-v0`",
        f"| {about['shipped']} (shipped) |",
        "| `load` |",
        "on the rig's own drive",
        "seeds s and s + 1 meet the same rigs in all but one environment",
        "MIT",
        about["seeds"]["0"]["machine"],
        "256 steps",
        about["fails"],
    ):
        assert words in text
    assert not re.search(r"\| (nan|None)\b", text)


def test_example_of_the_card_runs(trained, monkeypatch, capsys):
    monkeypatch.setattr("agents.policy.run_folder.TRAINED", trained)
    (block,) = re.findall(r"```python\n(.*?)```", card("ppo", trained), re.DOTALL)
    variables = {}
    exec(compile(block, "card", "exec"), variables)
    assert capsys.readouterr().out.strip() in ("True", "False")
    assert variables["info"]["start"] == STICK_SLIP


def test_agent_without_its_seeds_is_refused(five_seeds, trained):
    with pytest.raises(ValueError, match="not a shipped agent"):
        card("seed_0", five_seeds)
    with pytest.raises(ValueError, match="not a shipped agent"):
        card("sac", trained)


def test_the_uses_have_the_training_times_of_the_card():
    minutes = [one["seconds"] / 60 for one in read_seeds(TRAINED / "ppo")["seeds"].values()]
    uses = (TRAINED.parents[1] / "docs" / "uses.md").read_text(encoding="utf-8")
    assert f"{min(minutes):.0f} to {max(minutes):.0f} minutes" in uses


@pytest.mark.parametrize("name", CARDS)
def test_cards_in_the_package_are_up_to_date(name):
    written = (TRAINED / name / CARD).read_text(encoding="utf-8")
    assert written == card(name), "out of date; run: python -m docs.make cards"


def test_the_example_says_where_its_verdict_is_another_than_the_scores():
    drift, other = (card(name) for name in ("ppo_drift", "ppo_unknown"))
    assert "count it as calm below 0.5, where the bit is certain not to stop" in drift
    assert "certain not to stop" not in other
