#!/bin/bash
#SBATCH --job-name=@NAME@
#SBATCH --array=1-@SHARDS@
#SBATCH --cpus-per-task=@THREADS@
# Runs the sweep @NAME@ in @SHARDS@ shards, each an element of a Slurm array. Submit:
#     sbatch --time=HH:MM:SS THIS_FILE
# A shard that was stopped goes on where it was: submit the file again, and what is done is done. When all elements are done:
#     @PROGRAM@ sweep @CONFIG@@LEVEL@ --out @OUT@ --collect
set -eu
exec @PROGRAM@ --threads "${SLURM_CPUS_PER_TASK:-@THREADS@}" sweep @CONFIG@@LEVEL@ --out @OUT@ --shard "$SLURM_ARRAY_TASK_ID/@SHARDS@"
