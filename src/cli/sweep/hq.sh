#!/bin/bash
#HQ --name=@NAME@
#HQ --array=1-@SHARDS@
#HQ --cpus=@THREADS@
# Runs the sweep @NAME@ in @SHARDS@ shards with HyperQueue. Submit:
#     hq submit --directives=always THIS_FILE
# A shard that was stopped goes on where it was: submit the file again, and what is done is done. When all tasks are done:
#     @PROGRAM@ sweep @CONFIG@@LEVEL@ --out @OUT@ --collect
set -eu
exec @PROGRAM@ --threads @THREADS@ sweep @CONFIG@@LEVEL@ --out @OUT@ --shard "$HQ_TASK_ID/@SHARDS@"
