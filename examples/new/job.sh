#!/bin/bash
#SBATCH --job-name=@NAME@
#SBATCH --ntasks=16              # ranks; any number: main.cpp says grid<dynamic, dynamic>
#SBATCH --ntasks-per-core=1      # one to a core, none to its second thread
#SBATCH --time=01:00:00
# With features<checkpoints> in main.cpp (README.md says how) remove one # from the next four lines: the
# job writes its state two minutes before its time ends, is queued again, and goes on from there.
##SBATCH --signal=USR1@120
##SBATCH --requeue
# keep=(--checkpoint @NAME@.h5 --checkpoint-every 1000)
# [[ -f @NAME@.h5 ]] && keep+=(--restart @NAME@.h5)

srun --cpu-bind=cores ./build/@NAME@ --steps 2000 --csv @NAME@.csv --json @NAME@.json --quiet "${keep[@]}"
