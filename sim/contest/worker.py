"""Process of entries: gives up what it can reach, then forks one that answers for each entry.

Run as a script by `entry_process`, isolated (-I -S). Where the system allows, it sees Python, its
libraries and an empty folder in place of the file system, no other process, no network, and is
nobody. What was given up is told to the judge before the entry's code is there.
"""

import ctypes
import json
import os
import resource
import shutil
import sys
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from importlib import import_module
from io import BytesIO
from types import ModuleType, SimpleNamespace

NOBODY = 65534
NAMESPACES = (
    0x00020000 | 0x08000000 | 0x40000000 | 0x20000000 | 0x04000000
)  # ns, ipc, net, pid, uts
NEW_USER = 0x10000000
READ_ONLY, NO_SETUID, NO_DEVICES, REMOUNT, BIND, RECURSIVE, PRIVATE = (
    *(1, 2, 4, 32, 4096, 16384),
    1 << 18,
)
PIVOT_ROOT = {"x86_64": 155, "aarch64": 41}
DETACH, NO_NEW_PRIVILEGES, DIE_WITH_PARENT, DUMPABLE = 2, 38, 1, 4
SYSTEM = ("/usr", "/lib", "/lib64", "/bin", "/etc/ld.so.cache", "/dev/null", "/dev/urandom")
HOME, CACHE = "/entry", "/cache"
"""Working folder of an entry, empty; generated code of armside, that it need not compile again."""
ROOM = 1 << 29
"""[bytes] of both, in memory."""
FILES = 64 << 20
"""[bytes], largest file of an entry."""
MACHINES = {
    "x86_64": (0xC000003E, {
        *(248, 249, 250), *(29, 30, 31, 64, 65, 66, 68, 69, 70, 71), *(240, 241),
        *(165, 166, 155, 272, 308), 101,
    }, 56, 435),
    "aarch64": (0xC00000B7, {
        *(217, 218, 219), *(194, 195, 196, 190, 191, 193, 186, 187, 188, 189), *(180, 181),
        *(40, 39, 41, 97, 268), 117,
    }, 220, 435),
}  # fmt: skip
"""Of each machine: its AUDIT_ARCH (linux/audit.h), the calls that an entry may not make, and those
of clone and clone3. Keys of the kernel, memory, semaphores and messages of System V, and queues of
POSIX outlive the process that made them; a namespace of its own would have rooms without a limit;
ptrace looks into others. (Tables of arch/x86/entry/syscalls and include/uapi/asm-generic/unistd.h.)
"""
SECCOMP, FILTER = 22, 2
LOAD, EQUAL, AT_LEAST, ANY_BIT, RETURN = 0x20, 0x15, 0x35, 0x45, 0x06
ALLOW, REFUSE = 0x7FFF0000, 0x00050000
NOT_PERMITTED, NO_SUCH_CALL = 1, 38
X32 = 0x40000000
_libc = ctypes.CDLL(None, use_errno=True)


def _try(result: int) -> None:
    if result:
        raise OSError(ctypes.get_errno(), "the system does not allow it")


def _mount(source: str, target: str, kind: str = "", flags: int = 0, data: str = "") -> None:
    _try(_libc.mount(source.encode(), target.encode(), kind.encode(), flags, data.encode()))


def isolate(libraries: list[str], root: str, cache: dict[str, str]) -> list[str]:
    """Leave the file system, processes and network of the machine; what of it was left."""
    uid, gid = os.getuid(), os.getgid()
    try:
        _try(_libc.unshare(NAMESPACES | (NEW_USER if uid else 0)))
    except OSError:
        return []
    if uid:
        for name, text in (
            ("setgroups", "deny"),
            ("uid_map", f"{NOBODY} {uid} 1"),
            ("gid_map", f"{NOBODY} {gid} 1"),
        ):
            with open(f"/proc/self/{name}", "w") as file:
                file.write(text)
    if child := os.fork():  # the first process of the new namespace is the one that stays
        os.closerange(0, 3)
        os._exit(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) & 0xFF)
    _libc.prctl(DIE_WITH_PARENT, 9)
    try:
        _enter(libraries, root, cache)
    except OSError:  # a system may grant namespaces, and no mounts in them
        os.chdir(root)
        return ["network"]
    return ["file system", "processes", "network"]


def _enter(libraries: list[str], root: str, cache: dict[str, str]) -> None:
    """Make a file system of the libraries and an empty folder, and leave the machine's."""
    _mount("none", "/", flags=RECURSIVE | PRIVATE)
    _mount("tmpfs", root, "tmpfs", NO_SETUID | NO_DEVICES, f"size={ROOM},mode=755")
    for path in (*SYSTEM, *libraries):
        _bind(path, root + path)
    os.mkdir(root + CACHE)
    for place, file in cache.items():
        target = f"{root}{CACHE}/{place}"
        os.makedirs(os.path.dirname(target), exist_ok=True)
        shutil.copy2(file, target)  # with its time, by which numba knows it
        os.chmod(target, 0o644)
    _bind(root + CACHE, root + CACHE, anew=True)
    os.mkdir(root + HOME)
    _mount("tmpfs", root + HOME, "tmpfs", NO_SETUID | NO_DEVICES, f"size={ROOM},mode=777")
    os.mkdir(root + "/old")
    _try(_libc.syscall(PIVOT_ROOT[os.uname().machine], root.encode(), (root + "/old").encode()))
    os.chdir(HOME)
    _try(_libc.umount2(b"/old", DETACH))
    os.rmdir("/old")
    _mount("none", "/", flags=REMOUNT | BIND | READ_ONLY | NO_SETUID | NO_DEVICES)


def _bind(path: str, target: str, anew: bool = False) -> None:
    if os.path.islink(path):
        os.makedirs(os.path.dirname(target), exist_ok=True)
        os.symlink(os.readlink(path), target)
        return
    if not os.path.exists(path) or (os.path.exists(target) and not anew):
        return
    os.makedirs(target if os.path.isdir(path) else os.path.dirname(target), exist_ok=True)
    if not os.path.isdir(path):
        os.close(os.open(target, os.O_CREAT, 0o644))
    _mount(path, target, flags=BIND)
    if not path.startswith("/dev/"):
        flags = REMOUNT | BIND | READ_ONLY | NO_SETUID | NO_DEVICES
        _mount("none", target, flags=flags)


class _Instruction(ctypes.Structure):
    """struct sock_filter of linux/filter.h."""

    _fields_ = (
        *(("code", ctypes.c_uint16), ("if_so", ctypes.c_uint8)),
        *(("if_not", ctypes.c_uint8), ("value", ctypes.c_uint32)),
    )


class _Program(ctypes.Structure):
    """struct sock_fprog of linux/filter.h."""

    _fields_ = (("length", ctypes.c_uint16), ("filter", ctypes.POINTER(_Instruction)))


def refuse_calls() -> list[str]:
    """Make calls of the system fail by which something outlives an entry; what was given up."""
    if os.uname().machine not in MACHINES:
        return []
    machine, refused, clone, clone3 = MACHINES[os.uname().machine]
    no = (RETURN, 0, 0, REFUSE | NOT_PERMITTED)
    program = [(LOAD, 0, 0, 4), (EQUAL, 1, 0, machine), no]
    program += [(LOAD, 0, 0, 0), (AT_LEAST, 0, 1, X32), no]
    for number in sorted(refused):
        program += [(EQUAL, 0, 1, number), no]
    program += [(EQUAL, 0, 1, clone3), (RETURN, 0, 0, REFUSE | NO_SUCH_CALL)]
    program += [(EQUAL, 0, 3, clone), (LOAD, 0, 0, 16), (ANY_BIT, 0, 1, NEW_USER), no]
    program += [(RETURN, 0, 0, ALLOW)]
    each = (_Instruction * len(program))(*(_Instruction(*one) for one in program))
    if _libc.prctl(SECCOMP, FILTER, ctypes.byref(_Program(len(program), each)), 0, 0):
        return []
    return ["kernel"]


def drop(memory: int) -> list[str]:
    """Become nobody where the process is root, without a way back, within limits."""
    for limit, most in (
        (resource.RLIMIT_AS, memory),
        (resource.RLIMIT_FSIZE, FILES),
        (resource.RLIMIT_CORE, 0),
        (resource.RLIMIT_NOFILE, 256),
    ):
        resource.setrlimit(limit, (most, most))
    dropped = []
    if os.getuid() == 0:
        os.setgroups([])
        os.setresgid(NOBODY, NOBODY, NOBODY)
        os.setresuid(NOBODY, NOBODY, NOBODY)
        dropped = ["user"]
    _libc.prctl(NO_NEW_PRIVILEGES, 1, 0, 0, 0)
    _libc.capset((ctypes.c_uint32 * 2)(0x20080522, 0), (ctypes.c_uint32 * 6)())
    _libc.prctl(DIE_WITH_PARENT, 9)  # a change of user clears it
    return [*dropped, *refuse_calls()]


def serve(given: int, taken: int, isolation: list[str], preloaded: list[str]) -> None:
    """Say what was given up; then for each entry that is sent fork a process that answers for it.

    Only this process has the pipes of the judge. It hands on calls and answers, and neither reads
    nor runs what is the entry's. Processes and files that an entry leaves are gone before the next.
    """
    for name in preloaded:
        import_module(name)
    from armside.sim.contest.frames import packed, relayed, unpacked

    def answer(value: dict) -> None:
        _write(taken, packed(value))

    answer({"isolation": isolation})
    _libc.prctl(DUMPABLE, 0, 0, 0, 0)  # the entry's process may not look into this one
    child, calls, answers = 0, -1, -1
    while True:
        frame = bytearray()
        relayed(partial(_read, given), frame.extend)
        call = unpacked(BytesIO(frame).read, len(frame), len(frame))
        if child and ("end" in call or "source" in call):
            _finish(child, calls, answers)
            child = 0
            if os.listdir():  # what cannot be deleted: another process has another folder
                os._exit(0)
        if "end" in call:
            answer({"ended": True})
            continue
        if "source" in call:
            (asked, calls), (answers, said) = os.pipe(), os.pipe()
            child = os.fork()
            if not child:
                for one in (given, taken, calls, answers):
                    os.close(one)
                _answer_for(
                    *(call["source"], call["name"]),
                    partial(unpacked, partial(_read, asked), 1 << 40),
                    lambda value, to=said: _write(to, packed(value)),
                )
            os.close(asked)
            os.close(said)
        else:
            with suppress(OSError):  # it has ended
                _write(calls, frame)
        relayed(partial(_read, answers), partial(_write, taken))


def _read(pipe: int, count: int) -> bytes:
    """Exactly so many bytes; the end of the other side is that of this process."""
    parts = bytearray()
    while len(parts) < count:
        part = os.read(pipe, count - len(parts))
        if not part:
            os._exit(0)
        parts += part
    return bytes(parts)


def _write(pipe: int, data: bytes | bytearray) -> None:
    frame = memoryview(data)
    while len(frame):
        frame = frame[os.write(pipe, frame) :]


def _finish(child: int, *pipes: int) -> None:
    """Kill an entry, wait for it, and leave nothing of it."""
    os.kill(child, 9)
    if os.getpid() == 1:  # of a namespace: elsewhere it would be the machine's processes
        with suppress(ProcessLookupError):
            os.kill(-1, 9)
        with suppress(ChildProcessError):
            while True:  # it has inherited whatever the entry has started
                os.waitpid(-1, 0)
    else:
        os.waitpid(child, 0)
    for pipe in pipes:
        os.close(pipe)
    _empty(os.getcwd())


def _answer_for(source: str, name: str, next_call: Callable, answer: Callable) -> None:
    """Answer `start` with the task and `update` with the records, until it is killed."""
    import numpy as np

    entry, module = None, ModuleType("entry")
    sys.modules["entry"] = module
    call = {"load": {}}
    while True:
        try:
            ((method, of),) = call.items()
            if method == "load":
                exec(compile(source, name, "exec"), module.__dict__)
                entry = module.Entry()
                answer({"loaded": True})
            else:
                found = getattr(entry, method)(SimpleNamespace(**of))
                if found is None:
                    answer({"stop": True})
                else:
                    answer({"correction": np.asarray(found, np.float64)})
        except BaseException as error:  # an entry may raise anything
            answer({"raised": f"{type(error).__name__}: {error}"[:300]})
        call = next_call()


def _empty(folder: str) -> None:
    for path in os.scandir(folder):
        with suppress(OSError):
            shutil.rmtree(path) if path.is_dir(follow_symlinks=False) else os.unlink(path)


def main() -> None:
    """What the judge wants is in the only argument, as JSON."""
    _libc.prctl(DIE_WITH_PARENT, 9)
    asked = json.loads(sys.argv[1])
    given, taken = os.dup(0), os.dup(1)
    null = os.open(os.devnull, os.O_RDWR)
    for stream in (0, 1, 2):
        os.dup2(null, stream)
    os.close(null)
    isolation = []
    if asked["isolate"]:
        isolation = isolate(asked["libraries"], asked["root"], asked["cache"])
    isolation += drop(asked["memory"])
    sys.path[:0] = asked["path"]
    sys.argv = [""]
    # Threads of BLAS that wait for a busy core make small matrices much slower.
    os.environ.update({"HOME": os.getcwd(), "XDG_CACHE_HOME": CACHE})
    os.environ.update({f"{name}_NUM_THREADS": "1" for name in ("OPENBLAS", "OMP", "NUMBA")})
    serve(given, taken, isolation, asked["preloaded"])


if __name__ == "__main__":
    main()
