import pytest

from agents.policy.run_folder import shipped
from agents.shipping import action_zero, failures
from agents.shipping.named import add_names_argument
from drillrig_env.command_line import Parser

COMMANDS = (action_zero, failures)


def test_all_shipped_agents_where_none_is_named():
    parser = Parser()
    add_names_argument(parser)
    assert parser.parse_args([]).names == shipped()
    assert parser.parse_args(["sac", "ppo"]).names == ["sac", "ppo"]
    assert f"default: {', '.join(shipped())}" in " ".join(parser.format_help().split())


@pytest.mark.parametrize("module", COMMANDS, ids=lambda module: module.__name__)
def test_an_unknown_name_is_refused_before_anything_is_done(module, monkeypatch, capsys):
    for does in ("write_card", "add_action_zero", "write_failures"):
        monkeypatch.delattr(module, does, raising=False)
    with pytest.raises(SystemExit) as end:
        module.main(["sac", "ppo_sfot"])
    assert end.value.code == 2
    error = capsys.readouterr().err
    assert "'ppo_sfot' is no shipped agent; did you mean ppo_soft? allowed: ppo, " in error
