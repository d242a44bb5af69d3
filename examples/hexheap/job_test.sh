#!/usr/bin/env bash
# job.sh, with a stand-in for srun that starts seven ranks on this machine and makes the job small: it
# runs, keeps its checkpoint, and goes on from there when it is queued again.
#   job_test.sh PROGRAM MPIEXEC NUMPROC_FLAG
set -euo pipefail
job=$(cd "$(dirname "$0")" && pwd)/job.sh
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
mkdir build bin
ln -s "$1" build/heap
cat >bin/srun <<END
#!/usr/bin/env bash
[[ \$1 == --cpu-bind=cores ]] || { echo "srun: \$1?"; exit 1; }
shift
words=()
while ((\$#)); do
  case \$1 in
    --radius) words+=(--radius 8); shift ;;
    --steps) words+=(--steps "\$STEPS"); shift ;;
    --checkpoint-every) words+=(--checkpoint-every 10); shift ;;
    *) words+=("\$1") ;;
  esac
  shift
done
exec "$2" "$3" 7 "\${words[@]}"
END
chmod +x bin/srun
bash -n "$job"
grep -q '^#SBATCH --ntasks=91 ' "$job"
STEPS=30 PATH=$work/bin:$PATH bash "$job"
[[ -s heap.h5 && -s heap.csv ]]
grep -q '"ranks": 7,' heap.json && grep -q '"steps": 30,' heap.json
STEPS=50 PATH=$work/bin:$PATH bash "$job"
grep -q '"restarted_at": 30,' heap.json && grep -q '"steps": 50,' heap.json
