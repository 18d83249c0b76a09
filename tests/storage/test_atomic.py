"""A file is whole or it is not there, whatever happens to its writer."""

import errno
import os

import pytest

from fledge.errors import BadFile, FledgeError
from fledge.storage import atomic


def names(folder):
    return sorted(path.name for path in folder.iterdir())


def test_writes_and_replaces(tmp_path):
    path = tmp_path / "a.bin"
    atomic.write(path, b"one")
    atomic.write(str(path), b"two")
    assert path.read_bytes() == b"two"
    assert names(tmp_path) == ["a.bin"]


def test_a_file_has_the_usual_permissions(tmp_path):
    (tmp_path / "usual").write_bytes(b"")
    atomic.write(tmp_path / "ours", b"")
    assert (tmp_path / "ours").stat().st_mode == (tmp_path / "usual").stat().st_mode


def test_the_old_file_stands_until_the_new_one_is_whole(tmp_path):
    path = tmp_path / "a.bin"
    atomic.write(path, b"old")
    with atomic.replacing(path) as file:
        file.write(b"new")
        file.flush()
        assert path.read_bytes() == b"old"
    assert path.read_bytes() == b"new"


@pytest.mark.parametrize("error", [KeyboardInterrupt, RuntimeError, FledgeError, SystemExit])
def test_an_interrupted_write_changes_nothing(tmp_path, error):
    path = tmp_path / "a.bin"
    atomic.write(path, b"old")
    with pytest.raises(error), atomic.replacing(path) as file:
        file.write(b"new")
        raise error
    assert path.read_bytes() == b"old"
    assert names(tmp_path) == ["a.bin"]


@pytest.mark.parametrize("call", ["fsync", "replace"])
def test_a_full_disk_is_one_clear_line(tmp_path, monkeypatch, call):
    def full(*_):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(atomic.os, call, full)
    with pytest.raises(BadFile) as caught:
        atomic.write(tmp_path / "a.bin", b"new")
    assert str(caught.value) == f"{tmp_path / 'a.bin'}: cannot be written: No space left on device"
    assert names(tmp_path) == []


LIMITED = """
    import resource, signal, sys
    from fledge.errors import BadFile
    from fledge.storage import atomic

    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096))
    try:
        with atomic.replacing(sys.argv[1]) as file:
            for _ in range(100):
                file.write(bytes(int(sys.argv[2])))
    except BadFile as error:
        print(error)
"""


@pytest.mark.slow
@pytest.mark.parametrize("size", [50, 100_000])
def test_a_disk_that_refuses_more_bytes(tmp_path, python, size):
    path = tmp_path / "a.bin"
    atomic.write(path, b"old")
    out, err = python(LIMITED, path, size).communicate()
    assert (out, err) == (f"{path}: cannot be written: File too large\n", "")
    assert path.read_bytes() == b"old"
    assert names(tmp_path) == ["a.bin"]


def test_places_that_cannot_be_written(tmp_path):
    (tmp_path / "file").write_bytes(b"")
    (tmp_path / "folder").mkdir()
    os.mkfifo(tmp_path / "pipe")
    before = names(tmp_path)
    for name, why in [
        ("file/a.bin", "Not a directory"),
        ("nowhere/a.bin", "No such file or directory"),
        ("folder", "folder is not a regular file"),
        ("pipe", "pipe is not a regular file"),
        ("x" * 250, "File name too long"),
    ]:
        with pytest.raises(BadFile) as caught:
            atomic.write(tmp_path / name, b"new")
        assert str(caught.value) == f"{tmp_path / name}: cannot be written: {why}"
    assert names(tmp_path) == before


@pytest.mark.skipif(os.geteuid() == 0, reason="permissions do not bind root")
def test_a_read_only_folder(tmp_path):
    tmp_path.chmod(0o500)
    try:
        with pytest.raises(BadFile, match="cannot be written: Permission denied"):
            atomic.write(tmp_path / "a.bin", b"new")
    finally:
        tmp_path.chmod(0o700)


HANGING = """
    import sys, time
    from fledge.storage import atomic

    with atomic.replacing(sys.argv[1]) as file:
        file.write(b"half")
        file.flush()
        print("half", flush=True)
        time.sleep(60.0)
"""


def test_a_killed_writer_leaves_nothing_under_the_name_and_is_swept_up_after(tmp_path, python):
    path = tmp_path / "a.bin"
    atomic.write(path, b"old")
    writer = python(HANGING, path)
    assert writer.stdout.readline() == "half\n"
    assert atomic.sweep(tmp_path) == []  # it is alive
    assert len(names(tmp_path)) == 2
    writer.kill()
    writer.wait()
    assert path.read_bytes() == b"old"
    (left,) = set(names(tmp_path)) - {"a.bin"}
    assert left.startswith(".a.bin.") and left.endswith(".partial")
    assert atomic.sweep(tmp_path) == [tmp_path / left]
    assert names(tmp_path) == ["a.bin"]


def test_a_sweep_of_nothing(tmp_path):
    assert atomic.sweep(tmp_path) == atomic.sweep(tmp_path / "nowhere") == []


def test_reading_makes_every_error_a_clear_line(tmp_path):
    path = tmp_path / "a"
    for error, line in [
        (
            FileNotFoundError(errno.ENOENT, "No such file or directory"),
            "cannot be read: No such file or directory",
        ),
        (FledgeError("it is blue"), "it is blue"),
        (ValueError("line one\nline two"), "damaged, or not a flight at all (ValueError line one line two)"),
        (MemoryError(), "damaged, or not a flight at all (MemoryError)"),
    ]:
        with pytest.raises(BadFile) as caught, atomic.reading(path, "a flight"):
            raise error
        assert str(caught.value) == f"{path}: {line}"


@pytest.mark.slow
def test_the_storage_does_not_load_jax(python):
    out, err = python("import sys, fledge.storage; print('jax' in sys.modules)").communicate()
    assert (out, err) == ("False\n", "")
