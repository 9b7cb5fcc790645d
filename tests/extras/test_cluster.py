"""The extra [cluster]: a sweep on a real Ray cluster of two nodes, one of which goes away.

Ray listens on the machine's first address. The cluster therefore runs in a network namespace that
has nothing but a loopback device; without one these tests do not start it.
"""

import os
import subprocess
import sys
import tempfile
import textwrap
from pathlib import Path

import pytest

pytest.importorskip("ray", reason="needs the extra [cluster]", exc_type=ImportError)

ROOT = Path(__file__).parent.parent.parent
QUICK = {"RAY_worker_niceness": "0"}
"""Ray lets its workers wait for whatever else the machine has to do."""
LIMIT = 300
"""[s], of a test: twenty times what it takes."""

CLUSTER = """
import os, sys
from pathlib import Path

os.environ |= {"RAY_USAGE_STATS_ENABLED": "0", "RAY_DISABLE_IMPORT_WARNING": "1"}
NODE = {"num_cpus": 1, "object_store_memory": 80 * 2**20}
from ray.cluster_utils import Cluster

from armside.scripts.jobs.dataset import Dataset
from armside.scripts.jobs.grid import parse, run_grid
from armside.scripts.jobs.workers import RayCluster, Workers

def main():
    folder, axes = Path(sys.argv[1]), ["speed=60", "iterations=3", "gamma=0.5,0.9", "seed=0:4"]
    cluster = Cluster(initialize_head=True, head_node_args=NODE)
    second = cluster.add_node(**NODE)
    cluster.wait_for_nodes()
    assert cluster.address.startswith("127.0.0.1:"), cluster.address
    grid = parse(axes, 0)
    on_ray, local = Dataset(folder / "ray"), Dataset(folder / "local")
    engine = RayCluster(cluster.address)
    done = 0

    def step():
        nonlocal done
        done += 1
        if done == 3:
            cluster.remove_node(second, allow_graceful=False)

    counts = run_grid(grid, on_ray, engine, step)
    engine.close()
    cluster.shutdown()
    assert counts == {"done": 8}, on_ray.read()["error"].to_pylist()
    with Workers() as workers:
        run_grid(grid, local, workers)
    assert on_ray.read().equals(local.read())
    print("equal")

if __name__ == "__main__":  # worker processes import this file
    main()
"""


@pytest.fixture
def run_alone(require_program, tmp_path):
    """Runs Python where there is only a loopback device, in namespaces of its own, or skips."""
    require_program("unshare")
    require_program("ip")
    as_root = [] if os.geteuid() == 0 else ["--map-root-user"]
    # With the namespace of process ids, nothing that Ray has started outlives the test.
    spaces = [*as_root, "--net", "--pid", "--fork", "--kill-child", "--mount-proc"]
    alone = ["unshare", *spaces, "sh", "-c", 'ip link set lo up && exec "$@"', "sh"]
    probe = subprocess.run([*alone, "true"], capture_output=True, check=False)
    if probe.returncode:  # of the kernel, not of a program that could be installed
        pytest.skip("needs a network namespace (unshare --net), which is not permitted here")

    def run(code, *arguments):
        script = tmp_path / "script.py"
        script.write_text(textwrap.dedent(code))
        # Short: the sockets of Ray are in it, and have at most 107 characters.
        with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
            environment = (
                os.environ | QUICK | {"PYTHONPATH": str(ROOT / "src"), "RAY_TMPDIR": folder}
            )
            return subprocess.run(
                [*alone, sys.executable, str(script), *map(str, arguments)],
                cwd=tmp_path,
                env=environment,
                capture_output=True,
                text=True,
                timeout=LIMIT,
                check=False,
            )

    return run


def test_a_node_that_is_removed_loses_no_result(run_alone, tmp_path):
    done = run_alone(CLUSTER, tmp_path)
    assert done.returncode == 0, done.stderr[-3000:]
    assert done.stdout.endswith("equal\n")


def test_a_cluster_that_does_not_answer_is_one_clear_error(run_alone):
    code = """
    from armside.scripts import cli
    print(cli.main(["sweep", "gamma=0.9", "--engine", "ray", "--address", "127.0.0.1:1"]))
    """
    done = run_alone(code)
    assert done.stdout.endswith("2\n"), done.stderr[-2000:]
    assert "no Ray cluster answers at 127.0.0.1:1" in done.stderr
