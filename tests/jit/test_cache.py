"""Machine code is kept where it can be, and a cache that is damaged or full stops nobody."""

import os
import tempfile
from pathlib import Path

import numba
import numpy as np
import pytest

from drillrig_env.jit import cache
from drillrig_env.jit.compiled import compiled


def triple(values):
    values *= 3.0


def run(kernel):
    values = np.ones(3)
    kernel(values)
    np.testing.assert_array_equal(values, 3.0)
    return kernel.stats.cache_hits, kernel.stats.cache_misses


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path))
    monkeypatch.setattr(cache, "_WARNED", [])
    return tmp_path


@pytest.fixture
def nowhere(monkeypatch, tmp_path):
    """No folder but the temporary one, which is `tmp_path`."""
    njit = numba.njit

    def refusing(*arguments, cache=False, **options):
        if cache and not numba.config.CACHE_DIR:
            raise RuntimeError("cannot cache function: no locator available")
        return njit(*arguments, cache=cache, **options)

    monkeypatch.setattr(numba, "njit", refusing)
    monkeypatch.setattr(numba.config, "CACHE_DIR", "")
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.setattr(cache, "_WARNED", [])
    cache.temporary_folder.cache_clear()
    yield tmp_path
    cache.temporary_folder.cache_clear()


def test_machine_code_is_kept(folder):
    assert run(compiled(triple)) == ({}, {(numba.float64[::1],): 1})
    assert run(compiled(triple)) == ({(numba.float64[::1],): 1}, {})


@pytest.mark.parametrize("ending", ["nbi", "nbc"])
@pytest.mark.parametrize("damage", [lambda content: content[:-20], lambda content: b"", lambda content: content[::-1]])
def test_damaged_file_is_compiled_anew(folder, ending, damage):
    run(compiled(triple))
    (path,) = folder.rglob(f"*.{ending}")
    path.write_bytes(damage(path.read_bytes()))
    hits, misses = run(compiled(triple))
    assert (len(hits), len(misses)) == (0, 1)
    hits, misses = run(compiled(triple))
    assert (len(hits), len(misses)) == (1, 0)


def test_full_disk_is_no_traceback(folder, monkeypatch):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(cache.CacheFile, "_open_for_write", full)
    with pytest.warns(UserWarning, match=r"No space left on device.*NUMBA_CACHE_DIR"):
        run(compiled(triple))


def test_temporary_folder_takes_the_place_of_others(nowhere):
    run(compiled(triple))
    (folder,) = nowhere.glob("drillrig-*")
    assert folder.stat().st_mode & 0o777 == 0o700 or os.name == "nt"
    hits, misses = run(compiled(triple))
    assert (len(hits), len(misses)) == (1, 0)
    assert numba.config.CACHE_DIR == ""


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="needs owners of files")
@pytest.mark.parametrize("trap", ["link", "open to others", "a file", "of somebody else"])
def test_temporary_folder_that_is_not_safe_is_not_taken(nowhere, trap, monkeypatch):
    folder = nowhere / f"drillrig-{os.getuid()}"
    if trap == "link":
        (nowhere / "other").mkdir(mode=0o700)
        folder.symlink_to(nowhere / "other")
    elif trap == "a file":
        folder.write_text("")
    else:
        folder.mkdir()
        folder.chmod(0o777 if trap == "open to others" else 0o700)
    if trap == "of somebody else":
        user = os.getuid()
        monkeypatch.setattr(os, "getuid", lambda: user + 1)
        folder.rename(nowhere / f"drillrig-{user + 1}")
    with pytest.warns(UserWarning, match="NUMBA_CACHE_DIR"):
        kernel = compiled(triple)
    run(kernel)
    assert not list(Path(nowhere).rglob("*.nb?"))


def test_no_folder_at_all_warns_once_and_works(nowhere, monkeypatch, recwarn):
    monkeypatch.setattr(tempfile, "tempdir", str(nowhere / "nowhere"))
    for _ in range(2):
        run(compiled(triple))
    assert len([warning for warning in recwarn if "NUMBA_CACHE_DIR" in str(warning.message)]) == 1


def test_code_after_an_edit_never_takes_the_place_of_code_that_is_being_loaded(tmp_path):
    now, edited = (cache.CacheFile(str(tmp_path), "kernel", stamp) for stamp in ("now", "edited"))
    now.save("of floats", "floats")
    held = now._load_index()["of floats"]
    edited.save("of floats", "floats after an edit")
    assert now._load_data(held) == "floats"
    assert now.load("of floats") is None
    assert edited.load("of floats") == "floats after an edit"


def test_processes_that_compile_at_once_never_get_each_others_code(tmp_path, monkeypatch):
    first, second = (cache.CacheFile(str(tmp_path), "kernel", "now") for _ in range(2))
    monkeypatch.setattr(first, "_load_index", dict)  # both have looked before there was anything
    monkeypatch.setattr(second, "_load_index", dict)
    save_data = first._save_data

    def late(name, data):
        second.save("of records", "records")
        save_data(name, data)

    monkeypatch.setattr(first, "_save_data", late)
    first.save("of floats", "floats")
    later = cache.CacheFile(str(tmp_path), "kernel", "now")
    assert later.load("of floats") in (None, "floats")
    assert later.load("of records") in (None, "records")
