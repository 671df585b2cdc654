# SPDX-License-Identifier: Apache-2.0
"""A viewer as a process of its own, and a browser's side of its web socket, without a browser."""

import asyncio
import http.cookiejar
import json
import struct
import subprocess
import sys
import threading
import urllib.error
import urllib.parse
import urllib.request

import numpy
import tornado.httpclient
import tornado.websocket

import scrim
from scrim.view import _door, _server

PATIENCE = 60  # seconds


class Viewer:
    """`python -m scrim.view PATH`, which has printed its address."""

    def __init__(self, path, environment, *options, browser=""):
        words = [sys.executable, "-m", "scrim.view", path, *options, *(() if browser else ("--no-browser",))]
        environment = {**environment, "BROWSER": browser}
        self.process = subprocess.Popen(
            words, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )
        line = self.process.stdout.readline()
        assert "?token=" in line, line + self.process.stderr.read()
        self.url = line.split(": ", 1)[1].strip()
        parts = urllib.parse.urlsplit(self.url)
        self.port, self.token = parts.port, parts.query.removeprefix("token=")
        self.socket = f"ws://127.0.0.1:{self.port}/socket?token={self.token}"

    def get(self, path, token=True, **headers):
        """(status, body) of a request."""
        mark = "&" if "?" in path else "?"
        url = f"http://127.0.0.1:{self.port}{path}" + (f"{mark}token={self.token}" if token else "")
        try:
            with self._opener().open(urllib.request.Request(url, headers=headers), timeout=PATIENCE) as reply:
                return reply.status, reply.read()
        except urllib.error.HTTPError as error:
            return error.code, error.read()

    @staticmethod
    def _opener():
        cookies = http.cookiejar.CookieJar(http.cookiejar.DefaultCookiePolicy(strict_domain=False))
        return urllib.request.build_opener(urllib.request.HTTPCookieProcessor(cookies))

    def browser(self):
        return Browser(self)

    def close(self):
        if self.process.poll() is None:
            self.process.terminate()
        self.process.wait(PATIENCE)
        self.process.stdout.close()
        self.process.stderr.close()


class Door:
    """The address of a viewer in a notebook, which has the token in its path."""

    def __init__(self, url):
        self.url = url.rstrip("/")
        self.socket = self.url.replace("http", "ws") + "/socket"

    def get(self, path=""):
        """(status, body, head) of a request."""
        try:
            with urllib.request.urlopen(f"{self.url}/{path}", timeout=PATIENCE) as reply:
                return reply.status, reply.read(), reply.headers
        except urllib.error.HTTPError as error:
            return error.code, error.read(), error.headers


class Serving:
    """A server of this process, in a thread: `opening` gives what it shows."""

    def __init__(self, opening):
        self.door = _door.Door()
        self.server, self.problem = _server.Server(opening, self.door), None
        self.port, self.token = self.door.port, self.door.token
        self.socket = f"ws://127.0.0.1:{self.port}/socket?token={self.token}"
        self.thread = threading.Thread(target=self._run, daemon=True)
        self.thread.start()

    def _run(self):
        async def serve():
            self.loop = asyncio.get_running_loop()
            await self.server.run()

        try:
            asyncio.run(serve())
        except scrim.Error as problem:
            self.problem = problem

    def get(self, path):
        return Viewer.get(self, path)

    _opener = staticmethod(Viewer._opener)

    def end(self):
        self.loop.call_soon_threadsafe(self.server.end)
        self.thread.join(PATIENCE)
        assert not self.thread.is_alive()


class Browser:
    """One connection. `pictures`: float32 arrays by slot, of the newest picture message, whose head is `head`."""

    def __init__(self, viewer, **headers):
        self._loop = asyncio.new_event_loop()
        request = tornado.httpclient.HTTPRequest(viewer.socket, headers=headers, connect_timeout=PATIENCE)
        self._socket = self._do(lambda: tornado.websocket.websocket_connect(request, max_message_size=1 << 28))
        self._textures, self.pictures, self.head, self.state, self.errors = {}, {}, {}, {}, []
        self.verified = []
        self.serial = 0

    def _do(self, call):
        """The result of what `call` begins, in this object's loop."""

        async def do():
            return await asyncio.wait_for(call(), PATIENCE)

        return self._loop.run_until_complete(do())

    def send(self, **message):
        if message["type"] not in ("have", "save", "end"):  # for the others there are pictures
            self.serial += 1
            message["serial"] = self.serial
        self._do(lambda: self._socket.write_message(json.dumps(message)))

    def hear(self):
        """The next message, which is kept."""
        data = self._do(self._socket.read_message)
        assert data is not None, "the viewer closed the connection"
        if isinstance(data, str):
            message = json.loads(data)
            if message["type"] == "state":
                self.state = message
            if message["type"] == "verified":
                self.verified.append(message)
            if message["type"] == "error":
                self.errors.append(message["text"])
            return message
        size = struct.unpack_from("<I", data)[0]
        head, offset = json.loads(data[4 : 4 + size]), 4 + size
        if head["type"] == "pictures":
            for fresh in head["fresh"]:
                count = int(numpy.prod(fresh["shape"]))
                pixels = numpy.frombuffer(data, numpy.float16, count, offset).reshape(fresh["shape"])
                self._textures[fresh["number"]] = pixels.astype(numpy.float32)
                offset += 2 * count
            self.head = head
            self.pictures = {slot: self._textures[number] for slot, number in head["slots"].items()}
            self.send(type="have")
        return head

    def until(self, wanted):
        """Listens until a message is as `wanted(message)` says."""
        while not wanted(message := self.hear()):
            pass
        return message

    def until_exact(self):
        """Listens until the picture of the newest event is the one that a command renders."""
        serial = self.serial
        self.until(lambda m: m["type"] == "pictures" and m["exact"] and m["serial"] >= serial)
        return self.pictures["beauty"]

    def until_layers(self):
        """Listens until the layers of that picture are there, too."""
        serial = self.serial
        self.until(lambda m: m["type"] == "pictures" and m["exact"] and m["layers"] and m["serial"] >= serial)
        return self.pictures["beauty"]

    def close(self):
        self._socket.close()
        self._do(lambda: asyncio.sleep(0))
        self._loop.close()
