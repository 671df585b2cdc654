# SPDX-License-Identifier: Apache-2.0
"""A notebook: a kernel as Jupyter runs it, cells of which render, show progress, and are interrupted."""

import queue
import re

import pytest
from jupyter_client.manager import KernelManager

PATIENCE = 60  # seconds


@pytest.fixture
def notebook(python_path):
    manager = KernelManager(kernel_name="python3")
    manager.start_kernel(env=python_path)
    client = manager.client()
    client.start_channels()
    client.wait_for_ready(timeout=PATIENCE)
    yield manager, client
    client.stop_channels()
    manager.shutdown_kernel(now=True)


def run(client, code, on_output=lambda text: None):
    """The reply to a cell, and all that it printed."""
    cell = client.execute(code)
    text = ""
    while True:
        message = client.get_iopub_msg(timeout=PATIENCE)
        if message["parent_header"].get("msg_id") != cell:
            continue
        if message["msg_type"] == "stream":
            text += message["content"]["text"]
            on_output(text)
        if message["msg_type"] == "status" and message["content"]["execution_state"] == "idle":
            break
    while True:
        try:
            reply = client.get_shell_msg(timeout=PATIENCE)
        except queue.Empty:
            pytest.fail("the kernel does not answer")
        if reply["parent_header"].get("msg_id") == cell:
            return reply["content"], text


def test_a_cell_is_interrupted_and_the_next_one_renders(notebook, smoke):
    manager, client = notebook
    reply, _ = run(client, f"import scrim; shot = scrim.open({str(smoke)!r})")
    assert reply["status"] == "ok", reply
    interrupted = []

    def interrupt(text):
        if "on" in text and not interrupted:
            interrupted.append(True)
            manager.interrupt_kernel()

    endless = 'shot.render(verify="all", progress=lambda part: print("on", flush=True))'
    reply, _ = run(client, endless, interrupt)
    assert interrupted and reply["status"] == "error" and reply["ename"] == "KeyboardInterrupt", reply
    reply, text = run(client, "print(shot.render(crop=(0, 0, 8, 8)).image.shape)")
    assert reply["status"] == "ok" and text == "(8, 8, 4)\n", (reply, text)


def test_a_shot_is_shown_in_a_cell_and_changed_there(notebook, smoke):
    pytest.importorskip("tornado")
    pytest.importorskip("tomlkit")
    from viewing import Browser, Door

    manager, client = notebook
    reply, _ = run(client, f"import scrim; shown = scrim.open({str(smoke)!r}).view(height=300)")
    assert reply["status"] == "ok", reply
    _, text = run(client, "print(shown._repr_html_())")
    assert 'height="300"' in text and (url := re.search(r'src="(http://127\.0\.0\.1:\d+/t/[^/]+/)"', text))
    door = Door(url[1])
    status, page, head = door.get()
    assert status == 200 and b"picture" in page and "frame-ancestors *" in head["Content-Security-Policy"]
    assert door.get("page.js")[0] == 200 and door.get("../other")[0] in (403, 404)
    browser = Browser(door)
    assert browser.until_exact().shape == (48, 64, 4)
    browser.send(type="set", id="light.key.intensity", value=9.0, done=True)
    browser.until_exact()
    browser.close()
    _, text = run(client, "shown.close(); print(shown.toml)")
    assert "intensity = 9.0" in text
    with pytest.raises(OSError):
        door.get()


def test_a_volume_from_an_array_is_shown(notebook):
    pytest.importorskip("tornado")
    pytest.importorskip("tomlkit")
    from viewing import Browser, Door

    _, client = notebook
    code = """if True:
        import numpy, scrim
        scene = {"camera": {"position": [0, 0, 30], "target": [0, 0, 0], "resolution": [32, 24]},
                 "volume": [{"name": "fog", "density": {"scale": 1.0}}]}
        field = scrim.Field(numpy.ones((8, 8, 8), numpy.float32), origin=(-3.5, -3.5, -3.5))
        print(scrim.loads(scene).view(volumes={"fog": field}).url)
    """
    _, text = run(client, code)
    browser = Browser(Door(text.strip()))
    assert browser.until_exact()[12, 16, 3] > 0.99
    browser.close()
