"""The database of Optuna's studies: what is wrong with it is said in one line, and trials whose
process was killed are tried again.

Optuna is imported here only where it is used: it takes half a second.
"""

import random
import re
import time
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .errors import InputError, one_line

if TYPE_CHECKING:
    import optuna

CONNECT_TIMEOUT = 10
"""[s], for a storage server to answer."""
HAVE_TIMEOUT = ("psycopg", "psycopg2", "mysqldb", "pymysql")
"""Drivers that take it as `connect_timeout`."""
HEARTBEAT = 10
"""[s], between signs of life of a running trial."""
SILENCE = 60
"""[s] without one, after which other processes take a trial for dead."""
RETRIES = 2
"""Of a trial that died: its design may be what kills."""
ATTEMPTS = 5
"""At making the tables of a new database, which others may be making too."""


@contextmanager
def reaching(storage: str) -> Iterator[None]:
    """Open a storage: what its URL, its driver or its server can cause becomes InputError."""
    from sqlalchemy.exc import SQLAlchemyError

    try:
        yield
    except InputError:
        raise
    except ImportError as error:
        raise InputError(_missing(storage, error)) from error
    except (SQLAlchemyError, OSError, ValueError) as error:
        raise InputError(f"storage {shown(storage)} does not answer: {_reason(error)}") from error


def connect(storage: str) -> "optuna.storages.RDBStorage":
    """The database, with its tables. Processes that make them at the same moment try again.

    storage: URL as SQLAlchemy writes them; the folder of an SQLite file is made. Raises InputError
    for what is none; use it in a block of `reaching`.
    """
    from sqlalchemy.exc import IntegrityError, ProgrammingError

    options = _options(storage)
    for attempt in range(1, ATTEMPTS + 1):
        try:
            return _open(storage, options)
        except (IntegrityError, ProgrammingError):
            if attempt == ATTEMPTS:
                raise
            time.sleep(random.uniform(0.5, 1.5))
    raise AssertionError("unreachable")


def shown(storage: str) -> str:
    """The URL without its password, quoted."""
    return repr(re.sub(r"(://[^:/@]*):.*@", r"\1:***@", storage))


def _options(storage: str) -> dict[str, Any]:
    """Keyword arguments of Optuna's storage for this kind of database."""
    from sqlalchemy.engine import make_url
    from sqlalchemy.exc import ArgumentError

    try:
        url = make_url(storage)
        driver = url.get_dialect().driver
    except (ArgumentError, ValueError) as error:
        raise InputError(
            f"storage {shown(storage)} is no SQLAlchemy URL, such as sqlite:///runs/x.sqlite3"
        ) from error
    if url.get_backend_name() != "sqlite":
        limit = {"connect_timeout": CONNECT_TIMEOUT} if driver in HAVE_TIMEOUT else {}
        return {"engine_kwargs": {"connect_args": limit, "pool_pre_ping": True}} | _watched()
    options: dict[str, Any] = {
        "engine_kwargs": {"connect_args": {"timeout": 60}}  # another process may be writing
    }
    if url.database in (None, "", ":memory:"):  # belongs to a single thread
        return options
    Path(url.database).parent.mkdir(parents=True, exist_ok=True)
    return options | _watched()


def _watched() -> dict[str, Any]:
    """Running trials give signs of life; one that stops to is failed, and tried again."""
    from optuna.storages import RetryHeartbeatStaleTrialCallback

    with _experiments_allowed():
        again = RetryHeartbeatStaleTrialCallback(max_retry=RETRIES)
    return {
        "heartbeat_interval": HEARTBEAT,
        "grace_period": SILENCE,
        "heartbeat_stale_trial_callback": again,
    }


def _open(storage: str, options: dict[str, Any]) -> "optuna.storages.RDBStorage":
    import optuna

    with _experiments_allowed():
        return optuna.storages.RDBStorage(storage, **options)


@contextmanager
def _experiments_allowed() -> Iterator[None]:
    """Optuna calls its heartbeats experimental, in a warning at each use."""
    from optuna.exceptions import ExperimentalWarning

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ExperimentalWarning)
        yield


def _missing(storage: str, error: ImportError) -> str:
    """Which driver to install. Optuna wraps the error that names it."""
    cause = error.__cause__ if isinstance(error.__cause__, ImportError) else error
    advice = ""
    if storage.startswith("postgresql"):
        advice = "; pip install 'armside[postgres]' brings that of postgresql+psycopg://"
    missing = f"the database driver {cause.name}, which is not installed"
    return f"storage {shown(storage)} needs {missing}{advice}"


def _reason(error: Exception) -> str:
    """The driver's own words, without SQLAlchemy's around them."""
    cause = getattr(error, "orig", None) or error
    return one_line(cause).split(" Is the server running")[0]
