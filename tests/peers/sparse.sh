#!/usr/bin/env bash
# The sparse basis beside numpy: the same problem, start and number of iterations, in turns.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

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
wanted=tests/peers/requirements.txt
if ! cmp -s "$wanted" "$venv/requirements.txt"; then
    echo "Installing the peers in $venv" >&2
    rm -rf "$venv"
    python3 -m venv "$venv"
    "$venv/bin/pip" install --quiet --requirement "$wanted"
    cp "$wanted" "$venv/requirements.txt"
fi
cargo build --quiet --release --locked --features fit --bin phiz-fit

exec "$venv/bin/python" tests/peers/sparse.py --program target/release/phiz-fit "$@"
