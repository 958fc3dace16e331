#!/bin/sh
# Trains the quadruped on flat ground for about two and a half minutes on a machine with many cores.
# Usage: train_walk.sh FOLDER [further arguments of learn_to_walk.py]
set -e
out=${1:?give the folder of the results}
shift
cd "$(dirname "$0")/../.."
device=cpu
${PYTHON:=python3} -c 'import sys, torch; sys.exit(not torch.cuda.is_available())' && device=cuda
exec "$PYTHON" python/examples/learn_to_walk.py --envs 1024 --iterations 100000 --seconds 150 --device "$device" --out "$out" "$@"
