"""The one exception for bad input, and words for what the operating system refuses.

The command line prints either as one sentence, without a traceback.
"""

import errno

_REASONS = {
    errno.ENOSPC: "the disk is full; make room and run the command again",
    errno.EDQUOT: "your quota on this disk is used up; make room and run the command again",
    errno.EFBIG: "the file would be larger than is allowed here; raise the limit (ulimit -f)",
    errno.EROFS: "the file system is read-only; choose another folder or make it writable",
    errno.EACCES: "permission denied; change its owner or its mode, or choose another folder",
    errno.EPERM: "not permitted; change its owner or its attributes, or choose another folder",
    errno.EIO: "the disk reports an input/output error; check it, then run the command again",
    errno.EMFILE: "too many files are open; raise the limit (ulimit -n)",
    errno.ENOENT: "no such file or folder; correct the path",
    errno.EISDIR: "is a folder, but a file is expected; correct the path",
    errno.ENOTDIR: "a part of this path is a file, but must be a folder; correct the path",
    errno.ENAMETOOLONG: "the name is longer than the file system allows; shorten it",
    errno.ELOOP: "its symbolic links lead in a circle; correct them",
    errno.ESTALE: "the network disk has lost this file; mount it again",
    errno.ENOMEM: "there is not enough memory; close other programs or use smaller pictures",
}


class InputError(ValueError):
    """Something the user gave is wrong. The message names the file, the value and the remedy."""


def sentence_of(error: OSError) -> str:
    """One sentence for what the operating system refused: the file, the reason and the remedy."""
    if error.errno is None:
        return " ".join(str(error).split())
    reason = _REASONS.get(error.errno, (error.strerror or "unknown error").lower())
    if error.filename is None:
        return reason
    name = error.filename
    return f"{name.decode(errors='replace') if isinstance(name, bytes) else name}: {reason}"
