"""A study with submitit, the library behind Hydra's launcher for Slurm: one task per shard, then the results, checked.

    python with_submitit.py study.toml study.csv --shards 16 --cluster slurm
    python with_submitit.py study.toml study.csv --shards 16 --cluster local     # processes on this computer
"""

import argparse
import subprocess
import sys

import submitit


def shard(results: str, number: int, threads: int) -> int:
    """Runs one shard, or what is left of it."""
    command = ["cocarry", "cluster", "shard", results, str(number), "--threads", str(threads)]
    return subprocess.run(command, check=True).returncode


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("study")
    parser.add_argument("results")
    parser.add_argument("--shards", type=int, default=16)
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--cluster", default=None, help="slurm, local, or what submitit finds")
    given = parser.parse_args()
    make = ["cocarry", "cluster", "slurm", given.study, "--output", given.results, "--shards", str(given.shards)]
    subprocess.run([*make, "--no-submit"], check=True)
    executor = submitit.AutoExecutor(folder=f"{given.results}.job/logs", cluster=given.cluster)
    executor.update_parameters(cpus_per_task=given.threads, timeout_min=240, name="cocarry")
    numbers = list(range(1, given.shards + 1))
    jobs = executor.map_array(shard, [given.results] * given.shards, numbers, [given.threads] * given.shards)
    failed = [number for number, job in zip(numbers, jobs, strict=True) if job.exception() is not None]
    if failed:
        print(f"shards that failed: {failed}; see the logs in {given.results}.job/logs", file=sys.stderr)
        return 1
    return subprocess.run(["cocarry", "cluster", "gather", given.results, "--audit", "1"], check=False).returncode


if __name__ == "__main__":
    sys.exit(main())
