import os

import pytest

from benchmarks import startup
from benchmarks.startup import TASKS, installed, summary, tabulate, why_not_read_only

posix = pytest.mark.skipif(why_not_read_only() is not None, reason="no folder can be made read-only here")
WRITE = "import os; open(os.path.join({folder}, 'new'), 'w').close()"
PLACES = {"package": "'drillrig_env'", "home": "os.environ['HOME']"}


@pytest.fixture(autouse=True)
def tasks(monkeypatch):
    """Tasks that write to the package's folder and to the home."""
    for name, folder in PLACES.items():
        monkeypatch.setitem(TASKS, name, WRITE.format(folder=folder))


def writable(install, place):
    try:
        return install.seconds(place) >= 0.0
    except RuntimeError as error:
        if "PermissionError" not in str(error):
            raise
        return False


@posix
@pytest.mark.parametrize("arguments", [{}, {"writable": False}, {"writable": False, "home": False}])
def test_install_can_be_written_to_only_where_it_may(arguments):
    with installed(**arguments) as install:
        assert writable(install, "package") is arguments.get("writable", True)
        assert writable(install, "home") is arguments.get("home", True)
    assert not install.folder.exists()


def test_install_is_a_copy_with_nothing_compiled(monkeypatch):
    find = "import os, importlib.util as u; assert u.find_spec('drillrig_env').origin.startswith(os.getcwd())"
    monkeypatch.setitem(TASKS, "find", find)
    with installed() as install:
        assert not list(install.folder.rglob("*.nbi"))
        assert install.seconds("find") > 0.0


def test_failure_is_told_without_the_folder_it_was_in(monkeypatch):
    monkeypatch.setitem(TASKS, "fail", "import os; raise OSError(os.getcwd())")
    with installed() as install, pytest.raises(RuntimeError, match=r"^OSError: \.\.\.$"):
        install.seconds("fail")


def test_table_has_medians_and_failures(capsys):
    tabulate({"one": summary({"later": {"import gymnasium": [3.0, 1.0, 2.0]}}), "two": {"fails": "no way"}})
    printed = capsys.readouterr().out
    assert "| one | later processes | 2.00 | - |" in printed
    assert "| two | fails: no way | - |" in printed


@pytest.mark.skipif(os.name != "posix", reason="root is a matter of POSIX")
def test_root_without_setpriv_leaves_the_read_only_cases_out(monkeypatch):
    monkeypatch.setattr(startup, "_is_root", lambda: True)
    monkeypatch.setattr(startup.shutil, "which", lambda _: None)
    assert "root may write anywhere" in why_not_read_only()
