"""Frames between the judge and an entry: values of JSON, with arrays of float64 behind them.

A frame is a magic word, the lengths of the text and of the arrays [bytes], the text, the arrays.
Nothing is unpickled. What a reader takes is bounded before it is read.
"""

import json
import math
import struct
from collections.abc import Callable
from typing import Any

import numpy as np

MAGIC = b"ACF1"
HEAD = struct.Struct("<4sIQ")
LONGEST_TEXT = 1 << 20
"""[bytes], of the text of a frame."""
CHUNK = 1 << 20
"""[bytes] that are handed on at once."""


class FrameError(ValueError):
    """A frame that is none, or larger than allowed."""


def packed(value: Any) -> bytes:
    """A frame of dicts, lists, strings, numbers, None and float64 arrays."""
    arrays = list[np.ndarray]()

    def plain(one: Any) -> Any:
        if isinstance(one, np.ndarray):
            arrays.append(np.ascontiguousarray(one, dtype="<f8"))
            return {"array": list(one.shape)}
        if isinstance(one, dict):
            return {str(key): plain(each) for key, each in one.items()}
        if isinstance(one, list | tuple):
            return [plain(each) for each in one]
        return one.item() if isinstance(one, np.generic) else one

    text = json.dumps(plain(value)).encode()
    data = b"".join(array.tobytes() for array in arrays)
    return HEAD.pack(MAGIC, len(text), len(data)) + text + data


def relayed(read: Callable[[int], bytes], write: Callable[[bytes], None]) -> None:
    """Hand the next frame on as it comes; it is for its reader to refuse it."""
    head = read(HEAD.size)
    write(head)
    _, n_text, n_data = HEAD.unpack(head)
    left = n_text + n_data
    while left > 0:
        part = read(min(left, CHUNK))
        write(part)
        left -= len(part)


def unpacked(read: Callable[[int], bytes], most: int, longest: int = LONGEST_TEXT) -> Any:
    """The value of the next frame, with arrays of at most `most` bytes together, and a text of at
    most `longest`.

    read: exactly so many bytes. Raises FrameError.
    """
    magic, n_text, n_data = HEAD.unpack(read(HEAD.size))
    if magic != MAGIC:
        raise FrameError("an answer that is no frame")
    if n_text > longest or n_data > most:
        raise FrameError(f"an answer of {n_text + n_data} bytes, at most {most} are taken")
    text, data = read(n_text), read(n_data)
    place = 0

    def restored(one: Any) -> Any:
        nonlocal place
        if isinstance(one, dict) and set(one) == {"array"}:
            shape = one["array"]
            if not (isinstance(shape, list) and all(type(n) is int and n >= 0 for n in shape)):
                raise FrameError("an answer with an array without a shape")
            size = 8 * math.prod(shape)
            if place + size > len(data):
                raise FrameError("an answer whose arrays are not there")
            place += size
            return np.frombuffer(data, "<f8", size // 8, place - size).reshape(shape).copy()
        if isinstance(one, dict):
            return {key: restored(each) for key, each in one.items()}
        return [restored(each) for each in one] if isinstance(one, list) else one

    try:
        return restored(json.loads(text))
    except (ValueError, RecursionError) as error:
        if isinstance(error, FrameError):
            raise
        raise FrameError("an answer that is no frame") from error
