# SPDX-License-Identifier: Apache-2.0
"""The address of a viewer. It is had before anything heavy is loaded: a browser that comes early waits in the socket's
queue, and starts while the viewer does.

Who knows the token may use the viewer. It is printed for the user alone; command lines are for all users to see, so the
browser that the viewer opens is given a file that only its user may read, and finds a ticket there which counts once.
A cookie stands for both from then on.
"""

from __future__ import annotations

import hmac
import html
import os
import secrets
import shutil
import socket
import tempfile

from .._errors import OutputError

_OPEN = """<!DOCTYPE html>
<meta charset="utf-8">
<title>Scrim</title>
<meta http-equiv="refresh" content="0; url={url}">
<p><a href="{url}">The viewer</a></p>
"""


def is_any(host: str) -> bool:
    """Whether that means all addresses of this machine."""
    return host in ("", "0.0.0.0", "::")


class Door:
    """Listens from the beginning. Port 0: any free port. Raises OutputError where the address is taken or foreign."""

    def __init__(self, host: str = "127.0.0.1", port: int = 0) -> None:
        self.host = host
        family = socket.AF_INET6 if ":" in host else socket.AF_INET
        try:
            self.socket = socket.create_server((host, port), family=family, backlog=128)
        except OSError as error:
            raise OutputError(f"cannot listen on {host}:{port}: {error.strerror}") from error
        self.socket.setblocking(False)
        self.port: int = self.socket.getsockname()[1]
        self.token, self.cookie = secrets.token_urlsafe(24), secrets.token_urlsafe(24)
        self._ticket, self._folder = "", ""

    @property
    def url(self) -> str:
        """The address for a browser on this machine, with the token."""
        return f"{self._plain}/?token={self.token}"

    @property
    def _plain(self) -> str:
        host = "127.0.0.1" if is_any(self.host) else self.host
        return f"http://{f'[{host}]' if ':' in host else host}:{self.port}"

    def invite(self) -> str:
        """The address of a file that leads a browser here. Raises OSError where it cannot be written."""
        self._ticket = secrets.token_urlsafe(24)
        self._folder = tempfile.mkdtemp(prefix="scrim-view-")
        path = os.path.join(self._folder, "open.html")
        with open(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w", encoding="utf-8") as file:
            file.write(_OPEN.format(url=html.escape(f"{self._plain}/?ticket={self._ticket}")))
        return f"file://{path}"

    def knows(self, token: str | None) -> bool:
        return _is(token, self.token)

    def remembers(self, cookie: str | None) -> bool:
        return _is(cookie, self.cookie)

    def takes(self, ticket: str | None) -> bool:
        """Whether that is the ticket, which is used up then."""
        if not (self._ticket and _is(ticket, self._ticket)):
            return False
        self.end_invitation()
        return True

    def end_invitation(self) -> None:
        """Removes the file of the invitation. The ticket is void from then on."""
        self._ticket = ""
        if self._folder:
            shutil.rmtree(self._folder, ignore_errors=True)
            self._folder = ""

    def close(self) -> None:
        self.socket.close()


def _is(given: str | None, secret: str) -> bool:
    return given is not None and hmac.compare_digest(given.encode(errors="replace"), secret.encode())
