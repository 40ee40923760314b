import csv
import json

import numpy as np

from baselines import Constant, JumpEase
from drillrig_env.evaluation.pictures import plot_histories, plot_map
from drillrig_env.evaluation.report import markdown_table, print_table, write_csv, write_json
from drillrig_env.evaluation.runner import run
from drillrig_env.evaluation.scores import score
from drillrig_env.evaluation.suites import suite

SUITE = suite("default", 40)
RUNS = {"constant": run(Constant(), SUITE), "jump_ease": run(JumpEase(), SUITE)}
RESULTS = {name: score(episodes) for name, episodes in RUNS.items()}
TOLD = {"jump_ease": True}


def test_table_marks_who_is_told(capsys):
    table = markdown_table(RESULTS, TOLD)
    assert "| jump_ease * |" in table
    assert "| constant |" in table
    assert f"{RESULTS['constant']['mitigated'].mean():.3f}" in table
    print_table("title", RESULTS, TOLD)
    assert "jump_ease *" in capsys.readouterr().out


def test_files_hold_every_episode_and_what_made_them(tmp_path):
    write_csv(tmp_path / "results.csv", {"default": RESULTS})
    rows = list(csv.DictReader((tmp_path / "results.csv").open()))
    assert len(rows) == 80
    mitigated = [int(row["mitigated"]) for row in rows if row["policy"] == "constant"]
    assert mitigated == RESULTS["constant"]["mitigated"].astype(int).tolist()
    write_json(tmp_path / "results.json", {"rigs": 40}, {"default": RESULTS})
    content = json.loads((tmp_path / "results.json").read_text())
    assert content["provenance"]["versions"]["numpy"] == np.__version__
    assert content["estimates"]["default"]["constant"]["mitigated"]["value"] == np.mean(mitigated)


def test_pictures_are_written(tmp_path):
    plot_histories(RUNS, 3, tmp_path / "histories.png")
    plot_map(RESULTS, RUNS["constant"].rig, tmp_path / "map.png")
    for name in ("histories.png", "map.png"):
        assert (tmp_path / name).read_bytes().startswith(b"\x89PNG")
