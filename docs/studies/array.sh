#!/bin/bash
# A study on a cluster, as a Slurm job array:
#
#   sbatch --array=1-16 docs/studies/array.sh 16 docs/studies/h2.toml
#   sbatch --array=3,4 docs/studies/array.sh 16 docs/studies/h2.toml   # tasks 3 and 4 again, if they failed
#   cocarry sweep --merge h2.csv h2.*-of-16.csv                        # once all have ended
#
# The first argument is the number of shards of the whole study; it stays the same when only some tasks are submitted again. Every task
# runs its shard of the episodes and writes one file. A task that was stopped resumes when it is queued again. Further
# arguments go to `cocarry sweep`.
#SBATCH --job-name=cocarry
#SBATCH --cpus-per-task=4
#SBATCH --time=04:00:00
#SBATCH --requeue
set -euo pipefail

shards=${1:?the number of shards, such as 16}
study=${2:?the study file}
shift 2
exec cocarry sweep "$study" \
    --shard "$SLURM_ARRAY_TASK_ID/$shards" \
    --threads "$SLURM_CPUS_PER_TASK" \
    "$@"
