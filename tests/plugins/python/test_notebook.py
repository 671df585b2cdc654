# SPDX-License-Identifier: Apache-2.0
"""A notebook: a kernel as Jupyter runs it, cells of which render, show progress, and are interrupted."""

import queue

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
