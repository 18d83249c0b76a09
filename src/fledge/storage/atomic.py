"""The way to disk and back: a file is whole or it is not there, and what goes wrong is said in one line.

A file is written under a hidden name in the same folder (`.NAME.<random>.partial`), flushed to the disk and
renamed. The rename is atomic on POSIX: whoever looks under the final name finds the old file or the new one,
never half of one. Whatever interrupts the writing, the hidden file goes; only SIGKILL or a power cut can
leave one behind, and `sweep` clears it away. A writer holds a lock on its hidden file, which the system takes
back when the writer dies: that is how `sweep` tells the dead from the living.

What this does not do: order two writers of one name. The last rename wins.
"""

import fcntl
import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

from fledge.errors import BadFile, FledgeError

RANDOM = "[0-9a-f]" * 8
"""What stands between name and `.partial`, as a pattern."""

AnyPath = str | os.PathLike[str]


@contextmanager
def replacing(path: AnyPath) -> Iterator[BinaryIO]:
    """A binary file to write to; after the block it stands under `path`, or nothing has changed there.

    Raises:
        BadFile: it cannot be written, and why.
    """
    path = Path(path)
    partial = path.parent / f".{path.name}.{secrets.token_hex(4)}.partial"
    try:
        if path.exists() and not path.is_file():
            raise OSError(f"{path.name or path} is not a regular file")
        with open(partial, "xb") as file:
            with suppress(OSError):  # not every file system has locks
                fcntl.flock(file, fcntl.LOCK_EX)
            yield file
            file.flush()
            os.fsync(file.fileno())
        os.replace(partial, path)
    except BaseException as error:
        with suppress(OSError):
            partial.unlink()
        if isinstance(error, OSError):
            raise BadFile(path, f"cannot be written: {error.strerror or error}") from error
        raise
    _sync_folder(path.parent)


def write(path: AnyPath, data: bytes) -> None:
    """Write a whole file.

    Raises:
        BadFile: it cannot be written, and why.
    """
    with replacing(path) as file:
        file.write(data)


def sweep(folder: AnyPath) -> list[Path]:
    """Remove what killed writers left in a folder, and say what that was."""
    return [
        partial for partial in sorted(Path(folder).glob(f".*.{RANDOM}.partial")) if _remove_if_dead(partial)
    ]


@contextmanager
def reading(path: AnyPath, kind: str) -> Iterator[None]:
    """Within the block, whatever goes wrong with reading `path` as a `kind` of file becomes a BadFile."""
    try:
        yield
    except OSError as error:
        raise BadFile(path, f"cannot be read: {error.strerror or error}") from error
    except FledgeError as error:
        raise BadFile(path, str(error)) from error
    except Exception as error:  # parsers of foreign bytes raise as they please, MemoryError included
        detail = " ".join(f"{type(error).__name__} {error}".split())
        raise BadFile(path, f"damaged, or not {kind} at all ({detail})") from error


def _remove_if_dead(partial: Path) -> bool:
    with suppress(OSError), open(partial, "r+b") as file:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        partial.unlink()
        return True
    return False


def _sync_folder(folder: Path) -> None:
    # The file is in place already; not every file system lets a folder be synced.
    with suppress(OSError):
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)
