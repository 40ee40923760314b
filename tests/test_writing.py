"""Every command that writes asks before its work whether it can, and makes the folders that are missing."""

from importlib import import_module

import pytest

from drillrig_env import Rig
from drillrig_env.cli.info import main as info
from drillrig_env.cli.simulate import main as simulate

COMMANDS = [
    ("drillrig_env.cli.info", "--write {}/rig.toml", "drillrig_env.toml.write_text"),
    ("drillrig_env.cli.simulate", "--csv {}/run.csv", "drillrig_env.simulation.simulate"),
    ("drillrig_env.cli.simulate", "--picture {}/run.png", "drillrig_env.simulation.simulate"),
    ("drillrig_env.cli.evaluate", "constant --output {}", "drillrig_env.evaluation.pieces.run"),
    ("drillrig_env.plots.__main__", "--output {}", "drillrig_env.plots.figures.write"),
    ("drillrig_env.plots.animation", "--output {}/film.gif", "drillrig_env.plots.animation.save"),
    ("docs.make.__main__", "agents --docs {}", "docs.make.agents.page"),
    ("baselines.tune", "z_torque --output {}/tuned.json", "baselines.tune.search"),
    ("agents.compare", "ablations --output {}/found.json", "agents.compare.compare"),
    ("agents.limits", "ppo_unknown --docs {}", "agents.limits.limits"),
    ("benchmarks.calibrated_rigs", "--rigs 1 --json {}/found.json", "benchmarks.calibrated_rigs.found_of"),
    ("drillrig_env.deploy.export", "lqg --out {}/lqg.onnx", "drillrig_env.deploy.export.policy_to_export"),
]


@pytest.mark.parametrize(("module", "words", "work"), COMMANDS, ids=lambda word: word if " " in word else "")
def test_what_cannot_be_written_is_found_before_the_work(module, words, work, tmp_path, monkeypatch, capsys):
    (tmp_path / "file").touch()
    monkeypatch.chdir(tmp_path)
    main = import_module(module).main
    monkeypatch.setattr(work, lambda *_, **__: pytest.fail("worked"))
    assert main(words.format(tmp_path / "file").split()) == 1
    assert "cannot be written" in capsys.readouterr().err


def test_a_missing_folder_is_made(tmp_path):
    assert info(["--write", str(tmp_path / "rigs" / "mine.toml")]) == 0
    assert Rig.of(tmp_path / "rigs" / "mine.toml") == Rig()
    assert simulate(["--duration", "1", "--csv", str(tmp_path / "runs" / "one.csv")]) == 0
    assert (tmp_path / "runs" / "one.csv").is_file()
