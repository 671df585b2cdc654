# SPDX-License-Identifier: Apache-2.0
"""The address of a viewer. It is had before anything heavy is loaded: a browser that comes early waits in the socket's
queue, and starts while the viewer does."""

from __future__ import annotations

import secrets
import socket

from .._errors import OutputError


def is_any(host: str) -> bool:
    """Whether that means all addresses of this machine."""
    return host in ("", "0.0.0.0", "::")


class Door:
    """Listens at once. Port 0 is a free one. Raises OutputError where the address cannot be had."""

    def __init__(self, host: str = "127.0.0.1", port: int = 0) -> None:
        self.host = host
        family = socket.AF_INET6 if ":" in host else socket.AF_INET
        try:
            self.socket = socket.create_server((host, port), family=family, backlog=128)
        except OSError as error:
            raise OutputError(f"cannot listen on {host}:{port}: {error.strerror}") from error
        self.socket.setblocking(False)
        self.port: int = self.socket.getsockname()[1]
        self.token = secrets.token_urlsafe(24)

    @property
    def url(self) -> str:
        """The address for a browser on this machine, with the token."""
        host = "127.0.0.1" if is_any(self.host) else self.host
        return f"http://{f'[{host}]' if ':' in host else host}:{self.port}/?token={self.token}"

    def close(self) -> None:
        self.socket.close()
