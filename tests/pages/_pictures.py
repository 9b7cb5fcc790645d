"""Pictures as sources: each PNG of the docs has text chunks that say what made it of which data.

The same stands in results.json, so that a picture without them, or another one, is noticed.
"""

import hashlib
import json
import re
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image
from PIL.PngImagePlugin import PngInfo

from .. import evidence
from ._engine import ROOT, Result, Source, by_claim, made_with_today

IMAGES = ROOT / "docs/images"
_VOLATILE = ("config", "made_with")
"""Members of JSON that name folders, versions and machines."""


def picture(name: str) -> Source:
    """Source of a picture of `tests/gallery`; `LINE` and `SEED` are read, not imported."""
    file = Path(str(evidence.file("gallery", name)))
    line, claim, seed = (
        (re.findall(rf'^{word} = "?([^"\n]*)', file.read_text("utf-8"), re.M) or [""])[0]
        for word in ("LINE", "CLAIM", "SEED")
    )
    seed = seed or (re.findall(r"--seed (\d+)", line) or ["0"])[0]
    made = claim and f"make claims NAME={claim}"
    return Source(
        f"{name}.png", (made or line or f"make pictures NAME={name}",), {}, drawn_by=file, seed=seed
    )


def pictures() -> dict[str, Source]:
    """Sources of the pictures by file name."""
    return {f"{name}.png": picture(name) for name in evidence.names("gallery")}


def drawn(source: Source, file: Path, data: Any) -> Result:
    """Result of a picture, made by today's code, or by that of the claim whose rows it shows."""
    version, code = by_claim(source.claim) if source.claim else made_with_today(source)
    values = {"seed": source.seed, "data": digest(data), "pixels": pixels(file)}
    return Result(version, code, source.lines, values)


def chunks(name: str, result: Result) -> dict[str, str]:
    """Text chunks of a picture by their keys."""
    made, line = f"make pictures NAME={name.removesuffix('.png')}", result.lines[-1]
    if line != made:
        made += f": {line}" if line.startswith("make ") else f": armside {line}"
    seed, data = result.values["seed"], result.values["data"]
    by = {"Software": f"armside {result.version}", "Source": made}
    return by | {"Seed": seed, "Data": data, "Code": result.code}


def stamp(file: Path, result: Result) -> None:
    """Write the text chunks of a picture."""
    info = PngInfo()
    for key, text in chunks(file.name, result).items():
        info.add_text(key, text)
    with Image.open(file) as image:
        image.load()
        image.save(file, format="PNG", optimize=True, pnginfo=info)


def stamps(file: Path) -> dict[str, str]:
    """Text chunks that a PNG has."""
    with Image.open(file) as image:
        image.load()
        return dict(getattr(image, "text", {}))


def pixels(file: Path) -> str:
    """Digest of what is seen, whatever the chunks."""
    with Image.open(file) as image:
        return _sha(image.convert("RGB").tobytes())


def digest(data: Any) -> str:
    """Digest of data: JSON, arrays and bytes in it; floats to nine digits, as machines differ."""
    return _sha(json.dumps(_plain(data), sort_keys=True).encode())


def of_folder(folder: Path) -> Any:
    """Data of a folder that a line of armside wrote: summary, or sections of a report."""
    files = [folder / "summary.json"]
    files = files if files[0].exists() else sorted((folder / "sections").glob("*.json"))
    found = [json.loads(file.read_text("utf-8")) for file in files]
    return [{key: of[key] for key in of if key not in _VOLATILE} for of in found]


def _plain(data: Any) -> Any:
    if isinstance(data, bytes):
        return _sha(data)
    if isinstance(data, float):
        return f"{data:.9g}"
    if isinstance(data, np.ndarray):
        return _plain(data.tolist())
    if isinstance(data, dict):
        return {key: _plain(value) for key, value in data.items()}
    return [_plain(value) for value in data] if isinstance(data, list | tuple) else data


def _sha(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()[:16]
