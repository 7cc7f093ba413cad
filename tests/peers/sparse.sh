#!/usr/bin/env bash
# The sparse basis beside numpy: the same problem, start and number of iterations, in turns.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
source tests/peers/peers.sh

usage() {
    cat <<END
usage: tests/peers/sparse.sh --template FILE --faces DIR [--count N] [--components K]
                             [--iterations N] [--repeats N]

DIR holds registered faces. The table goes to the terminal, its numbers to
target/peers/sparse.json. Exits 1 when ours is not 15 times as fast as numpy, or our objective more
than 0.1 % above numpy's or away from that of our algorithm in numpy. A numpy iteration takes some
10 seconds.
END
}

case "${1:---help}" in -h | --help) usage && exit ;; esac

venv=target/peers/venv
need_peers "$venv" tests/peers/requirements.txt

exec "$venv/bin/python" tests/peers/sparse.py --program target/release/phiz-fit "$@"
