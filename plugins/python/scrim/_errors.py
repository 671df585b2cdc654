# SPDX-License-Identifier: Apache-2.0
"""What Scrim raises: one class for each kind of error of the library.

A message says where (file:line:column), what was found, what was expected, and the choices there are.
"""


class Error(Exception):
    """Any error of Scrim."""


class RenderError(Error):
    """Something inside a render went wrong."""


class UsageError(Error, ValueError):
    """The caller asked for something that does not exist or does not fit together."""


class InputError(Error):
    """A file, scene or asset is missing or bad."""


class OutputError(Error):
    """A result could not be written."""


class OutOfMemoryError(Error, MemoryError):
    """The limit of memory does not suffice."""


class Cancelled(Error):
    """The caller asked to stop: `Job.cancel()`."""


class AccuracyError(Error):
    """The result is there, but not as accurate as was asked for: `Frame.require_accuracy()`."""
