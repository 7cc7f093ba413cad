#!/usr/bin/env bash
# For RUSTDOC, where cargo runs the examples of the docs: the docs themselves are made as well, of the crate and of its program, into
# target/doc, and a warning of theirs is an error. They are made with what the tests were built from; `cargo doc` would check all
# that phiz depends on once more for them, which takes longer than all else that is checked and not run.
set -euo pipefail

rustdoc "$@"

is_examples=
common=()
while [ $# -gt 0 ]; do
    case $1 in
        --test) is_examples=yes ;;
        --test-run-directory | --test-args | --crate-type | --crate-name) shift ;;
        src/lib.rs) ;;
        *) common+=("$1") ;;
    esac
    shift
done
# Cargo also asks who this is.
[ -n "$is_examples" ] || exit 0
common+=(-D warnings -o target/doc)
rustdoc --crate-type rlib --crate-name phiz src/lib.rs "${common[@]}"
rustdoc --crate-type bin --crate-name phiz_fit src/bin/phiz-fit/main.rs "${common[@]}"
