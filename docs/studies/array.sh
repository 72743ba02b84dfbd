#!/bin/bash
# A study on a cluster, as a Slurm job array:
#
#   sbatch --array=1-16 docs/studies/array.sh docs/studies/h2.toml
#   cocarry sweep --merge h2.csv h2.*-of-16.csv       # once all have ended
#
# Every task runs its share of the episodes and writes one file. A task that was stopped goes on where it was when it is queued again.
# Further arguments go to `cocarry sweep`.
#SBATCH --job-name=cocarry
#SBATCH --cpus-per-task=4
#SBATCH --time=04:00:00
#SBATCH --requeue
set -euo pipefail

study=$1
shift
exec cocarry sweep "$study" \
    --shard "$SLURM_ARRAY_TASK_ID/$SLURM_ARRAY_TASK_COUNT" \
    --threads "$SLURM_CPUS_PER_TASK" \
    "$@"
