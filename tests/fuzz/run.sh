#!/usr/bin/env bash
# Fuzzes the blob reader: tests/fuzz/run.sh [SECONDS [EXECUTIONS]], 600 seconds unless told.
#
# libFuzzer with coverage feedback, debug assertions and overflow checks on the stable compiler:
# the flags are those of `cargo fuzz`, and RUSTC_BOOTSTRAP lets the stable compiler take them. What
# it finds is left in target/fuzz/findings; a finding is run again with target/fuzz/blob FILE.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"

seconds=${1:-600}
executions=${2:--1}
work=$PWD/../../target/fuzz
corpus=$work/corpus
mkdir -p "$corpus" "$work/findings"

host=$(rustc -vV | sed -n 's/^host: //p')
export RUSTC_BOOTSTRAP=1
export CARGO_TARGET_DIR=$work/build
export RUSTFLAGS="-Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4 \
-Cllvm-args=-sanitizer-coverage-inline-8bit-counters -Cllvm-args=-sanitizer-coverage-pc-table \
-Cllvm-args=-sanitizer-coverage-trace-compares -Ccodegen-units=1 -Zsanitizer=address --cfg fuzzing"
cargo build --release --locked --target "$host" --bin blob
cp "$CARGO_TARGET_DIR/$host/release/blob" "$work/blob"

# Seeds: both modes with nothing changed, and one change of each kind.
printf '\1' >"$corpus/sound"
for kind in 0 1 2 3 4 5; do
    printf "\\1\\$kind\\0\\0\\0\\170\\17\\0\\0\\377\\0\\0\\0\\1\\0\\0\\0" >"$corpus/kind-$kind"
done

# A blob of some kilobytes may not ask for more than 64 MB at once, nor take 5 seconds. Leaks are
# not looked for: nothing here allocates outside of Rust's own types.
cd "$work"
exec ./blob corpus -max_total_time="$seconds" -runs="$executions" -max_len=24000 -timeout=5 \
    -malloc_limit_mb=64 -rss_limit_mb=2048 -artifact_prefix=findings/ -detect_leaks=0 \
    -use_value_profile=1 -print_final_stats=1
