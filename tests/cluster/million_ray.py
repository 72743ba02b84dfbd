"""A study on a Ray cluster of two raylets, the second of which is killed half-way.

python million_ray.py STUDY RESULTS
"""

import resource
import sys

import cocarry
from ray.cluster_utils import Cluster


def main() -> None:
    study, results = sys.argv[1:]
    cluster = Cluster(initialize_head=True, head_node_args={"num_cpus": 1})
    second = cluster.add_node(num_cpus=1)
    cluster.wait_for_nodes()
    killed = []

    def tell(done: int, count: int) -> None:
        if not killed and 2 * done >= count:
            killed.append(done)
            cluster.remove_node(second, allow_graceful=False)

    cocarry.sweep(study, out=results, backend="ray", address=cluster.address, progress=tell, table=False)
    assert killed, "the raylet was not killed"
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(f"  the raylet was killed after {killed[0]} episodes; the driver's memory: {memory:.0f} MB", file=sys.stderr)


if __name__ == "__main__":
    main()
