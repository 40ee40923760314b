import errno
import json
import os
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest

from drillrig_env.files import (
    LOCK,
    check_writable,
    check_writable_file,
    digest,
    owned,
    read_arrays,
    read_json,
    write_bytes,
    write_text,
    written_folders,
    written_whole,
)

HOLD = """
import sys, time
from drillrig_env.files import owned
with owned(sys.argv[1]):
    print("mine", flush=True)
    time.sleep(600)
"""


def left(folder):
    return sorted(path.name for path in folder.iterdir())


def test_text_bytes_and_what_a_library_writes_are_whole(tmp_path):
    write_text(tmp_path / "a.txt", "ω = 3\n")
    write_bytes(tmp_path / "b", b"\0\1")
    with written_whole(tmp_path / "c.npz") as new:
        np.savez(new, x=[1, 2])
    assert left(tmp_path) == ["a.txt", "b", "c.npz"]
    assert (tmp_path / "a.txt").read_bytes() == "ω = 3\n".encode()
    assert np.load(tmp_path / "c.npz")["x"].tolist() == [1, 2]


def test_a_missing_folder_is_made_for_a_file(tmp_path):
    path = tmp_path / "one" / "two" / "a.txt"
    check_writable_file(path)
    assert left(tmp_path) == []
    write_text(path, "here")
    assert path.read_text() == "here"


def test_a_file_that_cannot_be_written_is_found_before_it_is(tmp_path):
    (tmp_path / "file").touch()
    for path, words in ((tmp_path, "it is a folder"), (tmp_path / "file" / "a.txt", "not a directory")):
        with pytest.raises(OSError, match=f"cannot be written: {words}"):
            check_writable_file(path)
    check_writable_file(tmp_path / "file")
    check_writable_file(os.devnull)


def test_a_write_that_is_cut_leaves_the_old_file_and_nothing_beside_it(tmp_path):
    path = tmp_path / "model.zip"
    path.write_bytes(b"old")
    with pytest.raises(ZeroDivisionError), written_whole(path) as new:
        new.write_bytes(b"%d" % (1 // (new.write_bytes(b"ne") - 2)))
    assert path.read_bytes() == b"old"
    assert left(tmp_path) == ["model.zip"]


def test_a_full_disk_leaves_the_old_file_and_is_named(tmp_path, monkeypatch):
    path = tmp_path / "model.zip"
    path.write_bytes(b"old")

    def full(_descriptor):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OSError, match=r"No space left on device: .*model\.zip"):
        write_bytes(path, b"new")
    assert path.read_bytes() == b"old"
    assert left(tmp_path) == ["model.zip"]


def test_a_folder_that_goes_away_is_named_with_the_file_that_was_asked_for(tmp_path):
    with pytest.raises(FileNotFoundError) as missing, written_whole(tmp_path / "no" / "a.txt") as new:
        new.rename(new.parent.rmdir() or new)
    assert missing.value.filename == str(tmp_path / "no" / "a.txt")
    assert str(missing.value).endswith(f"{str(tmp_path / 'no' / 'a.txt')!r}")


@pytest.mark.skipif(os.name == "nt", reason="symbolic links need rights there")
def test_links_rights_and_devices_stay_what_they_are(tmp_path):
    (tmp_path / "a.txt").write_text("old")
    (tmp_path / "a.txt").chmod(0o640)
    (tmp_path / "link").symlink_to(tmp_path / "a.txt")
    write_text(tmp_path / "link", "new")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "a.txt").read_text() == "new"
    assert (tmp_path / "a.txt").stat().st_mode & 0o777 == 0o640
    write_text(os.devnull, "gone")


def test_damaged_json_is_named_with_what_to_do(tmp_path):
    path = tmp_path / "config.json"
    path.write_text('{"seed": ')
    with pytest.raises(ValueError, match=r"config\.json is damaged: it is not JSON .*; copy it"):
        read_json(path, "copy it")
    path.write_text("[1]")
    with pytest.raises(ValueError, match="it holds no object but a list; copy it"):
        read_json(path, "copy it")
    path.write_bytes(b"\xff\xfe")
    with pytest.raises(ValueError, match="is damaged"):
        read_json(path, "copy it")
    path.write_text(json.dumps({"seed": 1}))
    assert read_json(path, "copy it") == {"seed": 1}


def test_damaged_arrays_are_named_with_what_to_do(tmp_path):
    path = tmp_path / "evaluations.npz"
    np.savez(path, timesteps=np.arange(100))
    whole = path.read_bytes()
    assert read_arrays(path, "remove it")["timesteps"].sum() == 4950
    flipped = bytearray(whole)
    flipped[200] ^= 1
    for damaged in (whole[: len(whole) // 2], whole[:10], b"", bytes(flipped), b"no archive at all"):
        path.write_bytes(damaged)
        with pytest.raises(ValueError, match=r"evaluations\.npz is damaged: .*; remove it"):
            read_arrays(path, "remove it")


def test_digest_is_that_of_the_content(tmp_path):
    (tmp_path / "a").write_bytes(b"abc")
    assert digest(tmp_path / "a") == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"


def test_a_folder_that_can_be_written_is_not_even_made(tmp_path):
    check_writable(tmp_path / "a" / "b")
    assert left(tmp_path) == []


def test_a_folder_that_cannot_be_written_is_named(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(OSError, match=r"file.deep .* cannot be written"):
        check_writable(tmp_path / "file" / "deep")


def test_a_folder_has_one_owner_who_is_named(tmp_path):
    folder = tmp_path / "run"
    taken = pytest.raises(BlockingIOError, match=f"run is in use by process {os.getpid()}; wait")
    with owned(folder), taken, owned(folder):
        pass
    with owned(folder):
        pass


def test_a_folder_is_waited_for(tmp_path):
    turns = []

    def second():
        with owned(tmp_path, wait=60.0):
            turns.append("second")

    thread = threading.Thread(target=second)
    with owned(tmp_path):
        thread.start()
        time.sleep(0.1)
        turns.append("first")
    thread.join()
    assert turns == ["first", "second"]


def test_a_lock_ends_with_its_process_however_it_ends(tmp_path):
    holder = subprocess.Popen([sys.executable, "-c", HOLD, str(tmp_path)], stdout=subprocess.PIPE, text=True)
    try:
        assert holder.stdout.readline() == "mine\n"
        with pytest.raises(BlockingIOError, match=f"in use by process {holder.pid}"), owned(tmp_path):
            pass
    finally:
        holder.kill()
        holder.wait()
    assert Path(tmp_path / LOCK).exists() or os.name == "nt"
    with owned(tmp_path):
        pass


def test_folders_are_whole_or_not_there(tmp_path):
    folders = [tmp_path / "sets" / name for name in ("a", "b")]

    def write(text, stop=False):
        with written_folders(folders) as new:
            for folder in new:
                (folder / "file").write_text(text)
                assert folder.name.startswith(".")  # Minari, among others, lists what is not hidden
                if stop:
                    raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write("never", stop=True)
    assert list(tmp_path.iterdir()) == []
    write("first")
    with pytest.raises(KeyboardInterrupt):
        write("second", stop=True)
    assert [(folder / "file").read_text() for folder in folders] == ["first", "first"]
    write("third")
    assert [(folder / "file").read_text() for folder in folders] == ["third", "third"]
    assert sorted(path.name for path in (tmp_path / "sets").iterdir()) == ["a", "b"]


def test_what_another_process_has_made_meanwhile_is_kept(tmp_path):
    folders = [tmp_path / "a", tmp_path / "b"]

    def none_is_there():
        if any(folder.exists() for folder in folders):
            raise FileExistsError("one is there already")

    def meanwhile():
        with written_folders(folders, none_is_there):
            folders[1].mkdir()
            (folders[1] / "file").write_text("the other's")

    with pytest.raises(FileExistsError, match="one is there already"):
        meanwhile()
    assert [path.name for path in tmp_path.iterdir()] == ["b"]
    assert (folders[1] / "file").read_text() == "the other's"
