"""A release: it refuses before anything is changed, and leaves version, changelog, wheel, commit and tag."""

import json
import shutil
import subprocess
import zipfile
from pathlib import Path

import pytest

from docs import release
from docs.release import PARTS, main, renumbered

NOTHING = {"nothing": ("this",)}  # the Zen of Python: a module that runs, and holds
DIGESTS = {"a machine": {"single DrillRig-v0": {"digest": "1"}, "policy lqg": {"digest": "2"}}}


def git(tree, *words):
    return subprocess.run(["git", *words], cwd=tree, capture_output=True, text=True, check=True).stdout.strip()


@pytest.fixture
def tree(tmp_path, monkeypatch):
    """A small project of its own, committed, with checks that hold and packages that are built at once."""
    for name in ("GIT_AUTHOR_NAME", "GIT_COMMITTER_NAME", "GIT_AUTHOR_EMAIL", "GIT_COMMITTER_EMAIL"):
        monkeypatch.setenv(name, "somebody@example.org")
    tree = tmp_path / "tree"
    files = {
        "drillrig_env/__init__.py": '"""A rig."""\n\n__version__ = "0.2.0"\n',
        "CITATION.cff": "title: DrillRig\nversion: 0.2.0\nlicense: MIT\n",
        "CHANGELOG.md": "# Changes\n\n## Unreleased\n\n- New: a rig.\n\n## 0.1.0\n\nFirst.\n",
        "tests/digests.json": json.dumps(DIGESTS),
        ".gitignore": "/dist/\n",
    }
    for name, text in files.items():
        (tree / name).parent.mkdir(parents=True, exist_ok=True)
        (tree / name).write_text(text)
    git(tree, "init", "--quiet", "--initial-branch", "main")
    git(tree, "add", "--all")
    git(tree, "commit", "--quiet", "--message", "Begin")

    def build(copy, version):
        package = copy / "dist" / f"drillrig-{version}-py3-none-any.whl"
        package.parent.mkdir()
        package.write_text((copy / "drillrig_env" / "__init__.py").read_text())
        return [package]

    monkeypatch.setattr(release, "ROOT", tree)
    monkeypatch.setattr(release, "CHECKS", NOTHING)
    monkeypatch.setattr(release, "build", build)
    return tree


def everything(tree):
    return (
        git(tree, "rev-parse", "HEAD"),
        git(tree, "tag"),
        git(tree, "status", "--porcelain"),
        git(tree, "worktree", "list"),
    )


def test_a_release_is_a_commit_a_tag_and_packages(tree):
    assert main(["0.3.0"]) == 0
    assert '__version__ = "0.3.0"' in git(tree, "show", "v0.3.0:drillrig_env/__init__.py")
    assert "\nversion: 0.3.0\ndate-released: 20" in git(tree, "show", "v0.3.0:CITATION.cff")
    changes = git(tree, "show", "v0.3.0:CHANGELOG.md")
    assert "\n## 0.3.0, 20" in changes
    assert "Unreleased" not in changes
    assert "New: a rig." in git(tree, "tag", "--list", "--format=%(contents)", "v0.3.0")
    assert git(tree, "rev-parse", "main") == git(tree, "rev-parse", "v0.3.0^{commit}")
    assert 'version__ = "0.3.0"' in (tree / "dist" / "drillrig-0.3.0-py3-none-any.whl").read_text()
    assert git(tree, "status", "--porcelain") == ""
    assert len(git(tree, "worktree", "list").splitlines()) == 1


def test_a_dry_run_changes_nothing(tree, capsys):
    before = everything(tree)
    assert main(["0.2.0", "--dry-run"]) == 0
    assert "v0.2.0 can be released: drillrig-0.2.0-py3-none-any.whl" in capsys.readouterr().out
    assert everything(tree) == before
    assert not (tree / "dist").exists()


def test_a_check_that_fails_refuses_it_and_changes_nothing(tree, monkeypatch, capsys):
    monkeypatch.setattr(release, "CHECKS", {**NOTHING, "tests": ("json.tool", "CITATION.cff")})
    before = everything(tree)
    assert main(["0.3.0"]) == 1
    said = capsys.readouterr().err
    assert "the tests of the release: nothing has been changed. python -m json.tool CITATION.cff" in said
    assert "Expecting value" in said
    assert everything(tree) == before


def test_a_tree_with_changes_is_refused(tree, capsys):
    (tree / "new.py").write_text("")
    assert main(["0.3.0"]) == 1
    assert "changes that are not committed: ?? new.py" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("version", "said"), [("0.1.9", "below 0.2.0"), ("0.3", "allowed: X.Y.Z"), ("v0.3.0", "allowed: X.Y.Z")]
)
def test_a_version_that_cannot_be_is_refused(version, said, tree, capsys):
    with pytest.raises(SystemExit) as end:
        main([version])
    assert end.value.code == 2
    assert said in capsys.readouterr().err


def test_a_version_is_released_once_and_says_what_is_new(tree, capsys):
    git(tree, "tag", "v0.3.0")
    assert main(["0.3.0"]) == 1
    assert "v0.3.0 is there already" in capsys.readouterr().err
    assert main(["0.4.0"]) == 0
    assert main(["0.5.0"]) == 1
    assert "says nothing under ## Unreleased" in capsys.readouterr().err


def test_without_a_branch_there_is_none_to_go_on(tree, capsys):
    git(tree, "checkout", "--quiet", "--detach")
    assert main(["0.3.0"]) == 1
    assert "no branch is checked out" in capsys.readouterr().err


def test_an_id_with_other_numbers_is_refused(tree, capsys):
    git(tree, "tag", "v0.2.0")
    other = {"a machine": {"single DrillRig-v0": {"digest": "9"}, "policy lqg": {"digest": "8"}}}
    (tree / "tests" / "digests.json").write_text(json.dumps(other))
    git(tree, "commit", "--quiet", "--all", "--message", "Other numbers")
    assert main(["0.3.0"]) == 1
    assert "the numbers of DrillRig-v0 are not those of v0.2.0" in capsys.readouterr().err
    assert renumbered(DIGESTS, DIGESTS) == []
    assert renumbered(DIGESTS, {"another machine": {}}) == []
    assert renumbered(DIGESTS, {"a machine": {"single DrillRig-v1": {"digest": "9"}}}) == []


@pytest.mark.slow
def test_a_clone_of_the_project_is_released_with_its_wheel(tmp_path, monkeypatch):
    clone = tmp_path / "clone"
    git(Path(__file__).parents[1], "clone", "--quiet", "--no-tags", ".", str(clone))
    git(clone, "switch", "--quiet", "--force-create", "main")
    git(clone, "config", "user.name", "Somebody")
    git(clone, "config", "user.email", "somebody@example.org")
    news = (clone / "CHANGELOG.md").read_text(encoding="utf-8")
    if "## Unreleased" not in news:
        (clone / "CHANGELOG.md").write_text(
            news.replace("\n## ", "\n## Unreleased\n\n- News.\n\n## ", 1), encoding="utf-8"
        )
        git(clone, "commit", "--quiet", "--all", "--message", "News")
    (clone / PARTS).mkdir()
    (clone / PARTS / "uPlot.js").write_text("")  # in the place of what npm fetches
    monkeypatch.setattr(release, "ROOT", clone)
    monkeypatch.setattr(release, "CHECKS", {"linter": release.CHECKS["linter"]})
    assert main(["9.9.9"]) == 0
    names = zipfile.ZipFile(clone / "dist" / "drillrig-9.9.9-py3-none-any.whl").namelist()
    assert {"drillrig-9.9.9.dist-info/METADATA", (PARTS / "uPlot.js").as_posix()} <= set(names)
    assert (clone / "dist" / "drillrig-9.9.9.tar.gz").is_file()
    shutil.rmtree(clone / PARTS)
    assert git(clone, "describe") == "v9.9.9"
