"""Release a version: check all that must hold, then write version and changelog, build the wheel, commit and tag.

    python -m docs.release 0.3.0 --dry-run    # everything, and nothing of it is kept
    python -m docs.release 0.3.0              # make release VERSION=0.3.0

Version, changelog and citation are written, checked, built and committed in a copy of the tree (a worktree of git's).
Only when all of it is done does the branch go on to that commit, with the tag v0.3.0, and the packages lie in dist/.
So a check that fails, Ctrl-C and a kill leave the tree as it was. Nothing is pushed: the last lines say how.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
import zipfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path
from tempfile import TemporaryDirectory

from drillrig_env.command_line import Failed, Parser, command
from drillrig_env.files import write_text
from drillrig_env.markdown import listed

ROOT = Path(__file__).parents[1]
PARTS = Path("drillrig_env", "room", "web", "parts")
"""What npm fetches for the control room's page, which git does not have."""

DIGESTS = "tests/digests.json"

CHECKS: dict[str, tuple[str, ...]] = {
    "linter": ("ruff", "check"),
    "format": ("ruff", "format", "--check"),
    "types": ("mypy",),
    "results bit for bit": ("tests.digests",),
    "pages made from results": ("docs.make", "--check"),
    "fast tests": ("pytest", "-q", "-n", "2"),
    "site": ("sphinx", "--fail-on-warning", "--keep-going", "--quiet", "docs", "docs/_build/html"),
    "links of the site": ("docs.site.check", "docs/_build/html"),
}
"""What must hold, each a module with its arguments."""

_VERSION = re.compile(r'(?<=^__version__ = ")[^"]*(?="$)', re.MULTILINE)
_NEWS = re.compile(r"^## Unreleased\n(.*?)(?=^## |\Z)", re.MULTILINE | re.DOTALL)
_SAID = 30  # lines of a check that failed


@command
def main(arguments: Sequence[str] | None = None) -> None:
    """Release a version, or with --dry-run only see whether it could be."""
    parser = Parser(prog="python -m docs.release", description=__doc__)
    parser.add_argument("version", metavar="X.Y.Z", help="not below the version that the code has")
    parser.add_argument("--dry-run", action="store_true", help="check and build; keep no commit, tag or package")
    chosen = parser.parse_args(arguments)
    version, tag = chosen.version, f"v{chosen.version}"
    if not re.fullmatch(r"\d+\.\d+\.\d+", version):
        parser.error(f"version {version!r} is not allowed; allowed: X.Y.Z, as 0.3.0")
    found = _VERSION.search((ROOT / "drillrig_env" / "__init__.py").read_text(encoding="utf-8"))
    if found and _parts(version) < _parts(found[0]):
        parser.error(f"version {version} is below {found[0]}, which the code has")
    branch, news = ready(tag)
    with _copy() as copy:
        write_version(copy, version, datetime.now(UTC).date().isoformat())
        check(copy)
        packages = build(copy, version)
        if chosen.dry_run:
            print(f"{tag} can be released: {listed([one.name for one in packages])}; nothing has been changed")
            return
        _git("commit", "--quiet", "--all", "--no-verify", "--message", f"Release {version}", at=copy)
        (ROOT / "dist").mkdir(exist_ok=True)
        for package in packages:
            shutil.copy(package, ROOT / "dist")
        _git("merge", "--quiet", "--ff-only", _git("rev-parse", "HEAD", at=copy))
    _git("tag", "--annotate", tag, "--cleanup=verbatim", "--message", f"DrillRig {version}\n\n{news}")
    print(f"released: {tag} on {branch}; in dist: {listed([one.name for one in packages])}")
    print(f"to publish: git push origin {branch} {tag}")


def ready(tag: str) -> tuple[str, str]:
    """The branch, and what is new; `Failed` where the tree is not one that `tag` could be put on."""
    if changed := _git("status", "--porcelain"):
        raise Failed(f"the tree has changes that are not committed: {listed(changed.split(chr(10)))}")
    branch = _git("branch", "--show-current")
    if not branch:
        raise Failed("no branch is checked out, so there is none to go on; allowed: git switch main")
    if _git("tag", "--list", tag):
        raise Failed(f"{tag} is there already; a version is released once")
    news = _NEWS.search((ROOT / "CHANGELOG.md").read_text(encoding="utf-8"))
    if news is None or not news[1].strip():
        raise Failed("CHANGELOG.md says nothing under ## Unreleased; a release says what is new")
    check_numbers()
    return branch, news[1].strip()


def check_numbers() -> None:
    """`Failed` where an environment gives other numbers than in the version before, under the same id."""
    tags = _git("tag", "--list", "v*", "--merged", "HEAD", "--sort=-version:refname").split()
    if not tags:
        return
    before = json.loads(_git("show", f"{tags[0]}:{DIGESTS}"))
    if others := renumbered(before, json.loads((ROOT / DIGESTS).read_text(encoding="utf-8"))):
        raise Failed(
            f"the numbers of {listed(others)} are not those of {tags[0]}; "
            "an id with other numbers gets the next number behind its -v (CONTRIBUTING.md)"
        )


def renumbered(before: dict[str, dict[str, object]], now: dict[str, dict[str, object]]) -> list[str]:
    """The ids of environments whose digests on some machine are others now, from two contents of digests.json."""
    found = {
        kind.split()[-1]
        for machine, kinds in before.items()
        for kind, kept in kinds.items()
        if re.search(r"-v\d+$", kind) and now.get(machine, {}).get(kind, kept) != kept
    }
    return sorted(found)


def write_version(copy: Path, version: str, date: str) -> None:
    """Write a version and its date (ISO) where the tree says them: package, citation and changelog."""
    package, citation, changes = copy / "drillrig_env" / "__init__.py", copy / "CITATION.cff", copy / "CHANGELOG.md"
    write_text(package, _VERSION.sub(version, package.read_text(encoding="utf-8")))
    text = re.sub(r"^date-released: .*\n", "", citation.read_text(encoding="utf-8"), flags=re.MULTILINE)
    text = re.sub(r"^version: .*$", f"version: {version}\ndate-released: {date}", text, flags=re.MULTILINE)
    write_text(citation, text)
    text = changes.read_text(encoding="utf-8")
    write_text(changes, text.replace("## Unreleased\n", f"## {version}, {date}\n", 1))


def check(copy: Path) -> None:
    """Run every check in the copy; `Failed` with the last lines of the first that does not hold."""
    settings = {**os.environ, "PYTHONPATH": str(copy), "MPLBACKEND": "Agg"}
    for name, words in CHECKS.items():
        print(f"checking: {name}", flush=True)
        line = [sys.executable, "-m", *words]
        done = subprocess.run(
            line, cwd=copy, env=settings, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False
        )
        if done.returncode:
            said = "\n".join(done.stdout.rstrip().splitlines()[-_SAID:])
            raise Failed(f"the {name} of the release: nothing has been changed. python -m {' '.join(words)}\n{said}")


def build(copy: Path, version: str) -> list[Path]:
    """Wheel and source of the copy; `Failed` where they cannot be built, or the wheel lacks the room's page."""
    print("building: wheel and source", flush=True)
    folder = copy / "dist"
    line = [sys.executable, "-m", "uv", "build", "--quiet", "--out-dir", str(folder), str(copy)]
    done = subprocess.run(line, stderr=subprocess.PIPE, text=True, check=False)
    wheel = folder / f"drillrig-{version}-py3-none-any.whl"
    if done.returncode or not wheel.is_file():
        raise Failed(f"the wheel could not be built; nothing has been changed\n{done.stderr.rstrip()}")
    if (PARTS / "uPlot.js").as_posix() not in zipfile.ZipFile(wheel).namelist():
        raise Failed(
            "the wheel lacks the page of the control room; python -m drillrig_env.room.parts fetches its parts"
        )
    return [wheel, folder / f"drillrig-{version}.tar.gz"]


@contextmanager
def _copy() -> Iterator[Path]:
    """A worktree at the branch's commit, with the parts of the room's page; it goes with the block."""
    with TemporaryDirectory(prefix="drillrig-release-") as folder:
        copy = Path(folder) / "tree"
        _git("worktree", "add", "--quiet", "--detach", str(copy), "HEAD")
        try:
            if (ROOT / PARTS).is_dir():
                shutil.copytree(ROOT / PARTS, copy / PARTS)
            yield copy
        finally:
            _git("worktree", "remove", "--force", str(copy))


def _parts(version: str) -> list[int]:
    return [int(part) for part in version.split(".")]


def _git(*words: str, at: Path | None = None) -> str:
    done = subprocess.run(["git", *words], cwd=at or ROOT, capture_output=True, text=True, check=False)
    if done.returncode:
        raise Failed(f"git {words[0]}: {(done.stderr or done.stdout).strip()}")
    return done.stdout.strip()


if __name__ == "__main__":
    raise SystemExit(main())
