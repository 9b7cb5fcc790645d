"""Rounds and their seal: tasks are drawn from HMAC-SHA256(salt, round/track/index).

The SHA-256 of the salt is published with the round, the salt when the round ends. The round of
development has the empty salt, so everybody draws its tasks.
"""

import hashlib
import hmac
import json
import secrets
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..records.files import InputError, check_can_write, check_file, reading

DEVELOPMENT = "development"
SALT_BYTES = 32


@dataclass(frozen=True)
class Round:
    """A round by its name, with the SHA-256 of its salt (hex); `development` has neither seal nor
    salt."""

    name: str = DEVELOPMENT
    digest: str = ""
    salt: bytes = b""

    def __post_init__(self) -> None:
        if not self.name or not self.name.replace("-", "").isalnum():
            raise ValueError(f"a round's name has letters, digits and -, got {self.name!r}")
        if (self.name == DEVELOPMENT) != (not self.digest):
            raise ValueError(f"a round but {DEVELOPMENT} has the SHA-256 of its salt")
        if self.judged and hashlib.sha256(self.salt).hexdigest() != self.digest:
            raise ValueError(f"the salt is not that of the round {self.name}: its SHA-256 differs")

    @property
    def judged(self) -> bool:
        """Tasks are sealed, and their ranges partly exceed those of development."""
        return self.name != DEVELOPMENT

    def key(self, *words: object) -> int:
        """The 256 bits of HMAC-SHA256(salt, round/word/...), as an integer."""
        text = "/".join(map(str, (self.name, *words))).encode()
        return int.from_bytes(hmac.digest(self.salt, text, "sha256"))

    def rng(self, *words: object) -> np.random.Generator:
        """Source of a task's draws."""
        return np.random.default_rng(self.key(*words))


def new_round(name: str, folder: Path) -> Round:
    """Draw a salt; write NAME.json, to be published, and NAME.salt, to be kept until the end.

    Raises InputError where one of them exists already.
    """
    salt = secrets.token_bytes(SALT_BYTES)
    if name == DEVELOPMENT:
        raise InputError(f"the round {DEVELOPMENT} is public: it has no salt")
    made = Round(name, hashlib.sha256(salt).hexdigest(), salt)
    public, secret = folder / f"{name}.json", folder / f"{name}.salt"
    check_can_write(folder)
    for file in (public, secret):
        if file.exists():
            raise InputError(f"{file} exists already: a round is made once")
    secret.touch(mode=0o600)
    secret.write_text(salt.hex() + "\n")
    public.write_text(json.dumps({"round": name, "salt_sha256": made.digest}, indent=2) + "\n")
    return made


def read_round(file: Path, salt: str) -> Round:
    """The round of a published file with its salt: 64 hex digits, or a file that holds them.

    Raises InputError for a file that is none, and for a salt that is not that of the round.
    """
    with reading(check_file(file)):
        found = json.loads(file.read_text(encoding="utf-8"))
        name, digest = str(found["round"]), str(found["salt_sha256"])
    text = salt
    if len(salt) != 2 * SALT_BYTES:
        text = check_file(Path(salt)).read_text(encoding="utf-8").strip()
    try:
        return Round(name, digest, bytes.fromhex(text))
    except ValueError as error:
        raise InputError(f"{file}: {error}") from error
