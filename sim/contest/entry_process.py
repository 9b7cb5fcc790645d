"""An entry in a process of its own, which the judge calls with arrays and a deadline."""

import contextlib
import json
import os
import selectors
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any, Literal

import numpy as np

import armside
from armside.kinematics.cache import cache_folder, loaded_files

from ..records.files import InputError
from . import worker
from .frames import CHUNK, LONGEST_TEXT, FrameError, packed, unpacked

MEMORY = 4 << 30
"""[bytes] of address space that an entry has."""
STARTING = 60.0
"""[s], for Python to start and for the entry's file to be read."""
LIBRARIES = ("site-packages", "dist-packages")
"""Names of the folders of libraries; no other folder of the machine is seen."""
PRELOADED = [
    *("scipy.signal", "scipy.linalg", "armside.ilc.filters", "armside.ilc.laws"),
    "armside.sim.contest.read_only_cache",
]
"""Modules that entries find loaded, which would take each most of a second."""


ISOLATED = frozenset(("file system", "processes", "network", "kernel"))
"""What the process of an entry must have left for a judged round."""
Kind = Literal["raised", "hung", "wrong shape", "not finite", "beyond limits", "ended"]
LONGEST_REASON = 300
"""Characters."""


class EntryError(RuntimeError):
    """An entry that raised, hung, ended or answered nonsense: the reason why a task is lost.

    Its text may hold what the entry knows; its kind does not.
    """

    def __init__(self, kind: Kind, text: str) -> None:
        super().__init__(text[:LONGEST_REASON])
        self.kind: Kind = kind


class EntryProcess:
    """A process for entries, one after the other; a context, at whose end it is not alive.

    Each entry is loaded in a fork of its own. After one that is at fault a new process is begun.
    """

    def __init__(self, *, judged: bool = False, isolate: bool = True) -> None:
        """judged: refuse to run an entry that is not isolated, and give no reason in its words.
        isolate: False leaves it in the machine's file system, as systems do that allow nothing
        else."""
        self.judged, self.isolate, self.isolation = judged, isolate, list[str]()
        self._process: subprocess.Popen[bytes] | None = None

    def __enter__(self) -> "EntryProcess":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def load(self, source: str, name: str = "entry.py") -> None:
        """Begin with the text of an entry's file.

        Raises EntryError where it cannot be run; InputError, before any of it has run, where the
        process cannot be begun or is not as isolated as a judged round needs.
        """
        if self._process is None:
            self._begin()
        self._ask({"source": source, "name": name}, STARTING, 0)

    def end(self) -> None:
        """The end of an entry."""
        if self._process is not None:
            try:
                self._ask({"end": True}, STARTING, 0)
            except EntryError:
                self.close()

    def _begin(self) -> None:
        self._folder = tempfile.TemporaryDirectory(prefix="contest-")
        package, home = Path(armside.__file__).parent, cache_folder().parents[1]
        paths = [path for path in sys.path if Path(path).name in LIBRARIES]
        paths += [str(Path(np.__file__).parents[1]), str(package.parent)]
        rooms = [str(room.resolve()) for room in package.iterdir() if room.is_symlink()]
        asked = {
            "libraries": _outermost([sys.base_prefix, *paths, *rooms]),
            **{"path": paths, "root": self._folder.name},
            "cache": {
                str(f.relative_to(home)): str(f) for f in loaded_files() if f.is_relative_to(home)
            },
            **{"memory": MEMORY, "isolate": self.isolate, "preloaded": PRELOADED},
        }
        python = os.path.realpath(sys.executable)
        self._process = subprocess.Popen(
            [python, "-I", "-S", "-B", worker.__file__, json.dumps(asked)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            cwd=self._folder.name,
            env={},
            start_new_session=True,
        )
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._out, self._in = self._process.stdin.fileno(), self._process.stdout.fileno()
        for stream in (self._out, self._in):
            os.set_blocking(stream, False)
        try:
            found = self._answer(time.monotonic() + STARTING, 0)
        except EntryError as error:
            self.close()
            raise InputError(f"the process of entries does not start ({python}): {error}") from None
        self.isolation = [str(one) for one in found["isolation"]]
        if self.judged and (lacking := ISOLATED - {*self.isolation}):
            self.close()
            needed = "a judged round needs a system that grants namespaces and mounts"
            raise InputError(f"{needed}; not left: {', '.join(sorted(lacking))}")

    def call(
        self, name: str, of: dict[str, Any], shape: tuple[int, int], seconds: float
    ) -> np.ndarray | None:
        """The correction, of the shape (N, n), that `start` or `update` returns; None to stop.

        Raises EntryError.
        """
        found = self._ask({name: of}, seconds, 8 * shape[0] * shape[1])
        if found.get("stop") is True:
            return None
        correction = found.get("correction")
        if not isinstance(correction, np.ndarray):
            raise EntryError("wrong shape", f"{name} answered no correction")
        if correction.shape != shape:
            raise EntryError(
                "wrong shape", f"{name} returned the shape {correction.shape}, not {shape}"
            )
        if not np.isfinite(correction).all():
            raise EntryError("not finite", f"{name} returned a correction that is not finite")
        return correction

    def _ask(self, call: dict[str, Any], seconds: float, most: int) -> dict[str, Any]:
        until = time.monotonic() + seconds
        frame = memoryview(packed(call))
        while len(frame):
            self._wait(self._out, selectors.EVENT_WRITE, until)
            try:
                frame = frame[os.write(self._out, frame[:CHUNK]) :]
            except BrokenPipeError:
                raise EntryError("ended", "the process ended") from None
        found = self._answer(until, most)
        if "ended" in found and "end" not in call:
            raise EntryError("ended", "the process ended")
        if "raised" in found:
            raise EntryError("raised", " ".join(str(found["raised"]).split()))
        return found

    def _answer(self, until: float, most: int) -> dict[str, Any]:
        def read(count: int) -> bytes:
            parts = bytearray()
            while len(parts) < count:
                self._wait(self._in, selectors.EVENT_READ, until)
                part = os.read(self._in, min(count - len(parts), CHUNK))
                if not part:
                    raise EntryError("ended", "the process ended")
                parts += part
            return bytes(parts)

        try:
            found = unpacked(read, most + LONGEST_TEXT)
        except FrameError as error:
            raise EntryError("wrong shape", str(error)) from error
        if not isinstance(found, dict):
            raise EntryError("wrong shape", "an answer that is no frame")
        return found

    def _wait(self, stream: int, event: int, until: float) -> None:
        with selectors.DefaultSelector() as selector:
            selector.register(stream, event)
            left = until - time.monotonic()
            if left <= 0.0 or not selector.select(left):
                raise EntryError("hung", "no answer in time")

    def close(self) -> None:
        """Kill the entry and whatever it has started."""
        if self._process is None:
            return
        pid = self._process.pid
        inner = Path(f"/proc/{pid}/task/{pid}/children")
        with contextlib.suppress(OSError, ValueError):
            for child in inner.read_text().split():
                os.kill(int(child), signal.SIGKILL)  # the first of its namespace takes all others
        with contextlib.suppress(ProcessLookupError):
            os.killpg(pid, signal.SIGKILL)
        self._process.wait()
        for stream in (self._process.stdin, self._process.stdout):
            if stream is not None:
                with contextlib.suppress(OSError):
                    stream.close()
        self._process = None
        self._folder.cleanup()


def _outermost(paths: list[str]) -> list[str]:
    """Folders without those inside others."""
    kept = list[str]()
    for path in sorted({os.path.realpath(path) for path in paths}):
        if not any(Path(path).is_relative_to(other) for other in kept):
            kept.append(path)
    return kept
