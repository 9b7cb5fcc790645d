"""Tasks on a Ray cluster."""

import socket
from collections.abc import Callable, Hashable
from typing import Any

from ..shell.errors import InputError, one_line
from ..shell.extras import needs

RETRIES = 3
"""Of a task whose node went away."""
TIMEOUT = 10.0
"""[s], for a cluster to accept a connection."""


class RayCluster:
    """An engine of `queue.Queue` on nodes that have armside installed. Tasks of lost nodes are
    run again."""

    def __init__(self, address: str) -> None:
        """Raises InputError when Ray is not installed or the cluster does not answer."""
        with needs("cluster", "the engine ray", "Ray"):
            import ray  # pyright: ignore[reportMissingImports]
        self._ray = ray
        try:
            _knock(address)
            ray.init(address=address, log_to_driver=False, logging_level="ERROR")
        except (ConnectionError, RuntimeError, ValueError, OSError) as error:
            raise InputError(f"no Ray cluster answers at {address}: {one_line(error)}") from error
        self._call = ray.remote(num_cpus=1, max_retries=RETRIES)(_call)
        self._running: dict[Any, Hashable] = {}

    @property
    def room(self) -> int:
        return max(1, int(self._ray.cluster_resources().get("CPU", 1))) - len(self._running)

    @property
    def busy(self) -> bool:
        return bool(self._running)

    def submit(self, tag: Hashable, function: Callable[[Any], Any], item: Any) -> None:
        self._running[self._call.remote(function, item)] = tag

    def collect(self) -> list[tuple[Any, Any]]:
        done, _ = self._ray.wait(list(self._running), num_returns=1)
        outcomes: list[tuple[Any, Any]] = []
        for reference in done:
            try:
                outcome = self._ray.get(reference)
            except self._ray.exceptions.RayError as error:
                outcome = error
            outcomes.append((self._running.pop(reference), outcome))
        return outcomes

    def close(self) -> None:
        self._ray.shutdown()


def _call(function: Callable[[Any], Any], item: Any) -> Any:
    return function(item)


def _knock(address: str) -> None:
    """Raise OSError when nobody listens at host:port; Ray itself would try for minutes."""
    host, _, port = address.removeprefix("ray://").rpartition(":")
    if host and port.isdigit():
        socket.create_connection((host, int(port)), TIMEOUT).close()
