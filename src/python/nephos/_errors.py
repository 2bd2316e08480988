# SPDX-License-Identifier: Apache-2.0
"""Exceptions of nephos: one class for each result of the library, with the message of its log."""
from . import _declarations as c


class Error(Exception):
    """Base of all errors of nephos. `result` is the library's number for the kind of failure."""

    result = c.NEPH_ERROR_INTERNAL


class InternalError(Error):
    """A fault of nephos itself."""


class OutOfMemoryError(Error, MemoryError):
    """No memory was left."""

    result = c.NEPH_ERROR_OUT_OF_MEMORY


class ArgumentError(Error, ValueError):
    """A value outside of its range."""

    result = c.NEPH_ERROR_INVALID_ARGUMENT


class SceneError(Error, ValueError):
    """A scene that cannot be read, or whose keys do not fit together."""

    result = c.NEPH_ERROR_BAD_SCENE


class NotFoundError(Error, FileNotFoundError):
    """A file that is not there."""

    result = c.NEPH_ERROR_NOT_FOUND


class InputOutputError(Error, OSError):
    """A file or folder that cannot be read or written."""

    result = c.NEPH_ERROR_IO


class FileError(Error, ValueError):
    """A file that is damaged or of another kind."""

    result = c.NEPH_ERROR_BAD_FILE


class LimitError(Error):
    """A limit of time, memory or size was reached."""

    result = c.NEPH_ERROR_LIMIT


class Cancelled(Error):
    """A call that was cancelled: by its progress callback, or by Renderer.cancel."""

    result = c.NEPH_ERROR_CANCELLED


class UnsupportedError(Error, NotImplementedError):
    """A feature that this build or machine lacks."""

    result = c.NEPH_ERROR_UNSUPPORTED


_classes = {kind.result: kind for kind in Error.__subclasses__()}


def make_error(result, messages, text):
    """Exception of a result. Its text is the messages of the log, or, without one, the sentence about the result."""
    return _classes.get(result, InternalError)("\n".join(messages) or text)
