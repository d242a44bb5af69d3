#!/bin/bash
#SBATCH --job-name=hexheap
#SBATCH --ntasks=91              # ranks: 1, 7, 19, 37, 61, 91, 127 ...
#SBATCH --ntasks-per-core=1      # one to a core, none to its second thread
#SBATCH --time=04:00:00
#SBATCH --signal=USR1@120        # two minutes before the end: write the checkpoint
#SBATCH --requeue                # what did not come to its end is queued again ...

restart=()
[[ -f heap.h5 ]] && restart=(--restart heap.h5)  # ... and goes on from there

srun --cpu-bind=cores ./build/heap --radius 60 --steps 20000 --csv heap.csv --json heap.json --quiet \
  --checkpoint heap.h5 --checkpoint-every 1000 "${restart[@]}"
