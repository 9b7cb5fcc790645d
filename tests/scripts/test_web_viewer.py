"""The web viewer's server, without Rerun behind it."""

import os
import signal
import socket
import struct
import threading
import time

import pytest

from armside.scripts.viewers import web_viewer

LARGE = b"x" * 50_000_000
"""More than the buffers between server and browser hold."""
PAGES = {"/large": (LARGE, {}), "/wrong": ("text in place of bytes", {})}


@pytest.fixture
def viewer(tmp_path, monkeypatch):
    monkeypatch.setattr(web_viewer, "viewer_pages", lambda replay: PAGES)
    (tmp_path / "a.rrd").write_bytes(b"")
    viewer = web_viewer.WebViewer(tmp_path / "a.rrd", port=0)
    thread = threading.Thread(target=viewer.serve)
    thread.start()
    yield viewer
    viewer.close()
    thread.join()


@pytest.mark.parametrize("ending", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_it_and_the_handlers_of_before_are_back(tmp_path, monkeypatch, ending):
    monkeypatch.setattr(web_viewer, "viewer_pages", lambda replay: PAGES)
    (tmp_path / "a.rrd").write_bytes(b"")
    before, said = signal.getsignal(ending), []

    def say(text):
        said.append(text)
        if len(said) == 1:
            threading.Timer(0.2, os.kill, [os.getpid(), ending]).start()

    web_viewer.serve(tmp_path / "a.rrd", say, port=0, telemetry=False)
    port = said[0].partition("127.0.0.1:")[2].partition("/")[0]
    assert said[1:] == ["ended"]
    assert signal.getsignal(ending) is before
    with socket.socket() as free:
        assert free.connect_ex(("127.0.0.1", int(port))) != 0


def leave_in_mid_answer(viewer, path):
    """Ask for a page, read the beginning of the answer, and reset the connection."""
    port = viewer._server.server_port
    with socket.create_connection(("127.0.0.1", port), timeout=10) as browser:
        browser.sendall(f"GET {path} HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n\r\n".encode())
        assert browser.recv(10).startswith(b"HTTP/")
        browser.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))


def answering():
    return [t for t in threading.enumerate() if "process_request_thread" in t.name]


def wait_for_the_answers():
    deadline = time.monotonic() + 20.0
    while answering() and time.monotonic() < deadline:
        time.sleep(0.02)
    assert not answering()


def test_a_browser_that_leaves_is_no_error(viewer, capsys):
    leave_in_mid_answer(viewer, "/large")
    wait_for_the_answers()
    assert capsys.readouterr().err == ""


def test_a_fault_of_the_server_is_shown(viewer, capsys):
    leave_in_mid_answer(viewer, "/wrong")
    wait_for_the_answers()
    assert "TypeError" in capsys.readouterr().err
