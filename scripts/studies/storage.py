"""The database of Optuna's studies, with errors of one line that hide the secrets of its URL, and
heartbeats by which trials of killed processes are tried again.

Optuna is imported here only where it is used: it takes half a second.
"""

import logging
import random
import sys
import threading
import time
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import unquote

from ..shell.errors import InputError, RunFailed, install, one_line

if TYPE_CHECKING:
    import optuna

CONNECT_TIMEOUT = 10
"""[s], for a storage server to answer."""
LOCK_TIMEOUT = 60
"""[s], for other programs to let go of an SQLite file: processes that share a study write for
milliseconds each, but in no order, and one that gives up has lost its trial."""
SLOW = 5.0
"""[s] of waiting, after which a person is told what for."""
HAVE_TIMEOUT = ("psycopg", "psycopg2", "mysqldb", "pymysql")
"""Drivers with an option `connect_timeout`."""
SHOWN = ("host", "port", "dbname", "service", "sslmode", "charset", "mode", "uri", "timeout")
"""Entries of a URL's query that may be shown: each driver has names of its own for secrets."""
TABLES = {"studies": "study_id", "trials": "trial_id"}
"""Tables of Optuna with names that another program may have given too, and a column of each."""
MIGRATIONS = "alembic_version"
"""Table of programs that migrate their database as Optuna does."""
HEARTBEAT = 2
"""[s], between signs of life of a running trial."""
SILENCE = 8
"""[s] without one, four of them, after which other processes take a trial for dead. Being wrong
costs one trial: see `search.run_trial`."""
RETRIES = 2
"""Repetitions of a trial that died: its design may be what kills."""
ATTEMPTS = 5
"""At making the tables of a new database, which others may be making too."""


@contextmanager
def reaching(storage: str) -> Iterator[None]:
    """Open a storage: errors of its URL, its driver or its server become InputError. A long wait,
    as for a file that is locked, is announced on stderr."""
    from optuna.exceptions import OptunaError
    from sqlalchemy.exc import SQLAlchemyError

    waiting = f"armside: waiting for storage {redacted(storage)!r}"
    patience = threading.Timer(SLOW, lambda: print(waiting, file=sys.stderr))
    patience.daemon = True
    patience.start()
    try:
        yield
    except InputError:
        raise
    except ImportError as error:
        # Optuna wraps the error that names the driver.
        cause = error.__cause__ if isinstance(error.__cause__, ImportError) else error
        missing = f"the database driver {cause.name}, which is not installed"
        if storage.startswith("postgresql"):
            missing += f"; {install('postgres')} brings that of postgresql+psycopg://"
        raise InputError(f"storage {redacted(storage)!r} needs {missing}") from error
    # RuntimeError: tables of another version of Optuna.
    except (SQLAlchemyError, OptunaError, OSError, ValueError, RuntimeError) as error:
        reason = f"does not answer: {_reason(error)}"
        raise InputError(f"storage {redacted(storage)!r} {reason}") from error
    finally:
        patience.cancel()


@contextmanager
def using(storage: str) -> Iterator[None]:
    """Work with an open storage: one that is lost on the way becomes RunFailed. Optuna's thread of
    heartbeats loses it too, and would print a traceback beside that."""
    others = threading.excepthook
    threading.excepthook = lambda ended: None if _lost(ended.exc_value) else others(ended)
    try:
        yield
    except Exception as error:
        if (lost := _lost(error)) is None:
            raise
        raise RunFailed(
            f"storage {redacted(storage)!r} failed: {_reason(lost)}; it keeps finished trials"
        ) from error
    finally:
        threading.excepthook = others


def _lost(error: BaseException | None) -> BaseException | None:
    """The storage's error that an error is, or was raised while handling: Optuna ends a trial in
    a block of `finally`, which fails in its own way without a storage."""
    from optuna.exceptions import StorageInternalError
    from sqlalchemy.exc import SQLAlchemyError

    while error is not None and not isinstance(error, (SQLAlchemyError, StorageInternalError)):
        error = error.__cause__ or error.__context__
    return error


def connect(storage: str) -> "optuna.storages.RDBStorage":
    """The database of an SQLAlchemy URL, with its tables; the folder of an SQLite file is made.
    Processes that make them at the same moment try again. Raises InputError for anything else, and
    for a database of another program; use it in a block of `reaching`."""
    import optuna
    from sqlalchemy.exc import IntegrityError, OperationalError, ProgrammingError

    # A pool whose server goes away would print the traceback of what the command says in one line.
    logging.getLogger("sqlalchemy.pool").addHandler(logging.NullHandler())
    options = _options(storage)
    _refuse_foreign(storage, options)
    if (file := _file(storage)) is not None:
        file.parent.mkdir(parents=True, exist_ok=True)
    for attempt in range(1, ATTEMPTS + 1):
        try:
            # Optuna fills a template in: braces in a path or a password are none.
            literal = storage.replace("{", "{{").replace("}", "}}")
            with _experiments_allowed():
                return optuna.storages.RDBStorage(literal, **options)
        except (IntegrityError, OperationalError, ProgrammingError) as error:
            others = not isinstance(error, OperationalError) or "already exists" in str(error)
            if attempt == ATTEMPTS or not others:
                raise
            time.sleep(random.uniform(0.5, 1.5))
    raise AssertionError("unreachable")


def redacted(storage: str) -> str:
    """The URL with *** for its password and for all entries of its query that may be secret."""
    from sqlalchemy.engine import make_url
    from sqlalchemy.exc import ArgumentError

    try:
        url = make_url(storage)
    except (ArgumentError, ValueError):  # no URL: what has an @ or a = may be anything
        return "***" if set("@=") & set(storage) else storage
    query = {name: text if name.lower() in SHOWN else "***" for name, text in url.query.items()}
    host = url.host and url.host.rpartition("@")[2]  # of a password with an @
    return unquote(url.set(query=query, host=host).render_as_string(hide_password=True))


def fail_silent(study: "optuna.Study") -> None:
    """Give up on running trials without a sign of life: each is tried again, at most RETRIES
    times."""
    import optuna

    with _experiments_allowed():
        optuna.storages.fail_stale_trials(study)


def _options(storage: str) -> dict[str, Any]:
    """Keyword arguments of Optuna's storage for this kind of database."""
    from optuna.storages import RetryHeartbeatStaleTrialCallback
    from sqlalchemy.engine import make_url
    from sqlalchemy.exc import ArgumentError

    try:
        url = make_url(storage)
        driver = url.get_dialect().driver
    except (ArgumentError, ValueError) as error:
        raise InputError(
            f"storage {redacted(storage)!r} is no SQLAlchemy URL, such as sqlite:///runs/x.sqlite3"
        ) from error
    with _experiments_allowed():
        again = RetryHeartbeatStaleTrialCallback(max_retry=RETRIES)
    # Running trials give signs of life; one that stops to is failed, and queued again.
    watched = {
        "heartbeat_interval": HEARTBEAT,
        "grace_period": SILENCE,
        "heartbeat_stale_trial_callback": again,
    }
    if url.get_backend_name() != "sqlite":
        limit = {"connect_timeout": CONNECT_TIMEOUT} if driver in HAVE_TIMEOUT else {}
        return {"engine_kwargs": {"connect_args": limit, "pool_pre_ping": True}} | watched
    options: dict[str, Any] = {"engine_kwargs": {"connect_args": {"timeout": LOCK_TIMEOUT}}}
    if url.database in (None, "", ":memory:"):  # belongs to a single thread
        return options
    if "mode" in url.query and not url.database.startswith("file:"):
        as_uri = f"sqlite:///file:{url.database}?mode={url.query['mode']}&uri=true"
        raise InputError(f"?mode= is part of an SQLite URI: {as_uri}")
    return options | watched


def _file(storage: str) -> Path | None:
    """File of an SQLite database; None for another kind, in memory or as a URI."""
    from sqlalchemy.engine import make_url

    url = make_url(storage)
    ours = url.get_backend_name() == "sqlite" and url.database
    return None if not ours or url.database in (":memory:",) or "uri" in url.query else Path(ours)


def _refuse_foreign(storage: str, options: dict[str, Any]) -> None:
    """Raise InputError for tables of another program: Optuna would add its own beside them."""
    import sqlalchemy

    foreign = f"storage {redacted(storage)!r} belongs to another program: its table"
    engine = sqlalchemy.create_engine(storage, **options["engine_kwargs"])
    try:
        if (file := _file(storage)) is not None and not file.exists():
            engine.dialect.loaded_dbapi  # noqa: B018 - raises ImportError without its driver
            return  # and a connection would make the file
        known = sqlalchemy.inspect(engine)
        names = set(known.get_table_names())
        for table in sorted(set(TABLES) & names):
            if TABLES[table] not in [column["name"] for column in known.get_columns(table)]:
                raise InputError(f"{foreign} {table!r} is none of Optuna's")
        # A file is of one program; a server's database may serve several, but not two that migrate.
        others = names if file is not None else names & {MIGRATIONS}
        if others and not set(TABLES) <= names:
            raise InputError(f"{foreign} {min(others)!r} is none of Optuna's")
    finally:
        engine.dispose()


@contextmanager
def _experiments_allowed() -> Iterator[None]:
    """Optuna calls its heartbeats experimental, in a warning at each use."""
    from optuna.exceptions import ExperimentalWarning

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ExperimentalWarning)
        yield


def _reason(error: BaseException) -> str:
    """Message of the driver, without those of SQLAlchemy and Optuna around it."""
    while error.__cause__ is not None:
        error = error.__cause__
    cause = getattr(error, "orig", None) or error
    return one_line(cause).split(" Is the server running")[0]
