"""Rerun's viewers: in a window, or in a browser on this machine, cut off from all others.

The web viewer is a page with a program (WebAssembly) that ships inside Rerun. As shipped it also
asks for fonts, looks for new releases and reports its use. Here it is served with a content
security policy that lets it talk to this server and to nothing else, unless that is wished for.
"""

import os
import re
import signal
import subprocess
import sys
import tempfile
import time
import urllib.request
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import IO, Any
from urllib.parse import quote, urlsplit

from ..shell.errors import InputError, RunFailed

LOOPBACK = "127.0.0.1"
PAGES = ("/", "/re_viewer.js", "/re_viewer_bg.wasm", "/favicon.ico")
KEPT_HEADERS = ("Content-Type", "Content-Encoding", "rerun-final-length")
POLICY = (
    "default-src 'none'; script-src 'self' 'unsafe-inline' 'unsafe-eval' 'wasm-unsafe-eval'; "
    "style-src 'unsafe-inline'; img-src 'self' data: blob:; worker-src 'self' blob:; "
    "connect-src 'self'; base-uri 'none'; form-action 'none'"
)
START = 30.0
"""Longest wait for Rerun to start [s]."""
Answer = tuple[bytes, Mapping[str, str]]
"""Content and headers of the answer for one address."""


def rerun_program() -> str:
    """Path of the viewer that ships in the wheel of rerun-sdk."""
    import rerun_cli

    program = Path(rerun_cli.__file__).parent / "rerun"
    if not program.is_file():
        raise RunFailed(f"rerun-sdk was installed without its viewer: no {program.name} in it")
    return str(program)


@contextmanager
def private_environment(telemetry: bool) -> Iterator[dict[str, str]]:
    """Environment for Rerun with statistics off; with `telemetry`, the user's own settings."""
    if telemetry:
        yield dict(os.environ)
        return
    with tempfile.TemporaryDirectory(prefix="armside-rerun-") as folder:
        settings, data = Path(folder) / "rerun" / "analytics.json", f"{folder}/data"
        settings.parent.mkdir()
        settings.write_text(
            '{"analytics_enabled": false, "analytics_id": "", "metadata": {}, '
            f'"config_file_path": "{settings}", "data_dir_path": "{data}"}}'
        )
        yield os.environ | {"XDG_CONFIG_HOME": folder, "XDG_DATA_HOME": data}


def viewer_pages(replay: Path) -> dict[str, Answer]:
    """Files of the web viewer by path, read from a Rerun that is started for it."""
    command = [rerun_program(), str(replay), "--serve-web", "--bind", LOOPBACK]
    command += ["--port", "auto", "--web-viewer-port", "0"]
    with (
        private_environment(telemetry=False) as env,
        tempfile.TemporaryFile("w+") as printed,
        subprocess.Popen(command, env=env, stdout=printed, stderr=printed) as process,
    ):
        try:
            address, pages = _address(process, printed), dict[str, Answer]()
            for path in PAGES:
                with urllib.request.urlopen(address + path, timeout=START) as answer:
                    found = {name: answer.headers[name] for name in KEPT_HEADERS}
                    headers = {name: value for name, value in found.items() if value}
                    pages[path] = answer.read(), headers
            return pages
        finally:
            process.terminate()


def _address(process: subprocess.Popen[bytes], printed: IO[str]) -> str:
    """Address of the viewer, as printed by Rerun."""
    until = time.monotonic() + START
    while time.monotonic() < until and process.poll() is None:
        printed.seek(0)
        if found := re.search(r"web-viewer at (http://[\d.]+:\d+)", printed.read()):
            return found[1]
        time.sleep(0.05)
    printed.seek(0)
    last = (printed.read().strip().splitlines() or ["it printed nothing"])[-1]
    raise RunFailed(f"Rerun did not serve its viewer: {last}")


class _Server(ThreadingHTTPServer):
    """A browser may leave in the middle of an answer: that is no error."""

    def handle_error(self, request: Any, client_address: Any) -> None:
        if not isinstance(sys.exception(), ConnectionError):
            super().handle_error(request, client_address)


class WebViewer:
    """Web viewer with one replay in it, served until closed. port: 0 takes any free one; InputError
    for one that is in use or not allowed. telemetry: let the page talk to other machines."""

    def __init__(self, replay: Path, *, port: int, telemetry: bool = False) -> None:
        pages: dict[str, Answer] = {}
        try:
            self._server = _Server((LOOPBACK, port), _handler(pages, telemetry))
        except OSError as error:
            advice = "choose another with --port, or 0 for any free one"
            text = f"port {port} is in use or not allowed ({error.strerror}); {advice}"
            raise InputError(text) from error
        try:
            pages.update(viewer_pages(replay))
            headers = {"Content-Type": "application/octet-stream"}
            pages["/replay.rrd"] = replay.read_bytes(), headers
        except BaseException:
            self._server.server_close()
            raise

    @property
    def address(self) -> str:
        """Address to open in a browser."""
        return f"http://{LOOPBACK}:{self._server.server_port}/"

    def serve(self) -> None:
        """Answer until interrupted, or closed by another thread."""
        try:
            self._server.serve_forever(poll_interval=0.1)
        finally:
            self._server.server_close()

    def close(self) -> None:
        """End `serve`."""
        self._server.shutdown()


def serve(replay: Path, say: Callable[[str], None], *, port: int, telemetry: bool) -> None:
    """Serve the web viewer until Ctrl-C. say: prints the address, and the end."""
    viewer = WebViewer(replay, port=port, telemetry=telemetry)
    # A shell that starts us in the background sets Ctrl-C to be ignored.
    endings, end = (signal.SIGINT, signal.SIGTERM), signal.default_int_handler
    before = {ending: signal.signal(ending, end) for ending in endings}
    try:
        say(f"Open {viewer.address} in a browser on this machine; Ctrl-C ends")
        sys.stdout.flush()
        viewer.serve()
    except KeyboardInterrupt:
        say("ended")
    finally:
        for ending, handler in before.items():
            signal.signal(ending, handler)


def _handler(pages: Mapping[str, Answer], telemetry: bool) -> type[BaseHTTPRequestHandler]:
    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            asked = urlsplit(self.path)
            host = f"{LOOPBACK}:{self.server.server_port}"  # type: ignore[attr-defined]
            if self.headers["Host"] not in (host, host.replace(LOOPBACK, "localhost")):
                self.send_error(403)  # another site's name that points here
            elif asked.path == "/" and "url=" not in asked.query:
                self.send_response(302)
                replay = quote(f"http://{self.headers['Host']}/replay.rrd", safe="")
                also = asked.query and f"&{asked.query}"  # such as renderer=webgl
                self.send_header("Location", f"/?url={replay}&persist=0{also}")
                self.send_header("Content-Length", "0")
                self.end_headers()
            elif page := pages.get(asked.path):
                content, headers = page
                self.send_response(200)
                for name, value in {**headers, "Content-Length": str(len(content))}.items():
                    self.send_header(name, value)
                if not telemetry:
                    self.send_header("Content-Security-Policy", POLICY)
                self.end_headers()
                self.wfile.write(content)
            else:
                self.send_error(404)

        def log_message(self, format: str, *args: object) -> None:
            """Log nothing."""

    return Handler


def check_display(instead: str) -> None:
    """Raise InputError where no window can be opened; `instead` names a way without one."""
    if sys.platform == "linux" and not (
        os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
    ):
        raise InputError(f"no display here (neither DISPLAY nor WAYLAND_DISPLAY is set); {instead}")


def show(file: Path, telemetry: bool) -> None:
    """Show a replay in Rerun's native viewer until its window is closed. Raises RunFailed where the
    viewer fails."""
    command = [rerun_program(), str(file), "--bind", LOOPBACK, "--port", "auto"]
    with private_environment(telemetry) as env:
        try:
            status = subprocess.run(command, env=env, check=False).returncode
        except KeyboardInterrupt:
            return
    if status:
        raise RunFailed(f"the viewer ended with status {status}; --web shows it in a browser")
