"""Screenshots of a page in a headless Chromium, by the WebDriver protocol.

Draws WebGL on the CPU (SwiftShader), so it works on a machine without graphics.
"""

import base64
import json
import subprocess
import time
import urllib.error
import urllib.request
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

ARGUMENTS = (
    "--headless=new",
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--no-first-run",
    "--hide-scrollbars",
)
START = 20.0
"""Longest wait for the driver to start [s]."""
ANSWER = 180.0
"""Longest wait for an answer [s]: a page that draws on the CPU is slow."""


class Page:
    """Page that is open in the browser."""

    def __init__(self, address: str) -> None:
        self._address = address

    def screenshot(self) -> bytes:
        """Page as it is shown now, as PNG."""
        return base64.b64decode(_ask(f"{self._address}/screenshot"))

    def screenshot_when(self, good: Callable[[bytes], bool], within: float) -> bytes:
        """First screenshot that is good, or the last one taken within that time [s].

        A busy page that gives none is asked again. Raises TimeoutError where it gave none at all.
        """
        until = time.monotonic() + within
        seen = b""
        while True:
            try:
                seen = self.screenshot()
            except TimeoutError:
                if not seen and time.monotonic() > until:
                    raise
            if seen and (good(seen) or time.monotonic() > until):
                return seen
            time.sleep(0.5)

    def answered(self) -> list[str]:
        """Addresses that the page asked for and got an answer from, since the last call."""
        entries = _ask(f"{self._address}/se/log", {"type": "performance"})
        messages = [json.loads(entry["message"])["message"] for entry in entries]
        received = (m for m in messages if m["method"] == "Network.responseReceived")
        return [m["params"]["response"]["url"] for m in received]


@contextmanager
def page(
    address: str, *, driver: str = "chromedriver", width: int = 1600, height: int = 900
) -> Iterator[Page]:
    """Open an address in a browser of its own; it is closed when the block ends.

    Raises OSError where there is no such driver, or it does not start.
    """
    wanted = {
        "browserName": "chrome",
        "goog:chromeOptions": {"args": [*ARGUMENTS, f"--window-size={width},{height}"]},
        "goog:loggingPrefs": {"performance": "ALL"},
    }
    out, err = subprocess.PIPE, subprocess.DEVNULL
    with subprocess.Popen([driver, "--port=0"], stdout=out, stderr=err, text=True) as process:
        try:
            base = f"http://127.0.0.1:{_port(process)}"
            opened = _ask(f"{base}/session", {"capabilities": {"alwaysMatch": wanted}})
            own = f"{base}/session/{opened['sessionId']}"
            try:
                _ask(f"{own}/url", {"url": address})
                yield Page(own)
            finally:
                _ask(own, method="DELETE")
        finally:
            process.terminate()


def _port(process: subprocess.Popen[str]) -> int:
    """Port of the driver, as printed by it."""
    assert process.stdout is not None
    until = time.monotonic() + START
    while time.monotonic() < until and (line := process.stdout.readline()):
        if "on port" in line and "successfully" in line:
            return int(line.split("on port")[1].strip(" .\n"))
    raise OSError("the browser's driver did not start")


def _ask(address: str, body: dict[str, Any] | None = None, method: str | None = None) -> Any:
    data = None if body is None else json.dumps(body).encode()
    headers = {"Content-Type": "application/json"}
    request = urllib.request.Request(address, data, headers, method=method)
    try:
        with urllib.request.urlopen(request, timeout=ANSWER) as answer:
            return json.load(answer)["value"]
    except urllib.error.HTTPError as error:
        answer = json.load(error)["value"]
        text = f"the browser failed: {answer.get('message', answer)}".splitlines()[0]
        late = answer.get("error") == "timeout"
        raise (TimeoutError(text) if late else OSError(text)) from error
