"""Nothing is written over unasked; what is gone on with is of the same making."""

import numpy as np
import pytest

from drillrig_env.evaluation.beginning import begin, check_same
from drillrig_env.evaluation.contest import Contestant, config_of
from drillrig_env.evaluation.histories import Histories
from drillrig_env.evaluation.results import Results
from drillrig_env.evaluation.store import holds_results, save
from drillrig_env.evaluation.suites import suite


def config(rigs=6, env="DrillRig-v0", version="1", policies=("a",), suites=("default",), **about):
    field = [Contestant(name, {"": lambda suite: None}, {"sensors": "state"}, (), None, about) for name in policies]
    return config_of(env, [suite(name, rigs) for name in suites], field, version, "command", "a")


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"rigs": 7}, r"suite default is not what it was: rigs was 6, and is 7 now"),
        ({"env": "DrillRigSurface-v0"}, r"env was DrillRig-v0"),
        ({"version": "2"}, r"version was 1, and is 2 now"),
        ({"gain": 3.0}, r"policy a is not what it was: gain was None, and is 3.0 now"),
    ],
)
def test_a_run_of_another_making_is_not_continued(change, words, tmp_path):
    check_same(config(), config(), tmp_path)
    with pytest.raises(ValueError, match=f"holds results of another making: {words}"):
        check_same(config(), config(**change), tmp_path)


SCORES = {"seed": np.array([""] * 6), "episode": np.arange(6), "cost": np.linspace(0.0, 1.0, 6)}


@pytest.fixture
def folder(tmp_path):
    """A folder with the results of two policies, and a picture of them."""
    results = Results(config(policies=("a", "b")), {})
    for name in ("a", "b"):
        results.add("default", name, SCORES)
    save(tmp_path, results, Histories())
    (tmp_path / "scores_default.png").touch()
    return tmp_path


def test_an_empty_folder_is_begun_with_nothing(tmp_path):
    results, histories = begin(tmp_path / "new", config())
    assert (results.policies, histories.kept, results.config) == ([], {}, config())
    assert not (tmp_path / "new").exists()
    assert begin(tmp_path, config(), resume=True)[0].policies == []


def test_what_the_command_makes_again_is_replaced_pictures_too(folder):
    results, _ = begin(folder, config(policies=("a", "b", "c"), suites=("default", "load")))
    assert results.policies == []
    assert list(folder.iterdir()) == []


@pytest.mark.parametrize(
    ("now", "words"),
    [
        ({"policies": ("a",)}, "holds results of b, which this command would not make again"),
        ({"policies": ("a", "b"), "suites": ("load",)}, "holds results of suite default, which"),
        ({"policies": ("c",)}, "holds results of a and b, which"),
        ({"policies": ("a", "b"), "version": "2"}, "version was 1, and is 2 now"),
    ],
)
def test_other_results_are_never_written_over_unasked(folder, now, words):
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    with pytest.raises(ValueError, match=words) as found:
        begin(folder, config(**now))
    for way in ("--overwrite", "--output"):
        assert way in str(found.value)
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before
    assert begin(folder, config(**now), overwrite=True)[0].policies == []
    assert not holds_results(folder)


def test_resume_keeps_what_is_there(folder):
    results, _ = begin(folder, config(policies=("c",)), resume=True)
    assert results.policies == ["a", "b"]
    assert list(results.config["policies"]) == ["c", "a", "b"]
    assert holds_results(folder)
    with pytest.raises(ValueError, match="version was 1"):
        begin(folder, config(version="2"), resume=True)


def test_damage_is_refused_but_where_it_does_not_matter(folder):
    said = []
    (folder / "histories.npz").write_bytes(b"PK")
    assert begin(folder, config(), resume=True, say=said.append)[0].policies == ["a", "b"]
    assert "histories.npz is damaged" in said[0]
    (folder / "results.csv").write_bytes(b"")
    for resume in (True, False):
        with pytest.raises(ValueError, match=r"results.csv is damaged"):
            begin(folder, config(policies=("a", "b")), resume=resume)
    assert begin(folder, config(), overwrite=True)[0].policies == []
