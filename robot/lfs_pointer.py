"""Recognizes what Git LFS leaves in place of a file that it has not fetched."""

from __future__ import annotations

LFS_POINTER = b"version https://git-lfs"


def is_lfs_pointer(data: bytes) -> bool:
    """Return whether bytes are such a pointer, and not the file itself."""
    return data.startswith(LFS_POINTER)
