"""What is saved is read again; what was damaged or edited is refused by name; a cut leaves what was there."""

import json
import lzma

import numpy as np
import pytest

from drillrig_env.evaluation import store
from drillrig_env.evaluation.histories import Histories
from drillrig_env.evaluation.results import Results
from drillrig_env.evaluation.store import (
    clear,
    clear_pictures,
    holds_results,
    picture_name,
    read,
    read_histories,
    save,
)


@pytest.mark.parametrize("packed", [False, True])
def test_results_and_histories_come_back(comparison, tmp_path, packed):
    results, histories = comparison
    folder = tmp_path / "new" / "folder"
    save(folder, results, histories, packed)
    again = read(folder)
    assert again.rows == results.rows
    assert (again.config, again.provenance) == (results.config, results.provenance)
    assert again.estimates["load"].keys() == results.estimates["load"].keys()
    assert read_histories(folder).kept.keys() == histories.kept.keys()
    assert (folder / "results.csv.xz").exists() == packed


def test_the_file_says_what_it_holds_and_has_no_nan(comparison, tmp_path):
    results, histories = comparison
    save(tmp_path, results, histories)
    text = (tmp_path / "results.json").read_text()
    content = json.loads(text)
    assert content["files"]["results.csv"]["rows"] == 3 * (24 + 24 + 3 * 24)
    assert list(content["files"]["histories.npz"]) == ["sha256"]
    assert content["provenance"]["versions"]["numpy"] == np.__version__
    assert content["config"]["suites"]["degraded"]["env"]["delay"] == [1, 5]
    assert content["config"]["policies"]["privileged"]["privileged"] == ["normal_force", "mu_s", "mu_k", "v_b"]
    assert "NaN" not in text


def without_last_row(content):
    return b"".join(content.splitlines(keepends=True)[:-1])


@pytest.mark.parametrize(
    ("name", "damage", "words"),
    [
        ("results.csv", without_last_row, r"results.csv is damaged: it has 359 rows, and had 360 when it was written"),
        ("results.csv", lambda content: b"", r"results.csv is damaged: it has 0 rows, and had 360"),
        ("results.csv", lambda content: content[:-3], r"results.csv is damaged: it has 359 rows"),
        (
            "results.csv",
            lambda content: content.replace(b"constant,,0,", b"constant,,1,", 1),
            r"is not what was written",
        ),
        ("results.json", lambda content: content[:1000], r"results.json is damaged: it is not JSON"),
        ("results.json", lambda content: b"{}", r"results.json is damaged: 'config' is missing"),
        ("results.json", lambda content: b"[1]", r"results.json is damaged: it holds no object"),
    ],
)
def test_what_was_damaged_is_refused_in_a_sentence_that_says_what_to_do(comparison, tmp_path, name, damage, words):
    save(tmp_path, *comparison)
    path = tmp_path / name
    before = path.read_bytes()
    path.write_bytes(damage(before))
    assert path.read_bytes() != before
    with pytest.raises(ValueError, match=words) as found:
        read(tmp_path)
    assert str(path) in str(found.value)
    assert "put a copy of it back, or remove the folder and evaluate again" in str(found.value)


def test_results_of_an_earlier_version_are_told_from_damaged_ones(comparison, tmp_path):
    save(tmp_path, *comparison)
    content = json.loads((tmp_path / "results.json").read_text())
    del content["files"]
    (tmp_path / "results.json").write_text(json.dumps(content))
    for read_part in (read, read_histories):
        with pytest.raises(ValueError, match=r"is of an earlier version, which kept no digests.*evaluate again$"):
            read_part(tmp_path)


def test_packed_rows_that_were_cut_are_refused(comparison, tmp_path):
    save(tmp_path, *comparison, packed=True)
    path = tmp_path / "results.csv.xz"
    path.write_bytes(path.read_bytes()[:-100])
    with pytest.raises(ValueError, match=r"results.csv.xz is damaged: it cannot be unpacked"):
        read(tmp_path)
    path.write_bytes(lzma.compress(b"suite,policy\n"))
    with pytest.raises(ValueError, match="it has 0 rows, and had 360"):
        read(tmp_path)


def test_damaged_histories_are_refused_and_the_results_are_not(comparison, tmp_path):
    save(tmp_path, *comparison)
    path = tmp_path / "histories.npz"
    path.write_bytes(path.read_bytes()[:-1])
    with pytest.raises(ValueError, match=r"histories.npz is damaged: it is not what was written"):
        read_histories(tmp_path)
    path.unlink()
    with pytest.raises(ValueError, match=r"histories.npz is missing"):
        read_histories(tmp_path)
    assert read(tmp_path).policies


def test_a_folder_without_results_is_refused(comparison, tmp_path):
    with pytest.raises(ValueError, match=r"holds no results: results.json is missing"):
        read(tmp_path)
    save(tmp_path, *comparison)
    (tmp_path / "results.csv").unlink()
    with pytest.raises(ValueError, match=r"holds no results: results.csv is missing"):
        read(tmp_path)


class Cut(BaseException):
    """A kill at a bad moment."""


@pytest.mark.parametrize("files", [1, 2, 3])
def test_a_save_that_is_cut_leaves_what_can_be_read(comparison, tmp_path, monkeypatch, files):
    whole, histories = comparison
    first = Results(whole.config, whole.provenance)
    first.add("default", "constant", whole.scores["default"]["constant"])
    save(tmp_path, first, Histories())
    written = []

    def until(write):
        def cut(path, content):
            if len(written) == files:
                raise Cut
            written.append(path)
            write(path, content)

        return cut

    for name in ("write_bytes", "write_text"):
        monkeypatch.setattr(store, name, until(getattr(store, name)))
    if files < 3:
        with pytest.raises(Cut):
            save(tmp_path, whole, histories)
    else:
        save(tmp_path, whole, histories)
    assert read(tmp_path).rows == (whole if files == 3 else first).rows
    assert read_histories(tmp_path).kept.keys() == (histories.kept.keys() if files > 1 else set())
    monkeypatch.undo()
    save(tmp_path, whole, histories)
    assert read(tmp_path).rows == whole.rows


def test_clear_removes_an_evaluations_files_and_no_others(comparison, tmp_path):
    save(tmp_path, *comparison)
    for name in ("scores_default", "histories_load_below", "map_of_the_site"):
        (tmp_path / f"{name}.png").touch()
    clear_pictures(tmp_path)
    assert holds_results(tmp_path)
    assert [path.name for path in tmp_path.glob("*.png")] == ["map_of_the_site.png"]
    clear(tmp_path)
    assert not holds_results(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["map_of_the_site.png"]


def test_half_of_an_evaluation_is_seen(tmp_path):
    assert not holds_results(tmp_path)
    (tmp_path / "results.csv").touch()
    assert holds_results(tmp_path)


def test_pictures_have_the_name_of_what_they_show():
    assert picture_name("scores", "default") == "scores_default"
    assert picture_name("histories_below", "load") == "histories_load_below"
