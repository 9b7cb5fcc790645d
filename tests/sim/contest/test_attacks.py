"""Entries that try to read the truth: each attempt comes back with nothing.

The judge's process holds a word in its memory, its environment, a file and a pipe; each entry
reports what it found as an error, whose text is the reason of the lost task.
"""

import hashlib
import os
import socket
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from armside.sim.contest.entry_process import EntryError, EntryProcess

WORD = "true-stiffness-4711"
SHAPE = (4, 1)
START = """
import gc, inspect, os, sys, glob, socket, ctypes, signal
class Entry:
    def start(self, task):
        word = "-".join(("true", "stiffness", "4711"))
        def found():
{body}
        raise RuntimeError("found: " + repr(found()))
"""
ATTEMPTS = {
    "file system": """
            paths = [{secret!r}, {here!r}, "/home", "/etc/passwd", "/etc/shadow", "/proc", "/sys"]
            folder = os.path.dirname({secret!r})
            return [p for p in (*paths, folder) if os.path.exists(p)] + glob.glob("/*/*.salt")
""",
    "writing beyond its folder": """
            written = []
            for folder in ("/", "/cache", "/usr", "/dev", os.path.dirname(os.__file__)):
                try:
                    open(os.path.join(folder, "note"), "w").close()
                    written.append(folder)
                except OSError:
                    pass
            return written
""",
    "garbage collector": """
            return [type(o) for o in gc.get_objects() if isinstance(o, dict)
                    and any(word == v for v in list(o.values()) if isinstance(v, str))
                    and "word" not in o]
""",
    "inspect": """
            names = ("individual", "salt", "truth", "plant", "errors")
            return [n for f in inspect.stack() for n in f.frame.f_locals if n in names]
""",
    "frames": """
            held, f = [], sys._getframe()
            while f:
                held += {{"round", "salt", "plant"}} & {{*f.f_globals, *f.f_locals}}
                f = f.f_back
            return held
""",
    "environment": """
            known = "HOME XDG_CACHE_HOME LC_CTYPE"
            return [k for k in os.environ if k not in known and not k.endswith("_NUM_THREADS")]
""",
    "memory of the parent": """
            read = []
            for pid in (os.getppid(), {pid}, 1):
                for name in ("mem", "environ", "maps", "cmdline"):
                    try:
                        read.append(open(f"/proc/{{pid}}/{{name}}", "rb").read(9))
                    except OSError:
                        pass
            return read
""",
    "ptrace and signals": """
            libc, done = ctypes.CDLL(None, use_errno=True), []
            for pid in (os.getppid(), {pid}):
                if pid and libc.ptrace(16, pid, 0, 0) == 0:
                    done.append(pid)
            try:
                os.kill({pid}, 0)
                done.append("the judge can be signalled")
            except OSError:
                pass
            return done
""",
    "open files": """
            import stat
            kept, null = [], os.stat("/dev/null").st_rdev
            for fd in range(256):
                try:
                    of = os.fstat(fd)
                except OSError:
                    continue
                if not stat.S_ISFIFO(of.st_mode) and of.st_rdev != null:
                    kept.append(fd)
            return kept
""",
    "sockets": """
            reached = []
            places = {{socket.AF_INET: ("127.0.0.1", {port}), socket.AF_UNIX: {socket!r}}}
            for family in places:
                with socket.socket(family) as s:
                    try:
                        s.connect(places[family])
                        reached.append(places[family])
                    except OSError:
                        pass
            return reached
""",
    "modules of the judge": """
            import numpy as np
            from armside.sim.contest.joint_track import draw
            from armside.sim.contest.seal import Round
            from hashlib import sha256
            guesses = (b"", b"salt", bytes(32), b"2026-a")
            rounds = [Round(), *(Round("2026-a", sha256(s).hexdigest(), s) for s in guesses)]
            return [i for r in rounds for i in range(3)
                    if np.array_equal(draw(r, i).given["reference"], task.reference)]
""",
}


@pytest.fixture(scope="module")
def process():
    with EntryProcess() as alive:
        yield alive


@pytest.fixture
def judge(tmp_path, monkeypatch):
    """What the attempts look for, and where it is."""
    monkeypatch.setenv("ARMSIDE_SECRET", WORD)
    secret = tmp_path / "2026-a.salt"
    secret.write_text(WORD)
    tmp_path.chmod(0o755)
    with socket.create_server(("127.0.0.1", 0)) as server, socket.socket(socket.AF_UNIX) as unix:
        path = str(tmp_path / "s")
        unix.bind(path)
        unix.listen()
        with open(secret):
            yield {
                **{"secret": str(secret), "here": os.path.abspath(__file__), "pid": os.getpid()},
                **{"port": server.getsockname()[1], "socket": path},
            }


def reason(process, source, given=None):
    try:
        process.load(source)
        process.call("start", given or {"reference": np.zeros(SHAPE)}, SHAPE, 30.0)
    except EntryError as lost:
        return str(lost)
    finally:
        process.end()


@pytest.mark.parametrize("attempt", ATTEMPTS)
def test_an_attempt_to_read_the_truth_finds_nothing(attempt, process, judge):
    given = None
    if attempt == "modules of the judge":
        from armside.sim.contest.joint_track import draw
        from armside.sim.contest.seal import Round

        salt = b"\x17" * 32
        given = draw(Round("2026-a", hashlib.sha256(salt).hexdigest(), salt), 0).given
    source = START.format(body=ATTEMPTS[attempt].strip("\n").format(**judge))
    assert reason(process, source, given) == "RuntimeError: found: []"


@pytest.mark.parametrize("attempt", ["file system", "environment", "sockets"])
def test_the_same_attempt_finds_something_where_nothing_is_isolated(attempt, judge):
    """An attempt that could never find anything would prove nothing."""
    text = START.format(body=ATTEMPTS[attempt].strip("\n").format(**judge))
    space = {}
    exec(text, space)
    with pytest.raises(RuntimeError, match=r"found: \[.+\]"):
        space["Entry"]().start(None)


FLOOD = """
import os
class Entry:
    def start(self, task):
        for fd in range(3, 64):
            try:
                while True:
                    os.write(fd, {what})
            except OSError:
                pass
"""


@pytest.mark.parametrize(
    ("what", "says"),
    [("b'x' * 65536", "no frame"), ("b'ACF1' + b'\\xff' * 12", "bytes, at most")],
)
def test_a_flood_of_the_pipe_is_cut_off_and_the_next_entry_is_well(process, what, says):
    assert says in reason(process, FLOOD.format(what=what))
    assert reason(process, GOOD) is None


GOOD = "import numpy as np\nclass Entry:\n    def start(self, task): return np.zeros((4, 1))\n"
LEFT_BEHIND = """
import os, time, numpy as np
class Entry:
    def start(self, task):
        if os.path.exists("note"): raise RuntimeError("remembers")
        open("note", "w").write("seen")
        if os.fork() == 0:
            time.sleep(60)
        return np.zeros((4, 1))
"""


def test_an_entry_remembers_nothing_of_the_task_before(process):
    assert reason(process, LEFT_BEHIND) is None
    assert reason(process, LEFT_BEHIND) is None


KERNEL = """
import ctypes, os
CALLS = {"x86_64": (248, 249, 250, 29, 64, 68, 240, 165, 272, 308),
         "aarch64": (217, 218, 219, 194, 190, 186, 180, 40, 97, 268)}[os.uname().machine]
CLONE, NEW_USER = {"x86_64": 56, "aarch64": 220}[os.uname().machine], 0x10000011
class Entry:
    def start(self, task):
        call, found = ctypes.CDLL(None, use_errno=True).syscall, []
        for number in CALLS:
            if call(number, b"user", b"name", b"value", 5, -4) != -1 or ctypes.get_errno() != 1:
                found.append(number)
        if call(CLONE, NEW_USER, 0, 0, 0, 0) != -1:
            found.append("namespace of a child")
        raise RuntimeError(f"found: {found}")
"""


def test_what_the_kernel_keeps_of_a_process_is_refused(process):
    """Keys, memory and queues of System V and POSIX would tell the next task of this one."""
    assert reason(process, KERNEL) == "RuntimeError: found: []"
    assert "kernel" in process.isolation


LOCKED = """
import os, numpy as np
class Entry:
    def start(self, task):
        if os.path.exists("locked"): raise RuntimeError("remembers")
        os.makedirs("locked/inside")
        os.chmod("locked", 0)
        return np.zeros((4, 1))
"""
DEEP = LOCKED.replace(
    'os.makedirs("locked/inside")',
    """os.mkdir("locked")
        for _ in range(600):
            os.mkdir("d"); os.chdir("d")""",
).replace('os.chmod("locked", 0)', "pass")


@pytest.mark.parametrize("source", [LOCKED, DEEP])
def test_what_cannot_be_deleted_is_not_there_for_the_next_task(process, source):
    assert reason(process, source) is None
    assert reason(process, source) is None


FORGED = """
import os, stat, time
from armside.sim.contest.frames import packed
class Entry:
    def start(self, task):
        for fd in range(3, 64):
            try:
                os.write(fd, packed({"raised": "x" * 1000000}))
            except OSError:
                pass
        time.sleep(9)
"""


def test_a_forged_reason_of_a_megabyte_is_cut(process):
    assert reason(process, FORGED) == "x" * 300


CARRYING = """
import os, stat, time
import numpy as np
from armside.sim.contest.frames import packed, unpacked
from io import BytesIO
class Entry:
    def start(self, task):
        pipes = []
        for fd in range(3, 64):
            try:
                if stat.S_ISFIFO(os.fstat(fd).st_mode): pipes.append(fd)
            except OSError:
                pass
        given, taken = pipes[0], pipes[1]
        def read(n):
            data = b""
            while len(data) < n:
                data += os.read(given, n - len(data)) or os._exit(0)
            return data
        os.write(taken, packed({"correction": np.zeros((4, 1))}))
        unpacked(read, 1 << 20)  # the end
        os.write(taken, packed({"ended": True}))
        unpacked(read, 1 << 20)  # the next entry, which is not run
        os.write(taken, packed({"loaded": True}))
        unpacked(read, 1 << 20)
        os.write(taken, packed({"raised": "carried"}))
        time.sleep(9)
"""


def test_an_entry_does_not_live_on_in_the_next_task(process):
    assert reason(process, CARRYING) is None
    assert reason(process, GOOD) is None


def test_no_more_memory_is_had_than_allowed(process):
    body = "            return len(bytearray(1 << 33))"
    assert reason(process, START.format(body=body)).startswith("MemoryError")


HANGING = """
import sys, time
from armside.sim.contest.entry_process import EntryProcess
process = EntryProcess()
process.load("class Entry:\\n def start(self, task):\\n  while True: pass")
print(process._process.pid, flush=True)
process.call("start", {"a": 1}, (1, 1), 600.0)
"""


def test_an_entry_ends_with_a_judge_that_is_killed():
    judge = subprocess.Popen([sys.executable, "-c", HANGING], stdout=subprocess.PIPE, text=True)
    assert judge.stdout is not None
    pid = int(judge.stdout.readline())
    children = Path(f"/proc/{pid}/task/{pid}/children").read_text().split()
    judge.kill()
    judge.communicate()
    until = time.monotonic() + 30.0
    alive = [Path("/proc") / str(p) for p in (pid, *children)]
    while any(map(_runs, alive)) and time.monotonic() < until:
        time.sleep(0.05)
    assert not any(map(_runs, alive))


def _runs(process):
    """Neither gone nor a zombie that nobody has waited for."""
    try:
        return process.joinpath("stat").read_text().rsplit(")")[-1].split()[0] != "Z"
    except OSError:
        return False
