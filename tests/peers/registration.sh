#!/usr/bin/env bash
# Registration beside its peers: ours, trimesh's nricp_sumner and nricp_amberg on the same simulated
# scans, template and landmarks, each on one thread, one after the other for each person.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
source tests/peers/peers.sh

usage() {
    cat <<END
usage: ICT_FACEKIT=DIR tests/peers/registration.sh --template FILE [--count N] [--seed S]
                                                   [--settings clean,noisy]

DIR holds ICT-FaceKit's FaceXModel. The table goes to the terminal, its numbers to
target/peers/registration.json. A peer takes about 20 seconds a scan.
END
}

case "${1:---help}" in -h | --help) usage && exit ;; esac
need_ict

venv=target/peers/venv
need_peers "$venv" tests/peers/requirements.txt

# One thread for everybody.
export RAYON_NUM_THREADS=1 OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1
exec "$venv/bin/python" tests/peers/registration.py --ict "$ICT_FACEKIT" \
    --program target/release/phiz-fit "$@"
