#!/usr/bin/env bash
# Faces from photos beside a peer: ours and eos, which is given the same model, on the same points.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
source tests/peers/peers.sh

usage() {
    cat <<END
usage: ICT_FACEKIT=DIR tests/peers/photo.sh --template FILE [--model FILE] [--count N] [--seed S]

DIR holds ICT-FaceKit's FaceXModel. The table goes to the terminal, its numbers to
target/peers/photo.json. eos takes some 20 milliseconds a photo, and is tried with every
regularisation.
END
}

case "${1:---help}" in -h | --help) usage && exit ;; esac
need_ict

venv=target/peers/venv-photo
need_peers "$venv" tests/peers/requirements-photo.txt

# One thread for everybody.
export RAYON_NUM_THREADS=1 OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1
exec "$venv/bin/python" tests/peers/photo.py --ict "$ICT_FACEKIT" \
    --program target/release/phiz-fit "$@"
