"""Unpack what a recorder packed, file by file or message by message."""

from __future__ import annotations

from pathlib import Path
import shutil
from tempfile import gettempdir, mkdtemp
import weakref

import zstandard

from bpc_perception.recording.storage import planes
from bpc_perception.recording.storage.raw_message import BagError

PACKED = ('.zstd', '.zst')  # suffixes of rosbag2 and of the program zstd
MAGIC = zstandard.MAGIC_NUMBER.to_bytes(4, 'little')  # no serialized message begins so
LARGEST_MESSAGE_BYTES = 1 << 30  # unpacked; fifteen captures of the largest camera


def unpacked(data: bytes) -> bytes:
    """Return a serialized message that may be packed. Raises BagError when it is damaged."""
    if data.startswith(planes.MAGIC):
        return planes.unpack(data)
    if not data.startswith(MAGIC):
        return data
    try:
        stated = zstandard.frame_content_size(data)  # -1: it is not
        with zstandard.ZstdDecompressor().stream_reader(data) as stream:
            found = stream.read(LARGEST_MESSAGE_BYTES + 1)
    except zstandard.ZstdError as error:
        raise BagError(f'expected a message packed with zstd, found: {error}; '
                       'was the recording damaged since?') from error
    if len(found) > LARGEST_MESSAGE_BYTES or stated not in (-1, len(found)):
        raise BagError('expected a message packed with zstd, found one that is torn or larger '
                       f'than {LARGEST_MESSAGE_BYTES} bytes; was the recording damaged since?')
    return found


class UnpackedFile:
    """A storage file that can be read; a packed one is unpacked for as long as this exists.

    Attributes:
        path: what to read.
    """

    def __init__(self, file: Path) -> None:
        """Unpack a file if it is packed. Raises BagError when it is damaged, or no room is left.

        Of a torn file all is unpacked up to the damage.
        """
        self.path = file
        if file.suffix not in PACKED:
            return
        try:
            folder = mkdtemp(prefix='bpc-unpacked-')
            weakref.finalize(self, shutil.rmtree, folder, ignore_errors=True)
            self.path = Path(folder, file.stem)
            with file.open('rb') as packed, self.path.open('wb') as whole:
                zstandard.ZstdDecompressor().copy_stream(packed, whole)
        except zstandard.ZstdError as error:
            raise BagError(f'{file}: expected a file packed with zstd, found: {error}; unpack '
                           'what is left of it with zstd -d') from error
        except OSError as error:
            raise BagError(f'{file}: expected room to unpack it in {gettempdir()}, found: '
                           f'{error.strerror}; TMPDIR names another folder') from error
